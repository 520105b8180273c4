"""Corrected arcs: few more blocks than before, and each passes LinuxCNC's own check of its
radii."""

from __future__ import annotations

import random

import numpy as np
import pytest

from postproc.compensate import Options
from postproc.filter import Filter, setup_of
from postproc.machine.file import read_machine
from postproc.nc import dialects
from postproc.verify import Verifier
from tests.linuxcnc import oracle

ARCS = 1500

MACHINE = """format = "gcomp-machine/1"
name = "smooth"
title = "made up: 20 um of smooth deviation"
control = "linuxcnc"
chain = "w-X-Y-b-Z-t"
source = "made up for a test"
[axes.X]
travel = [-120, 520]
least_increment = 0.0001
table = "X.csv"
[axes.Y]
travel = [-120, 420]
least_increment = 0.0001
table = "Y.csv"
[axes.Z]
travel = [-110, 110]
least_increment = 0.0001
[squareness]
C0Y = 20.0
[offsets]
G54 = { X = 0.0, Y = 0.0, Z = 0.0 }
"""


def smooth(folder):
    """Positioning and straightness of X and Y, 20 um from end to end, nodes 25 mm apart."""
    folder.mkdir()
    (folder / "machine.toml").write_text(MACHINE)
    for axis, high, across in (("X", 400, "EYX_um"), ("Y", 300, "EXY_um")):
        place = np.arange(-125, high + 126, 25.0)
        own, side = 10 * np.sin(place / high * np.pi), 8 * np.cos(2 * place / high * np.pi)
        rows = [f"{p:g},{a:.3f},{b:.3f}" for p, a, b in zip(place, own, side, strict=True)]
        (folder / f"{axis}.csv").write_text(
            "\n".join([f"{axis}_mm,E{axis}{axis}_um,{across}", *rows]) + "\n"
        )
    return read_machine(folder)


def arcs(count: int) -> str:
    """A chain of arcs of 1 to 30 mm radius that stays within 300 x 200 mm."""
    rng, x, y = random.Random(7), 200.0, 150.0
    lines = ["G21 G90 G17 G54", f"G0 X{x:.4f} Y{y:.4f} Z0", "G1 F1000 Z-1"]
    while len(lines) < count + 3:
        radius, begin, sweep = rng.uniform(1, 30), rng.uniform(0, 2 * np.pi), rng.uniform(0.3, 5.5)
        i, j = round(-radius * np.cos(begin), 4), round(-radius * np.sin(begin), 4)
        end = begin + sweep
        to_x, to_y = round(x + i + radius * np.cos(end), 4), round(y + j + radius * np.sin(end), 4)
        if 50 < to_x < 350 and 50 < to_y < 250:
            lines.append(f"G3 X{to_x:.4f} Y{to_y:.4f} I{i:.4f} J{j:.4f}")
            x, y = to_x, to_y
    return "\n".join([*lines, "M2", ""])


def by_radius(count: int) -> str:
    """The same with R, a seventh of them near half a turn, and full circles by I J; up to 359
    degrees."""
    rng, x, y = random.Random(8), 200.0, 150.0
    lines = ["G21 G90 G17 G54", f"G0 X{x:.4f} Y{y:.4f} Z0", "G1 F1000 Z-1"]
    while len(lines) < count + 3:
        radius, begin, sweep = (
            rng.uniform(1, 30),
            rng.uniform(0, 2 * np.pi),
            rng.uniform(0.02, 6.27),
        )
        sweep = rng.uniform(0.97, 1.03) * np.pi if rng.random() < 1 / 7 else sweep
        code, i, j = rng.choice([2, 3]), -radius * np.cos(begin), -radius * np.sin(begin)
        end = begin + (sweep if code == 3 else -sweep)
        to_x, to_y = round(x + i + radius * np.cos(end), 3), round(y + j + radius * np.sin(end), 3)
        word = round(radius, 3)
        if rng.random() < 0.1:
            lines.append(f"G{code} I{i:.3f} J{j:.3f}")
        elif 50 < to_x < 350 and 50 < to_y < 250 and np.hypot(to_x - x, to_y - y) < 2 * word:
            lines.append(
                f"G{code} X{to_x:.3f} Y{to_y:.3f} R{word if sweep <= np.pi else -word:.3f}"
            )
            x, y = to_x, to_y
    return "\n".join([*lines, "M2", ""])


@pytest.mark.parametrize(("tolerance", "most", "whole"), [(0.001, 1.9, 0.15), (0.003, 1.35, 0.5)])
def test_arcs_by_radius_and_full_circles_are_drawn_as_proven(tmp_path, tolerance, most, whole):
    """LinuxCNC accepts every arc, and turns as far as the nominal one does; most keep R, some
    circles one block.

    Seen at 1 and 3 um: 1.82 and 1.28 arcs for each, R in 819 of 866 and in 609 of 636 that R arcs
    became, 15 and 44 of 74 circles in one block.
    """
    reason = oracle.available()
    if reason:
        pytest.skip(reason)
    text = by_radius(600)
    setup = setup_of(smooth(tmp_path / "smooth"), start={"X": 0, "Y": 0, "Z": 0})
    filter_ = Filter(
        read_machine(tmp_path / "smooth"),
        dialects.load("linuxcnc"),
        setup,
        Options(tolerance=tolerance),
    )
    verifier = Verifier(filter_)
    output = (filter_.feed(text.encode()) + filter_.finish()).decode()
    assert verifier.passed, verifier.report()
    nominal, made = ([m for m in oracle.motions(t) if m.kind == "arc"] for t in (text, output))
    assert len(nominal) == 600
    assert len(made) < most * len(nominal)
    assert swept(made) == pytest.approx(swept(nominal), abs=0.2)
    lines = output.splitlines()
    assert sum(" R" in line for line in lines) > text.count(" R")
    # what the circles became is among them
    centres = sum(" I" in line and "X" in line for line in lines)
    assert centres < 0.35 * len(made)
    assert sum(" I" in line and "X" not in line for line in lines) > whole * text.count(" I")


def swept(arcs: list) -> float:
    """rad, all arcs together, as LinuxCNC turns them."""
    total = 0.0
    for arc in arcs:
        a = np.arctan2(arc.start[1] - arc.centre[1], arc.start[0] - arc.centre[0])
        b = np.arctan2(arc.end[1] - arc.centre[1], arc.end[0] - arc.centre[0])
        way = (b - a) % (2 * np.pi) if arc.turns > 0 else (a - b) % (2 * np.pi)
        total += way if arc.start[:2] != arc.end[:2] else 2 * np.pi
    return total


def test_growth_is_below_two_and_every_arc_is_accepted(tmp_path):
    reason = oracle.available()
    if reason:
        pytest.skip(reason)
    machine = smooth(tmp_path / "smooth")
    text = arcs(ARCS)
    filter_ = Filter(
        machine,
        dialects.load("linuxcnc"),
        setup_of(machine, start={"X": 0, "Y": 0, "Z": 0}),
        Options(tolerance=0.001),
    )
    verifier = Verifier(filter_)
    output = (filter_.feed(text.encode()) + filter_.finish()).decode()
    assert verifier.passed, verifier.report()
    assert verifier.uncorrected.deviation > 0.008
    growth = output.count("\n") / text.count("\n")
    assert growth < 2.0
    accepted = oracle.motions(output)
    assert sum(m.kind == "arc" for m in accepted) >= ARCS


@pytest.mark.parametrize("units, unit", [("G21", 1.0), ("G20", 25.4)])
def test_arcs_that_miss_their_end_by_nearly_the_limit_are_still_accepted(tmp_path, units, unit):
    """To the last digit what LinuxCNC allows (0.0028284 in, 0.028284 mm), which the correction must
    not raise over the limit: 60 arcs a unit."""
    reason = oracle.available()
    if reason:
        pytest.skip(reason)
    machine = smooth(tmp_path / "smooth")
    rng, limit = random.Random(11), 0.00282 if units == "G20" else 0.02828
    lines = [
        f"{units} G90 G17 G54",
        f"G0 X{200 / unit:.4f} Y{150 / unit:.4f} Z0",
        f"G1 F{1000 / unit:.1f} Z{-1 / unit:.4f}",
    ]
    for _ in range(60):
        x, y, radius = (
            round(rng.uniform(*edge) / unit, 5) for edge in ((60, 340), (60, 240), (5, 25))
        )
        lines += [
            f"G1 X{x:.5f} Y{y:.5f}",
            f"G2 X{x + 2 * radius + limit:.5f} Y{y:.5f} I{radius:.5f} J0",
        ]
    text = "\n".join([*lines, "M2", ""])
    assert len(oracle.motions(text)) > 100
    filter_ = Filter(
        machine,
        dialects.load("linuxcnc"),
        setup_of(machine, start={"X": 0, "Y": 0, "Z": 0}),
        Options(tolerance=0.001),
    )
    output = (filter_.feed(text.encode()) + filter_.finish()).decode()
    assert filter_.summary.changed > 100
    assert len(oracle.motions(output)) > 100
