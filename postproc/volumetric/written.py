"""What a fit found: the text of a machine folder, and a report for a person. What the readings do
not tell is not written."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from postproc.machine.chain import ROTARY, XYZ
from postproc.machine.model import Machine
from postproc.machine.tables import COMPONENTS
from postproc.machine.write import KEPT, axis_table, machine_toml
from postproc.units import UM, URAD
from postproc.volumetric.identify import sentences, undetermined
from postproc.volumetric.rows import Rows, unit_of
from postproc.volumetric.solve import Fit, corners
from postproc.volumetric.unknowns import Group


def open_names(fit: Fit) -> set[str]:
    """Names of errors that are not written."""
    return {name for names in undetermined(fit) for name in names}


def _one(group: Group) -> tuple[str, float]:
    """Unit and its size in mm or rad."""
    angle = group.row >= 3 or (group.name[0] in ROTARY and group.name[1] == "0")
    return ("urad", URAD) if angle else ("um", UM)


def _size(fit: Fit, g: Group) -> str:
    """How large an error is, with its u."""
    unit, one = _one(g)
    value, u = fit.values(g)
    if not len(g.nodes):
        return f"{float(value[0]) / one:8.2f} {unit}, u {float(u[0]) / one:.2g}"
    return (
        f"{float(np.ptp(value)) / one:8.2f} {unit} from end to end, u"
        f" {float(u.max()) / one:.2g} at most, {len(g.nodes)} nodes"
    )


def _set_up(r: Rows, left: np.ndarray) -> str:
    """What is left of one set-up's readings."""
    one, name = unit_of(r), "urad" if r.kind == "angle" else "um"
    return (
        f"  {r.name}: {r.kind}, {len(r)} readings, u {r.u / one:.2g} {name}, left"
        f" {float(np.sqrt((left**2).mean())) / one:.2g} {name} (rms)"
    )


def report(fit: Fit, tool: np.ndarray, zero: frozenset[str]) -> str:
    """For a person: set-ups and what is left of them, the errors with u, what is not told."""
    out = [
        f"{sum(map(len, fit.rows))} readings, {fit.unknowns.number} numbers of"
        f" {len(fit.unknowns.groups)} errors"
    ]
    out += [*map(_set_up, fit.rows, fit.left), ""]
    hidden = open_names(fit)
    for g in fit.unknowns.groups:
        out.append(f"  {g.name:<5} {'not told' if g.name in hidden else _size(fit, g)}")
    if zero:
        out.append(f"  taken as zero: {', '.join(sorted(zero))}")
    out.append("")
    for names, text in zip(undetermined(fit), sentences(undetermined(fit)), strict=True):
        way = (
            "; they are not written. Another place, tool length or line may tell them, --zero"
            f" {names[-1]} takes it as zero"
        )
        out.append(text + way)
    if lost := [x for x in _without_lost_motion(fit) if f"B:{x}" not in zero]:
        out.append(
            f"lost motion of {', '.join(lost)} is not in these readings: approach places from both"
            " sides (approach_X = -1 and 1)"
        )
    if fit.widened:
        out.append(
            f"what is left is {np.sqrt(fit.chi):.1f} times the stated u (chi2 {fit.chi:.1f} for"
            f" each of {fit.free} degrees of freedom): every u is widened by it"
        )
    if not fit.unknowns.bare.chain.rotary:
        out.append(
            "u of the deviation at corners and middles of the travels:"
            f" {corners(fit, tool) / UM:.2f} um at most"
        )
    return "\n".join(out)


def as_json(fit: Fit) -> dict[str, Any]:
    """The same as plain dictionaries."""
    found: dict[str, Any] = {
        "format": "gcomp-volumetric/1",
        "readings": sum(map(len, fit.rows)),
        "chi2": fit.chi,
        "free": fit.free,
    }
    hidden = open_names(fit)
    for g in fit.unknowns.groups:
        unit, one = _one(g)
        value, u = fit.values(g)
        found.setdefault("errors", {})[g.name] = {
            "unit": unit, "told": g.name not in hidden, "nodes_mm": g.nodes.tolist(),
            "value": (value / one).tolist(), "u": (u / one).tolist(),
        }  # fmt: skip
    found["not_parted"] = undetermined(fit)
    return found


def _taken(stated: Mapping[str, Any], keys: Iterable[str]) -> dict[str, Any]:
    """What a machine states of these keys, in their order."""
    return {k: stated[k] for k in keys if k in stated}


def _known(fit: Fit) -> list[Group]:
    """The errors that the readings tell."""
    # Errors that can not be parted have no value of their own: a sum of two that is right would be
    # written as two that are wrong, and act so elsewhere.
    hidden = open_names(fit)
    return [g for g in fit.unknowns.groups if g.name not in hidden]


def folder(
    fit: Fit, like: Mapping[str, Any], head: Mapping[str, Any], tool: np.ndarray, files: list[str]
) -> dict[str, str]:
    """File name to text of the machine that was found. like: machine.toml of the machine that was
    measured; head: name, title."""
    letters = fit.unknowns.bare.letters
    known = _known(fit)
    data: dict[str, Any] = {
        "format": "gcomp-machine/1",
        **head,
        **_taken(like, ("control", "chain", "diameter", "reversal", "limits")),
    }
    # unverified: the signs of a new map are shown by a measurement after compensation alone
    data |= {"source": f"gcomp volumetric from {', '.join(files)}", "signs": "unverified"}
    top = "Written by gcomp volumetric. Deviation = actual - commanded, tool against workpiece."
    comments = {"": "\n".join([top, *_of_undetermined(fit)])}
    texts: dict[str, str] = {}
    data["axes"] = {x: _taken(like["axes"][x], KEPT) for x in letters}
    for x in sorted(set(letters) & set(XYZ), key=letters.index):
        if tables := _tables_of(fit, x, known):
            data["axes"][x]["table"] = f"{x}.csv"
            texts |= tables
    if square := _squareness(fit, known):
        data["squareness"] = square
        comments |= {f"squareness.u.{n}": "urad, U = 2 u, 95 %" for n in square["u"]}
    if tool.any():
        length = zip(XYZ, tool.tolist(), strict=True)
        data["tool"] = {x: v for x, v in length if x in letters}
        point = "the point that was measured: change it to where your tool ends"
        comments |= dict.fromkeys((f"tool.{x}" for x in XYZ), point)
    return {"machine.toml": machine_toml(data, comments), **texts}


def _squareness(fit: Fit, known: list[Group]) -> dict[str, Any]:
    """urad by name, and U = 2 u of each; {} where none is known."""
    found = {
        g.name: fit.values(g)
        for g in known
        if not len(g.nodes) and g.name[1] == "0" and g.name[0] in ROTARY
    }
    if not found:
        return {}
    value = {n: round(float(v[0]) / URAD, 4) for n, (v, _) in found.items()}
    return value | {"u": {n: round(2 * float(u[0]) / URAD, 4) for n, (_, u) in found.items()}}


def turned(
    fit: Fit,
    like: Mapping[str, Any],
    head: Mapping[str, Any],
    tables: Mapping[str, str],
    files: list[str],
) -> dict[str, str]:
    """File name to text of the machine with how its rotary axes lie; its slides keep their map.
    tables: the other files of its folder."""
    hidden = open_names(fit)
    # all of the machine's file stays but for its name: only the rotary axes were found
    data = {k: v for k, v in like.items() if k not in ("name", "title")} | dict(head)
    data["source"] = (
        f"{like.get('source', '')}; rotary axes: gcomp volumetric from {', '.join(files)}".lstrip(
            "; "
        )
    )
    data["signs"] = "unverified"
    square = dict(like.get("squareness", {}))
    square_u, location = dict(square.pop("u", {})), dict(like.get("location", {}))
    comments = {
        "": "\n".join(
            ["How the rotary axes lie was found by gcomp volumetric.", *_of_undetermined(fit)]
        )
    }
    for g in fit.unknowns.groups:
        if g.name in hidden:
            continue
        value, u = fit.values(g)
        if g.name[0] in ROTARY:
            square[g.name], square_u[g.name] = (
                round(float(value[0]) / URAD, 4),
                round(2 * float(u[0]) / URAD, 4),
            )
        else:
            location[f"{g.name}_um"] = round(float(value[0]) / UM, 4)
            comments[f"location.{g.name}_um"] = f"u = {float(u[0]) / UM:.2g} um, k = 1"
    data |= {"squareness": square | {"u": square_u}, "location": location}
    return {"machine.toml": machine_toml(data, comments), **tables}


def _of_undetermined(fit: Fit) -> list[str]:
    lost = _without_lost_motion(fit)
    return [f"Not in this map: {text}." for text in sentences(undetermined(fit))] + (
        [f"Not in this map: lost motion of {', '.join(lost)}."] if lost else []
    )


def _without_lost_motion(fit: Fit) -> list[str]:
    """Slides whose lost motion was not asked for: they were not read from both sides."""
    groups = fit.unknowns.groups
    asked = {g.letter for g in groups if g.name.startswith("B:")}
    return [
        x for x in XYZ if x not in asked and any(g.letter == x and len(g.nodes) for g in groups)
    ]


def _tables_of(fit: Fit, x: str, known: list[Group]) -> dict[str, str]:
    """The tables of an axis by name of file; none where nothing of it is known."""
    own = [g for g in known if g.letter == x and len(g.nodes)]
    turned = next((g for g in known if g.name == f"B:{x}"), None)
    if not (own or turned):
        return {}
    return dict(
        zip((f"{x}.csv", f"{x}_uncertainty.csv"), _tables(fit, x, own, turned), strict=True)
    )


def _on_nodes(fit: Fit, group: Group | None, nodes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(K,) an error and its u; zero where it is not among the unknowns."""
    if group is None:
        return np.zeros(len(nodes)), np.zeros(len(nodes))
    # between two nodes u is theirs by shares at most
    # held beyond its own nodes, as the machine's table will be
    value, u = (np.interp(nodes, group.nodes, v) for v in fit.values(group))
    return value, u


def _tables(fit: Fit, letter: str, own: list[Group], turned: Group | None) -> tuple[str, str]:
    """The axis table and the table of its U."""
    # lost motion alone, without any component: a table of two nodes holds it over the travel
    travel = np.array(fit.unknowns.bare.axes[letter].travel)
    nodes = np.unique(np.concatenate([g.nodes for g in own])) if own else travel
    along = f"E{letter}{letter}"
    groups: dict[str, Group | None] = {g.name: g for g in own}
    if turned:
        groups.setdefault(along, None)
    values: dict[str, np.ndarray] = {}
    known: dict[str, np.ndarray] = {}
    for name in sorted(groups, key=lambda n: COMPONENTS.index(n[:2])):
        value, u = _on_nodes(fit, groups[name], nodes)
        unit, one = ("urad", URAD) if COMPONENTS.index(name[:2]) >= 3 else ("um", UM)
        if turned and name == along:
            half, half_u = (float(v[0]) / 2 for v in fit.values(turned))
            #     forward = mean + B / 2, reverse = mean - B / 2     (B:x, forward less reverse)
            # U of either by both, as if independent.
            both = np.hypot(u, half_u)
            values |= {
                f"{name}_um_fwd": (value + half) / one,
                f"{name}_um_rev": (value - half) / one,
            }
            # the folder holds U, k = 2 (machine/uncertainty.py)
            known |= {f"{name}_um_fwd": 2 * both / one, f"{name}_um_rev": 2 * both / one}
        else:
            values[f"{name}_{unit}"], known[f"{name}_{unit}"] = value / one, 2 * u / one
    comment = (
        "fitted to readings all over the volume; zero at the node next to zero, straightness"
        " without a slope"
    )
    return (
        axis_table(letter, nodes, values, [comment]),
        axis_table(letter, nodes, known, ["U, 95 % (k = 2), of the values in the axis table"]),
    )


def without_errors(machine: Machine) -> Machine:
    """The machine as its control believes it to be."""
    axes = {
        x: replace(a.bare, uncertainty=None, measured_at=np.zeros(3))
        for x, a in machine.axes.items()
    }
    return replace(machine, axes=axes, square={}, effects=(), control_tables=(), growth=())
