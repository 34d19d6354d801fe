#!/bin/bash
# Maps of logs of real planar lasers, built along icp-slam's poses from nine of ten scans and scored by the tenth: with
# rays without a return as free space, which is the default, and without (real_logs.md).
set -euo pipefail
# shellcheck source=share/experiments/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
share=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
start_experiment "$@"
need icp-slam mrpt-apps

# The log of the Telecommunication Faculty (Debian's package mrpt-common), and building 079 from the Radish collection,
# which is not a package: its place is $LAMAP_DATA/radish.
faculty="/usr/share/mrpt/datasets/2006-01ENE-21-SENA_Telecom Faculty_one_loop_only.rawlog"
fr079="${LAMAP_DATA:-}/radish/fr079.rawlog"

# poses NAME LOG: runs icp-slam, $data/NAME.simplemap, unless it exists.
poses()
{
  local name=$1 log=$2
  [[ ! -f $data/$name.simplemap ]] || return 0
  echo "poses of $name"
  local folder
  folder=$(mktemp -d)
  sed 's/^SAVE_3D_SCENE .*/SAVE_3D_SCENE = false/' "$share/ini/icp-slam/bgk.ini" > "$folder/run.ini"
  if ! (cd "$folder" && icp-slam run.ini "$log" < /dev/null > printed.txt 2>&1); then
    tail -n 5 "$folder/printed.txt" >&2
    rm -rf "$folder"
    exit 1
  fi
  mv "$folder/LOG_ICP-SLAM/_finalmap_.simplemap" "$data/$name.simplemap"
  rm -rf "$folder"
}

maps=()
for map in bgkMap gpMap hilbertMap overlappingHilbertMap; do
  maps+=(-m "$map" -m "$map (returns only): $map insertOpts.considerInvalidRangesAsFreeSpace=false")
done

# score NAME LOG: appends a table of maps, unless there is no such log.
score()
{
  local name=$1 log=$2
  if [[ ! -f $log ]]; then
    echo "${0##*/}: $name is left out: there is no $log" >&2
    return 0
  fi
  poses "$name" "$log"
  echo "score maps of $name"
  "$lamap" compare -i "$data/$name.simplemap" --held-out 10 -s creationOpts.planar=true -s insertOpts.maxRange=30 \
    --thresholds 0.7 --table "$data/$name.table.csv" "${maps[@]}" > /dev/null
  {
    echo "**$name**"
    echo
    awk -F, '
      FNR == 1 {
        for (i = 1; i <= NF; ++i) column[$i] = i
        print "| map | AUC | log loss | walls found |"
        print "|---|---:|---:|---:|"
        next
      }
      { printf "| %s | %.4f | %.4f | %.1f %% |\n", $1, $column["auc_of_returned"], $column["log_loss_of_returned"],
        100 * $column["recall_at_0.7"] }' "$data/$name.table.csv"
    echo
  } >> "$out/real_logs.md"
}

: > "$out/real_logs.md"
score faculty "$faculty"
$quick || score fr079 "$fr079"
