"""Laws for every dialect, also a stranger's."""

from __future__ import annotations

import re
from collections import defaultdict
from pathlib import Path

import numpy as np
import pytest

from postproc.errors import UsageError
from postproc.nc import codes, dialects
from postproc.nc.cycles import family
from postproc.nc.expand import siemens_holes
from postproc.nc.interpreter import Interpreter
from postproc.nc.lexer import lex
from postproc.nc.spellings import respelled
from postproc.nc.state import NONE, Setup
from tests import dialects_doc

ROOT = Path(__file__).parents[2]
NAMES = dialects.names()
DRILLED = ("MCALL", *siemens_holes.NAMES)  # what Sinumerik's language writes out
LETTERS = set("ABCDEFGHIJKLMNOPQRSTUVWXYZ")
# what is wrong, a colon, what to do
HAS_WAY_OUT = re.compile(r"^[a-z/(].*\S: \S.*[^.]$", re.DOTALL)

pytestmark = pytest.mark.parametrize("name", NAMES)


# -- rows ------------------------------------------------------------------------------------------


def test_codes_are_whole(name):
    dialect = dialects.load(name)
    words = [code.word for code in dialect.codes]
    spelled = [codes.code_number(word) for word in words]
    assert len(spelled) == len(set(spelled)), "a code stands twice"
    for code in dialect.codes:
        assert re.fullmatch(r"G\d+(\.\d)?|#?[A-Z][A-Z0-9_]*", code.word), code
        assert code.meaning, code
        assert 0 <= code.number < dialects.NOTHING, code
        assert not code.does or code.does in codes.DOES, (
            f"{code.word} does {code.does!r}: a key of postproc.nc.codes"
        )
        # ROT alone takes a shift back; with words it is refused.
        assert not code.refuses or code.does in (
            "",
            "frame",
            "thread by diameter",  # stays under G7, is refused where it can be written out
        ), f"{code.word}: what the interpreter does it does not refuse"


def test_the_motions_and_modes_that_the_interpreter_asks_for(name):
    dialect = dialects.load(name)
    for number in (0, 10, 20, 30):
        assert dialect.by_number[number].group == "motion"
    for number in (170, 180, 190):
        assert dialect.by_number[number].group == "plane"
    for number, group in ((200, "units"), (210, "units")):
        assert dialect.by_number[number].group == group
    if not dialect.increments:
        assert {900, 910} <= set(dialect.by_number), (
            "places and distances are told by G90 and G91, or by letters"
        )
    for group, numbers in (("distance", (900, 910)), ("feed mode", (930, 940, 950))):
        for number in numbers:
            assert number not in dialect.by_number or dialect.by_number[number].group == group, (
                number
            )
    for group, numbers in (("diameter", (70, 80)), ("arc centre", (901, 911))):
        own = [c for c in dialect.codes if c.group == group and not c.refuses]
        have = {c.number for c in own if c.does != "polar on"}  # X is what face.py says
        assert have <= {*numbers, codes.code_number("DIAM90")}, group


def test_what_is_like_a_code_of_another_control_stands_in_its_group(name):
    """And that code is somewhere a code of its own."""
    own = {
        (code.word, code.group)
        for dialect in dialects_doc.every()
        for code in dialect.codes
        if not code.like
    }
    for code in dialects.load(name).codes:
        if code.like:
            assert (code.like, code.group) in own, f"{code.word} is like {code.like}"


def test_spellings_of_one_code_do_the_same(name):
    by_number = defaultdict(set)
    for code in dialects.load(name).codes:
        by_number[code.number].add((code.group, code.takes, code.does, bool(code.refuses)))
    assert all(len(kinds) == 1 for kinds in by_number.values())


def test_what_is_refused_says_the_way_out(name):
    dialect = dialects.load(name)
    for code in dialect.codes:
        assert not code.refuses or HAS_WAY_OUT.match(code.refuses), (
            f"{code.word}: say what is wrong, a colon, what to do"
        )
    for number, reason in dialect.m_refuses.items():
        assert number >= 0
        assert HAS_WAY_OUT.match(reason), f"M{number}: say what is wrong, a colon, what to do"
        assert number not in dialect.m_codes, f"M{number} is refused, and passed"
    for number, meaning in dialect.m_codes.items():
        assert number >= 0
        assert meaning


def test_expand_is_promised_only_where_it_is(name):
    """A sentence that names --expand needs somebody who writes such codes out."""
    dialect = dialects.load(name)
    written = family(dialect)
    ways = written.codes | set(written.control.codes if _codes(written) else ())
    for code in dialect.codes:
        if "--expand" not in code.refuses:
            continue
        if code.refuses == codes.CALL:
            assert dialect.language, f"{code.word}: nobody runs this language"
        elif _codes(written):
            assert codes.code_number(code.word) in ways, f"{code.word}: nobody writes it out"
        else:
            by_language = code.refuses == codes.FRAME or code.word in DRILLED
            assert codes.code_number(code.word) in ways or by_language, (
                f"{code.word}: nobody writes it out (FAMILIES in nc/cycles, by the name)"
            )
    if codes.CALL in dialect.m_refuses.values():
        assert dialect.language


def _codes(written) -> bool:
    return hasattr(written.control, "codes")


def test_a_modal_code_that_moves_otherwise_is_refused_or_done(name):
    """No code of the motion group is read as a straight line by mistake."""
    for code in dialects.load(name).codes:
        if code.group == "motion" and code.number not in (0, 10, 20, 30, 800):
            assert code.refuses or code.does in (
                *codes.CYCLE_KEYS,
                *codes.STAY_KEYS,
                *codes.SPLINE_KEYS,
            ), code
    dialect = dialects.load(name)
    if dialect.arc_centre == "pole":
        assert dialect.is_refused[[20, 30]].all(), "nobody keeps a pole from block to block yet"


# -- the dialect -----------------------------------------------------------------------------------


def test_a_dialect_is_found_by_its_name_and_is_data(name):
    dialect = dialects.load(name)
    assert dialect.name == name
    assert dialect.title
    assert dialect.grammar.semicolon in ("comment", "end of block")
    assert dialect.plane in (170, 180, 190)
    assert dialect.motion in (NONE, 0, 10)
    assert dialect.integers in ("units", "least increments")
    assert dialect.arc_centre in ("incremental", "pole")
    assert dialect.length_letter in ("H", "D", "T")
    assert set(dialect.increments) <= LETTERS
    assert set(dialect.dwell) <= LETTERS
    assert set(dialect.repeats) <= LETTERS
    assert set(dialect.letters) <= LETTERS
    assert len(dialect.carried_codes) == (2 if dialect.carried else 0)
    assert 0 < dialect.arc_tolerance_mm <= dialect.arc_tolerance_most_mm
    assert dialect.integers == "units" or dialect.integer_notice
    assert set(dialect.exact_stops) <= set(dialect.by_number)
    assert not set(dialect.ends) - set(dialect.m_codes), (
        "a code that ends the program is none of its M codes"
    )
    with pytest.raises(AttributeError):
        dialect.plane = 170


def test_it_says_where_its_facts_come_from(name):
    text = (ROOT / "postproc" / "nc" / "dialects" / f"{name.replace('-', '_')}.py").read_text()
    doc = text.split('"""')[1]
    assert re.search(r"manual|documentation|\.[ch]p?p?\b|B-\d{5}", doc, re.IGNORECASE), (
        "name the manual, or the source file"
    )


def test_keywords_are_codes_and_the_other_way_round(name):
    """A word that the grammar reads as a code is a row of the table."""
    dialect = dialects.load(name)
    words = {code.word for code in dialect.codes if not re.fullmatch(r"G[\d.]+", code.word)}
    assert set(dialect.grammar.keywords) == words
    for word in sorted(words)[:400]:
        read = respelled(word.encode() + b"\n", dialect.grammar)
        assert (
            codes.code_number(word) - codes.KEYWORD == int(read[1:].split()[0]) or len(word) < 3
        ), word


def test_its_signs_are_regular_expressions(name):
    dialect = dialects.load(name)
    assert dialect.signs, "say how a program of this control can be told"
    for sign in (*dialect.signs, *dialect.remarks):
        assert sign.isascii()
        assert not re.compile(sign, re.MULTILINE).search(""), "a sign that is everywhere is none"


# -- the interpreter with it -----------------------------------------------------------------------


def test_the_state_at_the_start(name):
    dialect = dialects.load(name)
    state = Interpreter(
        dialect, Setup(("X", "Y", "Z"), least_increment={"X": 1e-3, "Y": 1e-3, "Z": 1e-3})
    ).initial()
    assert state.codes["plane"] == dialect.plane
    assert (state.codes["distance"], state.codes["units"], state.codes["feed mode"]) == (
        900,
        210,
        940,
    )
    assert state.codes["motion"] == dialect.motion
    for group, number in state.codes.items():
        assert (
            number == NONE
            or group not in dialect.groups
            or number not in dialect.by_number
            or dialect.by_number[number].group == group
        )


def test_every_code_of_it_can_be_read(name):
    """A block with the code alone makes no traceback, and leaves no axis at a place that it
    invented."""
    dialect = dialects.load(name)
    setup = Setup(
        ("X", "Y", "Z"),
        least_increment={"X": 1e-3, "Y": 1e-3, "Z": 1e-3},
        start={"X": 0.0, "Y": 0.0, "Z": 0.0},
    )
    interpreter = Interpreter(dialect, setup)
    for code in dialect.codes:
        text = code.word + (dialect.block_end or "") + "\n"
        words = lex(text.encode(), dialect.grammar)
        assert words.fault is None, (code, words.fault)
        _, state, _ = interpreter.run(words, interpreter.initial())
        assert (state.position == 0).all() or not state.known.all(), code


def test_a_code_that_it_has_not_is_not_read_as_one_that_it_has(name):
    """G20 is no code of Siemens, though its G70 counts as G20 everywhere."""
    dialect = dialects.load(name)
    spelled = {codes.code_number(code.word) for code in dialect.codes}
    for number in {code.number for code in dialect.codes} - spelled:
        assert dialect.group_of[dialect.meant[number]] == dialects.UNKNOWN
    assert (dialect.group_of[dialect.meant[sorted(spelled)]] != dialects.UNKNOWN).all()
    assert np.count_nonzero(dialect.meant != dialects.NOTHING) == len(spelled)


# -- docs/DIALECTS.md ------------------------------------------------------------------------------


def test_the_page_of_dialects_is_up_to_date(name):
    assert dialects_doc.chapter(dialects.load(name)) in dialects_doc.DOC.read_text(), (
        "run: python -m tests.dialects_doc"
    )


def test_an_unknown_name_is_answered_with_the_names(name):
    with pytest.raises(UsageError, match=name):
        dialects.load("klingon")
