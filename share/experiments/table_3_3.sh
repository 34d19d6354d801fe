#!/bin/bash
# Table 3.3: time per scan of Hilbert maps in the two rooms and in the corridor, with one thread: insertion and, for a
# global map, its training (by the first query).
set -euo pipefail
# shellcheck source=share/experiments/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
start_experiment "$@"

worlds
corridor
for name in structured unstructured corridor; do
  maps=(-m "$octomap" -m "$ghm100")
  # The corridor's 2.3 million training points with 1,000 features each do not fit into memory.
  $quick || [[ $name == corridor ]] || maps+=(-m "$ghm1000")
  compare "$name" "table_3_3_$name" "${maps[@]}" -m "$ohm" -m "$our_ohm" -m "$our_incremental"
done
