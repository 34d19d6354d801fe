#!/bin/bash
# Table 3.1 and figure 3.3: Hilbert maps and OctoMap in the structured world. Quality, and ROC curves.
set -euo pipefail
# shellcheck source=share/experiments/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
start_experiment "$@"

worlds
maps=(-m "$octomap" -m "$ghm100")
$quick || maps+=(-m "$ghm1000")
compare structured table_3_1 "${maps[@]}" -m "$ohm" -m "$our_ohm" -m "$our_incremental" \
  --roc "$out/figure_3_3.png"
