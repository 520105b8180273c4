"""Text to words: letters, exact decimal numbers and places, as a slow reader sees them; nothing
else ever comes out."""

from __future__ import annotations

import re
import warnings
from decimal import Decimal
from pathlib import Path
from random import Random

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from postproc.errors import ProgramError
from postproc.filter import Filter, setup_of
from postproc.machine.file import read_machine
from postproc.nc import dialects
from postproc.nc.grammar import Grammar
from postproc.nc.lexer import lex

ROOT = Path(__file__).resolve().parents[1]
SEMICOLON = st.sampled_from(["comment", "end of block"])
MOST_DIGITS = 18
FAST = settings(max_examples=150, deadline=None)


# -- the slow reader -------------------------------------------------------------------------------


def slow(text: bytes, semicolon: str):
    """Words (block, letter, value, start, number, stop) up to the first faulty block, and the
    fault's offset or None.

    One character after the other, after the grammar. "%" is not its business.
    """
    code = text.decode("latin-1")
    pattern = r"\([^()\n]*\)|;[^\n]*" if semicolon == "comment" else r"\([^()\n]*\)"

    def blank(comment: re.Match) -> str:
        """Blanks; but a comment that breaks a number stays, and its "(" is the fault."""
        breaks = re.match(r"[ \t\r]*[0-9.+-]", code[comment.end() :])
        return comment[0] if breaks else " " * len(comment[0])

    code = re.sub(pattern, blank, code)
    ends = "\n;" if semicolon == "end of block" else "\n"
    words, block, mine, i = [], 0, [], 0

    def skip(k: int) -> int:
        while k < len(code) and code[k] in " \t\r":
            k += 1
        return k

    def digits(k: int) -> tuple[str, int, int]:
        """Digits from k on with blanks among them, where they end, and the next character that is
        none."""
        found, end = "", k
        while (k := skip(k)) < len(code) and code[k] in "0123456789":
            found, end, k = found + code[k], k + 1, k + 1
        return found, end, k

    first = True
    while True:
        i = skip(i)
        if i >= len(code):
            return words + mine, None
        c = code[i]
        if c in ends:
            words, mine, block, first = words + mine, [], block + 1, True
            i += 1
            continue
        if c == "/" and first:
            _, _, i = digits(i + 1)
            first = False
            continue
        first = False
        if not (c.isascii() and c.isalpha()):
            return words, i
        start, stop = i, i + 1
        number = i = skip(i + 1)
        sign = ""
        if i < len(code) and code[i] in "+-":
            sign, i = code[i], i + 1
            stop = i
        whole, end, i = digits(i)
        stop = end if whole else stop
        fraction = ""
        if i < len(code) and code[i] == ".":
            stop = i + 1
            fraction, end, i = digits(i + 1)
            stop = end if fraction else stop
        if not 1 <= len(whole + fraction) <= MOST_DIGITS:
            return words, start
        value = Decimal(f"{sign}{whole or 0}.{fraction or 0}")
        mine.append((block, c.upper(), value, start, number, stop))


def fast(text: bytes, semicolon: str):
    """The lexer's answer in the same form."""
    w = lex(text, Grammar(semicolon))
    words = [
        (
            int(w.block[i]),
            chr(w.letter[i]),
            Decimal(int(w.mantissa[i])).scaleb(-int(w.decimals[i])),
            int(w.start[i]),
            int(w.number[i]),
            int(w.stop[i]),
        )
        for i in range(len(w.letter))
    ]
    return words, w.fault.start if w.fault else None


# -- words -----------------------------------------------------------------------------------------

BLANKS = ["", "", "", " ", "  ", "\t"]
COMMENTS = ["(a comment)", "()", "(X1 ; % [2])", "(\u00e9)"]


def number(rng: Random) -> str:
    def digits(least: int, most: int) -> str:
        return "".join(rng.choices("00123456789", k=rng.randint(least, most)))

    sign = rng.choice(["", "+", "-"])
    return rng.choice(
        [
            sign + digits(1, 5) + rng.choice(["", "." + digits(0, 5)]),
            sign + "." + digits(1, 6),
            sign + digits(1, 18),
            rng.choice(["", "-"]) + digits(1, 9) + "." + digits(0, 9),
            "." + digits(1, 18),
        ]
    )


def line(rng: Random) -> str:
    """Plain blocks with blanks anywhere, also within numbers, and comments between words."""
    text = rng.choice(["", "", "/", " / "])
    for _ in range(rng.randint(0, 6)):
        word = rng.choice("GXZMFabxyzIJKNOTSPQRUW") + number(rng)
        text += "".join(c + rng.choice(BLANKS) for c in word)
        text += rng.choice(["", "", rng.choice(COMMENTS), rng.choice(BLANKS)])
    return text + rng.choice(["", "", "\r", "; X9 (", " ;N1"])


def program(seed: int) -> str:
    """From one number: drawn word by word, drawing took most of the time."""
    rng = Random(seed)
    return "\n".join(line(rng) for _ in range(rng.randint(0, 6)))


PROGRAM = st.integers(0, 2**32).map(program)


@FAST
@given(PROGRAM, SEMICOLON)
@example("X-0.\nY+.5\nZ000000000000000001", "comment")
@example("G 9 1 X - 1 2 . 3 4 (c)Z1", "end of block")
def test_words_are_what_a_slow_reader_reads(program, semicolon):
    text = program.encode("latin-1")
    assert fast(text, semicolon) == slow(text, semicolon)


@FAST
@given(st.text(alphabet="GXYZ0123456789.+-/ \t\n();\r,#[=\x00\u00e9\u00ff", max_size=60), SEMICOLON)
@example("X1(c)2", "comment")
@example("X1(c)  -2", "comment")
@example("X1(c)(d) 2", "comment")
@example("X1(c)" + 60 * " " + "2", "comment")
@example("X1(c)\r2", "comment")
@example("G1 (a (b) c)", "comment")
@example("; ( \nX1)", "comment")
@example("X1;Y,2\nZ3", "end of block")
def test_the_first_fault_is_where_a_slow_reader_stops(program, semicolon):
    text = program.encode("latin-1")
    assert fast(text, semicolon) == slow(text, semicolon)


@FAST
@given(
    PROGRAM,
    st.sampled_from(list(",#[]=&$!*:<>?@^_`{|}~\"'\\") + ["\x00", "\x1b", "\x7f", "\u00e9"]),
    st.data(),
)
def test_a_strange_character_is_named_where_it_stands(program, strange, data):
    """Put between two words of a good program; what stands in blocks before it is read."""
    text = program.encode("latin-1")
    good, fault = fast(text, "comment")
    if fault is not None:
        return
    place = data.draw(st.sampled_from([start for _, _, _, start, _, _ in good] or [0]))
    spoilt = text[:place] + strange.encode("latin-1") + text[place:]
    words, fault = fast(spoilt, "comment")
    assert fault == place
    block = text.count(b"\n", 0, place)
    assert words == [word for word in good if word[0] < block]


@pytest.mark.parametrize(
    "text, start",
    [
        ("G1 X", 3),
        ("G1 X-", 3),
        ("G1 X.", 3),
        ("X[1+2]", 0),
        ("#1=2", 0),
        ("o100 sub", 5),
        ("X1.2.3", 4),
        ("X+-3", 0),
        ("X1,R2", 2),
        ("5", 0),
        ("N1 G1/X1", 5),
        ("X1234567890123456789", 0),
        ("G1 X1000000000.123456789", 3),
        ("X1 (open", 3),
        ("X1 )", 3),
        ("(a)X1(b)2", 5),
        ("G1\nX1\nY=2", 6),
    ],
)
def test_faults_carry_their_offset(text, start):
    fault = lex(text.encode(), Grammar("comment")).fault
    assert fault is not None
    assert fault.start == start
    assert start < fault.stop <= len(text)
    assert fault.message


@given(st.integers(1, MOST_DIGITS), st.integers(0, MOST_DIGITS))
def test_numbers_are_exact_to_eighteen_digits(whole, decimals):
    digits = "9" * whole
    text = f"X-{digits[: max(whole - decimals, 0)]}.{digits[max(whole - decimals, 0) :]}"
    words, fault = fast(text.encode(), "comment")
    assert fault is None
    assert words[0][2] == Decimal(text[1:])


@given(SEMICOLON, st.integers(19, 400))
def test_a_longer_number_is_refused_with_its_length(semicolon, n):
    fault = lex(b"G1 X" + b"1" * n + b"\n", Grammar(semicolon)).fault
    assert str(n) in fault.message
    assert "18" in fault.message


def test_blocks_know_their_line_and_their_slash():
    words = lex(b"G1;X1\n/X2;/X3\n\nX4", Grammar("end of block"))
    assert words.line.tolist() == [0, 0, 1, 1, 2, 3]
    assert words.skip.tolist() == [False, False, True, True, False, False]
    text = [words.text[a:b] for a, b in zip(words.block_start, words.block_stop, strict=True)]
    assert text == [b"G1", b"X1", b"/X2", b"/X3", b"", b"X4"]


@pytest.mark.parametrize(
    ("text", "off", "on"),
    [
        ("G43 H1 Z2./M8", "G43 H1 Z2. M8", "G43 H1 Z2."),
        ("G1 X1. / Y2. F9 (a/b)\nX3.", "G1 X1. Y2. F9\nX3.", "G1 X1.\nX3."),
        ("/G1 X1./M8\nX3.", "/G1 X1. M8\nX3.", "/\nX3."),
        ("N10/G1 X1.;G0 (/)/Z1.", "N10 G1 X1.;G0 Z1.", "N10;G0"),
        ("X1./\r\nM8", "X1.\nM8", "X1.\nM8"),
    ],
)
def test_block_delete_takes_what_stands_behind_a_slash(text, off, on):
    """Haas Mill Operator's Manual, "Block Delete"."""
    grammar = dialects.load("haas").grammar
    for drop, same in ((False, off), (True, on)):
        words, plain = lex(text.encode(), grammar, drop), lex(same.encode(), grammar)
        assert not words.fault
        assert words.within == text.replace("(/)", "   ").find("/", text.startswith("/")) or drop
        for name in ("letter", "mantissa", "decimals", "block", "skip"):
            assert getattr(words, name).tolist() == getattr(plain, name).tolist()


@pytest.mark.parametrize("text", ["X1/2", "X1//M8", "X1/M8/M9", "X[1/2]", "X1/#1"])
def test_a_slash_that_may_divide_is_refused(text):
    for drop in (False, True):
        assert lex(text.encode(), dialects.load("haas").grammar, drop).fault
        assert lex(b"X1/M8", dialects.load("fanuc-mill").grammar, drop).fault


def test_a_tape_mark_ends_the_batch():
    words = lex(b"G1 X1\n%\nX2,\n", Grammar("comment"))
    assert (words.tape, words.fault) == (6, None)
    assert bytes(words.letter) == b"GX"


# -- any bytes -------------------------------------------------------------------------------------

BYTES = st.one_of(
    st.binary(max_size=80),
    st.text(alphabet="GXZIKRFMTUWSN0123456789.-+ \n/%();", max_size=80).map(str.encode),
    st.lists(
        st.sampled_from(
            b"G0 G1 G2 G3 G4 G20 G21 G17 G18 G28 G41 G53 G54 G55 G80 G81 G90 G91 G92 G93 G95 M2 M3"
            b" M30 M98 T0101 X20. Z30. X0 Z0 X-1. Z600. X1.23456789012 U5. W-2. I5. K-5. R20. R-20."
            b" P2 F100. S9 N1 / % (c) ; \n \n \n".replace(b" \n", b"  \n").split(b" ")
        ),
        max_size=25,
    ).map(b" ".join),
)


@FAST
@given(st.binary(max_size=200), SEMICOLON)
def test_the_lexer_never_raises(text, semicolon):
    words = lex(text, Grammar(semicolon))
    assert words.text == text
    assert (words.start < words.number).all()
    assert (words.number < words.stop).all()


@pytest.mark.parametrize(
    "name, dialect",
    [
        ("perfect", "linuxcnc"),
        ("perfect", "fanuc-lathe"),
        ("studer-s36", "fanuc-lathe"),
        ("studer-s36", "linuxcnc"),
    ],
)
def test_any_bytes_pass_or_are_refused(name, dialect):
    """Nothing but a ProgramError comes out, and a machine without errors passes its input to the
    byte."""
    machine, language = read_machine(ROOT / "machines" / name), dialects.load(dialect)

    @settings(max_examples=150, deadline=None)
    @given(BYTES)
    @example(b"G0 X20. Z30.\nG93 G1 Z0\n")
    @example(b"G0 X20. Z30.\nM98 P1000\nX5. Z5.\n")
    @example(b"G90 G0 X20. Z10.\n G1 X30. %\n")
    def law(text):
        filter_ = Filter(machine, language, setup_of(machine))
        try:
            out = filter_.feed(text) + filter_.finish()
        except ProgramError as error:
            assert error.place is not None
            assert 1 <= error.place.line <= text.count(b"\n") + 1
            assert error.message
            return
        if machine.is_zero:
            assert out == text

    law()


# -- a second opinion ------------------------------------------------------------------------------


@settings(max_examples=60, deadline=None)
@given(
    st.sampled_from(["G0", "G1", "G01", "g1", "N20 G1", "G90 G1", ""]),
    st.dictionaries(
        st.sampled_from("XYZ"),
        st.from_regex(r"-?[0-9]{1,4}(\.[0-9]{1,4})?", fullmatch=True),
        min_size=1,
    ),
    st.sampled_from(["", " F250", " F12.5"]),
    st.sampled_from(["", " (a comment)"]),
)
def test_pygcode_reads_the_same_words(code, axes, feed, comment):
    """pygcode 0.2.1, its own reader and its own rules."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from pygcode import Line
    text = f"{code} {' '.join(x + v for x, v in axes.items())}{feed}{comment}".strip()
    theirs = [(word.letter, float(word.value)) for word in Line(text).block.words]
    mine, fault = fast(text.encode(), "comment")
    assert fault is None
    assert [(letter, float(value)) for _, letter, value, *_ in mine] == theirs


@pytest.mark.parametrize(
    ("dialect", "text", "letters"),
    [
        ("siemens", 'MSG("a;b") F9', b"F"),
        ("siemens", 'T="A;B" M6 ; "x;', b"TM"),
        ("siemens", 'F9 ; MSG("a") S5', b"F"),
        ("siemens", 'MSG("a") ; "b" S5', b""),
        ("siemens", "S1=1500 M1=3 S2=9 M2=4", b"SM"),
        ("heidenhain", 'TOOL CALL "A;B" Z S5', b"TS"),
        ("heidenhain", 'TOOL CALL "A" Z ; "S5', b"T"),
        ("fagor", "G1 F9 ; X5", b"GF"),
    ],
)
def test_a_semicolon_in_a_string_begins_no_comment(dialect, text, letters):
    words = lex(text.encode() + b"\n", dialects.load(dialect).grammar)
    assert (words.letter.tobytes(), words.fault) == (letters, None)
