"""What options of `gcomp simulate` name, looked up: effects, forces, channels."""

from __future__ import annotations

import argparse
from types import ModuleType

from postproc import effects
from postproc.commands import values
from postproc.errors import UsageError
from postproc.machine.model import Machine
from postproc.simulate.actual import Term


def term(word: str, machine: Machine) -> Term:
    """An effect from "backlash:X:size_um=9"."""
    name, _, rest = word.partition(":")
    axis, _, text = rest.partition(":")
    if name not in effects.names():
        raise UsageError(f"there is no effect {name!r}", f"effects: {', '.join(effects.names())}")
    module = effects.load(name)
    number = {"all": 0, "axis": 1, "pair": 2}[module.PER]
    good = (
        len(axis) == number
        and len(set(axis)) == number
        and all(x in machine.axes and x in "XYZ" for x in axis)
    )
    if not good:
        like = {0: "", 1: "X", 2: "XZ"}[number]
        raise UsageError(
            f"--with {word}: {axis!r} is not what {name} acts on",
            f"like {name}:{like}:...; axes: {' '.join(machine.letters)}",
        )
    return Term(module, axis, _parameters(word, module, text))


def _parameters(word: str, module: ModuleType, text: str) -> dict[str, float]:
    """An effect's parameters, from "size_um=9,..."."""
    parameters = dict(getattr(module, "OPTIONAL", {}))
    for item in filter(None, text.split(",")):
        key, _, value = item.partition("=")
        if key not in module.PARAMETERS:
            settings = "; ".join(f"{k} ({v})" for k, v in module.PARAMETERS.items())
            name = word.partition(":")[0]
            raise UsageError(f"--with {word}: {name} has no {key!r}", f"its parameters: {settings}")
        try:
            parameters[key] = values.number(value)
        except argparse.ArgumentTypeError as error:
            raise UsageError(f"--with {word}: {key}: {error}", module.PARAMETERS[key]) from None
        if high := effects.too_high(module, key, parameters[key]):
            raise UsageError(f"--with {word}: {high}", module.PARAMETERS[key])
        if (known := effects.of_axes(module, key)) and parameters[key] not in known:
            raise UsageError(
                f"--with {word}: {key} = {value} is no number of an axis", module.PARAMETERS[key]
            )
    if missing := [key for key in module.PARAMETERS if key not in parameters]:
        raise UsageError(f"--with {word}: {missing[0]} is missing", module.PARAMETERS[missing[0]])
    return parameters


def forces(
    given: list[tuple[str, tuple[float, ...]]], machine: Machine
) -> dict[str, tuple[float, ...]]:
    """Axis to N, of each run in turn. Raises UsageError for an axis that the machine has not."""
    for axis, _ in given:
        if axis not in machine.axes:
            raise UsageError(
                f"--force names {axis}, which is no axis of {machine.name}",
                f"its axes are {' '.join(machine.letters)}",
            )
    return dict(given)


def without(text: str, channels: dict) -> tuple[str, ...]:
    """Names of the channels that --without names, T for all temperatures. Raises UsageError."""
    wanted = [word.strip() for word in text.split(",") if word.strip()]
    found: list[str] = []
    for word in wanted:
        some = [c for c in channels if c == word or (word == "T" and c.startswith("T_"))]
        if not some:
            raise UsageError(
                f"--without {word}: there is no such channel", f"channels: {', '.join(channels)}"
            )
        found += some
    return tuple(found)
