"""Figures as plain dictionaries in the form of plotly.js, in the house's colours. Colours are roles: "@before"."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

Trace = dict[str, Any]
Figure = dict[str, Any]


def column(values: Any, digits: int = 3) -> list[float | None]:
    """Numbers for a page: so many digits after the point, null where there is none."""
    return [None if not np.isfinite(v) else round(float(v), digits) + 0.0 for v in np.asarray(values, float)]


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


def band(x: Sequence[Any], low: Sequence[Any], high: Sequence[Any], name: str, role: str, **more: Any) -> Trace:
    """An area between two curves; `role` is one of those with "fill" in their meaning."""
    return {
        "type": "scatter", "mode": "lines", "x": [*x, *reversed(x)], "y": [*high, *reversed(low)], "name": name,
        "fill": "toself", "fillcolor": f"@{role}", "line": {"width": 0}, "hoverinfo": "skip", **more,
    }  # fmt: skip


def bars(x: Iterable[Any], y: Iterable[Any], name: str, role: str, **more: Any) -> Trace:
    """Bars; orientation="h": lying."""
    return {"type": "bar", "x": list(x), "y": list(y), "name": name, "marker": {"color": f"@{role}"}, **more}


def figure(
    name: str, caption: str, data: Sequence[Trace], x: str = "", y: str = "", height: int = 340, **layout: Any
) -> Figure:
    """A figure of a page: an identifier, what it shows, curves, the names of its axes with units. layout: further entries
    of plotly.js; `log`: whether its y axis can be switched between even and logarithmic steps, and begins so."""
    log = layout.pop("log", None)
    axis = {"gridcolor": "@grid", "zerolinecolor": "@rule", "linecolor": "@rule", "automargin": True}
    own = {key: {**axis, **layout.pop(key, {})} for key in ("xaxis", "yaxis")}
    own["xaxis"].setdefault("title", {"text": x})
    own["yaxis"].setdefault("title", {"text": y})
    for key in [k for k in layout if k.startswith(("xaxis", "yaxis"))]:
        layout[key] = {**axis, **layout[key]}
    return {
        "id": name, "caption": caption, "height": height, "log": log, "data": list(data),
        "layout": {**own, **layout},
    }  # fmt: skip


def um(values: Any, digits: int = 3) -> list[float | None]:
    """mm as um."""
    return column(np.asarray(values, float) * 1000.0, digits)
