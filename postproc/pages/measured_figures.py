"""Figures of tests by the ISO 230 series: along an axis, at rest, about a circle."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from postproc.iso import Result
from postproc.iso.circles import Trace
from postproc.iso.drift import HOUR, Drift
from postproc.iso.figure import ends, magnified, readings_of
from postproc.iso.positioning import Positioning
from postproc.iso.report import decimals, number, scale
from postproc.iso.straightness import Straightness
from postproc.pages import charts

SIDE = 0.86  # of the width; beside it stand the widths E, M and A
ROLES = {1: "plus", -1: "minus"}
MOST_READINGS, MOST_POINTS = 4000, 2500  # of a figure


def shown(result: Result, value: float | None) -> str:
    """A value, mm or rad, in the unit of the test."""
    return number(None if value is None else value / scale(result), decimals(result))


def _bands(test: Positioning, unit: float) -> Iterator[charts.Trace]:
    """mean +- 2 s in each direction. unit: mm or rad of a unit of the ordinate."""
    for row, way in enumerate((1, -1)):
        mean, s = test.mean[row] / unit, test.s[row] / unit
        there = np.isfinite(mean) & np.isfinite(s)
        if there.any():
            low, high = (charts.column((mean + k * s)[there], 3) for k in (-2, 2))
            target = charts.column(test.target[there], 4)
            role = f"{ROLES[way]}-fill"
            yield charts.band(target, low, high, "mean +- 2 s", role, showlegend=False)


def along(result: Result, name: str) -> charts.Figure:
    """Readings, means, means +- 2 s, and beside the travel the widths that the parameters stand
    for."""
    test = readings_of(result)
    unit = scale(result)
    x = charts.column(test.target, 4)
    data: list[charts.Trace] = []
    data += _bands(test, unit)
    for row, way in enumerate((1, -1)):
        rows = np.flatnonzero(test.way == way)
        rows = rows[:: max(1, len(rows) // MOST_READINGS)]
        if not len(rows):
            continue
        sign = "+" if way > 0 else "-"
        hover = f"%{{x}}: %{{y:.2f}} {result.unit}, run %{{customdata}}<extra></extra>"
        data.append(charts.dots(
            charts.column(test.position[rows], 4), charts.column(test.reading[rows] / unit, 3),
            f"readings, {sign}", ROLES[way], size=4, opacity=0.4, showlegend=False,
            customdata=charts.column(test.run[rows], 0), hovertemplate=hover,
        ))  # fmt: skip
        data.append(charts.line(
            x, charts.column(test.mean[row] / unit, 3), f"mean, approached in {sign}", ROLES[way],
            mode="lines+markers", marker={"size": 5, "color": f"@{ROLES[way]}"},
        ))  # fmt: skip
    if test.two_way:
        data.append(
            charts.line(
                x, charts.column(test.middle / unit, 3), "mean, two-way", "still", dash="dash"
            )
        )
    notes: list[dict[str, Any]] = []
    if isinstance(result.detail, Straightness):
        data += _lines(result, result.detail, unit)
        domain = 1.0
    else:
        widths, notes = _widths(result, test, unit)
        data += widths
        domain = SIDE if widths else 1.0
    along = "degrees" if result.test == "rotary" else "mm"
    letter = result.subject.split(",")[0] if result.test == "diagonal" else result.subject[2:3]
    return charts.figure(
        name,
        "Readings (dots), their means with 2 s, in each direction of approach. Actual - commanded.",
        data,
        f"{letter}, {along}",
        f"deviation, {result.unit}",
        400,
        annotations=notes,
        xaxis={"domain": [0, domain], "range": charts.reach(x)},
        xaxis2={
            "domain": [min(domain + 0.02, 0.99), 1],
            "visible": False,
            "fixedrange": True,
            "range": [-0.6, 2.6],
        },
    )


def _widths(
    result: Result, test: Positioning, unit: float
) -> tuple[list[charts.Trace], list[dict[str, Any]]]:
    """E, M and A as bars beside the curves, each with its name and size."""
    data, notes = [], []
    for label, width in ends(result, test).items():
        k, value = "MEA".index(label[0]), result[label].value
        low, high = (round(float(v) / unit, 3) for v in width)
        data.append(charts.line(
            [k, k], [low, high], label, "ink", xaxis="x2", showlegend=False, mode="lines+markers",
            marker={"symbol": "line-ew-open", "size": 12, "color": "@ink"},
            hovertemplate=f"{label} {shown(result, value)} {result.unit}<extra></extra>",
        ))  # fmt: skip
        notes.append({
            "x": k, "y": high, "xref": "x2", "yref": "y", "yanchor": "bottom", "yshift": 6,
            "showarrow": False, "text": f"{label}<br>{shown(result, value)}<br>{result.unit}",
            "brief": label,  # the numbers stand in the table,
            "font": {"color": "@ink", "size": 11},
        })  # fmt: skip
    return data, notes


def _lines(result: Result, lines: Straightness, unit: float) -> list[charts.Trace]:
    """The reference line and the zone of the straightness error about it."""
    if lines.off is None:
        return []
    x, name = charts.column(lines.test.target, 4), lines.best
    level, off = lines.off
    size = shown(result, lines.errors[name])
    data = [charts.line(x, charts.column(level / unit, 3), f"{lines.kind} line", "ink", width=1.2)]
    for k, edge in enumerate((np.nanmax(off), np.nanmin(off))):
        data.append(charts.line(
            x, charts.column((level + edge) / unit, 3), f"zone: {name} {size} {result.unit}", "ink",
            dash="dashdot", width=1, showlegend=not k,
        ))  # fmt: skip
    return data


def at_rest(result: Result, name: str) -> charts.Figure:
    """Readings over the time, from the first one on, with the range that the first parameter is."""
    d: Drift = result.detail
    unit, step = scale(result), max(1, len(d.time) // MOST_READINGS)
    hours = (d.time - d.time[0]) / HOUR
    moved = (d.reading - d.reading[0]) / unit
    data = [
        charts.line(
            charts.column(hours[::step], 4),
            charts.column(moved[::step], 3),
            f"reading along {d.letter}",
            "plus",
            mode="lines+markers",
            marker={"size": 3, "color": "@plus"},
            hovertemplate=f"%{{x:.2f}} h: %{{y:.2f}} {result.unit}<extra></extra>",
        )
    ]
    main = result.parameters[0]
    said = f"{main.name}: {shown(result, main.value)} {result.unit}"
    for k, level in enumerate((moved.min(), moved.max())):
        data.append(charts.line(
            charts.column(hours[[0, -1]], 4), charts.column([level, level], 3), said, "ink",
            dash="dashdot", width=1, showlegend=not k, hoverinfo="skip",
        ))  # fmt: skip
    return charts.figure(
        name,
        "Readings from the first one on, while no slide moves; between the lines: the range over"
        " the whole time.",
        data,
        "time, h",
        f"reading, {result.unit}",
        400,
        xaxis={"range": charts.reach(charts.column(hours, 4))},
    )


def circle(result: Result, name: str) -> charts.Figure:
    """Circles about their least-squares centre (arcs as they stand), deviations magnified."""
    traces: list[Trace] = result.detail
    nominal = traces[0].nominal
    about, times, division, rings = magnified(traces)
    plane = result.subject.split(",")[0]
    data: list[charts.Trace] = []
    seen: set[int] = set()
    for t, (angle, radial) in zip(traces, about, strict=True):
        step = max(1, len(angle) // (MOST_POINTS // min(len(traces), 5)))
        # "xy" counter-clockwise, from +X to +Y; clockwise "yx"
        sense = plane.lower() if t.way > 0 else plane.lower()[::-1]
        data.append({
            "type": "scatterpolar", "mode": "lines",
            "name": f"from +{sense[0].upper()} to +{sense[1].upper()}",
            "theta": charts.column(np.degrees(angle[::step]), 2),
            "r": charts.column((nominal + times * radial)[::step], 4),
            "customdata": charts.um(radial[::step], 2),
            "hovertemplate": "%{theta:.0f} degrees: %{customdata} um<extra></extra>",
            "line": {"color": f"@{ROLES[1 if t.way > 0 else -1]}", "width": 1.2},
            "showlegend": t.way not in seen,
        })  # fmt: skip
        seen.add(t.way)
    turn = np.linspace(0, 360, 181)
    data.append({
        "type": "scatterpolar", "mode": "lines", "name": f"nominal, {nominal:g} mm",
        "theta": charts.column(turn, 1), "r": [nominal] * len(turn),
        "line": {"color": "@ink", "width": 1, "dash": "dot"}, "hoverinfo": "skip",
    })  # fmt: skip
    return charts.figure(
        name,
        f"About the least-squares centre, deviations {times:g} times larger; one ring is"
        f" {division * 1000:g} um.",
        data,
        "",
        "",
        560,
        polar=charts.polar(list(plane), list(nominal + times * rings), list(rings * 1000)),
    )
