# Sourced by demo.sh, test.sh and .ci/run: the repository's root, its Debian packages, configuration and build.
# shellcheck shell=bash

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
package_list=$root/share/debian-packages.txt

say() { printf '\n== %s\n' "$*"; }

fail()
{
  printf '%s: %s\n' "$(basename "$0")" "$*" >&2
  exit 1
}

# packages_of SECTION...: prints the packages in these sections of the list, one per line.
packages_of()
{
  local section
  for section in "$@"; do
    grep -qx "\[$section\]" "$package_list" || fail "no section [$section] in $package_list"
    awk -v wanted="[$section]" '
      { sub(/#.*/, ""); gsub(/[ \t]/, "") }
      /^\[/ { inside = ($0 == wanted); next }
      inside && NF { print }' "$package_list"
  done
}

# install_packages SECTION...: installs missing packages. Uses neither apt nor the network if none is missing.
install_packages()
{
  command -v dpkg-query > /dev/null ||
    fail "this is not a Debian system (no dpkg-query); install the packages in $package_list by hand"

  local wanted package missing=() as_root=()
  wanted=$(packages_of "$@")
  while read -r package; do
    [ "$(dpkg-query -W -f='${db:Status-Status}' "$package" 2> /dev/null)" = installed ] || missing+=("$package")
  done <<< "$wanted"
  [ ${#missing[@]} -gt 0 ] || return 0

  if [ "$(id -u)" != 0 ]; then
    command -v sudo > /dev/null ||
      fail "packages are missing and there is no sudo; as root: apt-get install --no-install-recommends ${missing[*]}"
    as_root=(sudo)
  fi
  say "Installing ${#missing[@]} Debian packages: ${missing[*]}"
  as_root+=(env DEBIAN_FRONTEND=noninteractive)
  "${as_root[@]}" apt-get -q update ||
    fail "apt-get update failed: is there a network?"
  "${as_root[@]}" apt-get -q -y -o DPkg::Lock::Timeout=300 install --no-install-recommends "${missing[@]}" ||
    fail "apt-get could not install: ${missing[*]}"
}

# One compiler per core, but no more than fit into the free memory at 1.5 GB each.
build_jobs()
{
  local cores memory_kb by_memory
  cores=$(nproc)
  memory_kb=$(awk '/^MemAvailable:/ { print $2 }' /proc/meminfo 2> /dev/null)
  by_memory=$(( ${memory_kb:-0} / 1500000 ))
  [ -n "$memory_kb" ] || by_memory=$cores
  [ "$by_memory" -ge 1 ] || by_memory=1
  echo $(( by_memory < cores ? by_memory : cores ))
}

# configure_and_build PRESET [TARGET...]: builds all targets if none is named.
configure_and_build()
{
  local preset=$1 target_arguments=()
  shift
  [ $# = 0 ] || target_arguments=(--target "$@")
  say "Configuring: preset $preset"
  (cd "$root" && cmake --preset "$preset") || fail "cmake could not configure the preset $preset"
  say "Building: preset $preset${*:+, targets $*}"
  (cd "$root" && cmake --build --preset "$preset" --parallel "$(build_jobs)" "${target_arguments[@]}") ||
    fail "the build of the preset $preset failed"
}
