"""LinuxCNC programs written out, with the motions of LinuxCNC's own interpreter for the original;
what it refuses is refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.expand.linuxcnc_lines import PROGRAMS, Fine, by_oracle, check, refused, run
from tests.linuxcnc import oracle
from tests.linuxcnc.test_against_linuxcnc import (
    AXES,
)


@pytest.fixture(scope="module")
def theirs():
    loaded = {path: oracle.load(path) for path in PROGRAMS}
    return dict(zip(loaded, by_oracle(list(loaded.values())), strict=True))


def test_there_are_enough_programs():
    assert len(PROGRAMS) >= 80


@pytest.mark.parametrize("path", PROGRAMS, ids=lambda path: path.stem)
def test_motions_are_those_of_linuxcnc(path, theirs):
    check(*oracle.load(path), theirs[path])


def test_subs_in_files(tmp_path):
    """LinuxCNC finds files by their path from the root; the name behind it is that of the sub."""
    folder = Path(
        "/", *[part.lower() for part in tmp_path.parts[1:-1]], "x" + str(abs(hash(tmp_path)))
    )
    try:
        folder.mkdir(parents=True)
    except OSError as e:
        pytest.skip(f"no folder in small letters: {e}")
    files = {
        "one": (
            "o<one> sub\nG0 X#1\no<helper> call [2]\no<one> endsub [4]\no<helper> sub\nG0"
            " Y#1\no<helper> endsub\nM2\n"
        ),
        "four": "G0 X9\no<four> sub\nG0 X#1\no<four> endsub\nM2\n",
        "six": "%\no<six> sub\nG0 X#1\nM2\no<six> endsub\n",
    }
    programs = [
        "G0\no<{}/one> call [3]\nZ#<_value>\no<{}/one> call [5]\no<one> call [6]\nM2\n",
        "o<{}/one> call [3]\nG0 Z1\no<helper> call[9]\nM2\n",
        "o<{}/four> call [3]\no<four> call [4]\nG0 Z1\nM2\n",
        "o<one> sub\nG0 X9\no<one> endsub\no<{}/one> call [3]\nM2\n",
        "o<{}/six> call [3]\nG0 Z1\nM2\n",
    ]
    try:
        for name, text in files.items():
            (folder / f"{name}.ngc").write_text(text)
        programs = [(text.replace("{}", str(folder)), {}) for text in programs]
        answers = by_oracle(programs)
    finally:
        for path in folder.iterdir():
            path.unlink()
        folder.rmdir()
    library = {name: text.encode() for name, text in files.items()}
    for (text, kwargs), expected in zip(programs, answers, strict=True):
        check_with(library, text.replace(f"{folder}/", ""), kwargs, expected)


def check_with(library, text, kwargs, expected):
    plain = [line.text.decode() for line in run(text, kwargs, library, tracker=Fine)]
    check("\n".join(plain), kwargs, expected)


REFUSED_BY_BOTH = {
    "G0 X#<a>": (1, "#<a> has no value yet"),
    "G0 X##1": (1, "there is no parameter #0"),
    "G0 X1\nX#5602": (2, "there is no parameter #5602"),
    "#1.5=3": (1, "1.5, which is no whole number"),
    "#5420=1": (1, "#5420 belongs to the control"),
    "#<_x>=1": (1, "#<_x> can be read only"),
    "G0 X[1/0]": (1, "division of 1 by zero"),
    "G0 X[SQRT[-1]]": (1, "SQRT of -1 does not exist"),
    "G0 X[LN[0]]": (1, "LN of 0 does not exist"),
    "G0 X[ACOS[2]]": (1, "ACOS of 2 does not exist"),
    "G0 X[[-8]**[1/3]]": (1, "-8 ** 0.3333333333 is no number"),
    "G0 X[EXP[1000]]": (1, "EXP of 1000 does not exist"),
    "G0 X[5 MOD 0]": (1, "5 MOD 0 does not exist"),
    "G0 X[1+2": (1, "']' is missing behind the expression"),
    "G0 X[1+]": (1, "a value is missing"),
    "G0 X[SIN 30]": (1, "'[' is missing behind SIN"),
    "G0 X[ATAN[1]]": (1, "'/' is missing behind ATAN"),
    "G0 X[2(c)+3]": (1, "a comment stands there"),
    "G0 X[EXISTS[1]]": (1, "EXISTS: it asks for a parameter"),
    "G0 X#<a": (1, "the name is not closed by '>'"),
    "#1=2+1": (1, "'+' begins no word"),
    "#1": (1, "'=' is missing behind the parameter"),
    "G[0.05] X1": (1, "G0.05 is no G code"),
    "M[3.5]": (1, "M is 3.5, which is no whole number"),
    "N[5] G0 X1": (1, "'n' begins no word"),
    "o1 foo": (1, "no keyword that LinuxCNC knows"),
    "o1 if 1": (1, "'[' is missing behind if"),
    "o1 if [1] X1": (1, "if is followed by more than a comment"),
    "o1 (c) if [1]": (1, "an O number is followed by more than a comment"),
    "o1.5 if [1]": (1, "an O number is 1.5"),
    "o1 while [0]\nX1": (1, "o1 while has no o1 endwhile behind this line"),
    "o1 if [0]\nX1": (1, "o1 if has no o1 endif"),
    "o100 sub\nG0 X1": (1, "o100 sub has no o100 endsub"),
    "o1 endwhile": (1, "endwhile: o1 is not open"),
    "o1 else": (1, "else: o1 is not open"),
    "o1 repeat [1]\no1 break\no1 endrepeat": (2, "break: o1 belongs to the repeat of line 1"),
    "o1 if [1]\no1 endif\no1 if [1]\no1 endif": (3, "o1 is used already, in line 1"),
    "o1 if [1]\no1 while [0]\no1 endwhile\no1 endif": (2, "o1 is used already"),
    "o100 return": (1, "return outside of any sub"),
    "o100 call": (1, "there is no sub o100 further down, and no file 100.ngc"),
    "o100 call 5\nM2\no100 sub\no100 endsub": (1, "call is followed by more than a comment"),
    "o1 call " + 31 * "[1]" + "\nM2\no1 sub\no1 endsub": (1, "more than 30 arguments"),
    "o100 call\no100 sub\no100 endsub": (2, "sub o100 is met again"),
    "o1 sub\no2 sub\no2 endsub\no1 endsub": (2, "o2 begins within the definition of sub o1"),
    "o1 sub\no1 endsub\no1 sub\no1 endsub": (3, "sub o1 is met again"),
    "o1 sub\nM99\no1 endsub\no1 call": (2, "m99 within sub o1"),
    "o1 sub\no1 endsub\nM98 P1": (1, "o1 is a sub"),
    "o1 call\nM2\nO1\nM99": (3, "o1 is a Fanuc-style program"),
    "M98 P5": (1, "there is no program O5 further down"),
    "M98 L2": (1, "M98 without P"),
    "G0 X1 M98 P5\nM2\nO5\nM99": (1, "M98 is not the first word"),
    "M98 P5\nM2\nO5\nM99 P1": (4, "m99 is followed by more than a comment"),
    "M98 P5 L1.5\nM2\nO5\nM99": (1, "L is 1.5"),
    "G0 X1\n(abort, no tool)\nX2": (2, "the program ends itself here: no tool"),
    "G41.1 D3\nG0 X#5420": (2, "while cutter radius compensation is on"),
    "G0 X[1]]": (1, "']' begins no word"),
    "G0 X[1.2.3]": (1, "a value is missing, or is none"),
    "o1 sub\no1 endsub [1\no1 call": (2, "']' is missing"),
}


def test_what_linuxcnc_refuses_is_refused():
    answers = by_oracle([(text + "\nM2\n", {}) for text in REFUSED_BY_BOTH])
    accepted = [
        text
        for text, answer in zip(REFUSED_BY_BOTH, answers, strict=True)
        if isinstance(answer, list)
    ]
    assert not accepted


@pytest.mark.parametrize("text", REFUSED_BY_BOTH)
def test_refusals_say_what_and_where(text):
    line, message = REFUSED_BY_BOTH[text]
    error = refused(text + "\nM2\n")
    assert message in error.message
    assert error.advice
    assert (error.place.file, error.place.line) == ("main.ngc", line)


def test_all_axes_of_the_oracle_are_read():
    assert AXES == ("X", "Y", "Z", "A", "B", "C")
