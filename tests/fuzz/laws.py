"""The laws that every program, however odd, must keep.

`broken(case)` says in one line which law a case breaks, or "" where it keeps them all.
"""

from __future__ import annotations

import contextlib
import re
import signal
import sys
import traceback
import warnings
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from fuzz.cases import Case, filter_of
from postproc.commands.expansion import through
from postproc.errors import GcompError, ProgramError
from postproc.filter import OWN_OUTPUT, Filter
from postproc.motions import ENTRY, FREE
from postproc.nc.expand import Limits, Program
from postproc.nc.expand.written import Written
from postproc.nc.interpreter import Interpreter
from postproc.units import UM
from postproc.verify import Verifier

SECONDS = 10  # a case that takes longer hangs
LIMITS = Limits(steps=3000, depth=8)
MOST_PLAIN = 300_000  # bytes that an expansion may hand to the filter here
REPORT = "this is an error of gcomp"


class TookTooLong(BaseException):
    """No library catches this on its way."""


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
    thread that nothing led to, and one where an axis turns back, is said."""
    said = {notice.code for notice in verifier.filter.notices}
    if "unled" in said or ("turned" in said and verifier.in_thread):
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
