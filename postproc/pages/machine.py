"""The page of a machine: every measured error with how well it is known, how the axes lean, what
the map makes of the volume."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from postproc.calibrate import Finding
from postproc.machine import overshoot
from postproc.machine.axis import Axis
from postproc.machine.chain import LINEAR, ROTARY, XYZ
from postproc.machine.lacks import lacks
from postproc.machine.model import Machine
from postproc.machine.stated import EffectTerm
from postproc.machine.tables import COMPONENTS, AxisTable
from postproc.machine.uncertainty import MapUncertainty, micrometres
from postproc.pages import charts
from postproc.pages.frame import Page
from postproc.pages.machine_volume import corners, farthest, volume
from postproc.pages.program import counted
from postproc.units import UM, URAD

ROLES = ("plus", "minus", "after", "limit", "open", "still")
LEAN = 8.0  # degrees, as which the largest angle is drawn


def calibrated(machine: Machine, name: str, findings: Sequence[Finding]) -> Page:
    """The page of a machine that was made of recordings; findings come first: what looks wrong in
    them."""
    made = page(machine)
    made.title = f"{name}: calibration"
    made.subject = [row for row in made.subject if row[0] not in ("name", "map")]
    sections = made.blocks
    made.blocks = sections[:1]
    if doubts := [f.message for f in findings if f.level == "doubt"]:
        made.mood = "open"
        made.section("In doubt")
        made.listing(doubts)
    made.blocks += sections[1:]
    if notes := [f.message for f in findings if f.level != "doubt"]:
        made.section("To know")
        made.listing(notes)
    return made


def page(machine: Machine) -> Page:
    """The page of a machine."""
    missing = lacks(machine)
    result = Page(
        machine.title or machine.name, _headline(machine, missing), "open" if missing else ""
    )
    result.subject = [
        ("name", machine.name), ("control", machine.control), ("map", machine.digest),
        ("axes", " ".join(machine.letters)), ("reversal", machine.reversal),
    ]  # fmt: skip
    if machine.source:
        result.subject.append(("source", machine.source))
    _tiles(result, machine)
    for axis in machine.axes.values():
        _axis(result, machine, axis)
    _squareness(result, machine)
    volume(result, machine)
    _said(result, machine, missing)
    return result


def _headline(machine: Machine, missing: list[str]) -> str:
    if machine.is_zero:
        return f"The map of this machine is zero: no program is changed{_warm(machine)}."
    largest = farthest(machine)
    are = "is" if len(missing) == 1 else "are"
    things = counted(len(missing), "thing")
    known = f"; {things} {are} not in the map (at the end of this page)" if missing else ""
    return f"The map states deviations of up to {largest / UM:.1f} um in the working volume{known}."


def _warm(machine: Machine) -> str:
    """What a machine may be corrected for although its map is zero: heat, by temperatures."""
    spins = any(term.name == "spindle_growth" for term in machine.effects)
    if not spins and all(axis.expansion is None for axis in machine.axes.values()):
        return ""
    return " but for its heat, where --temperatures names a log of it"


def _tiles(result: Page, machine: Machine) -> None:
    stated = sum(len(table.rows) for table in machine.tables.values())
    square = len(machine.square_stated)
    known = MapUncertainty(machine)
    tiles = [
        (f"{stated}", f"component{'s' * (stated != 1)} with a table", ""),
        (f"{square}", f"angle{'s' * (square != 1)} of squareness", ""),
    ]
    if known.parts:
        u = max(
            float(known.length(corners(machine), np.full_like(corners(machine), s)).max())
            for s in (-1.0, 1.0)
        )
        tiles.append((f"+- {micrometres(u)} um", "how well the map is known, at worst (95 %)", ""))
    else:
        tiles.append(("not stated", "how well the map is known", ""))
    for letter, axis in machine.axes.items():
        unit = "mm" if letter in LINEAR else "degrees"
        tiles.append(
            (f"{axis.travel[0]:g} to {axis.travel[1]:g}", f"travel of {letter}, {unit}", "")
        )
    result.tiles(*tiles)


# -- axis by axis ----------------------------------------------------------------------------------


def _axis(result: Page, machine: Machine, axis: Axis) -> None:
    result.section(f"Axis {axis.letter}")
    table = axis.table
    if table is None or table.is_zero:
        result.text(_without_table(machine, axis))
        return
    for some, unit, scale, what in (
        (range(3), "um", UM, "translations"),
        (range(3, 6), "urad", URAD, "rotations"),
    ):
        if rows := [i for i in table.rows if i in some]:
            result.figure(_components(axis, rows, unit, scale, what))
    result.table(
        ("component", ">from", ">to", ">reversal, at most", ">U (95 %), at most", "unit"),
        [_row(axis, i) for i in table.rows],
    )
    if axis.left_out:
        result.text(f"Measured, and within the uncertainty: {', '.join(axis.left_out)}.")
    for grid in axis.grids:
        result.text(
            f"Errors that depend on {grid.other} too: {len(grid.nodes)} by {len(grid.others)}"
            " places."
        )


def _without_table(machine: Machine, axis: Axis) -> str:
    """What an axis has that has no table: effects, growth, or nothing."""
    stated = list(dict.fromkeys(t.name for t in machine.effects if axis.letter in t.axis))
    if axis.expansion is not None:
        stated.append("growth with its temperature")
    if stated:
        return f"No table; what is stated of it (below): {', '.join(stated)}."
    return (
        "No error is stated along this axis."
        if axis.table is None
        else "Its table is zero everywhere."
    )


def _row(axis: Axis, row: int) -> tuple[str, ...]:
    """A component in numbers: its range, its reversal, and how well it is known."""
    assert axis.table is not None
    unit, scale = ("um", UM) if row < 3 else ("urad", URAD)
    both = np.array([axis.table.forward[row], axis.table.reverse[row]]) / scale
    known = axis.uncertainty
    if known is not None and row in known.stated:
        u = max(float(way[row].max()) for way in (known.table.forward, known.table.reverse)) / scale
        stated = f"+- {u:.2f}"
    else:
        stated = "not stated"
    # both: (2, K) forward and reverse, um or urad
    turned = float(np.abs(both[1] - both[0]).max())
    return (
        f"{COMPONENTS[row]}{axis.letter}", f"{both.min():+.2f}", f"{both.max():+.2f}",
        f"{turned:.2f}" if turned else "-", stated, unit,
    )  # fmt: skip


def _components(axis: Axis, rows: list[int], unit: str, scale: float, what: str) -> charts.Figure:
    """Curves of some components, both directions, with U as bands."""
    table, data = axis.table, []
    assert table is not None
    x = charts.column(table.nodes, 4)
    place = "mm" if axis.letter in LINEAR else "degrees"
    for row in rows:
        name, role = f"{COMPONENTS[row]}{axis.letter}", ROLES[row % 3]
        for label, values, u, dash in _ways(axis, table, row, name):
            if u is not None:
                low, high = (charts.column((values + sign * u) / scale, 3) for sign in (-1, 1))
                data.append(
                    charts.band(x, low, high, f"U of {label} (95 %)", "noise", showlegend=False)
                )
            data.append(charts.line(
                x, charts.column(values / scale, 3), label, role, dash=dash, mode="lines+markers",
                marker={"size": 3, "color": f"@{role}"},
                hovertemplate=f"{label} at %{{x}} {place}: %{{y:.2f}} {unit}<extra></extra>",
            ))  # fmt: skip
    doubt = "" if axis.uncertainty is not None else " How well they are known is not stated."
    return charts.figure(
        f"axis-{axis.letter}-{what}",
        f"{what.capitalize()} of {axis.letter}, actual - commanded, over its travel.{doubt}", data,
        f"{axis.letter}, {place}", unit, 320, xaxis={"range": list(_shown(axis))},
    )  # fmt: skip


def _ways(
    axis: Axis, table: AxisTable, row: int, name: str
) -> list[tuple[str, np.ndarray, np.ndarray | None, str]]:
    """The curves of a component: label, values, U or None, dash; one where both directions are the
    same."""
    u: tuple[np.ndarray | None, ...] = (None, None)
    known = axis.uncertainty
    if known is not None and row in known.stated:
        u = (known.table.forward[row], known.table.reverse[row])
    forward, reverse = table.forward[row], table.reverse[row]
    if np.array_equal(forward, reverse):
        return [(name, forward, u[0], "solid")]
    return [
        (f"{name}, approached in +", forward, u[0], "solid"),
        (f"{name}, approached in -", reverse, u[1], "dash"),
    ]


def _shown(axis: Axis) -> tuple[float, float]:
    """The travel; of an axis that turns on and on, one turn."""
    low, high = axis.travel
    return (low, high) if axis.letter in LINEAR or high - low <= 720.0 else (0.0, 360.0)


# -- squareness ------------------------------------------------------------------------------------


def _squareness(result: Page, machine: Machine) -> None:
    angles = machine.angles
    if not angles:
        return
    result.section("Squareness")
    result.table(
        ("name", ">angle, urad", ">U (95 %), urad", ">over its travel, um"),
        [_angle(machine, *angle) for angle in angles.items()],
    )
    largest = max(map(abs, angles.values()))
    data, notes, at = [], [], 0.0
    for name, value in angles.items():
        if name[2] in XYZ:
            curves, said = _lean(name, value, LEAN * value / largest, at)
            data += curves
            notes += said
            at += 1.5
    if not data:
        return
    plain = {"visible": False, "fixedrange": True}
    result.figure(
        charts.figure(
            "square",
            f"How the axes lean: the largest angle is drawn as {LEAN:g} degrees. Dotted: a right"
            " angle.",
            data,
            "",
            "",
            230,
            annotations=notes,
            shape=1.4 / (max(at, 3.0) + 0.3),
            xaxis={**plain, "range": [-0.4, max(at, 3.0)]},
            yaxis={**plain, "range": [-0.15, 1.35], "scaleanchor": "x"},
        )
    )


def _angle(machine: Machine, name: str, value: float) -> tuple[str, ...]:
    """An angle in numbers: how well it is known, and what it makes over the axis' travel."""
    letter = name[2]
    u = machine.square_u.get(name)
    over = "-"
    if letter in machine.axes and letter in XYZ:
        over = f"{value * float(np.ptp(machine.axes[letter].travel)) / UM:+.1f}"
    return (name, f"{value / URAD:+.1f}", "not stated" if u is None else f"+- {u / URAD:.1f}", over)


def _lean(name: str, value: float, degrees: float, at: float) -> tuple[list[dict], list[dict]]:
    """A right angle with its foot at `at`, and beside it the axis as it leans, drawn by so many
    degrees; and what is written there."""
    # A turn about axis i moves the end of a unit vector along `letter` into the remaining one.
    i, letter = ROTARY.index(name[0]), name[2]
    other = next(x for k, x in enumerate(XYZ) if k != i and x != letter)
    turn = np.radians(degrees)
    # Right-handed: about Z a turn takes X towards +Y and Y towards -X; so with `other` next behind
    # `letter` in XYZXY a positive angle leans towards it. Lengths about 1, drawn `degrees` off.
    sign = 1.0 if (XYZ.index(other) - XYZ.index(letter)) % 3 == 1 else -1.0
    top = [at + sign * float(np.sin(turn)), float(np.cos(turn))]
    left = top[0] < at
    return [
        charts.line(
            [at, at],
            [0, 1],
            f"{letter} square to {other}",
            "nominal",
            dash="dot",
            showlegend=False,
            hoverinfo="skip",
        ),
        charts.line([at, at + 0.5], [0, 0], other, "nominal", showlegend=False, hoverinfo="skip"),
        charts.line(
            [at, round(top[0], 4)],
            [0, round(top[1], 4)],
            name,
            "before",
            width=3,
            showlegend=False,
            hovertemplate=f"{name} {value / URAD:+.1f} urad<extra></extra>",
        ),
    ], [
        _note(at, 1.08, f"{name} {value / URAD:+.0f} urad", "center", "bottom"),
        _note(at + 0.52, 0.0, f"+{other}", "left", "middle"),
        # on the side from which the axis leans away
        _note(
            at + (0.03 if left else -0.03), 0.9, f"+{letter}", "left" if left else "right", "middle"
        ),
    ]


def _note(x: float, y: float, text: str, across: str, up: str) -> dict:
    return {
        "x": round(x, 3), "y": y, "text": text, "showarrow": False, "xanchor": across,
        "yanchor": up, "font": {"color": "@ink"},
    }  # fmt: skip


def _stated(term: EffectTerm) -> dict[str, float]:
    """Parameters of an effect but for those that are as they are where they are not stated."""
    usual = getattr(term.module, "OPTIONAL", {})
    return {k: v for k, v in term.parameters.items() if k not in usual or v != usual[k]}


# -- in words --------------------------------------------------------------------------------------


def _said(result: Page, machine: Machine, missing: list[str]) -> None:
    if machine.effects:
        result.section("Effects")
        result.table(
            ("effect", "axis", "parameters"),
            [
                (t.name, t.axis, ", ".join(f"{k} = {v:g}" for k, v in _stated(t).items()))
                for t in machine.effects
            ],
        )
    if heated := [x for x, axis in machine.axes.items() if axis.expansion is not None]:
        result.section(
            "Heat",
            f"{', '.join(heated)}: growth with temperature is stated; --temperatures LOG follows it"
            " along a program.",
        )
    if doubts := overshoot.found(machine):
        result.section("In doubt")
        result.listing(list(doubts))
    if missing:
        result.section(
            "Not in this map",
            "What was not measured is zero here, and no program is corrected for it:",
        )
        result.listing(missing)
