"""A measurement after compensation against the one before: what it took out, and whether every sign
is right.

pairing: which recordings belong together; signs: what became of each component and direction;
judge: parameters of ISO 230-2 before and after; report: for a person, as data, and as a page.
Deviation = actual - commanded by the nominal program, mm or rad.
"""

from __future__ import annotations

from dataclasses import dataclass

from postproc.errors import GcompError
from postproc.iso import Parameter
from postproc.iso.assign import Motion


class AcceptError(GcompError):
    """The recordings can not be compared."""


@dataclass(frozen=True)
class Ratio:
    """What of the deviation before is there after. of: "approached in +", "approached in -" or
    "reversal"; value: 0 where all is gone, 1 where nothing happened, 2 where the correction was
    added with the wrong sign; U: expanded (95 %), None where it can not be told; size: mm or rad,
    rms of what it is a ratio of; verdict: a key of VERDICTS."""

    of: str
    value: float
    U: float | None
    size: float
    verdict: str


VERDICTS = {
    "good": "taken out",
    "nothing": "nothing happened",
    "turned": "SIGN TURNED",
    "too much": "CORRECTED TOO MUCH",
    "undecided": "too small to tell",
    "between": "not decided",
}


@dataclass(frozen=True)
class Change:
    """One parameter before and after. reduction: 1 - after / before and its U (95 %), None where
    not defined."""

    before: Parameter
    after: Parameter
    reduction: float | None
    U: float | None


@dataclass(frozen=True)
class Outcome:
    """One line of targets. changes: parameters; ratios: of signs; acted: how much of what the map
    states was taken out (1: all of it, 0: none, -1: it was added), None without a machine or where
    the map is zero; left, scatter: mm or rad, rms of the means after about their zero (and line, of
    a straightness), and of what the scatter of the runs alone makes of them, None where each target
    has one run; repeat: mm or rad, largest repeatability of one direction after;
    notices: in words; curves: targets and means about their own mean."""

    subject: str
    unit: str
    before: Motion
    after: Motion
    changes: tuple[Change, ...]
    ratios: tuple[Ratio, ...]
    acted: float | None
    left: float
    scatter: float | None
    repeat: float | None
    notices: tuple[str, ...]
    curves: dict[str, list[float | None]]

    @property
    def turned(self) -> list[str]:
        """Directions whose sign is turned."""
        return [r.of for r in self.ratios if r.verdict == "turned"]
