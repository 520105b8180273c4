"""g2core, TinyG's successor on 32 bits: the same answers, flow by lines: a few on the way, one more
for each answer.

From synthetos/g2, g2core/controller.cpp: a line that begins with { $ ? ! ~ % or H is a control line
and passes the blocks that wait (controller_parse_control), so a block is never wrapped in {"gc":..}
(its issues 209 and 287); ^D kills the job and leaves an alarm that {clear:n}, M2 or M30 ends (its
wiki, "Job Exception Handling"). The footer is [revision, status, bytes] without a checksum. Four
lines on the way (its wiki, "linemode"). The echo of verbosity 5 is the only check of what it read.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from postproc.streaming.protocols.tinyg import TinyG

TITLE = "g2core"
POKE = b'{"fv":null}\n'
LINES = 4
DOES = {
    "hold": "it was told to hold (!): ~ executes what it has, Ctrl-D drops it",
    "stop": (
        "Ctrl-D was sent: it drops what was not executed and stays in alarm until {clear:n}, M2"
        " or M30"
    ),
}


def recognises(banner: str) -> bool:
    """Its name, or a build of 100 and above in its answers."""
    return bool(re.search(r"g2core|\"fb\":1[0-9]{2}\.", banner))


class G2core(TinyG):
    title = TITLE
    lines = LINES
    fill = 4 * 254
    counts = False  # what the third number counts is unverified
    does: Mapping[str, str] = DOES
    urgents: Mapping[str, bytes] = {"hold": b"!", "resume": b"~", "stop": b"\x04"}


PROTOCOL = G2core
