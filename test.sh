#!/bin/bash
# Builds mrpt-lamap and runs all of its tests. Needs Debian 12 and git; installs missing packages (as root, or with
# sudo). Arguments are passed to ctest, e.g. `./test.sh -R Kernel`. LAMAP_PRESET=ci makes warnings errors.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/.ci/common.sh"

install_packages build run test
preset=${LAMAP_PRESET:-release}
configure_and_build "$preset"

say "Testing"
log=$root/build/ctest.log
status=0
(cd "$root" && ctest --preset "$preset" --parallel "$(nproc)" "$@") 2>&1 | tee "$log" || status=$?

[ -n "${LAMAP_DATA:-}" ] || echo "LAMAP_DATA names no folder with measured data: the tests that need it were skipped."
# Repeat ctest's summary after its lists of skipped and failed tests.
grep -E '^[0-9]+% tests passed' "$log" || echo "ctest ran no tests"
exit "$status"
