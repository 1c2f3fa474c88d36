# shellcheck shell=sh disable=SC2086,SC2154,SC2034
# Flips at the 60 Hz of the kernel's virtual display, of a scene so small that one emulated processor can keep up. Each refresh
# of a turn is a picture or is counted as missed. The guest's clock counts its instructions, one a nanosecond (run-kms.sh -a
# icount): the figures are those of a machine of that speed, whatever runs beside QEMU.
export LP_NUM_THREADS=0
for way in atomic legacy; do
    set -- --set sampling.slices_per_voxel=0.05 --zoom 0.3 --budget-ms 10 --set shading.model=none
    [ $way = atomic ] || set -- "$@" --no-atomic
    start "$@"
    [ $way = legacy ] || idle
    kms-host key spc
    sleep 10
    kms-host key spc
    rest
    turned=$(sed -n 's/.*show: turned for //p' $log)
    say "note $way: turned for $turned: $(echo "$turned" | awk '{ printf "%.1f refreshes a second", ($3 + $5) / $1 }')"
    verdict "$way: pictures and missed refreshes are 60 a second" \
        awk -v t="$turned" 'BEGIN { split(t, w, " "); all = w[3] + w[5]; exit !(w[1] > 9 && all > 59 * w[1] && all < 60.6 * w[1] + 2) }'
    verdict "$way: one in twenty is missed at most" \
        awk -v t="$turned" 'BEGIN { split(t, w, " "); exit !(w[3] > 100 && w[5] <= w[3] / 20) }'
    kms-host key q
    gone "$way" 0
    say "note $way: $(tail -1 $log)"
done
