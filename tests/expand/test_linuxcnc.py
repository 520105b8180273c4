"""LinuxCNC programs written out: values by hand, programs against LinuxCNC's own interpreter,
refusals, limits, anything."""

from __future__ import annotations

import math
import random
import re
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from postproc.errors import ProgramError
from postproc.nc import dialects
from postproc.nc.expand import Limits, Program
from postproc.nc.expand.linuxcnc import lines
from postproc.nc.expand.tracker import Tracker
from postproc.nc.interpreter import Interpreter
from tests.linuxcnc import oracle
from tests.linuxcnc.test_against_linuxcnc import (
    AXES,
    CLOSE,
    full_turns,
    initial_state,
    ours,
    setup_for,
)

PROGRAMS = sorted((Path(__file__).parent / "linuxcnc").glob("*.ngc"))
LIMITS = Limits(steps=100_000, depth=20)


class Fine(Tracker):
    """Writes numbers so that a nanometre's thousandth can be told."""

    def decimals(self, letter: str) -> int:
        return 12


def run(text, kwargs=None, library=None, tracker=Tracker, limits=LIMITS, setup=None):
    """The lines, as the driver takes them."""
    kwargs = kwargs or {}
    follower = tracker(Interpreter(dialects.load("linuxcnc"), setup or setup_for(kwargs)))
    if setup is None:
        follower._state = initial_state(follower.state, kwargs)
    text = text.encode("latin-1") if isinstance(text, str) else text
    found = []
    for line in lines(Program("main.ngc", text, (library or {}).get), follower, limits):
        found.append(line)
        follower.take(line.text)
    return found


def texts(text, **more):
    return [line.text.decode("latin-1") for line in run(text, **more)]


def value(expression, before=""):
    """What an expression is, by what stands behind X."""
    [text] = texts(f"{before}\nX[{expression}]".lstrip("\n"), tracker=Fine)
    return float(text[1:])


def refused(text, **more):
    with pytest.raises(ProgramError) as caught:
        run(text, **more)
    return caught.value


# -- values and text, by hand ----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        ("2+3*4", 14),
        ("2**3**2", 64),
        ("-2**2", 4),
        ("7-2-3", 2),
        ("24/4/2", 3),
        ("1+1 EQ 2", 1),
        ("1 OR 0 AND 0", 0),
        ("-7 MOD 4", 1),
        ("7 MOD -4", 3),
        ("9+8*7/6+5-4*3**2+1", -35 / 3),
        ("SIN[30]", 0.5),
        ("COS[90] LT 0", 1),
        ("ATAN[1]/[-1]", 135),
        ("FIX[-2.5]", -3),
        ("FUP[-2.5]", -2),
        ("ROUND[2.5]", 3),
        ("ROUND[-2.5]", -3),
        ("FIX[SIN[30]*2]", 1),
        ("SQRT[2]", math.sqrt(2)),
        ("LN[EXP[1]]", 1),
        ("1 EQ 1.00009", 1),
        ("1 LE 0.99999", 0),
        ("--5", 5),
        ("-+-[3]", 3),
        ("2 - -3", 5),
        ("EXISTS[#<no>]", 0),
        ("EXISTS[#5602]", 0),
        ("#5599", 1),
        ("ABS[-.5]", 0.5),
    ],
)
def test_expressions(expression, expected):
    assert value(expression) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("G1 X[1+1] Y2 (a #1) ; [b", "G1 X2. Y2 (a #1) ; [b"),
        ("g 1 x [ 1 / 4 ] Y.50", "g 1 x 0.25 Y.50"),
        (
            "N10 G[0] M[3] T[2] S[500] F[1.5] H[1] D[2] P[3] L[4] X-[0]",
            "N10 G0 M3 T2 S500. F1.5 H1 D2 P3 L4 X0.",
        ),
        ("G[59.1] P[0.5] D[1.5] X[1/3]", "G59.1 P0.5 D1.5 X0.33333333"),
        ("#1=5 G0 X[1]", "G0 X1."),
        ("G0 X[1] #1=5", "G0 X1."),
        ("G0 #1=5 X[1] (c)", "G0 X1. (c)"),
        ("G0 X[1] #1=5 (c)", "G0 X1. (c)"),
        ("/N5 #1=5 X[1]", "/N5 X1."),
        ("X1#1=5Y[1]", "X1Y1."),
        ("G0 X--5 Y+-[2]", "G0 X5. Y-2."),
        ("#1=1 (msg, hello)", "(msg, hello)"),
        ("M#9 P[1]", "M0 P1"),
        ("(debug, #1 [2]) ;#3", "(debug, #1 [2]) ;#3"),
        ("G4 P[2.25]", "G4 P2.25"),
        ("X[1]\r", "X1."),
        ("G10 L2 P1 X5 ( kept  as is )", "G10 L2 P1 X5 ( kept  as is )"),
        ("", ""),
        ("\t", "\t"),
    ],
)
def test_text_that_is_no_expression_stays(line, expected):
    assert texts(line + "\nM2") == [expected, "M2"]


@pytest.mark.parametrize(
    "line", ["#1=5", "N10 #1=5 #<a>=2 (set)", "o1 if [1] (c)", "/#1=3 ; c", "o100 sub\no100 endsub"]
)
def test_lines_of_no_words_vanish(line):
    assert texts(line) == []


def test_lines_know_where_they_come_from():
    text = "%\nG0 X1\no<a> call [2]\no1 repeat [2]\nY1\no1 endrepeat\nM2\nX9\n%\n"
    found = run(text, library={"a": b"o<a> sub\n(in a)\nX#1\no<a> endsub\n"})
    assert [(line.source, line.file) for line in found] == [
        (1, ""), (2, ""), (2, "a.ngc"), (3, "a.ngc"), (5, ""), (5, ""), (7, ""), (9, ""),
    ]  # fmt: skip


def test_plain_programs_are_passed_on_unchanged():
    for path in sorted(oracle.PROGRAMS.glob("*.ngc")):
        text, kwargs = oracle.load(path)
        if re.search(r"#|\[|o\s*\d|o\s*<|m\s*(9[89]|7[0-3])", text, re.IGNORECASE):
            continue  # something to run
        all_lines = [
            line for line in text.replace("\r", "").rstrip("\n").split("\n") if line.strip() != "%"
        ]
        found = [line for line in texts(text, kwargs=kwargs) if line.strip() != "%"]
        assert found == all_lines[: len(found)], path.stem
        assert (
            len(found) == len(all_lines)
            or "%" in text
            or "M2" in found[-1].upper()
            or "M30" in found[-1].upper()
        ), path.stem


def test_skipped_lines_are_not_executed():
    kwargs = {"block_delete": True}
    assert texts("#1=1\n/#1=2\n/G0 X9 (c)\n/ X#1\n/M2\n/o1 if [0]\nX#1\n", kwargs=kwargs) == [
        "/#1=2", "/G0 X9 (c)", "/ X#1", "/M2", "/o1 if [0]", "X1.",
    ]  # fmt: skip
    assert texts("#1=1\n/#1=2\n/ X#1\n") == ["/ X2."]


def test_position_behind_the_tape_mark():
    assert texts("%\nG0 X5\nX[#5420+1]\n#1=#<_x>\nY#1\n%\n") == ["%", "G0 X5", "X6.", "Y6.", "%"]


def test_task_is_the_machine():
    """Programs ask #<_task> whether they run on the machine or are only shown; what is written out
    will run there."""
    assert value("#<_task>") == 1


def test_tool_offset_in_force():
    text = "X#<_tool_offset>\nT1 M6 G43\nX#<_tool_offset>\nG49\nX#<_tool_offset>"
    assert texts(text, kwargs={"tools": {1: {"Z": 5.0}}})[::2] == ["X0.", "X1.", "X0."]


def test_reference_points_that_are_stated():
    assert texts("X#5161 Y#5182 Z#5163", kwargs={"parameters": {5161: 7.0, 5182: 8.0}}) == [
        "X7. Y8. Z0."
    ]


def test_reach_of_a_written_number_is_the_least_increment_and_the_unit():
    assert texts("X[1/3] F[1/3]\nG20 X[1/3]\nX[1/3]\nG21\nX[1/3]") == [
        "X0.33333333 F0.333333", "G20 X0.33333333", "X0.333333333", "G21", "X0.33333333",
    ]  # fmt: skip


# -- against LinuxCNC ------------------------------------------------------------------------------


def by_oracle(programs):
    """What LinuxCNC makes of programs (text, keywords)."""
    reason = oracle.available()
    if reason:
        pytest.skip(reason)
    return oracle.motions_of_many(programs)


def check(text, kwargs, expected):
    """The motions of the program as written out are those of the original in LinuxCNC."""
    assert isinstance(expected, list), expected
    plain = (
        "\n".join(line.text.decode("latin-1") for line in run(text, kwargs, tracker=Fine)) + "\n"
    )
    mine = ours(plain, kwargs)
    expected = [
        m
        for m in expected
        if m.kind != "dwell"
        and (
            m.kind == "arc" or max(abs(a - b) for a, b in zip(m.start, m.end, strict=True)) > CLOSE
        )
    ]
    assert [m["kind"] for m in mine] == [m.kind for m in expected], plain
    for a, b in zip(mine, expected, strict=True):
        assert not a["reason"][0], (a, plain)
        for axis in range(6):
            assert a["end"][axis] == pytest.approx(b.end[axis], abs=CLOSE), (a, b, plain)
        if b.kind == "arc":
            assert a["centre"] == pytest.approx(b.centre, abs=CLOSE), (a, b)
            assert full_turns(a["sweep"]) == abs(b.turns), (a, b)


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


def test_name_with_a_folder():
    assert texts("o<cycles/a> call [3]\n", library={"a": b"o<a> sub\nX#1\no<a> endsub\n"}) == [
        "X3."
    ]


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


# Programs drawn by chance: blocks within blocks, loops that count, calls, jumps; all of it is
# defined in LinuxCNC.


class Chance:
    """Draws a program."""

    LABELS = ("{}", "<l{}>", "[{}]", "<L {}>", "{}.")
    MOVES = (
        "#32",
        "#33",
        "#1",
        "#2",
        "[#32*2]",
        "[#33-#1]",
        "#<a>",
        "#<_g>",
        "7",
        "[#5420+1]",
        "[#<_y>-2]",
        "-#2",
    )
    TESTS = (
        "#32 MOD 2 EQ 0",
        "#33 GT 3",
        "#1 LT 2",
        "#<a> GE 1 AND #32 LT 6",
        "#2",
        "1",
        "0",
        "#<_value_returned>",
    )
    SETS = (
        "#32=[#32+1]",
        "#33=[#32*2-#33 MOD 7]",
        "#<a>=[#<a>+1]",
        "#<_g>=[#<_g>-#<a>] #<a>=#<_g>",
        "#1=[#1+1]",
        "#2=[#1-#2]",
        "#[30+2]=[#33 MOD 5]",
        "#<a>=[#<a> MOD 11] #33=[#33 MOD 13]",
        "#32=[#32 MOD 9]",
        "#<_g>=[#<_g> MOD 17]",
    )

    def __init__(self, seed):
        self.draw, self.lines, self.subs, self.count = random.Random(seed), [], [], 0

    def program(self):
        self.lines += ["G0 X0 Y0 Z0", "#32=1 #33=2 #1=3", "#<a>=0 #<_g>=5"]
        behind = []
        for name in self.draw.sample(["500", "<first>", "501"], self.draw.randint(0, 3)):
            before, self.lines = self.lines, [f"o{name} sub", "#<a>=#1"]
            self.block(1, [], name)
            self.lines.append(f"o{name} endsub{self.draw.choice([' [#2+1]', '', ' [#<a>]'])}")
            body, self.lines = self.lines, before
            (behind if self.draw.random() < 0.4 else self.lines).extend(body)
            self.subs.append(name)
        self.block(0, [], "")
        self.lines += [f"o{name} call [1] [2]" for name in self.subs[:2]]
        self.block(0, [], "")
        return "\n".join([*self.lines, "M2", *behind]) + "\n"

    def label(self):
        self.count += 1
        return self.draw.choice(self.LABELS).format(self.count)

    def block(self, depth, loops, sub):
        for _ in range(self.draw.randint(1, 4)):
            kinds = [self.move, self.move, self.set]
            if depth < 4:
                kinds += [
                    self.branch,
                    self.loop,
                    self.loop,
                    self.repeat,
                    self.jump,
                    self.back,
                    self.call,
                ]
            self.draw.choice(kinds)(depth, loops, sub)

    def move(self, depth, loops, sub):
        words = [
            a + self.draw.choice(self.MOVES)
            for a in self.draw.sample("XYZ", self.draw.randint(1, 3))
        ]
        before = self.draw.choice(["", "", "N10 ", "G0 ", "G1 F100 ", "G91 ", "G90 ", "/"])
        self.lines.append(
            before
            + " ".join(words)
            + self.draw.choice(["", "", " (c #9)", " ; x", " #33=[#33 MOD 7+1]"])
        )

    def set(self, depth, loops, sub):
        self.lines.append(self.draw.choice(self.SETS))

    def test(self):
        return self.draw.choice(self.TESTS)

    def branch(self, depth, loops, sub):
        label = self.label()
        self.lines.append(f"o{label} if [{self.test()}]")
        self.block(depth + 1, loops, sub)
        for _ in range(self.draw.choice([0, 0, 1, 2])):
            self.lines.append(f"o{label} elseif [{self.test()}]")
            self.block(depth + 1, loops, sub)
        if self.draw.random() < 0.5:
            self.lines.append(f"o{label} else")
            self.block(depth + 1, loops, sub)
        self.lines.append(f"o{label} endif")

    def loop(self, depth, loops, sub):
        label = self.label()
        counter, most, do = (
            f"#{100 + self.count}",
            self.draw.randint(0, 4),
            self.draw.random() < 0.5,
        )
        test = f"o{label} while [{counter} LT {most}]"
        self.lines += [f"{counter}=0", f"o{label} do" if do else test, f"{counter}=[{counter}+1]"]
        self.block(depth + 1, [*loops, label], sub)
        self.lines.append(test if do else f"o{label} endwhile")

    def repeat(self, depth, loops, sub):
        label = self.label()
        self.lines.append(
            f"o{label} repeat [{self.draw.choice(['2', '#32 MOD 3', '1.5', '0', '3'])}]"
        )
        self.block(depth + 1, loops, sub)
        self.lines.append(f"o{label} endrepeat")

    def jump(self, depth, loops, sub):
        if loops:
            self.within(f"o{self.draw.choice(loops)} {self.draw.choice(['break', 'continue'])}")

    def back(self, depth, loops, sub):
        if sub:
            self.within(f"o{sub} return{self.draw.choice(['', ' [#1+#32]'])}")

    def within(self, line):
        label = self.label()
        self.lines += [f"o{label} if [{self.test()}]", line, f"o{label} endif"]

    def call(self, depth, loops, sub):
        earlier = self.subs[: self.subs.index(sub)] if sub in self.subs else self.subs
        if earlier:
            values = [
                f"[{v}]"
                for v in self.draw.choices(
                    ["#1", "#32", "3", "#<a>", "#33-1"], k=self.draw.randint(0, 3)
                )
            ]
            self.lines.append(f"o{self.draw.choice(earlier)} call {' '.join(values)}")
            self.lines.append("#33=[#<_value>+#<_value_returned>]")


def test_programs_drawn_by_chance():
    programs = [(text, {}) for text in (Chance(seed).program() for seed in range(80)) if ends(text)]
    assert len(programs) >= 70
    for (text, kwargs), expected in zip(programs, by_oracle(programs), strict=True):
        check(text, kwargs, expected)


def ends(text):
    """Whether a program comes to its end, and not beyond a kilometre; LinuxCNC would be waited for
    in vain."""
    try:
        run(text, limits=Limits(steps=2000, depth=20))
    except ProgramError as error:
        assert "lines were executed" in error.message or "beyond 1e+06 mm" in error.message, error
        return False
    return True


def drawn_expression(draw, depth=0):
    if depth > 1 or draw.random() < 0.2:
        return draw.choice(
            [f"{draw.uniform(-9, 9):.3f}", str(draw.randint(0, 12)), "#1", "#2", "#<a>"]
        )
    inner = lambda: drawn_expression(draw, depth + 1)
    function = draw.choice(["SIN", "COS", "ABS", "FIX", "FUP", "ROUND", "", "", "", "-"])
    if draw.random() < 0.1:
        return f"ATAN[{inner()}]/[{inner()}]"
    signs = draw.choices(
        ["+", "-", "*", " EQ ", " NE ", " GT ", " LT ", " GE ", " LE ", " AND ", " OR ", " XOR "],
        k=2,
    )
    return f"{function}[{inner()}{signs[0]}{inner()}{signs[1]}{inner()} MOD {draw.randint(2, 9)}]"


def test_expressions_drawn_by_chance():
    draw = random.Random(1)
    drawn = [e for e in (drawn_expression(draw) for _ in range(600)) if len(e) < 200]
    assert len(drawn) > 300
    moves = [f"X[[{expression}] MOD 1000]" for expression in drawn]
    text = "\n".join(["#1=1.25 #2=-3 #<a>=7", "G0 X5000", *moves, "M2"])
    [expected] = by_oracle([(text, {})])
    assert isinstance(expected, list), expected
    found = [float(line[1:]) for line in texts(text, tracker=Fine)[1:-1]]
    assert found == pytest.approx([m.end[0] for m in expected][1:], abs=CLOSE)


# -- what LinuxCNC has and gcomp refuses -----------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("X#5061", "#5061 is known to the machine only"),
        ("X#5070", "known to the machine only"),
        ("X#5399", "known to the machine only"),
        ("X#5410", "known to the machine only"),
        ("X#5600", "known to the machine only"),
        ("X#<_hal[pin]>", "#<_hal[pin]> is known to the machine only"),
        ("X#<_ini[axis_x]home>", "known to the machine only"),
        ("X[EXISTS[#<_hal[pin]>]]", "known to the machine only"),
        ("X#<_rpm>", "known to the machine only"),
        ("X#<_vmajor>", "known to the machine only"),
        ("X#5210", "#5210 is not known"),
        ("F100\nG20 X#<_feed>\nX#<_feed>", "#<_feed> is not known"),
        ("#5221=1", "#5221 belongs to the control"),
        ("#5211=1", "#5211 belongs to the control"),
        ("#5161=1", "#5161 belongs to the control"),
        ("#5399=1", "#5399 belongs to the control"),
        ("#<_hal[pin]>=1", "can be read only"),
        ("M61 Q2\nX#5400", "M61 has changed the tool"),
        ("G28.1\nX#5161", "G28.1 has changed it"),
        ("G10 L2 P1 R30\nX#5420", "G10 R has turned coordinates"),
        ("G0 Z3\nG81 Z-1 R2 F100\nG0 Z5\nX#<_motion_mode>", "cycles are written out"),
        ("G0 X1\nG38.2 X5 F10\nX#5420", "#5420 is not known"),
        ("(py, x=1)", "runs Python"),
        (";py,x=1", "runs Python"),
        ("(PYRUN,x=1)\nM2", "runs Python"),
        ("M99", "M99 in the main program"),
        ("G0 X1\nM99\nM2", "M99 in the main program"),
        ("M98 P5 X1\nM2\nO5\nM99", "followed by more than P and L"),
        ("o1 do\no1 while [0]\no1 do\no1 while [0]", "o1 is used already, in line 1"),
        ("X[TAN[90]]", "X would be -3.98679763e+19"),
        ("X[ROUND[3000000000]]", "ROUND of 3000000000"),
        ("X[1e30]", "']' is missing"),
        ("X[" + 400 * "9" + "]", "a number of 400 digits"),
        ("o1 repeat [9999999999]\no1 endrepeat", "a repeat count of 9999999999"),
        ("o1 while [1]\no1 endwhile", "more than 100,000 lines were executed"),
        ("o1 sub\no1 call\no1 endsub\no1 call", "calls nest deeper than 20"),
        ("X" + 50 * "[" + "1" + 50 * "]", "more than 40 brackets"),
        ("X" + 50 * "-" + "#1", "more than 40 brackets"),
        ("%\no1 if [0]\n%\n", "o1 if has no o1 endif"),
        ("G0 X1 (c\nX[1] (c", "a comment is opened and not closed"),
        ("o<a", "the name is not closed by '>'"),
        ("o1 sub\no1 endsub [1/0]\nX#<_value>", "#<_value> is not known"),
    ],
)
def test_refused(text, message):
    error = refused(text)
    assert message in error.message
    assert error.advice


def test_position_that_nobody_knows():
    setup = replace(setup_for({}), start={})
    assert "#5420 is not known" in refused("Y1\nX#5420", setup=setup).message
    assert texts("G0 X3\nX[#5420+1]", setup=setup) == ["G0 X3", "X4."]
    nothing = replace(setup_for({}), offsets={})
    for what in (
        "#5161",
        "#5185",
        "#5221",
        "#5400",
        "#5403",
        "#<_current_tool>",
        "#<_selected_tool>",
        "#<_coord_system>",
    ):
        assert f"{what} is not known" in refused(f"X{what}", setup=nothing).message


def test_files_without_their_end():
    for library, message in (
        ({"a": b"o<a> sub\nX1\n"}, "the file ends within sub o<a>"),
        ({"a": b"X1\n"}, "there is no sub o<a> in a.ngc"),
        ({"a": b""}, "there is no sub o<a> in a.ngc"),
        ({"a": b"%\no<a> sub\nX1\n%\n"}, "'%' within sub o<a>"),
        ({"a": b"o<a> sub\no<b> sub\n"}, "sub o<b> begins within sub o<a>"),
    ):
        assert message in refused("o<a> call\n", library=library).message
    assert "the file ends within sub o5" in refused("M98 P5\nM2\nO5\n").message


def test_fault_in_a_file_names_the_file():
    error = refused("o<a> call\n", library={"a": b"o<a> sub\n\nX#<n>\n"})
    assert (error.place.file, error.place.line, error.place.start, error.place.stop) == (
        "a.ngc",
        3,
        2,
        6,
    )


def test_a_line_that_can_not_be_followed_is_told_where_it_matters():
    assert "because of a line before" in refused("G0 X1 X2\nX#5420").message


def test_length_alone_is_no_fault():
    assert len(run("X1\n" * 3000, limits=Limits(steps=10, depth=5))) == 3000


# -- anything --------------------------------------------------------------------------------------

SEEDS = [path.read_bytes() for path in PROGRAMS]
PIECES = [
    b"#",
    b"[",
    b"]",
    b"<",
    b">",
    b"=",
    b"o1",
    b"o1 if [",
    b"endif",
    b"\n",
    b"(",
    b")",
    b";",
    b"%",
    b"/",
    b"-",
    b"**",
    b"M98 P",
    b"M99",
    b"M2",
    b"sub",
    b"endsub",
    b"call",
    b"\xff",
    b"\x00",
    b"9" * 30,
    b"1e9",
    b"EXISTS[",
    b"ATAN[",
    b".",
]


@settings(max_examples=300, deadline=None)
@given(
    st.sampled_from(SEEDS),
    st.lists(
        st.tuples(
            st.integers(0, 2000),
            st.integers(0, 12),
            st.sampled_from(PIECES) | st.binary(max_size=3),
        ),
        max_size=4,
    ),
)
def test_whatever_the_text_it_ends_in_lines_or_a_fault(text, changes):
    for at, gone, piece in changes:
        at %= len(text) + 1
        text = text[:at] + piece + text[at + gone :]
    try:
        run(text, library={"a": text, "5": text}, limits=Limits(steps=2000, depth=5))
    except ProgramError as error:
        assert error.message and error.advice and error.place.line >= 1


@settings(max_examples=300, deadline=None)
@given(
    st.lists(
        st.sampled_from(PIECES)
        | st.binary(max_size=2)
        | st.sampled_from([b" ", b"1", b"X", b"G1"]),
        max_size=30,
    )
)
def test_pieces_in_any_order(pieces):
    try:
        run(b"".join(pieces), limits=Limits(steps=200, depth=5))
    except ProgramError as error:
        assert error.message and error.advice


def test_all_axes_of_the_oracle_are_read():
    assert AXES == ("X", "Y", "Z", "A", "B", "C")
