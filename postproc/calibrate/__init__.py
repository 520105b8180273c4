"""Recordings of single axes in, error tables of a machine out: means, uncertainties, datum, lines,
squareness, checks.

Knows no files: recordings come in as arrays, a machine folder goes out as text (folder.py). Every
reading is actual - commanded of the tool against the workpiece, so tables have the machine's sign
and nothing is turned round.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from postproc.errors import GcompError
from postproc.machine.chain import Chain

# 1/K, expansion of steel and of most glass scales' substrates; ISO 230-2 names 11 to 12 for steel
STEEL = 11.5e-6
LINES = ("least-squares", "end-points")


class CalibrationError(GcompError):
    """The recordings do not give a machine that can be trusted."""


@dataclass(frozen=True)
class Finding:
    """What a check found. level: "doubt" for what may be wrong, "note" for what was done or could
    not be looked at;
    numbers: what it rests on, names with their unit."""

    check: str
    level: str
    component: str
    message: str
    numbers: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Options:
    """What the user decides.

    chain: who carries whom. datum: axis to the position where its deviations are zero; keep_zero:
    leave the zeros as recorded. line: how the reference line of a straightness is drawn;
    keep_lines: leave it in. squareness: name to (value, u) in rad, or to "straightness" or
    "diagonals". square_error: (value, u) rad, the angle of the square over 90 degrees. square_at:
    axis to mm, where the axes stood when a stated squareness was measured. leads: axis to mm of a
    turn of its screw. travel: axis to mm. point (3,): mm, the measured point from the last
    carriage. u_random: u of the recordings is noise and averages out. u_temperature: K, of the
    scale's mean temperature; expansion: 1/K. mean: one column for both directions. keep_all:
    components within their uncertainty too.
    """

    chain: Chain
    datum: Mapping[str, float] = field(default_factory=dict)
    keep_zero: bool = False
    line: str = "least-squares"
    keep_lines: bool = False
    squareness: Mapping[str, tuple[float, float | None] | str] = field(default_factory=dict)
    square_error: tuple[float, float] | None = None
    square_at: Mapping[str, float] = field(default_factory=dict)
    leads: Mapping[str, float] = field(default_factory=dict)
    travel: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    max_slope: float = 0.005
    outside: str = "error"
    point: tuple[float, float, float] = (0.0, 0.0, 0.0)
    u_random: bool = False
    u_temperature: float = 0.0
    expansion: float = STEEL
    drop_outliers: bool = False
    keep_all: bool = False
    mean: bool = False
    diameter: tuple[str, ...] = ()
