"""How forms of effects and aliens are written down, and what they give."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from .base import Array, Fields, Rng, log_uniform
from .case import Case
from .recordings import Recording

Field = Callable[[Recording], Fields]


@dataclass
class Hidden:
    """A drawn shape. field: um for size 1, by channel; least, most: sizes that physics allows;
    after: what else of a recording changes, with the size that was taken."""

    field: Field
    after: Callable[[Recording, float], None] | None = None
    most: float = math.inf
    least: float = 0.0


Draw = Callable[[Case, Rng], Hidden]


@dataclass(frozen=True)
class Form:
    """A textbook form of an effect (or of an alien, which has no name). about: what its axis is:
    `axis` or `other` of the case, `pair`, or "" where it has none."""

    effect: str
    name: str
    plans: tuple[str, ...]
    draw: Draw
    about: str = "axis"

    def axis(self, c: Case) -> str:
        return getattr(c, self.about) if self.about else ""


FORMS: dict[str, list[Form]] = {}
ALIENS: list[Form] = []
# what an effect must be told from: shapes of each recording
NUISANCES: dict[str, Callable[[Case, Recording], list[Fields]]] = {}


def form(effect: str, plans: str, about: str = "axis") -> Callable[[Draw], Draw]:
    """Writes down a form; its docstring is its name."""

    def add(draw: Draw) -> Draw:
        known = Form(effect, _name(draw), tuple(plans.split()), draw, about)
        FORMS.setdefault(effect, []).append(known)
        return draw

    return add


def alien(plans: str) -> Callable[[Draw], Draw]:
    """Writes down physics that the contract has no name for."""

    def add(draw: Draw) -> Draw:
        ALIENS.append(Form("", _name(draw), tuple(plans.split()), draw, ""))
        return draw

    return add


def _name(draw: Draw) -> str:
    return " ".join((draw.__doc__ or "").split())


def along(axis: str, value: Callable[[Recording], Any], **more: Any) -> Hidden:
    """A deviation along one axis, um."""
    return Hidden(lambda rec: rec.project({axis: value(rec)}), **more)


def moved(value: Callable[[Recording], Mapping[str, Any]]) -> Hidden:
    """A deviation in several directions, um."""
    return Hidden(lambda rec: rec.project(value(rec)))


def read(value: Callable[[Recording], Any], **more: Any) -> Hidden:
    """A change of the reading alone, um."""
    return Hidden(lambda rec: {"r": value(rec)}, **more)


def with_current(axis: str, r: Rng, value: Callable[[Recording], Array]) -> Hidden:
    """A deviation by a force against the loop's stiffness: the drive's current pays for it."""
    gain = log_uniform(r, 0.05, 0.2)  # A for 1 um

    def after(rec: Recording, size: float) -> None:
        if axis in rec.current:
            y = rec.project({axis: value(rec)})[axis]
            rec.current[axis] = rec.current[axis] - size * y * gain

    return along(axis, value, after=after)
