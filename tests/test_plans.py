"""What is remembered of lines that are alike: it is used, changes nothing, and stays small."""

from __future__ import annotations

import random
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from postproc.compensate.columns import Columns
from postproc.errors import ProgramError
from postproc.filter import Filter, setup_of
from postproc.machine.file import read_machine
from postproc.nc import dialects, interpreter, lexer, plans
from postproc.nc.grammar import Grammar
from postproc.nc.lexer import lex
from postproc.records import names, replace
from tests.small_machines import write_mill

ROOT = Path(__file__).resolve().parents[1]
STUDER = read_machine(ROOT / "machines" / "studer-s36")
HEAD = b"G21 G90 G17 G54 G94 F900\nG0 X10. Y10. Z30.\nG1 X12. Y11. Z29.5\n"
LATHE = b"G21 G98 G0 X40. Z100.\nG1 X41. Z99. F200\n"
NUMBER = st.decimals(1, 35, places=3).map(lambda x: f"{x}".rstrip("0"))
WORDS = st.sampled_from(
    ["X{0}Y{1}Z{2}", "X{0} Y{1}", "Z{2}", "X-.{3}", "G1 X{0} Z{2}", "G0 X{0} Y{1}", "N{3} X{0}",
     "N{3} G1 Y{1} F{4}00", "F{4}00", "G4 P.{3}", "G91", "G90", "G90 X{0} Y{1} Z{2}", "M8", "M9",
     "G20", "G21", "(none)", "", "X{3}", "G2 X{0} Y{1} R200.", "G53 G0 Z30.", "G92 X{0}", "G92.1",
     "G28", "T{4} M6", "G43 H{4}", "G49", "S{3} M3", "U{3} W{4}", "G55", "G54", "/X{0}", "G0Z{2};a"]
)  # fmt: skip
LINES = st.lists(
    st.builds(
        lambda text, x, y, z, n, few: text.format(x, y, z, n, few),
        WORDS, NUMBER, NUMBER, NUMBER, st.integers(0, 99), st.integers(1, 3),
    ),
    min_size=1, max_size=12,
)  # fmt: skip


@pytest.fixture(scope="module")
def mills(tmp_path_factory):
    folder = tmp_path_factory.mktemp("mills")
    return [read_machine(write_mill(folder / str(both), both)) for both in (False, True)]


def outcome(filter_: Filter, parts: list[bytes]) -> tuple[object, ...]:
    """Text, refusal, notices and counts."""
    out, said = b"", ""
    try:
        for part in parts:
            out += filter_.feed(part)
        out += filter_.finish()
    except ProgramError as error:
        out, said = out + error.delivered, str(error)
    told = [(n.code, n.message, n.line, n.counts) for n in filter_.notices]
    return out, said, told, sorted(vars(filter_.summary).items())


def filter_of(machine, dialect: str) -> Filter:
    zeros = dict.fromkeys(machine.letters, 0.0)
    offsets = {"G54": zeros, "G55": zeros | {"X": 1.5}, "T0101": zeros}
    return Filter(machine, dialects.load(dialect), setup_of(machine, offsets=offsets))


def check(machine, dialect: str, text: bytes) -> None:
    """Line by line with and without what is remembered, and at once."""
    lines = text.splitlines(keepends=True)
    planned = outcome(filter_of(machine, dialect), lines)
    without = filter_of(machine, dialect)
    without.interpreter.plans.none = True
    assert planned == outcome(without, lines)
    assert planned[:2] == outcome(filter_of(machine, dialect), [text])[:2]


@settings(deadline=None, max_examples=40)
@given(st.sampled_from(["linuxcnc", "grbl", "haas", "siemens", "mach3"]), LINES)
def test_what_is_remembered_changes_nothing(mills, dialect, lines):
    """The program twice over, so that its lines meet plans of themselves."""
    text = HEAD + 2 * ("\n".join(lines) + "\n").encode()
    for machine in mills:
        check(machine, dialect, text)


@settings(deadline=None, max_examples=20)
@given(LINES)
def test_nor_on_a_lathe_with_increments(lines):
    text = LATHE + 2 * ("\n".join(x for x in lines if "Y" not in x) + "\n").encode()
    check(STUDER, "fanuc-lathe", text)


SAFE = (
    "X{0}", "X{0} Y{1}", "X{0}Y{1}Z{0}", "G1 X{0} Y{1}", "G0 X{0} Y{1}", "N{2} X{0}", "F{2}00",
    "G1 Y{1} F{2}00", "G0", "G1", "G91", "G90", "G90 X{0}", "G20", "G21", "M8", "M9", "(none)",
    "G4 P.{2}", "G54", "G55", "S{2}00 M3", "G90 G21 G54", "G49", "G17", "G40", "G92 X{0}",
    "G92.1", "/X{0}", "T{2}",
)  # fmt: skip


def drawn(rng: random.Random, words: tuple[str, ...]) -> bytes:
    """Twelve times five lines of few kinds, each time from one place and with the modes of HEAD."""
    text = HEAD.decode()
    for _ in range(12):
        text += "G21 G90 G54 G1 G49 G92.1 X10. Y10. Z30. F900\n"
        few = rng.sample(words, 3)
        for _ in range(5):
            x, y = (f"{rng.randint(10, 13) / 10:.1f}" for _ in "XY")
            text += rng.choice(few).format(x, y, rng.randint(1, 3)) + "\n"
    return text.encode()


@pytest.mark.parametrize("seed", range(40))
def test_programs_of_few_kinds_of_lines_are_what_they_are_without_plans(mills, seed):
    """Hypothesis' programs are short, and end at the first line that is refused: these go on."""
    text = drawn(random.Random(seed), SAFE)
    check(mills[seed % 2], "linuxcnc", text)
    lines = text.splitlines(keepends=True)
    assert not outcome(filter_of(mills[seed % 2], "linuxcnc"), lines)[1]


def batches(monkeypatch, machine, lines: list[bytes], dialect: str = "linuxcnc") -> int:
    """How many of lines are worked out from the start."""
    made = []

    class Counted(interpreter.Batch):
        def __init__(self, *arguments):
            made.append(1)
            super().__init__(*arguments)

    monkeypatch.setattr(interpreter, "Batch", Counted)
    filter_ = filter_of(machine, dialect)
    filter_.feed(HEAD)
    made.clear()
    for line in lines:
        filter_.feed(line)
    assert filter_.summary.changed
    return len(made)


@pytest.mark.parametrize(
    ("line", "most"),
    [(b"X%d.25 Y%d.5 Z2%d.\n", 1), (b"N%d G1 X%d.5 F900 (a)\nZ2%d.\n", 2),
     (b"G91 X.%d Y.%d Z-.%d\n", 2), (b"G1 X%d. Y1%d.\nG4 P.5\nM8\nG0 Z3%d.\n", 5)],
)  # fmt: skip
def test_a_line_like_one_before_is_worked_out_once(monkeypatch, mills, line, most):
    text = b"".join(line % (k % 9, k % 8, k % 7) for k in range(40))
    assert batches(monkeypatch, mills[0], text.splitlines(keepends=True)) <= most


def test_so_is_what_its_strokes_are(monkeypatch, mills):
    made = []
    monkeypatch.setattr(Columns, "_whole", lambda b, whole=Columns._whole: made.append(whole(b)))
    filter_ = filter_of(mills[0], "linuxcnc")
    filter_.feed(HEAD)
    made.clear()
    for k in range(9):
        filter_.feed(b"X1%d.\n" % k)
    assert len(made) == 1


def test_other_values_than_places_are_other_plans(monkeypatch, mills):
    lines = [b"G1 X%d. S%d00\n" % (k % 5, k + 1) for k in range(9)]
    assert batches(monkeypatch, mills[0], lines) == len(lines)


@pytest.mark.parametrize("line", [b"G1 X%d. F%d00\n", b"X%d.\nF%d00\n", b"X%d.\nN5 G4 P.%d\n"])
def test_another_feed_or_dwell_is_no_other_plan(monkeypatch, mills, line):
    text = b"".join(line % (k % 5, k + 1) for k in range(9))
    assert batches(monkeypatch, mills[0], text.splitlines(keepends=True)) <= 4


@pytest.mark.parametrize("dialect", ["fanuc-mill", "haas"])
def test_the_point_of_a_place_is_asked_for_and_no_other(monkeypatch, mills, dialect):
    lines = [b"N%d G1 X1%d. Y2. F900\n" % (k, k) for k in range(9)]
    assert batches(monkeypatch, mills[0], lines, dialect) == 1


def test_little_is_kept(monkeypatch, mills):
    monkeypatch.setattr(plans, "MOST", 3)
    monkeypatch.setattr(lexer, "MOST_SHAPES", 4)
    filter_ = filter_of(mills[0], "linuxcnc")
    filter_.dialect = replace(filter_.dialect, grammar=Grammar())
    filter_.feed(HEAD)
    for k in range(12):
        filter_.feed(b"X%d. S%d00 %s\n" % (k, k, b" " * k))
    assert len(filter_.interpreter.plans.by_key) <= 3
    assert len(filter_.dialect.grammar.shapes) <= 4


DIGITS = st.text("0123456789", min_size=60, max_size=60)


@given(
    st.text("XYG0123.+- ()/;%\r\nN", min_size=1, max_size=60), DIGITS,
    st.sampled_from(["comment", "end of block"]),
)  # fmt: skip
def test_a_text_of_a_known_shape_is_read_as_any(text, digits, semicolon):
    other = "".join(d if c.isdigit() else c for c, d in zip(text, digits, strict=False))
    grammar = Grammar(semicolon=semicolon)
    lex(text.encode(), grammar)
    known = lex(other.encode(), grammar)
    new = lex(other.encode(), Grammar(semicolon=semicolon))
    for name in names(lexer.Words):
        one, two = getattr(known, name), getattr(new, name)
        if isinstance(one, np.ndarray):
            assert np.array_equal(one, two), name
            assert one.dtype == two.dtype, name
        else:
            assert str(one) == str(two), name
