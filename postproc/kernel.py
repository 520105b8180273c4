"""The compiled kernel (kernel.c, nc/splice.c), where setup.sh or somebody built it:

    python -m postproc.kernel        # needs a C compiler: cc, or what CC names

Without it gcomp gives the same bytes, and arcs take twice as long. docs/DESIGN.md says why it
is there.
"""

from __future__ import annotations

import ctypes
import hashlib
import os
import sys
from functools import cache

FOLDER = os.path.dirname(__file__)
SOURCES = os.path.join(FOLDER, "kernel.c"), os.path.join(FOLDER, "nc", "splice.c")
BUILT = os.path.join(FOLDER, "kernel-built.so")
# A product and a sum in one instruction have other bits; nobody asks for errno, or for traps.
FLAGS = ("-O3", "-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math", "-shared", "-fPIC")


@cache
def library() -> ctypes.CDLL | None:
    """The kernel; None where it was not built, or from another source, or for another computer."""
    if not os.path.exists(BUILT):
        return None
    try:
        found = ctypes.CDLL(BUILT)
        # The digest of both sources is compiled in. A kernel of an older source would give other
        # bits than numpy's, and nobody would see why.
        same = ctypes.c_char.in_dll(found, "source")
    except (OSError, ValueError):
        return None
    return found if ctypes.string_at(ctypes.addressof(same)) == _digest().encode() else None


def _digest() -> str:
    digest = hashlib.sha256()
    for source in SOURCES:
        with open(source, "rb") as file:
            digest.update(file.read())
    return digest.hexdigest()


def build(target: str = BUILT) -> str:
    """Compile the kernel; "" or why that failed."""
    import shlex
    import subprocess

    compiler = shlex.split(os.environ.get("CC", "cc"))
    part = f"{target}.part"  # a process that has the old one loaded keeps it
    command = [*compiler, *FLAGS, f'-DSOURCE="{_digest()}"', "-o", part, *SOURCES, "-lm"]
    try:
        done = subprocess.run(command, capture_output=True, text=True)
    except OSError as error:
        return f"there is no C compiler {compiler[0]} here: {error.strerror}"
    if done.returncode:
        return done.stderr
    os.replace(part, target)
    return ""


def main() -> int:
    """Build it where it is found; the exit status."""
    fault = build()
    print(fault or f"built {BUILT}", file=sys.stderr if fault else sys.stdout)
    return 1 if fault else 0


if __name__ == "__main__":
    sys.exit(main())
