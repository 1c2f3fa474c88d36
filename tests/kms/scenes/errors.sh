# shellcheck shell=sh disable=SC2086,SC2154,SC2034
# What stands in the way is said in one line, exit status 4; `caps` says the same in more words.
echo 'nobody:x:65534:65534:nobody:/tmp:/bin/sh' >>/etc/passwd
chmod 777 /tmp
# refused NAME PATTERN COMMAND...: one line on stderr that holds PATTERN, exit 4
refused() {
    name=$1 pattern=$2
    shift 2
    "$@" 2>/tmp/error >/dev/null
    status=$?
    say "note $name: $(head -1 /tmp/error | sed 's/^vitrine: error: //')"
    one_line() { [ $status = 4 ] && [ "$(wc -l </tmp/error)" = 1 ] && grep -q "^vitrine: error: .*$pattern" /tmp/error; }
    verdict "$name: exit 4 (it was $status), one line" one_line
}
# caps_says NAME PATTERN COMMAND...
caps_says() {
    name=$1 pattern=$2
    shift 2
    "$@" 2>/dev/null | grep '^card' >/tmp/caps
    say "note caps, $name: $(sed 's/^card *//' /tmp/caps)"
    verdict "caps, $name" grep -q "$pattern" /tmp/caps
}
show="$binary show $common"
caps_says "ready" "driver.*ready" "$binary" caps
chmod 600 /dev/dri/card0
refused "no permission" "ermission denied.*group" su nobody -c "$show"
caps_says "no permission" "ermission denied.*group" su nobody -c "$binary caps"
start
refused "card busy" "another program" $show --no-seat
refused "card busy, with a seat" "another program\|seat" $show
caps_says "card busy" "in use" "$binary" caps
chmod 666 /dev/dri/card0
refused "card busy, not root" "another program" su nobody -c "$show"
caps_says "card busy, not root" "another program" su nobody -c "$binary caps"
kill $pid
wait $pid
echo off >/sys/class/drm/card0-Virtual-1/status
refused "no screen" "no screen is connected" $show
caps_says "no screen" "no screen is connected" "$binary" caps
echo on >/sys/class/drm/card0-Virtual-1/status
refused "no such mode" "has no mode 123x45" $show --mode 123x45
refused "no such connector" "has no connector HDMI-A-7" $show --connector HDMI-A-7
refused "no such card" "/dev/dri/card9" $show --card 9
verdict "--connector help lists the screen" sh -c "$show --connector help | grep -q 'Virtual-1 .*connected'"
mv /usr/lib/x86_64-linux-gnu/dri /usr/lib/x86_64-linux-gnu/dri.away
refused "no driver" "Mesa" $show
caps_says "no driver" "Mesa" "$binary" caps
mv /usr/lib/x86_64-linux-gnu/dri.away /usr/lib/x86_64-linux-gnu/dri
# Whoever may open it and is the first is its master: no root is needed.
su nobody -c "$show -v --mode $mode 2>/tmp/nobody.log" &
tries=0
while ! grep -q 'at rest' /tmp/nobody.log 2>/dev/null && [ $tries -lt 1200 ]; do
    usleep 100000
    tries=$((tries + 1))
done
kms-host shot nobody
say "same nobody"
killall vitrine
wait
# make run: the screen if there is one, else a file. The head is much to draw for this guest.
cat >/tmp/vitrine-small <<EOT
#!/bin/sh
for last; do :; done
case \$1 in
show) exec $show ;;
*) exec $binary snapshot $common --size 32x24 -o \$last ;;
esac
EOT
chmod +x /tmp/vitrine-small
sh /run.sh /tmp/vitrine-small /tmp/a.png >/tmp/run.out 2>&1 &
pid=$!
tries=0
while ! pidof vitrine >/dev/null && [ $tries -lt 100 ]; do usleep 100000 && tries=$((tries + 1)); done
sleep 5
verdict "make run takes the screen" sh -c 'grep -q "trying the screen" /tmp/run.out && pidof vitrine'
killall vitrine
wait $pid
verdict "make run on a screen writes no file" [ ! -e /tmp/a.png ]
chmod 600 /dev/dri/card0
su nobody -c "sh /run.sh /tmp/vitrine-small /tmp/c.png" >/tmp/run.out 2>&1
verdict "make run without the right to the screen writes the file" [ -s /tmp/c.png ]
mv /dev/dri /dev/away
refused "no card" "no card" $show
verdict "caps without a card: in words" sh -c "$binary caps | grep -q '^cards *none: KMS knows no card'"
mkdir /tmp/b
sh /run.sh /tmp/vitrine-small /tmp/b/b.png >/tmp/run.out 2>&1
verdict "make run without a card writes the file" [ -s /tmp/b/b.png ]
