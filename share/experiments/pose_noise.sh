#!/bin/bash
# Uncertain poses: log loss and AUC over the standard deviation of the sensor's position, without and with the covariance
# of the poses (pose_noise.md, pose_noise.png). Means of several seeds.
set -euo pipefail
# shellcheck source=share/experiments/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
start_experiment "$@"

seeds=(31 32 33)
noises=(0 0.1 0.2 0.3)
if $quick; then
  seeds=(31)
  noises=(0 0.2)
fi
kinds=(bgkMap hilbertMap overlappingHilbertMap gpMap)
maps=()
for kind in "${kinds[@]}"; do
  for use in false true; do maps+=(-m "$kind $use: $kind insertOpts.usePoseCovariance=$use"); done
done

: > "$data/pose_noise.dat"
for noise in "${noises[@]}"; do
  for s in "${seeds[@]}"; do
    name=pose_noise.$noise.$s
    log=$data/$name.simplemap
    echo "maps of structured, seed $s, with poses that are off by $noise m"
    [ -f "$log" ] ||
      "$lamap" simulate structured --seed "$s" --pose-noise "$noise,0" -o "$log" --truth "$data/$name.csv" > /dev/null
    "$lamap" compare -i "$log" -c "$data/$name.ini" --truth "$data/$name.csv" --table "$data/$name.table.csv" \
      "${maps[@]}" > /dev/null
    awk -F, -v noise="$noise" '
      NR == 1 { for (i = 1; i <= NF; ++i) column[$i] = i; next }
      { split($1, map, " "); print noise, map[1], map[2], $column["auc"], $column["log_loss"] }' \
      "$data/$name.table.csv" >> "$data/pose_noise.dat"
  done
done

# One row per noise and map: means of AUC and log loss, without the covariance and with it.
awk '
  !($1 in known) { noise[++noises] = $1; known[$1] = 1 }
  !($2 in seen) { map[++maps] = $2; seen[$2] = 1 }
  { n[$1, $2, $3] += 1; auc[$1, $2, $3] += $4; loss[$1, $2, $3] += $5 }
  END {
    for (m = 1; m <= maps; ++m)
      for (i = 1; i <= noises; ++i) {
        key = noise[i] SUBSEP map[m] SUBSEP
        printf "%s %s %.4f %.4f %.4f %.4f\n", map[m], noise[i], auc[key "false"] / n[key "false"],
          loss[key "false"] / n[key "false"], auc[key "true"] / n[key "true"], loss[key "true"] / n[key "true"] } }' \
  "$data/pose_noise.dat" > "$data/pose_noise.mean.dat"
{
  echo "| map | deviation [m] | AUC without | with covariances | log loss without | with covariances |"
  echo "|---|---:|---:|---:|---:|---:|"
  awk '{ printf "| %s | %s | %.3f | %.3f | %.3f | %.3f |\n", $1, $2, $3, $5, $4, $6 }' "$data/pose_noise.mean.dat"
} > "$out/pose_noise.md"

{
  echo "set terminal pngcairo size 1240,480 font 'Sans,12'; set output '$out/pose_noise.png'"
  echo "set multiplot layout 1,2; set grid; set xlabel 'standard deviation of positions [m]'"
  for score in "AUC:3:5:bottom left" "log loss:4:6:top left"; do
    IFS=: read -r title without with key <<< "$score"
    echo "set ylabel '$title'; set key $key"
    lines=()
    for i in "${!kinds[@]}"; do
      rows="< awk '\$1 == \"${kinds[i]}\"' '$data/pose_noise.mean.dat'"
      rows=${rows//\'/\'\'}
      lines+=("'$rows' using 2:$without with linespoints linecolor $((i + 1)) dashtype 2 notitle")
      lines+=("'$rows' using 2:$with with linespoints linecolor $((i + 1)) title '${kinds[i]}'")
    done
    (IFS=,; echo "plot ${lines[*]}")
  done
} | gnuplot
