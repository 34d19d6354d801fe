#!/bin/bash
# Table 4.1: time per scan of BGK maps, GP maps (nested BCM) and OctoMap, with one thread; the corridor with all of its
# rays.
set -euo pipefail
# shellcheck source=share/experiments/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
start_experiment "$@"

worlds
corridor
for name in structured unstructured corridor_dense; do
  compare "$name" "table_4_1_${name%_dense}" -m "$octomap" -m "$gpom" -m "$bgk" -m "$our_bgk"
done
