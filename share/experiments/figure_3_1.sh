#!/bin/bash
# Figure 3.1 of the thesis: an overlapping Hilbert map of a two-dimensional world at 5 cm after scans 1, 7, 14 and 20 of
# 20, with the thesis's preset and with our defaults.
#
#   figure_3_1.sh OUTDIR [--quick]
#
# Writes to OUTDIR figure_3_1.png, scores.txt, the log and the truth, and for each preset and number of scans the map
# and its own picture (thesis_7.lamap.gz, thesis_7.png, ...). --quick omits the markers of the training points.
set -euo pipefail
# shellcheck source=share/experiments/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
start_experiment "$@"

scans=20
shown=(1 7 14 20)
presets=(thesis default)
cell=0.05  # [m]
simulate=("$lamap" simulate flatland --seed 1 --max-range 6 --range-noise 0.01 --resolution "$cell")
map=(-s creationOpts.planar=true -s creationOpts.resolution="$cell" -s insertOpts.maxRange=6)

# scans_of FILE TUM: simulates a log with the poses in TUM.
scans_of()
{
  "${simulate[@]}" --trajectory "$2" --scans "$(wc -l < "$2")" -o "$1" > /dev/null
}

# training_points N: the thinned-out training points of scan N alone, for the markers. A BGK map whose kernel reaches
# only one cell holds exactly the cells of hits and of free samples.
training_points()
{
  local points=("${map[@]}" -m bgkMap -s insertOpts.kernelSupport="$cell" -s insertOpts.protectHits=1
    -s insertOpts.freeMargin=0.25 -s insertOpts.freeResolution=0.5 -s insertOpts.rayDecimation=6)
  sed -n "$1p" poses.txt > pose.txt
  scans_of scan.rawlog pose.txt
  "$lamap" build -i scan.rawlog "${points[@]}" -o scan.lamap.gz > /dev/null
  "$lamap" export scan.lamap.gz -o "points_$1.csv" > /dev/null
  "$lamap" build -i scan.rawlog "${points[@]}" -s insertOpts.considerInvalidRangesAsFreeSpace=false -o scan.lamap.gz \
    > /dev/null
  "$lamap" export scan.lamap.gz -o scan.csv > /dev/null
  # Free cells that come only from rays without a return have their own marker.
  awk -F, 'FNR == 1 { next } NR == FNR { seen[$1 "," $2]; next }
    { print $1, $2, ($4 > 0.5 ? "hit" : ($1 "," $2) in seen ? "free" : "assumed") }' scan.csv "points_$1.csv" \
    > "points_$1.txt"
  rm scan.* "points_$1.csv"
}

echo "$scans scans of flatland ..."
"${simulate[@]}" --scans $scans -o log.rawlog --truth truth.csv > /dev/null
grep -v '^#' log.tum > poses.txt

: > scores.txt
for n in "${shown[@]}"; do
  head -n "$n" poses.txt > first.txt
  scans_of first.rawlog first.txt
  [[ $quick == true ]] || training_points "$n"
  for preset in "${presets[@]}"; do
    name=${preset}_$n
    echo "map after scan $n, preset $preset ..."
    "$lamap" build -i first.rawlog -m overlappingHilbertMap -s creationOpts.preset="$preset" "${map[@]}" \
      -o "$name.lamap.gz" > /dev/null
    "$lamap" render "$name.lamap.gz" --view slice --color prob -o "$name.png" > /dev/null
    "$lamap" export "$name.lamap.gz" -o "$name.csv" > /dev/null
  done
done
rm -f first.* pose.txt

# Scores come from the maps.
for preset in "${presets[@]}"; do
  maps=("${shown[@]/#/${preset}_}")
  "$lamap" eval "${maps[@]/%/.lamap.gz}" --truth truth.csv
done > scores.txt

# grid_of CSV: its probabilities as a matrix over the world and its walls, rows along y; 0.5 where the map has no
# evidence.
read -r left bottom columns rows < <(awk -F, -v cell=$cell '
  NR > 1 { x = $1 / cell; y = $2 / cell
    if (NR == 2 || x < x0) x0 = x; if (NR == 2 || x > x1) x1 = x; if (NR == 2 || y < y0) y0 = y; if (y > y1) y1 = y }
  END { margin = 4; printf "%.0f %.0f %.0f %.0f\n", x0 - 0.5 - margin, y0 - 0.5 - margin, x1 - x0 + 1 + 2 * margin,
    y1 - y0 + 1 + 2 * margin }' truth.csv)
grid_of()
{
  awk -F, -v cell=$cell -v left="$left" -v bottom="$bottom" -v columns="$columns" -v rows="$rows" '
    NR > 1 { prob[sprintf("%.0f,%.0f", $1 / cell - 0.5 - left, $2 / cell - 0.5 - bottom)] = $4 }
    END { for (y = 0; y < rows; ++y) for (x = 0; x < columns; ++x)
      printf "%s%s", (x "," y) in prob ? prob[x "," y] : 0.5, x + 1 < columns ? " " : "\n" }' "$1"
}

# marks N: the markers drawn over a panel.
marks()
{
  if [[ $quick == false ]]; then
    echo ", '< grep assumed points_$1.txt || echo NaN NaN' using 1:2 with points pt 7 ps 0.25 lc rgb '#1a9641' notitle \\"
    echo ", '< grep free points_$1.txt' using 1:2 with points pt 7 ps 0.25 lc rgb '#2b6cff' notitle \\"
    echo ", '< grep hit points_$1.txt' using 1:2 with points pt 7 ps 0.35 lc rgb '#e31a1c' notitle \\"
  fi
  echo ", 'poses.txt' every ::0::$(($1 - 1)) using 2:3 with points pt 6 ps 1 lw 1.5 lc rgb 'black' notitle \\"
  echo ", 'poses.txt' every ::$(($1 - 1))::$(($1 - 1)) using 2:3 with points pt 7 ps 1.6 lc rgb 'magenta' notitle"
}

declare -A titles=([thesis]="preset thesis" [default]="default settings")
{
  echo "set terminal pngcairo size 1800,840 font 'Sans,13'; set output 'figure_3_1.tmp.png'"
  echo "set multiplot; unset tics; unset key; unset colorbox; set cbrange [0:1]"
  echo "set palette defined (0 'white', 1 'black'); set border lc rgb '#808080'"
  echo "left = $left*$cell; bottom = $bottom*$cell"
  echo "set xrange [left:left + $columns*$cell]; set yrange [bottom:bottom + $rows*$cell]"
  for row in 0 1; do
    preset=${presets[row]}
    for column in 0 1 2 3; do
      n=${shown[column]}
      grid_of "${preset}_$n.csv" > "${preset}_$n.grid"
      echo "set lmargin at screen $column*0.23 + 0.03; set rmargin at screen $column*0.23 + 0.25"
      echo "set bmargin at screen 0.53 - $row*0.465; set tmargin at screen 0.945 - $row*0.465"
      ((row == 1)) || echo "set title 'after scan $n' offset 0,-0.6"
      ((row == 0)) || echo "unset title"
      if ((column == 0)); then echo "set ylabel \"${titles[$preset]}\" offset 1"; else echo "unset ylabel"; fi
      if ((row == 1 && column == 3)); then
        echo "set label 1 'the robot now' at screen 0.09,0.025 center tc rgb 'magenta'"
        echo "set label 2 'the robot before' at screen 0.22,0.025 center tc rgb 'black'"
        if [[ $quick == false ]]; then
          echo "set label 3 'hits of the last scan' at screen 0.37,0.025 center tc rgb '#e31a1c'"
          echo "set label 4 'its free points' at screen 0.53,0.025 center tc rgb '#2b6cff'"
          echo "set label 5 'free points of rays without a return' at screen 0.74,0.025 center tc rgb '#1a9641'"
        fi
        echo "set colorbox user origin 0.956,0.065 size 0.012,0.88; set cbtics 0.5"
        echo "set label 6 'P(occupied)' at screen 0.962,0.965 center"
      fi
      echo "plot '${preset}_$n.grid' matrix using (left + (\$1 + 0.5)*$cell):(bottom + (\$2 + 0.5)*$cell):3 with image \\"
      marks "$n"
    done
  done
  echo "unset multiplot"
} > figure_3_1.gp
gnuplot figure_3_1.gp
mv figure_3_1.tmp.png figure_3_1.png
rm -f ./*.grid ./*_*.csv points_*.txt figure_3_1.gp
echo "$out/figure_3_1.png, scores.txt"
