"""One component: zero, line, gaps, several files; and the measured grinder given back by its own
tables."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from pytest import approx

from postproc.calibrate import CalibrationError, Options
from postproc.calibrate.assign import assign
from postproc.calibrate.component import build
from postproc.calibrate.run import calibrate
from postproc.machine.chain import parse
from postproc.recordings import Recording
from tests.calibrate import seed
from tests.calibrate.simulation import (
    Slide,
    everything,
    recording,
    slide,
    three_axes,
    truth,
    two_axes,
)

UM, URAD = 1e-3, 1e-6
GRINDER, MILL = parse("w-b-Z-X-t"), parse("w-X-Y-b-Z-t")
REST = {"X": 80.0, "Z": 200.0}


def test_the_grinders_tables_come_back_where_zeros_and_lines_are_kept():
    """Tables 6.1 and 6.2 as they stand in machines/studer-s36, to 0.05 um."""
    from pathlib import Path

    from postproc.machine.file import read_machine

    tables = read_machine(Path(__file__).resolve().parents[2] / "machines" / "studer-s36").tables
    result = calibrate(
        seed.all_recordings(), Options(GRINDER, keep_lines=True, keep_zero=True)
    ).components
    assert sorted(result) == sorted(seed.COLUMNS)
    for name, component in result.items():
        row = ("EX", "EY", "EZ", "EA", "EB", "EC").index(name[:2])
        table = tables[name[2]]
        assert component.nodes == approx(table.nodes, abs=0)
        one = URAD if name == "EBZ" else UM
        assert component.value[0] / one == approx(table.forward[row] / one, abs=0.05)
        assert component.value[1] / one == approx(table.reverse[row] / one, abs=0.05)


def test_the_grinders_line_is_taken_off_once():
    """EZX: slope of the mean of both directions by numpy's polyfit, -91.9 urad; only B0X is added
    back."""
    stated = -382.352941 * URAD
    result = calibrate(seed.all_recordings(), Options(GRINDER, squareness={"B0X": (stated, None)}))
    component = result.components["EZX"]
    raw = component.cells.mean
    slope, height = np.polyfit(component.nodes, raw.mean(axis=0), 1)
    assert component.slope == approx(slope, rel=1e-9)
    assert component.slope / URAD == approx(-91.9, abs=0.1)
    assert component.lined
    expected = raw - (slope * component.nodes + height)
    expected -= expected[:, 0].mean()
    assert component.value == approx(expected, abs=1e-9)
    x = np.array([[170.0], [0.0]])
    deviation = result.machine.deviation(x, np.zeros((2, 1)))[1, 0]
    # the model itself adds no slope
    assert deviation == approx(component.mean[-1] - component.mean[0], abs=1e-9)
    assert np.polyfit(component.nodes, component.mean, 1)[0] == approx(0.0, abs=1e-12)
    assert not [f for f in result.findings if f.check == "squareness"]


def test_lines_that_are_kept_beside_a_squareness_are_reported():
    options = Options(GRINDER, keep_lines=True, squareness={"B0X": (-382.352941 * URAD, None)})
    told = [
        f for f in calibrate(seed.all_recordings(), options).findings if f.check == "squareness"
    ]
    assert [f.component for f in told] == ["EXZ", "EZX"]
    assert all(f.level == "doubt" and "counts twice" in f.message for f in told)


def made(letter="X", component="EZX", values=None, nodes=None, ways=(1, -1)) -> Recording:
    """One run each way of given values, um."""
    nodes = np.linspace(0, 400, 5) if nodes is None else np.asarray(nodes, float)
    values = values or {1: nodes * 0.01, -1: nodes * 0.01 - 1}
    n = len(nodes)
    columns = {
        "X_mm": np.tile(nodes, len(ways)), "approach_X": np.repeat(np.array(ways, float), n),
        "reading_um": np.concatenate([np.asarray(values[w], float) for w in ways]),
    }  # fmt: skip
    quantity = "displacement" if component == "EXX" else "straightness"
    return Recording(
        "targets",
        {"quantity": quantity, "sensitive": {component[1]: 1.0}},
        columns,
        "r.csv",
        np.arange(n * len(ways)) + 5,
    )


@pytest.mark.parametrize("line", ["least-squares", "end-points"])
def test_both_lines_leave_the_reversal(line):
    """A straight line with a step between the directions: nothing is left but half a um up and half
    down."""
    component = build([assign(made())], Options(MILL, line=line))
    assert component.slope / URAD == approx(10.0)
    assert component.value / UM == approx(np.array([[0.5] * 5, [-0.5] * 5]))
    assert component.reversal / UM == approx(np.ones(5))


def test_the_two_lines_differ_where_the_rail_is_bent():
    """0, 0, 0, 0, 4 um at 0 to 400 mm: through the ends 10 urad; least squares 8 urad, by hand (sum
    (q-200) y / sum (q-200)^2)."""
    bent = made(values={1: [0, 0, 0, 0, 4], -1: [0, 0, 0, 0, 4]})
    assert build([assign(bent)], Options(MILL, line="end-points")).slope / URAD == approx(10.0)
    assert build([assign(bent)], Options(MILL)).slope / URAD == approx(8.0)


@pytest.mark.parametrize("datum, zero", [({}, 0.0), ({"X": 50.0}, 50.0), ({"X": 400.0}, 400.0)])
def test_the_mean_of_both_directions_is_zero_at_the_datum(datum, zero):
    values = {1: [3, 5, 1, 0, 7], -1: [1, 4, -2, 0, 8]}
    component = build([assign(made(component="EXX", values=values))], Options(MILL, datum=datum))
    assert component.datum == zero
    assert np.interp(zero, component.nodes, component.mean) == approx(0.0, abs=1e-12)
    assert np.diff(component.value[0]) / UM == approx([2, -4, -1, 7])


def test_without_position_zero_the_datum_is_the_first_target():
    component = build([assign(made(nodes=[100, 200, 300, 400, 500]))], Options(MILL))
    assert component.datum == 100.0
    with pytest.raises(CalibrationError, match="600 lies outside"):
        build([assign(made())], Options(MILL, datum={"X": 600.0}))


def test_a_direction_that_was_not_read_is_filled_and_reported():
    """In - at 400 nothing (no overrun): 8 from the other direction less the reversal of 300; at 100
    half way."""
    full = made(component="EXX", values={1: [0, 2, 4, 6, 8], -1: [-1, 1, 3, 4, 9]})
    rows = np.delete(np.arange(10), [6, 9])
    component = build([assign(full.pick(rows))], Options(MILL, keep_zero=True))
    assert component.value[1] / UM == approx([-1, 1.0, 3, 4, 6])
    assert component.filled == ((1, 1), (1, 4))
    assert list(np.isnan(component.reversal)) == [False, True, False, False, True]


def test_one_direction_holds_for_both():
    component = build(
        [assign(made(component="EXX", values={-1: [0, 1, 2, 3, 5]}, ways=(-1,)))], Options(MILL)
    )
    assert not component.two_way
    assert component.value[0] == approx(component.value[1])
    assert component.cells.one_way == -1
    assert np.isnan(component.reversal).all()


def test_files_of_one_component_are_joined_whatever_their_zeros_and_lines():
    rng = np.random.default_rng(8)
    machine = two_axes(rng)
    for name in ("EXZ", "EZZ"):
        files = [
            recording(rng, machine["Z"], name, {"X": 80.0}, runs=3, file=f"{i}.csv")
            for i in range(2)
        ]
        component = build([assign(f) for f in files], Options(GRINDER))
        assert (component.cells.n == 6).all()
        off = component.value / UM - truth(machine["Z"], name, {"X": 80.0})
        assert np.abs(off).max() < 0.8
        s = component.cells.scatter.s[0, 0] / UM
        assert s == approx(0.3, abs=0.06)


def test_files_whose_zeros_nothing_connects_are_refused():
    rng = np.random.default_rng(8)
    axis = two_axes(rng)["Z"]
    up, down = (
        recording(rng, axis, "EZZ", {"X": 80.0}, ways=(w,), file=f"{w}.csv") for w in (1, -1)
    )
    with pytest.raises(CalibrationError, match="nothing connects their zeros") as caught:
        build([assign(up), assign(down)], Options(GRINDER))
    assert caught.value.place.file == "-1.csv"


def test_the_same_component_at_another_place_of_the_others_is_refused():
    """The first that is named counts; of an angle both do, a carriage turns as a whole."""
    rng = np.random.default_rng(8)
    axis = two_axes(rng)["Z"]
    parts = [
        recording(rng, axis, n, {"X": x}, file=f"{n}{x:g}.csv")
        for x in (0.0, 100.0)
        for n in ("EZZ", "EBZ")
    ]
    result = calibrate(parts, Options(GRINDER))
    assert [e.message for e in result.refused] == [
        "EZZ is measured at X = 100 here, and at X = 0 in EZZ0.csv, which was named first"
    ]
    assert result.refused[0].place.file == "EZZ100.csv"
    assert (result.components["EZZ"].cells.n == 5).all()
    assert (result.components["EBZ"].cells.n == 10).all()


def test_one_target_is_no_component():
    alone = made().pick(np.array([0, 5]))
    series = replace(
        assign(made()),
        **{
            n: getattr(assign(made()), n)[[0, 5]]
            for n in ("position", "approach", "run", "reading", "lines")
        },
    )
    assert len(alone) == 2
    with pytest.raises(CalibrationError, match="1 target"):
        build([series], Options(MILL))


# -- what more runs do not lessen ------------------------------------------------------------------


def test_the_instrument_counts_in_full_and_noise_does_not():
    """u = 0.5 um of the instrument beside a scatter of 0.3 / sqrt(20): the square root of the sum
    of squares."""
    rng = np.random.default_rng(3)
    part = recording(rng, two_axes(rng)["Z"], "EZZ", {"X": 80.0}, runs=20)
    scatter = build([assign(part)], Options(GRINDER)).u
    stated = replace(part, head=part.head | {"u_um": 0.5})
    assert build([assign(stated)], Options(GRINDER)).u / UM == approx(np.hypot(0.5, scatter / UM))
    assert build([assign(stated)], Options(GRINDER, u_random=True)).u == approx(scatter)
    # less the mean of two at the datum
    assert scatter[0, 5] / UM == approx(0.3 * (1 / 20 + 1 / 40) ** 0.5, rel=0.05)


def test_means_without_any_scatter_are_not_compared_with_it():
    """One run of an instrument whose u is said to be 0: chi-squared would be without bounds."""
    exact = made()
    component = build([assign(replace(exact, head=exact.head | {"u_um": 0.0}))], Options(GRINDER))
    assert component.noise is None and component.small == ""


def test_the_temperature_counts_with_the_length_from_the_datum():
    """0.4 K of a steel scale at 510 mm: 11.5e-6 * 0.4 * 510 mm = 2.35 um; at the datum nothing."""
    rng = np.random.default_rng(3)
    part = recording(rng, two_axes(rng)["Z"], "EZZ", {"X": 80.0}, runs=20)
    cold, warm = (
        build([assign(part)], Options(GRINDER, u_temperature=t)).u / UM for t in (0.0, 0.4)
    )
    assert np.sqrt(warm[0, -1] ** 2 - cold[0, -1] ** 2) == approx(2.346, abs=1e-3)
    assert warm[0, 0] == cold[0, 0]


# -- where it was measured -------------------------------------------------------------------------


def test_measured_at_names_the_axes_of_the_arm_only():
    """w-X-Y-b-Z-t: the arm of Z is the tool alone, of Y it is Z, of X it is Y and Z."""
    rng = np.random.default_rng(2)
    rest = {"X": 200.0, "Y": 150.0, "Z": -100.0}
    result = calibrate(everything(rng, three_axes(rng), rest), Options(MILL))
    assert result.measured_at == {"X": {"Y": 150.0, "Z": -100.0}, "Y": {"Z": -100.0}, "Z": {}}
    assert result.optics == {"X": "tool", "Y": "tool", "Z": ""}


def test_the_measured_point_counts():
    """Along X, which Z carries, as a position; along Z, where no axis makes an arm, in the
    translations: EXZ - 120 EBZ."""
    at, away = (
        calibrate(
            everything(np.random.default_rng(2), two_axes(np.random.default_rng(2)), REST),
            Options(GRINDER, point=p),
        )
        for p in ((5.0, 0.0, 0.0), (5.0, 0.0, 120.0))
    )
    assert at.measured_at["Z"] == away.measured_at["Z"] == {"X": 85.0}
    less = at.components["EXZ"].value - away.components["EXZ"].value
    assert less == approx(120.0 * away.components["EBZ"].value, abs=1e-9)
    assert np.abs(less).max() > 1 * UM
    # At the measured point and at rest the machine deviates by what the laser said.
    place, sense = np.array([[REST["X"]], [200.0]]), np.ones((2, 1))
    rows = [at.machine.letters.index(x) for x in "XZ"]
    said, same = (r.machine.deviation(place[rows], sense)[:, 0] for r in (at, away))
    assert said == approx(same, abs=1e-9)


def test_components_measured_at_two_places_are_brought_together_with_the_angles():
    rng = np.random.default_rng(6)
    axis: Slide = slide(rng, "X", np.linspace(0, 400, 17), ("EXX", "EYX", "EBX", "ECX"), ("Y", "Z"))
    here, there = {"Y": 100.0, "Z": 0.0}, {"Y": 100.0, "Z": -250.0}
    parts = [
        recording(rng, axis, n, here if n == "EXX" else there, noise=0.02)
        for n in ("EXX", "EBX", "ECX")
    ]
    axis.forward["EAX"] = axis.reverse["EAX"] = 12 * np.sin(axis.targets / 100)
    parts += [recording(rng, axis, n, there, noise=0.02) for n in ("EYX", "EAX")]
    result = calibrate(parts, Options(MILL))
    assert result.measured_at["X"] == here
    # roll times 250 mm is about 3 um: without it the straightness would be that much off
    off = result.components["EYX"].value / UM - truth(axis, "EYX", here)
    line = np.polyfit(axis.targets, off.mean(axis=0), 1)
    assert np.abs(off - np.polyval(line, axis.targets)).max() < 0.2
    assert any("carried there with EAX" in f.message for f in result.findings)
    lacking = calibrate([p for p in parts if p.file != "EAX.csv"], Options(MILL))
    assert any("not measured: EAX" in f.message and "2.5 um" in f.message for f in lacking.findings)


@pytest.mark.parametrize("name", ["EZZ", "EXZ"])
@pytest.mark.parametrize(
    "ratio, refused", [(0.0, True), (2.0, True), (-1.0, True), (1.0, False), (0.9, False)]
)
def test_before_and_after_make_no_map_together(name, ratio, refused):
    """The same axis with so much of its deviation, each with its own zero and line of the
    set-up."""
    rng = np.random.default_rng(11)
    axis = two_axes(rng)["Z"]
    axis = Slide(
        "Z",
        axis.targets,
        {name: axis.forward[name]},
        {name: axis.reverse[name]},
        ("X",),
        axis.measured_at,
    )
    other = Slide(
        "Z",
        axis.targets,
        {name: ratio * axis.forward[name]},
        {name: ratio * axis.reverse[name]},
        ("X",),
        axis.measured_at,
    )
    parts = [
        recording(rng, a, name, {"X": 30.0}, file=f)
        for a, f in ((axis, "first.csv"), (other, "second.csv"))
    ]
    if refused:
        with pytest.raises(CalibrationError, match="times here what it is in first.csv") as error:
            calibrate(parts, Options(GRINDER))
        assert float(error.value.message.split()[2]) == approx(ratio, abs=0.05)
    else:
        assert name in calibrate(parts, Options(GRINDER)).components


def test_a_head_that_says_compensated_is_believed():
    rng = np.random.default_rng(12)
    axis = two_axes(rng)["Z"]
    parts = [recording(rng, axis, n, {"X": 30.0}, compensated=n == "EXZ") for n in ("EZZ", "EXZ")]
    with pytest.raises(
        CalibrationError, match="EZZ.csv was measured before compensation, and EXZ.csv after it"
    ):
        calibrate(parts, Options(GRINDER))
    found = calibrate(parts[1:], Options(GRINDER)).findings
    assert any(f.check == "state" and "what was left" in f.message for f in found)


def test_the_temperature_of_a_scale_has_a_part_in_a_length_alone():
    """1 K on 360 degrees of C is no length: EXC is as well known as without it; EXX over 300 mm is
    known by 11.5e-6 * 300 mm = 3.45 um less."""
    rng = np.random.default_rng(1)
    for letter, far, extra in (("C", 360.0, 0.0), ("X", 300.0, 3.45 * UM)):
        targets = np.tile(np.linspace(0.0, far, 7), 4)
        unit = "deg" if letter == "C" else "mm"
        columns = {
            "run": np.repeat([1.0, 2.0, 3.0, 4.0], 7),
            f"{letter}_{unit}": targets,
            f"approach_{letter}": np.tile([1.0, -1.0], 2).repeat(7),
            "reading_um": rng.normal(0, 0.1, 28),
        }
        head = {"quantity": "displacement", "sensitive": {"X": 1.0}}
        one = assign(Recording("targets", head, columns, "c.csv", np.arange(28)))
        plain, warm = (build([one], Options(MILL, u_temperature=k)) for k in (0.0, 1.0))
        assert one.component == f"EX{letter}"
        assert np.sqrt(warm.u**2 - plain.u**2)[:, -1] == approx(extra, abs=1e-9)


@pytest.mark.parametrize("ways", [(-1,), (1,)])
def test_a_file_in_one_direction_is_joined_to_both_in_its_own(ways):
    """The first file was read in one direction, the second, which lies 7 um higher and reverses by
    4 um, in both: the zero of the second follows from the direction that both have."""
    nodes = np.linspace(0.0, 300.0, 7)

    def made(ways, zero):
        columns = {
            "run": np.ones(7 * len(ways)),
            "X_mm": np.tile(nodes, len(ways)),
            "approach_X": np.repeat(np.array(ways, float), 7),
            "reading_um": np.concatenate([zero + 2.0 * way + nodes / 30 for way in ways]),
        }
        head = {"quantity": "displacement", "sensitive": {"X": 1.0}}
        rows = np.arange(len(columns["run"]))
        return assign(Recording("targets", head, columns, "x.csv", rows))

    found = build([made(ways, 0.0), made((1, -1), 7.0)], Options(MILL))
    assert found.cells.s[found.cells.n > 1] == approx(0.0, abs=1e-12)
    assert found.reversal == approx(4.0 * UM)
