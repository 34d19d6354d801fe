#!/bin/bash
# Figures 3.2, 3.4, 3.6 and 3.7: pictures of the maps of chapter 3 in both rooms and of the corridor, from outside and
# from inside.
set -euo pipefail
# shellcheck source=share/experiments/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
start_experiment "$@"

worlds
corridor
for name in structured:3_2 unstructured:3_4; do
  figure=figure_${name#*:}
  name=${name%:*}
  echo "draw maps of $name"
  picture "$name" "${figure}_octomap" $room octoMap
  picture "$name" "${figure}_ghm100" $room hilbertMap creationOpts.preset=thesis
  $quick || picture "$name" "${figure}_ghm1000" $room hilbertMap creationOpts.preset=thesis creationOpts.components=1000
  picture "$name" "${figure}_ohm" $room overlappingHilbertMap creationOpts.preset=thesis
  picture "$name" "${figure}_overlapping" $room overlappingHilbertMap
  picture "$name" "${figure}_incremental" $room hilbertMap
  more=()
  $quick || more=("global Hilbert map, m = 1000=${figure}_ghm1000")
  sheet "$figure" 3 "OctoMap=${figure}_octomap" "global Hilbert map, m = 100=${figure}_ghm100" "${more[@]}" \
    "overlapping, thesis=${figure}_ohm" "overlapping, default=${figure}_overlapping" \
    "incremental, default=${figure}_incremental"
done
echo "draw maps of the corridor"
whole=-1,-1,-0.2,45,19,3.4
within=8,6,-0.2,22,13,3.4
for map in octoMap:octomap overlappingHilbertMap:overlapping hilbertMap:incremental; do
  view=(--z-max 2.5)
  picture corridor "figure_3_6_${map#*:}" $whole "${map%:*}"
  view=(--z-max 2.5 --elevation 25 --azimuth -75 --zoom 1.5)
  picture corridor "figure_3_7_${map#*:}" $within "${map%:*}"
done
for figure in figure_3_6 figure_3_7; do
  sheet $figure 3 "OctoMap=${figure}_octomap" "overlapping, default=${figure}_overlapping" \
    "incremental, default=${figure}_incremental"
done
