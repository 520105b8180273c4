"""The components of a calibration as a picture: means of both directions with their band of 2 u.
Needs matplotlib."""

from __future__ import annotations

import io
from typing import Any

import numpy as np

from postproc.calibrate.assign import place_name, unit_of
from postproc.calibrate.calibration import Calibration
from postproc.calibrate.component import Component
from postproc.errors import GcompError
from postproc.style import LIGHT, PAPER, made_by

APPROACHED = {1: "approached in +", -1: "approached in \N{MINUS SIGN}", 0: "one direction"}
FORWARD, REVERSE, BOTH, INK, FAINT = (
    LIGHT[role] for role in ("plus", "minus", "mean", "ink", "rule")
)
FORMATS = ("png", "svg", "pdf")


def draw(calibration: Calibration, kind: str) -> bytes:
    """The picture as a file of `kind` (png, svg, pdf). Raises GcompError where matplotlib is not
    installed."""
    try:
        from matplotlib import rc_context
    except ImportError:
        raise GcompError(
            "a figure needs matplotlib, which is not installed", "pip install 'gcomp[figures]'"
        ) from None
    with rc_context(PAPER):
        return _drawn(calibration, kind)


def _drawn(calibration: Calibration, kind: str) -> bytes:
    from matplotlib.figure import Figure

    left = {c.name for c, _ in calibration.left_out}
    shown = sorted(calibration.measured.values(), key=lambda c: ("XYZABC".index(c.letter), c.name))
    columns = 1 if len(shown) < 2 else 2 if len(shown) < 7 else 3
    rows = -(-len(shown) // columns)
    figure = Figure(figsize=(4.6 * columns, 2.7 * rows + 0.5), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False).ravel()
    for axis, component in zip(axes, shown, strict=False):
        _component(axis, calibration, component, component.name in left)
    for axis in axes[len(shown) :]:
        axis.set_visible(False)
    known = any(np.isfinite(c.u).any() for c in shown)
    bands = "bands: \N{PLUS-MINUS SIGN}2u, 95 %" if known else "uncertainty not known"
    figure.suptitle(f"Deviation = actual \N{MINUS SIGN} commanded; {bands}", fontsize=9, color=INK)
    out = io.BytesIO()
    figure.savefig(out, format=kind, dpi=130, metadata=made_by(kind))
    return out.getvalue()


def _outliers(axis: Any, calibration: Calibration, component: Component, one: float) -> None:
    """Readings that were taken as outliers. one: mm or rad of a unit of the ordinate."""
    for n, outlier in enumerate(o for o in calibration.outliers if o.component == component.name):
        k = int(np.argmin(np.abs(component.nodes - outlier.position)))
        way = 1 if outlier.approach < 0 and component.two_way else 0
        # the reading's distance from its mean, at the mean as it is drawn (zero and line taken off)
        height = (component.value[way, k] + outlier.value - component.cells.mean[way, k]) / one
        if np.isfinite(height):
            axis.plot(
                outlier.position, height, "x", color=INK, markersize=7,
                label=None if n else "outlier",
            )  # fmt: skip


def _component(axis: Any, calibration: Calibration, component: Component, left_out: bool) -> None:
    unit, one = unit_of(component.name)
    shown_unit = {"um": "µm", "urad": "µrad"}[unit]
    if component.two_way:
        ways = [(0, FORWARD, APPROACHED[1], "o"), (1, REVERSE, APPROACHED[-1], "s")]
    else:
        ways = [(0, BOTH, APPROACHED[component.cells.one_way], "o")]
    for way, colour, label, marker in ways:
        value, u = component.value[way] / one, component.u[way] / one
        if np.isfinite(u).any():
            axis.fill_between(
                component.nodes, value - 2 * u, value + 2 * u, color=colour, alpha=0.2, linewidth=0
            )
        axis.plot(
            component.nodes, value, color=colour, marker=marker, markersize=2.5, linewidth=1.0,
            label=label,
        )  # fmt: skip
    _outliers(axis, calibration, component, one)
    axis.axhline(0, color=FAINT, linewidth=0.6, zorder=0)
    note = " (left out)" if left_out else " (line off)" if component.lined else ""
    axis.set_title(component.name + note, loc="left")
    axis.set_xlabel(f"{component.letter}, {place_name(component.letter)}")
    axis.set_ylabel(f"deviation, {shown_unit}")
    axis.grid(True)
    axis.legend(fontsize=7, frameon=False)
