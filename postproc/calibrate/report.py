"""A calibration for a person, and the same as data (format gcomp-calibration/1)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from postproc.calibrate.assign import place_name, unit_of
from postproc.calibrate.calibration import Calibration
from postproc.calibrate.component import Component
from postproc.calibrate.folder import LEFT_OUT, files
from postproc.calibrate.outliers import Outlier
from postproc.calibrate.statistics import t_factor
from postproc.iso.report import aligned
from postproc.units import URAD

FORMAT = "gcomp-calibration/1"
HEADER = ("", "targets", "from", "to", "runs", "range", "B", "s", "largest u", "U95", "unit", "")


def table(calibration: Calibration) -> str:
    """Components, squareness, outliers and findings."""
    rows: list[tuple[str, ...]] = [HEADER]
    left = {c.name: why for c, why in calibration.left_out}
    for component in sorted(calibration.measured.values(), key=_order):
        rows.append(_row(component, left.get(component.name, "")))
    lines = aligned(rows, (0, 10, 11), "")
    lines += ["", *_treated(calibration)]
    for one in calibration.squareness.values():
        u = "u not known" if one.u is None else f"u = {one.u / URAD:.2g}"
        lines.append(f"squareness {one.name}  {one.value / URAD:+.2f} urad, {u}  ({one.source})")
    lines += _outliers(calibration)
    for error in calibration.refused:
        lines += ["", f"not used: {error}"]
    findings: dict[str, list[str]] = {"doubt": [], "note": []}
    for finding in calibration.findings:
        findings.setdefault(finding.level, []).append(finding.message)
    for title, texts in (
        ("not in this map:", calibration.lacks),
        ("in doubt:", findings["doubt"]),
        ("to know:", findings["note"]),
    ):
        if texts:
            lines += ["", title, *(f"  {text}" for text in texts)]
    return "\n".join(lines)


def _treated(calibration: Calibration) -> list[str]:
    """What was done to zeros and lines, before squareness is added."""
    parts = sorted(calibration.components.values(), key=_order)
    zeros = {}
    for c in parts:
        zeros[c.letter] = (
            "as recorded" if c.datum is None else f"{c.letter} = {c.datum:g} {place_name(c.letter)}"
        )
    lines = [
        (
            f"zero (mean of both directions) at: {', '.join(zeros.values())}"
            if any(c.datum is not None for c in parts)
            else "zeros as recorded"
        )
    ]
    if slopes := [f"{c.name} {c.slope / URAD:+.2f}" for c in parts if c.straight]:
        did = (
            "left in"
            if calibration.options.keep_lines
            else f"taken off ({calibration.options.line})"
        )
        lines.append(f"lines of straightness {did}, urad: {', '.join(slopes)}")
    return lines


def _order(component: Component) -> tuple[int, str]:
    return "XYZABC".index(component.letter), component.name


def _row(component: Component, why: str) -> tuple[str, ...]:
    # of what was measured, also where it is left out as small
    numbers = numbers_of(component)
    places = component.nodes
    return (
        component.name, str(len(places)), f"{places[0]:g}", f"{places[-1]:g}",
        _runs(component), f"{numbers['range']:.2f}", _shown(numbers["B"]), _shown(numbers["s"]),
        _shown(numbers["u"]), _shown(numbers["U95"]), unit_of(component.name)[0],
        f"left out: {LEFT_OUT[why]}" if why else "",
    )  # fmt: skip


def _runs(component: Component) -> str:
    n = component.cells.n[component.cells.n > 0]
    least, most = int(n.min()), int(n.max())
    return str(most) if least == most else f"{least}-{most}"


def _shown(value: float | None) -> str:
    return "-" if value is None else f"{value:.2f}"


def numbers_of(component: Component) -> dict[str, float | None]:
    """range, largest B, s (of all targets together), largest u and its U95, in the component's
    unit; None: not known."""
    _, one = unit_of(component.name)
    scatter = component.cells.scatter
    # NaN at targets that were filled in: no reading stands behind their reversal
    b = np.abs(component.reversal)
    s = math.sqrt(float(np.nanmean(scatter.s**2))) / one if scatter.known else None
    u = component.largest_u / one
    return {
        "range": component.span / one,
        "B": float(np.nanmax(b)) / one if np.isfinite(b).any() else None,
        "s": s,
        "u": None if math.isnan(u) else u,
        "U95": None if math.isnan(u) else 2 * u,
    }


def _outliers(calibration: Calibration) -> list[str]:
    if not calibration.outliers:
        return []
    gone = calibration.options.drop_outliers
    lines = [
        "",
        (
            f"{len(calibration.outliers)} outlier{'s' if len(calibration.outliers) > 1 else ''},"
            f" {'left out' if gone else 'kept (--drop-outliers leaves them out)'}:"
        ),
    ]
    return lines + [f"  {sentence(o)}" for o in calibration.outliers]


def sentence(outlier: Outlier) -> str:
    """File, line, value, how far off, against what."""
    unit, one = unit_of(outlier.component)
    way = {1: ", approached in +", -1: ", approached in -"}.get(outlier.approach, "")
    what = (
        "the other runs there"
        if outlier.against == "runs"
        else "its neighbours, which the other direction follows"
    )
    return (
        f"{outlier.file}:{outlier.line}: {outlier.component} at {outlier.component[2]} ="
        f" {outlier.position:g}{way}: {outlier.value / one:+.2f} {unit} is {outlier.off / one:+.2f}"
        f" off {what} ({outlier.times:.0f} standard deviations)"
    )


def data(calibration: Calibration) -> dict[str, Any]:
    """Everything, in um, urad and mm, for JSON: what is not known is None."""
    left = {c.name: why for c, why in calibration.left_out}
    return {
        "format": FORMAT,
        "recordings": files(calibration),
        "components": [
            _component(c, left.get(c.name))
            for c in sorted(calibration.measured.values(), key=_order)
        ],
        "squareness": [
            {
                "name": s.name,
                "value_urad": s.value / URAD,
                "u_urad": None if s.u is None else s.u / URAD,
                "source": s.source,
            }
            for s in calibration.squareness.values()
        ],
        "outliers": [
            {
                "file": o.file,
                "line": o.line,
                "component": o.component,
                "position": o.position,
                "approach": o.approach,
                "value": o.value / unit_of(o.component)[1],
                "off": o.off / unit_of(o.component)[1],
                "unit": unit_of(o.component)[0],
                "times": o.times,
                "against": o.against,
                "dropped": calibration.options.drop_outliers,
            }
            for o in calibration.outliers
        ],
        "refused": [
            {"file": e.place.file if e.place else None, "message": e.message}
            for e in calibration.refused
        ],
        "findings": [
            {
                "check": f.check,
                "level": f.level,
                "component": f.component,
                "message": f.message,
                "numbers": dict(f.numbers),
            }
            for f in calibration.findings
        ],
        "measured_at_mm": calibration.measured_at,
        "not_in_this_map": calibration.lacks,
    }


def _component(component: Component, why: str | None) -> dict[str, Any]:
    unit, one = unit_of(component.name)

    def column(values: np.ndarray) -> list[list[float | None]]:
        ways = values if component.two_way else values[:1]
        return [[float(v) if math.isfinite(v) else None for v in row] for row in ways]

    dof = component.dof
    return {
        "component": component.name,
        "unit": unit,
        "files": [s.file for s in component.series],
        "written": why is None,
        "left_out": why,
        "two_way": component.two_way,
        f"nodes_{place_name(component.letter)}": component.nodes.tolist(),
        "value": column(component.value / one),
        "mean": column(component.cells.mean / one),
        "s_each": column(component.cells.s / one),
        "n": column(component.cells.n.astype(float)),
        "u_each": column(component.u / one),
        "coverage_factor_of_u": 2.0,
        # u is told so that 2 u covers 95 %: who wants the plain u divides by this
        "t_factor_in_u": float(t_factor(dof)) / 2 if math.isfinite(dof) else 1.0,
        "slope": component.slope / one,
        "line_removed": component.lined,
        "datum": component.datum,
        **numbers_of(component),
    }
