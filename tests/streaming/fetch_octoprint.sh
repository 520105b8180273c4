#!/bin/sh
# Fetch OctoPrint, whose virtual printer is a receiver in the tests that nobody here wrote.
#
# tests/streaming/fetch_octoprint.sh [DIR]      default:
# ${XDG_CACHE_HOME:-$HOME/.cache}/gcomp/octoprint
#
# An environment of its own is made in DIR and filled from PyPI (about 200 MB; OctoPrint is AGPL
# and runs there as a process of its own, nothing of it is imported here). Does nothing if DIR is
# complete; nothing outside DIR changes.
set -eu

dir=${1:-${XDG_CACHE_HOME:-$HOME/.cache}/gcomp/octoprint}
python=${PYTHON:-python3}

fail() { echo "fetch_octoprint.sh: $1" >&2; exit 1; }

[ -e "$dir/complete" ] && exit 0
command -v "$python" >/dev/null 2>&1 || fail "needs $python"

mkdir -p "$(dirname "$dir")" || fail "cannot write $(dirname "$dir")"
rm -rf "$dir"
"$python" -m venv "$dir" || fail "cannot make an environment in $dir"
"$dir/bin/python" -m pip install --quiet --disable-pip-version-check "octoprint==1.11.8" \
    || fail "pip cannot install OctoPrint"
"$dir/bin/python" -c "import octoprint.plugins.virtual_printer.virtual" || fail "OctoPrint has no virtual printer"
touch "$dir/complete"
