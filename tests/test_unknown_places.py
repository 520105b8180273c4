"""A correction asks for the positions that it depends on, and for no other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from postproc.errors import ProgramError
from postproc.filter import Filter, setup_of
from postproc.machine.axis import Axis
from postproc.machine.chain import XYZ, parse
from postproc.machine.model import Machine
from postproc.machine.tables import COMPONENTS, AxisTable, GridTable
from postproc.nc import dialects
from postproc.nc.expand import Limits, Program
from postproc.nc.expand.written import Written
from postproc.nc.interpreter import Interpreter
from postproc.nc.state import Setup
from postproc.verify import Verifier

NODES = np.linspace(-100.0, 500.0, 7)
LEAST = 1e-4


def mill(
    *components: str, square: dict | None = None, chain: str = "w-X-Y-b-Z-t", **more
) -> Machine:
    """Three axes with these components: 20 um (urad) times a bent curve, nothing else."""
    axes = {}
    for letter in XYZ:
        rows = np.zeros((6, len(NODES)))
        for name in components:
            if name[2] == letter:
                size = 0.02 if name[1] in XYZ else 20e-6
                rows[COMPONENTS.index(name[:2])] = size * np.sin(
                    NODES / 90.0 + COMPONENTS.index(name[:2])
                )
        axes[letter] = Axis(
            letter, (-200.0, 600.0), LEAST, np.zeros(3), AxisTable(letter, NODES, rows, rows)
        )
    return Machine("m", "", "linuxcnc", parse(chain), axes, square=square or {}, **more)


def corrected(machine: Machine, text: str, dialect: str = "linuxcnc", **offsets) -> str:
    filter_ = Filter(machine, dialects.load(dialect), setup_of(machine, offsets or None))
    return (filter_.feed(text.encode()) + filter_.finish()).decode()


def numerical(machine: Machine) -> np.ndarray:
    """(A, A) bool: the same question asked of the deviation itself, at random places."""
    rng = np.random.default_rng(4)
    place = rng.uniform(-90, 490, (3, 60))
    result = np.zeros((3, 3), bool)
    for j in range(3):
        there = place.copy()
        there[j] += rng.uniform(-80, 80, 60)
        result[:, j] = (
            np.abs(machine.deviation(there, 0 * place) - machine.deviation(place, 0 * place)).max(
                axis=1
            )
            > 0
        )
    return result


@pytest.mark.parametrize("chain", ["w-X-Y-b-Z-t", "w-b-Z-X-Y-t", "w-Y-X-Z-b-t"])
def test_the_dependence_is_that_of_the_deviation(chain):
    from postproc.machine.dependence import direct

    for letter in XYZ:
        for kind in "XYZABC":
            machine = mill(f"E{kind}{letter}", chain=chain)
            assert (direct(machine) == numerical(machine)).all(), (kind, letter)
    for letter, lean in (("Y", [0, 0, 1e-4]), ("Z", [1e-4, 0, 0]), ("X", [0, 1e-4, 0])):
        machine = mill(square={letter: np.array(lean)}, chain=chain)
        assert (direct(machine) == numerical(machine)).all()
    values = (
        np.random.default_rng(1).normal(0, 0.01, (6, 7, 7))
        * np.array([0, 1, 0, 0, 0, 0])[:, None, None]
    )
    machine = mill("EXX", chain=chain)
    grid = GridTable("X", "Z", NODES, NODES, values, values)
    machine = replace(
        machine, axes={**machine.axes, "X": replace(machine.axes["X"], grids=(grid,))}
    )
    assert (direct(machine) == numerical(machine)).all()


def test_a_correction_depends_through_the_commands_of_other_axes():
    machine = mill("EXY", "EYZ")  # X by y, y's command by z
    assert machine.depends.tolist() == [
        [True, True, True],
        [False, True, True],
        [False, False, False],
    ]


def test_x_is_corrected_where_nobody_knows_z():
    """EXX alone: a feed of X needs no Z, and what is written is what it is with Z known."""
    machine = mill("EXX")
    text = "G21 G90\nG0 X0\nG1 X100 F500\nX250\nG91 X30\nG90 Z10\nX20\n"
    known = corrected(machine, "G0 X-50 Y0 Z20\n" + text)
    unknown = corrected(machine, "G0 X-50\n" + text)
    assert (
        unknown.splitlines()[2:] == known.splitlines()[2:]
        and unknown.count("\n") > known.count("\n") - 2
    )


def test_an_axis_off_its_reference_is_held_and_not_written():
    """EXY: X depends on y. While Z is lost behind G28, X and Y stay corrected; while Y is lost, a
    motion of Z alone leaves X where it is, and writes no word of it."""
    machine = mill("EXY", "EXX")
    text = "G21 G90\nG0 X50 Y40 Z10\nG1 X60 F300\nG28 Y0\nG1 Z-5\nZ3\nG0 Y40\nG1 X70\n"
    lines = corrected(machine, text, G28={}).splitlines()
    assert lines[-4:-2] == ["G1 Z-5", "Z3"]
    assert "X" in lines[-2] or "X" in lines[-1]


@pytest.mark.parametrize(
    "components, text, named",
    [
        (("EXX",), "G21 G90\nG91 G1 X5 F100\n", "X"),
        (("EXY",), "G21 G90\nG1 X5 F100\n", "Y"),
        (("EXY", "EXZ", "EZX"), "G21 G90\nG0 Y0\nG1 X5 F100\n", "Z"),
        (("ECX",), "G21 G90\nG1 Y5 F100\n", "X"),
        (("EXX", "EYY", "EZZ"), "G21 G90\nG91 G1 Z5 X1 F100\n", "X Z"),
    ],
)
def test_a_refusal_names_only_what_matters(components, text, named):
    machine = mill(*components)
    with pytest.raises(ProgramError) as error:
        corrected(machine, text)
    assert error.value.message.startswith(f"where {named} stands is not known")
    more = {axis: 0.0 for axis in named.split()}  # the way out works
    filter_ = Filter(machine, dialects.load("linuxcnc"), setup_of(machine, start=more))
    assert filter_.feed(text.encode()) + filter_.finish()


def test_a_purge_before_anything_is_known_passes():
    """A printer that purges before it homes: nothing moves that could be corrected."""
    machine = mill("EXX", "EXY", "EZX").carrying(("E",))
    text = "M83\nG1 E5 F100\nG92 E0\nG1 E-1 F1800\n"
    assert corrected(machine, text, "marlin") == text
    with pytest.raises(ProgramError, match="where Y stands"):
        corrected(machine, text + "G1 X5 Z1 F100\nG91\nG1 X1\n", "marlin")


def test_a_place_outside_the_tables_counts_only_where_it_is_known():
    """The Z table begins at 50 here; nobody said where Z is, and X needs none."""
    machine = mill("EXX", "EZZ")
    z = machine.axes["Z"]
    table = AxisTable("Z", NODES + 150.0, z.table.forward, z.table.reverse)
    machine = replace(
        machine, axes={**machine.axes, "Z": replace(z, travel=(50.0, 700.0), table=table)}
    )
    out = corrected(machine, "G21 G90\nG0 X0\nG1 X100 F500\n")
    assert "Z" not in out.replace("TOL", "").split("\n", 2)[2]
    with pytest.raises(ProgramError, match="outside the error table of Z"):
        corrected(machine, "G21 G90\nG0 X0 Z10\n")


def test_a_place_that_the_start_can_not_say_is_not_asked_for_there():
    """M6 takes Z up behind the start: the advice names the way that works."""
    dialect = dialects.load("fanuc-mill")
    axes = tuple("XYZ")
    text = "G90 G54 G0 X0 Y0{}\nT1 M6\n{}G68 X0 Y0 R30.\nG81 X5. Y0 Z-6. R2. F99\nG80\nM30\n"

    def written(first: str, then: str, start: dict[str, float]) -> bytes:
        setup = Setup(
            axes, least_increment=dict.fromkeys(axes, 1e-3), offsets={"G54": {}}, start=start
        )
        program = Program("p.nc", text.format(first, then).encode())
        return b"".join(Written(program, Interpreter(dialect, setup), Limits(steps=99, depth=2)))

    for start in ({}, dict.fromkeys(axes, 0.0)):
        with pytest.raises(ProgramError, match="where Z stands, and that is not known") as error:
            written("", "", start)
        assert ("--start" in error.value.advice) == (not start)
    assert b"G1 Z-6." in written("", "G0 Z9.\n", {})


UNKNOWN = ("G21 G91\n", "G0 X1\n", "G0 X1\n", "G1 X5 F100\n", "G1 X7\n", "G0 X7\n")


def test_the_first_feed_at_an_unknown_place_is_refused_however_the_program_is_cut():
    """Nothing in it could be corrected: the refusal names line 4, where the first feed is, also
    when rapids come before and further feeds behind it in batches of their own."""
    dialect = dialects.load("grbl")
    for cut in (UNKNOWN, ("".join(UNKNOWN),)):
        m = mill("EXX")
        filter_ = Filter(m, dialect, setup_of(m))
        for line in cut:
            filter_.feed(line.encode())
        with pytest.raises(ProgramError, match="where X stands is not known here") as error:
            filter_.finish()
        assert error.value.place.line == 4


def test_rapids_at_an_unknown_place_are_counted_and_the_first_is_named():
    m = mill("EXX")
    for cut in (UNKNOWN[:3], ("".join(UNKNOWN[:3]),)):
        filter_ = Filter(m, dialects.load("grbl"), setup_of(m))
        for line in cut:
            filter_.feed(line.encode())
        filter_.finish()
        assert [(n.line, n.counts) for n in filter_.notices] == [(2, (2, 0, 0))]


OVER = (
    "G21 G90 G40 G49 G80\nG28 G91 Z0\nG90\nT1 M6\nG54\nG1 X10. Y20. F1000.\n",
    "G1 X12.\nG43 Z15. H1\nG1 X50.\nM30\n",
)


def test_feeds_between_a_tool_change_and_the_new_length_stay_as_they_are():
    """CAM programs without rapids lead the tool over the part by G1 (Autodesk's personal licence):
    both are left and counted, and X and Y follow with the first Z. A feed behind G28 alone, and an
    arc, are refused as before."""
    m = mill("EXZ", "EYZ", "EXX")

    def filtered(*parts: str) -> tuple[str, list]:
        offsets = {"G54": {}, "H1": {"Z": 0.0}}
        filter_ = Filter(m, dialects.load("fanuc-mill"), setup_of(m, offsets))
        out = b"".join([*(filter_.feed(p.encode()) for p in parts), filter_.finish()])
        return out.decode(), filter_.notices

    whole, notices = filtered("".join(OVER))
    lines = whole.splitlines()
    assert "G1 X10. Y20. F1000." in lines and "G1 X12." in lines
    first = next(line for line in lines if "Z15" in line)
    place = np.array([[12.0], [20.0], [15.0]])
    off = m.deviation(place, 0 * place)[:, 0]
    assert np.abs(off[:2]).min() > 0.004
    for letter, nominal, error in zip("XY", (12.0, 20.0), off, strict=False):
        assert float(first.split(letter)[1].split()[0]) == pytest.approx(nominal - error, abs=5e-4)
    assert [(n.line, n.counts) for n in notices if n.code == "unknown"] == [(6, (2, 2, 1))]
    for cut in (OVER, [line + "\n" for line in "".join(OVER).splitlines()]):
        assert filtered(*cut)[0] == whole
    for text in (
        "".join(OVER).replace("T1 M6\n", ""),
        "".join(OVER).replace("G1 X12.", "G2 X12. I1."),
    ):
        with pytest.raises(ProgramError, match="where Z stands is not known"):
            filtered(text)


def test_what_else_is_not_known_is_refused_behind_a_tool_change_too():
    """Y is bent by X, and G28 has sent X to an unknown place."""
    m = mill("EYX", "EYZ")
    text = "G21 G90 G40 G49 G80\nG28 G91 X0 Z0\nG90\nT1 M6\nG54\n{}G43 Z15. H1\nG1 X5.\nM30\n"
    offsets = {"G54": {}, "H1": {"Z": 0.0}}
    filter_ = Filter(m, dialects.load("fanuc-mill"), setup_of(m, offsets))
    filter_.feed(text.format("G1 X2. Y20. F99\n").encode())
    filter_.finish()
    with pytest.raises(ProgramError, match="where X Z stands is not known"):
        filter_ = Filter(m, dialects.load("fanuc-mill"), setup_of(m, offsets))
        filter_.feed(text.format("G1 Y20. F99\n").encode())
        filter_.finish()


@pytest.mark.parametrize(
    ("name", "change"),
    [
        *((x, "T2 M6") for x in ("linuxcnc", "mach3", "grbl", "grblhal", "fluidnc", "smoothie")),
        ("marlin", "T1"),
    ],
)
def test_no_rapid_behind_a_tool_change_that_may_stay_away_gets_a_z(name, change):
    """M6 goes back (NIST RS274/NGC 3.6.3; Marlin, tool_change.cpp), but with LinuxCNC's
    TOOL_CHANGE_POSITION, a macro of Mach3 or of a sender it need not: the Z of before would take
    the new tool down on its way. A feed is a cut where Z stands, and gets it."""
    m = mill("EZX", "EXX")
    head = "G21\nG90\nG0 X10 Y10 Z90\nG1 X20 F99\n"
    lines = corrected(m, f"{head}{change}\nG0 X150 Y20\nG0 Z50\nG0 X300 Y20\n", name).splitlines()
    rapids = lines[lines.index(change) + 1 :]
    assert "Z" not in rapids[0] and "X150" not in rapids[0]
    assert "Z" in rapids[1] and "Z" in rapids[2]
    lines = corrected(m, f"{head}{change}\nG1 X150 Y20\n", name).splitlines()
    assert "Z" in lines[-1]


def test_behind_a_tool_call_of_klartext_nobody_knows_z():
    m = mill("EZX", "EXX")
    head = "BEGIN PGM A MM\nTOOL CALL 1 Z S9\nL Z+90 FMAX\nL X+10 Y+10 FMAX\n"
    text = head + "{}\nL X+150 Y+20 FMAX\nL Z+50 FMAX\nEND PGM A MM\n"
    offsets = {"T1": {}, "T2": {}}
    called = corrected(m, text.format("TOOL CALL 2 Z S9"), "heidenhain", **offsets).splitlines()
    assert "Z" not in called[called.index("TOOL CALL 2 Z S9") + 1]
    faster = corrected(m, text.format("TOOL CALL S99"), "heidenhain", **offsets).splitlines()
    assert "Z" in faster[faster.index("TOOL CALL S99") + 1]


@pytest.mark.parametrize("feed", [999, 1])
def test_a_feed_behind_such_a_rapid_begins_where_the_rapid_left_the_tool(feed):
    """Its beginning is not measured, all behind it is: it takes Z where it was, so the rapids
    behind it get their Z again."""
    m = mill("EZX", "EXX")
    head = "G21\nG90\nG0 X10 Y10 Z5\nT2 M6\nG0 X150 Y20\nG1 X150 Y20 F99\nG0 X140 Y20\n"
    for cut in ("G1 Z-2", "G1 Y60"):
        filter_ = Filter(m, dialects.load("linuxcnc"), setup_of(m, None))
        verifier = Verifier(filter_)
        lines = f"{head}{cut}\nG0 X50\nG1 X160\n".encode().splitlines(keepends=True)
        out = b""
        for at in range(0, len(lines), feed):
            out += filter_.feed(b"".join(lines[at : at + feed]))
        written = (out + filter_.finish()).decode().splitlines()
        assert verifier.passed, cut
        rapids = [line for line in written if line.startswith("G0")]
        assert ["Z" in line for line in rapids] == [True, False, False, True]
