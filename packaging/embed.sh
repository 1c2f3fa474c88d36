#!/bin/sh
# embed.sh STRUCT ARRAY HEADER EXT FILE... - writes C that holds the files as a NULL-ended table of {name, text, bytes}.
# EXT: an extension to strip from the names, or `keep`. The text is followed by a NUL that `bytes` does not count.
set -eu
struct=$1 array=$2 header=$3 ext=$4
shift 4
echo "/* Made by packaging/embed.sh; do not edit. */"
echo "#include \"$header\""
i=0
for file; do
    printf 'static const unsigned char file_%d[] = {\n' "$i"
    od -An -v -tu1 "$file" | sed 's/  */,/g; s/^,//; s/$/,/'
    echo '0};'
    i=$((i + 1))
done
echo "const struct $struct ${array}[] = {"
i=0
for file; do
    name=$(basename "$file")
    [ "$ext" = keep ] || name=$(basename "$file" ".$ext")
    printf '    {"%s", (const char *)file_%d, sizeof file_%d - 1},\n' "$name" "$i" "$i"
    i=$((i + 1))
done
echo '    {0, 0, 0},'
echo '};'
