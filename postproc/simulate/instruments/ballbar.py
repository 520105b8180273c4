"""Ballbar: distance of the tool from a centre while it goes round (ISO 230-4). What leads in and
out is not recorded.

Of a run of more than one turn the middle turn is kept, so that the overshoot at both ends falls
away.
"""

from __future__ import annotations

import numpy as np

from postproc.errors import GcompError, UsageError
from postproc.simulate.actual import Reality
from postproc.simulate.instruments import Settings, Signal, commands, refuse_more

TITLE = "ballbar"
SETTINGS = {
    "centre": "X85,Z255: mm, slide positions (the centre of the longest arcs)",
    "radius": "mm (that of the longest arcs)",
    "rate": "Hz, samples (250)",
    "centre_um": "X3,Y-2: um, by which the set-up misses the centre",
}
# mm: arcs whose centre and radius differ by less are the same circle, to the rounding of their
# words
SAME = 2e-3


def measure(reality: Reality, settings: Settings) -> Signal:
    """um from the nominal radius along the longest circles. Raises GcompError without arcs,
    UsageError for too many samples."""
    timeline = reality.timeline
    path, plan, curves = timeline.path, timeline.plan, timeline.path.curves
    letters = path.letters
    piece = np.flatnonzero((path.curve >= 0) & (timeline.steps.arc[path.step] >= 0))
    # The arcs by which corners are cut belong to straight steps.
    if not len(piece):
        raise GcompError("the program has no arcs (G2, G3): nothing for a ballbar")
    c = curves.pick(path.curve[piece])
    first, second = np.argmax(np.abs(c.e1) > 0.5, axis=0), np.argmax(np.abs(c.e2) > 0.5, axis=0)
    column = np.arange(len(piece))
    at = np.stack([c.base[first, column], c.base[second, column]])
    names = [tuple(sorted((letters[a], letters[b]))) for a, b in zip(first, second, strict=True)]
    longest = int(np.argmax(_turned(c, at, names)))
    plane = names[longest]
    given = settings.place("centre")
    centre = given or {
        letters[first[longest]]: float(at[0, longest]),
        letters[second[longest]]: float(at[1, longest]),
    }
    if {*centre} != {*plane}:
        raise UsageError(
            f"--set centre names {' '.join(centre)}, the longest arcs turn in {' '.join(plane)}",
            f"--set centre={plane[0]}0,{plane[1]}0",
        )
    radius = settings.above_zero("radius", float(np.round(c.r0[longest], 6)))
    keep = np.array([n == plane for n in names])
    rows = [letters.index(x) for x in plane]
    missed = np.hypot(c.base[rows[0]] - centre[plane[0]], c.base[rows[1]] - centre[plane[1]])
    keep &= (missed < SAME) & (np.abs(c.r0 - radius) < SAME) & (np.abs(c.r1 - radius) < SAME)
    if not keep.any():
        place = ", ".join(f"{x} {v:g}" for x, v in centre.items())
        raise GcompError(
            f"no arc has its centre at {place} and the radius {radius:g} mm",
            "--set centre=X0,Y0 --set radius=100",
        )
    sense = np.where(first == rows[0], 1.0, -1.0) * np.sign(c.sweep)
    piece, sense, sweep = piece[keep], sense[keep], np.abs(c.sweep[keep])
    rate = settings.above_zero("rate", 250.0)
    time, runs, senses = _samples(timeline, piece, sense, sweep, rate)
    where = plan.at(time)[0]
    state = timeline.state(time, None, runs)
    error = reality.error(state, ("tool",), where)
    off = settings.place("centre_um")
    arm = [
        state.position[x] + error["XYZ".index(x)] - centre[x] - off.get(x, 0.0) * 1e-3
        for x in plane
    ]
    # the commands of resting slides too: errors hang on them
    columns = {"run": runs, "t_s": state.time, **commands(state)}
    columns |= {"radial_um": (np.hypot(*arm) - radius) * 1e3, "sense": senses}
    # F of G93 is a share of the step's way a second
    step, way = path.step[piece], np.bincount(path.step, path.length)
    feed = timeline.steps.feed[step] * np.where(timeline.steps.inverse[step], way[step], 1.0)
    head = {
        "instrument": TITLE, "centre": centre, "radius_mm": radius,
        "feed_mm_min": float(np.round(np.nanmedian(feed) * 60.0, 6)), "rate_hz": rate,
    }  # fmt: skip
    return Signal("ballbar", head, columns, {"radial_um": 1.0}, state)


def _samples(timeline, piece, sense, sweep, rate: float) -> list[np.ndarray]:
    """(N,) s, run and sense of the samples of every run: pieces one after the other in one
    sense."""
    # arcs one behind the other in one sense are one run; a line or a turn round begins the next
    run = np.cumsum(np.concatenate([[0], (np.diff(piece) != 1) | (np.diff(sense) != 0)]))
    parts: list[tuple[np.ndarray, ...]] = []
    total = 0.0
    for k in range(int(run[-1]) + 1):
        of = np.flatnonzero(run == k)
        begin, end = _middle(timeline, piece[of], sweep[of])
        total += (end - begin) * rate
        refuse_more(total)
        t = begin + np.arange(int((end - begin) * rate) + 1) / rate
        parts.append((t, np.full(len(t), k + 1.0), np.full(len(t), sense[of[0]])))
    return [np.concatenate(x) for x in zip(*parts, strict=True)]


def _turned(c, at: np.ndarray, names: list) -> np.ndarray:
    """(n,) rad: how far the circle that each piece belongs to is gone round in all."""
    # to 0.01 mm: the same circle, whatever the rounding of its words
    keys = [
        (n, *np.round(p, 2).tolist(), round(float(r), 2))
        for n, p, r in zip(names, at.T, c.r0, strict=True)
    ]
    total: dict = {}
    for key, sweep in zip(keys, np.abs(c.sweep).tolist(), strict=True):
        total[key] = total.get(key, 0.0) + sweep
    return np.array([total[key] for key in keys])


def _middle(timeline, piece: np.ndarray, sweep: np.ndarray) -> tuple[float, float]:
    """s: begin and end of the middle turn of a run, or of all of it where it is no more than
    one."""
    plan, path = timeline.plan, timeline.path
    begin, end = float(plan.start[piece[0]]), float(plan.start[piece[-1] + 1])
    total = float(sweep.sum())
    if total <= 2 * np.pi + 1e-6:
        return begin, end
    gone = np.concatenate([[0.0], np.cumsum(path.length[piece])])
    grid = np.linspace(begin, end, 20_001)
    where, way = plan.at(grid)[:2]
    along = gone[np.clip(np.searchsorted(piece, where), 0, len(piece) - 1)] + way
    along[-1] = gone[-1]
    # as much off either end: what is left is one turn, at full feed
    edge = (total - 2 * np.pi) / 2 / total * gone[-1]
    return float(np.interp(edge, along, grid)), float(np.interp(gone[-1] - edge, along, grid))
