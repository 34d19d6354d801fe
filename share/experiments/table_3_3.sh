#!/bin/bash
# Table 3.3: how long Hilbert maps take for a scan, in the two rooms and in the corridor, with one thread. Insertion,
# and for a global map its training (the first question to it).
set -euo pipefail
# shellcheck source=share/experiments/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
start_experiment "$@"

worlds
corridor
maps=(-m octoMap -m "$ghm100")
$quick || maps+=(-m "$ghm1000")
for name in structured unstructured corridor; do
  compare "$name" "table_3_3_$name" "${maps[@]}" -m "$ohm" -m overlappingHilbertMap -m hilbertMap
done
