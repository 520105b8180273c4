"""Figures of readings about a circle, before and after, their deviations magnified."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from postproc.diagnose.answer import Diagnosis, floor
from postproc.iso.figure import round_down
from postproc.pages import charts
from postproc.pages.left import FEWEST, Z95, thinned

FILL = 0.4  # of the radius, which the largest deviation of a circle is drawn to fill


def of_diagnosis(d: Diagnosis) -> Iterator[charts.Figure]:
    """Before and after about each circle, deviations magnified."""
    for file, recording in enumerate(d.recordings):
        rows = np.flatnonzero(d.rows.file == file)
        centre, nominal = recording.head.get("centre"), recording.head.get("radius_mm")
        if not isinstance(centre, dict) or len(centre) != 2 or not nominal or len(rows) < FEWEST:
            continue
        yield _circle(
            d, file, rows, sorted(centre), {x: float(v) for x, v in centre.items()}, float(nominal)
        )


def _circle(
    d: Diagnosis,
    file: int,
    rows: np.ndarray,
    axes: list[str],
    centre: dict[str, float],
    nominal: float,
) -> charts.Figure:
    rows, few = thinned(rows)
    # angle from the first axis towards the second, by the places that were commanded
    arm = [d.rows.state.position[x][rows] - centre[x] for x in axes]
    angle = np.degrees(np.arctan2(arm[1], arm[0])) % 360
    top = max(float(np.abs(d.before[rows]).max()), 1e-6)
    #     drawn radius = nominal + times_ x deviation, mm
    # The largest deviation fills FILL of the radius; the factor is a round one, for the caption.
    times_ = round_down(FILL * nominal / top)
    data: list[charts.Trace] = []
    for values, role, said in (
        (d.before, "before", "before"),
        (d.after, "after", "with the effects found"),
    ):
        data.append({
            "type": "scatterpolar", "mode": "markers", "name": said,
            "theta": charts.column(angle, 2),
            "r": charts.column(nominal + times_ * values[rows], 4),
            "text": charts.um(values[rows], 2),
            "hovertemplate": "%{theta:.0f} degrees: %{text} um<extra></extra>",
            "marker": {"color": f"@{role}", "size": 3},
        })  # fmt: skip
    for sign in (-1, 1):
        half = Z95 * float(np.median(floor(d)[rows]))
        data.append(
            _ring(nominal + sign * times_ * half, "95 % of the noise", "still", "dot", sign > 0)
        )
    data.append(_ring(nominal, f"model, {nominal:g} mm", "ink", "solid", True))
    step = round_down(top) * 1000  # um
    rings = [k for k in range(-9, 10) if abs(k) * step <= 1250 * top]
    return charts.figure(
        f"circle-{file}",
        f"{Path(d.recordings[file].file).name}: measured - model about the circle, {times_:,.0f}"
        f" times larger; one ring is {step:g} um.{few}",
        data,
        "",
        "",
        560,
        # +Z stands above the circle, and the legend above that
        legend={"orientation": "h", "x": 0, "y": 1.06, "yanchor": "bottom"},
        polar=charts.polar(
            axes, [nominal + times_ * step * k / 1000 for k in rings], [step * k for k in rings]
        ),
    )


def _ring(radius: float, said: str, role: str, dash: str, shown: bool) -> charts.Trace:
    turn = np.linspace(0, 360, 121)
    return {
        "type": "scatterpolar",
        "mode": "lines",
        "name": said,
        "theta": charts.column(turn, 1),
        "r": [round(radius, 4)] * len(turn),
        "line": {"color": f"@{role}", "width": 1, "dash": dash},
        "hoverinfo": "skip",
        "showlegend": shown,
    }
