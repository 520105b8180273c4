#!/bin/sh
# Fetch LinuxCNC's own G-code interpreter, to be a witness in the tests.
#
#   tests/linuxcnc/fetch.sh [DIR]      default: ${XDG_CACHE_HOME:-$HOME/.cache}/gcomp/linuxcnc
#
# Two Debian packages (22 MB) are downloaded with apt and 4 MB of them unpacked into DIR. Nothing
# is installed; nothing outside DIR changes (apt's package lists may be refreshed). Does nothing
# if DIR is complete.
set -eu

dir=${1:-${XDG_CACHE_HOME:-$HOME/.cache}/gcomp/linuxcnc}
packages="linuxcnc-uspace libboost-python1.74.0"
wanted="usr/bin/rs274
usr/lib/python3/dist-packages/gcode.cpython-311-
usr/lib/librs274.so. usr/lib/libnml.so. usr/lib/liblinuxcnchal.so. usr/lib/liblinuxcncini.so.
usr/lib/libpyplugin.so. usr/lib/libtooldata.so.
/libboost_python311.so."

fail() { echo "fetch.sh: $1" >&2; exit 1; }

[ -e "$dir/complete" ] && exit 0

for tool in apt-get dpkg-deb tar ldd; do
    command -v $tool >/dev/null 2>&1 || fail "needs $tool (Debian 12); LinuxCNC's interpreter was not fetched"
done

work=$(mktemp -d) || fail "cannot make a temporary folder"
trap 'rm -rf "$work"' EXIT
mkdir -p "$work/debs" "$work/tree"

. "$(dirname "$0")/packages.sh"   # download, unpack

missing() {     # names of shared libraries that the loader does not find
    LD_LIBRARY_PATH="$work/tree/usr/lib:$work/tree/usr/lib/$(arch)-linux-gnu:$work/tree/lib/$(arch)-linux-gnu" \
        ldd "$work"/tree/usr/bin/rs274 "$work"/tree/usr/lib/python3/dist-packages/gcode.cpython-311-*.so 2>/dev/null \
        | awk '/not found/ {print $1}' | sort -u
}

download $packages
unpack $wanted
for file in $wanted; do
    found=$(find "$work/tree" -path "*$file*" | head -n 1)
    [ -n "$found" ] || fail "the packages hold no $file: LinuxCNC 2.9 for Python 3.11 (Debian 12) is needed"
done

# A bare system may lack a few common libraries; they too are only unpacked.
for library in $(missing); do
    case $library in
        libpython3.11.so.*) download libpython3.11 ;;
        libtirpc.so.*)      download libtirpc3 ;;
        libedit.so.*)       download libedit2 ;;
        libbsd.so.*)        download libbsd0 ;;
        libmd.so.*)         download libmd0 ;;
        libgssapi_krb5.so.*) download libgssapi-krb5-2 libkrb5-3 libk5crypto3 libkrb5support0 libcom-err2 libkeyutils1 ;;
        *) fail "the interpreter needs $library, and no package is known for it" ;;
    esac
    unpack "/lib"
done
[ -z "$(missing)" ] || fail "still missing: $(missing | tr '\n' ' ')"

mkdir -p "$dir" && cp -R "$work/tree/." "$dir/" && touch "$dir/complete" || fail "cannot write $dir"
