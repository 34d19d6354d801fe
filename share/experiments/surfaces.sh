#!/bin/bash
# Scores against a truth of surfaces, and the shape of the maps: all kinds of maps with their defaults, and OctoMap, in
# worlds that were not used to choose the defaults (surfaces.md). The mean of several seeds.
set -euo pipefail
# shellcheck source=share/experiments/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
start_experiment "$@"

seeds=(31 32 33)
$quick && seeds=(31)
maps=(-m hilbertMap -m bgkMap -m gpMap -m overlappingHilbertMap -m octoMap)

# mean_of FILE.csv...: a table of maps in Markdown, in the order of the files.
mean_of()
{
  awk -F, '
    function harmonic(p, r) { return p + r > 0 ? 2 * p * r / (p + r) : 0 }
    FNR == 1 { for (i = 1; i <= NF; ++i) column[$i] = i; next }
    !($1 in count) { order[++maps] = $1 }
    { count[$1] += 1
      sum[$1, 1] += $column["auc"]; sum[$1, 2] += $column["log_loss"]; sum[$1, 3] += $column["f1"]
      sum[$1, 4] += harmonic($column["precision_at_0.50001"], $column["recall_at_0.50001"])
      sum[$1, 5] += 100 * $column["mean_distance_m"]; sum[$1, 6] += 100 * $column["distance_95_m"]
      sum[$1, 7] += 100 * $column["surface_covered"]; sum[$1, 8] += $column["occupied_per_surface_cell"]
      sum[$1, 9] += 100 * $column["surface_called_free"]; sum[$1, 10] += 100 * $column["free_called_free"] }
    END {
      print "| map | AUC | log loss | F1, own threshold | F1, p > 0.5 | distance, mean / 95 % [cm] | covered |" \
        " occupied per surface cell | surface called free | free called free |"
      print "|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|"
      for (i = 1; i <= maps; ++i) {
        m = order[i]; n = count[m]
        printf "| %s | %.3f | %.3f | %.3f | %.3f | %.1f / %.1f | %.1f %% | %.2f | %.1f %% | %.1f %% |\n", m,
          sum[m, 1] / n, sum[m, 2] / n, sum[m, 3] / n, sum[m, 4] / n, sum[m, 5] / n, sum[m, 6] / n, sum[m, 7] / n,
          sum[m, 8] / n, sum[m, 9] / n, sum[m, 10] / n } }' "$@"
}

: > "$out/surfaces.md"
report()
{
  local title=$1
  shift
  local tables=()
  local s name
  for s in "${seeds[@]}"; do
    name=surfaces.$title.$s
    world "$name" "$@" --seed "$s" --truth-of surfaces --surface "$data/$name.surface.csv"
    echo "score the shape of maps of $title, seed $s"
    "$lamap" compare -i "$data/$name.rawlog" -c "$data/$name.ini" --truth "$data/$name.csv" \
      --surface "$data/$name.surface.csv" --thresholds 0.50001 --table "$data/$name.table.csv" "${maps[@]}" > /dev/null
    tables+=("$data/$name.table.csv")
  done
  {
    echo "**$title** (\`lamap simulate $*\`)"
    echo
    mean_of "${tables[@]}"
    echo
  } >> "$out/surfaces.md"
}
report structured structured
report unstructured unstructured
report poles poles
$quick || report dropouts structured --missing 0.1 --missing-as zero --missing-burst 5
report driving unstructured --sensor lidar16 --scans 6 --max-range 30
