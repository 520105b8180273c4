"""What repeats with every turn of the screw is invisible where all targets lie at the same angle of
the screw."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from postproc.calibrate import Finding
from postproc.calibrate.calibration import Calibration

# length of the mean of unit vectors at the targets' angles: 1 where all are the same
SAME_ANGLE = 0.95


def _positionings(calibration: Calibration) -> list[str]:
    """The axes whose positioning was measured."""
    components = calibration.components.items()
    return [c.letter for n, c in components if n == f"E{c.letter}{c.letter}"]


def check(calibration: Calibration) -> Iterator[Finding]:
    for letter, lead in calibration.options.leads.items():
        component = calibration.measured.get(f"E{letter}{letter}")
        if component is None:
            continue
        # each target as a hand of a clock; twice: half turns, where a second harmonic hides
        # (iso/positioning.py)
        phase = 2 * np.pi * component.nodes / lead
        alike = float(np.abs(np.exp(1j * phase).mean()))
        twice = float(np.abs(np.exp(2j * phase).mean()))
        spacing = float(np.median(np.diff(component.nodes)))
        numbers = {"lead_mm": lead, "spacing_mm": spacing, "alike": alike}
        text = f"{component.name}: targets every {spacing:g} mm"
        if alike > SAME_ANGLE:
            text += (
                f" are whole turns of the screw ({lead:g} mm): its cyclic error is invisible. Add a"
                " part of the lead to each target (ISO 230-2), or a fine run over two turns"
            )
            yield Finding("lead", "doubt", component.name, text, numbers)
        elif twice > SAME_ANGLE:
            text += (
                f" are half turns of the screw ({lead:g} mm): its cyclic error shows in part only,"
                " and as a zigzag"
            )
            yield Finding("lead", "doubt", component.name, text, numbers)
        elif spacing > lead / 2:
            text += (
                f" are further apart than half the lead ({lead:g} mm): its cyclic error looks like"
                " scatter between targets, and the table does not correct it"
            )
            yield Finding("lead", "note", component.name, text, numbers)
    known = calibration.options.leads
    asked = [x for x in _positionings(calibration) if x in "XYZ" and x not in known]
    if asked:
        text = (
            f"lead of the screw of {', '.join(asked)} not said (--lead {asked[0]}=5): whether the"
            " targets hide its cyclic error is not looked at"
        )
        yield Finding("lead", "note", "", text)
