"""grblHAL: GRBL's rules with a larger buffer, longer lines, more states, and backlash compensation
of its own.

Sources: grblHAL/core, report.c (banner "GrblHAL 1.1f ['$' or '$HELP' for help]",
[OPT:..,blocks,rx,axes,tools], [FIRMWARE:grblHAL]), stream.h (RX_BUFFER_SIZE 1024, a ring of which
one byte stays free), settings.h (backlash is setting 160 and on, axis by axis; $$ leaves it out and
$+ lists it), wiki "Report extensions".
"""

from __future__ import annotations

import re

from postproc.streaming.protocols.grbl import Grbl

TITLE = "grblHAL"
POKE = b"?"
BANNER = re.compile(r"GrblHAL [^\n]*\[|Grbl \d[^\n]*\[")
AXES = "XYZABCUV"
BACKLASH = 160


def recognises(banner: str) -> bool:
    return bool(re.search(r"grblhal", banner, re.IGNORECASE))


class GrblHal(Grbl):
    title = TITLE
    banner = BANNER
    default_window, default_line = 127, 255
    segments = 10  # stepper.h: SEGMENT_BUFFER_SIZE
    questions = (b"$I", b"$+", b"$#", b"$G")
    keep = 1

    def compensates(self, settings: dict[str, str]) -> list[str]:
        """Backlash, axis by axis."""
        found = []
        for i, axis in enumerate(AXES):
            value = settings.get(str(BACKLASH + i), "0")
            if re.fullmatch(r"[-+]?[0-9.]+", value) and float(value):
                found.append(f"backlash of {axis}, {float(value) * 1000:g} um (${BACKLASH + i})")
        return found


PROTOCOL = GrblHal
