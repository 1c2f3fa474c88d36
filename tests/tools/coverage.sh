#!/bin/sh
# coverage.sh DIR - lines reached, by file of ours, from the .gcda files under DIR (build/cov), least covered first;
# the annotated sources lie in DIR/gcov.
set -eu
dir=$(cd "$1" && pwd)
rm -rf "$dir/gcov"
mkdir -p "$dir/gcov"
root=$PWD
cd "$dir/gcov"
find "$dir/src" -name '*.gcda' -exec gcov --preserve-paths --relative-only --source-prefix "$root" {} + |
    awk '/^File / { gsub(/\047/, "", $2); file = $2 }
         /^Lines executed:/ && file ~ /^src\// {
             split($0, part, /[:% ]+/)
             if (part[6] + 0 > lines[file]) { lines[file] = part[6] + 0; percent[file] = part[3] + 0 }
         }
         END {
             for (file in lines) {
                 printf "%6.1f %%  %5d lines  %s\n", percent[file], lines[file], file
                 total += lines[file]; hit += lines[file] * percent[file] / 100
             }
             if (total) printf "%6.1f %%  %5d lines  in all\n", 100 * hit / total, total
         }' | sort -n
