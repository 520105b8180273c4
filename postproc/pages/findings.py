"""Figures of what a diagnosis found: how much each effect explains, how probable its names are,
what it does to readings that took no part, what no name explains, and what the written machine
would change."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from postproc.diagnose import machine_effects, words
from postproc.diagnose.answer import Diagnosis, floor
from postproc.diagnose.summary import UM, middle, rms, scaled
from postproc.diagnose.unknown import Cell
from postproc.machine.chain import LINEAR, XYZ
from postproc.machine.model import Machine
from postproc.pages import charts, left

PLACES = 161  # of a curve over a travel, at least
NODES = 4000  # of it, at most: a page stays small
CHANGES = 0.05  # um: less is not drawn
RANKED = 12  # causes that are listed
SHOWN = 0.02  # of a probability: less is not drawn


def held_out(d: Diagnosis) -> charts.Figure:
    """rms of what took no part, signal by signal."""
    own = [int(s) for s in np.unique(d.rows.signal[d.held])]
    sizes = {"before": d.before, "with the effects found": d.after, "noise": floor(d)}
    groups = []
    for (said, values), role in zip(sizes.items(), ("before", "after", "still"), strict=True):
        of = [rms(values[d.held & (d.rows.signal == s)]) * scaled(d, s)[0] for s in own]
        groups.append((said, role, of))
    labels = [left.name(d, s) + ("" if scaled(d, s)[1] == "um" else ", urad") for s in own]
    return charts.lying(
        "held-out",
        f"Held out ({d.held_name}): rms before, and with the effects found, beside the noise of"
        " single readings.",
        labels,
        groups,
        "rms of what took no part, um",
    )


def ranked(d: Diagnosis) -> list[tuple[str, float, float, float]]:
    """(effect, rms um, range um, share of all) of what was found, the largest first. range: from
    its least to its largest in one signal; share: of the sum of squares of all effects."""
    found = []
    for f in d.findings:
        part = (f.contribution - middle(d, f.contribution)) * UM
        wide = max(float(np.ptp(part[d.rows.signal == s])) for s in np.unique(d.rows.signal))
        found.append((words.named(f.block.key), rms(part), wide))
    # Squares add up where effects do not go together, sizes do not. What is left is no part of the
    # sum.
    whole = sum(size**2 for _, size, _ in found) or 1.0
    return sorted(
        ((n, size, wide, size**2 / whole) for n, size, wide in found), key=lambda one: -one[1]
    )[:RANKED]


def shares(d: Diagnosis) -> charts.Figure:
    """How much each effect explains, beside what is left."""
    sizes = [
        (words.named(f.block.key), rms(f.contribution - middle(d, f.contribution)) * UM)
        for f in d.findings
    ]
    sizes.sort(key=lambda one: -one[1])
    sizes += [("left with all of them", rms(d.after) * UM), ("noise", rms(floor(d)) * UM)]
    return charts.lying(
        "shares",
        "How much each effect explains in all readings, beside what is left with all of them and"
        " the noise.",
        [n for n, _ in sizes],
        [("rms", "command", [v for _, v in sizes])],
        "rms of all readings, um",
    )


def names(d: Diagnosis) -> charts.Figure | None:
    """How probable each name is, where more than one explains the readings."""
    shown = [f for f in d.findings if len(f.names) > 1]
    if not shown:
        return None
    labels, sizes = [], []
    for f in shown:
        of = words.named(f.block.key)
        for name, p in f.names.items():
            if p >= SHOWN:
                # of several effects each name says which one it stands for, on a line of its own
                other = name != f.block.key and len(shown) > 1
                labels.append(words.named(name) + f"<br>(for {of})" * other)
                sizes.append(100 * p)
    return charts.lying(
        "names",
        "How probable each name is if it is one of these: by the readings and by how common it is"
        " on machines.",
        labels,
        [("probability", "command", sizes)],
        "%",
    )


def features(d: Diagnosis) -> charts.Figure:
    """Features of parts, before and after."""
    own = [int(s) for s in np.unique(d.rows.signal[d.rows.sees == "part"])]
    labels = {s: left.name(d, s) for s in own}
    data: list[charts.Trace] = []
    for which, values, role, symbol, said in (
        (d.rows.sees == "part", d.before, "before", "circle-open", "before"),
        ((d.rows.sees == "part") & ~d.held, d.after, "after", "circle", "after"),
        ((d.rows.sees == "part") & d.held, d.after, "held", "diamond", "after, took no part"),
    ):
        rows = np.flatnonzero(which)
        if len(rows):
            data.append(charts.dots(
                charts.um(values[rows], 3), [labels[int(s)] for s in d.rows.signal[rows]], said,
                role, size=8, symbol=symbol, hovertemplate="%{y}: %{x:.2f} um<extra></extra>",
            ))  # fmt: skip
    half = [left.Z95 * float(np.median(floor(d)[d.rows.signal == s])) * UM for s in own]
    bars = charts.bars(
        charts.column(2 * np.array(half), 3), [labels[s] for s in own], "95 % of the noise",
        "noise", orientation="h", base=charts.column(-np.array(half), 3), hoverinfo="skip",
    )  # fmt: skip
    return charts.figure(
        "features",
        "Features of parts: what the machine's file leaves, and what is left with the effects"
        " found.",
        [bars, *data],
        "measured - model, um",
        "",
        130 + 30 * len(own),
        yaxis={"autorange": "reversed", "gridcolor": "rgba(0,0,0,0)"},
    )


def _cells(own: Sequence[Cell], scale: float, by_side: bool, name: str, role: str) -> charts.Trace:
    """The means of cells of one direction, with their 95 % limits. scale: units of a mm or rad."""
    x = [c.approach if by_side else (c.low + c.high) / 2 for c in own]
    wide = charts.limits(charts.column([1.96 * c.error * scale for c in own], 3))
    return charts.line(
        charts.column(x, 4), charts.column([c.mean * scale for c in own], 3), name, role,
        mode="lines+markers", error_y=wide,
    )  # fmt: skip


def unknown(d: Diagnosis) -> charts.Figure | None:
    """What no name explains, cell by cell."""
    u = d.unknown
    if u is None or len(u.cells) < 2:
        return None
    scale, unit = scaled(d, u.signal)
    by_side = u.depends == ("direction",)
    data = []
    for way, role, said in left.SIDES:
        if own := [c for c in u.cells if c.approach == way]:
            name = said if way else "both directions"
            data.append(_cells(own, scale, by_side, name, role))
    along = "time, s" if u.along == "time" else f"position of {u.along}, mm"
    return charts.figure(
        "unknown",
        f"{left.name(d, u.signal)}: the mean of what no name explains, with 95 % limits of the"
        " mean. No compensator applies it.",
        data,
        "direction of approach" if by_side else along,
        f"not explained, {unit}",
        320,
    )


def places(machine: Machine, other: Machine, letter: str) -> tuple[np.ndarray, str]:
    """(N,) mm: where curves along an axis are drawn, with every node of both machines, because a
    wave between them would be drawn as another one; and a word where only the middle of the travel
    holds as many as are drawn."""
    low, high = machine.axes[letter].travel
    nodes = [n for m in (machine, other) for n in m.knots.get(letter, [])]
    at = np.unique(np.concatenate([np.linspace(low, high, PLACES), *nodes]))
    at = at[(at >= low) & (at <= high)]
    if len(at) <= NODES:
        return at, ""
    first = (len(at) - NODES) // 2
    return at[first : first + NODES], " The middle of the travel is drawn."


def written(d: Diagnosis, accept: tuple[str, ...]) -> list[charts.Figure]:
    """What the written machine would change: the map's deviation along each slide, the others in
    the middle, before and after."""
    machine, other = d.machine, machine_effects.with_effects(d, accept)
    figures = []
    middles = {
        x: (a.travel[0] + a.travel[1]) / 2 if x in LINEAR else 0.0 for x, a in machine.axes.items()
    }
    slides = [x for x in machine.letters if x in XYZ]
    for letter in slides:
        at, part = places(machine, other, letter)
        place = np.stack([np.full(len(at), middles[x]) for x in machine.letters])
        place[machine.letters.index(letter)] = at
        if data := _curves((machine, other), place, slides, charts.column(at, 3)):
            figures.append(
                charts.figure(
                    f"written-{letter}",
                    f"Deviation by the map along {letter}, the other axes in the middle of their"
                    f" travel: as the file states it, and as --write-machine would write it.{part}",
                    data,
                    f"position of {letter}, mm",
                    "deviation, um",
                    340,
                )
            )
    return figures


def _curves(
    machines: tuple[Machine, Machine], place: np.ndarray, slides: list[str], x: list[float | None]
) -> list[dict]:
    """What changes of the deviation along each slide, approached from either side."""
    return [
        curve
        for error, role in zip(slides, ("plus", "minus", "limit"), strict=False)
        for side in (1.0, -1.0)
        for curve in _pair(machines, place, side, error, role, x)
    ]


def _pair(
    machines: tuple[Machine, Machine],
    place: np.ndarray,
    side: float,
    error: str,
    role: str,
    x: list[float | None],
) -> list[dict]:
    """The deviation along `error` at (A, N) mm approached from one side, as it is and as written;
    nothing where it does not change."""
    row = machines[0].letters.index(error)
    # (A, N): all axes approached from one side, `error`'s row of the slides' deviation
    before, after = (m.deviation(place, np.full_like(place, side))[row] * UM for m in machines)
    if float(np.abs(after - before).max()) < CHANGES:
        return []
    sign, dash = ("+", "solid") if side > 0 else ("-", "dash")
    return [
        charts.line(x, charts.column(values, 3), f"{error} {said}, from {sign}", colour, dash=dash)
        for values, said, colour in ((before, "as it is", "nominal"), (after, "as written", role))
    ]
