#!/bin/bash
# mk-vkms.sh OUT.ko - the kernel's virtual display (vkms: vertical blanks, CRCs, writeback) for the kernel that run-kms.sh boots;
# Debian ships none. Built from Debian's own source and header packages, downloaded by apt and unpacked under $KMS_CACHE, never
# installed; once per kernel package. Needs gcc-12 make xz-utils libelf1. Exit 2, with one line, where it cannot be had.
set -eu
out=$(realpath -m "$1")
cache=${KMS_CACHE:-$HOME/.cache/run-kms}
die() {
    echo "run-kms: vkms: $*" >&2
    exit 2
}
mkdir -p "$cache"
cache=$(cd "$cache" && pwd)
deb=$(find "$cache" -maxdepth 1 -name 'linux-image-[0-9]*-amd64_*.deb' ! -name '*cloud*' ! -name '*rt-amd64*' | sort -V | tail -1)
[ -n "$deb" ] || die "no kernel in $cache yet: run-kms.sh fetches one"
name=$(basename "$deb")
release=${name#linux-image-} release=${release%%_*} # 6.1.0-56-amd64
version=${name#*_} version=${version%_*}            # 6.1.192-2
built=$cache/vkms-$release-$version.ko
if [ ! -e "$built" ]; then
    for tool in gcc-12 make xz apt-get dpkg-deb; do command -v $tool >/dev/null || die "$tool is missing"; done
    work=$cache/vkms-$release
    rm -rf "$work"
    mkdir -p "$work"
    cd "$work"
    for package in "linux-source-6.1=$version" "linux-headers-$release=$version" \
        "linux-headers-${release%-amd64}-common=$version" "linux-kbuild-6.1=$version"; do
        apt-get -q download "$package" >apt.log 2>&1 || die "apt has no ${package} (apt-get update, then try again)"
    done
    for package in linux-headers-*.deb linux-kbuild-*.deb; do dpkg-deb -x "$package" root; done
    headers=$work/root/usr/src/linux-headers-$release
    sed -i "s|^include /usr/src/|include $work/root/usr/src/|" "$headers/Makefile"
    dpkg-deb --fsys-tarfile linux-source-6.1_*.deb | tar -xO ./usr/src/linux-source-6.1.tar.xz | xz -dc |
        tar -x --wildcards 'linux-source-6.1/drivers/gpu/drm/vkms/*'
    source=$work/linux-source-6.1/drivers/gpu/drm/vkms
    # 6.1.y checks which encoders may run together, and its vkms does not declare them: every writeback would be EINVAL.
    grep -q possible_clones "$source/vkms_output.c" ||
        sed -i 's|^\t\t\tDRM_ERROR("Failed to init writeback connector\\n");|&\n\t\telse\n\t\t\tencoder->possible_clones = output->wb_connector.encoder.possible_clones =\n\t\t\t\tdrm_encoder_mask(encoder) \| drm_encoder_mask(\&output->wb_connector.encoder);|' "$source/vkms_output.c"
    make -C "$headers" M="$source" CONFIG_DRM_VKMS=m modules -j2 >build.log 2>&1 || die "$(tail -1 build.log) ($work/build.log)"
    strip -g "$source/vkms.ko" -o "$built.part"
    mv "$built.part" "$built"
    cd "$cache"
    rm -rf "$work"
fi
cp "$built" "$out"
