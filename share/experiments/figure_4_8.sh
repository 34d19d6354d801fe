#!/bin/bash
# Figure 4.8: free space by the distance of points to lines, beside OctoMap, GP maps and BGK maps that sample points along
# the rays, in both rooms. Quality, and pictures.
set -euo pipefail
# shellcheck source=share/experiments/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
start_experiment "$@"

worlds
for name in structured unstructured; do
  compare "$name" "figure_4_8_$name" -m octoMap -m "$gpom" -m "$bgk" -m "$bgk insertOpts.freeSpace=line" \
    -m "bgkMap insertOpts.freeSpace=line"
  picture "$name" "figure_4_8_${name}_line" $room bgkMap creationOpts.preset=thesis insertOpts.freeSpace=line
done
