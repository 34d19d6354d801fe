#!/bin/bash
# Figures 4.4, 4.5 and 4.6: pictures of the maps of chapter 4 in both rooms and of the corridor.
set -euo pipefail
# shellcheck source=share/experiments/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
start_experiment "$@"

worlds
corridor
for name in structured:4_4 unstructured:4_5; do
  figure=figure_${name#*:}
  name=${name%:*}
  echo "draw maps of $name"
  picture "$name" "${figure}_octomap" $room octoMap
  picture "$name" "${figure}_gp" $room gpMap creationOpts.preset=la3dm
  picture "$name" "${figure}_bgk_thesis" $room bgkMap creationOpts.preset=thesis
  picture "$name" "${figure}_bgk" $room bgkMap
  sheet "$figure" 2 "OctoMap=${figure}_octomap" "GP, nested BCM=${figure}_gp" "BGK, thesis=${figure}_bgk_thesis" \
    "BGK, default=${figure}_bgk"
done
echo "draw a map of the corridor"
view=(--z-max 2.5)
picture corridor_dense figure_4_6 -1,-1,-0.2,45,19,3.4 bgkMap
