#!/bin/bash
# localize_often.sh LAMAP [RUNS [KIND]]: runs stock pf-localization with our map alone, 5 times by default.
# KIND is bgk (the default), gp, hilbert or overlapping: share/ini/pf-localization/KIND.ini. Each run draws other particles.
# Counts the runs that end within 0.3 m of the robot; fails if fewer than 4 of 5 do.
set -euo pipefail
lamap=$(realpath "$1")
runs=${2:-5}
kind=${3:-bgk}
config=$(realpath "$(dirname "${BASH_SOURCE[0]}")/../../share/ini/pf-localization/$kind.ini")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"

near=0
for run in $(seq "$runs"); do
  "$lamap" run -- pf-localization "$config" /usr/share/mrpt/datasets/localization_demo.rawlog </dev/null >printed.txt 2>&1 ||
    { cat printed.txt; exit 1; }
  rm -rf LOG_*
  end=$(grep -o 'PDF estimation: ([-0-9.]*,[-0-9.]*' printed.txt | tail -n 1 | tr -d '(' | cut -d' ' -f3)
  distance=$(awk -F, '{ printf "%.3f", sqrt(($1 - 15.9)^2 + ($2 + 10.0)^2) }' <<<"$end")
  echo "run $run ends at ($end), $distance m from (15.9, -10.0)"
  if awk -v d="$distance" 'BEGIN { exit !(d < 0.3) }'; then near=$((near + 1)); fi
done
echo "$near of $runs runs end within 0.3 m"
((5 * near >= 4 * runs))
