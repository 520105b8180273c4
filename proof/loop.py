"""The loop closed: a program is corrected by the user's map alone and by the diagnosed machine, and
both run through the true one.

The true machine is the generator's: its geometry, and the effects that were hidden. The corrected
programs are read by the independent interpreter of tests/reference. Nothing of the tool takes part
but its command line.

From which side an axis came is told by the commanded motion, for the map's own columns and where
forward lies beyond reverse; a slide with dead travel follows its command as a play does, and rests
until that is taken up. Sliders that
give way (windup) are followed through every commanded point.
"""

from __future__ import annotations

import re
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from proof.generator import cases
from proof.generator.machines import XYZ, Machine
from proof.generator.tracks import Sweep, Track
from proof.trial_run import gcomp

# effects that a place, and the way to it, decide: what a program can be corrected for beforehand
PLACED = {
    "scale",
    "pitch_shape",
    "backlash",
    "backlash_position",
    "windup",
    "cyclic",
    "squareness",
    "bow",
    "abbe",
    "sag",
}
HYSTERESIS = 0.0011  # mm
STEP = 1.0  # mm between samples
POINTS, DIAGONAL = 31, 13
SETTLING = 3  # motions before every axis has turned


@dataclass
class Looped:
    """Largest path error in um: of the program as it is, corrected by the map alone, by the
    diagnosed machine; limit: what the map alone leaves where nothing is hidden (its own error, and
    the tolerance). note: why diagnosed is that of the map alone."""

    case: str
    truth: list[str]
    uncompensated: float
    geometry: float
    diagnosed: float
    limit: float = 0.0
    note: str = ""

    @property
    def ratio(self) -> float:
        return self.diagnosed / self.geometry


def program(machine: Machine) -> tuple[str, np.ndarray]:
    """A test piece in G1: every axis there and back in unequal steps, every pair on a diagonal
    there and back. The text and the (K, 3) ends of its motions, slide positions in mm."""
    rest = np.array([machine.axes[x].share(0.47) if x in machine.axes else 0.0 for x in XYZ])
    indices = [XYZ.index(x) for x in machine.axes]
    ends = [rest.copy(), rest.copy(), rest.copy()]
    for i in indices:  # every axis turns once before anything counts
        ends[1][i] += 8.0
    for group in [(i,) for i in indices] + [(i, j) for i in indices for j in indices if i < j]:
        u = np.linspace(0.1, 0.9, POINTS if len(group) == 1 else DIAGONAL)
        u[1:-1] += 0.007 * np.sin(2.4 * np.arange(1, len(u) - 1) ** 2)
        line = np.tile(rest, (len(u), 1))
        for i in group:
            line[:, i] = [machine.axes[XYZ[i]].share(float(v)) for v in u]
        ends += [*line, *line[-2::-1]]
    points = np.array(ends)
    lines = ["G21 G90 G94 G17 G54" if machine.form == "mill" else "G21 G90 G94 G18 G54", "F600"]
    if machine.form != "mill":
        lines.insert(1, "G8")
    for k, point in enumerate(points):
        lines.append(
            f"N{k + 1} G1 " + " ".join(f"{x}{point[XYZ.index(x)]:.4f}" for x in machine.axes)
        )
    return "\n".join([*lines, "M30"]) + "\n", points


def corrected(text: str, folder: Path) -> tuple[str | None, str]:
    """The program as gcomp corrects it for the machine in `folder`; None and what it said where it
    refuses."""
    with tempfile.TemporaryDirectory() as place:
        source, target = Path(place) / "p.ngc", Path(place) / "c.ngc"
        source.write_text(text)
        status, said = gcomp(
            "compensate",
            "--machine",
            str(folder),
            "--dialect",
            "linuxcnc",
            str(source),
            "-o",
            str(target),
        )
        if status or not target.is_file():
            # what is kept of a trial names no folder of the computer that it ran on
            for path in (folder.resolve(), folder):
                said = said.replace(str(path), folder.name)
            return None, said.replace(f"{place}/", "").strip()[-300:]
        return target.read_text(), ""


def commanded(text: str, machine: Machine) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(N, 3) commanded points along a program, (N,) the number of the nominal motion (its N word),
    (N,) whether the point is the end of an output block."""
    from tests.reference import interpreter

    letters = list(machine.axes)
    zero = {"G54": dict.fromkeys(letters, 0.0)}
    diameter = () if machine.form == "mill" else ("X",)
    number, of_line = 0, {}
    for k, line in enumerate(text.splitlines(), start=1):
        word = re.match(r"\s*N(\d+)", line)
        number = int(word[1]) if word else number
        of_line[k] = number
    points, motion, last = [], [], []
    for block in interpreter.run(text, "linuxcnc", axes=letters, diameter=diameter, offsets=zero):
        if block.kind not in ("feed", "rapid"):
            continue
        end = _vector(block.end)
        start = _vector(block.start) if block.known else end
        n = max(1, int(np.ceil(np.linalg.norm(end - start) / STEP)))
        for k in range(1, n + 1):
            points.append(start + (end - start) * k / n)
            motion.append(of_line[block.line])
            last.append(k == n)
    return np.array(points), np.array(motion), np.array(last)


def _vector(place: dict) -> np.ndarray:
    return np.array([float(place.get(x) or 0.0) for x in XYZ])


def path_error(drawn: cases.Drawn, text: str, nominal: np.ndarray) -> float:
    """um: the largest distance of the true machine's path from the nominal one: at ends of motions
    from the end, between from the line. The mean deviation of all ends is taken off first: a part
    is clamped and its zero touched on that machine, and no instrument sees a deviation that is the
    same everywhere."""
    machine = drawn.scene.machine
    points, motion, last = commanded(text, machine)
    direction = np.stack([sides(column) for column in points.T], axis=1)
    actual = points + 1e-3 * deviation(drawn, points, direction)
    end = nominal[motion - 1]
    start = nominal[np.maximum(motion - 2, 0)]
    along = end - start
    length = np.maximum(np.linalg.norm(along, axis=1), 1e-12)[:, None]
    counts = motion > SETTLING
    closes = last & (np.r_[motion[1:], -1] != motion)
    off = actual - end
    off -= off[closes & counts].mean(axis=0)
    across = off - (off * along).sum(axis=1)[:, None] / length**2 * along
    errors = np.where(closes, np.linalg.norm(off, axis=1), np.linalg.norm(across, axis=1))
    return float(errors[counts].max() * 1e3)


def sides(command: np.ndarray) -> np.ndarray:
    """(N,) direction in which a slide was last commanded to move, +1 before it has; one that goes
    back by no more than the hysteresis (and an increment, by which words are rounded) keeps it."""
    side, far, found = 1.0, float(command[0]), []
    for place in command.tolist():
        if (place - far) * side < -HYSTERESIS:
            side, far = -side, place
        elif (place - far) * side > 0:
            far = place
        found.append(side)
    return np.array(found)


def lost(command: np.ndarray, half: np.ndarray) -> np.ndarray:
    """(N,) um by which a slide is off its command (N,) um. Where half (N,) um of its lost motion is
    positive, forward short of reverse, it is dead travel. Where it is negative forward lies beyond
    reverse, as where a control takes up too much: no play does that, and the direction of the last
    command says the side, as for the map's own columns."""
    return np.where(half > 0, behind(command, np.maximum(half, 0.0)), -sides(command / 1e3) * half)


def behind(command: np.ndarray, half: np.ndarray) -> np.ndarray:
    """(N,) um by which a slide is off its command (N,) um: it rests until the command is half
    (N,) um of its dead travel away, to either side. It came from below."""
    off, found = -float(half[0]), []
    for step, most in zip(np.diff(command, prepend=command[0]), half, strict=True):
        off = float(np.clip(off - step, -most, most))
        found.append(off)
    return np.array(found)


def deviation(drawn: cases.Drawn, points: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """(N, 3) um of the true machine along a commanded path."""
    machine = drawn.scene.machine
    time = np.arange(len(points)) * 0.1
    sweep = Sweep(time, points, np.arange(len(points)), slice(0, len(points)))
    track = Track(
        "trace",
        {"sees": "tool"},
        "".join(machine.axes),
        np.ones(len(points), int),
        time,
        points,
        direction,
        sweeps=[sweep],
        force=np.zeros_like(points),
    )
    total = machine.deviation(points, direction)
    for hidden in drawn.hidden:
        effect = hidden.effect
        if effect.gap is not None:
            i = XYZ.index(effect.axis)
            half = hidden.size * effect.gap(points[:, i]) / 2
            total[:, i] += lost(points[:, i] * 1e3, half)
            continue
        shift = effect.on(track)
        if shift is not None and shift.tool is not None:
            total += hidden.size * shift.tool
    return total


def close(case: str, details: dict, folder: Path, diagnosed: Path) -> Looped:
    """The loop of one case. folder: the case; diagnosed: the machine that the tool wrote."""
    drawn = cases.draw(details["seed"], details["kind"], details["number"])
    text, nominal = program(drawn.scene.machine)
    plain = path_error(drawn, text, nominal)
    first, said = corrected(text, folder / "machine")
    if first is None:
        return Looped(
            case, _names(drawn), plain, plain, plain, note=f"the map alone is refused: {said}"
        )
    geometry = path_error(drawn, first, nominal)
    limit = path_error(replace(drawn, hidden=[]), first, nominal)
    second, said = (
        corrected(text, diagnosed) if diagnosed.is_dir() else (None, "no machine was written")
    )
    if second is None:
        return Looped(case, _names(drawn), plain, geometry, geometry, limit, said)
    return Looped(case, _names(drawn), plain, geometry, path_error(drawn, second, nominal), limit)


def _names(drawn: cases.Drawn) -> list[str]:
    return [f"{h.effect.name}:{h.effect.axis or ''}" for h in drawn.hidden]


def wanted(truth: list[dict]) -> bool:
    """Whether the loop can be closed on a case: something visible is hidden, and places decide all
    of it."""
    return (
        bool(truth)
        and all(t["effect"] in PLACED for t in truth)
        and any(t["visible"] for t in truth)
    )
