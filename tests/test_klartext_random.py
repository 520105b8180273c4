"""Random programs in Heidenhain Klartext, in place and written out: all are corrected and verified,
any cut of what is corrected in place gives the same bytes, and on a machine without errors no byte
changes. 1,200 of them were run so once; here are 40."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from postproc.commands.expansion import through
from postproc.filter import Filter, setup_of
from postproc.machine.file import read_machine
from postproc.nc import dialects
from postproc.nc.expand import Limits, Program
from postproc.nc.expand.written import Written
from postproc.nc.interpreter import Interpreter
from postproc.verify import Verifier
from tests.small_machines import write_mill

PERFECT = Path(__file__).resolve().parents[1] / "machines" / "perfect"
DIALECT = dialects.load("heidenhain")
OFFSETS = {"G54": {"X": 5.0}, "T1": {"Z": 1.0}, "T2": {"Z": 2.0, "R": 6.0}}
ENDS = ("", " R0", " R0 FMAX", " FMAX", " F500", " F AUTO", " FMAX M8", " F MAX M9")
BESIDE = (
    "; a remark|* - STEP|CYCL DEF 32.1 T0.01|M8|STOP|FN 0: Q5 = +3|L M140 MB MAX\nL Z+10 FMAX|"
    "L Z-5 R0 FMAX M91|TOOL CALL 2 Z DL+0.25\nL Z+3 FMAX|CYCL DEF 7.1 X-1.5|TRANS DATUM RESET"
).split("|")
HOLE = (
    " ~\n Q200=+2 ~\n Q201=-5 ~\n Q206=+90 ~\n Q202=+2 ~\n Q203=+1 ~\n Q204=+10\nL X+35.5 FMAX M99"
)
WRITTEN_OUT = (
    "CC IX+4.5 IY+0\nC DR+ F300",
    "CC IX+3 IY+0\nCP IPA+400 IZ-1 DR+",
    "CALL LBL 9",
    "CYCL DEF 200 DRILL" + HOLE,
    "CYCL DEF 207 TAP" + HOLE,
    "CC IX+4.5 IZ+0\nCP IPA-90 DR- F300",
    "CC IY+2 IZ+1\nCP IPA+200 IX+1 DR+ F300",
    "L X+60 Y+0 F300\nL IX+8\nRND R2.5\nL IY+9 M8\nCHF 1.5\nL IX-20 IY+3",
    "CYCL DEF 205 PECK ~\n Q257=+0.7 ~\n Q256=+0.2 ~\n Q258=+0.5" + HOLE,
    "L X+20 Y-3 F300\nL X+31 Y+2.5\nCT IX+7 IY-4\nCT IX+2 IY+9.5",
    "CYCL DEF 1.0 PECK\nCYCL DEF 1.1 2\nCYCL DEF 1.2 -5\nCYCL DEF 1.3 3\nCYCL DEF 1.5 F90\n"
    "L X+44 Z+12 FMAX M99\nL IX+3 FMAX M99",
    "CYCL DEF 200 DRILL" + HOLE + "\nCYCL DEF 221 GRID ~\n Q225=+50 ~\n Q226=+3 ~\n Q237=+5 ~\n"
    " Q238=+7 ~\n Q242=+2 ~\n Q243=+2 ~\n Q224=+11 ~\n Q200=+2 ~\n Q203=+0 ~\n Q204=+9",
    "TOOL CALL 2 Z\nL Z+20 FMAX M3\nCYCL DEF 208 BORE ~\n Q334=+2 ~\n Q335=+21 ~\n Q351=+1" + HOLE,
)


def straight(rng: random.Random) -> str:
    ranges = {"X": (10, 90), "Y": (-40, 40), "Z": (-30, 30)}
    words = [
        f"{axis}{rng.uniform(*limits):+.{rng.randint(0, 4)}f}"
        for axis, limits in ranges.items()
        if rng.random() < 0.6
    ]
    if rng.random() < 0.2:
        words = [f"I{rng.choice('XYZ')}{rng.uniform(-3, 3):+.3f}"]
    lead = rng.choice(["", "12 ", "13  ", "/ 14 "])
    return lead + "L " + "  ".join(words or ["X+50"]) + rng.choice(ENDS)


def program(rng: random.Random, written_out: bool) -> bytes:
    lines = ["BEGIN PGM A MM", "TOOL CALL 1 Z S100 F100", "L X+50 Y+0 Z+20 R0 FMAX M3"]
    for _ in range(rng.randint(3, 25)):
        kind = rng.random()
        if kind < 0.15:
            lines.append(rng.choice(BESIDE))
        elif kind < 0.4 and written_out:
            lines.append(rng.choice(WRITTEN_OUT))
        else:
            lines.append(straight(rng))
    lines += ["L Z+30 FMAX M30", "LBL 9", "L IX+0.5 F100", "LBL 0", "END PGM A MM", ""]
    return "\n".join(lines).encode()


@pytest.mark.parametrize("seed", range(40))
def test_random_programs(seed, tmp_path):
    rng = random.Random(seed)
    written_out, which = rng.random() < 0.5, rng.randrange(3)
    folder = PERFECT if which == 2 else write_mill(tmp_path / "mill", which == 1)
    machine, text = read_machine(folder), program(rng, written_out)

    def fresh() -> Filter:
        start = dict.fromkeys("XYZ", 0.0)
        return Filter(machine, DIALECT, setup_of(machine, offsets=OFFSETS, start=start))

    filter_ = fresh()
    verifier = Verifier(filter_)
    if written_out:
        compensator = filter_.compensator
        tracked = Interpreter(DIALECT, filter_.setup)
        written = Written(
            Program("a.h", text), tracked, Limits(), compensator.keeps, compensator.tolerance
        )
        verifier.source = written.source
        out = b"".join(through(filter_, written, lambda size: None))
        assert out
    else:
        out = filter_.feed(text) + filter_.finish()
        edges = [0, *sorted(rng.randrange(len(text)) for _ in range(5)), len(text)]
        again = fresh()
        parts = [again.feed(text[a:b]) for a, b in zip(edges, edges[1:], strict=False)]
        assert b"".join(parts) + again.finish() == out
        assert which != 2 or out == text
    assert verifier.passed, verifier.report()
