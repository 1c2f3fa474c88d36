#!/bin/sh
# dicom.sh - every file of ../shared/data against pydicom and GDCM (tests/tools/dicom_check.py). Skipped by name
# where the data or the tools are not.
. "$(dirname "$0")/../../tools/tap.sh"
data=${VITRINE_TEST_DATA:-../shared/data}
if [ ! -d "$data/awkward" ]; then
    tap_skip "real DICOM files against other readers" "no $data/awkward"
elif ! /usr/bin/python3 -c 'import pydicom, numpy, gdcm' 2>/dev/null || ! command -v gdcmconv >/dev/null; then
    tap_skip "real DICOM files against other readers" "python3-pydicom, python3-numpy, python3-gdcm or libgdcm-tools is missing"
else
    exec /usr/bin/python3 tests/tools/dicom_check.py "$data"
fi
tap_done
