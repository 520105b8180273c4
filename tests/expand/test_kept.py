"""--expand leaves a drilling cycle as it stands where its hole bends by less than the tolerance of
holes, and writes it out where it bends more. What is left, in part or as a whole, moves LinuxCNC as
the program itself does."""

from __future__ import annotations

import io
import random
import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from postproc.commands import expansion
from postproc.compensate import Options
from postproc.errors import ProgramError
from postproc.filter import Filter, setup_of
from postproc.machine.axis import Axis
from postproc.machine.chain import parse
from postproc.machine.model import Machine
from postproc.machine.tables import AxisTable
from postproc.nc import dialects
from postproc.nc.expand import written
from postproc.verify import Verifier
from tests.campaigns import cases
from tests.expand.plain_lines import Exact, expand, needs_oracle, program_of
from tests.expand.test_holes_linuxcnc import HOLES, _random_holes
from tests.linuxcnc import oracle
from tests.linuxcnc.test_against_linuxcnc import CLOSE
from tests.test_hole_tolerance import mill

DRILLED = re.compile(r"(?i)g\s*0*(7\s*3|8\s*[1235679])(?![0-9])")
BEGIN = "G21 G90 G17\nM3 S500\nG0 X0. Y0. Z50.\n"


def corrected(text: str, machine: Machine, dialect: str = "fanuc-mill", **options):
    """What --expand makes of a program, and what --verify says; every line of it comes as a portion
    of its own too."""
    filter_ = Filter(machine, dialects.load(dialect), setup_of(machine), Options(**options))
    verifier = Verifier(filter_)
    said = SimpleNamespace(file=None, library=[], max_steps=10_000, max_depth=10)
    plain = expansion.written_out(filter_, io.BytesIO(text.encode()), said)
    out = b"".join(expansion.through(filter_, plain, lambda n: None)).decode()
    assert verifier.passed, verifier.report()
    return [line for line in out.splitlines() if "GCOMP" not in line]


# -- the hole decides ------------------------------------------------------------------------------

PECKS = BEGIN + "G98 G83 X10. Y10. Z-40. R2. Q30. F100\nX20.\nG80\nG0 Z50.\nM30\n"


@pytest.mark.parametrize(
    ("bend", "options", "stays"),
    [
        (4.0, {}, True), (6.0, {}, False), (6.0, {"hole_tolerance": 0.007}, True),
        (4.0, {"hole_tolerance": 0.003}, False), (6.0, {"tolerance": 0.008}, True),
        (0.4, {"hole_tolerance": 1e-6}, False), (0.0, {"hole_tolerance": 1e-6}, True),
        (0.0, {"hole_tolerance": 0.0}, False),
    ],
)  # fmt: skip
def test_a_cycle_is_written_out_where_its_hole_bends_by_more_than_its_tolerance(
    bend, options, stays
):
    """The axis lies `bend` um off its middle (tests/test_hole_tolerance.py): X10 less that, to the
    least increment."""
    lines = corrected(PECKS, mill(bend), **{"tolerance": 0.0005, **options})
    assert any("G83" in line for line in lines) == stays
    if stays:
        assert f"G98 G83 X{10 - bend / 1000:.4f}".rstrip("0") in lines[3] and len(lines) == 8
    else:
        assert sum("Z-28." in line for line in lines) >= 2 and "G0 Z2." in "".join(lines)


def test_on_a_machine_without_errors_cycles_stay_to_the_byte():
    loop = BEGIN + "G99 G81 X1. Z-4. R2. F100\nX2. Y3.\nG84 X4.\nG82 X5. P300\nG80\nG0 Z50.\nM30\n"
    assert corrected(loop, mill(0.0)) == loop.splitlines()


def test_a_cycle_whose_numbers_are_worked_out_stays_a_cycle():
    text = (
        "G21 G90 G17\nG0 X0 Y0 Z9\no1 sub\nG98 G81 X#1 Y2 Z-5 R1 F100\nG80\no1 endsub\no1 call"
        " [5]\no1 call [7]\nM2\n"
    )
    lines = corrected(text, mill(0.0), "linuxcnc")
    assert [line for line in lines if "G81" in line] == [
        f"G98 G81 X{x}. Y2 Z-5 R1 F100" for x in (5, 7)
    ]


@pytest.mark.parametrize("dialect", ["fanuc-mill", "haas"])
@pytest.mark.parametrize("cycle", ["G76 X10. Y10. Z-40. R2. Q0.2", "G88 X10. Y10. Z-40. R2. P100"])
def test_fine_boring_stays_a_cycle_or_is_refused(cycle, dialect):
    """The tool goes to the bottom with X and Y held, as in G81: its place and bottom are corrected;
    out it goes beside the wall (Q), where it cuts nothing."""
    text = BEGIN + f"G98 {cycle} F100\nX20.\nG80\nG0 Z50.\nM30\n"
    [first, second] = corrected(text, mill(4.0), dialect, tolerance=0.0005)[3:5]
    code, last = cycle.split()[0], cycle.split()[-1]
    assert first.startswith(f"G98 {code} X9.9960 Y10. Z-40. R2. {last}") and second == "X19.9960"
    with pytest.raises(ProgramError, match=f"{code} can not be written out"):
        corrected(text, mill(6.0), dialect, tolerance=0.0005)


def test_behind_a_hole_that_bends_the_rest_of_its_series_is_written_out():
    """z = -10 bends by 3.5 um, z = -40 by 7 um. R, Z and the initial level hold on in what is
    written out."""
    text = (
        BEGIN + "G98 G81 X10. Y10. Z-10. R2. F100\nX20. Z-40.\nX30. Z-10.\nG80\nG98 G81 X40. Z-10."
        " R2.\nG80\nM30\n"
    )
    lines = corrected(text, mill(7.0), tolerance=0.0005)
    kept = [n for n, line in enumerate(lines) if DRILLED.search(line)]
    assert len(kept) == 2 and lines[kept[0]].startswith("G98 G81 X9.9965 Y10. Z-10.")
    between = lines[kept[0] + 1 : kept[1]]
    assert [
        line
        for line in between
        if "Z50." in line and "X20" in line or "Z50." in line and "X30" in line
    ]
    assert (
        any("Z-40." in line for line in between) and sum("Z-10." in line for line in between) == 1
    )


def test_the_last_hole_of_a_series_that_goes_back_to_the_initial_level_stays():
    """G98 behind G99, as posts write it (holes and taps): NIST RS274/NGC 3.5.16; in LinuxCNC,
    tests/linuxcnc/programs/cycle_g98_after_g99.ngc."""
    for code in ("G81", "G84"):
        text = BEGIN + f"G99 {code} X10. Y0. Z-4. R2. F100\nX20.\nG98 X30.\nG80\nG0 X0.\nM30\n"
        lines = corrected(text, mill(4.0), tolerance=0.0005)
        assert [x for x in lines if x.startswith("G98")] == ["G98 X29.9992"], lines
        assert len(lines) == len(text.splitlines())


MUST = {
    "repeats": "G99 G81 X10. Z-4. R2. K2 F100\n",
    "distances": "G91 G99 G81 X10. Z-4. R-48. F100\nG90\n",
    "turned": "G68 X0. Y0. R30.\nG99 G81 X10. Y0. Z-4. R2. F100\nG80\nG69\nG0 X0. Y0.\n",
    "two motion codes": "G0 G99 G81 X10. Z-4. R2. F100\n",
    "stored and drilled later": "G99 G81 X10. Z-4. R2. K0 F100\nX20.\n",
}


@pytest.mark.parametrize("why", MUST)
def test_what_the_filter_can_not_follow_in_place_is_written_out(why):
    lines = corrected(BEGIN + MUST[why] + "G80\nG0 Z50.\nM30\n", mill(0.0))
    assert any(line.startswith("G1 ") and "Z-" in line for line in lines), lines


def leaning(um_per_mm: float) -> Machine:
    """X pitches by so much, but only where it came in the + direction: the bend depends on the side
    of contact."""
    nodes = np.array([-300.0, 300.0])
    forward, reverse = np.zeros((6, 2)), np.zeros((6, 2))
    forward[4] = um_per_mm * 1e-3
    axes = {x: Axis(x, (-300.0, 300.0), 1e-4, np.zeros(3)) for x in "XYZ"}
    axes["X"] = replace(axes["X"], table=AxisTable("X", nodes, forward, reverse))
    return Machine("m", "", "fanuc-mill", parse("w-Y-b-X-Z-t"), axes)


def test_the_worst_side_of_contact_decides():
    """20 mm deep, 0.6 um/mm from one side: 6 um off the middle; nothing from the other, from which
    this X comes."""
    text = BEGIN + "G98 G81 X-10. Y10. Z-18. R2. F100\nG80\nG0 Z50.\nM30\n"
    straight, bent = corrected(text, leaning(0.45)), corrected(text, leaning(0.6))
    assert any("G81" in line for line in straight) and not any("G81" in line for line in bent)


def _random_series(draw: random.Random) -> str:
    lines = ["G21 G90 G17", "M3 S500", "G0 X0. Y0. Z40."]
    for _ in range(draw.randint(2, 6)):
        cycle = draw.choice(["G81", "G83 Q7.", "G73 Q5.", "G85", "G89 P100", "G84"])
        lines.append(
            f"{draw.choice(['G98', 'G99'])} {cycle} X{draw.randint(-90, 90)}."
            f" Z-{draw.randint(1, 50)}. R3. F100"
        )
        for _ in range(draw.randint(0, 4)):
            depth = f" Z-{draw.randint(1, 50)}." * (draw.random() < 0.4)
            lines.append(f"X{draw.randint(-90, 90)}. Y{draw.randint(-90, 90)}." + depth)
        lines += ["G80", "G0 Z40."]
    return "\n".join([*lines, "M30", ""])


@pytest.mark.parametrize("tolerance", [0.001, 0.005])
def test_what_is_left_a_cycle_is_never_refused_behind(tolerance, monkeypatch):
    """Bends from 0 to 25 um, both ways: the filter takes every cycle that is left, verified,
    however the text comes."""
    draw = random.Random(3)
    left = 0
    for _ in range(12):
        text, slope = _random_series(draw), 10 ** draw.uniform(-2, 0)
        machine = leaning(slope)
        lines = corrected(text, machine, hole_tolerance=tolerance)
        left += sum(bool(DRILLED.search(line)) for line in lines)
        with monkeypatch.context() as one_by_one:
            one_by_one.setattr(written, "LINES_AT_ONCE", 1)
            assert corrected(text, machine, hole_tolerance=tolerance) == lines
    assert left >= 3


# -- LinuxCNC's interpreter ------------------------------------------------------------------------

KEEPS = {
    "every": lambda motions: True,
    "some": lambda motions: motions.target[0, 0] // 1000 % 3 != 0,
}


@needs_oracle()
@pytest.mark.parametrize("which", KEEPS)
def test_linuxcnc_moves_the_same_whatever_is_left(which):
    """Taps are left out: behind holes that are written out LinuxCNC begins their series anew, with
    its rapids in another order."""
    draw = random.Random(7)
    texts = [program_of(holes) for holes in HOLES]
    texts += [_random_holes(draw) for _ in range(cases(100, 250))]
    pairs = []
    for text in (t for t in texts if "84" not in t):
        try:
            lines = expand(text, tracker=Exact, keeps=KEEPS[which])
        except ProgramError:
            continue
        pairs.append((text, "\n".join(line.text.decode() for line in lines)))
    results = oracle.motions_of_many([(text, {}) for pair in pairs for text in pair])
    compared = left = 0
    for (text, out), before, after in zip(pairs, results[::2], results[1::2], strict=True):
        if not isinstance(before, list):
            continue
        assert isinstance(after, list), (after, text, out)
        one, other = ([m for m in motions if _moves(m)] for motions in (before, after))
        assert [m.kind for m in one] == [m.kind for m in other], (text, out)
        for a, b in zip(one, other, strict=True):
            assert a.end == pytest.approx(b.end, abs=10 * CLOSE) and a.seconds == b.seconds, (
                text,
                out,
            )
        compared += 1
        left += bool(DRILLED.search(out))
    assert compared >= 60 and left >= 20


def _moves(motion: oracle.Motion) -> bool:
    return (
        motion.kind == "dwell"
        or max(abs(a - b) for a, b in zip(motion.start, motion.end, strict=True)) > CLOSE
    )
