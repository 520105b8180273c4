"""A calibration as the text of a machine folder: what a machine model had or the user said, and
what was measured."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from postproc.calibrate.assign import place_name, unit_of
from postproc.calibrate.calibration import Calibration
from postproc.calibrate.component import Component
from postproc.machine.write import KEPT, axis_table, machine_toml, runs_table
from postproc.units import URAD

FORMAT = "gcomp-machine/1"


def folder(
    calibration: Calibration, head: Mapping[str, Any], axes: Mapping[str, Mapping[str, Any]]
) -> dict[str, str]:
    """File name to text.

    head: keys of machine.toml beside the axes and the squareness (name, title, control, diameter,
    tool, offsets, limits, ...); axes: letter to what is said of it (travel, least_increment, ...).
    Everything measured comes from the calibration.
    """
    chain = calibration.options.chain
    data: dict[str, Any] = {"format": FORMAT} | dict(head) | {"chain": "-".join(chain.links)}
    comments = {"": _top(calibration)}
    data["source"] = head.get("source") or _source(calibration)
    # always "unverified": a first map may have every sign turned, and nothing here could tell
    data["signs"] = calibration.machine.signs
    comments["signs"] = "until gcomp accept has seen a measurement after compensation"
    # the chain's order, then axes beside it: of a spindle's C or an indexer nothing was measured
    data["axes"] = {}
    for letter in [*chain.axes, *(x for x in axes if x not in chain.axes)]:
        section, said = _section(calibration, letter, axes.get(letter, {}))
        data["axes"][letter] = section
        comments |= {f"axes.{letter}.{key}": text for key, text in said.items()}
    if calibration.squareness:
        data["squareness"], said = _squareness(calibration)
        comments |= {f"squareness.{key}": text for key, text in said.items()}
    texts: dict[str, str] = {}
    for letter in calibration.axes():
        texts[f"{letter}.csv"] = _table(calibration, letter)
        if known := _uncertainty(calibration, letter):
            texts[f"{letter}_uncertainty.csv"] = known
        texts[f"{letter}_runs.csv"] = _runs(calibration, letter)
    return {"machine.toml": machine_toml(data, comments), **texts}


def _section(
    calibration: Calibration, letter: str, said: Mapping[str, Any]
) -> tuple[dict[str, Any], dict[str, str]]:
    """The keys of an axis in machine.toml, and comments to them; said: what the model has."""
    # of the machine that this one is like: travel and speeds, nothing that was measured
    section = {k: said[k] for k in KEPT if k in said}
    comments: dict[str, str] = {}
    if "travel" not in section:
        section = {"travel": [float(t) for t in calibration.travel(letter)], **section}
        comments["travel"] = f"{place_name(letter)}, from the first target to the last: not stated"
    if "centre" in section:
        comments["centre"] = "of the machine that this one is like: not measured"
    machine = calibration.machine.axes
    if letter in machine and (small := machine[letter].left_out):
        section["left_out"] = list(small)
        comments["left_out"] = "measured, and within the uncertainty"
    if letter in calibration.axes():
        _measured(calibration, letter, section, comments)
    return section, comments


def _measured(
    calibration: Calibration, letter: str, section: dict[str, Any], comments: dict[str, str]
) -> None:
    """Adds the keys of an axis with a table."""
    section["table"] = f"{letter}.csv"
    comments["table"] = "; ".join(dict.fromkeys(c.file for c in calibration.of(letter)))
    at = calibration.measured_at.get(letter, {})
    if at and letter in "XYZ":
        # a rotary axis has no arm from a place of the slides: its centre is its zero
        section["measured_at"] = {x: round(v, 6) for x, v in at.items()}
        comments["measured_at"] = "where the other axes of the arm stood"
    if calibration.optics.get(letter):
        section["optic"] = calibration.optics[letter]
        comments["optic"] = "what the measured point went along with"


def _squareness(calibration: Calibration) -> tuple[dict[str, Any], dict[str, str]]:
    """urad by name, U = 2 u of those that are known, and comments to them."""
    every = calibration.squareness.values()
    data: dict[str, Any] = {s.name: round(s.value / URAD, 6) for s in every}
    # U = 2 u, as all U of a folder are k = 2
    if known := {s.name: round(2 * s.u / URAD, 6) for s in every if s.u is not None}:
        data["u"] = known
    comments = {}
    for one in every:
        u = "u not known" if one.u is None else f"u = {one.u / URAD:.2g}, k = 1"
        comments[one.name] = f"urad, {u}; {one.source}"
        comments[f"u.{one.name}"] = "urad, U = 2 u, 95 %"
    return data, comments


def files(calibration: Calibration) -> list[str]:
    """The recordings that stand behind a calibration, each once."""
    series = [s.file for c in calibration.measured.values() for s in c.series]
    return list(dict.fromkeys(series + [d.file for d in calibration.diagonals]))


def _source(calibration: Calibration) -> str:
    instruments = {
        str(s.head.get("instrument", "")) for c in calibration.measured.values() for s in c.series
    } - {""}
    by = f" ({', '.join(sorted(instruments))})" if instruments else ""
    return f"calibrated by gcomp from {', '.join(files(calibration))}{by}"


def _top(calibration: Calibration) -> str:
    lines = [
        "Written by gcomp calibrate. Deviation = actual - commanded, tool against workpiece, slide"
        " positions, radius."
    ]
    if doubts := [f.message for f in calibration.findings if f.level == "doubt"]:
        lines += ["In doubt when it was written:"] + [
            f"- {' '.join(text.split())}" for text in doubts
        ]
    for component, why in calibration.left_out:
        lines.append(f"Left out: {component.name}, {LEFT_OUT[why]}")
    lines += [f"Not in this map: {text}" for text in calibration.lacks]
    return "\n".join(lines)


LEFT_OUT = {
    "range": "its range is below its expanded uncertainty",
    "noise": "it is what the scatter of the runs alone makes",
}


def treatment(component: Component) -> str:
    """What was done to a component's zero and line."""
    says = []
    if component.straight:
        slope = f"slope {component.slope / URAD:+.2f} urad"
        says.append(
            f"its line was taken off ({slope})"
            if component.lined
            else f"its line is left in ({slope})"
        )
    unit = place_name(component.letter)
    says.append(
        "zero as recorded"
        if component.datum is None
        else f"zero at {component.letter} = {component.datum:g} {unit}, mean of both directions"
    )
    return ", ".join(says)


def _columns(
    calibration: Calibration, component: Component, values: np.ndarray
) -> dict[str, np.ndarray]:
    """Columns of a table, of (2, K) mm or rad in + and in -."""
    unit, one = unit_of(component.name)
    name = f"{component.name}_{unit}"
    if calibration.two_way(component):
        return {f"{name}_fwd": values[0] / one, f"{name}_rev": values[1] / one}
    return {name: values[0] / one}


def _table(calibration: Calibration, letter: str) -> str:
    nodes = calibration.nodes(letter)
    columns: dict[str, np.ndarray] = {}
    comments = []
    for component in calibration.of(letter):
        columns |= _columns(calibration, component, calibration.values(component))
        comments.append(f"{component.name}: {component.file}; {treatment(component)}")
        comments += [f"{component.name}: {text}" for text in component.shifts]
        if len(component.nodes) < len(nodes):
            comments.append(
                f"{component.name}: measured at {len(component.nodes)} of these targets, linear"
                " between them"
            )
    return axis_table(letter, nodes, columns, comments)


def _uncertainty(calibration: Calibration, letter: str) -> str:
    """U = 2 u (95 %) under the columns of the axis table, linear between a component's own targets;
    empty where it is known of none. The mean of both directions is known at least as well as they
    are in the mean (JCGM 100, 5.2.2)."""
    nodes = calibration.nodes(letter)
    columns: dict[str, np.ndarray] = {}
    comments = ["U, 95 % (k = 2), of the values in the axis table"]
    for component in calibration.of(letter):
        if not np.isfinite(component.u).all():
            comments.append(
                f"{component.name}: its u is not known, as of one run and an instrument that states"
                " none"
            )
            continue
        u = 2 * component.u
        if component.two_way and calibration.options.mean:
            # no less than the mean of two u, which are independent at best and alike at worst
            u = np.tile(u.mean(axis=0), (2, 1))
        # Between two of its own targets a value is a share of either: its u is at most theirs by
        # shares, which is what linear u says.
        both = np.stack([np.interp(nodes, component.nodes, way) for way in u])
        columns |= _columns(calibration, component, both)
    return axis_table(letter, nodes, columns, comments) if columns else ""


def _runs(calibration: Calibration, letter: str) -> str:
    """Every value with its runs, their standard deviation s and its u; U95 = 2 u covers 95 %."""
    position = f"{letter}_{place_name(letter)}"
    rows = []
    for component in calibration.of(letter):
        unit, one = unit_of(component.name)
        for way in (0, 1) if component.two_way else (0,):
            for k, node in enumerate(component.nodes):
                u = float(component.u[way, k]) / one
                # runs as recorded, so that whoever doubts a value finds what stands behind it
                rows.append(
                    {
                        position: float(node),
                        "component": component.name,
                        "unit": unit,
                        "approach": (
                            "+-"[way]
                            if component.two_way
                            else {1: "+", -1: "-", 0: ""}[component.cells.one_way]
                        ),
                        "runs": int(component.cells.n[way, k]),
                        "mean": float(component.cells.mean[way, k]) / one,
                        "s": float(component.cells.s[way, k]) / one,
                        "value": float(component.value[way, k]) / one,
                        "u": u,
                        "U95": math.nan if math.isnan(u) else 2 * u,
                    }
                )
    return runs_table(
        letter,
        rows,
        (
            (
                "mean and s: of the runs as recorded. value: mean without its zero and line, as in"
                " the axis table."
            ),
            (
                "u: standard uncertainty of value, the factor t / 2 of few runs in it; U95 = 2 u"
                " covers 95 %."
            ),
        ),
    )
