"""A map holds for the state in which it was measured: with the control's own tables at work, or
without."""

from __future__ import annotations

from collections.abc import Iterator

from postproc.calibrate import Finding
from postproc.calibrate.calibration import Calibration

STATES = ("active", "off")


def _recordings(n: int) -> str:
    return "1 recording does" if n == 1 else f"{n} recordings do"


def check(calibration: Calibration) -> Iterator[Finding]:
    states: dict[str, list[str]] = {}
    for component in calibration.measured.values():
        for series in component.series:
            word = str(series.head.get("control_tables", "")).lower()
            files = states.setdefault(word if word in STATES else "unknown", [])
            if series.file not in files:
                files.append(series.file)
    if "active" in states and "off" in states:
        text = (
            f"{states['active'][0]} was measured with the control's own tables active,"
            f" {states['off'][0]} with them off: together they describe no state of the machine"
        )
        yield Finding(
            "control-tables",
            "doubt",
            "",
            text,
            {"active": len(states["active"]), "off": len(states["off"])},
        )
    elif "active" in states:
        text = (
            "measured with the control's own tables active: this map is what they leave, and holds"
            " only while they stay as they were"
        )
        yield Finding("control-tables", "note", "", text, {"files": len(states["active"])})
    if "unknown" in states:
        text = (
            f"{_recordings(len(states['unknown']))} not say whether the control's own tables"
            ' (pitch, backlash) were at work (control_tables = "active" or "off"): the map holds'
            " for that state only"
        )
        yield Finding("control-tables", "note", "", text, {"files": len(states["unknown"])})
