#!/bin/sh
# install-deps.sh [build|check] - installs the Debian packages that are missing, of those that the binary needs (build)
# or that the tests need too (check, the default). As root, or through sudo if that asks for no password; otherwise
# prints the one command to type and fails.
set -eu
build="gcc g++ libc6-dev pkg-config
    libegl-dev libgles-dev libegl-mesa0 libgl1-mesa-dri
    libpng-dev zlib1g-dev libyaml-dev libjansson-dev libdcmtk-dev libopenjp2-7-dev libzip-dev libexpat1-dev
    libdrm-dev libgbm-dev libseat-dev libinput-dev libxkbcommon-dev
    libcairo2-dev fonts-dejavu-core"
check="git libcmocka-dev clang clang-format clang-tidy cppcheck shellcheck libomp-dev libclang-rt-14-dev dicom3tools dcmtk"

case ${1:-check} in
build) wanted=$build ;;
check) wanted="$build $check" ;;
*)
    echo "usage: install-deps.sh [build|check]" >&2
    exit 2
    ;;
esac
if ! command -v dpkg-query >/dev/null; then
    echo "install-deps: this is no Debian, so nothing is installed; going on with what is here." >&2
    # shellcheck disable=SC2086
    echo "install-deps: the packages would be:" $wanted >&2
    exit 0
fi
# shellcheck disable=SC2086
installed=$(dpkg-query -W -f '${db:Status-Status} ${Package}\n' $wanted 2>/dev/null | sed -n 's/^installed //p')
missing=
for package in $wanted; do
    case "
$installed
" in
    *"
$package
"*) ;;
    *) missing="$missing $package" ;;
    esac
done
[ -n "$missing" ] || exit 0

command="apt-get -q update && apt-get install -y --no-install-recommends$missing"
if [ "$(id -u)" = 0 ]; then
    as_root=
elif sudo -n true 2>/dev/null; then
    as_root="sudo -n"
else
    echo "install-deps: packages are missing. As root, type:" >&2
    echo "    $command" >&2
    exit 1
fi
echo "install-deps: installing$missing" >&2
log=$(mktemp)
trap 'rm -f "$log"' EXIT
# apt speaks in hundreds of lines; they are shown only if it fails.
if ! $as_root sh -c "export DEBIAN_FRONTEND=noninteractive
    apt-get -q update && apt-get -q -o Dpkg::Use-Pty=0 install -y --no-install-recommends$missing" >"$log" 2>&1; then
    cat "$log" >&2
    echo "install-deps: failed; the command was: $command" >&2
    exit 1
fi
echo "install-deps: done" >&2
