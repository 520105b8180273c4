"""What the uncertainty rests on, said where it rests on little."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator

import numpy as np

from postproc.calibrate import Finding
from postproc.calibrate.assign import unit_of
from postproc.calibrate.calibration import Calibration


def check(calibration: Calibration) -> Iterator[Finding]:
    by_base: dict[tuple[bool, bool], list[str]] = defaultdict(list)
    for name, component in calibration.measured.items():
        stated = any(s.u is not None for s in component.series)
        by_base[stated, bool(component.cells.scatter.known)].append(name)
    if unknown := by_base[False, False]:
        text = (
            f"{', '.join(unknown)}: one run and no u_um in the head, so the uncertainty is not"
            " known, nor whether they stand out of it"
        )
        yield Finding("scatter", "doubt", "", text, {"components": len(unknown)})
    for name in by_base[True, False]:
        unit, one = unit_of(name)
        text = (
            f"{name}: one run, so u is the instrument's alone,"
            f" {calibration.measured[name].largest_u / one:.2g} {unit}"
        )
        yield Finding("scatter", "note", name, text)
    if many := by_base[False, True]:
        text = (
            f"{', '.join(many)}: no u_um in the head, so u is the scatter of the runs alone,"
            " without the instrument's part"
        )
        yield Finding("scatter", "note", "", text)
    yield from _of_components(calibration)


def _of_components(calibration: Calibration) -> Iterator[Finding]:
    """Readings that were filled in, and scatter that differs between targets."""
    for name, component in calibration.measured.items():
        for _, k in component.filled:
            text = (
                f"{name} has no reading at {component.letter} = {component.nodes[k]:g} in one"
                " direction: filled from its neighbours"
            )
            yield Finding("filled", "note", name, text, {"node": float(component.nodes[k])})
        if component.cells.scatter.known and not component.cells.scatter.pooled:
            s = component.cells.s[np.isfinite(component.cells.s)] / unit_of(name)[1]
            text = (
                f"{name}: s differs between targets more than chance makes ({s.min():.2g} to"
                f" {s.max():.2g} {unit_of(name)[0]}), so each has its own, with the larger factor"
                " of its few runs"
            )
            yield Finding(
                "scatter", "note", name, text, {"least": float(s.min()), "largest": float(s.max())}
            )
