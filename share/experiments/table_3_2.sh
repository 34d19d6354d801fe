#!/bin/bash
# Table 3.2 and figure 3.5: Hilbert maps and OctoMap in the unstructured world. Quality, and ROC curves.
set -euo pipefail
# shellcheck source=share/experiments/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
start_experiment "$@"

worlds
maps=(-m "$octomap" -m "$ghm100")
$quick || maps+=(-m "$ghm1000")
compare unstructured table_3_2 "${maps[@]}" -m "$ohm" -m "$our_ohm" -m "$our_incremental" \
  --roc "$out/figure_3_5.png"
