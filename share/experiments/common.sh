# Sourced by the experiments: start_experiment "$@" sets
#   lamap  the tool: $LAMAP, or the one in this repository's build folder
#   out    the folder for results, made if it is not there; the script goes on in it
#   quick  true with --quick: a smaller run of the same
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
          echo "${0##*/}: one folder only, not also $1; $usage" >&2
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
  if [[ ! -x $lamap ]]; then
    echo "${0##*/}: there is no $lamap: run ./demo.sh or build the target lamap, or name the tool in LAMAP" >&2
    exit 1
  fi
  lamap=$(realpath "$lamap")
  need gnuplot gnuplot-nox
  mkdir -p "$out"
  cd "$out" || exit 1
  out=$PWD
}

# need PROGRAM PACKAGE
need()
{
  command -v "$1" > /dev/null && return
  echo "${0##*/}: needs the program $1 (Debian's package $2)" >&2
  exit 1
}
