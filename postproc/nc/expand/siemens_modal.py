"""What holds on behind a plain line of a Sinumerik program: its F and its S, as they are written.

Siemens, NC Programming Manual, "Dwell time (G4)": F and S in a block with G4 say the time alone,
the feedrate and the spindle speed before it are retained. A string says nothing: MSG("F9").
"""

from __future__ import annotations

import re

STRING = re.compile(rb'"[^"\n]*"?')
DWELL = re.compile(rb"(?<![A-Z_0-9])G[ \t]*0*4(?![0-9.])", re.IGNORECASE)
# not S1=, which is that of one spindle
VALUE = rb"[ \t]*=?[ \t]*([0-9]+\.?[0-9]*|\.[0-9]+)(?![0-9.]|[ \t]*=)"
FEED = re.compile(rb"(?<![A-Z_0-9])F" + VALUE, re.IGNORECASE)
SPEED = re.compile(rb"(?<![A-Z_0-9])S" + VALUE, re.IGNORECASE)


def code_of(line: bytes) -> bytes:
    """A line up to its comment, its strings blank: all that stays stands where it stood."""
    if b'"' in line:
        line = STRING.sub(lambda m: b" " * len(m[0]), line)
    return line.partition(b";")[0]


def feed_of(code: bytes) -> bytes | None:
    """The F that holds behind a line's code, None: it names none."""
    return _last(FEED, code)


def speed_of(code: bytes) -> bytes | None:
    """The S that holds behind a line's code, None: it names none."""
    return _last(SPEED, code)


def _last(word: re.Pattern[bytes], code: bytes) -> bytes | None:
    # the quick question first: every line of a program comes here
    found = word.findall(code)
    return found[-1] if found and not DWELL.search(code) else None
