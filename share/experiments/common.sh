# Sourced by the experiments: start_experiment "$@" sets
#   lamap  the tool: $LAMAP, or the one in this repository's build folder
#   out    the folder for results, created if missing; it becomes the current folder
#   data   its subfolder for logs, truths and maps, which experiments share
#   quick  true with --quick: a smaller version of the experiment
# shellcheck shell=bash disable=SC2034  # what is set here is read by those who source this

start_experiment()
{
  local usage="usage: ${0##*/} OUTDIR [--quick]"
  out=
  quick=false
  while (($# > 0)); do
    case $1 in
      -h | --help)
        echo "$usage"
        exit 0
        ;;
      --quick) quick=true ;;
      -*)
        echo "${0##*/}: no such option: $1; $usage" >&2
        exit 2
        ;;
      *)
        if [[ -n $out ]]; then
          echo "${0##*/}: only one folder, not also $1; $usage" >&2
          exit 2
        fi
        out=$1
        ;;
    esac
    shift
  done
  if [[ -z $out ]]; then
    echo "$usage" >&2
    exit 2
  fi
  lamap=${LAMAP:-$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)/build/bin/lamap}
  lamap=$(command -v "$lamap" || echo "$lamap")
  if [[ ! -x $lamap ]]; then
    echo "${0##*/}: there is no $lamap: run ./demo.sh, build the target lamap, or set LAMAP to the tool" >&2
    exit 1
  fi
  lamap=$(realpath "$lamap")
  need gnuplot gnuplot-nox
  mkdir -p "$out"
  cd "$out" || exit 1
  out=$PWD
  # Scripts share data, but not between quick and full runs.
  data=$out/data
  ! $quick || data=$out/data-quick
  mkdir -p "$data"
}

# need PROGRAM PACKAGE
need()
{
  command -v "$1" > /dev/null && return
  echo "${0##*/}: needs the program $1 (Debian's package $2)" >&2
  exit 77  # ctest then counts the test as skipped
}

# The seed of the worlds that are shown; the defaults were chosen on other seeds (see defaults.sh).
seed=21

# world NAME [OPTION...]: simulates a world into $data/NAME.{rawlog,csv,ini}, unless it exists.
world()
{
  local name=$1
  shift
  [ -f "$data/$name.csv" ] && return
  echo "simulate $name"
  "$lamap" simulate "$@" -o "$data/$name.rawlog" --truth "$data/$name.csv" > /dev/null
}

worlds()
{
  local scans=12
  $quick && scans=6
  world structured structured --seed $seed --scans $scans
  world unstructured unstructured --seed $seed --scans $scans
}

# About as many rays of the corridor as the thesis kept, 5,000 per scan: every 17th of 89,000.
corridor()
{
  local scans=66
  $quick && scans=6
  world corridor_dense corridor --seed $seed --scans $scans
  [ -f "$data/corridor.rawlog" ] ||
    "$lamap" thin -i "$data/corridor_dense.rawlog" -o "$data/corridor.rawlog" --keep-every 17 > /dev/null
  cp -f "$data/corridor_dense.csv" "$data/corridor.csv"
  cp -f "$data/corridor_dense.ini" "$data/corridor.ini"
}

# compare WORLD OUTPUT [OPTION...]: one table of maps of a world, OUTPUT.md and OUTPUT.json.
compare()
{
  local name=$1 output=$2
  shift 2
  echo "compare maps of $name"
  "$lamap" compare -i "$data/$name.rawlog" -c "$data/$name.ini" --truth "$data/$name.csv" --threads 1 \
    --table "$out/$output.md" --json "$@" > "$out/$output.json"
}

# picture WORLD NAME BOX MAP [SETTING...]: builds a map of a world and draws it in 3D, $out/NAME.png.
picture()
{
  local name=$1 picture=$2 box=$3 map=$4
  shift 4
  local settings=()
  local setting
  for setting in "$@"; do settings+=(-s "$setting"); done
  "$lamap" build -i "$data/$name.rawlog" -c "$data/$name.ini" -m "$map" "${settings[@]}" \
    -o "$data/$picture.lamap.gz" > /dev/null
  "$lamap" render "$data/$picture.lamap.gz" -o "$out/$picture.png" --view 3d --size 800x560 --box "$box" \
    "${view[@]}"
}

# Options of `lamap render` in picture(); a script may change them.
view=()
room=-0.5,-0.5,-0.2,10.5,7.5,2.2

# The maps of the thesis, with its settings.
ohm="OHM, thesis: overlappingHilbertMap creationOpts.preset=thesis"
ghm100="GHM-100: hilbertMap creationOpts.preset=thesis"
ghm1000="GHM-1000: hilbertMap creationOpts.preset=thesis creationOpts.components=1000"
bgk="BGK, thesis: bgkMap creationOpts.preset=thesis"
gpom="GPOM (LA3DM): gpMap creationOpts.preset=la3dm"
# This library's defaults.
our_ohm="OHM, default: overlappingHilbertMap"
our_incremental="incremental, default: hilbertMap"
our_bgk="BGK, default: bgkMap"
octomap="OctoMap: octoMap"

# sheet FILE COLUMNS TITLE=PICTURE...: combines pictures in $out side by side in $out/FILE.png.
sheet()
{
  local file=$1 columns=$2
  shift 2
  local rows=$((($# + columns - 1) / columns))
  {
    echo "set terminal pngcairo size $((columns * 620)),$((rows * 450)) font 'Sans,13'; set output '$file.tmp.png'"
    echo "unset tics; unset border; unset key; set size ratio -1; set lmargin 0; set rmargin 0; set bmargin 0"
    echo "set tmargin 1.5; set multiplot layout $rows,$columns"
    local each
    for each in "$@"; do
      echo "set title \"${each%=*}\" noenhanced offset 0,-0.7"
      echo "plot '${each##*=}.png' binary filetype=png with rgbimage"
    done
    echo "unset multiplot"
  } | gnuplot
  mv "$file.tmp.png" "$file.png"
}
