# shellcheck shell=sh disable=SC2086,SC2154,SC2034
# The one scene of `make check`, by a kiosk file: the first picture, a key, the end. Pictures while it moves are as
# small as that file's `interactive_ms` asks for (without it 1/8 of the sides, under emulation); at rest they are snapshot's.
keyboards
console
"$binary" caps 2>/dev/null >/tmp/caps
verdict "caps says that the card is ready" grep -q '^card .*ready' /tmp/caps
kiosk=/tmp/kiosk.yaml
printf 'input: %s\nset: %s\nmode: %s\ninteractive_ms: 1000\n' "${common%% *}" "${common##* }" "$mode" >$kiosk
start
moving=$(sed -n 's|.*a picture of 1/4 of each side takes \(.*\) ms; moving: 1/\(.*\)|\1 \2|p' $log)
say "note interactive_ms 1000: 1/4 of the sides takes ${moving% *} ms; moving: 1/${moving#* }"
# The largest that fits: time goes with the pixels. What is printed is rounded.
verdict "pictures while moving are as small as interactive_ms asks for, and no smaller" awk -v m="$moving" \
    'BEGIN { split(m, v, " "); n = v[2]; q = 16 * v[1] / 1000; exit !(n && (n - 1) * (n - 1) < q + 0.01 && (n == 8 || q - 0.01 <= n * n)) }'
shot shown
say "same shown"
press right right --view 5,0
kms-host key q
gone quit 0
say "note $(tail -1 $log)"
