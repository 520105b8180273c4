"""Which component a recording measured: from the axis that moved, the quantity and the sensitive
direction.

One axis moves and the others rest: a component (EXX, EZX, EBZ). Several move together along a
straight line: a diagonal. Anything else fits nothing and is refused with the reason.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from postproc.calibrate import CalibrationError
from postproc.errors import Place
from postproc.machine.chain import ROTARY, XYZ
from postproc.machine.tables import COMPONENTS
from postproc.recordings import Recording
from postproc.units import UM

Refuse = Callable[..., CalibrationError]
REST = 0.02  # mm or deg: an axis that moves less than this is at rest
ALONG = 0.9999  # cosine: 0.8 degrees, by which 100 um are read 0.01 um short
STRAIGHT = 0.05  # mm: how far targets of a diagonal may lie beside its line


@dataclass(frozen=True)
class Series:
    """Readings of one component from one file.

    component: EZX; letter: the axis that moves. position (N,) mm (deg of rotary axes); approach
    (N,): +1, -1, 0 for not known; run (N,); reading (N,) mm or rad along the positive direction;
    lines (N,): of the file; t (N,) s; rest: axis to mm where it stood; u: mm or rad, of one
    reading, None for not stated; head and columns: of the recording.
    """

    component: str
    letter: str
    file: str
    position: np.ndarray
    approach: np.ndarray
    run: np.ndarray
    reading: np.ndarray
    lines: np.ndarray
    rest: dict[str, float]
    u: float | None
    head: dict[str, Any] = field(default_factory=dict)
    columns: dict[str, np.ndarray] = field(default_factory=dict)
    notices: tuple[str, ...] = ()

    @property
    def angle(self) -> bool:
        """Whether it is in rad."""
        return self.component[:2] in COMPONENTS[3:]

    @property
    def straight(self) -> bool:
        """Whether it is a straightness: a translation across a linear axis."""
        return not self.angle and self.letter in XYZ and self.component[1] != self.letter

    def pick(self, which: np.ndarray) -> Series:
        """The rows where `which` (N,) is true."""
        names = ("position", "approach", "run", "reading", "lines")
        parts = {name: getattr(self, name)[which] for name in names}
        return replace(self, columns={n: c[which] for n, c in self.columns.items()}, **parts)


@dataclass(frozen=True)
class Diagonal:
    """Readings along a line in which several axes move together. path: axis to (N,) mm; direction:
    axis to cosine of the sensitive direction; approach (N,): +1 where it was travelled along
    `direction`; rest: axis to mm where it stood."""

    file: str
    path: dict[str, np.ndarray]
    direction: dict[str, float]
    approach: np.ndarray
    reading: np.ndarray
    lines: np.ndarray
    rest: dict[str, float]

    @property
    def axes(self) -> list[str]:
        """Those that move, in the order X Y Z."""
        return [x for x in XYZ if x in self.path]

    @property
    def name(self) -> str:
        """Like +X-Z: the way of each axis along the reading."""
        return "".join(f"{'+' if c > 0 else '-'}{x}" for x, c in self.direction.items())


def assign(recording: Recording) -> Series | Diagonal:
    """Raises CalibrationError where the recording fits no component and no diagonal."""

    def refuse(message: str, advice: str = "") -> CalibrationError:
        return CalibrationError(message, advice, Place(recording.file, 1))

    if recording.kind != "targets":
        raise refuse(
            f"a {recording.kind} recording says nothing about one component alone",
            'calibration needs kind = "targets": captures at rest, one axis at a time',
        )
    vector = {x: v for x, v in recording.sensitive.items() if abs(v) > 1e-9}
    #     moves     quantity       read along      component
    #     Z         displacement   Z               EZZ
    #     Z         straightness   X               EXZ (a displacement read along X too)
    #     Z         angle          about Y         EBZ
    #     X and Z   displacement   their path      a diagonal
    letter, *more = _moving(recording, refuse)
    if more:
        return _diagonal(recording, [letter, *more], vector, refuse)
    direction = _along(letter, vector, refuse)
    component, notices = _component(recording.quantity, direction, letter, refuse)
    if f"approach_{letter}" not in recording.columns:
        notices += (
            (
                f"no column approach_{letter}: taken as measured in one direction, its reversal is"
                " not known"
            ),
        )
    run = recording.columns.get("run", np.ones(len(recording)))
    return Series(
        component, letter, recording.file, recording.position(letter), recording.approach(letter),
        # read towards - of an axis: the sign is turned here, once, and nowhere after it
        run, recording.reading * np.sign(vector[direction]), recording.lines,
        {x: float(np.mean(recording.position(x))) for x in recording.axes if x != letter},
        recording.u, recording.head, recording.columns, notices + recording.notices,
    )  # fmt: skip


def _moving(recording: Recording, refuse: Refuse) -> list[str]:
    """The axes that move, one at least. Raises CalibrationError."""
    span = {x: float(np.ptp(recording.position(x))) for x in recording.axes}
    moving = [x for x, s in span.items() if s > REST]
    if not moving:
        raise refuse(
            "no axis moves: " + ", ".join(f"{x} by {s:g}" for x, s in span.items()),
            "a component is a deviation over the travel of one axis; what stands still is drift",
        )
    return moving


def _along(letter: str, vector: dict[str, float], refuse: Refuse) -> str:
    """The axis along which a reading is taken. Raises CalibrationError for an oblique one."""
    direction = max(vector, key=lambda x: abs(vector[x]))
    if abs(vector[direction]) < ALONG:
        size = " ".join(f"{x} {v:+.3f}" for x, v in vector.items())
        raise refuse(
            f"{letter} moves and the reading is oblique (sensitive {size}): it mixes components",
            "measure along one axis; across two, use diagonals with all their axes moving",
        )
    return direction


def _component(
    kind: str, direction: str, letter: str, refuse: Refuse
) -> tuple[str, tuple[str, ...]]:
    """The component of an axis that a quantity along (about) `direction` is, and notices."""
    if kind == "angle":
        turn = XYZ.index(direction) if direction in XYZ else ROTARY.index(direction)
        return COMPONENTS[3 + turn] + letter, ()
    if direction in ROTARY:
        raise refuse(f"a {kind} along {direction}, a rotary axis", 'is quantity = "angle" meant?')
    component = COMPONENTS[XYZ.index(direction)] + letter
    if kind == "straightness" and direction == letter:
        raise refuse(
            f"straightness of {letter} along {letter} itself",
            f"along {letter} it is a displacement; else sensitive is wrong",
        )
    if kind == "displacement" and direction != letter and letter in XYZ:
        return component, (
            f"a displacement across {letter} is a straightness: taken as {component}",
        )
    return component, ()


def _diagonal(
    recording: Recording, moving: list[str], vector: dict[str, float], refuse: Refuse
) -> Diagonal:
    """Several axes moving in proportion, read along their common direction."""
    both = " and ".join(moving)
    if set(moving) & set(ROTARY):
        raise refuse(
            f"{both} move together", "a component needs one axis moving and the others at rest"
        )
    places = np.stack([recording.position(x) for x in moving])
    centred = places - places.mean(axis=1, keepdims=True)
    # the first left singular vector: cosines of the line that all places lie on
    along = np.linalg.svd(centred, full_matrices=False)[0][:, 0]
    beside = np.linalg.norm(centred - np.outer(along, along @ centred), axis=0)
    if beside.max() > STRAIGHT:
        line = int(recording.lines[int(np.argmax(beside))])
        raise refuse(
            f"{both} move, and not along one straight line (line {line} lies {beside.max():.3g} mm"
            " beside it)",
            "a component needs one axis moving and the others at rest, a diagonal all of them in"
            " proportion",
        )
    sensitive = np.array([vector.get(x, 0.0) for x in moving])
    cosine = float(along @ sensitive)
    if (
        recording.quantity != "displacement"
        or abs(cosine) < ALONG
        or not vector.keys() <= set(moving)
    ):
        raise refuse(
            f"{both} move together, and the {recording.quantity} is read at"
            f" {np.degrees(np.arccos(min(1.0, abs(cosine)))):.1f} degrees to their path",
            "of several axes that move together only the displacement along the path is used (ISO"
            " 230-6)",
        )
    along *= np.sign(cosine)
    # the axis that goes farthest says best in which direction the diagonal was travelled
    lead = moving[int(np.argmax(np.abs(along)))]
    approach = recording.approach(lead) * np.sign(along[moving.index(lead)])
    return Diagonal(
        recording.file, dict(zip(moving, places, strict=True)),
        dict(zip(moving, map(float, along), strict=True)), approach, recording.reading,
        recording.lines,
        {x: float(np.mean(recording.position(x))) for x in recording.axes if x not in moving},
    )  # fmt: skip


def unit_of(component: str) -> tuple[str, float]:
    """Unit in which a component is shown, and what one of it is in mm or rad."""
    return ("urad", 1e-6) if component[:2] in COMPONENTS[3:] else ("um", UM)


def place_name(letter: str) -> str:
    """Unit of an axis' positions."""
    return "deg" if letter in ROTARY else "mm"
