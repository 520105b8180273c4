"""The results drawn as the standards draw them: deviation over position with B, E and A; circles
magnified."""

from __future__ import annotations

import io
import math
from collections.abc import Sequence
from pathlib import PurePath
from typing import Any

import numpy as np

from postproc.errors import UsageError
from postproc.iso import Result
from postproc.iso.circles import Trace
from postproc.iso.drift import HOUR, Drift
from postproc.iso.positioning import Positioning
from postproc.iso.report import decimals, number, scale
from postproc.iso.straightness import Straightness
from postproc.style import LIGHT, PAPER, made_by

FORMATS = ("svg", "png", "pdf")
UP, DOWN, GREY, INK, GROUND = (LIGHT[role] for role in ("plus", "minus", "muted", "mean", "ground"))
WIDTH, HEIGHT, SIDE = 10.0, 4.6, 6.4  # inches of a panel
MOST = 12  # panels
ROOM = 0.05  # of the range of the means, below which no arrow of B is drawn
FILL = 0.5  # of the radius, which the largest deviation of a circle is drawn to fill


def check(name: str) -> None:
    """Raises UsageError where a figure of this name can not be drawn: another ending, or matplotlib
    is missing."""
    ending = PurePath(name).suffix[1:].lower()
    if ending not in FORMATS:
        raise UsageError(
            f"a figure can not be written as {name}",
            f"endings: {', '.join('.' + f for f in FORMATS)}",
        )
    try:
        import matplotlib  # noqa: F401
    except ImportError:
        raise UsageError(
            "figures need matplotlib, which is not installed", "pip install 'gcomp[figures]'"
        ) from None


def draw(results: Sequence[Result], format: str) -> bytes:
    """One panel for every result that has a picture. Raises UsageError where none has."""
    import matplotlib
    from matplotlib.figure import Figure

    kinds = (Positioning, Straightness, Drift, list)
    shown = [r for r in results if isinstance(r.detail, kinds)][:MOST]
    if not shown:
        raise UsageError(
            "none of these results has a figure",
            "positioning, straightness, diagonals, circles and slides at rest have",
        )
    heights = [SIDE if isinstance(r.detail, list) else HEIGHT for r in shown]
    with matplotlib.rc_context(PAPER):
        # not pyplot: that would ask for a window, and keep every figure that was drawn
        figure = Figure(figsize=(WIDTH, sum(heights)), layout="constrained")
        grid = figure.add_gridspec(len(shown), 1, height_ratios=heights)
        for i, result in enumerate(shown):
            if isinstance(result.detail, list):
                _circle(figure.add_subplot(grid[i], projection="polar"), result)
            elif isinstance(result.detail, Drift):
                _at_rest(figure.add_subplot(grid[i]), result)
            else:
                _along(figure.add_subplot(grid[i]), result)
        out = io.BytesIO()
        figure.savefig(out, format=format, dpi=130, metadata=made_by(format))
    return out.getvalue()


def _micro(result: Result) -> str:
    return "µrad" if result.unit == "urad" else "µm"


def _at_rest(axes: Any, result: Result) -> None:
    """Readings over the time, from the first one on, with the range over the whole of it."""
    d: Drift = result.detail
    unit, main = scale(result), result.parameters[0]
    hours, moved = (d.time - d.time[0]) / HOUR, (d.reading - d.reading[0]) / unit
    axes.plot(hours, moved, "-o", color=UP, ms=2.5, lw=1.2, label=f"reading along {d.letter}")
    size = number(None if main.value is None else main.value / unit, decimals(result))
    for label, level in ((f"{main.name}: {size} µm", moved.min()), (None, moved.max())):
        axes.axhline(level, color=INK, lw=0.8, ls="-.", label=label)
    axes.set_xlim(hours[0], hours[-1])
    axes.set_xlabel("time, h")
    axes.set_ylabel("reading, µm")
    axes.set_title(f"{result.subject}  ({result.standard})", loc="left")
    axes.grid(True)
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.13), ncol=2, fontsize=8, frameon=False)


def _position(result: Result) -> str:
    """What the abscissa is."""
    if result.test == "rotary":
        return "position, degrees"
    if result.test == "diagonal":
        return f"position along {result.subject.split(',')[0]}, mm"
    return f"{result.subject[2]}, mm"


def _along(axes: Any, result: Result) -> None:
    """Deviation over position: runs, means, means +- 2s, and the widths that the parameters stand
    for."""
    test = readings_of(result)
    unit, digits = scale(result), decimals(result)
    x = test.target
    for way, colour in ((1, UP), (-1, DOWN)):
        for run in np.unique(test.run[test.way == way]):
            rows = np.flatnonzero((test.way == way) & (test.run == run))
            rows = rows[np.argsort(test.position[rows], kind="stable")]
            axes.plot(
                test.position[rows], test.reading[rows] / unit, ".", color=colour, ms=3, alpha=0.45,
                lw=0,
            )  # fmt: skip
    for row, (sign, colour) in enumerate((("+", UP), ("-", DOWN))):
        mean, s = test.mean[row] / unit, test.s[row] / unit
        there = np.isfinite(mean)
        if not there.any():
            continue
        axes.plot(
            x[there], mean[there], "-o", color=colour, ms=3.5, lw=1.4,
            label=f"mean, approached in {sign}",
        )  # fmt: skip
        if np.isfinite(s).any():
            axes.fill_between(
                x, mean - 2 * s, mean + 2 * s, color=colour, alpha=0.12, lw=0,
                label=f"mean {sign} $\\pm$ 2s",
            )  # fmt: skip
    if test.two_way:
        axes.plot(x, test.middle / unit, "--", color=GREY, lw=1, label="mean, two-way")
    if isinstance(result.detail, Straightness):
        _lines(axes, result, result.detail, unit, digits)
    else:
        _widths(axes, result, test, unit, digits)
    _reversal(axes, result, test, unit, digits)
    axes.axhline(0, color=INK, lw=0.6)
    axes.set_xlabel(_position(result))
    axes.set_ylabel(f"deviation, {_micro(result)}")
    axes.set_title(f"{result.subject}  ({result.standard})", loc="left")
    axes.grid(True)
    # Below the axes nothing is hidden by it, whatever the curves do.
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.13), ncol=5, fontsize=8, frameon=False)


def readings_of(result: Result) -> Positioning:
    """The readings along an axis, also of a straightness."""
    return result.detail.test if isinstance(result.detail, Straightness) else result.detail


def ends(result: Result, test: Positioning) -> dict[str, tuple[float, float]]:
    """Bottom and top, mm, of the widths that have a value, in the order in which they are
    drawn."""
    unknown = (np.nan, np.nan)
    widths = {
        "M": (np.nanmin(test.middle), np.nanmax(test.middle)) if test.both.any() else unknown,
        "E": (np.nanmin(test.mean), np.nanmax(test.mean)),
        "A": (
            (np.nanmin(test.mean - 2 * test.s), np.nanmax(test.mean + 2 * test.s))
            if np.isfinite(test.s).any()
            else unknown
        ),
    }
    if not any(result[n].value is not None for n in widths):  # one direction only: its own letters
        sign = "+" if result["E+"].value is not None else "-"
        widths = {f"{n}{sign}": widths[n] for n in "EA"}
    return {name: width for name, width in widths.items() if result[name].value is not None}


def _widths(axes: Any, result: Result, test: Positioning, unit: float, digits: int) -> None:
    """E, M and A as arrows beside the curves."""
    widths = ends(result, test)
    length = max(test.length, 1e-9)
    start = float(test.target[-1])
    for i, (name, (bottom, top)) in enumerate(widths.items()):
        at = start + length * (0.045 + 0.075 * i)
        low, high = float(bottom) / unit, float(top) / unit
        for level in (low, high):
            axes.plot([start, at], [level, level], color=GREY, lw=0.5, ls=":")
        axes.annotate(
            "",
            (at, low),
            (at, high),
            arrowprops={"arrowstyle": "<->", "color": INK, "lw": 1, "shrinkA": 0, "shrinkB": 0},
        )
        value = result[name].value
        shown = number(None if value is None else value / unit, digits)
        said = f" {name}\n {shown}\n {_micro(result)}"
        axes.text(at, (low + high) / 2, said, va="center", fontsize=8)
    axes.set_xlim(
        float(test.target[0]) - 0.03 * length, start + length * (0.08 + 0.08 * len(widths))
    )
    # The axis ends where the travel ends: beyond it only the widths stand.
    axes.set_xticks([t for t in axes.get_xticks() if test.target[0] <= t <= start])


def _lines(axes: Any, result: Result, lines: Straightness, unit: float, digits: int) -> None:
    """The reference line and the zone of the straightness error about it."""
    if lines.off is None:
        return
    x, name = lines.test.target, lines.best
    level, left = lines.off
    axes.plot(x, level / unit, color=INK, lw=1, label=f"{lines.kind} line")
    size = lines.errors[name]
    error = number(None if size is None else size / unit, digits)
    for i, edge in enumerate((np.nanmax(left), np.nanmin(left))):
        axes.plot(
            x, (level + edge) / unit, color=INK, lw=0.7, ls="-.",
            label=None if i else f"zone: {name} {error} {_micro(result)}",
        )  # fmt: skip


def _reversal(axes: Any, result: Result, test: Positioning, unit: float, digits: int) -> None:
    """B between the means, at its target, where there is room for an arrow; no curve is hidden."""
    if result["B"].value is None:
        return
    at = int(np.nanargmax(np.abs(test.reversal)))
    up, down = test.mean[:, at] / unit
    if abs(up - down) <= ROOM * float(np.nanmax(test.mean) - np.nanmin(test.mean)) / unit:
        return
    axes.annotate(
        "",
        (test.target[at], up),
        (test.target[at], down),
        arrowprops={"arrowstyle": "<->", "color": INK, "lw": 1, "shrinkA": 0, "shrinkB": 0},
    )
    last = at > 0.8 * len(test.target)
    axes.annotate(
        f"B {number(result['B'].value / unit, digits)} {_micro(result)}",
        (test.target[at], (up + down) / 2), (-5 if last else 5, 0), textcoords="offset points",
        ha="right" if last else "left", va="center", fontsize=8,
        bbox={"boxstyle": "round,pad=0.15", "fc": GROUND, "ec": "none", "alpha": 0.8},
        zorder=1.9,  # matplotlib draws curves at 2
    )  # fmt: skip


def _values(result: Result) -> str:
    """The parameters but F, in um."""
    digits = decimals(result)
    return ";  ".join(
        f"{p.name} {number(p.value / 1e-3, digits)}"
        for p in result.parameters
        if p.value is not None and p.name[0] != "F"
    )


def _circle(axes: Any, result: Result) -> None:
    """Circles about their least-squares centre (arcs as they stand), deviations magnified to fill
    half the radius."""
    traces: list[Trace] = result.detail
    nominal = traces[0].nominal
    about, magnification, division, rings = magnified(traces)
    plane = result.subject.split(",")[0]
    seen: set[int] = set()
    for t, (angle, radial) in zip(traces, about, strict=True):
        colour = UP if t.way > 0 else DOWN
        sense = plane.lower() if t.way > 0 else plane.lower()[::-1]
        axes.plot(
            angle, nominal + magnification * radial, color=colour, lw=0.9, alpha=0.8,
            label=None if t.way in seen else sense,
        )  # fmt: skip
        seen.add(t.way)
    turn = np.linspace(0, 2 * np.pi, 361)
    axes.plot(turn, np.full(361, nominal), color=INK, lw=0.8, label=f"nominal, {nominal:g} mm")
    outermost = rings[-1]
    # The first and the last, between which all curves lie: a name of one between would lie on them.
    names = [f"{v * 1000:+g} µm" if abs(v) > outermost - 0.5 * division else "" for v in rings]
    axes.set_rgrids(nominal + magnification * rings, names, angle=22.5, fontsize=7, color=GREY)
    axes.set_ylim(0, nominal + magnification * outermost * 1.02)
    axes.set_xticks(
        np.radians([0, 90, 180, 270]),
        [f"+{plane[0]}", f"+{plane[1]}", f"-{plane[0]}", f"-{plane[1]}"],
    )
    axes.set_title(
        f"{result.subject}  ({result.standard})\nabout the least-squares centre, magnified"
        f" {magnification:g} : 1, one ring {division * 1000:g} µm\n{_values(result)}  (µm)",
        fontsize=9,
    )
    axes.legend(loc="lower left", bbox_to_anchor=(1.02, 0.0), fontsize=8, frameon=False)
    axes.grid(True)


def magnified(
    traces: Sequence[Trace],
) -> tuple[list[tuple[np.ndarray, np.ndarray]], float, float, np.ndarray]:
    """Each circle about its centre; how many times its deviations are drawn larger, so that the
    largest fills half the radius; mm from ring to ring, and the rings, mm from the nominal one."""
    about = [about_centre(t) for t in traces]
    largest = max(float(np.abs(radial).max()) for _, radial in about)
    magnification = round_down(FILL * traces[0].nominal / max(largest, 1e-6))
    division = round_down(max(largest, 1e-4))
    edge = math.ceil(largest / division)
    return about, magnification, division, division * np.arange(-edge, edge + 1)


def about_centre(trace: Trace) -> tuple[np.ndarray, np.ndarray]:
    """Angle (N,) and radius - nominal (N,), mm, closed where it is a full circle."""
    if not trace.full:
        return trace.angle, trace.radial
    radial = np.linalg.norm(trace.points - trace.least_squares.centre, axis=1) - trace.nominal
    return np.append(trace.angle, trace.angle[0]), np.append(radial, radial[0])


def round_down(value: float) -> float:
    """The largest of 1, 2, 5 times a power of ten that is not above value."""
    power = 10.0 ** math.floor(math.log10(value))
    return max(f * power for f in (1, 2, 5) if f * power <= value * (1 + 1e-9))
