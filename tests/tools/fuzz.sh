#!/bin/sh
# fuzz.sh - FUZZ_SECONDS=0: every fuzz target in FUZZ_DIR, linked with tests/fuzz/replay.c, reads its seeds
# (tests/fuzz/seeds/NAME/). Otherwise the targets are libFuzzer's, and go on with inputs of their own for so long. TAP.
# What they find stays in build/fuzz: `crash-…` to look at, corpus/NAME to start from next time. tests/fuzz/NAME.dict is
# the dictionary, if there is one.
. "$(dirname "$0")/tap.sh"
: "${FUZZ_DIR:?}" "${FUZZ_SECONDS:=0}"
for target in "$FUZZ_DIR"/*_fuzz; do
    [ -x "$target" ] || continue
    name=$(basename "$target" _fuzz)
    seeds=tests/fuzz/seeds/$name
    if [ ! -d "$seeds" ]; then seeds=$tap_dir/none && mkdir -p "$seeds"; fi
    count=$(find -L "$seeds" -type f | wc -l)
    if [ "$FUZZ_SECONDS" -eq 0 ]; then
        # As libFuzzer's limit of memory: whatever asks for more ends the program.
        tap_run "$name: $count seeds" env "ASAN_OPTIONS=${ASAN_OPTIONS-}:allocator_may_return_null=0:max_allocation_size_mb=1024:hard_rss_limit_mb=1024" "$target" "$seeds"
        continue
    fi
    corpus=build/fuzz/corpus/$name
    mkdir -p "$corpus"
    dictionary=tests/fuzz/$name.dict
    set -- "$target" -artifact_prefix=build/fuzz/ -rss_limit_mb=1024 -timeout=10
    tap_run "$name: $count seeds" "$@" -runs=0 "$seeds"
    [ -f "$dictionary" ] && set -- "$@" "-dict=$dictionary"
    tap_run "$name: $FUZZ_SECONDS s of inputs" "$@" -max_total_time="$FUZZ_SECONDS" -print_final_stats=1 "$corpus" "$seeds"
    tap_note "$name: $(sed -n 's/^stat::number_of_executed_units: */inputs run: /p' "$tap_out")"
done
tap_done
