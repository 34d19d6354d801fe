#!/bin/bash
# A pier as a scanning sonar hears it: all kinds of maps with its beams as cones and as lines, and OctoMap, against a
# truth of surfaces (pier.md), and pictures (pier.png). Means of seeds on which nothing was chosen.
set -euo pipefail
# shellcheck source=share/experiments/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
start_experiment "$@"

seeds=(61 62)
sweeps=12
cones=insertOpts.beamWidth=observation
lines=insertOpts.beamWidth=none
reach="insertOpts.kernelSupport=0.3 insertOpts.freeMargin=0.2"
# Without the models, of which there is one per ping, an overlapping map takes memory in proportion to space. Processes on
# all free cells of a cone would be slow.
cells=creationOpts.keepModels=false
sparse=insertOpts.freeResolution=0.4
maps=(-m "CBGKMap (cones): bgkMap $cones $reach" -m "CBGKMap (lines): bgkMap $lines $reach"
  -m "CHilbertMap (cones): hilbertMap $cones" -m "CHilbertMap (lines): hilbertMap $lines"
  -m "COverlappingHilbertMap (cones): overlappingHilbertMap $cones $cells"
  -m "COverlappingHilbertMap (lines): overlappingHilbertMap $lines $cells"
  -m "CGPMap (cones): gpMap $cones $sparse" -m "CGPMap (lines): gpMap $lines $sparse" -m "COctoMap: octoMap")
if $quick; then
  seeds=(61)
  sweeps=2
  maps=(-m "CBGKMap (cones): bgkMap $cones $reach" -m "CBGKMap (lines): bgkMap $lines $reach" -m "COctoMap: octoMap")
fi

# mean_of FILE.csv...: a table of maps in Markdown, in the order of the files.
mean_of()
{
  awk -F, '
    FNR == 1 { for (i = 1; i <= NF; ++i) column[$i] = i; next }
    !($1 in count) { order[++maps] = $1 }
    { count[$1] += 1
      sum[$1, 1] += $column["auc"]; sum[$1, 2] += $column["log_loss"]; sum[$1, 3] += $column["precision_at_0.7"]
      sum[$1, 4] += $column["recall_at_0.7"]; sum[$1, 5] += 100 * $column["surface_covered"]
      sum[$1, 6] += 100 * $column["free_called_free"]; sum[$1, 7] += $column["ms_per_scan"]
      sum[$1, 8] += $column["memory_bytes"] / 1048576 }
    END {
      print "| map | AUC | log loss | precision / recall at 0.7 | covered | free called free | ms per observation | MiB |"
      print "|---|---:|---:|---:|---:|---:|---:|---:|"
      for (i = 1; i <= maps; ++i) {
        m = order[i]; n = count[m]
        printf "| %s | %.3f | %.3f | %.2f / %.2f | %.1f %% | %.1f %% | %.1f | %.1f |\n", m, sum[m, 1] / n,
          sum[m, 2] / n, sum[m, 3] / n, sum[m, 4] / n, sum[m, 5] / n, sum[m, 6] / n, sum[m, 7] / n,
          sum[m, 8] / n } }' "$@"
}

tables=()
for s in "${seeds[@]}"; do
  name=pier.$s.$sweeps
  world "$name" pier --seed "$s" --scans $sweeps --truth-of surfaces --surface "$data/$name.surface.csv"
  echo "compare maps of pier, seed $s"
  "$lamap" compare -i "$data/$name.rawlog" -c "$data/$name.ini" --truth "$data/$name.csv" \
    --surface "$data/$name.surface.csv" --table "$data/$name.table.csv" "${maps[@]}" > /dev/null
  tables+=("$data/$name.table.csv")
done
mean_of "${tables[@]}" > "$out/pier.md"

# draw PICTURE SETTING...: a slice through a BGK map of the first world, in mid water.
draw()
{
  local picture=$1
  shift
  local settings=()
  local setting
  for setting in "$@"; do settings+=(-s "$setting"); done
  local name=pier.${seeds[0]}.$sweeps
  "$lamap" build -i "$data/$name.rawlog" -c "$data/$name.ini" -m bgkMap "${settings[@]}" \
    -o "$data/$picture.lamap.gz" > /dev/null
  "$lamap" render "$data/$picture.lamap.gz" -o "$out/$picture.png" --view slice --z 2.55 --size 800x560 \
    --box -1,-1,0,25,15,5
}
# shellcheck disable=SC2086  # several settings
draw pier_cones $cones $reach
# shellcheck disable=SC2086
draw pier_lines $lines $reach
sheet pier 2 "CBGKMap, beams as cones=pier_cones" "CBGKMap, beams as lines=pier_lines"
