#!/bin/sh
# Fetch LinuxCNC with its screen AXIS, and Xvfb to show it on, so that tests can open programs in
# it as a person does.
#
#   tests/hooks/fetch_axis.sh [DIR]    default: ${XDG_CACHE_HOME:-$HOME/.cache}/gcomp/linuxcnc-axis
#
# The packages that this system lacks (about 110, 65 MB, unpacked 260 MB) are downloaded with apt
# and unpacked into DIR. Nothing is installed; nothing outside DIR changes (apt's package lists
# may be refreshed). Does nothing if DIR is complete.
set -eu

dir=${1:-${XDG_CACHE_HOME:-$HOME/.cache}/gcomp/linuxcnc-axis}

fail() { echo "fetch_axis.sh: $1" >&2; exit 1; }

[ -e "$dir/complete" ] && exit 0

for tool in apt-get dpkg-deb awk; do
    command -v $tool >/dev/null 2>&1 || fail "needs $tool (Debian 12); AXIS was not fetched"
done
[ -x /usr/bin/python3.11 ] || fail "needs Debian's own Python, /usr/bin/python3.11"

wanted() {      # what an installation would add
    apt-get install -s --no-install-recommends linuxcnc-uspace xvfb 2>/dev/null \
        | awk '/^Inst/ {print $2}'
}

packages=$(wanted)
[ -n "$packages" ] || { apt-get -qq update && packages=$(wanted); } || true
[ -n "$packages" ] || fail "apt knows no linuxcnc-uspace and xvfb, or they are installed already"

work=$(mktemp -d) || fail "cannot make a temporary folder"
trap 'rm -rf "$work"' EXIT
chmod 755 "$work"   # apt downloads as a user of its own where it may
mkdir -p "$work/debs" "$work/tree/etc"
cd "$work/debs"
# shellcheck disable=SC2086
apt-get -qq download $packages >"$work/log" 2>&1 \
    || fail "apt-get cannot download: $(tail -n 1 "$work/log")"
for deb in *.deb; do
    dpkg-deb -x "$deb" "$work/tree" || fail "$deb is damaged"
done
# The tree is laid over /usr and /etc: what Debian keeps in /lib belongs to /usr/lib there.
if [ -d "$work/tree/lib" ]; then cp -a "$work/tree/lib/." "$work/tree/usr/lib/"; fi
[ -e "$work/tree/usr/bin/axis" ] && [ -e "$work/tree/usr/bin/Xvfb" ] \
    || fail "the packages hold no AXIS or no Xvfb"
mkdir -p "$dir" && cp -a "$work/tree/usr" "$work/tree/etc" "$dir/" && touch "$dir/complete" \
    || fail "cannot write $dir"
