#!/bin/bash
# Figure 4.3: ROC curves of OctoMap, GP maps and BGK maps in both rooms.
set -euo pipefail
# shellcheck source=share/experiments/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
start_experiment "$@"

worlds
for name in structured unstructured; do
  compare "$name" "figure_4_3_$name" -m "$octomap" -m "$gpom" -m "$bgk" -m "$our_bgk" \
    --roc "$out/figure_4_3_$name.png"
done
