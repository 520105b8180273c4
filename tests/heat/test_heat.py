"""`--temperatures`: the clock by hand, growth by hand and by another road, the batch law, and what
is refused."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from postproc import cli, effects, recordings
from postproc.commands import reading, reading_options, warming
from postproc.compensate import Compensator, Options
from postproc.effects import State
from postproc.errors import GcompError, Notice
from postproc.heat import clock, follow, log
from postproc.heat.course import spindle_lags
from postproc.machine import growth
from postproc.machine.file import read_machine
from postproc.nc import dialects
from postproc.nc.lexer import lex

ROOT = Path(__file__).resolve().parents[2]
TOML = """format = "gcomp-machine/1"
name = "warm"
control = "linuxcnc"
chain = "w-X-Y-b-Z-t"
[axes.X]
travel = [-10.0, 610.0]
least_increment = 0.0001
max_velocity = 12000.0
heat = {{ scale_um_m_K = 10.0, work_um_m_K = 20.0, fixed_mm = 100.0{more} }}
[axes.Y]
travel = [-10.0, 410.0]
least_increment = 0.0001
max_velocity = 12000.0
[axes.Z]
travel = [-10.0, 410.0]
least_increment = 0.0001
max_velocity = 6000.0
[offsets]
G54 = {{ X = 0.0, Y = 0.0, Z = 0.0 }}
{effects}
"""
SPINDLE = """
[[effect]]
name = "spindle_growth"
axis = "Z"
tau_s = 600.0
um_per_1000_rpm = 5.0
um_per_K = 0.0
housing_um = 2.0
housing_s = 2400.0
"""


def machine(tmp_path, more: str = "", effects: str = "") -> Path:
    (tmp_path / "warm").mkdir(exist_ok=True)
    (tmp_path / "warm" / "machine.toml").write_text(TOML.format(more=more, effects=effects))
    return tmp_path / "warm"


def written(tmp_path, *rows: str) -> Path:
    (tmp_path / "log.csv").write_text("\n".join(rows) + "\n")
    return tmp_path / "log.csv"


def gcomp(*words) -> int:
    return cli.main([*map(str, words)])


def options(folder, *words: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    reading_options.arguments(parser)
    return parser.parse_args(["--machine", str(folder), *map(str, words)])


def filter_of(folder, *words: str):
    asked = options(folder, *words)
    return reading.filter_of(asked, reading.machine_of(asked))


def times(filter_, text: str) -> tuple[clock.Times, clock.ClockState]:
    words = lex(text.encode(), filter_.dialect.grammar, False)
    motions, _, _ = filter_.interpreter.run(words, filter_.modal)
    return clock.run(words, motions, filter_.heat.rates, clock.ClockState())


def test_the_clock_by_hand(tmp_path):
    """X 12000, Z 6000 mm/min at rapid: 100 mm of X are 0.5 s, with 100 mm of Z beside it 1 s; 100
    mm at F600 10 s; a quarter of R 60 at F600 pi * 30 / 10 s; G93 F2 half a minute; an inch at F60
    inch/min 1 s; 50 mm at G95 F0.5 with 600 rpm 10 s."""
    folder = machine(tmp_path)
    f = filter_of(folder, "--temperatures", written(tmp_path, "t_s,T_scale_X_C", "0,20", "9999,20"))
    text = (
        "G21 G90 G54\nG0 X0 Y0 Z0\nG0 X100\nG0 X200 Z100\nG4 P7\nG1 X300 F600\nG17 G2 X360 Y-60 I0"
        " J-60\nG93 G1 X400 F2\nG94 G20 F60\nG1 X16.7480314961\nG21 M3 S600\nG95 G1 Z50 F0.5\n"
    )
    found, clock_state = times(f, text)
    took = (found.end - found.begin) / clock.MICRO
    by_hand = [0.0, 0.5, 1.0, 10.0, np.pi * 30 / 10, 30.0, 1.0, 10.0]
    assert took == pytest.approx(by_hand, abs=2e-6)
    assert clock_state.now / clock.MICRO == pytest.approx(sum(by_hand) + 7.0, abs=1e-5)
    assert (found.begin[3] - found.end[2]) / clock.MICRO == pytest.approx(7.0)


def test_the_way_to_a_hole_is_a_rapid(tmp_path):
    """100 mm of X at 12000 mm/min 0.5 s; 6 mm down at F100 3.6 s, and up at 6000 mm/min 0.06 s:
    the way to the hole was counted at the feed too (64.2 s a hole)."""
    record = written(tmp_path, "t_s,T_scale_X_C", "0,20", "9999,20")
    f = filter_of(machine(tmp_path), "--temperatures", record)
    head = "G21 G90 G54\nG0 X0 Y0 Z5\n"
    found, _ = times(f, f"{head}G81 X100 Z-5 R1 F100\nX200\nG80\n")
    took = (found.end - found.begin) / clock.MICRO
    assert took[1:] == pytest.approx([0.5 + 3.6 + 0.06, 0.5 + 3.6 + 0.06], abs=0.05)


def test_a_whole_circle_without_a_feed_is_counted(tmp_path):
    """It ends where it begins, and was thought to go nowhere."""
    record = written(tmp_path, "t_s,T_scale_X_C", "0,20", "9999,20")
    f = filter_of(machine(tmp_path), "--temperatures", record)
    assert times(f, "G21 G90 G54\nG0 X0 Y0 Z5\nG2 X0 Y0 I10\n")[1].without == 1


def test_a_dwell_of_a_time_that_is_not_known_takes_none(tmp_path):
    """It says none, or one that can only be in another unit."""
    record = written(tmp_path, "t_s,T_scale_X_C", "0,20", "9999,20")
    f = filter_of(machine(tmp_path), "--temperatures", record)
    for dwell, seconds in (("", 0.0), (" P0", 0.0), (" P20000000", 0.0), (" P7", 7.0)):
        _, after = times(f, f"G21 G90 G54\nG0 X0 Y0 Z0\nG4{dwell}\nG1 X100 F600\n")
        assert after.now / clock.MICRO == pytest.approx(10.0 + seconds)


def test_growth_by_hand(tmp_path, capsys):
    """The scale of X goes from 20 to 30 degrees in 1000 s, the work stays at 22: e = 10e-6 * (T -
    20) * (x - 100) - 20e-6 * 2 * (x - 100). At F60 from 0 to 500 the block takes 500 s; at its end
    there are 25 degrees: (50 - 40) um/m of 400 mm are 4.0 um, which the command makes up for. In
    its middle, at 250 s and X 250, there are 22.5: (25 - 40) um/m of 150 mm are -2.25 um. The next
    one, 60 mm at F60, ends at 560 s: (56 - 40) um/m * 460."""
    folder = machine(tmp_path)
    record = written(tmp_path, "t_s,T_scale_X_C,T_work_C", "0,20,22", "1000,30,22")
    program = tmp_path / "a.nc"
    program.write_text("G21 G90 G54\nG1 X0 Y0 Z0 F60\nX500\nX560\nM2\n")
    assert (
        gcomp(
            program,
            "--machine",
            folder,
            "--temperatures",
            record,
            "-o",
            tmp_path / "b.nc",
            "--verify",
            "--tolerance",
            "1um",
        )
        == 0
    )
    lines = (tmp_path / "b.nc").read_text().splitlines()
    ends = np.array([float(line[1:]) for line in lines if line.startswith("X")])
    course = np.array([(0.01 * k * 10 - 40) * (k - 100) * 1e-6 for k in range(561)])
    off = np.array([end + np.interp(end, np.arange(561), course) for end in ends])
    # every end lies where the nominal path is crossed at its own moment: F60 is 1 mm a second
    last = off[-1], off[np.argmin(np.abs(ends - 500))]
    assert last == pytest.approx((560.0, 500.0), abs=0.25e-3 + 5e-5)
    said = capsys.readouterr().err
    assert "by its own clock the program takes 560 s" in said
    deviation = float(said.split("nominal path ")[1].split(" um")[0])
    assert deviation <= 1.05, said


@pytest.mark.parametrize(
    ("dialect", "dwell", "seconds", "told"),
    [
        ("linuxcnc", "G4 P2.5", 2.5, ""),
        ("okuma", "G4 F2.5", 2.5, ""),
        ("mach3", "G4 P2.5", 0.0, "2 dwells (G4) take no time by the program's clock"),
        ("fagor", "G4 K250", 0.0, "write seconds with a point"),
        ("fagor", "G4 K2.5", 2.5, ""),
        ("linuxcnc", "G4 P0", 0.0, ""),
        ("linuxcnc", "G4 P20000000", 0.0, "2 dwells (G4) take no time"),
    ],
)
def test_dwells_whose_time_is_not_known_are_told(tmp_path, dialect, dwell, seconds, told):
    """Two dwells and 100 mm at F600 (10 s); one behind M2 does not count. What no unit is known of
    takes no time, and once for the whole program that is said."""
    folder = machine(tmp_path)
    record = written(tmp_path, "t_s,T_scale_X_C", "0,20", "9999,20")
    f = filter_of(folder, "--temperatures", record, "--dialect", dialect)
    f.feed(f"G90\nG0 X0. Y0. Z0.\n{dwell}\nG1 X100. F600.\n{dwell}\nM2\n{dwell}\n".encode())
    f.finish()
    said = [n for n in f.notices if n.code == "heat dwells"]
    assert len(said) == bool(told)
    assert not told or (told in said[0].message and said[0].size == 2.0)
    takes = next(n.message for n in f.notices if n.code == "heat")
    assert f"takes {10 + 2 * seconds:.0f} s" in takes, takes


def test_a_log_that_never_changes_is_a_stated_temperature(tmp_path, capsys):
    folder = machine(tmp_path)
    program = ROOT / "sample_programs" / "pocket_mill.ngc"
    record = written(tmp_path, "t_s,T_scale_X_C,T_work_C", "0,27,21", "99999,27,21")
    both = []
    for name, more in (("b", ("--temperatures", record)), ("c", ("--temperature", "X=27,work=21"))):
        words = (
            "--machine",
            folder,
            "-o",
            tmp_path / name,
            "--tolerance",
            "1um",
            "--verify",
            "--offset",
            "G54=X200,Y100,Z100",
        )
        assert gcomp(program, *words, *more) == 0
        both.append(
            [line for line in (tmp_path / name).read_text().splitlines() if "GCOMP" not in line]
        )
    one, other = both
    assert len(one) == len(other)
    numbers = [
        [
            float(w[1:])
            for line in text
            for w in line.split()
            if w[0] in "XYZ" and w[1:2] in "-.0123456789"
        ]
        for text in both
    ]
    assert np.abs(np.subtract(*numbers)).max() <= 2.6e-4
    capsys.readouterr()


PROGRAM = "".join(
    f"G1 X{300 + 200 * np.cos(k / 3):.3f} Y{200 + 150 * np.sin(k / 2):.3f}"
    f" Z{100 + 90 * np.sin(k / 5):.3f} F{500 + 37 * k}\n"
    + ("G4 P30\n" if k % 11 == 5 else "")
    + ("G0 Z300\n" if k % 17 == 3 else "")
    for k in range(36)
)
LOG = ["t_s,T_front_C,T_rear_C,T_work_C"] + [
    f"{60 * k},{20 + 6 * (1 - np.exp(-k / 8)):.3f},{20 + 3 * (1 - np.exp(-k / 15)):.3f},{20 + 0.05 * k:.3f}"  # noqa: E501
    for k in range(36)
]
TWO = ", sensors = { T_front_C = 0.0, T_rear_C = 600.0 }"


def test_any_cut_of_the_input_gives_the_same_bytes_and_the_output_keeps_the_tolerance(
    tmp_path, capsys
):
    folder = machine(tmp_path, TWO, SPINDLE)
    record = written(tmp_path, *LOG)
    text = ("G21 G90 G54 M3 S8000\nG0 X0 Y0 Z300\n" + PROGRAM + "M2\n").encode()
    whole = filter_of(folder, "--temperatures", record, "--tolerance", "1um")
    wanted = whole.feed(text) + whole.finish()
    for size in (7, 333):
        f = filter_of(folder, "--temperatures", record, "--tolerance", "1um")
        got = b"".join(f.feed(text[i : i + size]) for i in range(0, len(text), size)) + f.finish()
        assert got == wanted
    (tmp_path / "a.nc").write_bytes(text)
    words = (
        "--machine",
        folder,
        "--temperatures",
        record,
        "--tolerance",
        "1um",
        "--verify",
        "-o",
        tmp_path / "b.nc",
    )
    assert gcomp(tmp_path / "a.nc", *words) == 0
    said = capsys.readouterr().err
    after = float(said.split("nominal path ")[1].split(" um")[0])
    before = float(said.split("uncorrected ")[1].split(" um")[0])
    assert before > 10 and after < 1.3, said


def test_two_thermometers_are_the_integral_of_a_line(tmp_path):
    """T = 24 at 0 and 21 at 600: from the fixed point 100 on, 10e-6 * integral of (T(s) - 20), by
    hand 3.5 s - s^2 / 400 ... here (4 - s / 200) integrated: 4 (x - 100) - (x^2 - 100^2) / 400."""
    m = read_machine(machine(tmp_path, TWO))
    found, lacking, _ = growth.drivers(m, ["T_front_C", "T_rear_C"], spindles=False)
    assert not lacking and len(found) == 2
    warm = growth.grown(growth.following(m, found), found, np.array([4.0, 1.0]))
    x = np.linspace(-10, 600, 41)
    q = np.zeros((3, 41))
    q[0] = x
    s = np.maximum(x, 0.0)  # before the first thermometer it is as warm as there
    by_hand = 10e-6 * (4 * (s - 100) - (s**2 - 100**2) / 400 + 4 * np.minimum(x, 0))
    assert warm.deviation(q, 0 * q)[0] == pytest.approx(
        by_hand, abs=2e-8 + 10e-6 * (3 / 600) * (620 / 32) ** 2 / 8
    )


@pytest.mark.parametrize("first", [-90.0, 0.0])
def test_growth_is_exact_at_a_thermometer(tmp_path, first):
    """By hand where the middle of three, at 137, is 100 K warmer than the others: a share of (100 -
    first) / (137 - first) of that at the fixed point 100, and the mean of both over 37 mm.
    Thermometers beyond the travel are no nodes."""
    places = f"T_front_C = {first}, T_middle_C = 137.0, T_rear_C = 900.0"
    m = read_machine(machine(tmp_path, f", sensors = {{ {places} }}"))
    found, _, _ = growth.drivers(m, ["T_front_C", "T_middle_C", "T_rear_C"], spindles=False)
    assert {(d.nodes[0], d.nodes[-1]) for d in found} == {(-10.0, 610.0)}
    warm = growth.grown(growth.following(m, found), found, np.array([0.0, 100.0, 0.0]))
    by_hand = 10e-6 * (100 * (100 - first) / (137 - first) + 100) / 2 * 37
    grown = warm.deviation(np.array([[137.0], [0.0], [0.0]]), np.zeros((3, 1)))[0]
    assert grown == pytest.approx([by_hand], rel=1e-9)


def test_a_spindle_warms_as_the_effect_says():
    """The same turns, told to `spindle_growth` as a recording and to the clock motion by motion."""
    module = effects.load("spindle_growth")
    rng = np.random.default_rng(4)
    t = np.cumsum(rng.uniform(1, 200, 300))
    rpm = np.repeat(rng.choice([0.0, 3000.0, 12000.0], 30), 10)
    p = {name: 0.0 for name in module.PARAMETERS} | {
        "tau_s": 700.0,
        "um_per_1000_rpm": 4.0,
        "housing_um": 2.5,
        "housing_s": 2800.0,
        "power": 5 / 3,
        "fastest_rpm": 12000.0,
        "shift_um": 3.0,
        "shift": 1.0,
    }
    end = np.rint((t - t[0]) * clock.MICRO).astype(np.int64)[1:]
    none = np.zeros(0, np.int64)
    begin = np.append(0, end[:-1])
    times = clock.Times(begin, end, rpm[1:], clock.Dwells(none, none, none.astype(float)))
    lags = spindle_lags(p, times, 1.0, (0.0, 0.0))
    found = lags.at(np.arange(299), (end - begin) / clock.MICRO)
    # The effect lets the turns of a row hold until the next one.
    turns = np.append(rpm[1:], rpm[-1])
    state = State(
        {"Z": t * 0},
        {"Z": t * 0},
        {"Z": (0.0, 1.0)},
        time=t,
        run=t * 0,
        channels={"spindle_rpm": turns},
    )
    wanted = effects.deviation(module, state, "Z", **p)[2] / 1e-3
    shift = 3.0 * ((rpm[1:] / 12000) ** 2 - (turns[1:] / 12000) ** 2)
    assert found == pytest.approx(wanted[1:] + shift, abs=1e-6)


def test_the_simulators_own_physics_sees_the_growth_gone(tmp_path, capsys):
    """A spindle that warms the head for 25 min: the simulator, with its planner's times and the
    effect's own equation, reads 21 um along Z before, and after it what grows within one rest of 20
    s (0.9 um at first)."""
    folder = machine(
        tmp_path, "", SPINDLE.replace("5.0", "-3.0").replace("housing_um = 2.0", "housing_um = 1.0")
    )
    cold = written(tmp_path, "t_s,T_scale_X_C", "0,20", "9999,20")
    text = ["G21 G90 G54 G94", "M3 S9000", "G0 X100 Y100 Z300"]
    for k in range(40):
        text += [f"G1 X{100 + (k % 2) * 300} F600", f"G1 Z{300 - k} F600", "G4 P20"] + (
            ["S4000"] if k == 25 else []
        )
    nominal, corrected = tmp_path / "a.nc", tmp_path / "b.nc"
    nominal.write_text("\n".join([*text, "M2"]) + "\n")
    assert gcomp(nominal, "--machine", folder, "--temperatures", cold, "-o", corrected) == 0
    worst = []
    for words in ((nominal,), (corrected, "--nominal", nominal)):
        more = (
            "--machine",
            folder,
            "--instrument",
            "laser",
            "--set",
            "along=Z",
            "--set",
            "dwell=15",
            "-o",
            tmp_path / "z.csv",
        )
        assert gcomp("simulate", *words, *more) == 0
        read = recordings.read(recordings.Source("z.csv", (tmp_path / "z.csv").read_bytes()))
        worst.append(np.abs(read.reading).max() / 1e-3)
    assert worst[0] > 15 and worst[1] < 1.0, worst
    capsys.readouterr()


@pytest.mark.parametrize(
    ("rows", "words", "says"),
    [
        (
            ["t_s,T_scale_X_C", "0,20", "100,21"],
            (),
            "log.csv ends 100 s after the program begins, and this block ends after 500 s",
        ),
        (["t_s,T_scale_X_C", "0,68", "900,171"], (), "T_scale_X_C goes from 68 to 171"),
        (
            ["t_s,T_oil_C", "0,20", "900,21"],
            (),
            "nothing in warm grows by one of its columns (T_oil_C)",
        ),
        (["t_s,T_scale_X_C", "0,20", "0,21"], (), "not later than the one before"),
        (["t_s,T_scale_X_C", "noon,20", "later,21"], (), "'noon' is no time"),
        (["t_s,T_scale_X_C", "0,20", "900,21"], ("--log-begin", "1000"), "the log"),
        (
            ["t_s,T_scale_X_C", "0,20", "900,21"],
            ("--temperature", "X=21"),
            "both say how warm it is",
        ),
    ],
)
def test_what_is_refused(tmp_path, capsys, rows, words, says):
    program = tmp_path / "a.nc"
    program.write_text("G21 G90 G54\nG1 X0 Y0 Z0 F60\nX500\nM2\n")
    folder = machine(tmp_path)
    assert (
        gcomp(
            program,
            "--machine",
            folder,
            "--temperatures",
            written(tmp_path, *rows),
            "-o",
            tmp_path / "b",
            *words,
        )
        == 2
    )
    assert says in capsys.readouterr().err
    assert not (tmp_path / "b").exists()


def test_a_column_that_the_machine_names_is_needed_and_the_last_row_may_be_held(tmp_path, capsys):
    program = tmp_path / "a.nc"
    program.write_text("G21 G90 G54\nG1 X0 Y0 Z0 F60\nX500\nM2\n")
    words = (program, "-o", tmp_path / "b", "--machine")
    record = written(tmp_path, "t_s,T_front_C", "0,20", "900,21")
    assert gcomp(*words, machine(tmp_path, TWO), "--temperatures", record) == 2
    assert "asks for T_rear_C" in capsys.readouterr().err
    short = written(tmp_path, "t_s,T_scale_X_C", "0,20", "100,21")
    assert gcomp(*words, machine(tmp_path), "--temperatures", short, "--hold-temperature") == 0


def test_dates_gaps_and_decimal_commas(tmp_path):
    text = "time;T_scale_X_C\n2026-11-23T08:00:00;20,5\n2026-11-23T08:01:00;\n2026-11-23T08:02:00;21,5\n"  # noqa: E501
    found = log.read("l.csv", text.encode())
    assert found.time.tolist() == [0.0, 60.0, 120.0]
    assert found.columns["T_scale_X_C"].tolist() == [20.5, 21.0, 21.5]
    assert found.moment("2026-11-23T08:01:30") == 90.0
    with pytest.raises(GcompError, match="no time"):
        found.moment("half past eight")


def test_a_log_that_goes_on_is_read_anew(tmp_path):
    """While a job is streamed the newest whole row counts, whatever the clock says."""
    folder = machine(tmp_path)
    record = written(tmp_path, "t_s,T_scale_X_C", "0,20", "10,21")
    asked = options(folder, "--temperatures", record)
    asked.live_temperatures = True
    f = reading.filter_of(asked, reading.machine_of(asked))
    ends = []
    for row in ("", "60,25\n", "90,3"):
        with open(record, "a") as file:
            file.write(row)
        out = f.feed(b"G21 G90 G54\nG1 X0 Y0 Z0 F60\nX600\nX500\n").decode()
        ends.append(float(out.splitlines()[-1].split("X")[-1]))
    assert ends == pytest.approx([500 - 0.004, 500 - 0.020, 500 - 0.020], abs=1.3e-4)


def test_pace_and_begin(tmp_path):
    """Twice as slow and begun 100 s into the log: a block in the middle of 20 s of words meets 100
    + 2 * 10 s."""
    folder = machine(tmp_path)
    record = written(tmp_path, "t_s,T_scale_X_C", "0,20", "1000,30")
    f = filter_of(folder, "--temperatures", record, "--log-begin", "100", "--pace", "2")
    words = lex(b"G21 G90 G54\nG1 X0 Y0 Z0 F600\nX200\n", f.dialect.grammar, False)
    motions, _, _ = f.interpreter.run(words, f.modal)
    course, _ = f.heat.course(words, motions, f.heat.initial())
    values = course.at(np.array([0, 1]), np.array([0.5, 0.5]))
    assert values[0, 1] == pytest.approx((100 + 2 * 10) * 0.01, abs=1e-6)


SCREW = """
[[effect]]
name = "screw_heat"
axis = "Z"
alpha_ppm_K = 11.0
held_at_mm = 0.0
tau_s = {tau}
source = "a test"
"""


@pytest.mark.parametrize(("tau", "followed"), [("0.0", True), ("1.0", False), ("600.0", False)])
def test_a_screw_follows_its_thermometer_where_it_has_no_time_of_its_own(tau, followed, tmp_path):
    m = read_machine(machine(tmp_path, "", SCREW.format(tau=tau)))
    found, _, out = growth.drivers(m, ["T_screw_Z_C"], spindles=False)
    assert [d.column for d in found if d.name.startswith("screw_heat")] == [
        "T_screw_Z_C"
    ] * followed
    assert any("screw_heat of Z is not followed" in line for line in out) is not followed


def test_half_a_step_of_all_thermometers_is_an_eighth_of_the_tolerance(tmp_path):
    """10 um/(m K) of X's scale over 510 mm from where it is fixed, and 20 of the work: 5.1 um and
    10.2 um a kelvin."""
    log = written(tmp_path, "t_s,T_scale_X_C,T_work_C", "0,20,20", "9999,25,21")
    drivers = filter_of(machine(tmp_path), "--temperatures", log).heat.drivers
    assert [d.most * 1000 for d in drivers] == pytest.approx([5.1, 10.2])
    step = follow.steps(drivers, 0.001)
    assert step == pytest.approx([1 / 8 / 5.1, 1 / 8 / 10.2])
    assert sum(step * [5.1, 10.2]) / 2 == pytest.approx(1 / 8)


def test_an_effect_of_size_zero_moves_nothing(tmp_path):
    zero = SCREW.format(tau=0.0).replace("alpha_ppm_K = 11.0", "alpha_ppm_K = 0.0")
    log = written(tmp_path, "t_s,T_screw_Z_C", "0,20", "9999,30")
    filter_ = filter_of(machine(tmp_path, "", zero), "--temperatures", log)
    assert [d.most for d in filter_.heat.drivers] == [0.0]
    assert follow.steps(filter_.heat.drivers, 0.001) == [1.0]
    text = b"G21 G90 G54\nG0 X0 Y0 Z0\nG1 X400 Z100 F600\nM2\n"
    assert filter_.feed(text) + filter_.finish() == text


def test_what_heat_does_to_a_whole_program_has_no_line(tmp_path):
    """An arc of 157 s in line 4, over which the scale warms by 4.7 K."""
    folder = machine(tmp_path)
    log = written(tmp_path, "t_s,T_scale_X_C", "0,20", "1000,50")
    filter_ = filter_of(folder, "--temperatures", log)
    text = "G21 G90 G54 G17\nG0 X0 Y0 Z0\n(the arc)\nG2 X100 Y0 I50 J0 F60\nM2\n"
    filter_.feed(text.encode())
    assert [n.line for n in filter_.notices if n.code == "heat"] == [0]


def test_without_a_temperature_the_machine_is_as_cold_as_its_file(tmp_path):
    """Of holes that --expand asks about before anything has become warm."""
    m = read_machine(machine(tmp_path, TWO))
    found, _, _ = growth.drivers(m, ["T_front_C", "T_rear_C"], spindles=False)
    following = growth.following(m, found)
    tool = np.array([0, 0, 10_000_000_000])
    cold = Compensator(following, Options(heat_step=(0.1, 0.1)))._of_tool(tool)
    q = np.array([[0.0, 100.0, 400.0], [0.0] * 3, [0.0] * 3])
    by_file = growth.grown(following, found, np.zeros(2)).deviation(q, 0 * q)
    assert cold.machine.deviation(q, 0 * q) == pytest.approx(by_file, abs=1e-12)


def test_notices_say_what_was_taken(tmp_path):
    folder = machine(tmp_path, "", SPINDLE)
    asked = options(
        folder, "--temperatures", written(tmp_path, "t_s,T_scale_X_C", "0,20", "9000,21")
    )
    notices: list[Notice] = []
    m = read_machine(folder)
    grown, _ = warming.of(asked, replace(m), dialects.load("linuxcnc"), notices)
    told = " ".join(n.message for n in notices)
    assert "scale of X by T_scale_X_C" in told and "spindle_growth of Z by the turns" in told
    assert (
        "no column for the work: along X it stays at 20 C" in told
        and "up to 9000 s lie between two readings" in told
    )
    assert grown.growth and not grown.is_zero
