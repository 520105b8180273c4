"""The page of a machine: every measured error with how well it is known, how the axes lean, what the map makes of the volume."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from postproc.calibrate import Finding
from postproc.machine import overshoot
from postproc.machine.chain import ROTARY, XYZ
from postproc.machine.lacks import lacks
from postproc.machine.model import Axis, Machine
from postproc.machine.tables import COMPONENTS
from postproc.machine.uncertainty import MapUncertainty, micrometres
from postproc.pages import charts
from postproc.pages.frame import Page
from postproc.units import UM, URAD

PLACES = 400  # of a curve: tables have fewer nodes, effects are drawn as tables too
GRID, ARROWS, SLICES = 25, 9, 7  # places of a map along an axis, arrows along it, and levels
ROLES = ("plus", "minus", "after", "limit", "open", "still")
ARROW = 0.07  # of the longer side: as long as the largest deviation is drawn
LEAN = 8.0  # degrees, as which the largest angle is drawn


def html(machine: Machine) -> str:
    """The file's text of `page`."""
    return page(machine).html()


def calibrated_html(machine: Machine, name: str, findings: Sequence[Finding]) -> str:
    """The page of a machine that was made of recordings; findings come first: what looks wrong in them."""
    made = page(machine)
    made.title = f"{name}: calibration"
    made.subject = [row for row in made.subject if row[0] not in ("name", "map")]
    told = made.blocks
    made.blocks = told[:1]
    doubts = [f.message for f in findings if f.level == "doubt"]
    if doubts:
        made.mood = "open"
        made.section("In doubt")
        made.listing(doubts)
    made.blocks += told[1:]
    notes = [f.message for f in findings if f.level != "doubt"]
    if notes:
        made.section("To know")
        made.listing(notes)
    return made.html()


def page(machine: Machine) -> Page:
    """The page of a machine."""
    missing = lacks(machine)
    result = Page(
        machine.title or machine.name, _headline(machine, missing), "open" if missing else ""
    )
    result.subject = [
        ("name", machine.name), ("control", machine.control), ("map", machine.digest), ("axes", " ".join(machine.letters)),
        ("reversal", machine.reversal),
    ]  # fmt: skip
    if machine.source:
        result.subject.append(("source", machine.source))
    _tiles(result, machine)
    for axis in machine.axes.values():
        _axis(result, machine, axis)
    _squareness(result, machine)
    _volume(result, machine)
    _said(result, machine, missing)
    return result


def _headline(machine: Machine, missing: list[str]) -> str:
    if machine.is_zero:
        return "The map of this machine is zero: no program is changed."
    largest = float(np.linalg.norm(_deviation(machine, _corners(machine)), axis=0).max())
    known = (
        f"; {len(missing)} things are not in the map (at the end of this page)" if missing else ""
    )
    return f"The map states deviations of up to {largest / UM:.1f} um in the working volume{known}."


def _tiles(result: Page, machine: Machine) -> None:
    stated = sum(len(table.rows) for table in machine.tables.values())
    known = MapUncertainty(machine)
    tiles = [
        (f"{stated}", "components with a table", ""),
        (f"{len(machine.square_stated)}", "squarenesses", ""),
    ]
    if known.parts:
        u = max(
            float(known.length(_corners(machine), np.full_like(_corners(machine), s)).max())
            for s in (-1.0, 1.0)
        )
        tiles.append((f"+- {micrometres(u)} um", "how well the map is known, at worst (95 %)", ""))
    else:
        tiles.append(("not stated", "how well the map is known", ""))
    for letter, axis in machine.axes.items():
        unit = "mm" if letter in XYZ else "degrees"
        tiles.append(
            (f"{axis.travel[0]:g} to {axis.travel[1]:g}", f"travel of {letter}, {unit}", "")
        )
    result.tiles(*tiles)


# -- axis by axis ------------------------------------------------------------------------------------------------------


def _axis(result: Page, machine: Machine, axis: Axis) -> None:
    result.section(f"Axis {axis.letter}")
    table = axis.table
    if table is None or table.is_zero:
        result.text(
            "No error is stated along this axis."
            if table is None
            else "Its table is zero everywhere."
        )
        return
    for rows, unit, scale, what in (
        ([i for i in table.rows if i < 3], "um", UM, "translations"),
        ([i for i in table.rows if i >= 3], "urad", URAD, "rotations"),
    ):
        if rows:
            result.figure(_components(axis, rows, unit, scale, what))
    if axis.left_out:
        result.text(f"Measured, and within the uncertainty: {', '.join(axis.left_out)}.")
    for grid in axis.grids:
        result.text(
            f"Errors that depend on {grid.other} too: {len(grid.nodes)} by {len(grid.others)} places."
        )


def _components(axis: Axis, rows: list[int], unit: str, scale: float, what: str) -> charts.Figure:
    """Curves of some components, both directions, with U as bands."""
    table, data = axis.table, []
    assert table is not None
    x = charts.column(table.nodes, 4)
    place = "mm" if axis.letter in XYZ else "degrees"
    stated = axis.uncertainty.table if axis.uncertainty is not None else None
    for row in rows:
        name, role = f"{COMPONENTS[row]}{axis.letter}", ROLES[row % 3]
        ways = [("+", table.forward[row], stated.forward[row] if stated is not None else None, "solid"),
                ("-", table.reverse[row], stated.reverse[row] if stated is not None else None, "dash")]  # fmt: skip
        if np.array_equal(table.forward[row], table.reverse[row]):
            ways = ways[:1]
        for way, values, u, dash in ways:
            label = name if len(ways) == 1 else f"{name}, approached in {way}"
            if u is not None and axis.uncertainty is not None and row in axis.uncertainty.stated:
                low, high = (charts.column((values + sign * u) / scale, 3) for sign in (-1, 1))
                data.append(
                    charts.band(x, low, high, f"U of {label} (95 %)", "noise", showlegend=False)
                )
            data.append(
                charts.line(
                    x, charts.column(values / scale, 3), label, role, dash=dash, mode="lines+markers", marker={"size": 3, "color": f"@{role}"},
                    hovertemplate=f"{label} at %{{x}} {place}: %{{y:.2f}} {unit}<extra></extra>",
                )
            )  # fmt: skip
    known = "" if stated is not None else " How well they are known is not stated."
    return charts.figure(
        f"axis-{axis.letter}-{what}", f"{what.capitalize()} of {axis.letter}, actual - commanded, over its travel.{known}",
        data, f"{axis.letter}, {place}", unit, 320, xaxis={"range": list(_shown(axis))},
    )  # fmt: skip


def _shown(axis: Axis) -> tuple[float, float]:
    """The travel; of an axis that turns on and on, one turn."""
    low, high = axis.travel
    return (low, high) if axis.letter in XYZ or high - low <= 720.0 else (0.0, 360.0)


# -- squareness --------------------------------------------------------------------------------------------------------


def _squareness(result: Page, machine: Machine) -> None:
    angles = [
        (letter, i, float(v))
        for letter, lean in machine.square.items()
        for i, v in enumerate(lean)
        if v
    ]
    if not angles:
        return
    result.section("Squareness")
    rows = []
    largest = max(abs(v) for *_, v in angles)
    for letter, i, value in angles:
        name = f"{ROTARY[i]}0{letter}"
        u = machine.square_u.get(name)
        reach = (
            float(np.ptp(machine.axes[letter].travel))
            if letter in machine.axes and letter in XYZ
            else np.nan
        )
        rows.append((name, f"{value / URAD:+.1f}", "not stated" if u is None else f"+- {u / URAD:.1f}", "-" if np.isnan(reach) else f"{value * reach / UM:+.1f}"))  # fmt: skip
    result.table(("name", ">angle, urad", ">U (95 %), urad", ">over its travel, um"), rows)
    data, notes, at = [], [], 0.0
    for letter, i, value in [angle for angle in angles if angle[0] in XYZ]:
        # A turn about axis i moves the end of a unit vector along `letter` into the remaining one.
        plane = [k for k in range(3) if k != i]
        other = XYZ[next(k for k in plane if XYZ[k] != letter)]
        turn = np.radians(LEAN) * value / largest
        sign = 1.0 if (XYZ.index(other) - XYZ.index(letter)) % 3 == 1 else -1.0
        top = [at + sign * float(np.sin(turn)), float(np.cos(turn))]
        data += [
            charts.line([at, at], [0, 1], f"{letter} square to {other}", "nominal", dash="dot", showlegend=False, hoverinfo="skip"),
            charts.line([at, at + 0.5], [0, 0], other, "nominal", showlegend=False, hoverinfo="skip"),
            charts.line([at, round(top[0], 4)], [0, round(top[1], 4)], f"{ROTARY[i]}0{letter}", "before", width=3, showlegend=False,
                        hovertemplate=f"{ROTARY[i]}0{letter} {value / URAD:+.1f} urad<extra></extra>"),
        ]  # fmt: skip
        notes += [_note(at + 0.05, 1.12, f"{ROTARY[i]}0{letter} {value / URAD:+.0f} urad"), _note(at + 0.55, 0.0, f"+{other}"), _note(at - 0.06, 0.95, f"+{letter}")]  # fmt: skip
        at += 1.5
    if not data:
        return
    plain = {"visible": False, "fixedrange": True}
    result.figure(
        charts.figure(
            "square", f"How the axes lean: the largest angle is drawn as {LEAN:g} degrees.", data, "", "", 230, annotations=notes,
            xaxis={**plain, "range": [-0.3, max(at, 3.0)]}, yaxis={**plain, "range": [-0.15, 1.25], "scaleanchor": "x"},
        )
    )  # fmt: skip


def _note(x: float, y: float, text: str) -> dict:
    return {"x": round(x, 3), "y": y, "text": text, "showarrow": False, "font": {"color": "@ink"}}


# -- the volume --------------------------------------------------------------------------------------------------------


def _reach(machine: Machine, letter: str) -> tuple[float, float]:
    return machine.reached[letter] if letter in machine.reached else machine.axes[letter].travel


def _slides(machine: Machine) -> list[str]:
    return [x for x in XYZ if x in machine.axes and x in machine.chain.axes]


def _corners(machine: Machine) -> np.ndarray:
    """(A, N) places spread over the volume that programs can reach."""
    axes = [
        np.linspace(*_reach(machine, x), 9) if x in XYZ else np.array([0.0])
        for x in machine.letters
    ]
    return np.stack([g.ravel() for g in np.meshgrid(*axes, indexing="ij")])


def _deviation(machine: Machine, places: np.ndarray) -> np.ndarray:
    """(S, N) mm of the slides: the mean of both directions."""
    rows = [machine.letters.index(x) for x in _slides(machine)]
    below, above = (machine.deviation(places, np.full_like(places, s))[rows] for s in (1.0, -1.0))
    return (below + above) / 2


def _volume(result: Page, machine: Machine) -> None:
    slides = _slides(machine)
    if machine.is_zero or len(slides) < 2:
        return
    across, up = ("Z", "X") if slides == ["X", "Z"] else (slides[0], slides[1])
    third = next((x for x in slides if x not in (across, up)), None)
    levels = np.linspace(*_reach(machine, third), SLICES) if third else np.zeros(1)
    top = 0.0
    drawn = []
    for level in levels:
        heat, tip, size = _slice(machine, across, up, third, float(level))
        top = max(top, size)
        drawn.append((heat, tip))
    step = [_level(across, up, heat, tip, top) for heat, tip in drawn]
    figure = charts.figure(
        "volume", "Size of the deviation (mean of both directions of approach), and where the tool goes: arrows are drawn larger "
        "than they are.", step[-1], f"{across}, mm", f"{up}, mm", 460,
        xaxis={"constrain": "domain", "automargin": False}, showlegend=False,
        yaxis={"constrain": "domain", "automargin": False} | ({"scaleanchor": "x"} if _alike(machine, across, up) else {}),
    )  # fmt: skip
    if third:
        figure["steps"] = {
            "label": f"{third}, mm",
            "values": [f"{v:.4g}" for v in levels],
            "data": step,
            "at": SLICES - 1,
        }
    result.section("In the working volume")
    result.figure(figure)


def _alike(machine: Machine, across: str, up: str) -> bool:
    """Whether two travels may have one scale."""
    a, b = (float(np.ptp(_reach(machine, x))) for x in (across, up))
    return 0.25 < a / b < 6.0


def _slice(machine: Machine, across: str, up: str, third: str | None, level: float):
    """Size of the deviation over a grid in um, arrows as (x, y, dx, dy), and the largest size, mm."""
    slides = _slides(machine)

    def at(count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        a, b = (np.linspace(*_reach(machine, x), count) for x in (across, up))
        places = np.zeros((len(machine.letters), count * count))
        grid = np.meshgrid(a, b)
        places[machine.letters.index(across)], places[machine.letters.index(up)] = (
            g.ravel() for g in grid
        )
        if third:
            places[machine.letters.index(third)] = level
        return a, b, _deviation(machine, places)

    a, b, off = at(GRID)
    size = np.linalg.norm(off, axis=0)
    heat = (a, b, size.reshape(GRID, GRID) / UM)
    p, q, arrows = at(ARROWS)
    dx, dy = arrows[slides.index(across)], arrows[slides.index(up)]
    x, y = (g.ravel() for g in np.meshgrid(p, q))
    return heat, (x, y, dx, dy), float(size.max())


def _level(across: str, up: str, heat, tip, top: float) -> list[charts.Trace]:
    a, b, z = heat
    x, y, dx, dy = tip
    times = ARROW * max(float(np.ptp(x)), float(np.ptp(y))) / max(top, 1e-9)
    ends_x = [
        v for k in range(len(x)) for v in (round(x[k], 3), round(x[k] + times * dx[k], 3), None)
    ]
    ends_y = [
        v for k in range(len(x)) for v in (round(y[k], 3), round(y[k] + times * dy[k], 3), None)
    ]
    return [
        {
            "type": "heatmap", "x": charts.column(a, 3), "y": charts.column(b, 3), "z": [charts.column(row, 2) for row in z],
            "colorscale": "@sequential", "zmin": 0, "zmax": round(top / UM, 3), "opacity": 0.85, "zsmooth": "best",
            "colorbar": {"title": {"text": "um", "side": "top"}, "thickness": 12, "outlinewidth": 0},
            "hovertemplate": f"{across} %{{x}}, {up} %{{y}}: %{{z:.1f}} um<extra></extra>",
        },
        charts.line(ends_x, ends_y, "deviation", "ink", width=1.3, hoverinfo="skip"),
        charts.dots(charts.column(x + times * dx, 3), charts.column(y + times * dy, 3), "tip", "ink", size=4, hoverinfo="skip"),
    ]  # fmt: skip


# -- in words ----------------------------------------------------------------------------------------------------------


def _said(result: Page, machine: Machine, missing: list[str]) -> None:
    if machine.effects:
        result.section("Effects")
        result.table(
            ("effect", "axis", "parameters"),
            [
                (t.name, t.axis, ", ".join(f"{k} = {v:g}" for k, v in t.parameters.items()))
                for t in machine.effects
            ],
        )
    doubts = overshoot.found(machine)
    if doubts:
        result.section("In doubt")
        result.listing(list(doubts))
    if missing:
        result.section(
            "Not in this map",
            "What nobody measured is zero here, and no program is corrected for it:",
        )
        result.listing(missing)
