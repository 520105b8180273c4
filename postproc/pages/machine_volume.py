"""The deviation over the volume of a machine, on its page."""

from __future__ import annotations

from typing import Any

import numpy as np

from postproc.iso.figure import round_down
from postproc.machine.chain import LINEAR, XYZ
from postproc.machine.model import Machine
from postproc.pages import charts
from postproc.pages.frame import Page
from postproc.units import UM

GRID, ARROWS, SLICES = 25, 9, 7  # places of a map along an axis, arrows along it, and levels
ARROW = 0.07  # of the longer side: as long as the largest deviation is drawn


def _reach(machine: Machine, letter: str) -> tuple[float, float]:
    return machine.reached[letter] if letter in machine.reached else machine.axes[letter].travel


def _slides(machine: Machine) -> list[str]:
    return [x for x in XYZ if x in machine.axes and x in machine.chain.axes]


def corners(machine: Machine) -> np.ndarray:
    """(A, N) places spread over the volume that programs can reach."""
    axes = [
        np.linspace(*_reach(machine, x), 9) if x in LINEAR else np.array([0.0])
        for x in machine.letters
    ]
    return np.stack([g.ravel() for g in np.meshgrid(*axes, indexing="ij")])


def deviation(machine: Machine, places: np.ndarray) -> np.ndarray:
    """(S, N) mm of the slides: the mean of both directions."""
    rows = [machine.letters.index(x) for x in _slides(machine)]
    below, above = (machine.deviation(places, np.full_like(places, s))[rows] for s in (1.0, -1.0))
    return (below + above) / 2


def farthest(machine: Machine) -> float:
    """mm: the largest deviation of the slides in the volume, from either direction."""
    rows = [machine.letters.index(x) for x in _slides(machine)]
    places = corners(machine)
    both = [machine.deviation(places, np.full_like(places, s))[rows] for s in (1.0, -1.0)]
    return max(float(np.linalg.norm(off, axis=0).max()) for off in both)


def volume(result: Page, machine: Machine) -> None:
    slides = _slides(machine)
    if machine.is_zero or len(slides) < 2:
        return
    across, up, *more = ("Z", "X") if slides == ["X", "Z"] else slides
    third = more[0] if more else None
    levels = np.linspace(*_reach(machine, third), SLICES) if third else np.zeros(1)
    step = _levels(machine, across, up, third, levels)
    domain: dict[str, Any] = {"constrain": "domain", "automargin": False}
    one_scale = _alike(machine, across, up)
    figure = charts.figure(
        "volume",
        "Size of the deviation (mean of both directions of approach), and where the tool goes:"
        " a dot is the end of each arrow, and how long they are stands above.",
        step[-1],
        f"{across}, mm",
        f"{up}, mm",
        460,
        shape=float(np.ptp(_reach(machine, up)) / np.ptp(_reach(machine, across)))
        if one_scale
        else None,
        xaxis=domain,
        showlegend=False,
        yaxis=domain | ({"scaleanchor": "x"} if one_scale else {}),
    )
    if third:
        figure["steps"] = {
            "label": f"{third}, mm",
            "values": [f"{v:.4g}" for v in levels],
            "data": step,
            "at": SLICES - 1,
        }
    result.section("In the working volume")
    result.figure(figure)


def _levels(
    machine: Machine, across: str, up: str, third: str | None, levels: np.ndarray
) -> list[Any]:
    """What is drawn of each level, all of them on one scale."""
    drawn = [_slice(machine, across, up, third, float(level)) for level in levels]
    # of all levels: a colour and an arrow mean the same on each, and the slider changes no scale
    top = max(size for *_, size in drawn)
    return [_level(across, up, heat, tip, top) for heat, tip, _ in drawn]


def _alike(machine: Machine, across: str, up: str) -> bool:
    """Whether two travels may have one scale."""
    a, b = (float(np.ptp(_reach(machine, x))) for x in (across, up))
    return 0.25 < a / b < 6.0


def _slice(machine: Machine, across: str, up: str, third: str | None, level: float):
    """Size of the deviation over a grid in um, arrows as (x, y, dx, dy), and the largest size,
    mm."""
    slides = _slides(machine)

    def at(count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        a, b = (np.linspace(*_reach(machine, x), count) for x in (across, up))
        grid = dict(zip((across, up), (g.ravel() for g in np.meshgrid(a, b)), strict=True))
        resting = {third: level} if third else {}
        return a, b, deviation(machine, machine.at({**grid, **resting}, count * count))

    a, b, off = at(GRID)
    size = np.linalg.norm(off, axis=0)
    heat = (a, b, size.reshape(GRID, GRID) / UM)
    p, q, arrows = at(ARROWS)
    dx, dy = arrows[slides.index(across)], arrows[slides.index(up)]
    x, y = (g.ravel() for g in np.meshgrid(p, q))
    return heat, (x, y, dx, dy), float(size.max())


def _level(across: str, up: str, heat, tip, top: float) -> list[charts.Trace]:
    a, b, z = heat
    x, y, dx, dy = tip
    longer = max(float(np.ptp(x)), float(np.ptp(y)))
    # ends_x: begin, tip, None, begin, tip, None ...: one curve of many strokes, None lifts the pen
    times = ARROW * longer / max(top, 1e-9)
    # An arrow of a round size above the others, with its unit.
    whole = round_down(max(top, 1e-9))
    high = round(float(y.max()) + 1.7 * ARROW * longer, 3)
    begin, end = round(float(x.min()), 3), round(float(x.min()) + times * whole, 3)
    ends_x = [
        v for k in range(len(x)) for v in (round(x[k], 3), round(x[k] + times * dx[k], 3), None)
    ]
    ends_y = [
        v for k in range(len(x)) for v in (round(y[k], 3), round(y[k] + times * dy[k], 3), None)
    ]
    return [
        {
            "type": "contour",  # it ends at the last place, where a cell of a heat map goes beyond
            "contours": {"coloring": "heatmap"},
            "line": {"width": 0},
            "x": charts.column(a, 3),
            "y": charts.column(b, 3),
            "z": [charts.column(row, 2) for row in z],
            "colorscale": "@sequential",
            "zmin": 0,
            "zmax": round(top / UM, 3),
            "colorbar": {
                "title": {"text": "um", "side": "top"},
                "thickness": 12,
                "outlinewidth": 0,
            },
            "hovertemplate": f"{across} %{{x}}, {up} %{{y}}: %{{z:.1f}} um<extra></extra>",
        },
        charts.line(ends_x, ends_y, "deviation", "ink", width=1.3, hoverinfo="skip"),
        {
            **charts.dots([begin, end], [high, high], "scale", "ink", size=[0, 4]),
            "mode": "lines+markers+text",
            "line": {"color": "@ink", "width": 1.3},
            "text": ["", f"{whole / UM:g} um"],
            "textposition": "middle right",
            "hoverinfo": "skip",
        },
        charts.dots(
            charts.column(x + times * dx, 3),
            charts.column(y + times * dy, 3),
            "tip",
            "ink",
            size=4,
            hoverinfo="skip",
        ),
    ]
