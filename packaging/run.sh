#!/bin/sh
# run.sh VITRINE PNG - what `make run` does: the built-in head full screen where a card is free for it, else as a picture in PNG.
# The screen is left by q there, or ctrl-C here.
set -u
vitrine=$1 png=$2
set -- phantom:head --preset bone-and-skin --view 35,15 --zoom 1.5
if ls /dev/dri/card* >/dev/null 2>&1; then
    echo "trying the screen: q there or ctrl-C here ends it"
    "$vitrine" show "$@"
    status=$?
    [ $status = 4 ] || exit $status # 4: no screen for us
    echo "so the head goes into a picture instead"
fi
"$vitrine" snapshot "$@" -o "$png" || exit
echo "wrote $png"
echo "look at it with any viewer (xdg-open $png), or copy it to a machine with a screen;"
echo "your own data: $vitrine snapshot FOLDER -o OUT.png --preset NAME; $vitrine presets list shows the names"
