"""Every word of every cycle in docs/CYCLES.md: followed, so that another value moves the tool
elsewhere, or refused by name.

The table is read from the page; a program per row says which values are changed. What "followed"
means is judged on the plain lines, read by the interpreter: motions, dwells and how often, not
the text.
"""

from __future__ import annotations

import re
import string
from dataclasses import replace
from functools import cache
from typing import NamedTuple

import pytest

from postproc.errors import ProgramError
from postproc.nc import dialects
from postproc.nc.cycles.block import Block
from postproc.nc.cycles.words import GENERAL
from postproc.nc.expand import Line, Program
from postproc.nc.expand.resolve import Resolver
from postproc.nc.expand.tracker import Tracker
from postproc.nc.interpreter import Interpreter
from postproc.nc.state import Setup
from tests import cycles_doc
from tests.expand.plain_lines import LATHE, motions, needs_oracle, same_motions
from tests.linuxcnc import oracle
from tests.linuxcnc.test_against_linuxcnc import setup_for

MILL = replace(
    setup_for({}),
    start=dict.fromkeys("XYZABC", 0.0),
    offsets={**setup_for({}).offsets, "D1": {"R": 2.0}, "D2": {"R": 3.0}},
)
CODE = re.compile(r"`([a-z-]+)`")


class Sample(NamedTuple):
    """A block of a cycle: its words with a value and another one, what stands before and behind
    it, source lines that are not run (the subroutine of a shape), and a code in the block."""

    words: dict[str, tuple[str, str]]
    before: str = ""
    behind: str = ""
    aside: str = ""
    also: str = ""

    def run(self, name: str, code: str, change: str = "", add: str = "") -> list[Line]:
        """The plain lines, with the other value of `change` and with further words."""
        words = [x + self.words[x][x == change] for x in self.words]
        block = " ".join(w for w in [code, self.also, *words, add] if w)
        program = self.before.replace("|", "\n") + block + "\n" + self.behind.replace("|", "\n")
        aside = self.aside.replace("|", "\n")
        tracker = Tracker(Interpreter(dialects.load(name), setup(name)))
        tracker.program = SHAPES.get
        resolver = Resolver(Program("part", (aside + program).encode()), tracker)
        lines = enumerate(program.split("\n"), 1 + aside.count("\n"))
        return [plain for n, one in lines for plain in resolver.take(Line(one.encode(), n))]

    def only(self, letters: str) -> Sample:
        return self._replace(words={x: v for x, v in self.words.items() if x in letters})


WITH_Y = replace(LATHE, axes=("X", "Y", "Z", "C"), start=dict.fromkeys("XYZC", 0.0))


def setup(name: str) -> Setup:
    if name in ("haas-lathe", "okuma-lathe"):
        return WITH_Y
    return LATHE if "lathe" in name else MILL


def values(text: str) -> dict[str, tuple[str, str]]:
    """ "X1/2 Z3/4" as words with two values each."""
    return {w[0]: (w[1:].split("/")[0], w.split("/")[1]) for w in text.split()}


ZX, UW = "X80./78. Z-30./-31.", "U-20./-22. W-30./-31."
CONTOUR = "|N8 G0 X36.|N10 X40.|G1 Z-20.|N20 X100. Z-50.|N30 G1 X102. Z-51.|G0 X200."
FACE = "|N8 G0 Z-10.|N10 Z-9.|G1 X80.|N20 X60. Z1.|N30 G1 X58. Z1.5|G0 X200."
START = "G0 X100. Z2.|"
SUB = (
    "O100 SUB|G0 X2|G1 Z-4|X4 Z-6|X5 Z-7.5|X7|O100 ENDSUB|O101 SUB|G0 X3|G1 Z-4|X7 Z-8|O101 ENDSUB|"
)
TURN = "F100|S100 M3|G18 G0 X10 Z1|"
HOLE = "X5./6. Y4./3. Z-5./-6. R1./2."
BEGIN = "F100|S100 M3|G0 X0 Y0 Z9.|"
MORE = "|G83 X9.|G82 X8.|G80"
P, Q = "P10/8", "Q20/30"


FACING = (
    "O100 SUB|G0 Z-10|G1 X8|X6 Z-5|X4 Z-3|O100 ENDSUB|O101 SUB|G0 Z-9|G1 X8|X4 Z-3|O101 ENDSUB|"
)
POCKET = (
    "O100 SUB|G0 X4|G1 X6 Z-4|X3 Z-8|X6 Z-12|O100 ENDSUB|O101 SUB|G0 X3|G1 X5 Z-4|X3 Z-8|X7"
    " Z-12|O101 ENDSUB|"
)
THREAD = "X4/5 Z-10/-11 P1/1.5 I-.5/-.6 J.3/.4 K1/1.1 R1.5/2 Q20/25 H1/2 L3/2 E2/1"
START_POINT = "Q100/101 X10/11 Z1/2"
LINUXCNC_SAMPLES = {
    "G70": Sample(values(f"{START_POINT} D.4/.5 E.1/.2 P2/3"), TURN, aside=SUB),
    "G71": Sample(values(f"{START_POINT} D.1/.2 I2.5/2 R.3/.4"), TURN, aside=SUB),
    "G72": Sample(values(f"{START_POINT} D.1/.2 I.5/.7 R.3/.4"), TURN, aside=FACING),
    "G71.1": Sample(values(f"{START_POINT} D.1/.2 I2.5/2 R.3/.4"), TURN, aside=SUB),
    "G71.2": Sample(values(f"{START_POINT} D.1/.2 I.5/.4 R.3/.4"), TURN, aside=POCKET),
    "G72.1": Sample(values(f"{START_POINT} D.1/.2 I.5/.7 R.3/.4"), TURN, aside=FACING),
    "G76": Sample(values(THREAD), TURN),
}


def samples(name: str, code: str, way: str) -> list[Sample]:
    """The programs for a row of the table."""
    if name == "linuxcnc":
        return [LINUXCNC_SAMPLES.get(code, Sample(values(HOLE + " L2/3 P.5/.6 Q1.5/1"), BEGIN))]
    if name == "haas" and code == "G150":
        words = "P1/2 X5./6. Y9./8. Z-4./-3. R1./2. Q2./3. K.5/.6 D1/2 {}"
        start = "F100|G90 G17 G0 X0 Y0 Z9|"
        return [Sample(values(words.format(k)), start, also="G41") for k in ("I3./2.", "J3./2.")]
    if name == "haas" and code in ("G12", "G13"):
        pockets = ["I8./7. K15./14. Q4./3. D1/2 Z-2./-3.", "I8./7. D1/2 Z-2./-3. L2/3"]
        return [Sample(values(pockets[k]), "F100|G17 G0 X0 Y0 Z9|" + "G91 " * k) for k in (0, 1)]
    if name in ("fagor", "okuma"):
        one = "G90 G81 X0 Y0 Z-1 R1 M5{}|"
        before = one.format(4) if name == "okuma" and code != "G71" else ""
        behind = "|" + one.format(3) + "G80" if code == "G71" else ""
        return [Sample(values(OTHERS[name].get(code, OTHERS[name][""])), BEGIN + before, behind)]
    if name == "okuma-lathe" and code in ("G73", "G74"):
        step = "K1./1.5" if code == "G73" else "I2./3."
        words = f"X30./28. Z-5./-6. {step} D1./1.5 L2./3. E.5/.6 {{}}"
        return [Sample(values(words.format("")), "G0 X40. Z3.|G1 F.1|")]
    if name == "okuma-lathe":
        words = "X20./21. Y0./1. Z-5./-6. C30./40. Q2/3 E.5/.6 {}"
        return [
            Sample(values(words.format(k)), "G0 X40. Z3.|G1 F.1|") for k in ("K1./1.5", "I1./2.")
        ]
    if "lathe" not in name:
        peck = " I2./1.5 J.5/.4 K1./.9" if name == "haas" else ""
        both = [
            Sample(values(f"{HOLE} {how} P500/600 Q1.5/1."), BEGIN, MORE * (name != "haas"))
            for how in ("L2/3", "K2/3")
        ]
        return both[: 1 + (name != "haas")] + [
            Sample(values(f"{HOLE} L2/3 P500/600{peck}"), BEGIN)
        ] * bool(peck)
    if name == "haas-lathe" and (len(code) == 4 or code[1] == "8"):
        return haas_holes(code)
    kind = turning(name, code)
    if kind == "hole":
        deep = "Z" if code in ("G83", "G85") else "X"
        other = {"Z": "X20./21. Z-5./-6. R-1./-2.", "X": "Z-20./-21. X40./38. R-1./-2."}[deep]
        behind = f"|{'G83 X9.' if deep == 'Z' else 'G87 Z-9.'}|G80"
        first = [
            Sample(values(f"{other} P500/600 Q1500/1000 {how} C30./40."), START, behind)
            for how in ("K2/3", "L2/3")
        ]
        by = {
            "Z": "U-20./-21. W-5./-6. R-1./-2. H3./4.",
            "X": "W-20./-21. U-40./-38. R-1./-2. H3./4.",
        }[deep]
        return [*first, Sample(values(f"{by} P500/600 Q1500/1000"), START, behind)]
    if kind in ("turn", "face off"):
        taper = "I-1./-2." if kind == "turn" else "K-1./-2."
        fanuc = [] if name == "haas-lathe" else [Sample(values(f"{ZX} R-1./-2."), START)]
        return [
            Sample(values(f"{ZX} {taper}"), START),
            Sample(values(f"{UW} {taper}"), START),
            *fanuc,
        ]
    if kind in ("peck", "groove"):
        if way.startswith("first"):
            return [Sample(values("R1./2."), START, f"|{code} X80. Z-30. P4000 Q5000")]
        one = [Sample(values(f"{places} I4./3. K5./4. D0/1."), START) for places in (ZX, UW)]
        two = [Sample(values(f"{ZX} P4000/3000 Q5000/4000 R0/1."), START)]
        return one + two * (name != "haas-lathe")
    shape = FACE if kind == "face" else CONTOUR
    if kind == "finish":
        return [Sample(values(f"{P} {Q}"), START, shape)]
    first = {"rough": "U4./3. R1./.5", "face": "W4./3. R1./.5", "repeat": "U6./5. W3./2. R3/4"}[
        kind
    ]
    if way.startswith("first"):
        return [Sample(values(first), START, f"|{code} P10 Q20 U1. W.5" + shape)]
    alone = {"repeat": "I6./5. K3./2. D3/4"}.get(kind, "D4000/3000")
    return [Sample(values(f"{P} {Q} U1./2. W.5/.6 {alone}"), START, shape)]


SHAPES = {  # that G150 calls
    n: [f"G1 X0. Y{y}.".encode(), b"X-30.", b"Y-20.", b"X40.", f"Y{y}.".encode(), b"X0."]
    for n, y in ((1, 30), (2, 31))
}
OTHERS = {
    "fagor": {
        "": "X5./6. Y4./3. Z2./3. I-5./-6. K.5/.6",
        "G83": "X5./6. Y4./3. Z2./3. I-1.5/-1. J4/5",
    },
    "okuma": {
        "": f"{HOLE} P500/600",
        "G83": f"{HOLE} P500/600 Q1.5/1.",
        "G73": f"{HOLE} P500/600 I1.5/1. J3./4.5",
        "G71": "Z9./8.",
    },
}


def haas_holes(code: str) -> list[Sample]:
    """A hole of a Haas lathe, along X if its code is G241 and beyond."""
    where = "Z-20./-21. {}X40./38. R80./82." if len(code) == 4 else "X20./21. {}Z-5./-6. R1./1.5"
    by = where.replace("Z-20./-21.", "W-20./-21.").replace("X20./21.", "U-20./-21.")
    peck = ["Q1./1.5", "I2./1.5 J.5/.4 K1./.9"]
    return [
        Sample(values(f"{one.format(more)} P500/600 {q}"), START)
        for one, more in ((where, "Y1./2. C30./40. "), (by, "H3./4. "))
        for q in peck
    ]


def turning(name: str, code: str) -> str:
    """What a code of a lathe is."""
    names = {
        "G83": "hole",
        "G85": "hole",
        "G87": "hole",
        "G89": "hole",
        "G90": "turn",
        "G77": "turn",
        "G20": "turn",
    }
    names |= {"G94": "face off", "G79": "face off", "G24": "face off"}
    shapes = ["finish", "rough", "face", "repeat", "peck", "groove"]
    names |= {f"G{70 + k + 2 * name.endswith('-c')}": x for k, x in enumerate(shapes)}
    return names[code]


# -- the table -------------------------------------------------------------------------------------


class Row(NamedTuple):
    name: str
    code: str
    way: str
    followed: str
    kept: str
    known: str
    zero: str
    one: str


def table() -> list[Row]:
    """The rows of the page whose words are looked at, a cycle each."""
    page = cycles_doc.DOC.read_text().partition(cycles_doc.TITLE)[2]
    rows = []
    for line in re.findall(r"(?m)^\| `.*$", page):
        cells = [c.strip() for c in line.strip("|").split("|")]
        if cells[2] == cycles_doc.STAYS or cells[2].startswith("refused"):
            continue
        axes = "*axes*" in cells[2]
        kept, known = letters(cells[3]), "".join(re.findall(r"(?:^|; )([A-Z])", cells[4]))
        zero, one = ("".join(re.findall(rf"([A-Z]) \({n}\)", cells[4])) for n in (0, 1))
        for part in cells[0].split("; "):
            for name in CODE.findall(part):
                more = "" if not axes else "CUWH" if "lathe" in name else "ABC"
                rows += [
                    Row(name, code, cells[1], letters(cells[2]) + more, kept, known, zero, one)
                    for code in part.split()
                    if code[0] == "G"
                ]
    return rows


def letters(cell: str) -> str:
    """The letters of a cell: capitals that stand alone, before a meaning."""
    return "".join(re.sub(" ", "", m) for m in re.findall(r"(?:^|, )((?:[A-Z] )+)", cell))


ROWS = table()
IDS = [" ".join(r[:3]) for r in ROWS]


def what_it_does(lines: list[Line], name: str) -> list:
    """Ends of all motions, dwells and pitches, in their order."""
    dwells = [
        word for line in lines for word in re.findall(rb"G4 *[PKF][0-9.]+|K[0-9.]+", line.text)
    ]
    return [
        (m["kind"], [round(v, 6) for v in m["end"]]) for m in motions(lines, name, setup(name))
    ] + dwells


def strange(lines: list[Line], name: str) -> list[Line]:
    """Lines with other words than those of a plain motion."""
    found, more = [], ""
    for line in lines:
        block = Block.of(line.text, dialects.load(name).grammar)
        more = next(
            (
                {20: "IJKR", 30: "IJKR", 330: "K"}.get(c, "")
                for c in block.codes
                if c in (0, 10, 20, 30, 330)
            ),
            more,
        )
        also = "P" + dialects.load(name).dwell if 40 in block.codes else more
        also += "D" * (410 in block.codes)
        found += [line] * any(w.letter not in GENERAL + "XYZABCUVWH" + also for w in block.words)
    return found


def holding(row: Row, letter: str) -> list[Sample]:
    own = row.followed + row.kept + row.known
    return [s.only(own) for s in samples(*row[:3]) if letter in s.words]


def test_the_page_is_what_the_cycles_declare():
    page = cycles_doc.DOC.read_text()
    assert page == cycles_doc.page(page), "run: python -m tests.cycles_doc"


def test_the_table_has_every_cycle():
    said = {(r.name, r.code) for r in ROWS}
    declared = {
        (name, f"G{n / 10:g}")
        for row in cycles_doc.rows()
        if not row.form.stays and not row.form.never
        for name, numbers in row.codes.items()
        for n in numbers
    }
    assert said == declared and len(said) >= 55


@pytest.mark.parametrize("row", ROWS, ids=IDS)
def test_another_value_of_a_word_does_another_thing(row):
    every = samples(*row[:3])
    alone = every[0].only(row.followed + row.kept)
    every = [s.only(row.followed + row.kept + row.known) for s in every]

    @cache  # each with its own values once, not for every letter
    def does(sample: int, change: str = "") -> list:
        return what_it_does(every[sample].run(row.name, row.code, change), row.name)

    for letter in row.followed + row.kept:
        if letter in "ABC" and letter not in "".join(alone.words):
            one, other = (alone.run(row.name, row.code, add=letter + v) for v in ("30.", "40."))
            changed = [(what_it_does(one, row.name), what_it_does(other, row.name))]
        else:
            changed = [(does(k), does(k, letter)) for k, s in enumerate(every) if letter in s.words]
        assert changed, f"no program for {letter}"
        assert any(a != b for a, b in changed), letter


def programs(row: Row) -> dict[str, tuple[str, str]]:
    """LinuxCNC's programs of a row: letter changed ("": none) to the text, and the text without
    what is not reached."""
    [sample] = samples(*row[:3])
    sample, found = sample.only(row.followed), {}
    aside = sample.aside.replace("|", "\n")
    for change in ["", *sample.words]:
        words = " ".join(x + v[x == change] for x, v in sample.words.items())
        run = f"{sample.before}{row.code} {words}|M2|".replace("|", "\n")
        found[change] = aside + run, "\n" * aside.count("\n") + run
    return found


LINUXCNC = [row for row in ROWS if row.name == "linuxcnc"]


@needs_oracle()
@pytest.mark.parametrize("row", LINUXCNC, ids=[row.code for row in LINUXCNC])
def test_linuxcncs_own_interpreter_does_the_same_with_either_value_of_every_word(row):
    texts = programs(row)
    assert set(row.followed) == set(texts) - {""}
    results = oracle.motions_of_many([(text, {}) for text, _ in texts.values()])
    for (text, reached), theirs in zip(texts.values(), results, strict=True):
        same_motions(text, theirs, reached)


@pytest.mark.parametrize("row", ROWS, ids=IDS)
def test_what_comes_out_is_plain(row):
    for sample in samples(*row[:3]):
        before = (sample.before + sample.behind + sample.aside).split("|")
        lines = sample.only(row.followed + row.kept).run(row.name, row.code)
        assert not strange([x for x in lines if x.text.decode() not in before], row.name)


IDLE = {("haas-lathe", "G70"): "D"}  # says nothing there: tests/expand/test_turning_before.py


@pytest.mark.parametrize("row", ROWS, ids=IDS)
def test_every_other_letter_is_refused_by_its_name(row):
    [sample, *_] = samples(*row[:3])
    sample = sample.only(row.followed + row.kept)
    sample.run(row.name, row.code)
    for letter in sorted(
        set(string.ascii_uppercase) - set(GENERAL + row.followed + row.kept + IDLE.get(row[:2], ""))
    ):
        with pytest.raises(ProgramError) as caught:
            sample.run(row.name, row.code, add=f"{letter}1.5")
        # some letters make it the second block
        own = letter if not row.way.startswith("first") else "[A-Z]"
        said = (
            rf"{own}[0-9.]* in an? \w+ cycle \({re.escape(row.code)}\): |G\d+ without the number of"
            r" a block in [PQ]"
        )
        assert re.match(said, caught.value.message), caught.value.message
        assert (
            caught.value.advice
            and caught.value.place.line
            and caught.value.place.stop > caught.value.place.start
        )
        if letter in row.zero:
            sample.run(row.name, row.code, add=f"{letter}0")
        if letter in row.one:
            sample.run(row.name, row.code, add=f"{letter}1")


@pytest.mark.parametrize("row", ROWS, ids=IDS)
def test_a_word_that_stands_twice_is_refused(row):
    for letter in set(row.followed + row.kept):
        for sample in holding(row, letter)[:1]:
            with pytest.raises(ProgramError, match="named twice"):
                sample.only(row.followed + row.kept).run(row.name, row.code, add=letter + "1.")


STAYING = [(name, word) for name, words in cycles_doc.passed_on().items() for word in words]


@pytest.mark.parametrize(("name", "word"), STAYING)
def test_a_cycle_that_nobody_follows_stays_with_all_its_words(name, word):
    words = "(10,0,2,-5,,1)" if word[0] != "G" else " X50. Z-5. R2. P500 Q2. I1. K1. D1. L2 F.2"
    text = f"G0 X60. Z9.\n{word}{words}\n"
    resolver = Resolver(
        Program("part", text.encode()), Tracker(Interpreter(dialects.load(name), setup(name)))
    )
    lines = [
        plain.text.decode()
        for n, one in enumerate(text.split("\n"), 1)
        for plain in resolver.take(Line(one.encode(), n))
    ]
    assert lines == text.split("\n")


STAYS = [
    (name, n)
    for row in cycles_doc.rows()
    if row.form.stays
    for name, numbers in row.codes.items()
    for n in numbers
]


@pytest.mark.parametrize(("name", "number"), STAYS)
def test_a_cycle_that_stays_keeps_every_word(name, number):
    code = f"G{number / 10:g}"
    along = "X" if code == "G88" else "Z"
    words = (
        "X50. Z-5. F1.5 P011060 Q100 I1. K1. D1. J2."
        if number in (760, 780, 920, 210)
        else "X9. Z-5. R1. F2. J2. D1."
    )
    words = {"fagor": "X9. Z2. I-5. F2.", "okuma": words + " M54"}.get(name, words)
    [line] = [
        x
        for x in Sample({}, "S100 M3|G0 X60. Z9.|").run(name, f"{code} {words}")
        if code in x.text.decode()
    ]
    assert line.text.decode() == f"{code} {words}" and along in words


NEVER = [
    (name, n)
    for row in cycles_doc.rows()
    if row.form.never
    for name, numbers in row.codes.items()
    for n in numbers
]


@pytest.mark.parametrize(("name", "number"), NEVER)
def test_a_cycle_that_is_never_written_out_is_refused_by_its_name(name, number):
    with pytest.raises(ProgramError, match=f"^[^|]*G{number / 10:g} "):
        Sample({}, "F100|S100 M3|G0 X10 Z9|").run(
            name, f"G{number / 10:g} X1. Y1. Z-5. R2. Q100 P1"
        )
