"""Tests of machine tools evaluated as the ISO 230 series does: pure functions of arrays and
recordings.

positioning: ISO 230-2; drift: ISO 230-3; diagonals: ISO 230-6; circles: ISO 230-4; lines and
squareness: ISO 230-1; uncertainty: ISO/TR 230-9. choose says which of them a recording is for;
report and figure show the results. Inside mm and rad; deviation = actual - commanded; what is not
defined is None (in arrays NaN), never 0.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from postproc.errors import GcompError


class IsoError(GcompError):
    """A recording can not be evaluated by the test that it looks like."""


@dataclass(frozen=True)
class Options:
    """What the recordings do not say. line: reference line of straightness and squareness
    (end-point, least-squares, minimum-zone); leads: mm of the screw by axis, "" for any axis;
    budget: what is stated for the uncertainty."""

    line: str = "least-squares"
    leads: dict[str, float] = field(default_factory=dict)
    budget: Stated = field(default_factory=lambda: Stated())


@dataclass(frozen=True)
class Stated:
    """Influences on the uncertainty, all k = 1, None where not stated.

    device: mm, device_angle: rad, of one reading, in place of what a recording's head says;
    misalignment: rad, largest angle between the beam and the axis; alpha: 1/K; u_alpha: 1/K;
    temperature: degrees Celsius, mean of the machine in the test; u_temperature: K; drift: mm,
    whole range of the environmental variation error (EVE); square: rad, of the square.
    """

    device: float | None = None
    device_angle: float | None = None
    misalignment: float | None = None
    alpha: float | None = None
    u_alpha: float | None = None
    temperature: float | None = None
    u_temperature: float | None = None
    drift: float | None = None
    square: float | None = None


@dataclass(frozen=True)
class Term:
    """One influence on the uncertainty. u: mm or rad, k = 1; of: the parameters it acts on; said:
    where it comes from."""

    name: str
    u: float
    of: frozenset[str]
    said: str


@dataclass(frozen=True)
class Parameter:
    """value and U (expanded, k = 2, about 95 %): mm or rad, None where not defined; runs: the part
    of U that comes from the scatter of the runs; means: in words; at: where it was found."""

    name: str
    value: float | None
    means: str
    at: str = ""
    U: float | None = None
    runs: float | None = None


@dataclass(frozen=True)
class Result:
    """One test. test: positioning, rotary, angle, straightness, diagonal, diagonals, squareness,
    circle, ETVE, rotating spindle; subject: EXX, PPP, C0Y, XY; chosen: why this test; unit: um or
    urad; noise: mm or rad, for the digits shown; columns: of the table per target or per run, name
    to values; detail: what the figure draws; causes: of a circle, what makes it out of round."""

    test: str
    standard: str
    subject: str
    chosen: str
    unit: str
    files: tuple[str, ...]
    parameters: tuple[Parameter, ...]
    terms: tuple[Term, ...] = ()
    notices: tuple[str, ...] = ()
    noise: float = 0.0
    columns: dict[str, list[Any]] = field(default_factory=dict)
    detail: Any = None
    causes: Any = None

    def __getitem__(self, name: str) -> Parameter:
        return next(p for p in self.parameters if p.name == name)
