"""What heat does to a machine from moment to moment: drivers (a thermometer, a spindle that turns)
and by how much each moves an axis.

A driver is one number of the moment times a shape along one axis. Shapes are tables with nodes, so
a machine at one moment is an ordinary machine with one more table an axis, and cuts, bounds and
inverses need not know of heat.

A scale or screw with thermometers at several places has, between two of them, the temperature that
lies on the line between theirs, and grows by the integral of it from the point that does not move;
beyond the first and the last it is as warm as there.
"""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace

import numpy as np

from postproc.machine.axis import Axis, Driver, Expansion
from postproc.machine.chain import LINEAR, along
from postproc.machine.model import Machine
from postproc.machine.stated import EffectTerm
from postproc.machine.tables import AxisTable
from postproc.units import UM

REFERENCE = 20.0  # degrees Celsius (ISO 1)
# of a travel: the integral of a straight line bends by dT alpha L / 8 at most, a thousandth of that
# is left
PARTS = 32
SPINDLE = ("T_spindle_C", "T_head_C", "T_headstock_C")
FRAME = ("T_bed_C", "T_frame_C", "T_base_C", "T_column_C")
WORK = ("T_work_C", "T_part_C", "T_workpiece_C")


def drivers(
    machine: Machine, columns: Collection[str], spindles: bool
) -> tuple[tuple[Driver, ...], list[str], list[str]]:
    """What moves the machine by these columns of a log, and by the spindle where its turns are
    known; names of columns that the machine asks for and the log lacks; what stays out, in
    words."""
    found: list[Driver] = []
    lacking: list[str] = []
    out: list[str] = []
    # A part that a table turns grows from the table's middle in all directions, not along a slide
    # from `fixed_mm`: its growth is left out, and said.
    turned = next((x for x in machine.chain.rotary if machine.chain.side(x) == "workpiece"), "")
    for x, axis in machine.axes.items():
        if axis.expansion is None:
            continue
        if x not in LINEAR:
            out.append(f"growth of {x}, which turns, is not followed")
        else:
            of_scale = _scale(axis, columns, lacking)
            of_work = [] if turned else _work(axis, columns, lacking)
            found += of_scale + of_work
            out += _stays(axis.expansion, x, turned, bool(of_scale), bool(of_work))
    for term in machine.effects:
        by = _of_effect(machine, term, columns, spindles)
        found += by
        if not by and term.name in ("spindle_growth", "screw_heat", "structure_drift"):
            out.append(
                f"{term.name} of {term.axis} is not followed: no column of the log says what"
                " drives it"
            )
    return tuple(found), lacking, out


def _stays(growth: Expansion, x: str, turned: str, of_scale: bool, of_work: bool) -> Iterator[str]:
    """What of an axis' growth no column follows. turned: the axis that turns the work, or ""."""
    if growth.scale and not of_scale:
        yield f"no column for the scale of {x}: it stays at {growth.scale_at:g} C"
    if growth.work and not of_work:
        why = f"{turned} turns the work" if turned else "no column for the work"
        yield f"{why}: along {x} it stays at {growth.work_at:g} C"


def _first(names: Sequence[str], columns: Collection[str]) -> str:
    """The first of these names that is a column; "": none is."""
    return next((name for name in names if name in columns), "")


def grown(machine: Machine, moving: tuple[Driver, ...], values: np.ndarray) -> Machine:
    """The machine at one moment: values (D,) of its drivers. What they do takes the place of the
    stated temperatures."""
    terms = []
    for letter in dict.fromkeys(driver.letter for driver in moving):
        # the same moment has one table an axis, however many thermometers it has
        own = [
            (d, float(v)) for d, v in zip(moving, values, strict=True) if d.letter == letter and v
        ]
        if own:
            nodes = np.unique(np.concatenate([d.nodes for d, _ in own]))
            both = np.zeros((6, len(nodes)))
            # each driver's shape on common nodes, times its value of the moment: exact, as all are
            # linear between
            both[along(letter)] = sum(
                (v * np.interp(nodes, d.nodes, d.unit) for d, v in own), np.zeros(len(nodes))
            )
            terms.append(
                EffectTerm("heat", letter, {}, None, (AxisTable(letter, nodes, both, both),))
            )
    return replace(machine, effects=machine.effects + tuple(terms), growth=())


def following(machine: Machine, moving: tuple[Driver, ...]) -> Machine:
    """The machine with its drivers, and without the constant growth that they stand for."""
    axes = dict(machine.axes)
    for x, axis in machine.axes.items():
        if (e := axis.expansion) is not None:
            by = {d.name.split()[0] for d in moving if d.letter == x}
            # A driver counts from 20 degrees, so it holds all of the growth: the stated temperature
            # would be corrected a second time. What no column follows keeps its stated one.
            scale_at = REFERENCE if "scale" in by else e.scale_at
            work_at = REFERENCE if "work" in by else e.work_at
            axes[x] = replace(axis, expansion=replace(e, scale_at=scale_at, work_at=work_at))
    names = " ".join(f"{d.name} {d.column}" for d in moving)
    # a program that was corrected by this log is not that of the same machine without: the mark
    # differs
    digest = hashlib.sha256(f"{machine.digest} {names}".encode()).hexdigest()[:8]
    return replace(machine, axes=axes, growth=moving, digest=digest)


def _linear(name: str, axis: Axis, column: str, rate: float) -> Driver:
    """One temperature of the whole scale or part."""
    assert axis.expansion is not None
    nodes = np.array(axis.travel)
    return Driver(
        name, axis.letter, column, REFERENCE, nodes, rate * (nodes - axis.expansion.fixed)
    )


def _scale(axis: Axis, columns: Collection[str], lacking: list[str]) -> list[Driver]:
    growth = axis.expansion
    assert growth is not None
    x = axis.letter
    if not growth.scale:
        return []
    if not growth.sensors:
        own = _first((f"T_scale_{x}_C", f"T_screw_{x}_C"), columns)
        return [_linear(f"scale of {x}", axis, own, growth.scale)] if own else []
    lacking += [c for c, _ in growth.sensors if c not in columns]
    return _by_sensors(axis, growth, columns)


def _by_sensors(axis: Axis, growth: Expansion, columns: Collection[str]) -> list[Driver]:
    """The growth of a scale by those of its thermometers that are recorded."""
    x = axis.letter
    names = [c for c, _ in growth.sensors]
    places = np.array([at for _, at in growth.sensors if at is not None])
    here = [(k, c) for k, c in enumerate(names) if c in columns]
    if len(places) < len(names):  # where they sit is not said: their mean counts
        share = growth.scale / len(names)
        return [_linear(f"scale of {x}", axis, c, share) for _, c in here]
    return [
        Driver(f"scale of {x}", x, c, REFERENCE, *_grown_by(axis, growth, places, k))
        for k, c in here
    ]


def _grown_by(
    axis: Axis, growth: Expansion, places: np.ndarray, k: int
) -> tuple[np.ndarray, np.ndarray]:
    """Nodes mm, and mm per K of the k-th thermometer: the integral of its share from the fixed
    point on."""
    #   share 1 -----.              of the thermometer at p1: the scale before it is as warm, up to
    #                 `.            p2 it has a share that falls in a line, beyond p2 none. What a
    #         0         `--------   place moves by per K is the area from the fixed point to there,
    #               p1   p2   p3    times the rate of the scale.
    low, high = axis.travel
    nodes = np.unique(np.concatenate([np.linspace(low, high, PARTS + 1), places.clip(low, high)]))
    share = np.eye(len(places))[k]
    edges = np.unique(np.concatenate([nodes, places, [growth.fixed]]))
    value = np.interp(edges, places, share)  # a straight line between edges: the trapezium is exact
    total = np.concatenate([[0.0], np.cumsum((value[1:] + value[:-1]) / 2 * np.diff(edges))])
    total -= total[int(np.searchsorted(edges, growth.fixed))]
    return nodes, growth.scale * total[np.searchsorted(edges, nodes)]


def _work(axis: Axis, columns: Collection[str], lacking: list[str]) -> list[Driver]:
    growth = axis.expansion
    assert growth is not None
    if not growth.work:
        return []
    if growth.work_sensors:
        lacking += [c for c in growth.work_sensors if c not in columns]
        # work that is warm is cut too small: the other sign (Axis' Expansion.rate)
        share = -growth.work / len(growth.work_sensors)
        return [_linear("work", axis, c, share) for c in growth.work_sensors if c in columns]
    own = _first(WORK, columns)
    return [_linear("work", axis, own, -growth.work)] if own else []


def _of_effect(
    machine: Machine, term: EffectTerm, columns: Collection[str], spindles: bool
) -> list[Driver]:
    """What goes with a temperature above that at the beginning, or with the spindle's turns."""
    x, p = term.axis, term.parameters
    if x not in machine.axes or x not in LINEAR:
        return []
    nodes = np.array(machine.axes[x].travel)

    name = f"{term.name} of {x}"
    # With a time constant the growth is worked out from the turns that the program names, in um
    # (heat/course.py); without one it goes by a thermometer.
    if term.name == "spindle_growth" and p["tau_s"] > 0:
        named = tuple(sorted(p.items()))
        return [Driver(name, x, "", 0.0, nodes, np.full(2, UM), named)] if spindles else []
    # no thermometer of its kind in the log: the caller says that it is not followed
    columns_of, unit = _unit(term, nodes)
    column = _first(columns_of, columns)
    return [Driver(name, x, column, np.nan, nodes, unit * UM)] if column else []


def _unit(term: EffectTerm, nodes: np.ndarray) -> tuple[tuple[str, ...], np.ndarray]:
    """The columns that an effect without a time constant may go by, and (K,) um per K at nodes."""
    x, p = term.axis, term.parameters
    if term.name == "spindle_growth":
        return SPINDLE, np.full(2, p["um_per_K"])
    if term.name == "screw_heat" and p["tau_s"] == 0:
        # 1e-6 / K * mm, in um: 1e-3; plus what the bearing's own seat moves, um / K
        per_K = p["alpha_ppm_K"] * (nodes - p["held_at_mm"]) * 1e-3 + p["fixed_um_K"]
        return (f"T_screw_{x}_C", f"T_scale_{x}_C"), per_K
    if term.name == "structure_drift" and not any(p[k] for k in ("tau_s", "cycle_s", "creep")):
        return FRAME, np.full(2, p["size_um"])
    return (), np.zeros(2)
