"""Threads and taps of lathes in step with the spindle: what stays as it is, what is corrected in
place, what is said."""

from __future__ import annotations

import pytest

from postproc.errors import ProgramError
from postproc.filter import Filter, setup_of
from postproc.machine.file import read_machine
from postproc.machine.model import Machine
from postproc.nc import dialects
from tests.corpus.machines import write_smooth

THREADS = {
    "fanuc-lathe-a": [
        "G76 P020060 Q100 R0.05\nG76 X58. Z-8. P1300 Q200 F1.",
        "G92 X58. Z-8. F1.\nX57.5\nX57.",
    ],
    "fanuc-lathe": [
        "G76 P020060 Q100 R0.05\nG76 X58. Z-8. P1300 Q200 F1.",
        "G78 X58. Z-8. F1.\nX57.5\nX57.",
    ],
    "fanuc-lathe-c": [
        "G78 P020060 Q100 R0.05\nG78 X58. Z-8. P1300 Q200 F1.",
        "G21 X58. Z-8. F1.\nX57.5\nX57.",
    ],
    "haas-lathe": ["G76 X58. Z-8. K.6 D.1 F1.", "G92 X58. Z-8. F1.\nX57.5\nX57."],
}


@pytest.fixture(scope="module")
def machine(tmp_path_factory):
    return read_machine(
        write_smooth(tmp_path_factory.mktemp("lathe") / "lathe", True, 1e-4, lathe=True)
    )


def run(text: str, dialect: str, machine: Machine) -> tuple[list[str], list[str]]:
    """Lines and notices."""
    filter_ = Filter(machine, dialects.load(dialect), setup_of(machine))
    out = (filter_.feed(text.encode()) + filter_.finish()).decode().splitlines()
    return [line for line in out if "GCOMP" not in line], [n.message for n in filter_.notices]


@pytest.mark.parametrize(
    ("dialect", "thread"), [(d, t) for d, threads in THREADS.items() for t in threads]
)
def test_a_threading_cycle_stays_and_all_around_it_is_corrected(machine, dialect, thread):
    """B-64304EN-1, "Multiple thread cutting cycle": it ends where it began."""
    head, tail = "G0 X62. Z5.\n", "\nG0 X70.\nG1 Z-9. F.1\n"
    plain = run(head + tail.lstrip(), dialect, machine)[0]
    lines, notices = run(head + thread + tail, dialect, machine)
    assert lines == [plain[0], *thread.split("\n"), *plain[1:]] and plain[0] != head.strip()
    assert any("stays as it is, in step with the spindle" in n for n in notices)


def test_g76_leaves_the_motion_code_before_it_in_force(machine):
    """G76 is of group 00 (B-64304EN-1, "G code list")."""
    program = "G0 X62. Z5.\n{}X70.\nG1 Z-9. F.1\n"
    with_thread = run(program.format("G76 X58. Z-8. P1300 Q200 F1.\n"), "fanuc-lathe-a", machine)[0]
    del with_thread[1]
    assert with_thread == run(program.format(""), "fanuc-lathe-a", machine)[0]


@pytest.mark.parametrize("end", ["G80\nZ9.", "G0 Z9."])
@pytest.mark.parametrize("dialect", ["fanuc-lathe-a", "haas-lathe"])
def test_a_tap_is_corrected_in_place_and_ends_at_the_initial_level(machine, dialect, end):
    """G80, or a code of group 01, ends it; the control is back in G0 then."""
    lines, _ = run(f"G0 X0. Z6.\nG84 X0. Z-19. F.8\n{end}\nG1 X20. F.1\n", dialect, machine)
    word = float(lines[1].split("Z")[1].split()[0])
    assert lines[1].startswith("G84") and lines[1].endswith("F.8") and 0 < abs(word + 19.0) < 0.1
    last = run("G0 X0. Z6.\nG0 Z9.\nG1 X20. F.1\n", dialect, machine)[0]
    assert lines[-1] == last[-1]


def test_r_is_a_distance_on_a_fanuc_and_a_place_on_a_haas(machine):
    """B-64304EN-1, "Front drilling cycle": R from the initial level; Haas lathe operator's manual,
    G84: position of R. From Z6, R-3 lies above a bottom at Z2 on the one, and beyond it on the
    other."""
    text = "G0 X0. Z6.\nG84 X0. Z2. R-3. F.8\nG0 Z9.\n"
    assert run(text, "fanuc-lathe-a", machine)[0][1].startswith("G84 X")
    with pytest.raises(ProgramError, match="bottom lies beyond R"):
        run(text, "haas-lathe", machine)


def test_behind_a_thread_of_sinumerik_no_place_is_known(machine):
    """Where CYCLE97 ends no manual says: X and Z are corrected again when both have been named."""
    lines, notices = run(
        "G18 G90 DIAMON\nG0 X62 Z5\nCYCLE97(2,,0,-20,40,40,4,0,1.2,0,30,0,10,1,3,1)\nG0 X70\nZ9\n"
        "X60\n",
        "siemens",
        machine,
    )
    assert lines[1] != "G0 X62 Z5"
    assert lines[2:4] == ["CYCLE97(2,,0,-20,40,40,4,0,1.2,0,30,0,10,1,3,1)", "G0 X70"]
    assert lines[4].startswith("Z") and "X" in lines[4] and lines[4] != "Z9"
    assert any("CYCLE97 (thread) stays as it is" in n for n in notices)
    assert any("left as they are: 1" in n for n in notices)


def test_a_tap_of_sinumerik_loses_its_axis_alone(machine):
    """In ZX the hole lies along Y, which a lathe has not: X and Z are where they were."""
    tap = "CYCLE840(10,0,2,-15,,0,4,3,1,,1.25)"
    head, tail = "G18 G90 DIAMON\nG0 X62 Z5\n", "G0 X70\nG1 Z1 F99\n"
    plain = run(head + tail, "siemens", machine)[0]
    lines = run(head + tap + "\n" + tail, "siemens", machine)[0]
    assert lines == [*plain[:2], tap, *plain[2:]]


LINUXCNC = (
    "G18 G{} G90 G21 G95\nS800 M3\nG0 X25. Z2.\nG76 P3 Z-23 I-.92 J.18 R1.5 K1.84 Q29.5 H1\n{}"
)


def test_g76_of_linuxcnc_stays_under_g7_and_leads_nowhere_known(machine):
    """Releases differ on I J K of a diameter (cycles/threading.py), and it ends in Z at its word:
    behind it the axes are known again where the program names them."""
    lines, notices = run(LINUXCNC.format(7, "G0 X70.\nZ50.\nG1 Z-9. F.1\n"), "linuxcnc", machine)
    assert lines[3] == "G76 P3 Z-23 I-.92 J.18 R1.5 K1.84 Q29.5 H1"
    assert lines[4] == "G0 X70.", "Z is not known there"
    assert lines[5] != "Z50."
    assert any("stays as it is, in step with the spindle" in n for n in notices)


def test_g76_of_linuxcnc_is_written_out_under_g8(machine):
    with pytest.raises(ProgramError, match=r"G76 \(threading in many passes\)") as error:
        run(LINUXCNC.format(8, "G0 X70. Z50.\n"), "linuxcnc", machine)
    assert "--expand" in error.value.advice
