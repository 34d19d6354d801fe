#!/bin/bash
# Figure 4.2: the memory that pruning saves in a BGK map of the structured world, and its effect on states. blockDepth 3
# is the depth of the octrees in the thesis's figure.
set -euo pipefail
# shellcheck source=share/experiments/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
start_experiment "$@"

worlds
table=$out/figure_4_2.md
echo "| pruning | occupied | free | unknown | memory [MiB] |" > "$table"
echo "|---|---:|---:|---:|---:|" >> "$table"
for pruning in none lossless state; do
  echo "prune: $pruning"
  picture structured "figure_4_2_$pruning" $room bgkMap creationOpts.preset=thesis creationOpts.blockDepth=3 \
    "creationOpts.pruning=$pruning"
  "$lamap" info "$data/figure_4_2_$pruning.lamap.gz" --json > "$data/figure_4_2_$pruning.json"
  number() { grep -m1 "\"$1\":" "$data/figure_4_2_$pruning.json" | tr -dc '0-9.'; }
  echo "| $pruning | $(number occupied) | $(number free) | $(number unknown) | $(number memory) |" >> "$table"
done
sheet figure_4_2 2 "no pruning=figure_4_2_none" "cells of one state joined=figure_4_2_state"
