"""The tool centre's path as LinuxCNC's interpreter makes it, carried through a machine's deviation:
how far it misses.

Nothing of gcomp but the machine's own deviation is used: both programs go through LinuxCNC with its
tool table, the corrected one's centre path is sampled and moved by the deviation where each slide
stands, approached as it moves.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from tests.linuxcnc.oracle import Motion

PLANES = {"XY": (0, 1), "ZX": (2, 0), "YZ": (1, 2)}
STEP = 0.05  # mm along the path
PLAY = 0.01  # mm of travel after which an axis has turned back


@dataclass
class Path:
    """point (3, N) mm of the tool centre; line (N,) in the source; move (N,) which motion."""

    point: np.ndarray
    line: np.ndarray
    move: np.ndarray


def sampled(motions: list[Motion], step: float = STEP) -> Path:
    """Feeds and arcs only, ends included."""
    points, lines, moves = [], [], []
    for k, motion in enumerate(motions):
        if motion.kind not in ("feed", "arc"):
            continue
        p = arc(motion, step) if motion.kind == "arc" else straight(motion, step)
        points.append(p)
        lines.append(np.full(p.shape[1], motion.line))
        moves.append(np.full(p.shape[1], k))
    if not points:
        return Path(np.zeros((3, 0)), np.zeros(0, int), np.zeros(0, int))
    return Path(np.concatenate(points, axis=1), np.concatenate(lines), np.concatenate(moves))


def straight(motion: Motion, step: float) -> np.ndarray:
    a, b = np.array(motion.start[:3]), np.array(motion.end[:3])
    n = max(1, int(np.ceil(np.linalg.norm(b - a) / step)))
    return a[:, None] + (b - a)[:, None] * np.linspace(0, 1, n + 1)


def arc(motion: Motion, step: float) -> np.ndarray:
    first, second = PLANES[motion.plane]
    a, b, c = np.array(motion.start[:3]), np.array(motion.end[:3]), np.array(motion.centre)
    from_, to = a[[first, second]] - c, b[[first, second]] - c
    r0, r1 = np.hypot(*from_), np.hypot(*to)
    begin, turn = np.arctan2(*from_[::-1]), np.arctan2(*to[::-1]) - np.arctan2(*from_[::-1])
    sense = np.sign(motion.turns)
    turn = (sense * turn) % (2 * np.pi)
    if turn < 1e-9:
        turn = 2 * np.pi
    turn = sense * (turn + 2 * np.pi * (abs(motion.turns) - 1))
    n = max(4, int(np.ceil(abs(turn) * max(r0, r1) / step)))
    t = np.linspace(0, 1, n + 1)
    p = a[:, None] + (b - a)[:, None] * t
    radius = r0 + (r1 - r0) * t
    p[first], p[second] = (
        c[0] + radius * np.cos(begin + turn * t),
        c[1] + radius * np.sin(begin + turn * t),
    )
    p[:, -1] = b
    return p


def approach(point: np.ndarray) -> np.ndarray:
    """(3, N) -1, 0 or +1: the way each axis came, turned back only by more than PLAY."""
    result = np.zeros(point.shape)
    for row in range(3):
        extreme, side = point[row, 0], 0.0
        for k, value in enumerate(point[row].tolist()):
            if side >= 0 and value < extreme - PLAY or side <= 0 and value > extreme + PLAY:
                side = 1.0 if value > extreme else -1.0
            extreme = (
                value
                if side == 0 and k == 0
                else (
                    max(extreme, value)
                    if side > 0
                    else min(extreme, value)
                    if side < 0
                    else extreme
                )
            )
            result[row, k] = side
    return result


def actual(path: Path, machine) -> np.ndarray:
    """(3, N) mm where the tool centre really is."""
    rows = [machine.letters.index(x) for x in "XYZ"]
    q, s = (
        np.zeros((len(machine.letters), path.point.shape[1])),
        np.zeros((len(machine.letters), path.point.shape[1])),
    )
    q[rows], s[rows] = path.point, approach(path.point)
    return path.point + machine.deviation(q, s)[rows]


def distances(point: np.ndarray, path: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(N,) mm from points to a path of samples taken as a polyline, and (N,) the nearest sample."""
    near = cKDTree(path.T).query(point.T, k=3)[1].T
    best = np.full(point.shape[1], np.inf)
    for at in near:
        for other in (at - 1, at + 1):
            other = np.clip(other, 0, path.shape[1] - 1)
            a, way = path[:, at], path[:, other] - path[:, at]
            length = (way**2).sum(axis=0)
            use = length < (2 * STEP) ** 2  # not across a rapid
            t = np.where(
                use & (length > 0),
                ((point - a) * way).sum(axis=0) / np.where(length > 0, length, 1),
                0,
            )
            best = np.minimum(best, np.linalg.norm(point - a - way * np.clip(t, 0, 1), axis=0))
    return best, near[0]


def missed(nominal: list[Motion], run: list[Motion], machine) -> dict[int, float]:
    """Line of the nominal program to mm: the largest distance there between its path and the actual
    one, either way."""
    wanted, made = sampled(nominal), sampled(run)
    found: dict[int, float] = {}
    if not wanted.point.shape[1] or not made.point.shape[1]:
        assert not wanted.point.shape[1] and not made.point.shape[1]
        return found
    real = actual(made, machine)
    there, near = distances(real, wanted.point)
    back, _ = distances(wanted.point, real)
    for line, distance in [
        *zip(wanted.line[near].tolist(), there.tolist()),
        *zip(wanted.line.tolist(), back.tolist()),
    ]:
        found[line] = max(found.get(line, 0.0), distance)
    return found


def kinds(text: str) -> dict[int, str]:
    """Line (from 1) to "free", "entry", "inside", "rest" (no word of the plane, inside) or "exit",
    from the text alone."""
    found, state, plane = {}, "free", "XY"
    for number, line in enumerate(text.split("\n"), 1):
        line = re.sub(r"\([^)]*\)|;.*", "", line).upper()
        plane = (
            "XZ"
            if re.search(r"G18(?!\d)", line)
            else "XY"
            if re.search(r"G17(?!\d)", line)
            else plane
        )
        if re.search(r"G4[12](?!\d)", line):
            state = "entry"
        if re.search(r"G40(?!\d)", line):
            state = "exit"
        words = set(re.findall(r"[XYZIJK](?=\s*[-+.\d])", line))
        found[number] = (
            "rest" if state == "inside" and words and not words & {*plane, *"IJK"} else state
        )
        if words and not re.search(r"G10(?!\d)|G92", line):
            state = {"entry": "inside", "exit": "free"}.get(state, state)
    return found
