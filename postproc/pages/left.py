"""Figures of readings beside a model: what is left before and after, by place, by side, in time,
and what one effect adds, over its period where it has one."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from postproc.diagnose import locate, words
from postproc.diagnose.answer import Diagnosis, Finding, floor
from postproc.diagnose.summary import middle, rms, scaled
from postproc.pages import charts

SIDES = (
    (1, "plus", "approached in +"),
    (-1, "minus", "approached in -"),
    (0, "still", "no direction"),
)
# readings of a signal that are drawn: more can not be told apart, and the page stays small
DRAWN = 3000
FEWEST = 8  # readings of a figure
BINS = 40  # pieces of the noise band
EVEN = 1.2  # times: noise that differs by less is drawn as one band
Z95 = 1.96
ABOVE, BELOW = [0.55, 1.0], [0.0, 0.45]  # of a figure's height


def name(d: Diagnosis, signal: int) -> str:
    """File and column of a signal."""
    first = int(np.flatnonzero(d.rows.signal == signal)[0])
    return f"{Path(d.recordings[int(d.rows.file[first])].file).name}, {d.rows.signals[signal]}"


def signals(d: Diagnosis) -> list[int]:
    """Numbers of the signals that are drawn one by one, the one with the largest mismatch first."""
    found = [
        int(s) for s in np.unique(d.rows.signal)
        if (d.rows.signal == s).sum() >= FEWEST and d.rows.sees[d.rows.signal == s][0] != "part"
    ]  # fmt: skip
    # over the noise, so that angles in rad and lengths in mm are of one kind
    return sorted(found, key=lambda s: -rms((d.before / floor(d))[d.rows.signal == s]))


def thinned(which: np.ndarray) -> tuple[np.ndarray, str]:
    """Rows that are drawn, evenly over all, and a word where they are not all."""
    if len(which) <= DRAWN:
        return which, ""
    return (
        which[np.linspace(0, len(which) - 1, DRAWN).astype(int)],
        f" {DRAWN} of {len(which)} readings are drawn.",
    )


def noise_band(x: np.ndarray, noise: np.ndarray) -> tuple[list, list]:
    """Places (B,) and half widths (B,) within which 95 % of the noise lies: the median of the
    readings' own noise, piece by piece where it differs."""
    low, high = float(x.min()), float(x.max())
    even = np.quantile(noise, 0.95) <= EVEN * np.quantile(noise, 0.05)
    if even or high <= low:
        return [low, high], [Z95 * float(np.median(noise))] * 2
    #     half |----.         .----        steps: each piece has its two ends in `at`, and twice
    #          |    '---------'            the same half width
    edges = np.unique(np.quantile(x, np.linspace(0, 1, BINS + 1)))
    piece = np.clip(np.searchsorted(edges, x, side="right") - 1, 0, len(edges) - 2)
    at, half = [], []
    for k in np.unique(piece):
        at += [float(edges[k]), float(edges[k + 1])]
        half += [Z95 * float(np.median(noise[piece == k]))] * 2
    return at, half


def _band(x: np.ndarray, noise: np.ndarray, axis: str, shown: bool) -> charts.Trace:
    at, half = noise_band(x, noise)
    places, high = charts.column(at, 4), charts.column(half, 3)
    low = charts.column(-np.array(half), 3)
    return charts.band(
        places, low, high, "95 % of the noise", "noise", yaxis=axis, showlegend=shown
    )


def times(d: Diagnosis, which: np.ndarray) -> tuple[np.ndarray, str]:
    """When rows were read; where that was not written down, which came first."""
    time = d.rows.state.time[which]
    if np.ptp(time) > 0:
        return time, "time, s"
    return np.arange(1.0, len(which) + 1), "number of the reading (no times were recorded)"


def axis_of(d: Diagnosis, which: np.ndarray) -> str:
    """The axis along which a signal is looked at, as the regions that stand out are."""
    return locate.axis_of(d.rows, which)


def standing_out(d: Diagnosis, which: np.ndarray) -> np.ndarray:
    """(K,) bool: which of these rows are in a region that stands out."""
    whole = np.zeros(len(d.rows), bool)
    for place in d.places:
        whole |= locate.inside(place, d.rows)
    return whole[which]


def of_signal(d: Diagnosis, signal: int) -> list[charts.Figure]:
    """Before (above) and after (below), by place, by side and in time; of readings at one place in
    time alone."""
    which = np.flatnonzero(d.rows.signal == signal)
    axis = axis_of(d, which)
    rows, few = thinned(which)
    scale, unit = scaled(d, signal)
    place, side = d.rows.state.position[axis][rows], np.sign(d.rows.state.approach[axis][rows])
    time, said = times(d, rows)
    layout = {
        "yaxis": {"domain": ABOVE, "title": {"text": f"before, {unit}"}},
        "yaxis2": {"domain": BELOW, "title": {"text": f"after, {unit}"}},
    }
    key = f"left-{signal}"
    where = (
        f"{name(d, signal)}, {words.stretch(axis, float(place.min()), float(place.max()))}:"
        " measured - model"
        if np.ptp(place)
        else f"{name(d, signal)}, at rest: measured - model in time"
    )
    ringed = " Rings: where it stands out." if standing_out(d, rows).any() else ""
    what = (
        f"{where}. Above, what the machine's file leaves; below, what is left with the effects"
        f" found.{ringed}{few}"
    )
    took = "eadings that took no part in naming and fitting are marked."
    moved = bool(np.ptp(place))
    third = charts.figure(
        f"{key}-time", f"In time; r{took}" if moved else f"{what} R{took}",
        _in_time(d, rows, time, scale, unit), said, "", 460, xaxis={"anchor": "y2"}, **layout,
    )  # fmt: skip
    if not moved:
        return [third]
    first = charts.figure(
        f"{key}-place",
        what,
        _by_place(d, rows, place, side, scale, unit, axis),
        f"position of {axis}, mm",
        "",
        460,
        xaxis={"anchor": "y2"},
        **layout,
    )
    second = charts.figure(
        f"{key}-side",
        f"By the side from which {axis} comes; bars: the means.",
        _by_side(d, rows, side, scale, unit),
        f"direction of {axis}",
        "",
        460,
        showlegend=False,
        **layout,
        xaxis={
            "anchor": "y2",
            "tickvals": [way for way, _, _ in SIDES],
            "ticktext": ["+", "-", "none"],
            "range": [-1.6, 1.6],
        },
    )
    return [first, second, third]


def _halves(d: Diagnosis) -> tuple[tuple[np.ndarray, str], ...]:
    return (d.before, "y"), (d.after, "y2")


def _rings(d: Diagnosis, rows: np.ndarray, x: np.ndarray, scale: float) -> list[charts.Trace]:
    out = standing_out(d, rows)
    if not out.any():
        return []
    return [
        charts.dots(
            charts.column(x[out], 4),
            charts.column(d.before[rows][out] * scale, 3),
            "stands out",
            "open",
            size=10,
            symbol="circle-open",
            hoverinfo="skip",
        )
    ]


def _dots(x: list, values, said: str, role: str, y: str, hover: str, **more) -> charts.Trace:
    """Readings of one kind; y: the half of the figure in which they stand; hover: what is shown of
    the one under the pointer."""
    shown = {"size": 4, "yaxis": y, "hovertemplate": f"{hover}<extra></extra>", **more}
    return charts.dots(x, charts.column(values, 3), said, role, **shown)


def _by_place(d, rows, place, side, scale, unit, axis) -> list[charts.Trace]:
    data: list[charts.Trace] = _rings(d, rows, place, scale)  # below the dots, which stay seen
    for values, y in _halves(d):
        data.append(_band(place, floor(d)[rows] * scale, y, y == "y"))
        for way, role, said in SIDES:
            own = side == way
            if own.any():
                hover = f"{axis} %{{x:.3f}} mm: %{{y:.2f}} {unit}, line %{{text}} of the file"
                lines = d.rows.line[rows][own].tolist()
                read = values[rows][own] * scale
                data.append(_dots(
                    charts.column(place[own], 4), read, said, role, y, hover, showlegend=y == "y",
                    text=lines,
                ))  # fmt: skip
    return data


def _by_side(d, rows, side, scale, unit) -> list[charts.Trace]:
    data: list[charts.Trace] = []
    for values, y in _halves(d):
        half = Z95 * float(np.median(floor(d)[rows])) * scale
        data.append(
            charts.band([-1.6, 1.6], [-half] * 2, [half] * 2, "95 % of the noise", "noise", yaxis=y)
        )
        for way, role, said in SIDES:
            own = values[rows][side == way] * scale
            if len(own):
                # side by side about their sign, in the order in which they were read
                x = way + np.linspace(-0.3, 0.3, len(own))
                hover = f"%{{y:.2f}} {unit}"
                data.append(_dots(charts.column(x), own, said, role, y, hover, size=3, opacity=0.5))
                ends, mean = [way - 0.4, way + 0.4], [round(float(own.mean()), 3)] * 2
                data.append(charts.line(ends, mean, f"mean, {said}", "mean", width=2.5, yaxis=y))
    return data


def _in_time(d, rows, time, scale, unit) -> list[charts.Trace]:
    data: list[charts.Trace] = _rings(d, rows, time, scale)
    for values, y in _halves(d):
        data.append(_band(time, floor(d)[rows] * scale, y, False))
        for held, role, said in ((False, "still", "fitted"), (True, "held", "took no part")):
            own = d.held[rows] == held
            if own.any():
                hover = f"%{{x:.1f}}: %{{y:.2f}} {unit}"
                read = values[rows][own] * scale
                data.append(
                    _dots(charts.column(time[own]), read, said, role, y, hover, showlegend=y == "y")
                )
    return data


def of_finding(d: Diagnosis, k: int) -> charts.Figure | None:
    """What one effect adds to the signal that shows it best, over its own axis, folded where it
    comes back with a period."""
    f = d.findings[k]
    part = f.contribution - middle(d, f.contribution)
    own = [int(s) for s in np.unique(d.rows.signal[d.rows.sees != "part"])]
    if not own or not np.any(f.contribution[d.rows.sees != "part"]):
        return None
    signal = max(own, key=lambda s: rms(part[d.rows.signal == s]))
    rows, few = thinned(np.flatnonzero(d.rows.signal == signal))
    x, said = _over(d, f, rows)
    axis = axis_of(d, rows)
    side, (scale, unit) = np.sign(d.rows.state.approach[axis][rows]), scaled(d, signal)
    data = []
    for way, role, label in SIDES:
        some = np.flatnonzero(side == way)
        if len(some):
            some = some[np.argsort(x[some], kind="stable")]
            # readings without all other effects: what is left, and this one put back
            both = (d.after + f.contribution)[rows][some] * scale
            data.append(charts.dots(
                charts.column(x[some], 4), charts.column(both, 3), f"readings, {label}", role,
                size=3, opacity=0.35, showlegend=False,
                hovertemplate=f"%{{y:.2f}} {unit}<extra></extra>",
            ))  # fmt: skip
            data.append(charts.dots(
                charts.column(x[some], 4), charts.column(f.contribution[rows][some] * scale, 3),
                label, role, size=8, symbol="line-ew-open",
            ))  # fmt: skip
    return charts.figure(
        f"effect-{k}",
        f"{words.named(f.block.key)} in {name(d, signal)}: what it adds to each reading (strokes),"
        f" and the readings without all other effects (dots).{few}",
        data,
        said,
        unit,
        320,
    )


def _over(d: Diagnosis, f: Finding, rows: np.ndarray) -> tuple[np.ndarray, str]:
    """What an effect is drawn over: its period, its axis, or the time where its axis rests."""
    own = f.block.axis if f.block.axis in d.rows.state.position else ""
    moves = own and float(np.ptp(d.rows.state.position[own][rows])) > 1e-3
    period = f.value.get("period_mm", 0.0)
    if moves and period > 0:
        return (
            d.rows.state.position[own][rows] % period,
            f"position of {own} in its period of {period:.5g} mm, mm",
        )
    if hasattr(f.block.module, "WALLS") or not (moves or own == ""):
        return times(d, rows)
    axis = own if moves else axis_of(d, rows)
    return d.rows.state.position[axis][rows], f"position of {axis}, mm"
