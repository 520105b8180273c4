"""Figures as plain dictionaries in the form of plotly.js, in the house's colours. Colours are
roles: "@before"."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

Trace = dict[str, Any]
Figure = dict[str, Any]


def column(values: Any, digits: int = 3) -> list[float | None]:
    """Numbers for a page: so many digits after the point, null where there is none."""
    return [
        # + 0.0: -0.0 becomes 0.0. A page holds thousands of numbers: each digit that says nothing
        # is left out, and JSON has no NaN.
        None if not np.isfinite(v) else round(float(v), digits) + 0.0
        for v in np.asarray(values, float)
    ]


def line(x: Iterable[Any], y: Iterable[Any], name: str, role: str, **more: Any) -> Trace:
    """A curve."""
    dash, width = more.pop("dash", "solid"), more.pop("width", 1.6)
    return {
        "type": "scatter", "mode": "lines", "x": list(x), "y": list(y), "name": name,
        "line": {"color": f"@{role}", "width": width, "dash": dash}, **more,
    }  # fmt: skip


def dots(x: Iterable[Any], y: Iterable[Any], name: str, role: str, **more: Any) -> Trace:
    """Points."""
    size, symbol = more.pop("size", 5), more.pop("symbol", "circle")
    return {
        "type": "scatter", "mode": "markers", "x": list(x), "y": list(y), "name": name,
        "marker": {"color": f"@{role}", "size": size, "symbol": symbol}, **more,
    }  # fmt: skip


def band(
    x: Sequence[Any], low: Sequence[Any], high: Sequence[Any], name: str, role: str, **more: Any
) -> Trace:
    """An area between two curves; `role` is one of those with "fill" in their meaning."""
    return {
        # there along the upper edge and back along the lower one: one closed line, filled
        "type": "scatter", "mode": "lines", "x": [*x, *reversed(x)], "y": [*high, *reversed(low)],
        "name": name, "fill": "toself", "fillcolor": f"@{role}", "line": {"width": 0},
        "hoverinfo": "skip", **more,
    }  # fmt: skip


def bars(x: Iterable[Any], y: Iterable[Any], name: str, role: str, **more: Any) -> Trace:
    """Bars; orientation="h": lying."""
    return {
        "type": "bar", "x": list(x), "y": list(y), "name": name, "marker": {"color": f"@{role}"},
        **more,
    }  # fmt: skip


def figure(
    name: str,
    caption: str,
    data: Sequence[Trace],
    x: str = "",
    y: str = "",
    height: int = 340,
    **layout: Any,
) -> Figure:
    """A figure of a page: an identifier, what it shows, curves, the names of its axes with units.
    layout: further entries of plotly.js; `log`: whether its y axis can be switched between even and
    logarithmic steps, and begins so; `shape`: height by width of what is drawn, where both axes
    have one scale."""
    log, shape = layout.pop("log", None), layout.pop("shape", None)
    axis = {
        "gridcolor": "@grid",
        "zerolinecolor": "@rule",
        "linecolor": "@rule",
        "automargin": True,
    }
    own = {key: {**axis, **layout.pop(key, {})} for key in ("xaxis", "yaxis")}
    own["xaxis"].setdefault("title", {"text": x})
    own["yaxis"].setdefault("title", {"text": y})
    for key in [k for k in layout if k.startswith(("xaxis", "yaxis"))]:
        layout[key] = {**axis, **layout[key]}
    return {
        "id": name, "caption": caption, "height": height, "log": log, "shape": shape,
        "data": list(data),
        "layout": {**own, **layout},
    }  # fmt: skip


def lying(
    name: str,
    caption: str,
    labels: list[str],
    groups: list[tuple[str, str, list[float]]],
    x: str,
    **more: Any,
) -> Figure:
    """Lying bars: (name, role, lengths) for each group, a label for each bar; more: entries of each
    group's bars."""
    data = [
        bars(
            column(sizes, 3),
            labels,
            said,
            role,
            orientation="h",
            cliponaxis=False,
            hovertemplate=f"%{{y}}: %{{x:.3g}}<extra>{said}</extra>",
            **({"text": [f"{v:.3g}" for v in sizes], "textposition": "outside"} | more),
        )
        for said, role, sizes in groups
    ]
    most = max((v for _, _, sizes in groups for v in sizes), default=0.0) or 1.0
    height = 110 + (26 + 16 * (len(groups) - 1)) * len(labels)
    return figure(
        name,
        caption,
        data,
        x,
        "",
        height,
        yaxis={"autorange": "reversed", "gridcolor": "rgba(0,0,0,0)"},
        bargap=0.25,
        xaxis=(
            {"rangemode": "tozero"} if "error_x" in more else {"range": [0, round(1.25 * most, 4)]}
        ),
        showlegend=len(groups) > 1,
    )


def polar(axes: list[str], radii: list[float], labels: list[float]) -> dict:
    """The layout of a polar figure: rings at radii, of which the first and the last, between which
    all curves lie, have labels in um; the axes' own names around."""
    ends = (min(labels), max(labels))
    return {
        "bgcolor": "rgba(0,0,0,0)",
        "domain": {"x": [0.1, 0.9]},  # on a phone the names of the axes stand beside the circle
        "radialaxis": {
            "tickvals": column(radii, 4),
            "ticktext": [f"{v:+g} um" if v in ends else "" for v in labels],
            "ticks": "",
            "tickangle": 0,
            "range": [0, round(max(radii) * 1.04, 4)],
            "gridcolor": "@grid",
            "angle": 22.5,
            "tickfont": {"size": 10, "color": "@muted"},
            "linecolor": "@rule",
        },
        "angularaxis": {
            "tickvals": [0, 90, 180, 270],
            "ticktext": [f"+{axes[0]}", f"+{axes[1]}", f"-{axes[0]}", f"-{axes[1]}"],
            "gridcolor": "@grid",
            "linecolor": "@rule",
        },
    }


def reach(x: Sequence[float | None]) -> list[float]:
    """Where an axis begins and ends: at its first and last place, with room for a dot."""
    known = [v for v in x if v is not None]
    low, high = (min(known), max(known)) if known else (0.0, 1.0)
    edge = 0.015 * max(high - low, 1e-9)
    return [round(low - edge, 4), round(high + edge, 4)]


def limits(values: list[float | None]) -> dict[str, Any]:
    """Bars of an uncertainty, for error_x and error_y."""
    return {"type": "data", "array": values, "thickness": 1, "color": "@ink"}


def um(values: Any, digits: int = 3) -> list[float | None]:
    """mm as um."""
    return column(np.asarray(values, float) * 1000.0, digits)
