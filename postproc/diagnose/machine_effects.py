"""What of a diagnosis goes into a machine: the accepted effects of the machine that are told apart
from others, as sections of machine.toml."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from postproc import effects
from postproc.diagnose.answer import Diagnosis, Finding
from postproc.effects import sizes
from postproc.errors import UsageError
from postproc.machine import edit, effect_file
from postproc.machine.model import Machine

SHORTEST = 1.0  # mm: of a range


# Whole: three lists of findings, each with its conditions.
def written(d: Diagnosis, accept: tuple[str, ...]) -> tuple[list[Finding], list[Finding]]:
    """Effects of the machine that go into a written machine, and those that do not: another name
    explains the readings as well and would do something else to a program. accept: names
    (effect:axis) that are written all the same. Raises UsageError for a name that was not found."""
    able = [
        f
        for f in d.findings
        if f.status == "accepted"
        and f.block.module.KIND == "machine"
        and hasattr(f.block.module, "coefficients")
    ]
    for name in accept:
        if name not in [f.block.key for f in able]:
            known = ", ".join(f.block.key for f in able) or "none"
            raise UsageError(
                f"--accept {name}: no such effect is accepted",
                f"accepted effects of the machine: {known}",
            )
    # What stands in a machine's file corrects programs. So a name that is likely is not enough: no
    # other may correct otherwise, its size must differ from zero, its curve must hold between
    # targets.
    sure = [
        f
        for f in able
        if f.predictive
        and not f.aliases
        and not _happened(f)
        and _sized(f)
        and all(_same_use(f, name) for name in f.equivalent)
    ]
    out = [f for f in able if f.block.key not in accept and f not in sure]
    return [f for f in able if f not in out], out


def _sized(f: Finding) -> bool:
    """Whether one of its fitted sizes at least is told from zero: several that only their sum tells
    correct nothing one by one."""
    # a parameter of exactly 0 was not fitted
    ends = [f.ci95[name] for name in sizes(f.block.module) if f.value[name]]
    return not ends or any(low > 0.0 or high < 0.0 for low, high in ends)


def _happened(f: Finding) -> bool:
    """Whether it was in one recording alone, or at moments of these: their numbers and times are
    those of other recordings in the next experiment."""
    return f.value.get("file", -1.0) >= 0.0 or "t_s" in f.value


def _same_use(f: Finding, name: str) -> bool:
    """Whether it does a program no harm to take a finding for what another name says: not where the
    recording may be at fault and the machine in order, nor where it may be the same effect of
    another axis."""
    effect, _, axis = name.partition(":")
    if f.block.module.USE != "compensate":
        return True  # no program is corrected by it, whatever its name
    at_fault = effect in effects.names() and effects.load(effect).KIND != "machine"
    return not at_fault and (effect != f.block.name or axis == f.block.axis)


def not_told_apart(d: Diagnosis, accept: tuple[str, ...]) -> list[str]:
    """A sentence for each effect that does not go into a written machine, or goes into it although
    other names explain the readings as well."""
    kept, out = written(d, accept)
    said = [f"{f.block.key} is NOT written: {_not_sure(f)}, or --accept {f.block.key}" for f in out]
    return said + [
        f"{f.block.key} is written, and {_keys(f.equivalent)} would explain these readings as"
        " well: run the test that tells them apart before a part is cut"
        for f in kept
        if f.equivalent
    ]


def _keys(names: Iterable[str]) -> str:
    """Names as --accept takes them; an effect of no axis without its colon."""
    return ", ".join(name.removesuffix(":") for name in names)


def _not_sure(f: Finding) -> str:
    """Why a finding does not go into a written machine, and the way out."""
    if not f.predictive:
        return (
            "its curve does not predict targets that are left out of its fit; measure at more"
            " targets"
        )
    if f.aliases:
        return (
            f"its period is one of {len(f.aliases) + 1} that these targets show alike, and each"
            " corrects otherwise between them; measure at uneven distances"
        )
    if _happened(f):
        return "it happened in these recordings, and would be taken to happen in the next ones too"
    if not _sized(f):
        return "none of its sizes differs from zero; record again with more readings"
    return (
        f"{_keys(f.equivalent)} would explain these readings as well, and correct a program"
        " otherwise; run the test that tells them apart"
    )


def _half_widths(f: Finding) -> dict[str, float]:
    """U (95 %) of the parameters that have a size and were fitted: to the farther end of the
    interval."""
    found = {}
    for name in sizes(f.block.module):
        value, (low, high) = f.value[name], f.ci95[name]
        # of an interval that is not symmetric: U is one number, and the farther end is on the safe
        # side
        half = max(high - value, value - low)
        # else the parameter was not fitted
        if math.isfinite(half) and half > 1e-9 * max(abs(value), 1e-12):
            found[name] = float(f"{half:.3g}")
    return found


def _range(d: Diagnosis, f: Finding) -> tuple[float, float] | None:
    """mm: from where to where of its axis readings told an effect that is a curve over it."""
    module = f.block.module
    # A polynomial says nothing beyond the readings that told it; the compensator holds it level
    # there.
    curve = hasattr(module, "tables") or hasattr(module, "arm_tables")
    if not curve or "degree" not in module.PARAMETERS:
        return None  # a line, a gap, a wave go on as they are
    moving = module.moving(f.block.axis, **f.value) if module.PER == "pair" else f.block.axis
    informative = np.any(f.block.columns != 0, axis=1) & ~d.held
    place = d.rows.state.position[moving][informative]
    low, high = round(float(place.min()), 4), round(float(place.max()), 4)
    return (low, high) if high - low > SHORTEST else None


def with_effects(d: Diagnosis, accept: tuple[str, ...]) -> Machine:
    """The machine that `effects_toml` writes: the one that was judged, with the effects that go
    into it."""
    terms = [
        effect_file.term(f.block.name, f.block.axis, dict(f.value), d.machine.axes, _range(d, f))
        for f in written(d, accept)[0]
    ]
    return replace(d.machine, effects=(*d.machine.effects, *terms))


def effects_toml(d: Diagnosis, name: str, accept: tuple[str, ...]) -> Callable[[str], str]:
    """What makes a machine.toml that of the diagnosed machine: its name, and a section for every
    accepted effect of the machine that is told apart from others (or in accept). Instruments' and
    data's effects are none of it."""
    sections = []
    for f in written(d, accept)[0]:
        section: dict[str, Any] = {"name": f.block.name, "axis": f.block.axis, **f.value}
        section |= {f"u_{key}": u for key, u in _half_widths(f).items()}
        if measured := _range(d, f):
            section["measured_mm"] = list(measured)
        section["source"] = f"diagnosed from {', '.join(Path(r.file).name for r in d.recordings)}"
        names = ", ".join(f.equivalent)
        sections.append(
            (
                section,
                (
                    f"not told apart from {names}: run the test that parts them before a part"
                    " is cut"
                    if names
                    else ""
                ),
            )
        )
    return lambda text: edit.with_sections(text, name, "effect", sections)
