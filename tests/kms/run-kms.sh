#!/bin/bash
# run-kms.sh - run a DRM/KMS program in a throw-away QEMU guest, no GPU and no desktop needed.
#
#   run-kms.sh [options] -- 'shell command line for the guest'
#
#   -b FILE        host ELF binary (name in PATH or a path); goes to the same place in the guest
#                  with every library that ldd names. May be repeated.
#   -f SRC[:DST]   any other host file or folder (DST: absolute guest path). May be repeated.
#   -d DISPLAY     bochs (default) | vga | virtio | cirrus | qxl | vmware | none
#   -g WxH         preferred mode of bochs/vga/virtio (default 1024x768)
#   -H N           number of virtio outputs (default 1)
#   -M MOD         one more kernel module by name, or the path of a .ko.  May be repeated.
#   -r cpio|9p     guest root: cpio = initramfs with what -b/-f name (default);
#                  9p = the host's / read-only under a tmpfs overlay (needs no -b/-f)
#   -m MIB         guest memory (default 1024)
#   -c N           guest processors (default 2)
#   -a ACCEL       auto (default) | kvm | tcg | icount (tcg, one processor, whose clock counts its instructions, one
#                  a nanosecond: the guest's time does not depend on the host's load)
#   -o DIR         output folder (default ./kms-out): console.log run.log NAME.png
#   -k DEB         kernel .deb (default: newest linux-image-*-amd64_*.deb in $KMS_CACHE,
#                  else fetched there by apt-get download)
#   -t SEC         time limit for the whole guest (default 300)
#   -n             no Mesa files in the cpio (they are added by default)
#   -x 'ARGS'      more arguments for QEMU
#   -A 'ARGS'      more arguments for the kernel
#
# In the guest the command runs as root with /dev/dri, /dev/input, sysfs, debugfs and:
#   kms-host shot NAME [HEAD]        screendump to NAME.png, returns when it is written
#   kms-host key QCODE [QCODE..]     press and release a chord, e.g. "key ctrl c"
#   kms-host move X Y                absolute pointer, 0..32767 each
#   kms-host rel DX DY               relative pointer (give -x '-device virtio-mouse-pci')
#   kms-host button left|right|middle|wheel-up|wheel-down 1|0
#   kms-host qmp 'JSON'              any QMP command; prints QEMU's answer
# A program may instead print a line  ##SHOT NAME##  on its (unpiped, line-buffered) stdout and then
# hold the picture for about 1 s: same, but nothing waits for it.
#
# Exit: the guest command's own; 124 time limit; 125 the guest never reported; 2 usage.
# Needs: qemu-system-x86 busybox-static cpio kmod (xz-utils: quicker boot, 4 s less under TCG).
# Words are split on purpose, empty values are meant, `a && b || c` has a b that succeeds, and traps call what looks unused.
# shellcheck disable=SC1007,SC2015,SC2086,SC2317
set -u -o pipefail
die() { echo "run-kms: $*" >&2; exit 2; }
disp=bochs geo=1024x768 heads=1 root=cpio mem=1024 cpus=2 accel=auto out=./kms-out deb= limit=300 mesa=1 extra= append=
bins=() files=() mods=()
while getopts b:f:d:g:H:M:r:m:c:a:o:k:t:nx:A: o; do case $o in
  b) bins+=("$OPTARG");; f) files+=("$OPTARG");; d) disp=$OPTARG;; g) geo=$OPTARG;; H) heads=$OPTARG;;
  M) mods+=("$OPTARG");; r) root=$OPTARG;; m) mem=$OPTARG;; c) cpus=$OPTARG;; a) accel=$OPTARG;;
  o) out=$OPTARG;; k) deb=$OPTARG;; t) limit=$OPTARG;; n) mesa=0;; x) extra=$OPTARG;; A) append=$OPTARG;; *) exit 2;;
esac; done
shift $((OPTIND-1)); [ $# -ge 1 ] || die "no guest command (see the head of $0)"
cmd="$*"
for t in qemu-system-x86_64 cpio modprobe depmod; do command -v $t >/dev/null || die "$t is missing"; done
bb=$(command -v busybox) && ! ldd "$bb" >/dev/null 2>&1 || die "busybox-static is missing"
mkdir -p "$out"; out=$(cd "$out" && pwd); rm -f "$out"/{console.log,run.log,*.png}
W=$(mktemp -d); QPID=
cleanup() { [ -n "$QPID" ] && kill "$QPID" 2>/dev/null; rm -rf "$W"; }
trap cleanup EXIT; trap 'exit 130' INT TERM
T0=$(date +%s%N); say() { printf '%7.2f %s\n' "$(( ($(date +%s%N)-T0)/10000000 ))e-2" "$*" | tee -a "$out/run.log" >&2; }

# ---- kernel: unpacked once per package version
cache=${KMS_CACHE:-$HOME/.cache/run-kms}; mkdir -p "$cache"; cache=$(cd "$cache" && pwd)
newest() { find "$cache" -maxdepth 1 -name 'linux-image-[0-9]*-amd64_*.deb' ! -name '*cloud*' ! -name '*rt-amd64*' | sort -V | tail -1; }
[ -n "$deb" ] || deb=$(newest)
if [ -z "$deb" ]; then
  p=$(apt-cache depends linux-image-amd64 | awk '/Depends: linux-image-/{print $2; exit}')
  [ -n "$p" ] && (cd "$cache" && apt-get -q download "$p" >/dev/null 2>&1) || die "no kernel package: apt-get update, then try again"
  deb=$(newest)
fi
K=$cache/$(basename "$deb" .deb)
if [ ! -e "$K/.ok" ]; then
  rm -rf "$K"; mkdir -p "$K"; dpkg-deb -x "$deb" "$K" || die "cannot unpack $deb"
  v=$(basename "$K"/lib/modules/*); depmod -b "$K" "$v"
  # The ELF inside vmlinuz boots by PVH: no decompression inside the (slow, emulated) guest.
  off=$(LC_ALL=C grep -aboP '\xFD7zXZ\x00' "$K/boot/vmlinuz-$v" | head -1 | cut -d: -f1)
  if [ -n "$off" ] && command -v xz >/dev/null; then
    tail -c +$((off+1)) "$K/boot/vmlinuz-$v" | xz -dcq --single-stream >"$K/vmlinux" 2>/dev/null
    [ "$(head -c4 "$K/vmlinux" | tail -c3)" = ELF ] || rm -f "$K/vmlinux"
  fi
  touch "$K/.ok"
fi
ver=$(basename "$K"/lib/modules/*); kernel=$K/vmlinux; [ -e "$kernel" ] || kernel=$K/boot/vmlinuz-$ver

# ---- accelerator: /dev/kvm alone proves nothing (nested or PVM hosts have one that boots no stock kernel)
if [ "$accel" = auto ]; then
  accel=tcg; [ -w /dev/kvm ] && grep -qwE 'vmx|svm' /proc/cpuinfo && accel=kvm
fi
# Under emulation a processor without AVX: with `max`, QEMU 7.2 makes holes in what llvmpipe draws.
case $accel in
  kvm) acc="-accel kvm -cpu host";;
  icount) acc="-accel tcg,thread=single,tb-size=512 -cpu Nehalem -icount shift=0" cpus=1;;
  *) acc="-accel tcg,thread=multi,tb-size=512 -cpu Nehalem";;
esac

# ---- display
w=${geo%x*} h=${geo#*x}
case $disp in
  bochs)  dev="-vga none -device bochs-display,id=gpu0,xres=$w,yres=$h,vgamem=64M" m=bochs;;
  vga)    dev="-vga none -device VGA,id=gpu0,xres=$w,yres=$h,vgamem_mb=64" m=bochs;;
  virtio) dev="-vga none -device virtio-gpu-pci,id=gpu0,xres=$w,yres=$h,max_outputs=$heads" m=virtio-gpu;;
  cirrus) dev="-vga none -device cirrus-vga,id=gpu0" m=cirrus;;
  qxl)    dev="-vga none -device qxl-vga,id=gpu0" m=qxl;;
  vmware) dev="-vga none -device vmware-svga,id=gpu0" m=vmwgfx;;
  none)   dev="-vga none" m=;;
  *) die "unknown display $disp";;
esac

# ---- initramfs
R=$W/root; mkdir -p "$R"/usr/{bin,sbin,lib,lib64} "$R"/{proc,sys,dev,run,tmp,root,etc,ko}
for d in bin sbin lib lib64; do ln -s usr/$d "$R/$d"; done
cp "$bb" "$R/usr/bin/busybox"
put() { # SRC DST: one file, symlinks followed
  mkdir -p "$R$(dirname "$2")"; [ -e "$R$2" ] || cp -rL --preserve=mode "$1" "$R$2"; }
elf() { # FILE [DST]: a binary or library and all it links
  put "$1" "${2:-$1}"; ldd "$1" 2>/dev/null | grep -oE '(=> )?/[^ ]+' | sed 's/^=> //' | while read -r l; do put "$l" "$l"; done; }
if [ "$root" = cpio ]; then
  for b in "${bins[@]}"; do p=$(command -v "$b") || die "no such binary: $b"; p=$(realpath -s "$p"); elf "$p"; done
  for f in "${files[@]}"; do s=${f%%:*}; t=${f#*:}; elf "$(realpath -s "$s")" "$([ "$t" = "$f" ] && realpath -s "$s" || echo "$t")"; done
  if [ $mesa = 1 ]; then
    L=/usr/lib/x86_64-linux-gnu
    for l in $L/libEGL_mesa.so.0 $L/dri/kms_swrast_dri.so $L/libEGL.so.1 $L/libgbm.so.1 $L/libGLESv2.so.2 $L/libdrm.so.2; do [ -e $l ] && elf $l; done
    ln -sf kms_swrast_dri.so "$R$L/dri/swrast_dri.so"
    for l in /usr/share/glvnd/egl_vendor.d/50_mesa.json /usr/share/drirc.d/00-mesa-defaults.conf; do [ -e $l ] && put $l $l; done
  fi
fi
for x in virtio_pci virtio_input evdev uinput psmouse 9pnet_virtio 9p overlay $m "${mods[@]}"; do
  [ "$root" = 9p ] || case $x in 9p*|overlay) continue;; esac
  case $x in
    *.ko) for n in $(modinfo -F depends "$x" | tr , ' '); do modprobe -d "$K" -S "$ver" --ignore-install --show-depends "$n"; done; echo "insmod $(realpath "$x")";;
    *) modprobe -d "$K" -S "$ver" --ignore-install --show-depends "$x" || echo "run-kms: no module $x" >&2;;
  esac
done | awk '$1=="insmod" && !s[$2]++ {print $2}' >"$W/mods"
i=100; while read -r p; do cp "$p" "$R/ko/$i-$(basename "$p")"; i=$((i+1)); done <"$W/mods"
printf '%s\n' "$cmd" >"$R/cmd"; echo "root:x:0:0:root:/root:/bin/sh" >"$R/etc/passwd"
cat >"$R/usr/bin/kms-host" <<'G'
#!/bin/sh
exec 9<>/dev/ttyS1; flock 9 2>/dev/null; echo "@$*" >&9
IFS= read -r a <&9; case $a in "OK"*) [ "$a" = OK ] || echo "${a#OK }";; *) echo "kms-host: $a" >&2; exit 1;; esac
G
cat >"$R/init" <<'G'
#!/usr/bin/busybox sh
/usr/bin/busybox --install -s /usr/bin 2>/dev/null; export PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin HOME=/root
mount -t proc proc /proc; mount -t sysfs sys /sys; mount -t devtmpfs dev /dev
mkdir -p /dev/pts /dev/shm; mount -t devpts devpts /dev/pts; mount -t tmpfs tmp /dev/shm
mount -t debugfs debug /sys/kernel/debug; mount -t tmpfs run /run
stty -F /dev/ttyS1 raw -echo; exec 8<>/dev/ttyS1
for k in /ko/*; do insmod $k || echo "insmod $k failed"; done
mkdir -p /run/user/0; export XDG_RUNTIME_DIR=/run/user/0; chmod 700 /run/user/0
export LIBGL_ALWAYS_SOFTWARE=1
if grep -q kmsroot=9p /proc/cmdline; then
  mkdir -p /host /rw /new; mount -t tmpfs rw /rw; mkdir /rw/u /rw/w
  mount -t 9p -o trans=virtio,version=9p2000.L,msize=262144,cache=loose,ro host /host &&
  mount -t overlay -o lowerdir=/host,upperdir=/rw/u,workdir=/rw/w root /new || { echo "@EXIT 125" >&8; poweroff -f; }
  for d in proc sys dev run; do mkdir -p /new/$d; mount -o rbind /$d /new/$d; done
  mkdir -p /new/usr/local/bin; cp /cmd /new/.kms-cmd; cp /usr/bin/kms-host /new/usr/local/bin/kms-host
  cp /usr/bin/busybox /new/usr/local/bin/busybox
  set -- chroot /new /bin/sh /.kms-cmd
else set -- sh /cmd; fi
echo "@START $(cut -d' ' -f1 /proc/uptime)" >&8
"$@" </dev/null 8>&-; rc=$?
echo "guest command: exit $rc"; echo "@EXIT $rc" >&8
poweroff -f
G
chmod +x "$R/init" "$R/usr/bin/kms-host"
(cd "$R" && find . | cpio -o -H newc --quiet) >"$W/initrd"
say "initramfs $(( $(stat -c %s "$W/initrd") / 1024 )) KiB; kernel $ver; $accel; display $disp; root $root"

# ---- QEMU, driven by fifos
mkfifo "$W"/{qmp,ctl}.{in,out}; : >"$out/console.log"
exec {QI}<>"$W/qmp.in" {QO}<>"$W/qmp.out" {CI}<>"$W/ctl.in" {CO}<>"$W/ctl.out" {CON}<"$out/console.log"
fs=; [ "$root" = 9p ] && fs="-fsdev local,id=host,path=/,security_model=none,readonly=on,multidevs=remap -device virtio-9p-pci,fsdev=host,mount_tag=host"
# shellcheck disable=SC2086
qemu-system-x86_64 -name run-kms -nodefaults -no-user-config -no-reboot -display none $acc -m "$mem" -smp "$cpus" \
  -kernel "$kernel" -initrd "$W/initrd" -append "console=ttyS0 quiet panic=-1 random.trust_cpu=on kmsroot=$root $append" \
  -serial "file:$out/console.log" -chardev "pipe,id=ctl,path=$W/ctl" -serial chardev:ctl \
  -chardev "pipe,id=qmp,path=$W/qmp" -mon chardev=qmp,mode=control \
  $dev -device virtio-keyboard-pci -device virtio-tablet-pci $fs $extra </dev/null >>"$out/run.log" 2>&1 &
QPID=$!
qmp() { # JSON without the closing brace -> answer in $ans
  local l; printf '%s\n' "$1" >&$QI; ans=
  local part= end=$((SECONDS+30))
  while [ $SECONDS -lt $end ]; do
    if IFS= read -r -t 0.5 l <&$QO; then l=$part$l part=
      case $l in *'"return"'*|*'"error"'*) ans=${l%$'\r'}; break;; esac
    else part+=$l; kill -0 "$QPID" 2>/dev/null || break; fi
  done
  case $ans in *'"error"'*|'') return 1;; esac; }
ev() { qmp "{\"execute\":\"input-send-event\",\"arguments\":{\"events\":[$1]}}"; }
shot() { local a=; case $disp in none) ans="no display"; return 1;; esac
  [ -n "${2:-}" ] && a=",\"device\":\"gpu0\",\"head\":$2"
  qmp "{\"execute\":\"screendump\",\"arguments\":{\"filename\":\"$out/$1.png\",\"format\":\"png\"$a}}" && say "shot $1.png"; }
reply() { printf '%s\n' "$*" >&$CI; }
rc= buf= cbuf=
qmp '{"execute":"qmp_capabilities"}' || say "QMP: $ans"
serve() { # one request line of the guest
  local c=$1; shift; ans=
  case $c in
    @START) say "guest command starts (guest uptime $1 s)"; return;;
    @EXIT) rc=$1; say "guest command: exit $1"; return;;
    @shot) shot "$@";;
    @key) local k=; for x; do k+="${k:+,}{\"type\":\"qcode\",\"data\":\"$x\"}"; done; qmp "{\"execute\":\"send-key\",\"arguments\":{\"keys\":[$k]}}";;
    @move) ev "{\"type\":\"abs\",\"data\":{\"axis\":\"x\",\"value\":$1}},{\"type\":\"abs\",\"data\":{\"axis\":\"y\",\"value\":$2}}";;
    @rel) ev "{\"type\":\"rel\",\"data\":{\"axis\":\"x\",\"value\":$1}},{\"type\":\"rel\",\"data\":{\"axis\":\"y\",\"value\":$2}}";;
    @button) local d=false; [ "$2" = 1 ] && d=true; ev "{\"type\":\"btn\",\"data\":{\"button\":\"$1\",\"down\":$d}}";;
    @qmp) qmp "$*" && { reply "OK $ans"; return; };;
    *) ans="unknown request $c"; false;;
  esac && reply OK || reply "FAIL $ans"
}
drain() { # requests of the guest; a read that times out keeps what it has so far in $cbuf
  local l; while IFS= read -r -t 0.1 l <&$CO || { cbuf+=$l; false; }; do
    l=$cbuf${l%$'\r'} cbuf=
    case $l in @qmp\ *) serve @qmp "${l#@qmp }";; @*) set -f; serve $l; set +f;; esac
  done; }
while kill -0 "$QPID" 2>/dev/null; do
  drain
  while IFS= read -r l <&$CON || { buf+=$l; false; }; do
    l=$buf$l buf=; case $l in *'##SHOT '*'##'*) n=${l#*##SHOT }; shot "${n%%##*}";; esac; done
  if [ $(( ($(date +%s%N)-T0)/1000000000 )) -ge "$limit" ]; then say "time limit"; kill "$QPID"; rc=124; break; fi
done
drain
wait "$QPID" 2>/dev/null; QPID=
say "QEMU has ended"
exit "${rc:-125}"
