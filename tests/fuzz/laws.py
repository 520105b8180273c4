"""The laws that every program, however odd, must keep, and the machines they are tried on.

`broken(case)` says in one line which law a case breaks, or "" where it keeps them all.
"""

from __future__ import annotations

import contextlib
import random
import re
import signal
import sys
import tempfile
import traceback
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np

from postproc.commands.expansion import through
from postproc.compensate import Options
from postproc.errors import GcompError, ProgramError
from postproc.filter import OWN_OUTPUT, Filter, setup_of
from postproc.machine import places
from postproc.motions import ENTRY, FREE
from postproc.nc import dialects
from postproc.nc.expand import Limits, Program
from postproc.nc.expand.written import Written
from postproc.nc.interpreter import Interpreter
from postproc.units import UM
from postproc.verify import Verifier

SECONDS = 10  # a case that takes longer hangs
LIMITS = Limits(steps=3000, depth=8)
MOST_PLAIN = 300_000  # bytes that an expansion may hand to the filter here
MODES = ("mean", "step", "ramp", "off")
MAPS = ("zero", "one-way", "two-way")
LATHES = ("fanuc-lathe", "fanuc-lathe-a", "fanuc-lathe-c", "haas-lathe")
REPORT = "this is an error of gcomp"

WIDE = {
    "mill": {"X": (0.0, 200.0), "Y": (-60.0, 60.0), "Z": (-40.0, 40.0)},
    "lathe": {"X": (0.0, 170.0), "Z": (0.0, 500.0)},
}
OFFSETS = {
    **{f"G{n}": {"X": 5.0 * n - 270, "Z": 1.0} for n in range(54, 60)},
    "G59.1": {"X": 3.0},
    "G59.3": {},
    "G54.1 P1": {"X": 1.5, "Z": 2.0},
    "G54.1 P2": {},
    "G505": {"X": 2.0},
    "G110": {"X": 1.0},
    "H1": {"Z": 12.5},
    "H2": {"Z": -3.0},
    "T1": {"Z": 7.25},
    "T2": {"X": 1.0, "Z": 3.0},
    "D1": {"Z": 20.0},
    "D2": {},
    "T0101": {"X": 1.0, "Z": -2.0},
    "T0202": {},
    "G15 H1": {"X": 1.5, "Z": 2.0},
    "G15 H2": {},
    "G247 P1": {"X": 1.5, "Z": 2.0},
}


class TookTooLong(BaseException):
    """No library catches this on its way."""


@dataclass(frozen=True)
class Case:
    """A program with all that decides what becomes of it. cuts: where the batches end; stated:
    whether the offsets and the place before the program are known."""

    text: bytes
    dialect: str = "linuxcnc"
    map: str = "one-way"
    mode: str = "step"
    expand: bool = False
    delete: bool = False
    stated: bool = True
    clamp: bool = True
    cuts: tuple[int, ...] = ()

    def options(self) -> str:
        """All but the text, in one line that `case_of` reads."""
        return (
            f"dialect={self.dialect} map={self.map} mode={self.mode} expand={self.expand:d}"
            f" delete={self.delete:d} stated={self.stated:d} clamp={self.clamp:d}"
            f" cuts={','.join(map(str, self.cuts)) or '-'}"
        )


def case_of(text: bytes, options: str) -> Case:
    """The case that a line of options makes of a text."""
    found = dict(part.split("=", 1) for part in options.split() if "=" in part)
    case = Case(text, found.pop("dialect"), found.pop("map"), found.pop("mode"))
    cuts = found.pop("cuts", "-")
    flags = {name: value == "1" for name, value in found.items()}
    return replace(case, **flags, cuts=() if cuts == "-" else tuple(map(int, cuts.split(","))))


def random_case(rng: random.Random, text: bytes, dialect: str) -> Case:
    """A text under options of chance."""
    cuts = sorted(rng.randrange(len(text) + 1) for _ in range(rng.choice((1, 2, 5))))
    return Case(
        text,
        dialect,
        rng.choice(("zero", "one-way", "one-way", "two-way", "two-way", "two-way")),
        rng.choice((*MODES, "mean", "step")),
        rng.random() < 0.4,
        rng.random() < 0.2,
        rng.random() < 0.85,
        rng.random() < 0.8,
        tuple(cuts),
    )


# -- machines --------------------------------------------------------------------------------------

HEAD = """\
format  = "gcomp-machine/1"
name    = "{name}"
control = "linuxcnc"
chain   = "{chain}"
source  = "made up for the tests"
{diameter}
[limits]
max_correction = 0.5
max_slope = 0.005
{square}"""
SQUARE = {
    "mill": "[squareness]\nC0Y = 25.0\nA0Z = -15.0\nB0Z = 20.0\n",
    "lathe": "[squareness]\nB0X = -90.0\n",
}
AXIS = """
[axes.{axis}]
travel = [-3000.0, 3000.0]
least_increment = 0.0001
table  = "{axis}.csv"
measured_at = {{ {others} }}
"""


def _write(folder: Path, shape: str, kind: str) -> Path:
    """A machine with all errors of its slides, 10-20 um and urad, or with none; two-way: its place
    depends on direction."""
    folder.mkdir()
    ranges = WIDE[shape]
    chain, diameter = ("w-X-Y-b-Z-t", "") if shape == "mill" else ("w-b-Z-X-t", 'diameter = ["X"]')
    square = "" if kind == "zero" else SQUARE[shape]
    text = [HEAD.format(name=f"{shape}-{kind}", chain=chain, diameter=diameter, square=square)]
    for axis, (low, high) in ranges.items():
        nodes = np.linspace(low, high, 9)
        text.append(
            AXIS.format(axis=axis, others=", ".join(f"{o} = 0.0" for o in ranges if o != axis))
        )
        rng = np.random.default_rng(ord(axis))
        columns = {f"{axis}_mm": nodes}
        for kinds, unit in (("XYZ", "um"), ("ABC", "urad")):
            for direction in kinds:
                name, values = (
                    f"E{direction}{axis}_{unit}",
                    np.cumsum(rng.normal(0.0, 5.0, len(nodes))),
                )
                values = values * (kind != "zero")
                if kind == "two-way" and direction == axis:
                    columns |= {
                        name + "_rev": values + 2.0,
                        name + "_fwd": values - 2.0 - 0.5 * rng.random(len(nodes)),
                    }
                else:
                    columns[name] = values
        rows = [
            ",".join(columns),
            *(",".join(f"{v:.3f}" for v in row) for row in zip(*columns.values(), strict=True)),
        ]
        (folder / f"{axis}.csv").write_text("\n".join(rows) + "\n")
    (folder / "machine.toml").write_text("".join(text))
    return folder


@cache
def machine(shape: str, kind: str):
    """ "mill" or "lathe", of one of MAPS."""
    with tempfile.TemporaryDirectory() as folder:
        return places.load(str(_write(Path(folder) / f"{shape}-{kind}", shape, kind)))


@cache
def dialect(name: str):
    return dialects.load(name)


def filter_of(case: Case) -> Filter:
    """The filter that the case asks for."""
    shape = "lathe" if case.dialect in LATHES else "mill"
    spoken = dialect(case.dialect)
    built = machine(shape, case.map).carrying(spoken.carried)
    letters = set(built.letters)
    offsets = (
        {n: {x: v for x, v in place.items() if x in letters} for n, place in OFFSETS.items()}
        if case.stated
        else {}
    )
    start = dict.fromkeys(WIDE[shape], 0.0) if case.stated else {}
    setup = setup_of(built, offsets, start, case.delete)
    return Filter(
        built,
        spoken,
        setup,
        Options(None, "clamp" if case.clamp else "error", case.mode),
        name="program",
    )


# -- what comes out --------------------------------------------------------------------------------


class Watch(Verifier):
    """The Verifier, and which lines are motions that are never cut: what leads into or out of
    cutter radius compensation; and whether anything lies inside."""

    def __init__(self, filter_: Filter):
        super().__init__(filter_)
        self.filter = filter_
        self.whole: set[int] = set()
        self.beside = False

    def check(self, words, motions, pieces, output, first_line) -> None:
        lines = first_line + words.line[motions.block] + 1
        self.whole.update(lines[motions.cutter == ENTRY].tolist())
        self.beside |= bool((motions.cutter != FREE).any())
        super().check(words, motions, pieces, output, first_line)


def parts(text: bytes, cuts) -> list[bytes]:
    edges = [0, *sorted(min(at, len(text)) for at in cuts), len(text)]
    return [text[a:b] for a, b in zip(edges, edges[1:], strict=False)]


def outcome(filter_: Filter, fed: list[bytes]) -> tuple[bytes, str]:
    """What comes out, also before a refusal, and the refusal."""
    out = b""
    try:
        for part in fed:
            out += filter_.feed(part)
        return out + filter_.finish(), ""
    except ProgramError as error:
        return out + error.delivered, str(error)


def _written(case: Case, filter_: Filter) -> Written:
    interpreter = Interpreter(filter_.dialect, filter_.setup)
    return Written(Program("program", case.text), interpreter, LIMITS, filter_.compensator.keeps)


def expanded(case: Case) -> tuple[bytes, str, bool]:
    """The plain text of a program, the refusal, and whether it was cut short because it is long."""
    filter_ = filter_of(case)
    written = _written(case, filter_)
    plain = b""
    try:
        for portion in written:
            plain += portion
            if len(plain) > MOST_PLAIN:
                return plain, "", True
    except ProgramError as error:
        return plain, str(error), False
    return plain, "", False


@contextlib.contextmanager
def in_time(seconds: int = SECONDS) -> Iterator[None]:
    """Raises TookTooLong behind so many seconds of the processor, which a busy computer does not
    lengthen."""

    def ring(*_):
        raise TookTooLong

    before = signal.signal(signal.SIGPROF, ring)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


def broken(case: Case, seconds: int = SECONDS) -> str:
    """The law that the case breaks, "" if none."""
    try:
        with in_time(seconds), warnings.catch_warnings():
            # of numpy: a number that is none goes on unseen
            warnings.simplefilter("error", RuntimeWarning)
            return _broken(case)
    except TookTooLong:
        return f"hang: more than {seconds} s at {_where(sys.exc_info()[2])}"
    except GcompError as error:
        if REPORT in str(error):
            return f"own error: {error.message}"
        return f"not a ProgramError: {error.message}"
    except Exception as error:
        return f"crash: {type(error).__name__}: {str(error)[:100]} at {_where(error.__traceback__)}"


def _where(trace) -> str:
    inside = [f for f in traceback.extract_tb(trace) if "postproc" in f.filename]
    if not inside:
        return "the test"
    return " < ".join(f"{Path(f.filename).name}:{f.lineno}" for f in inside[-1:-4:-1])


def _broken(case: Case) -> str:
    if case.expand:
        return _broken_expanded(case)
    return _broken_plain(case)


def _broken_expanded(case: Case) -> str:
    plain, fault, long = expanded(case)
    if not long:
        filter_ = filter_of(case)
        verifier = Watch(filter_)
        written = _written(case, filter_)
        out, seen = b"", ""
        try:
            for data in through(filter_, written, lambda n: None):
                out += data
        except ProgramError as error:
            seen = str(error)
        if fault and not seen:
            return f"order: --expand refuses ({fault.splitlines()[0]}), and the whole does not"
        told = _verified(case, verifier)
        if told and not seen:
            return told
        if not seen and plain == case.text:
            if outcome(filter_of(case), [case.text]) != (out, ""):
                return "expand: other bytes than without --expand, where nothing was written out"
        if not seen and not fault:  # written out once more, nothing is left to write out
            again = replace(case, text=plain)
            twice, fault, _ = expanded(again)
            if fault:
                return f"twice expanded: refused: {fault.splitlines()[0]}"
            if twice != plain:
                return f"twice expanded: other bytes: {_difference(plain, twice)}"
    return _broken_plain(replace(case, text=plain, expand=False)) if plain else ""


def _broken_plain(case: Case) -> str:
    filter_ = filter_of(case)
    verifier = Watch(filter_)
    text = case.text
    out, fault = outcome(filter_, [text])
    if REPORT in fault:
        return f"own error: {fault.splitlines()[0]}"
    for cuts in (case.cuts, *_cuts(text, case.cuts)):
        other = outcome(filter_of(case), parts(text, cuts))
        if other != (out, fault):
            if other[0] != out:
                return f"batch: other bytes when cut at {cuts}: {_difference(out, other[0])}"
            return f"batch: another error when cut at {cuts}: {_line(fault)} / {_line(other[1])}"
    if filter_.machine.is_zero and (out != text if not fault else not text.startswith(out)):
        return f"zero map: bytes changed: {_difference(text, out)}"
    if fault:
        return ""
    told = _verified(case, verifier)
    if told:
        return told
    if out != text:
        _, again = outcome(filter_of(case), [out])
        if OWN_OUTPUT[0] not in again:
            return f"marker: the output is taken again: {_line(again)}"
    return ""


def _cuts(text: bytes, cuts) -> Iterator[list[int]]:
    """Line by line where the program is short, and cuts of chance."""
    if len(text) < 3000:
        yield [i + 1 for i, c in enumerate(text) if c == 10]
    if len(text) < 120:
        yield list(range(len(text)))


def _verified(case: Case, verifier: Watch) -> str:
    """Inside cutter radius compensation reversals are spread: there, only of maps that have none;
    blocks that lead into and out of it and threads are one piece, and bend as the map does; a
    thread that nothing led to is said."""
    if any(notice.code == "unled" for notice in verifier.filter.notices):
        return ""
    if verifier.corrected.line in verifier.whole or (verifier.beside and case.map == "two-way"):
        return ""
    if case.mode in ("mean", "step") and not verifier.passed:
        deviation = verifier.corrected.deviation / UM
        return f"verifier: {deviation:.2f} um left in line {verifier.corrected.line}"
    return ""


def _line(text: str) -> str:
    return text.splitlines()[0][:150] if text else "accepted"


def _difference(one: bytes, other: bytes) -> str:
    """The first lines that differ."""
    for a, b in zip(one.split(b"\n"), other.split(b"\n"), strict=False):
        if a != b:
            return f"{a[:80]!r} / {b[:80]!r}"
    return f"{len(one)} / {len(other)} bytes"


def kind(message: str) -> str:
    """What a message has in common with others of the same reason: for counting finds."""
    head, _, rest = message.partition(": ")
    if head in ("crash", "hang"):
        return message[:40] + message.rpartition(" at ")[2]
    if head == "own error":
        first, _, reason = rest.partition(": ")
        # each reason is a kind of its own
        rest = reason if first == "the output can not be followed" else first
    return head + ": " + "".join(c for c in rest[:60] if not c.isdigit())


# -- making a case small ---------------------------------------------------------------------------


def smallest(case: Case, tries: int = 600) -> Case:
    """The case with all taken out that is not needed to break the same law."""
    wanted = kind(broken(case)).split(":")[0]
    where = kind(broken(case)) if wanted in ("crash", "own error") else ""
    left = tries

    def still(other: Case) -> bool:
        nonlocal left
        left -= 1
        told = broken(other, 5 if wanted != "hang" else SECONDS)
        return kind(told) == where if where else kind(told).split(":")[0] == wanted

    for change in (
        {"expand": False},
        {"delete": False},
        {"mode": "mean"},
        {"mode": "step"},
        {"map": "one-way"},
        {"map": "zero"},
        {"clamp": True},
    ):
        other = replace(case, **change)
        if other != case and (change.get("map") != "zero" or case.map != "zero") and still(other):
            case = other
            if "mode" in change:
                break
    for pattern in (rb"[^\n]*\n|[^\n]+", rb"[A-Za-z#$<][^A-Za-z#$<\n]*|\n|.", rb"."):
        pieces = [m[0] for m in re.finditer(pattern, case.text, re.DOTALL)]
        size = max(1, len(pieces) // 2)
        while size and left > 0:
            at = 0
            while at < len(pieces) and left > 0:
                rest = pieces[:at] + pieces[at + size :]
                other = replace(case, text=b"".join(rest))
                if still(other):
                    case, pieces = other, rest
                else:
                    at += size
            size //= 2
    return case
