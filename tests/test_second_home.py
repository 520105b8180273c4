"""`--offset G30=..`: where the second reference point lies, machine coordinates, mm and radius.

Fanuc B-64484EN, "Second to fourth reference position return (G30)": P2 may be left out, P3 and P4
are other places."""

from __future__ import annotations

import pytest

from postproc.nc import dialects
from postproc.nc.expand.tracker import Tracker
from postproc.nc.interpreter import Interpreter
from postproc.nc.state import Setup
from postproc.offsets import canonical
from postproc.units import TICKS_PER_MM

PLACE = {"X": -5.0, "Y": 7.0, "Z": 90.0}


def stands(dialect: str, *blocks: str) -> dict[str, float | None]:
    """mm by axis; None: unknown."""
    setup = Setup(
        ("X", "Y", "Z"),
        start=dict.fromkeys("XYZ", 1.0),
        offsets={"G54": {"X": 100.0, "Y": 0.0, "Z": 0.0}, "G30": PLACE, "G28": PLACE},
    )
    tracker = Tracker(Interpreter(dialects.load(dialect), setup))
    for block in blocks:
        tracker.take(block.encode())
    state = tracker.state
    return {
        x: state.position[k] / TICKS_PER_MM if state.known[k] else None for k, x in enumerate("XYZ")
    }


@pytest.mark.parametrize("dialect", ["fanuc-mill", "haas", "linuxcnc"])
def test_axes_go_to_the_second_reference_point(dialect):
    """By hand: the work offset has no part in it; an axis that is not named stays."""
    head = ["G90 G54 G21 G17", "G0 X10. Y20. Z30."]
    assert stands(dialect, *head, "G91 G30 Z0.") == {"X": 110.0, "Y": 20.0, "Z": 90.0}
    assert stands(dialect, *head, "G91 G30 X0. Y0. Z0.", "X1.") == PLACE | {"X": -4.0}


def test_further_reference_points_are_not_known():
    head = ["G90 G54 G21 G17", "G0 X10. Y20. Z30."]
    assert stands("fanuc-mill", *head, "G91 G30 P2 Z0.")["Z"] == 90.0
    for p in ("P3", "P4"):
        assert stands("fanuc-mill", *head, f"G91 G30 {p} Z0.") == {"X": 110, "Y": 20, "Z": None}
    assert stands("fanuc-mill", *head, "G91 G30 P3 Z0.", "G30 P2 Z0.")["Z"] == 90.0
    assert stands("fanuc-mill", *head, "G91 G30 Z0.", "G30 P4 Z0.")["Z"] is None


@pytest.mark.parametrize("dialect", ["okuma", "marlin"])
def test_g30_means_other_things_elsewhere(dialect):
    assert stands(dialect, "G90", "G0 X10. Y20. Z30.", "G30 P1")["X"] != PLACE["X"]


@pytest.mark.parametrize("code", ["G28", "G30", "G91 G28"])
def test_without_an_axis_it_is_not_said_what_moves(code):
    """Fanuc: the axes of which the block names an intermediate point (B-64484EN, "Reference
    position return"). Haas: without any, all of them (mill operator's manual, G28)."""
    head = ["G90 G54 G21 G17", "G0 X10. Y20. Z30."]
    assert stands("fanuc-mill", *head, code) == {"X": None, "Y": None, "Z": None}
    assert stands("fanuc-mill", *head, code, "G90 G0 X3.") == {"X": 103.0, "Y": None, "Z": None}
    assert None not in stands("haas", *head, code).values()


def test_its_name():
    assert canonical("g30") == "G30"
