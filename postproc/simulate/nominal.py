"""Readings of a corrected program against the targets of the nominal one, as at a machine.

The corrected program commands the slides beside its targets so that the tool comes to them.
Captures belong together by their order, since a correction adds motions, and no rest.
"""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from postproc.errors import GcompError
from postproc.simulate.instruments import Settings, Signal

PLACE = re.compile("run|.*_(mm|deg)|approach_.*")  # columns that say where and when
FARTHEST = 1.0  # mm between a target and its command: twice the usual max_correction
AIMS = {"displacement": "along", "straightness": "across", "angle": "about"}


def aimed(settings: Settings, nominal: Signal) -> Settings:
    """The settings with the nominal program's direction where none is said: a corrected one
    leans."""
    name = AIMS.get(str(nominal.head.get("quantity")), "")
    if not name or name in settings.given:
        return settings
    words = ",".join(f"{x}{v + 0.0:.12f}" for x, v in nominal.head["sensitive"].items())
    return Settings(settings.instrument, settings.known, {**settings.given, name: words})


def against(signal: Signal, nominal: Signal) -> Signal:
    """The signal on the places, sides of approach and runs of the nominal one.

    Raises GcompError where the programs do not rest equally often, or at other targets; what is no
    capture at rest has no targets.
    """
    if signal.kind != "targets" or nominal.kind != "targets":
        raise GcompError(
            f"a {signal.kind} has no targets of its own",
            "--nominal is for captures at rest (laser, straightness, angle); a ballbar reads"
            " against its circle anyway",
        )
    # rest for rest: a corrected program has more motions and as many dwells
    n, wanted = len(signal.columns["run"]), len(nominal.columns["run"])
    if n != wanted:
        raise GcompError(
            f"the program rests at {n} targets, and the nominal one at {wanted}",
            "was it corrected from another program?",
        )
    columns = dict(signal.columns)
    # reading_um or reading_urad
    reading = next(name for name in columns if name.startswith("reading_"))
    shift = _shift(signal, nominal)
    columns |= {
        name: values
        for name, values in nominal.columns.items()
        if name in columns and PLACE.fullmatch(name)
    }
    if signal.head["quantity"] != "angle":
        # reading against the command + (command - target) = actual - target; um
        columns[reading] = columns[reading] + shift * 1e3
    return replace(signal, columns=columns)


def _shift(signal: Signal, nominal: Signal) -> np.ndarray:
    """(N,) mm along the reading's direction from the nominal targets to the signal's. Raises
    GcompError where they lie too far apart."""
    columns = signal.columns
    shift = np.zeros(len(columns["run"]))
    for name in [c for c in columns if c in ("X_mm", "Y_mm", "Z_mm", "A_deg", "B_deg", "C_deg")]:
        away = columns[name] - nominal.columns[name]
        worst = int(np.argmax(np.abs(away)))
        if abs(away[worst]) > FARTHEST:
            raise GcompError(
                f"capture {worst + 1} lies {abs(away[worst]):.4g} mm beside the nominal one in"
                f" {name[0]}",
                "was it corrected from another program, or do the runs differ?",
            )
        shift += signal.head["sensitive"].get(name[0], 0.0) * away
    return shift
