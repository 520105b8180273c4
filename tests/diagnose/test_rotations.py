"""A rotation that the machine's file lacks: what it does at the end of the arm that the file has,
and what an angular instrument reads. The geometry is written out here by hand."""

from __future__ import annotations

import numpy as np
import pytest

from postproc.cli import main
from postproc.effects import State, abbe, deviation
from postproc.machine.file import read_machine
from tests.diagnose.test_strangers_forms import names
from tests.diagnose.test_workshop import HEAD, MACHINE, diagnosed

TOOL = "[tool]\nX = 0.0\nY = 0.0\nZ = -120.0\n"
PLACES = 20.0 + 40.0 * np.arange(15)


def readings(quantity: str, sensitive: str, shown, y_mm: float, seed: int, noise: float) -> str:
    """Two runs of X there and back at a place of Y; shown(place): um or urad."""
    rng, rows, t = np.random.default_rng(seed), [], 100.0 * seed
    for run in (1, 2):
        for side, places in ((1, PLACES), (-1, PLACES[::-1])):
            for p in places:
                t += 5.0
                read = shown(p) + noise * rng.standard_normal()
                rows.append(f"{run},{t:.1f},{p:g},{y_mm:g},-20,{side},1,-1,{read:.3f}")
    head = HEAD.format("targets", "laser")
    head += f'# quantity = "{quantity}"\n# sensitive = {{ {sensitive} }}\n'
    unit = "urad" if quantity == "angle" else "um"
    return (
        f"{head}run,t_s,X_mm,Y_mm,Z_mm,approach_X,approach_Y,approach_Z,reading_{unit}\n"
        + "\n".join(rows)
        + "\n"
    )


def test_an_angle_that_the_file_lacks_is_named_where_it_is_read(tmp_path):
    """X turns about Y by 30 urad from one end to the other, as an autocollimator reads; the tool is
    120 mm below, so X moves by up to 3.6 um."""

    def turned(p):
        return 15.0 * (p - 300.0) / 300.0

    angle = readings("angle", "X = 0, Y = 1, Z = 0", turned, 50.0, 1, 0.3)
    place = readings(
        "displacement", "X = 1, Y = 0, Z = 0", lambda p: -0.12 * turned(p), 50.0, 2, 0.2
    )
    answer = diagnosed(tmp_path, angle, place, machine=MACHINE + TOOL)
    assert "abbe:X" in names(answer) and answer["unknown"] is None
    assert "abbe" not in {e["effect"] for e in answer["not_visible"]}
    (found,) = (e["parameters"] for e in answer["effects"] if e["effect"] == "abbe")
    assert (found["turn"]["value"], found["known"]["value"]) == (1, 0)
    assert found["c1_urad"]["value"] == pytest.approx(15.0, abs=0.5)


def test_on_one_line_it_is_an_error_of_position(tmp_path):
    bent = readings(
        "displacement", "X = 1, Y = 0, Z = 0", lambda p: 8e-5 * (p - 300) ** 2, 50, 3, 0.2
    )
    assert names(diagnosed(tmp_path, bent, machine=MACHINE + TOOL)) == ["pitch_shape:X"]


@pytest.mark.parametrize("turn", [0, 1, 2])
@pytest.mark.parametrize("of_file", [1.0, 2.0])
def test_the_written_machine_does_what_the_effect_says(tmp_path, turn, of_file):
    """X carries the workpiece of w-X-b-Y-Z-t: its own place, Y, Z and the tool are on its arm."""
    section = (
        f'[[effect]]\nname = "abbe"\naxis = "X"\nknown = 0\nturn = {turn}\narm = 0\n'
        f"zero_mm = 0\nof_file = {of_file:g}\narm_mm = 0\n"
        "c1_urad = 40\nc2_urad = -25\nc3_urad = 0\nc4_urad = 0\n"
        "c5_urad = 0\ndegree = 2\n"
    )
    (tmp_path / "machine.toml").write_text(MACHINE + TOOL + section)
    machine = read_machine(tmp_path)
    place = {"X": np.array([0.0, 150.0, 600.0]), "Y": np.array([10.0, 300.0, 400.0])}
    place["Z"] = np.array([-90.0, -50.0, 0.0])
    state = State(
        place,
        {x: np.ones(3) for x in "XYZ"},
        {x: machine.axes[x].travel for x in "XYZ"},
        arms={x: machine.arm_at(x, place) for x in "XYZ"},
        on_arm="X",
    )
    u = 2 * place["X"] / 600.0 - 1
    angle = (40.0 * u - 25.0 * (1.5 * u**2 - 0.5)) * 1e-6
    unit = np.zeros((3, 3))
    unit[turn] = angle
    reach = np.stack([place["X"] * (of_file == 1.0), place["Y"], place["Z"] - 120.0])
    by_hand = np.cross(unit, reach, axis=0)
    named = machine.effects[0].parameters
    assert deviation(abbe, state, "X", **named) == pytest.approx(by_hand, abs=1e-9)
    shown = machine.deviation(np.stack([place[x] for x in "XYZ"]), np.ones((3, 3)))
    assert shown == pytest.approx(by_hand, abs=2e-5)


def test_what_an_angular_instrument_reads_is_the_rotation_itself():
    state = State(
        {"X": np.array([0.0, 600.0])},
        {"X": np.ones(2)},
        {"X": (0.0, 600.0)},
        arms={"X": np.array([[0.0, 0.0], [0.0, 0.0], [200.0, 200.0]])},
        turned=np.array([False, True]),
    )
    named = {
        "turn": 1.0,
        "arm": 0.0,
        "of_file": 1.0,
        "known": 0.0,
        "degree": 1.0,
        "c1_urad": 10.0,
        "arm_mm": 0.0,
    }
    moved, read = deviation(abbe, state, "X", **named).T
    assert moved * 1e6 == pytest.approx([-2000.0, 0.0, 0.0])  # nm: 10 urad at 200 mm
    assert read * 1e6 == pytest.approx([0.0, 10.0, 0.0])  # urad


def test_a_simulated_machine_has_that_rotation(tmp_path):
    """40 urad at either end of X about Z, read by a laser at Y390: 390 mm * 40e-6 * 2 * 580 / 600
    from X10 to X590."""
    section = (
        '[[effect]]\nname = "abbe"\naxis = "X"\nknown = 0\nturn = 2\narm = 0\nof_file = 1\n'
        "zero_mm = 0\narm_mm = 0\nc1_urad = 40\ndegree = 1\n"
    )
    (tmp_path / "machine.toml").write_text(MACHINE + section)
    program, out = tmp_path / "p.nc", tmp_path / "r.csv"
    program.write_text("G21 G90 G1 X10 Y390 Z-10 F2000\nG4 P3\nX590\nG4 P3\n")
    words = ["simulate", str(program), "--machine", str(tmp_path), "-o", str(out), "--noise", "0"]
    assert main([*words, "--instrument", "laser", "--quiet"]) == 0
    head, *rows = (line for line in out.read_text().splitlines() if line[0] != "#")
    at = head.split(",").index("reading_um")
    first, last = (float(row.split(",")[at]) for row in rows)
    assert last - first == pytest.approx(-390e-3 * 40 * 2 * 580 / 600, abs=0.02)


def machine_of(folder, *, of_file: int = 1, turn: int = 1, c1: float = 200.0, more: str = ""):
    """A machine whose X turns by c1 urad at either end, as an effect."""
    folder.mkdir(exist_ok=True)
    section = (
        f'[[effect]]\nname = "abbe"\naxis = "X"\nknown = 0\nturn = {turn}\narm = 0\n'
        f"of_file = {of_file}\narm_mm = 0\nc1_urad = {c1}\ndegree = 1\n{more}"
    )
    (folder / "machine.toml").write_text(MACHINE + section)
    return folder


def table_of(folder):
    """The same machine with a table of that rotation about Y."""
    folder.mkdir()
    (folder / "X.csv").write_text("X_mm,EBX_urad\n0,-200\n600,200\n")
    text = MACHINE.replace("[axes.X]\n", '[axes.X]\ntable = "X.csv"\n')
    (folder / "machine.toml").write_text(text)
    return folder


def test_a_program_with_a_tool_is_corrected_as_by_a_table_of_the_rotation(tmp_path):
    """G43.1 Z120: the tip lies 120 mm below, 24 um to either side of the middle of X."""
    text = "G21 G90 G94\nG43.1 Z120\nG1 X10 Y10 Z-130 F1000\nX590\nM2\n"
    (tmp_path / "p.nc").write_text(text)
    made = []
    for folder in (machine_of(tmp_path / "e"), table_of(tmp_path / "t")):
        words = [str(tmp_path / "p.nc"), "--machine", str(folder), "-o", str(folder / "o.nc")]
        assert main([*words, "--quiet"]) == 0
        lines = (folder / "o.nc").read_text().splitlines()
        made.append([line for line in lines if line.startswith(("G1", "X"))])
    ends = [(moves[0], moves[-1]) for moves in made]
    assert ends[0] == ends[1] and ends[0][1].startswith("X590.025")


@pytest.mark.parametrize("of_file", [1, 2])
def test_beyond_what_was_measured_the_angle_stays(tmp_path, of_file):
    """40 urad about Z at the ends of X, read from 100 to 300 mm: 2/3 and 0 of -40 beyond; at Y0 Z0
    X itself is the arm, or nothing is."""
    more = "measured_mm = [100.0, 300.0]\n"
    folder = machine_of(tmp_path / "m", of_file=of_file, turn=2, c1=40.0, more=more)
    x = np.array([0.0, 100.0, 200.0, 300.0, 450.0, 600.0])
    place = np.stack([x, 0 * x, 0 * x])
    shown = read_machine(folder).deviation(place, np.ones_like(place))
    angle = 40e-6 * (np.clip(x, 100, 300) / 300 - 1)
    assert shown[1] == pytest.approx(angle * x * (of_file == 1), abs=2e-5)
    assert shown[0] == pytest.approx(0 * x, abs=1e-9)


@pytest.mark.parametrize("instrument", ["angle", "laser"])
def test_what_is_simulated_is_nothing_left_out_to_the_same_machine(tmp_path, instrument):
    """With a tool of 120 mm: what the instrument reads, by the effect and by the table."""
    places = "\n".join(f"X{x:g}\nG4 P3" for x in np.linspace(10, 590, 13))
    (tmp_path / "p.nc").write_text(f"G21 G90 G94\nG43.1 Z120\nG1 Y10 Z-130 F3000\n{places}\nM2\n")
    read = []
    for folder in (machine_of(tmp_path / "e"), table_of(tmp_path / "t")):
        out = folder / "r.csv"
        words = ["simulate", str(tmp_path / "p.nc"), "--machine", str(folder), "-o", str(out)]
        assert main([*words, "--instrument", instrument, "--noise", "0", "--quiet"]) == 0
        head, *rows = (line for line in out.read_text().splitlines() if line[0] != "#")
        at = next(k for k, name in enumerate(head.split(",")) if name.startswith("reading"))
        read.append([float(row.split(",")[at]) for row in rows])
    assert read[0] == pytest.approx(read[1], abs=0.02)
    assert np.ptp(read[0]) == pytest.approx({"angle": 387, "laser": 46}[instrument], rel=0.1)


def test_a_head_that_turns_has_no_arms_of_that_kind(tmp_path):
    """Simulating says so; nothing is guessed."""
    folder = machine_of(tmp_path / "m")
    text = (folder / "machine.toml").read_text()
    text = text.replace("w-X-b-Y-Z-t", "w-X-b-Y-Z-B-t")
    (folder / "machine.toml").write_text(
        text + "[axes.B]\ntravel = [-100.0, 100.0]\nleast_increment = 0.001\n"
    )
    (tmp_path / "p.nc").write_text("G21 G90 G1 X10 Y10 Z-10 F2000\nG4 P3\nX590\nG4 P3\n")
    words = ["simulate", str(tmp_path / "p.nc"), "--machine", str(folder), "--instrument", "laser"]
    assert main([*words, "-o", str(tmp_path / "r.csv"), "--quiet"]) == 2
