#!/bin/sh
# Makes .venv with gcomp in it; `sh setup.sh test` adds what the tests need. For a fresh Debian 12
# with python3 as well as for a machine that has everything: what is there already is used as it is.
set -eu
cd "$(dirname "$0")"
extra=${1:+"[$1]"}

python3 -c 'import sys; sys.exit(sys.version_info < (3, 11))' || {
    echo "gcomp needs Python 3.11 or newer; python3 here is $(python3 --version)" >&2
    exit 1
}
if ! [ -x .venv/bin/pip ]; then
    echo "setup.sh: making .venv in this folder; nothing outside of it is changed" >&2
    rm -rf .venv
    if ! python3 -m venv .venv >/dev/null 2>&1; then
        rm -rf .venv
        if [ "$(id -u)" = 0 ]; then sudo=; else sudo=sudo; fi
        if [ -n "$sudo" ] && ! command -v sudo >/dev/null; then
            echo "python3 has no venv module here, and this user may not install it:" \
                "ask for 'apt-get install python3-venv'" >&2
            exit 1
        fi
        echo "setup.sh: python3 has no venv module here: installing Debian's" \
            "python3-venv${sudo:+ (sudo asks for your password)}" >&2
        $sudo apt-get update -qq >/dev/null
        $sudo env DEBIAN_FRONTEND=noninteractive \
            apt-get install -y -qq python3-venv >/dev/null 2>&1 || {
            echo "python3-venv could not be installed: try '$sudo apt-get install python3-venv'" >&2
            exit 1
        }
        python3 -m venv .venv
    fi
fi
echo "setup.sh: installing gcomp${1:+ with $1} and what it needs into .venv" >&2
.venv/bin/pip install --quiet --disable-pip-version-check --use-pep517 --editable ".$extra"
# What is faster in C, where there is a compiler; gcomp works without it, to the same bytes.
compiler=${CC:-cc}
if command -v "${compiler%% *}" >/dev/null; then
    .venv/bin/python -m postproc.kernel >/dev/null 2>&1 ||
        echo "setup.sh: $compiler could not build the kernel: gcomp works without it" >&2
fi
