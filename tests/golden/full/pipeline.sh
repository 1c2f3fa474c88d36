#!/bin/sh
# Textures begun while the volume is read: tests/gl/pipeline_test lit in every case, and with every acquisition failing.
exec env VITRINE_TEST_FULL=1 "$(dirname "$VITRINE")/tests/gl/pipeline_test"
