#!/bin/bash
# Localization with few beams, the main use of learned maps: builds maps from all beams of a laser and from every 4th,
# 10th and 30th of them, and runs stock pf-localization in each map. Counts how many of 20 runs end within 0.5 m, and
# within 1 m, of the robot, in MRPT's localization_demo and in a simulated corridor.
set -euo pipefail
# shellcheck source=share/experiments/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
share=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
start_experiment "$@"
need pf-localization mrpt-apps

runs=20
fewer=(1 4 10 30)
if $quick; then
  runs=1
  fewer=(30)
fi
office=/usr/share/mrpt/datasets/localization_demo
if [[ ! -f $office.rawlog ]]; then
  echo "${0##*/}: needs $office.rawlog (Debian's package mrpt-common)" >&2
  exit 77
fi

# Mapping: a drive through the corridor. Localization: part of another drive, with noisy odometry.
if [[ ! -f $data/drive.rawlog ]]; then
  echo "simulate corridor"
  "$lamap" simulate corridor --seed $seed --sensor planar-laser --trajectory driving --scans 120 --range-noise 0.02 \
    -o "$data/mapping.simplemap" > /dev/null
  "$lamap" simulate corridor --seed $seed --sensor planar-laser --trajectory driving --scans 30 --range-noise 0.02 \
    --odometry-noise 0.05 -o "$data/drive.rawlog" > /dev/null
fi

# Localization uses only some of the beams. COctoMap would take most of the time, because it unpacks all beams for every
# particle before it skips any. So every map is given only every 5th beam, and its own decimation is divided by 5.
weighed=5
for log in "$office.rawlog" "$data/drive.rawlog"; do
  "$lamap" thin -i "$log" -o "$data/$(basename "$log" .rawlog).weighed.rawlog" --keep-every $weighed > /dev/null
done

# The configuration of our kinds of maps is share/ini/pf-localization/KIND.ini; that of MRPT's own maps is here.
map_sections()
{
  case $1 in
    grid)
      # As in MRPT's own pf-localization/localization_demo.ini.
      cat << INI
[MetricMap]
occupancyGrid_count = 1
[MetricMap_occupancyGrid_00_creationOpts]
resolution = 0.06
[MetricMap_occupancyGrid_00_insertOpts]
mapAltitude                       = 0
useMapAltitude                    = 0
maxDistanceInsertion              = 15
maxOccupancyUpdateCertainty       = 0.55
considerInvalidRangesAsFreeSpace  = 1
minLaserScanNoiseStd              = 0.001
[MetricMap_occupancyGrid_00_likelihoodOpts]
likelihoodMethod          = 4
LF_decimation             = $((20 / weighed))
LF_stdHit                 = 0.20
LF_maxCorrsDistance       = 0.30
LF_zHit                   = 0.95
LF_zRandom                = 0.05
LF_maxRange               = 80
LF_alternateAverageMethod = 0
INI
      ;;
    octomap)
      cat << INI
[MetricMap]
octoMap_count = 1
[MetricMap_octoMap_00_creationOpts]
resolution = 0.10
[MetricMap_octoMap_00_insertOpts]
maxrange = 30
[MetricMap_octoMap_00_likelihoodOpts]
decimation = $((20 / weighed))
INI
      ;;
    *)
      sed -n '/^\[MetricMap\]/,$p' "$share/ini/pf-localization/$1.ini" |
        awk -v weighed=$weighed '/^decimation/ { $3 = $3 / weighed } { print }'
      ;;
  esac
}

# config KIND LOG MAP AREA: prints the configuration.
config()
{
  local kind=$1 log=$2 map=$3
  local x0 x1 y0 y1
  read -r x0 x1 y0 y1 <<< "$4"
  sed '/^\[MetricMap\]/,$d' "$share/ini/pf-localization/bgk.ini" |
    sed -e "s|^map_file .*|map_file = $map|; s|^rawlog_file .*|rawlog_file = $log|" \
      -e "s|^init_PDF_min_x .*|init_PDF_min_x = $x0|; s|^init_PDF_max_x .*|init_PDF_max_x = $x1|" \
      -e "s|^init_PDF_min_y .*|init_PDF_min_y = $y0|; s|^init_PDF_max_y .*|init_PDF_max_y = $y1|" \
      -e "s|^particles_count .*|particles_count = 20000|; s|^KLD_maxSampleSize .*|KLD_maxSampleSize = 20000|"
  map_sections "$kind"
}

# localize CONFIG GOAL: prints how far from GOAL ("x,y") a run ends, in metres. A run without a result ends the
# experiment.
localize()
{
  local folder last
  folder=$(mktemp -d)
  cp "$1" "$folder/run.ini"
  (cd "$folder" && "$lamap" run --no-check -- pf-localization run.ini < /dev/null > printed.txt 2>&1) || true
  last=$(grep -o 'PDF estimation: ([-0-9.e]*,[-0-9.e]*' "$folder/printed.txt" | tail -n 1 | sed 's/.*(//')
  if [[ -z $last ]]; then
    echo "few_beams.sh: pf-localization gave no pose with $1:" >&2
    tail -n 5 "$folder/printed.txt" >&2
    rm -rf "$folder"
    return 255  # makes xargs stop
  fi
  rm -rf "$folder"
  awk -v last="$last" -v goal="$2" 'BEGIN { split(last, is, ","); split(goal, at, ",")
    print sqrt((is[1] - at[1])^2 + (is[2] - at[2])^2) }'
}
export -f localize
export lamap

# experiment NAME MAPPING LOG AREA GOAL: writes one table.
experiment()
{
  local name=$1 mapping=$2 log=$3 area=$4 goal=$5
  local table=$out/few_beams_$name.md
  local kinds=(grid octomap bgk overlapping hilbert)
  ! $quick || kinds=(grid bgk)
  {
    printf '| rays kept |%s\n' "$(printf ' %s |' "${kinds[@]}")"
    printf '|---|%s\n' "$(printf -- '---:|%.0s' "${kinds[@]}")"
  } > "$table"
  local every
  for every in "${fewer[@]}"; do
    echo "$name: one ray in $every"
    "$lamap" thin -i "$mapping" -o "$data/$name.$every.simplemap.gz" --keep-every "$every" > /dev/null
    local row="| 1/$every |"
    local kind
    for kind in "${kinds[@]}"; do
      config "$kind" "$log" "$data/$name.$every.simplemap.gz" "$area" > "$data/$name.$every.$kind.ini"
      local found
      found=$(seq "$runs" | xargs -P "$(nproc)" -I{} bash -c "localize '$data/$name.$every.$kind.ini' '$goal'" |
        awk '{ half += $1 < 0.5; one += $1 < 1 } END { print half + 0 " / " one + 0 }')
      echo "  $kind: within 0.5 m / 1 m in $found of $runs"
      row+=" $found |"
    done
    echo "$row" >> "$table"
  done
}

experiment office "$office.simplemap.gz" "$data/localization_demo.weighed.rawlog" "-10 10 -15 -5" 15.9,-10.0
goal=$(grep -v '^#' "$data/drive.tum" | tail -n 1 | awk '{ print $2 "," $3 }')
experiment corridor "$data/mapping.simplemap" "$data/drive.weighed.rawlog" "0 44 0 18" "$goal"
