#!/bin/bash
# Runs all experiments one after the other and prints how long each took.
set -euo pipefail
# shellcheck source=share/experiments/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
start_experiment "$@"

experiments=(figure_3_1 table_3_1 table_3_2 table_3_3 table_4_1 figure_4_2 figure_4_3 figure_4_7 figure_4_8
  figures_3_2_to_3_7 figures_4_4_to_4_6 few_beams defaults surfaces real_logs pier pose_noise)
options=()
$quick && options=(--quick)
number=0
for experiment in "${experiments[@]}"; do
  number=$((number + 1))
  echo "== $number of ${#experiments[@]}: $experiment"
  started=$SECONDS
  folder=$out
  # It writes other files besides its result.
  [[ $experiment != figure_3_1 ]] || folder=$out/figure_3_1
  "$here/$experiment.sh" "$folder" "${options[@]}"
  echo "   $((SECONDS - started)) s"
done
echo "results are in $out"
