"""Threads: corrected along the way where the control goes on in step, else at their ends, and the
rest is said."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from postproc.compensate import Options
from postproc.errors import ProgramError
from postproc.filter import Filter, setup_of
from postproc.machine.axis import Axis
from postproc.machine.chain import parse
from postproc.machine.model import Machine
from postproc.machine.tables import AxisTable
from postproc.nc import dialects
from postproc.verify import Verifier
from tests.linuxcnc import oracle

NODES = np.array([-100.0, 0.0, 30.0, 60.0, 100.0, 200.0])
# mm, X by z: bends by up to 15 um over 0 to 100
EXZ = np.array([0.0, 0.0, 0.012, -0.006, 0.010, 0.0])
EZZ = np.array([0.0, 0.0, 0.003, 0.006, 0.010, 0.010])  # mm, along the thread: 100 um/m


def lathe(exz=EXZ, ezz=EZZ) -> Machine:
    rows = np.zeros((6, len(NODES)))
    rows[0], rows[2] = exz, ezz
    axes = {
        "X": Axis("X", (-50.0, 300.0), 1e-4, np.zeros(3)),
        "Z": Axis("Z", (-100.0, 200.0), 1e-4, np.zeros(3), AxisTable("Z", NODES, rows, rows)),
    }
    return Machine("m", "", "linuxcnc", parse("w-b-Z-X-t"), axes)


def corrected(
    text: str, dialect: str, machine: Machine | None = None
) -> tuple[list[str], list[str], Verifier]:
    machine = machine or lathe()
    filter_ = Filter(machine, dialects.load(dialect), setup_of(machine), Options(tolerance=0.001))
    verifier = Verifier(filter_)
    out = filter_.feed(text.encode()) + filter_.finish()
    return out.decode().splitlines(), [n.message for n in filter_.notices], verifier


CHAINED = {
    "linuxcnc": ("G21 G90 G8 G18\nG0 X20 Z100\nG33 Z0 K2\nG0 X30\n", "K2"),
    "linuxcnc G64": ("G21 G90 G8 G18 G64 P0.01\nG0 X20 Z100\nG33 Z0 K2\nG0 X30\n", "K2"),
    "fanuc-lathe-a": ("G0 X20. Z100.\nG32 Z0. F2.\nG0 X30.\n", "F2."),
    "fanuc-lathe": ("G90 G0 X20. Z100.\nG33 Z0. E2.\nG0 X30.\n", "E2."),
    "fanuc-lathe-c": ("G90 G0 X20. Z100.\nG33 Z0. F2.\nG0 X30.\n", "F2."),
    "haas-lathe": ("G0 X20. Z100.\nG32 Z0. F2.\nG0 X30.\n", "F2."),
    "siemens": ("G90 G18 G64\nG0 X20 Z100\nG33 Z0 K2\nG0 X30\n", "K2"),
}
ALONE = {
    "linuxcnc": "G21 G90 G8 G18 G61\nG0 X20 Z100\nG33 Z0 K2\nG0 X30\n",
    "linuxcnc exact stop": "G21 G90 G8 G18 G61.1\nG0 X20 Z100\nG33 Z0 K2\nG0 X30\n",
    "grblhal": "G21 G90 G18\nG0 X20 Z100\nG33 Z0 K2\nG0 X30\n",
    "fanuc-mill": "G21 G90 G18\nG0 X20. Z100.\nG33 Z0. F2.\nG0 X30.\n",
    "fanuc-lathe": "G90 G0 X20. Z100.\nG34 Z0. F2. K0.1\nG0 X30.\n",
    "fanuc-lathe-a": "G0 X20. Z100.\nG32 Z0. F2. Q180000\nG0 X30.\n",
    "fanuc-lathe-c": "G90 G0 X20. Z100.\nG9 G33 Z0. F2.\nG0 X30.\n",
    "siemens": "G90 G18\nG0 X20 Z100\nG33 Z0 K2\nG0 X30\n",
    "fanuc-lathe inverse time": "G90 G93 G0 X20. Z100.\nG33 Z0. F2.\nG0 X30.\n",
}


@pytest.mark.parametrize("case", CHAINED)
def test_a_thread_is_cut_and_every_piece_names_its_lead(case):
    text, lead = CHAINED[case]
    lines, _, verifier = corrected(text, case.split()[0])
    at = next(i for i, line in enumerate(lines) if "G33" in line or "G32" in line)
    pieces = lines[at : at + 4]  # nodes at 60 and 30 and 100, 0 are ends
    assert [len(re.findall(rf"(?<![\d.]){re.escape(lead)}(?![\d.])", line)) for line in pieces] == [
        1,
        1,
        1,
        0,
    ]
    assert not any(re.search(r"G(1|01)\b", line) for line in pieces)
    assert verifier.passed and verifier.corrected.deviation < 0.00106
    assert verifier.uncorrected.deviation > 0.011


@pytest.mark.parametrize("case", ALONE)
def test_elsewhere_it_stays_one_block_and_what_bends_is_said(case):
    """From z = 100 (X off by 10 um) to 0 (by 0): at 30 the chord is 3 um and X 12, 9 off; at 60 6
    and -6, 12 off."""
    lines, notices, verifier = corrected(ALONE[case], case.split()[0])
    assert len(lines) == ALONE[case].count("\n") + 1  # the mark
    said = [n for n in notices if "stays one block" in n]
    assert len(said) == 1 and "up to 12.0 um" in said[0]
    assert verifier.passed  # its ends are right


def test_the_worst_thread_is_named_however_the_text_is_cut():
    text = "G90 G0 X20. Z60.\nG34 Z30. F2. K0.1\nG0 X30.\nZ100.\nX20.\nG34 Z0. F2. K0.1\nG0 X30.\n"
    machine = lathe()
    seen = []
    for step in (1, 17, 1000):
        filter_ = Filter(
            machine, dialects.load("fanuc-lathe"), setup_of(machine), Options(tolerance=0.001)
        )
        for i in range(0, len(text), step):
            filter_.feed(text[i : i + step].encode())
        filter_.finish()
        seen.append(sorted((n.code, n.message, n.line) for n in filter_.notices))
    assert seen[0] == seen[1] == seen[2]
    assert [n for n in seen[0] if n[0] == "thread"][0][2] == 6


def test_what_the_lead_is_off_by_is_said():
    """100 um/m of 2 mm: 0.2 um a turn, 10 um over 100 mm."""
    _, notices, _ = corrected(CHAINED["fanuc-lathe-a"][0], "fanuc-lathe-a", lathe(exz=0 * EXZ))
    said = [n for n in notices if "lead" in n]
    assert len(said) == 1
    assert "100 um/m, 0.200 um a turn of 2 mm, which adds up to 10.0 um" in said[0]
    _, quiet, _ = corrected(CHAINED["fanuc-lathe-a"][0], "fanuc-lathe-a", lathe(ezz=0 * EZZ))
    assert quiet == []


def test_a_thread_that_nothing_leads_to_is_named():
    """The program begins where --start says, uncorrected, and the thread's block does not name its
    code: the thread begins off, and the verifier names its line."""
    machine = lathe()
    setup = setup_of(machine, None, {"X": 20.0, "Z": 100.0})
    filter_ = Filter(machine, dialects.load("fanuc-lathe-a"), setup, Options(tolerance=0.001))
    verifier = Verifier(filter_)
    filter_.feed(b"G32\nZ0. F2.\nG0 X30.\n")
    filter_.finish()
    assert [n.line for n in filter_.notices if n.code == "unled"] == [2]
    assert not verifier.passed
    assert verifier.at_line([2])
    assert not verifier.at_line([1, 3])


def lathe_with_play() -> Machine:
    """4 um on both axes."""
    ends, rows = np.array([-100.0, 200.0]), {"X": 0, "Z": 2}
    lost = {x: np.where(np.arange(6)[:, None] == k, [-0.004, -0.004], 0.0) for x, k in rows.items()}
    tables = {x: AxisTable(x, ends, lost[x], 0 * lost[x]) for x in rows}
    plain = lathe()
    axes = {x: replace(axis, table=tables[x]) for x, axis in plain.axes.items()}
    return replace(plain, axes=axes)


# behind G0 X60. Z120. and X40. Z100., a thread for which X turns, and what it becomes
LED_TO = {
    "linuxcnc": ("G33 X44 Z50 K2 $1 (c)", "G0 X40.0040 Z100.0000 (c)|G33 X44.0040 Z50.0000 K2 $1"),
    "linuxcnc G61.1": (
        "G33 X44 Z50 K2",
        "G0 G64 X40.0040 Z100.0000|G33G61.1  X44.0040 Z50.0000 K2",
    ),
    "siemens": (
        "N1 G33 X=44 Z50 K2 SF=30",
        "N1 G0 X=40.0040 Z100.0000|G33 X44.0040 Z50.0000 K2 SF=30",
    ),
    "fanuc-lathe": ("G33X44.Z50.E2.M8;", "G0X40.0040Z100.0000M8;|G33X44.0040Z50.0000E2.;"),
    "fanuc-lathe-a": (
        "/G32 U4. W-50. F2. Q90000",
        "/G0 U0.0040 W0.0000|/G32 U4.0000 W-50.0000 F2. Q90000",
    ),
    "okuma-lathe": ("G34 X44. Z50. F2. E.1", "G0 X40.0040 Z100.0000|G34 X44.0040 Z50.0000 F2. E.1"),
}


@pytest.mark.parametrize("case", LED_TO)
def test_what_belongs_to_a_thread_stays_with_it_behind_the_rapid_that_is_put_in(case):
    machine, block = lathe_with_play(), LED_TO[case][0]
    dialect, *stop = case.split()
    point = "" if dialect in ("linuxcnc", "siemens") else "."
    text = "\n".join(
        [
            *stop,
            f"G0 X60{point} Z120{point}",
            f"X40{point} Z100{point}",
            block,
            f"G0 X70{point}",
            "",
        ]
    )
    outs = []
    for step in (1, 9, len(text)):
        filter_ = Filter(machine, dialects.load(dialect), setup_of(machine), Options())
        verifier = Verifier(filter_)
        parts = [text[i : i + step].encode() for i in range(0, len(text), step)]
        outs.append(b"".join(map(filter_.feed, parts)) + filter_.finish())
    assert outs[0] == outs[1] == outs[2] and verifier.passed
    assert "|".join(outs[0].decode().splitlines()[-3:-1]) == LED_TO[case][1]


# behind G0 X60. Z120., the blocks, and the line of the thread that begins off
TURNS = {
    "a taper behind a rapid in -": ("G0 X40. Z100.|G32 X44. Z50. F2.", 0),
    "a taper in the chain": ("G0 X40. Z100.|G32 Z50. F2.|X36. Z40.|X37. Z20.", 5),
    "a block without its code": ("G0 X40. Z100.|G32|X44. Z50. F2.", 4),
    "a taper behind a rapid in +": ("G0 X30.|X40. Z100.|G32 X44. Z50. F2.", 0),
    "Z alone": ("G0 X60. Z20.|X40. Z100.|G32 Z50. F2.", 0),
}


@pytest.mark.parametrize("case", TURNS)
def test_a_thread_that_an_axis_turns_back_for_is_named(case):
    """4 um of play, and nothing is put in between threads in step, and before one that does not
    name its code; along it the spindle says where Z stands."""
    machine = lathe_with_play()
    filter_ = Filter(machine, dialects.load("fanuc-lathe-a"), setup_of(machine), Options())
    verifier = Verifier(filter_)
    blocks, line = TURNS[case]
    filter_.feed(f"G0 X60. Z120.\n{blocks}\nG0 X70.\n".replace("|", "\n").encode())
    filter_.finish()
    said = [n for n in filter_.notices if n.code == "turned"]
    assert [n.line for n in said] == [line] * bool(line)
    assert verifier.passed != bool(line) and verifier.in_thread >= bool(line)
    assert not line or said[0].size == pytest.approx(verifier.corrected.deviation, rel=0.35)


@pytest.mark.skipif(oracle.available() is not None, reason=str(oracle.available()))
def test_linuxcnc_accepts_what_is_written():
    program = (
        "G21 G90 G8 G18\nM3 S100\nF100\nG0 X20 Z100\nG33 Z0 K2\nX19.5 Z-20 K2\nG0 X30\nZ100\nM2\n"
    )
    lines, _, _ = corrected(program, "linuxcnc")
    text = "\n".join(lines) + "\n"
    before, after = oracle.motions(program), oracle.motions(text)
    feeds = [m for m in after if m.kind == "feed"]
    assert len(feeds) == 4 and len([m for m in before if m.kind == "feed"]) == 2
    for m in feeds:  # each piece's ends, on the erroneous machine, lie on the nominal thread
        z = m.end[2]
        actual_x, actual_z = m.end[0] + np.interp(z, NODES, EXZ), z + np.interp(z, NODES, EZZ)
        assert actual_x == pytest.approx(20.0 if actual_z > -1e-3 else 19.5, abs=2e-4)


@pytest.mark.skipif(oracle.available() is not None, reason=str(oracle.available()))
def test_linuxcnc_accepts_the_rapid_that_is_put_in():
    program = "G21 G90 G8 G18\nM3 S100\nG0 X60 Z120\nX40 Z100\nG33 X44 Z50 K2 $0\nG0 X70\nM2\n"
    lines, _, _ = corrected(program, "linuxcnc", lathe_with_play())
    motions = oracle.motions("\n".join(lines) + "\n")
    assert [m.kind for m in motions] == ["rapid"] * 3 + ["feed", "rapid"]
    assert [m.end[0] for m in motions] == pytest.approx([60.002, 40.0, 40.004, 44.004, 70.004])


@pytest.mark.parametrize("dialect", ["haas-lathe", "fanuc-lathe-a"])
def test_a_of_a_thread_is_the_angle_of_its_tool(dialect):
    """Haas lathe operator's manual, G76: A, tool nose angle. Elsewhere A names an axis, which a
    lathe of X and Z has not; --expand takes it for the angle of a line."""
    text = "G0 X20. Z2.\nG76 X18.16 Z-20. K.92 D.3 F1.5 A60\nG0 Z5.\n"
    out, said, _ = corrected(text, dialect)
    assert "G76 X18.16 Z-20. K.92 D.3 F1.5 A60" in out
    assert any("thread is cut uncorrected" in s for s in said)
    with pytest.raises(ProgramError, match="has no axis A") as caught:
        corrected("G0 X20. Z2.\nG1 X30. A150.\n", dialect)
    assert caught.value.advice.endswith("if it is the angle of a line: --expand writes it out")
    with pytest.raises(ProgramError, match="has no axis A") as caught:
        corrected("G0 X20. Z2.\nA150.\n", dialect)
    assert "--expand" not in caught.value.advice
