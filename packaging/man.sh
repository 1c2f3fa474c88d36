#!/bin/sh
# man.sh VITRINE >vitrine.1 - the man page, out of what the program says of itself: its help texts, which come from the
# option tables, and with them the warnings of `info`.
set -eu
vitrine=$1
escape() { sed 's/\\/\\e/g; s/^\./\\\&./; s/^'"'"'/\\\&'"'"'/; s/-/\\-/g'; }
section() { # TITLE COMMAND...
    printf '.SH %s\n.nf\n' "$1"
    shift
    "$@" | escape
    printf '.fi\n'
}
printf '.TH VITRINE 1 "" "%s" "User Commands"\n' "$("$vitrine" --version)"
printf '.SH NAME\nvitrine \\- a CT volume viewer for screens without a desktop\n'
section DESCRIPTION "$vitrine" --help
"$vitrine" --help | sed -n '/^Commands:/,/^$/s/^  \([a-z]*\) .*/\1/p' | while read -r command; do
    section "VITRINE $(echo "$command" | tr '[:lower:]' '[:upper:]')" "$vitrine" "$command" --help
done
