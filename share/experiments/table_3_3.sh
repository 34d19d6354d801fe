#!/bin/bash
# Table 3.3: how long Hilbert maps take for a scan, in the two rooms and in the corridor, with one thread. Insertion,
# and for a global map its training (the first question to it).
set -euo pipefail
# shellcheck source=share/experiments/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
start_experiment "$@"

worlds
corridor
for name in structured unstructured corridor; do
  maps=(-m "$octomap" -m "$ghm100")
  # The corridor's 2.3 million training points with 1,000 features each are more than fits into memory.
  $quick || [[ $name == corridor ]] || maps+=(-m "$ghm1000")
  compare "$name" "table_3_3_$name" "${maps[@]}" -m "$ohm" -m "$our_ohm" -m "$our_incremental"
done
