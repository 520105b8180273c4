"""Printers and routers: homing, levelling, macros, the commands of Klipper and RepRapFirmware."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest

from postproc.errors import MachineError, ProgramError
from postproc.filter import Filter, setup_of
from postproc.machine.file import read_machine
from postproc.nc import dialects
from tests.test_unknown_places import mill

HOME = {"X": 0.0, "Y": 0.0, "Z": 0.0}
ALL = [f"E{c}{x}" for x in "XYZ" for c in "XYZABC"]


def filtered(
    text: str, dialect: str = "marlin", home: dict | None = None, start: dict | None = None, **more
):
    """The filter, and what it writes, of a machine with all errors."""
    of = dialects.load(dialect)
    machine = replace(mill(*ALL), home=home or {}, **more).carrying(of.carried)
    filter_ = Filter(machine, of, setup_of(machine, None, start))
    return filter_, (filter_.feed(text.encode()) + filter_.finish()).decode()


def written(
    text: str, dialect: str = "marlin", home: dict | None = None, start: dict | None = None
) -> list[str]:
    lines = filtered(text, dialect, home, start)[1].splitlines()
    return [line for line in lines if "GCOMP" not in line]


def refused(text: str, dialect: str, home: dict | None = None) -> ProgramError:
    with pytest.raises(ProgramError) as error:
        filtered(text, dialect, home)
    return error.value


def notice(filter_: Filter, code: str) -> str:
    return next((n.message for n in filter_.notices if n.code == code), "")


# -- where the machine stands ----------------------------------------------------------------------


def test_home_is_where_g28_puts_the_axes():
    """As if the program had gone there: the same blocks as behind a move to the place."""
    behind = "G1 Z15 F9000\nG91\nG1 X5 Y3 E1\n"
    home = {"X": 10.0, "Y": 20.0, "Z": 5.0}
    named = written("G1 X10 Y20 Z5 F9000\n" + behind, home=HOME)
    assert written("G28\n" + behind, home=home)[-1] == named[-1]
    assert written("G28\n" + behind, start=home) == written("G28\n" + behind, home=home), (
        "--start counts behind G28"
    )
    unknown = written("G28\n" + behind + "G90\nG1 X50 Y50 Z5\n")
    assert unknown[3] == "G1 X5 Y3 E1" and unknown[5].startswith("G1 X49.9"), "unknown place"


def test_home_is_not_the_start_of_a_program_on_a_mill():
    text = "G1 X10 F100\n"
    assert written(text, "grbl", HOME) != [text.strip()]
    assert "where" in refused(text, "linuxcnc", HOME).message
    assert written("G28\n" + text, "linuxcnc", HOME)[-1] != text.strip()


@pytest.mark.parametrize(
    "homing, known",
    [
        ("G28", "XYZ"),
        ("G28 X Y", "XY"),
        ("G28 XY", "XY"),
        ("G28 X0", "X"),
        ("g28 y", "Y"),
        ("G28 W", "XYZ"),
        ("N5 G28 X", "X"),
        ("G28 Z P0 T300 ; low", "Z"),
        ("G28 R5", "XYZ"),
        ("G28 O", ""),
    ],
)
def test_g28_homes_the_axes_that_it_names(homing, known):
    """The others stand at unknown places: G29 has been before."""
    of = dialects.load("marlin")
    machine = replace(mill(*ALL), home=HOME).carrying(of.carried)
    filter_ = Filter(machine, of, setup_of(machine))
    filter_.feed(f"G29\n{homing}\n".encode())
    assert "".join(x for x, k in zip("XYZ", filter_.modal.known, strict=False) if k) == known


@pytest.mark.parametrize("before, kept", [("", True), ("G1 X50 Y60\n", False)])
def test_homing_z_may_go_to_the_middle_of_the_bed(before, kept):
    of = dialects.load("klipper")
    machine = replace(mill(*ALL), home=HOME).carrying(of.carried)
    filter_ = Filter(machine, of, setup_of(machine))
    filter_.feed(f"G28\n{before}G28 Z\n".encode())
    assert filter_.modal.known[:3].tolist() == [kept, kept, True]


def test_a_feed_from_nowhere_is_counted_though_nothing_else_is_unknown():
    """Its end alone is corrected: the way there leaves from a place that nobody has told."""
    filter_, _ = filtered("G1 X60 Y3 Z5 F600\nG1 X80\n")
    assert "feeds corrected at their ends alone: 1; where the axes stand there" in notice(
        filter_, "unknown"
    )


def test_what_could_not_be_corrected_is_counted():
    text = "G91\nG1 Z5 F600\nG90\nG28\nG1 Z15\nG1 E3\nG1 X60 Y3\nG1 X80 E5\n"
    filter_, out = filtered(text)
    assert "as they are: 2 (feeds: 2); feeds corrected at their ends alone: 1" in notice(
        filter_, "unknown"
    )
    assert out.splitlines()[:6] == text.splitlines()[:6]
    assert "--start" in notice(filter_, "unknown") and "home" in notice(filter_, "unknown")


def test_an_arc_that_can_not_be_corrected_is_refused():
    """From a corrected place to an uncorrected one it would miss its end."""
    text = "G28\nG1 X60 Y50 Z1 F600\nG28 Z0\nG1 X70 Y50\nG2 X80 Y50 I5 J0\n"
    assert refused(text, "grbl").message.startswith("where Z stands")
    assert written(text.replace("G28 Z0", "M117"), "marlin")[-1].startswith("G2")


def test_a_machine_at_the_end_of_its_travel_is_left_there():
    """home X0 Y0 Z0 at the end of the travel: a correction that leads beyond is not made, and
    counted."""
    axes = {x: replace(a, travel=(0.0, 600.0)) for x, a in mill(*ALL).axes.items()}
    text = "G28\nG1 Z15 F9000\nG1 X60\nG1 Y30\nG1 X80 E1\n"
    filter_, out = filtered(text, home=HOME, axes=axes)
    assert out.splitlines()[:4] == text.splitlines()[:4]
    assert notice(filter_, "stop").endswith("leads beyond: 3")
    places = [float(v) for v in re.findall(r"[XYZ](-?[\d.]+)", out)]
    assert min(places) >= 0.0 and "Y29.9" in out


@pytest.mark.parametrize(
    "level",
    ["G29", "G29 W", "G29 P1 X30 T V4", "M420 S1", "G80", "G29 S1 ; go", "G34", "G26", "G12 P1 S2"],
)
def test_levelling_passes_and_places_are_lost_behind_it(level):
    of = dialects.load("marlin")
    machine = replace(mill(*ALL), home=HOME).carrying(of.carried)
    filter_ = Filter(machine, of, setup_of(machine))
    assert filter_.feed(f"G28\n{level}\n".encode()).decode() == f"G28\n{level}\n"
    assert filter_.modal.known[:3].all() == level.startswith("M420")


def test_smoothie_stands_nowhere_behind_its_homing_by_hand():
    """G92.4 (Robot.cpp): the slides stay, what they are called changes."""
    lines = written("G0 X10 Y10 Z5\nG92.4 X0\nG0 X20\nG0 Y20\nG0 Z6\n", "smoothie", HOME)
    assert lines[1] == "G92.4 X0"
    assert lines[2].startswith("G0 X20")
    assert "Y" not in lines[2]
    assert "Z" not in lines[3]


@pytest.mark.parametrize("dialect", ["grbl", "grblhal", "fluidnc", "smoothie"])
def test_grbl_begins_in_g0(dialect):
    """gc_state is cleared before the first line, and 0 is MOTION_MODE_SEEK (gnea/grbl, gcode.c and
    gcode.h)."""
    lines = written("X10 Y10 Z5\nG1 X20 F300\n", dialect, HOME)
    named = written("G0 X10 Y10 Z5\nG1 X20 F300\n", dialect, HOME)
    assert [line.removeprefix("G0 ") for line in named] == lines
    assert lines[0] != "X10 Y10 Z5"


# -- the machine's own file ------------------------------------------------------------------------


@pytest.mark.parametrize(
    "line, said",
    [
        ("home = { X = 1.0, Y = -2.0, Z = 3.5 }", ""),
        ("home = { W = 1.0 }", "home names 'W'"),
        ("home = 5", "home = 5"),
        ('home = { X = "a" }', "X = 'a' is not a number"),
    ],
)
def test_home_in_machine_toml(tmp_path, line, said):
    axes = "".join(f"[axes.{x}]\ntravel = [-5.0, 200.0]\nleast_increment = 0.001\n" for x in "XYZ")
    (tmp_path / "machine.toml").write_text(
        'format = "gcomp-machine/1"\nname = "p"\ncontrol = "marlin"\nchain ='
        f' "w-Y-b-Z-X-t"\n{line}\n{axes}'
    )
    if not said:
        assert read_machine(tmp_path).home == {"X": 1.0, "Y": -2.0, "Z": 3.5}
        return
    with pytest.raises(MachineError, match=re.escape(said)) as error:
        read_machine(tmp_path)
    assert error.value.place is not None and error.value.place.line == 5


# -- Klipper ---------------------------------------------------------------------------------------

QUIET = (
    "EXCLUDE_OBJECT_DEFINE NAME=a CENTER=10,10 POLYGON=[[1,1],[2,2]]",
    "EXCLUDE_OBJECT_START NAME='part 1'",
    "exclude_object_end name=a",
    "SET_PRESSURE_ADVANCE ADVANCE=0.05 SMOOTH_TIME=0.04",
    "SET_VELOCITY_LIMIT ACCEL=3000",
    "SET_FAN_SPEED FAN=aux SPEED=.5",
    "SET_PRINT_STATS_INFO TOTAL_LAYER=10",
    'RESPOND MSG="G1 X5"',
    "M117 G1 X5",
    "SET_GCODE_OFFSET Z=0",
    "SAVE_GCODE_STATE NAME=x",
    "SET_GCODE_OFFSET X=0.0 Y=-0.00 MOVE=1",
    "@pause",
    "TEMPERATURE_WAIT SENSOR=extruder MINIMUM=200",
    "M204 S500",
    "SET_SKEW CLEAR=1",
)
MACROS = (
    "START_PRINT BED=60",
    "print_start EXTRUDER=210",
    "_PRIME",
    "PA",
    "TIMELAPSE_TAKE_FRAME",
    "G29",
    "G32",
    "T1",
    "M600",
    "G80",
    "BED_MESH_CALIBRATE ADAPTIVE=1",
    "QUAD_GANTRY_LEVEL",
)


@pytest.mark.parametrize("command", QUIET)
def test_commands_of_klipper_that_move_nothing(command):
    head, behind = "G28\nG1 X60 Y50 Z1 F600\n", "G1 X65 E1\n"
    lines = written(head + command + "\n" + behind, "klipper", HOME)
    assert [line for line in lines if line != command] == written(head + behind, "klipper", HOME)
    assert command in lines


@pytest.mark.parametrize("command", MACROS)
def test_places_are_lost_behind_a_macro(command):
    of = dialects.load("klipper")
    machine = replace(mill(*ALL), home=HOME).carrying(of.carried)
    filter_ = Filter(machine, of, setup_of(machine))
    assert (
        command in filter_.feed(f"G28\nG1 X60 Y50 Z1\n{command}\n".encode()).decode().splitlines()
    )
    assert not filter_.modal.known[:3].any()
    assert notice(filter_, "macro").startswith(command.split()[0].split("=")[0])


@pytest.mark.parametrize(
    "command, why",
    [
        ("RESTORE_GCODE_STATE NAME=x", "modes come back"),
        ("SET_GCODE_OFFSET Z=0.05", "shifts the coordinates"),
        ("SET_GCODE_OFFSET Z_ADJUST=-.1", "shifts the coordinates"),
        ("SET_KINEMATIC_POSITION X=5", "shifts the coordinates"),
        ("SET_SKEW XY=100,101,70", "leans the axes"),
        ("G20", "no inches"),
    ],
)
def test_commands_of_klipper_that_can_not_be_followed(command, why):
    error = refused(f"G28\nG1 X60 Y50 Z1\n{command}\nG1 X65\n", "klipper", HOME)
    assert why in error.advice
    assert error.place is not None and error.place.line == (3 if command != "G20" else 4)


def test_e_of_klipper_is_incremental_under_g91_or_m83():
    """gcode_move.py, cmd_G1: not absolute_coord or not absolute_extrude. On Marlin G90 makes E
    absolute again."""
    text = "G28\nM83\nG91\nG90\nG1 X60 Y50 Z1 E2\nG1 X150 E2\n"
    for dialect, sums in (("klipper", [2.0, 2.0]), ("marlin", [2.0, 0.0])):
        of = dialects.load(dialect)
        machine = replace(mill(*ALL), home=HOME).carrying(of.carried)
        filter_, way = Filter(machine, of, setup_of(machine)), []
        filter_.watchers.append(
            lambda w, m, p, o, n, way=way: way.extend((m.target - m.start)[3] / 1e10)
        )
        filter_.feed(text.encode())
        assert way == pytest.approx(sums)


# -- Marlin and RepRapFirmware ---------------------------------------------------------------------


@pytest.mark.parametrize(
    "line",
    [
        "Start GCode begin",
        "T?",
        "Tx",
        "Tc",
        "@BEDLEVELVISUALIZER",
        "; thumbnail begin 16x16 100",
        "; iVBORw0KGgo(X+1",
        "M118 //action:prompt_begin",
    ],
)
def test_lines_that_are_no_command_of_marlin_pass(line):
    head, behind = "G28\nG1 X60 Y50 Z1 F600\n", "G1 X65 Y51 Z2 E1\n"
    lines = written(head + line + "\n" + behind, "marlin", HOME)
    assert line in lines and lines[-1] == written(head + behind, "marlin", HOME)[-1]


@pytest.mark.parametrize(
    "line",
    [
        'echo "G1 X5", {var.a}',
        "var a = 5",
        "set global.x = {var.a * 2}",
        "global z=3",
        "abort",
        "param.S",
    ],
)
def test_meta_commands_of_reprap_pass(line):
    head, behind = "G28\nG1 X60 Y50 Z1 F600\n", "G1 X65 Y51 Z2 E1\n"
    lines = written(head + line + "\n" + behind, "reprap", HOME)
    assert line in lines and lines[-1] == written(head + behind, "reprap", HOME)[-1]


@pytest.mark.parametrize("line", ["T0", "T-1", 'M98 P"/macros/prime.g"', "G1009", "M600"])
def test_places_are_lost_behind_files_of_reprap(line):
    of = dialects.load("reprap")
    machine = replace(mill(*ALL), home=HOME).carrying(of.carried)
    filter_ = Filter(machine, of, setup_of(machine))
    filter_.feed(f"G28\nG1 X60 Y50 Z1\n{line}\n".encode())
    assert not filter_.modal.known[:3].any()


@pytest.mark.parametrize("line", ["T0 R ; switch extruder", "T0 S", "N4 T0 S"])
def test_a_letter_without_a_value_behind_t_moves_nothing(line):
    """Marlin 2, gcode/parser.h: a parameter may have no value; T's (F, S) are the change's own.
    Aura (Anisoprint) writes the first."""
    head, behind = "G28\nG1 X60 Y50 Z1 F600\n", "G1 X65 Y51 Z2 E1\n"
    lines = written(head + line + "\n" + behind, "marlin", HOME)
    assert line in lines and lines[-1] == written(head + "T0\n" + behind, "marlin", HOME)[-1]


def test_a_tool_without_an_offset_is_said():
    filter_, out = filtered("G28\nT1\nG1 X60 Y50 Z1\nG1 X65\n", home=HOME)
    assert "--offset T1=" in notice(filter_, "T1") and "G1 X64.9" in out


META = (
    'G28\nG1 X60 Y50 Z1 F600\nif {var.a} > 1 ; no motion\n  M117 hot\n  echo "x"\n\nelse\n  M106'
    " S0\nG1 X65 Y51 Z2 E1\n"
)


def test_conditions_of_reprap_that_move_nothing_pass():
    lines = written(META, "reprap", HOME)
    assert lines[-1] == written("G28\nG1 X60 Y50 Z1 F600\nG1 X65 Y51 Z2 E1\n", "reprap", HOME)[-1]


@pytest.mark.parametrize(
    "line", ["  G1 X70", "\tG91", "  if 1\n    G1 X5", "  M117 a\n  G92 X0", "  G2 X5 Y5 I1 J1"]
)
def test_conditions_of_reprap_that_move_are_refused(line):
    """With the line that can not be followed; behind the condition all is as before."""
    error = refused(META.replace("  M106 S0", line), "reprap", HOME)
    assert "inside if or while" in error.message
    assert error.place is not None and error.place.text.strip().startswith("G")
    for cut in (True, False):
        of = dialects.load("reprap")
        machine = replace(mill(*ALL), home=HOME).carrying(of.carried)
        filter_ = Filter(machine, of, setup_of(machine))
        text = META.replace("  M106 S0", "  G28\n  G29") + "G1 X70\n"
        parts = [text] if cut else text.splitlines(keepends=True)
        out = b"".join(filter_.feed(part.encode()) for part in parts).decode()
        assert "X64.9" in out and "X69.9" in out and "  G28\n  G29\n" in out


@pytest.mark.parametrize("dialect", ["grbl", "grblhal", "fluidnc"])
def test_homing_of_grbl_in_a_program(dialect):
    lines = written("$H\nG0 X10 Y10 Z5\nG1 X20 F300\n", dialect)
    assert lines == ["$H", *written("G0 X10 Y10 Z5\nG1 X20 F300\n", dialect)]
    behind = "G91\nG1 X10 Y5 Z5 F300\n"
    home = {"X": 10.0, "Y": 20.0, "Z": 5.0}
    assert (
        written("$H\n" + behind, dialect, home)[1:] == written("G28\n" + behind, dialect, home)[1:]
    )
    assert written("$H\n" + behind, dialect, home)[-1] != "G1 X10 Y5 Z5 F300"
    assert written("$H\n" + behind, dialect, start=home) == written("$H\n" + behind, dialect, home)


def test_temperatures_of_a_tool_are_no_offset():
    assert written("G10 P0 S200 R150\nG28\nG1 X60 Y50 Z1\n", "reprap", HOME)[-1] != "G1 X60 Y50 Z1"


def test_a_program_that_never_says_where_an_axis_is_is_refused():
    """A laser that never names Z, on a machine whose corrections need it: nothing would be
    corrected."""
    error = refused("G21 G90\nM4\nG0 X10 Y10\nG1 X30 S200 F1000\nG1 Y30\nM5\n", "grbl")
    assert error.message.startswith("where Z stands is not known") and "--start Z" in error.advice
    assert error.place is not None and error.place.line == 4
    assert "X29.9" in "".join(
        written("G21 G90\nG0 X10 Y10\nG1 X30 F1000\n", "grbl", start={"Z": 0.0})
    )
