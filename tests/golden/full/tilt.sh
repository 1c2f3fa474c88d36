#!/bin/sh
# tilt.sh - a tilted gantry through every path (tests/tools/tilt_check.py). Skipped by name without numpy.
. "$(dirname "$0")/../../tools/tap.sh"
data=${VITRINE_TEST_DATA:-../shared/data}
if ! /usr/bin/python3 -c 'import numpy' 2>/dev/null; then
    tap_skip "a tilted gantry through every path" "python3-numpy is missing"
elif [ -d "$data/dcm_qa_ct/GE_tilt_unequal" ]; then
    exec /usr/bin/python3 tests/tools/tilt_check.py "$data"
else
    exec /usr/bin/python3 tests/tools/tilt_check.py
fi
tap_done
