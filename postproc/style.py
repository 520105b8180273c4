"""Every colour and size of pages and figures, in light and in dark.

Hues are Okabe and Ito's, which people with any common colour blindness tell apart (Okabe, Ito:
Color Universal Design, 2008); in dark they are lighter. A role is one meaning: figures name roles
("@before"), never colours.
"""

from __future__ import annotations

from typing import Any

LIGHT = {
    "ground": "#ffffff",
    "panel": "#f5f7f9",
    "ink": "#1b1f24",
    "muted": "#59636e",
    "rule": "#d5dbe1",
    "grid": "#e6eaee",
    "link": "#0b62a4",
    "nominal": "#8a939d",
    "before": "#d55e00",
    "after": "#008a66",
    "command": "#0072b2",
    "limit": "#b3123f",
    "plus": "#0072b2",
    "minus": "#d55e00",
    "still": "#7b848e",
    "mean": "#1b1f24",
    "held": "#008a66",
    "mark": "#b3123f",
    "u": "rgba(120, 100, 190, 0.22)",
    "noise": "rgba(110, 120, 130, 0.18)",
    "plus-fill": "rgba(0, 114, 178, 0.16)",
    "minus-fill": "rgba(213, 94, 0, 0.16)",
    "good": "#00734f",
    "bad": "#b3123f",
    "open": "#8a6100",
}
DARK = {
    "ground": "#14181d",
    "panel": "#1d232a",
    "ink": "#e6eaee",
    "muted": "#a3adb8",
    "rule": "#3a434d",
    "grid": "#2a3138",
    "link": "#7cc0f2",
    "nominal": "#8f99a4",
    "before": "#ff9a4d",
    "after": "#35c79b",
    "command": "#62b8f0",
    "limit": "#ff7396",
    "plus": "#62b8f0",
    "minus": "#ff9a4d",
    "still": "#9aa4ae",
    "mean": "#e6eaee",
    "held": "#35c79b",
    "mark": "#ff7396",
    "u": "rgba(170, 150, 240, 0.25)",
    "noise": "rgba(160, 170, 180, 0.18)",
    "plus-fill": "rgba(98, 184, 240, 0.18)",
    "minus-fill": "rgba(255, 154, 77, 0.18)",
    "good": "#35c79b",
    "bad": "#ff7396",
    "open": "#f0c560",
}
# From little to much; each step is seen on white and on black, and its lightness falls evenly.
SEQUENTIAL = [[0.0, "#74b9d6"], [0.35, "#e3c75a"], [0.65, "#ee8a3a"], [1.0, "#b3123f"]]
FONT = 'system-ui, "Segoe UI", Roboto, "DejaVu Sans", sans-serif'


# Figures on paper (--figure): matplotlib's settings, in the light roles.
PAPER: dict[Any, Any] = {
    "font.size": 9,
    "text.color": LIGHT["ink"],
    "axes.labelcolor": LIGHT["ink"],
    "axes.edgecolor": LIGHT["rule"],
    "axes.titlecolor": LIGHT["ink"],
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "grid.color": LIGHT["grid"],
    "grid.linewidth": 0.6,
    "xtick.color": LIGHT["muted"],
    "ytick.color": LIGHT["muted"],
    "svg.hashsalt": "gcomp",
}


def made_by(kind: str) -> dict[str, str | None]:
    """What a figure says of itself, by its ending: who made it, and no date, so that the same
    figure is the same file."""
    dates = {"svg": "Date", "pdf": "CreationDate"}
    who: dict[str, str | None] = {"Software" if kind == "png" else "Creator": "gcomp"}
    return who | ({dates[kind]: None} if kind in dates else {})


def variables(roles: dict[str, str]) -> str:
    """Roles as CSS custom properties."""
    return "".join(f"--{name}:{value};" for name, value in roles.items())
