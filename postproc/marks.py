"""How a file says that gcomp made it.

Each mark is what gcomp alone writes, with what stands around it: a program, a drawing or a page of
a person may name gcomp, too.
"""

from __future__ import annotations

import re

from postproc.expressions import expression

Mark = tuple[re.Pattern[bytes], int]  # and how far from the beginning to look, bytes; 0: to the end

# The comment with its version, before the first block that was changed.
PROGRAM: Mark = (expression(rb"\(GCOMP [0-9]", re.IGNORECASE), 0)
PAGE: Mark = (expression(rb'content="gcomp '), 1 << 14)
JSON: Mark = (expression(rb'"format": "gcomp-'), 1 << 10)
# What style.made_by() says, in SVG, PDF and PNG.
FIGURE: Mark = (
    expression(rb"<dc:title>gcomp</dc:title>|/Creator \(gcomp\)|tEXtSoftware\0gcomp"),
    0,
)
SIMULATED: Mark = (expression(rb"simulated = true"), 1 << 14)
RESIDUALS: Mark = (
    expression(rb"recording,row,signal,measured_um,before_um,after_um,held_out"),
    1 << 7,
)
LONGEST = 128  # bytes of a mark, at most


def comment(text: bytes) -> Mark:
    """Of a file that begins with this comment."""
    return re.compile(re.escape(text)), 1 << 8
