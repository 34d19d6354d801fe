#!/bin/bash
# Figure 4.7: station keeping. The same scan 1, 15, 30 and 60 times: how many cells are occupied in a BGK map and in a
# GP map (BCM), and pictures of both.
set -euo pipefail
# shellcheck source=share/experiments/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
start_experiment "$@"

counts=(1 15 30 60)
! $quick || counts=(1 15)
table=$out/figure_4_7.md
echo "| scans | BGK, thesis | BGK, default | GP |" > "$table"
echo "|---|---:|---:|---:|" >> "$table"
occupied() { "$lamap" info "$data/$1.lamap.gz" --json | grep -m1 '"occupied":' | tr -dc '0-9'; }
for scans in "${counts[@]}"; do
  echo "station keeping: $scans scans"
  world "station_$scans" station --seed $seed --scans "$scans"
  picture "station_$scans" "figure_4_7_bgk_thesis_$scans" $room bgkMap creationOpts.preset=thesis
  picture "station_$scans" "figure_4_7_bgk_$scans" $room bgkMap
  picture "station_$scans" "figure_4_7_gp_$scans" $room gpMap creationOpts.preset=la3dm
  echo "| $scans | $(occupied "figure_4_7_bgk_thesis_$scans") | $(occupied "figure_4_7_bgk_$scans") |" \
    "$(occupied "figure_4_7_gp_$scans") |" >> "$table"
done
sheets=()
for map in "bgk_thesis:BGK, thesis" "bgk:BGK, default" "gp:GP, nested BCM"; do
  for scans in "${counts[@]}"; do
    sheets+=("${map#*:}, $scans scans=figure_4_7_${map%%:*}_$scans")
  done
done
sheet figure_4_7 ${#counts[@]} "${sheets[@]}"
