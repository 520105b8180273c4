"""Sinumerik's cycles in step with the spindle that stay as they are: CYCLE840 (tapping with a
compensating chuck) at its corrected place, CYCLE97, CYCLE98 and CYCLE99 (threads).

Siemens "SINUMERIK 840D/840Di/810D", Programming Guide Cycles, and "SINUMERIK 808D", Programming and
Operating Manual: CYCLE840 ends at RTP, which is written before and behind it, so that the axis of
the hole is known again. Where a thread ends is not said: X and Z are not known behind it
(postproc/nc/left.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from postproc.nc.expand.siemens_drilling import Drilling
from postproc.nc.expand.siemens_values import Value, numeric
from postproc.nc.expand.tracker import Tracker, number

THREADS = ("CYCLE97", "CYCLE98", "CYCLE99")
NAMES = {
    "CYCLE840": (
        "RTP RFP SDIS DP DPR DTB SDR SDAC ENC MPIT PIT AXN PITA TECHNO PITM PTAB PTABA GMODE"
        " DMODE AMODE"
    )
}


class Tapping(Drilling):
    """A call of CYCLE840 with its values; around: the lines before and behind it."""

    words = NAMES
    around = (b"", b"")

    def lines(self, tracker: Tracker, feed: bytes, speed: bytes = b"") -> list[bytes]:
        axis = self.axis(tracker)
        self._check(axis)
        self._levels()
        high = b"G0 " + self._to(tracker, axis)(self.given["RTP"])
        values = [self.given.get(word) for word in self.words[self.name].split()]
        call = _written(self.name, values)
        # a program that was written out once is written out again without another two
        if self.around == (high, high):  # they stand there already
            return [call]
        return [high, call, high, *tracker.motion_code()]


@dataclass
class Thread:
    """A call of a threading cycle."""

    name: str
    values: Sequence[Value | None]

    def lines(self, tracker: Tracker, feed: bytes, speed: bytes = b"") -> list[bytes]:
        """The call, with numbers for its expressions."""
        return [_written(self.name, self.values)]


def _written(name: str, values: Sequence[Value | None]) -> bytes:
    texts = [_text(value) for value in values]
    while texts and not texts[-1]:
        texts.pop()
    return f"{name}({','.join(texts)})".encode("latin-1")


def _text(value: Value | None) -> str:
    if value is None:
        return ""
    if isinstance(value, str):
        return f'"{value}"'
    return number(float(numeric(value)), 6).rstrip(".")
