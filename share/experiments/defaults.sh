#!/bin/bash
# The evidence for the defaults: important options are searched on some worlds (defaults_*_search.md, best log loss
# first); then all kinds of maps with their defaults, and OctoMap, are scored on other worlds (defaults.md).
set -euo pipefail
# shellcheck source=share/experiments/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
start_experiment "$@"

chosen_on=(1 2)      # seeds for choosing
reported=(31 32 33)  # seeds for reporting
if $quick; then
  chosen_on=(1)
  reported=(31)
fi

# mean_of FILE.csv...: a table of maps with their scores averaged over the files, lowest log loss first.
mean_of()
{
  awk -F, '
    FNR == 1 { next }
    { auc[$1] += $2; loss[$1] += $4; calibration[$1] += $6; count[$1] += 1
      if (!($1 in least) || $2 < least[$1]) least[$1] = $2
      if ($6 > worst[$1]) worst[$1] = $6 }
    END { for (map in auc) printf "%s,%.4f,%.4f,%.4f,%.3f,%.3f\n", map, auc[map] / count[map], least[map],
      loss[map] / count[map], calibration[map] / count[map], worst[map] }' "$@" | sort -t, -k4,4g |
    awk -F, 'BEGIN { print "| map | AUC, mean | AUC, least | log loss, mean | calibration error, mean | worst |"
      print "|---|---:|---:|---:|---:|---:|" }
      { printf "| %s | %s | %s | %s | %s | %s |\n", $1, $2, $3, $4, $5, $6 }'
}

# score NAME OUTPUT [OPTION...]: scores maps of a world, $data/OUTPUT.table.csv.
score()
{
  local name=$1 output=$2
  shift 2
  "$lamap" compare -i "$data/$name.rawlog" -c "$data/$name.ini" --truth "$data/$name.csv" \
    --table "$data/$output.table.csv" "$@" > /dev/null
}

# search KIND VARIANT...: compares the default with a map for each variant, "key=value key=value".
search()
{
  local kind=$1
  shift
  local maps=(-m "$kind")
  local variant
  for variant in "$@"; do maps+=(-m "$kind $variant"); done
  local tables=()
  local kind_of_world s
  for kind_of_world in structured unstructured; do
    for s in "${chosen_on[@]}"; do
      world "$kind_of_world.$s" "$kind_of_world" --seed "$s"
      echo "search $kind in $kind_of_world, seed $s"
      score "$kind_of_world.$s" "$kind.$kind_of_world.$s" "${maps[@]}"
      tables+=("$data/$kind.$kind_of_world.$s.table.csv")
    done
  done
  mean_of "${tables[@]}" > "$out/defaults_${kind}_search.md"
}

i=insertOpts
c=creationOpts
search bgkMap $i.kernelSupport=0.25 $i.kernelSupport=0.3 $i.freeWeight=0.25 $i.freeWeight=1 $i.freeMargin=0.2 \
  $i.protectHits=1 $i.protectHits=0 "$i.freeWeight=1 $i.freeMargin=0.2" "$i.kernelSupport=0.3 $i.freeWeight=1" \
  $i.kernel=wendlandC2
search overlappingHilbertMap $i.fieldWeight=0.4 $i.fieldWeight=0.8 $i.fieldWeight=1 $i.hitWeight=1 $i.hitWeight=3 \
  $i.freeResolution=0.2 $i.fieldDepth=0.2 $c.outOfFieldLimit=0 $c.outOfFieldLimit=1 $c.priorPrecision=0.05 \
  $c.gamma=10 $c.gamma=20
search hilbertMap $i.hitWeight=1 $i.hitWeight=3 $i.freeResolution=0.2 $c.priorPrecision=0.05 $c.priorPrecision=0.2 \
  $c.gamma=10 $c.gamma=20 $c.latticeSpacing=0.2

# Conditions that were not used to choose the defaults: other seeds, another sensor, noise.
all=(-m bgkMap -m overlappingHilbertMap -m hilbertMap -m gpMap -m octoMap)
: > "$out/defaults.md"
report()
{
  local title=$1
  shift
  local tables=()
  local s
  for s in "${reported[@]}"; do
    world "report.$title.$s" "$@" --seed "$s"
    echo "score defaults in $title, seed $s"
    score "report.$title.$s" "report.$title.$s" "${all[@]}"
    tables+=("$data/report.$title.$s.table.csv")
  done
  {
    echo "**$title** (\`lamap simulate $*\`)"
    echo
    mean_of "${tables[@]}"
    echo
  } >> "$out/defaults.md"
}
report structured structured
report unstructured unstructured
report noisy structured --range-noise 0.03 --pose-noise 0.02,0.3
$quick || report dropouts structured --missing 0.1 --missing-as zero --missing-burst 5
$quick || report poles poles
report driving unstructured --sensor lidar16 --scans 6 --max-range 30
if ! $quick; then
  reported=(31)
  report corridor corridor
fi
