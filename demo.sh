#!/bin/bash
# Builds mrpt-lamap and maps real data with it: the logs and simple maps of the Debian package mrpt-common. Leaves maps
# and pictures in build/demo/. Needs Debian 12 and git; installs the packages that are missing (as root, or with sudo).
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/.ci/common.sh"

install_packages build run
configure_and_build release lamap lamap_mrpt

lamap=$root/build/bin/lamap
out=$root/build/demo
datasets=$(dirname "$(dpkg -L mrpt-common | grep '/datasets/malaga-cs-fac-building\.simplemap\.gz$')")
mkdir -p "$out"
cd "$out"

# picture NAME: NAME.lamap.gz from above and in 3D.
picture()
{
  "$lamap" render "$1.lamap.gz" -o "$1_above.png"
  "$lamap" render "$1.lamap.gz" -o "$1_3d.png" --view 3d
}

# A laser sees a plane: one layer of cells, at the height of the sensor.
say "malaga-cs-fac-building: a simple map of a faculty building, by lamap build"
"$lamap" build -i "$datasets/malaga-cs-fac-building.simplemap.gz" -m bgkMap -s creationOpts.planar=true \
  -o malaga-cs-fac-building.lamap.gz
picture malaga-cs-fac-building

say "localization_demo: a simple map of an office, by lamap build"
"$lamap" build -i "$datasets/localization_demo.simplemap.gz" -m bgkMap -s creationOpts.planar=true \
  -o localization_demo.lamap.gz
picture localization_demo

say "SENA: a log of a laser and odometry, by MRPT's own icp-slam with the plug-in loaded"
"$lamap" run -- icp-slam "$root/share/icp-slam_bgk.ini" \
  "$datasets/2006-01ENE-21-SENA_Telecom Faculty_one_loop_only.rawlog"
