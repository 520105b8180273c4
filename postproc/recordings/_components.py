"""What was measured at targets, and in which unit: a component by its name in ISO 230-1, from what
the file says and what the options say.

What neither says is asked for.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from postproc.errors import Place, UsageError
from postproc.recordings import AXES, ReadingOptions, RecordingError, Source
from postproc.recordings import _units as units
from postproc.recordings._units import ANGLE, LENGTH, Unit

#     E  X  Z      E  B  Z
#     |  |  |         |
#     |  |  axis      rotation about Y
#     |  direction
#     error, actual - commanded
LINEAR, ROTARY = "XYZ", "ABC"
TURNS = dict(zip(ROTARY, LINEAR, strict=True))
COMPONENT = re.compile(r"E([XYZABC])([XYZABC])")
SOME_UNITS = {LENGTH: "um, mm", ANGLE: "urad, mm/m, arcsec"}
QUANTITY_OF = {"displacement": LENGTH, "straightness": LENGTH, "angle": ANGLE}


@dataclass(frozen=True)
class Component:
    """What was measured: EXZ is the deviation along X while Z moves; EBZ the rotation about Y.
    Names of ISO 230-1."""

    name: str
    axis: str
    quantity: str
    sensitive: dict[str, float]

    @property
    def position(self) -> str:
        """The column of the axis' position."""
        return f"{self.axis}_{'mm' if self.axis in LINEAR else 'deg'}"


def _named(name: str, axis: str, quantity: str, file: str) -> Component:
    """The component of --component. Raises UsageError where --axis or the file contradict it."""
    component = parsed(name)
    if axis and axis != component.axis:
        raise UsageError(
            f"--axis {axis} and --component {component.name} contradict each other",
            f"{component.name} belongs to the axis {component.axis}",
        )
    if quantity and component.quantity != quantity:
        raise UsageError(
            f"{component.name} is {article(component.quantity)}, and {file} holds"
            f" {article(quantity)}"
        )
    return component


def component_of(
    options: ReadingOptions, source: Source, axis: str = "", quantity: str = "", where: int = 1
) -> Component:
    """What was measured, from the options and from what the file says of axis and quantity (as far
    as it does).

    Raises UsageError where options contradict each other or name no component; RecordingError with
    the option that is missing where it stays open.
    """
    axis_stated = options.axis.strip().upper()
    if axis_stated not in ("", *AXES):
        raise UsageError(f"--axis {options.axis} is no axis letter", f"one of {' '.join(AXES)}")
    if options.component:
        return _named(options.component, axis_stated, quantity, source.name)
    axis = axis_stated or axis
    place = Place(source.name, where)
    if not axis:
        raise RecordingError(
            "the file does not say which axis moved",
            "say --axis Z, or what was measured, like --component EXZ",
            place,
        )
    # one component only: EZZ of a line, ECC of a table
    if quantity == "displacement" or (quantity == "angle" and axis in ROTARY):
        return parsed(f"E{axis}{axis}")
    directions = {"straightness": LINEAR.replace(axis, ""), "angle": ROTARY}
    may = [f"E{d}{axis}" for d in directions.get(quantity, LINEAR + ROTARY)]
    what = {
        "straightness": "in which direction the straightness of",
        "angle": "about which axis the rotation of",
    }.get(quantity, "what of")
    raise RecordingError(
        f"the file does not say {what} {axis} was measured",
        f"say --component {' or '.join(may)}",
        place,
    )


def positioning(
    options: ReadingOptions,
    source: Source,
    axis: str,
    said: Unit | None,
    where: int,
    notices: list[str],
) -> Component:
    """What a table measured that names its axis at most: what --component says, or else the
    positioning of the axis.

    said: the unit in the file; angles of a linear axis can not be its positioning. Raises as
    `component_of`.
    """
    if options.component:
        return component_of(options, source, axis, "", where)
    unit = units.named(options.unit) if options.unit else said
    quantity = "angle" if unit is not None and unit.quantity == ANGLE else "displacement"
    component = component_of(options, source, axis, quantity, where)
    notices.append(
        f"taken as {component.name}, the positioning of {component.axis} (--component where it was"
        " straightness or an angle)"
    )
    return component


def parsed(name: str) -> Component:
    """A component by its name in ISO 230-1. Raises UsageError for a name that is none."""
    found = COMPONENT.fullmatch(name.strip().upper())
    if found is None:
        raise UsageError(
            f"{name!r} is no component that is recorded at targets",
            "E, then the direction X Y Z or rotation A B C, then the axis that moves: EZZ,"
            " EXZ, EBZ",
        )
    direction, axis = found[1], found[2]
    if direction in ROTARY:
        return Component(found[0], axis, "angle", {TURNS[direction]: 1.0})
    return Component(
        found[0], axis, "displacement" if direction == axis else "straightness", {direction: 1.0}
    )


def article(quantity: str) -> str:
    """The quantity as a noun."""
    return {
        "displacement": "a displacement",
        "straightness": "a straightness",
        "angle": "an angle",
    }[quantity]


def axis_in(text: str) -> str:
    """The one axis letter that stands alone in a free text ("Z", "X-axis", "Achse Y"), or
    nothing."""
    found = {
        m.upper() for m in re.findall(r"(?<![A-Za-z])([XYZABCxyzabc])(?:[0-9])?(?![A-Za-z])", text)
    }
    return found.pop() if len(found) == 1 else ""


def unit_for(
    options: ReadingOptions,
    source: Source,
    component: Component,
    said: Unit | None = None,
    where: int = 1,
) -> Unit:
    """The unit of the readings: what the file says, or the options do.

    Raises RecordingError where neither does, and UsageError where they differ, or where it is not
    one of this component.
    """
    kind = QUANTITY_OF[component.quantity]
    # Of two that differ neither is taken: a factor of 25.4 or 1000 looks like a machine.
    stated = units.named(options.unit) if options.unit else None
    if stated and said and stated.factor != said.factor:
        raise UsageError(
            f"{source.name} says that its readings are in {said.name}, and --unit says"
            f" {stated.name}",
            "leave --unit out, or mend the file where it is wrong",
        )
    unit = stated or said
    if unit is None:
        raise source.fault(
            where,
            "the file does not say in which unit its readings are",
            f"say it: --unit with one of {SOME_UNITS[kind]}",
        )
    if unit.quantity != kind:
        what = article(component.quantity)
        of = "angles" if unit.quantity == ANGLE else "lengths"
        text = f"{component.name} is {what}, and {unit.name} is a unit of {of}"
        if stated:
            raise UsageError(text, "another --unit, or another --component")
        raise source.fault(where, text, "say what was measured: --component")
    return unit
