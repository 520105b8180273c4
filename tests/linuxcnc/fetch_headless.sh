#!/bin/sh
# Fetch LinuxCNC itself (task, motion, HAL; no display), to be a receiver in the tests that runs
# programs in auto mode.
#
# tests/linuxcnc/fetch_headless.sh [DIR]      default:
# ${XDG_CACHE_HOME:-$HOME/.cache}/gcomp/linuxcnc-headless
#
# Two or three Debian packages (22 MB) are downloaded with apt and the parts without a display
# unpacked into DIR. Nothing is installed; nothing outside DIR changes (apt's package lists may be
# refreshed). Does nothing if DIR is complete.
set -eu

dir=${1:-${XDG_CACHE_HOME:-$HOME/.cache}/gcomp/linuxcnc-headless}
programs="usr/bin/milltask usr/bin/io usr/bin/linuxcncsvr usr/bin/rtapi_app usr/bin/halcmd usr/bin/linuxcncrsh"
wanted="$programs
usr/lib/linuxcnc/modules/motmod.so usr/lib/linuxcnc/modules/tpmod.so usr/lib/linuxcnc/modules/homemod.so
usr/lib/linuxcnc/modules/trivkins.so usr/lib/linuxcnc/modules/hal_lib.so
usr/lib/python3/dist-packages/linuxcnc.cpython-311-
usr/lib/librs274.so. usr/lib/libnml.so. usr/lib/liblinuxcnchal.so. usr/lib/liblinuxcncini.so. usr/lib/libposemath.so.
usr/lib/libpyplugin.so. usr/lib/libtooldata.so.
usr/share/linuxcnc/linuxcnc.nml
/libboost_python311.so."

fail() { echo "fetch_headless.sh: $1" >&2; exit 1; }

[ -e "$dir/complete" ] && [ -e "$dir/usr/bin/linuxcncrsh" ] && exit 0

for tool in apt-get dpkg-deb tar ldd; do
    command -v $tool >/dev/null 2>&1 || fail "needs $tool (Debian 12); LinuxCNC was not fetched"
done
[ -x /usr/bin/python3.11 ] || fail "needs Debian's own Python, /usr/bin/python3.11, which LinuxCNC's task is linked to"

work=$(mktemp -d) || fail "cannot make a temporary folder"
trap 'rm -rf "$work"' EXIT
chmod 755 "$work"   # apt downloads as a user of its own where it may
mkdir -p "$work/debs" "$work/tree"

. "$(dirname "$0")/packages.sh"   # download, unpack

missing() {     # names of shared libraries that the loader does not find
    (
        cd "$work/tree"
        LD_LIBRARY_PATH="$work/tree/usr/lib:$work/tree/usr/lib/$(arch)-linux-gnu:$work/tree/lib/$(arch)-linux-gnu" \
            ldd $programs usr/lib/python3/dist-packages/linuxcnc.cpython-311-*.so 2>/dev/null
    ) | awk '/not found/ {print $1}' | sort -u
}

download linuxcnc-uspace libboost-python1.74.0
unpack $wanted
for file in $wanted; do
    found=$(find "$work/tree" -path "*$file*" | head -n 1)
    [ -n "$found" ] || fail "the packages hold no $file: LinuxCNC 2.9 for Python 3.11 (Debian 12) is needed"
done

# Libraries that the system lacks are only unpacked too; libepoxy belongs to the preview in the
# Python module, and is never called.
for library in $(missing); do
    case $library in
        libepoxy.so.*)      download libepoxy0 ;;
        libpython3.11.so.*) download libpython3.11 ;;
        libtirpc.so.*)      download libtirpc3 ;;
        libudev.so.*)       download libudev1 ;;
        libedit.so.*)       download libedit2 ;;
        libbsd.so.*)        download libbsd0 ;;
        libmd.so.*)         download libmd0 ;;
        libgssapi_krb5.so.*) download libgssapi-krb5-2 libkrb5-3 libk5crypto3 libkrb5support0 libcom-err2 libkeyutils1 ;;
        *) fail "LinuxCNC needs $library, and no package is known for it" ;;
    esac
    unpack "/lib"
done
[ -z "$(missing)" ] || fail "still missing: $(missing | tr '\n' ' ')"

# The tree is laid over /usr: what Debian keeps in /lib belongs to /usr/lib there.
if [ -d "$work/tree/lib" ]; then cp -R "$work/tree/lib/." "$work/tree/usr/lib/"; rm -rf "$work/tree/lib"; fi
mkdir -p "$dir" && cp -R "$work/tree/." "$dir/" && touch "$dir/complete" || fail "cannot write $dir"
