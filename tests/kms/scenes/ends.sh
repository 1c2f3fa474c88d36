# shellcheck shell=sh disable=SC2086,SC2154,SC2034
# Atomic, legacy, and without a seat manager; ended by q, SIGTERM and a crash. The text console comes back each time.
keyboards
console
start
verdict "atomic mode setting is used" grep -q 'show: on .* atomic' $log
shot atomic
say "same atomic"
printf '\033[1;1Hprinted while a picture is shown\n' >/dev/tty1
press right right --view 5,0
kms-host key q
printf '\033[1;1H\033[2Kthe text console\n' >/dev/tty1
gone quit 0
say "note $(tail -1 $log)"
start --no-atomic
verdict "legacy mode setting is used" grep -q 'show: on .* legacy' $log
shot legacy
say "same legacy"
kill -TERM $pid
gone term 143
start --no-seat
verdict "no seat manager is used" grep -q 'show: on .* seat: none' $log
shot bare
say "same bare"
kill -SEGV $pid
gone segv 139
