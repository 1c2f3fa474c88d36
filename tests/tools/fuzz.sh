#!/bin/sh
# fuzz.sh - runs every fuzz target in FUZZ_DIR over its seeds (tests/fuzz/seeds/NAME/), then, if FUZZ_SECONDS is not 0,
# goes on with inputs of its own for so long. TAP. What it finds stays in build/fuzz: `crash-…` to look at, corpus/NAME
# to start from next time. tests/fuzz/NAME.dict is the dictionary, if there is one.
. "$(dirname "$0")/tap.sh"
: "${FUZZ_DIR:?}" "${FUZZ_SECONDS:=0}"
for target in "$FUZZ_DIR"/*_fuzz; do
    [ -x "$target" ] || continue
    name=$(basename "$target" _fuzz)
    seeds=tests/fuzz/seeds/$name
    corpus=build/fuzz/corpus/$name
    mkdir -p "$corpus"
    if [ ! -d "$seeds" ]; then seeds=$tap_dir/none && mkdir -p "$seeds"; fi
    dictionary=tests/fuzz/$name.dict
    set -- "$target" -artifact_prefix=build/fuzz/ -rss_limit_mb=1024 -timeout=10
    count=$(find -L "$seeds" -type f | wc -l)
    tap_run "$name: $count seeds" "$@" -runs=0 "$seeds"
    if [ "$FUZZ_SECONDS" -gt 0 ]; then
        [ -f "$dictionary" ] && set -- "$@" "-dict=$dictionary"
        tap_run "$name: $FUZZ_SECONDS s of inputs" "$@" -max_total_time="$FUZZ_SECONDS" -print_final_stats=1 "$corpus" "$seeds"
        tap_note "$name: $(sed -n 's/^stat::number_of_executed_units: */inputs run: /p' "$tap_out")"
    fi
done
tap_done
