#!/bin/sh
# install-deps.sh - installs the Debian packages that building and testing needs and that are missing. As root, or
# through sudo if that needs no password; otherwise prints the one command to type and fails.
set -eu
packages="gcc g++ make git ca-certificates pkg-config libc6-dev
    libegl-dev libgles-dev libegl1 libgles2 libegl-mesa0 libgl1-mesa-dri libgbm-dev libdrm-dev
    libpng-dev zlib1g-dev libyaml-dev libcglm-dev libjansson-dev libdcmtk-dev libcmocka-dev
    clang clang-format clang-tidy cppcheck libclang-rt-14-dev libomp-14-dev dicom3tools dcmtk"
missing=
for package in $packages; do
    case $(dpkg-query -W -f '${Status}' "$package" 2>/dev/null || :) in
    "install ok installed") ;;
    *) missing="$missing $package" ;;
    esac
done
[ -n "$missing" ] || exit 0
install="apt-get update && DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends$missing"
if [ "$(id -u)" = 0 ]; then
    :
elif sudo -n true 2>/dev/null; then
    install="sudo sh -c '$install'"
else
    echo "install-deps: packages are missing. As root, type:" >&2
    echo "$install" >&2
    exit 1
fi
echo "install-deps: installing$missing" >&2
sh -c "$install"
