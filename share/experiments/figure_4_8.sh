#!/bin/bash
# Figure 4.8: free space from the distance of cells to lines, compared with OctoMap, GP maps and BGK maps that sample
# points along the rays, in both rooms. Quality, and pictures.
set -euo pipefail
# shellcheck source=share/experiments/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
start_experiment "$@"

worlds
sheets=()
for name in structured unstructured; do
  compare "$name" "figure_4_8_$name" -m "$octomap" -m "$gpom" -m "$bgk" -m "BGK lines, thesis: ${bgk#*: } insertOpts.freeSpace=line" \
    -m "BGK lines, default: bgkMap insertOpts.freeSpace=line"
  # The thesis's lines end at their hits and outweigh them, so with its settings no cell reaches the threshold.
  picture "$name" "figure_4_8_${name}_octomap" $room octoMap
  picture "$name" "figure_4_8_${name}_gp" $room gpMap creationOpts.preset=la3dm
  picture "$name" "figure_4_8_${name}_samples" $room bgkMap creationOpts.preset=thesis
  picture "$name" "figure_4_8_${name}_line" $room bgkMap insertOpts.freeSpace=line
  sheets+=("OctoMap=figure_4_8_${name}_octomap" "GP=figure_4_8_${name}_gp"
    "BGK, thesis=figure_4_8_${name}_samples" "BGK, lines=figure_4_8_${name}_line")
done
sheet figure_4_8 4 "${sheets[@]}"
