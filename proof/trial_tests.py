"""Whether a test that an answer asks for would show what a blind test hides: its program is written
by the tool, run by the tool's simulator, and what was visited is looked at. The numbers of the
readings are not."""

from __future__ import annotations

import re
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from proof.trial_run import gcomp

LEADS = (5.0, 10.0)  # mm, of the screws whose multiples are the targets
PHASES = 0.3  # of a lead: wider gaps between the phases that are visited leave it open
APART = 20.0  # mm between two arms


def asked(test: str) -> str | None:
    """The experiment of a next_test, as `gcomp simulate --test` takes it."""
    found = re.search(r"gcomp simulate --test (\S+)", test)
    return found[1] if found else None


def shows(blind: dict[str, Any], test: str, machine: Path) -> bool:
    """Whether the test shows the suspects of a blind spot on this machine."""
    experiment = asked(test)
    if experiment is None:
        return False
    with tempfile.TemporaryDirectory() as folder:
        program, recording = Path(folder) / "p.nc", Path(folder) / "r.csv"
        status, _ = gcomp(
            "simulate",
            "--test",
            experiment,
            "--machine",
            str(machine),
            "--program-out",
            str(program),
            "-o",
            str(recording),
            "--quiet",
        )
        if status or not program.is_file() or not program.stat().st_size or not recording.is_file():
            return False
        head, columns = table(recording.read_text())
    return seen(blind, head, columns)


def table(text: str) -> tuple[str, dict[str, np.ndarray]]:
    """Head and columns of a recording."""
    lines = text.splitlines()
    head = "\n".join(line for line in lines if line.startswith("#"))
    names, *rows = (line.split(",") for line in lines if line and not line.startswith("#"))
    return head, {name: np.array([row[i] for row in rows]) for i, name in enumerate(names)}


def seen(blind: dict[str, Any], head: str, columns: dict[str, np.ndarray]) -> bool:
    """Whether a recording of this form would tell the suspects from nothing and from each other."""
    axis = blind["suspects"][0].partition(":")[2]
    at = {n[0]: c.astype(float) for n, c in columns.items() if re.fullmatch(r"[XYZ](_cmd)?_mm", n)}
    if blind["spot"] == "one_sense":
        if "sense" in columns and set(axis) <= set(at):
            return len(set(columns["sense"])) == 2
        # a diagonal at rest
        return "approach_X" in columns and all(x in at and np.ptp(at[x]) > APART for x in axis)
    if axis not in at or np.ptp(at[axis]) < 1e-3:
        return False
    if blind["spot"] == "lead_multiples":
        return np.ptp(at[axis]) >= 2 * min(LEADS) and all(
            _widest(at[axis] / lead) <= PHASES for lead in LEADS
        )
    if blind["spot"] == "one_direction":
        if f"approach_{axis}" in columns:
            return {"1", "-1"} <= set(columns[f"approach_{axis}"])
        step = np.sign(np.diff(at[axis]))
        return bool((step > 0).any() and (step < 0).any())
    if 'quantity = "angle"' in head:
        return True
    others = [np.ptp(v) for x, v in at.items() if x != axis]
    return max(others, default=0.0) >= APART


def _widest(turns: np.ndarray) -> float:
    """The widest gap between the phases, in turns."""
    phase = np.unique(np.round(turns % 1.0, 6))
    return float(np.diff(np.r_[phase, phase[0] + 1.0]).max())
