"""Small rules of machines, filter and diagnosis that no other test tells apart from their
neighbours, each by hand."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from postproc import filter as filter_module
from postproc import intake
from postproc.diagnose import abrupt, prose, spectra
from postproc.diagnose import search as search_module
from postproc.diagnose.search import Search
from postproc.errors import ProgramError
from postproc.filter import Filter, setup_of
from postproc.machine import places
from postproc.machine.axis_file import over_turns
from postproc.machine.bounds import Bounds
from postproc.machine.lacks import lacks
from postproc.machine.tables import AxisTable
from postproc.machine.volumetric import VolumetricMap
from postproc.nc import dialects

# -- machines --------------------------------------------------------------------------------------


def table(letter: str, nodes: list[float]) -> AxisTable:
    values = np.zeros((6, len(nodes)))
    return AxisTable(letter=letter, nodes=np.array(nodes), forward=values, reverse=values)


def test_a_full_turn_is_repeated_where_the_travel_asks_for_it():
    """0 to 360 over -90 to 450 degrees; not within the turn, nor half a turn, whose ends hold."""
    turn, half = table("C", [0.0, 180.0, 360.0]), table("C", [0.0, 180.0])
    wide = over_turns(turn, -90.0, 450.0, Path("C.csv"))
    assert wide.nodes[0] <= -90.0 and wide.nodes[-1] >= 450.0
    assert over_turns(turn, 10.0, 350.0, Path("C.csv")) is turn
    assert over_turns(half, -90.0, 450.0, Path("C.csv")) is half


def test_degrees_beyond_a_table_are_not_told_as_mm():
    """C of the five-axis mill is measured for a third of its travel: no correction in mm says how
    far its table must reach."""
    mill = places.load("example-five-axis")
    letter = next(x for x in mill.tables if x not in "XYZ")
    axes = dict(mill.axes)
    axes[letter] = replace(axes[letter], travel=(-720.0, 720.0))
    said = [line for line in lacks(replace(mill, axes=axes)) if line.startswith(f"{letter} ")]
    assert not [line for line in said if "its end values hold" in line or "refused" in line]


def test_a_map_has_the_travel_that_was_asked_for():
    made = VolumetricMap({"X": table("X", [0.0, 100.0])}, ())
    assert made.machine().axes["X"].travel == (0.0, 100.0)
    assert made.machine({"X": (-5.0, 120.0)}).axes["X"].travel == (-5.0, 120.0)


def test_errors_of_an_axis_move_the_tool_by_their_translation_and_their_arm():
    """3, 4 and 12 mm are 13 mm; half a radian at 2 mm one more."""
    own = SimpleNamespace(reach=lambda letter: 2.0)
    errors = np.array([3.0, 4.0, 12.0, 0.0, 0.3, 0.4])
    assert Bounds.at_tip(cast(Any, own), "X", errors) == pytest.approx(14.0)


def test_the_rapid_of_a_machine_is_stated_in_mm_per_min():
    """8000 mm/min are 133.3 mm/s."""
    assert places.load("example-mill").axes["X"].velocity == pytest.approx(8000.0 / 60.0)


# -- the filter ------------------------------------------------------------------------------------


def test_a_line_without_end_is_refused_until_the_program_has_ended(monkeypatch):
    monkeypatch.setattr(intake, "LINE", 20)
    mill = places.load("example-mill")
    filter_ = Filter(mill, dialects.load("linuxcnc"), setup_of(mill))
    filter_.feed(b"G21 G90\n")
    with pytest.raises(ProgramError):
        filter_.feed(b"(" + b"x" * 20)
    filter_ = Filter(mill, dialects.load("linuxcnc"), setup_of(mill))
    filter_.feed(b"G21 G90\nM2\n")
    assert filter_.feed(b"(" + b"x" * 20) == b""


def test_portions_of_many_arcs_end_with_the_line_that_fills_them(monkeypatch):
    """Four arcs of three bytes, two at most: two and two, not three and one."""
    monkeypatch.setattr(filter_module, "MOST_ARCS", 2)
    assert list(filter_module._portions(b"I1\nI2\nI3\nI4\n")) == [b"I1\nI2\n", b"I3\nI4\n"]
    assert list(filter_module._portions(b"I1\nI2\nI3\nI4")) == [b"I1\nI2\n", b"I3\nI4"]


# -- diagnosis -------------------------------------------------------------------------------------


def test_a_jump_is_weighed_by_the_noise_of_each_signal(monkeypatch):
    """2 um where it scatters by 1 um, 4 um by half of it: (2 + 4 * 4) / (1 + 4)."""
    column = np.array([0.0, 0.0, 1.0, 1.0] * 2)
    signals = [np.arange(4), np.arange(4, 8)]
    monkeypatch.setattr(abrupt, "_signals", lambda sets, own: signals)
    left, sigma = column * np.repeat([2.0, 4.0], 4), np.repeat([1.0, 0.5], 4)
    found = abrupt._step(cast(Any, None), left, column, sigma)
    assert found == pytest.approx((18 / 5, 18 / np.sqrt(5)))
    sigma[4:] = 0.0  # took no part
    assert abrupt._step(cast(Any, None), left, column, sigma) == pytest.approx((2.0, 2.0))


def test_a_place_is_told_of_its_own_signal():
    """The laser's X moves, the part's does not: from 10 to 20 mm, and nothing of a rest."""
    rows = SimpleNamespace(
        signals=("laser_mm", "probe_mm"), signal=np.array([0, 0, 1, 1]),
        sees=np.array(["laser", "laser", "part", "part"]),
        state=SimpleNamespace(position={"X": np.array([0.0, 30.0, 5.0, 5.0])}),
    )  # fmt: skip
    place = SimpleNamespace(
        approach="both", signal=0, axis="X", low=10.0, high=20.0, timed=False, file=0,
        rms=1e-3, peak=2e-3, p=0.01,
    )  # fmt: skip
    d = SimpleNamespace(rows=rows, recordings=[SimpleNamespace(file="a.csv")])
    said = prose.where(cast(Any, d), cast(Any, place))
    assert "X from 10.0 to 20.0 mm, in both directions: " in said


def test_the_best_names_are_those_above_the_least_with_their_own_coefficients(monkeypatch):
    """Of four blocks of two columns the third is worth most; the second has its name already, and
    the last less than the least that counts."""
    monkeypatch.setattr(
        "postproc.diagnose.search.plausible", lambda block, values: seen.append(values) or True
    )
    seen: list = []
    blocks = [SimpleNamespace(key=key, width=2) for key in ("a", "b", "b", "c")]
    evidence = SimpleNamespace(
        scan=lambda fit: (np.array([6.0, 7.0, 9.0, 2.0]), np.arange(8.0), None),
        first=[0, 2, 4, 6],
    )
    own = SimpleNamespace(
        sets=SimpleNamespace(
            evidence=evidence, cost=np.zeros(4), blocks=blocks, members=lambda fit: ()
        ),
        least=3.0, _allowed=lambda chosen, k: True,
    )  # fmt: skip
    assert Search._best(cast(Any, own), cast(Any, None), 9) == {"b": 2, "a": 0}
    assert [values.tolist() for values in seen] == [[4.0, 5.0], [0.0, 1.0]]
    assert Search._best(cast(Any, own), cast(Any, None), 1) == {"b": 2}


def test_what_is_periodic_is_looked_for_by_weight(monkeypatch):
    """What is left over the square of its noise; what took no part counts for nothing."""
    sigma, seen = np.array([0.5, 2.0, 0.0]), []
    for name, value in (
        ("shares", {"zero": np.array([1.0, 1.0, 1.0]), "noise": sigma}),
        ("white", sigma),
    ):
        monkeypatch.setattr(search_module, name, lambda evidence, fit, value=value: value)
    monkeypatch.setattr(
        search_module, "found", lambda rows, weighted, noise: seen.append(weighted) or []
    )
    sets = SimpleNamespace(evidence=SimpleNamespace(y=np.array([2.0, 9.0, 5.0])), blocks=[], rows=0)
    Search._look(cast(Any, SimpleNamespace(sets=sets)), cast(Any, SimpleNamespace(fit=None)))
    assert seen[0].tolist() == [1.0 / 0.25, 8.0 / 4.0, 0.0]


def test_samples_between_motions_swing_with_none():
    """64 samples at 50 Hz that swing at 5 Hz: in a motion that is the likeliest frequency, between
    motions there is none to tell."""
    t = np.arange(64) / 50.0
    swing = np.sin(2 * np.pi * 5.0 * t)
    for passage, first in ((0, [5.0]), (-1, [])):
        state = SimpleNamespace(passage=np.full(64, passage), time=t)
        rows = SimpleNamespace(state=state, signal=np.zeros(64, int))
        found = spectra.in_time(cast(Any, rows), swing, np.ones(64))
        assert found[:1] == pytest.approx(first, abs=0.1)
