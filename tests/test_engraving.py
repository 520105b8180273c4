"""G47 of Haas engraves a text: the block stays, its place and depth are corrected, and what stands
behind it must not count from where the last letter ends.

Haas Mill Operator's Manual (2017), "G47 Text Engraving"; manual 96-8000 rev R, page 159, for the
order of its motions.
"""

from __future__ import annotations

import re

import pytest

from postproc.errors import ProgramError
from postproc.filter import Filter, setup_of
from postproc.machine.file import read_machine
from postproc.machine.model import Machine
from postproc.nc import dialects
from tests.small_machines import write_mill

HEAD = "G21 G90 G54 G0 X0. Y0. Z5.\n"
TEXT = "G47 P0 (HELLO X5 G1) X10. Y5. I45. J5. R1. Z-0.1 F100. E50.\n"
MANUAL = """\
G00 G90 G40 G49 G54
G20 G00 G54 X2. Y2. Z0.1
G47 P0 (TEXT TO ENGRAVE) X2. Y2. I45. J0.5 R0.05 Z-0.005 F15. E10.
G00 G80 Z0.1
G00 Z0.1 M09
G53 G49 Z0 M05
G53 Y0
M30
"""  # O60471 of the manual, its tool's length left out
FROM_THE_END = "a motion from where an engraving has ended"


@pytest.fixture(scope="module", params=[False, True], ids=["one way", "two ways"])
def machine(request, tmp_path_factory) -> Machine:
    return read_machine(write_mill(tmp_path_factory.mktemp("mill") / "mill", request.param))


def run(text: str, machine: Machine) -> tuple[list[str], list[str]]:
    """Lines and notices."""
    setup = setup_of(machine, {"G54": {}})
    filter_ = Filter(machine, dialects.load("haas"), setup)
    out = (filter_.feed(text.encode()) + filter_.finish()).decode().splitlines()
    return [line for line in out if "GCOMP" not in line], [n.message for n in filter_.notices]


def words(line: str) -> dict[str, float]:
    return {m[1]: float(m[2]) for m in re.finditer(r"([XYZ])(-?[0-9.]+)", line.split(")")[-1])}


def test_its_place_and_depth_are_those_of_a_feed_there(machine):
    """X and Y are corrected for the middle of the depth, as a hole's; Z for the bottom: within 0.2
    um of a feed to that place, since 0.1 mm apart nothing bends more."""
    lines, notices = run(HEAD + TEXT + "G0 Z5.\n", machine)
    feed = run(HEAD + "G0 X10. Y5. Z1.\nG1 Z-0.1 F100.\n", machine)[0]
    at = {**words(feed[1]), **words(feed[-1])}
    assert words(lines[1]) == pytest.approx(at, abs=2e-4)
    assert words(lines[1]) != {"X": 10.0, "Y": 5.0, "Z": -0.1}
    assert "(HELLO X5 G1)" in lines[1] and lines[1].endswith("F100. E50.")
    assert any("G47 (engraving) stays" in n for n in notices)


def test_rapids_before_x_and_y_are_named_again_stay_as_written(machine):
    """Only the control knows where the last letter ends: a correction would take the axes back to
    the first one."""
    lines, _ = run(MANUAL, machine)
    assert lines[3:] == MANUAL.splitlines()[3:]
    assert lines[2].startswith("G47 P0 (TEXT TO ENGRAVE) X")


def test_behind_it_places_are_corrected_as_ever(machine):
    """The tool comes from an unknown side to X30 Y-9; from there on all is as without a text."""
    tail = "G0 Z5.\nG0 X30. Y-9.\nG0 X40. Y-20.\nG1 Z-2. F50.\nX60.\n"
    with_text = run(HEAD + TEXT + tail, machine)[0]
    without = run(HEAD + tail, machine)[0]
    assert with_text[4:] == without[3:] and words(with_text[3])["X"] != 30.0


@pytest.mark.parametrize(
    "behind",
    [
        "G1 X50. Y5. F9.",
        "G1 Z-1. F9.",
        "G2 X20. Y5. I5. J0. F9.",
        "G91 G0 X5.",
        "G0 X5.\nG1 Z-1. F9.",
        "G81 X5. Z-1. R1. F9.",
        "G81 Z-1. R1. F9.",
        "G91 G0 Z1. X1.",
    ],
)
def test_nothing_but_rapids_begins_where_it_ended(machine, behind):
    with pytest.raises(ProgramError, match=FROM_THE_END):
        run(HEAD + TEXT + behind + "\n", machine)


@pytest.mark.parametrize(
    "behind",
    [
        "G81 X5. Y2. Z-1. R1. F9.\nG80",
        "G0 X5.\nY6.\nG1 Z-1. F9.",
        "G91 G0 Z1.\nG90 G0 X5. Y6.\nG1 Z-1. F9.",
        TEXT.strip() + "\nG0 X5. Y5.\nG1 Z-1. F9.",
        "G53 G0 Z0.\nG53 Y0.",
    ],
)
def test_places_lead_on(machine, behind):
    run(HEAD + TEXT + behind + "\n", machine)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("G91 G47 P0 (A) Z-1. R1. F9.", "in G91"),
        ("G18 G47 P0 (A) Z-1. R1. F9.", "outside the XY plane"),
        ("G47 P0 (A) R1. F9.", "without Z"),
        ("G47 P0 (A) R1. Z2. F9.", "lies above R"),
        ("G81 Z-1. R1. F9.\nG47 P0 (A) R1. Z-1. F9.", "within a canned cycle"),
    ],
)
def test_what_is_not_said_of_it_is_refused(machine, text, said):
    with pytest.raises(ProgramError, match=said):
        run(HEAD + text + "\n", machine)


@pytest.mark.parametrize("size", [1, 7, 40])
def test_the_batch_does_not_matter(machine, size):
    text = (HEAD + TEXT + TEXT.replace("X10.", "X40.") + "G0 Z5.\nX5.\nY6.\nG1 Z-1. F9.\n").encode()
    whole, parts = (
        Filter(machine, dialects.load("haas"), setup_of(machine, {"G54": {}})) for _ in "12"
    )
    cut = b"".join(parts.feed(text[i : i + size]) for i in range(0, len(text), size))
    assert cut + parts.finish() == whole.feed(text) + whole.finish()
