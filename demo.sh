#!/bin/bash
# Builds mrpt-lamap and maps real data with it: the logs and simple maps of the Debian package mrpt-common. Writes maps
# and pictures to build/demo/. Needs Debian 12 and git; installs missing packages (as root, or with sudo).
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/.ci/common.sh"

install_packages build run
configure_and_build release lamap lamap_mrpt lamap_python

lamap=$root/build/bin/lamap
out=$root/build/demo
datasets=$(dirname "$(dpkg -L mrpt-common | grep '/datasets/malaga-cs-fac-building\.simplemap\.gz$')")
mkdir -p "$out"
cd "$out"

# pictures_of NAME: prints the map's contents and draws it from above and in 3D.
pictures_of()
{
  "$lamap" info "$1.lamap.gz" | sed -n '/^observed cells/,/^extent z/p'
  "$lamap" render "$1.lamap.gz" -o "$1_above.png"
  "$lamap" render "$1.lamap.gz" --view 3d --show-free -o "$1_3d.png"
}

# build_from_simplemap NAME [OPTION...]: builds a map from MRPT's observations with poses. A 2D laser sees a plane: one
# layer of cells. Rays are truncated, because this laser sees up to 80 m, through doors and windows.
build_from_simplemap()
{
  local name=$1
  shift
  "$lamap" build -i "$datasets/$name.simplemap.gz" -m bgkMap -s creationOpts.planar=true "$@" -o "$name.lamap.gz"
  pictures_of "$name"
}

say "malaga-cs-fac-building: scans with poses of a university building, by lamap build"
build_from_simplemap malaga-cs-fac-building -s insertOpts.maxRange=30

say "localization_demo: scans with poses of a corridor and its rooms, by lamap build"
build_from_simplemap localization_demo -s insertOpts.maxRange=10 -s creationOpts.resolution=0.05

say "SENA: a log of laser and odometry, by MRPT's own icp-slam with the plug-in loaded"
"$lamap" run -- icp-slam "$root/share/ini/icp-slam/bgk.ini" \
  "$datasets/2006-01ENE-21-SENA_Telecom Faculty_one_loop_only.rawlog" > icp-slam.log 2>&1 ||
  { tail -n 30 icp-slam.log >&2; fail "icp-slam failed; its output is in $out/icp-slam.log"; }
mv -f LOG_ICP-SLAM/_finalmaps_.txt_lamap__CBGKMap_00.lamap.gz SENA_icp-slam.lamap.gz
pictures_of SENA_icp-slam

say "Done. In $out:"
for map in malaga-cs-fac-building localization_demo SENA_icp-slam; do
  printf '  %-36s the map\n' "$map.lamap.gz"
  printf '  %-36s seen from above\n' "${map}_above.png"
  printf '  %-36s in 3D\n' "${map}_3d.png"
done
