# shellcheck shell=sh disable=SC2086,SC2154,SC2034
# The one scene of `make check`: the first picture, a key, the end.
keyboards
console
"$binary" caps 2>/dev/null >/tmp/caps
verdict "caps says that the card is ready" grep -q '^card .*ready' /tmp/caps
start
shot shown
say "same shown"
press right right --view 5,0
kms-host key q
gone quit 0
say "note $(tail -1 $log)"
