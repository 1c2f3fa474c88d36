#!/bin/sh
# Another transfer function, another preset: tests/gl/change_test in every way there is to light.
exec env VITRINE_TEST_FULL=1 "$(dirname "$VITRINE")/tests/gl/change_test"
