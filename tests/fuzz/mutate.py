"""A fuzzer of bytes: programs from everywhere, changed a little, kept where they reach lines of the
source that none before reached. `run` does so many cases, or so many seconds; as a program: python
-m fuzz.mutate SECONDS [SEED].
"""

from __future__ import annotations

import random
import re
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from types import FrameType

from fuzz import grammar, laws
from fuzz.cases import Case, random_case
from fuzz.words import EXTREMES

ROOT = Path(__file__).resolve().parents[2]
CORPUS = ROOT.parent / "shared" / "corpus"
FOLDERS = {  # folder: dialects that its programs are tried in first
    ROOT / "sample_programs": ("fanuc-lathe", "linuxcnc", "fanuc-mill"),
    ROOT / "tests" / "linuxcnc" / "programs": ("linuxcnc", "grblhal", "fluidnc"),
    ROOT / "tests" / "linuxcnc" / "programs_new": ("linuxcnc", "grblhal", "fluidnc"),
    ROOT / "tests" / "linuxcnc" / "refused": ("linuxcnc", "grbl"),
    ROOT / "tests" / "linuxcnc" / "refused_new": ("linuxcnc", "grblhal"),
    CORPUS / "fanuc": ("fanuc-mill", "haas", "fanuc-lathe"),
    CORPUS / "mixed": ("fanuc-mill", "linuxcnc", "marlin"),
    CORPUS / "sinumerik": ("siemens",),
}
LONGEST = 1500  # bytes of a seed: more is cut off, so that many are tried
WORDS = (
    "G0 G1 G2 G3 G4 G9 G10 G17 G18 G19 G20 G21 G28 G33 G40 G41 G42 G43 G43.1 G49 G52 G53 G54 G54.1"
    " G55 G61 G64 G68 G69 G80 G81 G83 G84 G90 G91 G92 G92.1 G93 G94 G95 G98 G99 M0 M2 M3 M6 M30 M98"
    " M99 M117 M82 M83 M110 T1 D1 H1 P1 L2 K0 R5 Q1 E1 I0 J5 X=IC( AC( CR= TURN= TRANS ATRANS ROT"
    ' RPL= DIAMON DIAMOF SUPA MCALL CYCLE81( MSG(" FOR WHILE ENDFOR ENDWHILE IF ENDIF ELSE GOTOF'
    " GOTOB GOTO LOOP ENDLOOP REPEAT UNTIL DEF PROC $AA_IW[X] O100 o100 sub endsub call while"
    " endwhile repeat #1 #1= #<a> #5421 [ ] [#1+1] SIN[ DO1 END1 GOTO10 THEN G65 ( ) ; % / * *71 ,"
    ' = \n \r\n \t N10 : :1 U1 W-1 V2 A5 F100 S1 E-1 " { } < > \x80 \0'
).split(" ")
NUMBER = re.compile(rb"[-+]?[0-9]+\.?[0-9]*|[-+]?\.[0-9]+")
TOKEN = re.compile(rb"[A-Za-z#$<_]*[=( ]*[-+]?[0-9.]*[ \t]*|.", re.DOTALL)


@dataclass
class Found:
    """A broken law: the case that breaks it, and how often it was met."""

    case: Case
    told: str
    times: int = 1


@dataclass
class Fuzzer:
    """One run: what it was started with, and what it has seen. `guided`: keep cases that reach new
    lines of the source."""

    rng: random.Random
    guided: bool = True
    pool: list[Case] = field(default_factory=list)
    lines: set[tuple[str, int]] = field(default_factory=set)
    found: dict[str, Found] = field(default_factory=dict)
    cases: int = 0

    def start(self) -> None:
        """Seeds: real programs, and one of the generator for each dialect."""
        for text, name in seeds():
            self.pool.append(random_case(self.rng, text, name))

    def step(self) -> None:
        """One case: an old one changed, or at times a new one."""
        rng = self.rng
        if rng.random() < 0.15 or not self.pool:
            name = rng.choice(grammar.every())
            text = grammar.program(
                rng, name, rng.choice((3, 6, 12, 20)), rng.choice((0.0, 0.02, 0.1))
            )
        else:
            base = rng.choice(self.pool)
            name = base.dialect if rng.random() < 0.85 else rng.choice(grammar.every())
            other = rng.choice(self.pool).text
            text = changed(rng, base.text, other)
        self.attempt(random_case(rng, text[: 2 * LONGEST], name))

    def attempt(self, case: Case) -> None:
        self.cases += 1
        before = len(self.lines)
        if self.guided:
            sys.settrace(self._trace)
        try:
            told = laws.broken(case)
        finally:
            sys.settrace(None)
        if told:
            name = laws.kind(told)
            if name in self.found:
                self.found[name].times += 1
                if len(case.text) < len(self.found[name].case.text):
                    self.found[name].case, self.found[name].told = case, told
            else:
                self.found[name] = Found(case, told)
        elif len(self.lines) > before:
            self.pool.append(case)

    def _trace(self, frame: FrameType, event: str, arg):
        """Notes lines of the package; a function whose lines are all known is passed by."""
        file = frame.f_code.co_filename
        if "postproc" not in file:
            return None
        lines = self.lines
        lines.add((file, frame.f_lineno))

        def inside(frame: FrameType, event: str, arg):
            if event == "line":
                lines.add((file, frame.f_lineno))
            return inside

        return inside


def run(seed: int, cases: int = 0, seconds: float = 0.0, guided: bool = True) -> Fuzzer:
    """So many cases, or for so long; the same seed and number of cases do the same."""
    fuzzer = Fuzzer(random.Random(seed), guided)
    fuzzer.start()
    stop = time.monotonic() + seconds
    while fuzzer.cases < cases if cases else time.monotonic() < stop:
        fuzzer.step()
    return fuzzer


def seeds() -> Iterator[tuple[bytes, str]]:
    """Programs with a dialect that they are written in."""
    for folder, names in FOLDERS.items():
        if not folder.is_dir():
            continue
        for i, path in enumerate(
            sorted(p for p in folder.rglob("*") if p.is_file() and p.suffix.lower() in ENDINGS)
        ):
            yield path.read_bytes()[:LONGEST], names[i % len(names)]
    for k, name in enumerate(grammar.every()):
        yield grammar.program(random.Random(k), name, 15, 0.0), name


ENDINGS = (".nc", ".ngc", ".mpf", ".spf", ".gcode", ".tap", ".cnc", ".h", ".arc")


def changed(rng: random.Random, text: bytes, other: bytes) -> bytes:
    """The text after one change, or a few."""
    # a window of lines: short programs come further in a second
    if len(text) > 200 and rng.random() < 0.5:
        lines = text.split(b"\n")
        first = rng.randrange(len(lines))
        text = b"\n".join(lines[first : first + rng.randint(2, 15)])
    for _ in range(rng.choice((1, 1, 2, 3, 6))):
        text = rng.choice(OPERATORS)(rng, text, other)
    return text


def _flip(rng, text, other):
    if not text:
        return b"G1"
    at = rng.randrange(len(text))
    return text[:at] + bytes([text[at] ^ (1 << rng.randrange(8))]) + text[at + 1 :]


def _any_byte(rng, text, other):
    at = rng.randint(0, len(text))
    return text[:at] + bytes([rng.randrange(256)]) + text[at + rng.randint(0, 1) :]


def _splice(rng, text, other):
    a, b = text.split(b"\n"), other.split(b"\n")
    first = rng.randrange(len(b))
    at = rng.randint(0, len(a))
    return b"\n".join(a[:at] + b[first : first + rng.randint(1, 6)] + a[at:])


def _tokens(text: bytes) -> list[bytes]:
    return [m[0] for m in TOKEN.finditer(text) if m[0]]


def _delete(rng, text, other):
    pieces = _tokens(text)
    at = rng.randint(0, len(pieces))
    return b"".join(pieces[:at] + pieces[at + rng.choice((1, 1, 1, 2, 5)) :])


def _double(rng, text, other):
    pieces = _tokens(text)
    at = rng.randint(0, len(pieces))
    return b"".join(pieces[:at] + pieces[at : at + rng.choice((1, 1, 3))] * 2 + pieces[at:])


def _swap(rng, text, other):
    pieces = _tokens(text)
    if len(pieces) < 2:
        return text
    i, j = rng.randrange(len(pieces)), rng.randrange(len(pieces))
    pieces[i], pieces[j] = pieces[j], pieces[i]
    return b"".join(pieces)


def _lines(rng, text, other):
    """Lines in another order."""
    lines = text.split(b"\n")
    i, j = rng.randrange(len(lines)), rng.randrange(len(lines))
    if rng.random() < 0.5:
        lines[i], lines[j] = lines[j], lines[i]
    else:
        lines.insert(i, lines[j])
    return b"\n".join(lines)


def _number(rng, text, other):
    """A number becomes an extreme one, or one from elsewhere."""
    found = list(NUMBER.finditer(text))
    if not found:
        return text + b"X5"
    match = rng.choice(found)
    if rng.random() < 0.6:
        new = rng.choice(EXTREMES).encode()
    elif rng.random() < 0.5:
        new = b"%.*f" % (rng.randint(0, 6), rng.uniform(-60, 200))
    else:
        new = rng.choice(found)[0]
    return text[: match.start()] + new + text[match.end() :]


def _insert(rng, text, other):
    pieces = _tokens(text)
    pieces.insert(
        rng.randint(0, len(pieces)),
        rng.choice(WORDS).encode("latin-1") + rng.choice((b"", b" ", b"\n")),
    )
    return b"".join(pieces)


OPERATORS = (
    _flip,
    _any_byte,
    _splice,
    _delete,
    _double,
    _swap,
    _lines,
    _number,
    _number,
    _insert,
    _insert,
)


def main() -> None:
    """Fuzz for some seconds and print what was found, made small, with what the sidecar files of
    found/ hold."""
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 60.0
    seed = int(sys.argv[2]) if len(sys.argv) > 2 else time.time_ns() % 10**9
    fuzzer = run(seed, seconds=seconds)
    print(
        f"seed {seed}: {fuzzer.cases} cases, {len(fuzzer.lines)} lines of source,"
        f" {len(fuzzer.pool)} programs kept"
    )
    for found in fuzzer.found.values():
        case = laws.smallest(found.case, 30 if found.told.startswith("hang") else 600)
        print(
            f"{found.times} x {laws.broken(case) or found.told}\n    {case.options()}\n   "
            f" {case.text!r}",
            flush=True,
        )


if __name__ == "__main__":
    main()
