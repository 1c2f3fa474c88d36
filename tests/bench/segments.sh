#!/bin/sh
# segments.sh - what the light of a ray segment costs by every method, and tables of them (segments.c).
set -eu
exec "${BENCH_DIR:-build/release/tests/bench}/segments"
