#!/bin/sh
# fresh-debian.sh [TARGET...] - proves that the project needs nothing but git and make: sets up a bare Debian 12 with
# debootstrap, clones the last commit into it, runs `make TARGET` for each (default: run, check), and prints how long
# each took, installing packages included. Needs root, debootstrap and a Debian mirror. Logs and the picture end up in
# build/fresh/.
#
# FRESH   the folder for the system, about 3 GB (default /tmp/vitrine-fresh); removed at the end unless KEEP=1
# MIRROR  default: the first one that this machine's apt uses
set -eu
fresh=${FRESH:-/tmp/vitrine-fresh}
suite=bookworm
cd "$(dirname "$0")/../.."
project=$PWD
out=$project/build/fresh
[ $# -gt 0 ] || set -- run check

say() { echo "fresh-debian: $*"; }
die() {
    echo "fresh-debian: $*" >&2
    exit 1
}
[ "$(id -u)" = 0 ] || die "needs root, for chroot and mount"
command -v debootstrap >/dev/null || die "needs debootstrap: apt-get install debootstrap"
[ ! -e "$fresh" ] || die "$fresh exists; remove it or set FRESH"
mirror=${MIRROR:-$(cat /etc/apt/sources.list /etc/apt/sources.list.d/*.list /etc/apt/sources.list.d/*.sources 2>/dev/null |
    sed -n 's/^deb  *\(\[[^]]*\] *\)\{0,1\}\([a-z]*:[^ ]*\) .*/\2/p; s/^URIs: *\([^ ]*\).*/\1/p' | grep -m1 '/debian/*$' || :)}
: "${mirror:=http://deb.debian.org/debian}"

# The mounts live in a mount namespace of our own: they are gone when this script is, whatever happens.
if [ "${FRESH_UNSHARED:-}" != 1 ]; then
    exec unshare --mount --propagation private env FRESH_UNSHARED=1 FRESH="$fresh" MIRROR="$mirror" "$0" "$@"
fi
# Nothing is removed while anything of the host's is mounted below.
# shellcheck disable=SC2317 # called by trap
clean() {
    for dir in proc sys dev; do
        if mountpoint -q "$fresh/$dir"; then umount --recursive --lazy "$fresh/$dir"; fi
    done
    if [ "${KEEP:-0}" = 1 ]; then return; fi
    if grep -q " $fresh/" /proc/self/mounts; then
        say "still mounted, so not removed: $fresh"
    else
        rm -rf --one-file-system "$fresh"
    fi
}
trap clean EXIT
trap 'exit 1' HUP INT TERM

mkdir -p "$out"
say "debootstrap $suite from $mirror into $fresh"
debootstrap --variant=minbase --include=git,make,ca-certificates "$suite" "$fresh" "$mirror" >"$out/debootstrap.log" 2>&1 ||
    die "debootstrap failed, see $out/debootstrap.log"
# The host's way to the network: its Debian mirrors, proxy and apt's download settings.
apt-config dump Acquire | grep -vi 'IndexTargets' >"$fresh/etc/apt/apt.conf.d/00host" || :
if [ -f /etc/apt/sources.list.d/debian.sources ]; then
    cp /etc/apt/sources.list.d/debian.sources "$fresh/etc/apt/sources.list.d/"
    : >"$fresh/etc/apt/sources.list"
fi
cp -L /etc/resolv.conf /etc/hosts "$fresh/etc/"
mount -t proc proc "$fresh/proc"
mount --rbind /dev "$fresh/dev"
mount -t sysfs -o ro sys "$fresh/sys" 2>/dev/null || mount --rbind /sys "$fresh/sys"

[ -z "$(git status --porcelain)" ] || say "note: uncommitted changes are not part of the clone"
git clone -q --no-hardlinks --branch "$(git rev-parse --abbrev-ref HEAD)" "file://$project" "$fresh/root/vitrine"
say "$(git -C "$fresh/root/vitrine" log -1 --format='commit %h %s'), $(nproc) cores"
# CPU seconds that finished children have used so far: the fair figure on a machine that does other work too.
cpu() {
    times >"$out/times"
    sed -n '2{s/[ms]/ /g;p;}' "$out/times" | awk '{ printf "%d", $1 * 60 + $2 + $3 * 60 + $4 }'
    rm -f "$out/times"
}
status=0
for target; do
    begin=$(date +%s)
    cpu >"$out/cpu"
    cpu_begin=$(cat "$out/cpu")
    # shellcheck disable=SC2016
    if env -i HOME=/root TERM=dumb PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C \
        ${http_proxy:+http_proxy="$http_proxy"} ${https_proxy:+https_proxy="$https_proxy"} \
        chroot "$fresh" sh -c 'cd /root/vitrine && exec make "$1"' sh "$target" >"$out/$target.log" 2>&1; then
        word=passed
    else
        word=FAILED status=1
        tail -n 60 "$out/$target.log"
    fi
    cpu >"$out/cpu"
    say "make $target: $word in $(($(date +%s) - begin)) s, $(($(cat "$out/cpu") - cpu_begin)) s of CPU; $(tail -n 1 "$out/$target.log")"
done
rm -f "$out/cpu"
cp "$fresh/root/vitrine/build/vitrine.png" "$out/" 2>/dev/null && say "the picture: $out/vitrine.png"
(cd "$fresh/root/vitrine" && sha256sum build/release/vitrine) || :
say "$(chroot "$fresh" dpkg-query -W | wc -l) packages, $(du -sm --one-file-system "$fresh" | cut -f1) MB"
exit $status
