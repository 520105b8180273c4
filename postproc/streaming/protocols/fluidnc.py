"""FluidNC: GRBL's rules, lines up to 255 characters, channels with buffers of their own, no sizes
in $I.

Sources: bdring/FluidNC, FluidNC/src/Report.cpp (banner with "[FluidNC", [VER:..FluidNC..], [OPT:..]
without numbers), Channel.h (line of 255 characters). Its backlash lies in its configuration file,
which it does not report here: what it compensates by itself is not seen (unverified on hardware).
"""

from __future__ import annotations

import re

from postproc.streaming.protocols.grbl import Grbl

TITLE = "FluidNC"
POKE = b"?"
BANNER = re.compile(r"Grbl \d[^\n]*\[")


def recognises(banner: str) -> bool:
    return bool(re.search(r"fluidnc", banner, re.IGNORECASE))


class FluidNc(Grbl):
    title = TITLE
    banner = BANNER
    default_window, default_line = 128, 255
    segments = 20  # stepping: segments, 20 at most


PROTOCOL = FluidNc
