"""Real programs, whole, on made-up machines: what comes out, and which laws of a correction hold
for it.

The programs stand beside the project and are no part of it. Each is read in the dialect that a
knowing user would choose, by a machine without errors (the output must be the input, to the byte)
and by machines with smooth maps (the output is replayed and measured). What is measured here is
added up from motions by other code than the one that made them.
"""

from __future__ import annotations

import contextlib
import csv
import io
import itertools
import re
import signal
import threading
import traceback
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from postproc.commands import expansion
from postproc.compensate import Options
from postproc.errors import BlockFault, GcompError, ProgramError
from postproc.filter import Filter, setup_of
from postproc.machine.file import read_machine
from postproc.machine.model import Machine
from postproc.motions import FOREIGN, HOLE, Motions
from postproc.nc import dialects
from postproc.nc.interpreter import Interpreter
from postproc.nc.lexer import lex
from postproc.units import TICKS_PER_MM, UM
from postproc.verify import Verifier

ROOT = Path(__file__).resolve().parents[2]
CORPUS = ROOT.parent / "shared" / "corpus"
FOLDERS = ("fanuc", "mixed", "sinumerik")
NO_PROGRAMS = {"LICENSE", "README.md"}
XYZ, ROTARY = "XYZ", "ABC"
FAR = 3000.0  # mm: tables reach from -FAR to FAR
MAX_STEPS, MAX_DEPTH = 200_000, 50
LONGEST_S = 20

# -- programs --------------------------------------------------------------------------------------

PLOTTER = "a pen on a small controller: M300 lifts it, G4 P counts milliseconds"
LATHE = "X and Z alone, X a diameter, I K arcs in G18"
HELP = "for the eyes of a parser's tests, no program: pieces of many languages"
MIXED = {
    "_Insulpro.Piping.-.115mm.OD.-.40mm.WT.txt": (
        "linuxcnc",
        "plain DIN codes between % lines, no control of its own",
    ),
    "_cncwebsim_fresa.gcode": ("linuxcnc", "plain codes, `;` comments, G92 with axis words"),
    "_fresa.gcode": ("linuxcnc", "plain codes, `;` comments, G92 with axis words"),
    "_dxf2gcode_join.ngc": ("linuxcnc", "dxf2gcode, G64 P"),
    "_join.ngc": ("linuxcnc", "dxf2gcode, G64 P"),
    "_ffcp_end.gcode": (
        "marlin",
        "the end of a print (Sailfish, a printer's firmware): Marlin is its next of kin",
    ),
    "_gcodeLexer_samples.ngc": ("linuxcnc", HELP),
    "_samples.ngc": ("linuxcnc", HELP),
    "_gcodehs_sample.gcode": ("linuxcnc", "pcb2gcode writes for LinuxCNC"),
    "_libgcode_slot.ngc": ("linuxcnc", "O words: a library of subprograms"),
    "_slot.ngc": ("linuxcnc", "O words: a library of subprograms"),
    "_linuxcnc_dot.ngc": ("linuxcnc", "O words: a library of subprograms"),
    "_mach3.gcode": ("mach3", "says so; torch height by S words"),
    "_mach3_plasma.gcode": ("mach3", "says so; torch height by S words"),
    "_program_3.gcode": ("mach3", "Vectric's post for Mach3: G71, G91.1, M62 P1"),
    "_viaconstructor_simple.ngc": ("linuxcnc", "viaConstructor, G64 P"),
    "arc_end.gcode": ("marlin", "the end of a print: E, M104, M140, M84"),
    "bondtech_estep.gcode": ("marlin", "settings of a printer: M92 E, M500"),
    "circle_a.gcode": ("grbl", "Estlcam, plain codes: GRBL reads them"),
    "estlcam_circle_a.gcode": ("grbl", "Estlcam, plain codes: GRBL reads them"),
    "makerblock_tinycnc.gcode": ("marlin", PLOTTER),
    "plotter_owl.gcode": ("marlin", PLOTTER),
    "program_1.gcode": (
        "mach3",
        "O number of Fanuc, but `;` comments, which a Fanuc does not have",
    ),
    "program_2.gcode": (
        "linuxcnc",
        "`;` takes blocks out; G41 without D means the tool in the spindle",
    ),
    "reprap_25000_cnc.gcode": ("marlin", "for a RepRap's printer board: all feeds, arcs by R"),
    "reprap_cnc.gcode": ("marlin", "for a RepRap's printer board: all feeds, arcs by R"),
}
FRAGMENTS = {"mixed/_gcodeLexer_samples.ngc", "mixed/_samples.ngc"}
ABSOLUTE_CENTRES = {
    "fanuc/BOTTLE.NC",
    "fanuc/CONTOUR_ABS.NC",
    "fanuc/TEST2.NC",
}  # their user says --arc-centre absolute
SLOW = {
    "fanuc/BOTTLE.NC": 400,
    "fanuc/PARALLEL.NC": 400,
    "mixed/makerblock_tinycnc.gcode": 600,
}  # lines that tests read


@dataclass(frozen=True)
class Program:
    """One file. name: "folder/file"; dialect: the one that a knowing user would choose; why: where
    that is not obvious."""

    name: str
    path: Path
    dialect: str
    why: str = ""

    @property
    def text(self) -> bytes:
        return self.path.read_bytes()

    @property
    def short(self) -> bytes:
        """The text, of a long one its first lines."""
        return b"".join(self.text.splitlines(keepends=True)[: SLOW.get(self.name, 10**9)])

    @property
    def lathe(self) -> bool:
        """Whether its user has a lathe: slides X and Z, X a diameter."""
        return "lathe" in self.dialect

    @property
    def arc_centre(self) -> str:
        return "absolute" if self.name in ABSOLUTE_CENTRES else "incremental"


def programs() -> list[Program]:
    """All programs, in order of folder and name; none where the corpus is not there."""
    found = []
    for folder in FOLDERS:
        for path in sorted((CORPUS / folder).glob("*"), key=lambda p: p.name):
            if path.suffix == ".csv" or path.name in NO_PROGRAMS:
                continue
            found.append(Program(f"{folder}/{path.name}", path, *chosen(folder, path.name)))
    return found


def has_cycles(program: Program) -> bool:
    """Whether canned cycles or frames stand in it, which --expand writes out though they can be
    corrected in place."""
    return bool(re.search(rb"(?i)G8[1-9]|G7[346]|TRANS|ROT|DEF |=|o<", program.text))


def chosen(folder: str, name: str) -> tuple[str, str]:
    """Dialect, and why."""
    if folder == "sinumerik":
        return "siemens", ""
    if folder == "fanuc":
        return ("fanuc-lathe", LATHE) if "TURN" in name else ("fanuc-mill", "")
    return MIXED.get(name, ("linuxcnc", "not looked at yet"))


def recognised(text: bytes) -> str:
    """What `--dialect auto` takes it for; several names where the signs are the same."""
    try:
        from postproc.nc.recognise import recognise
    except ImportError:
        return "?"
    found = recognise(text)
    if not found:
        return ""
    return " ".join(name for name, signs in found if len(signs) == len(found[0][1]))


# -- machines --------------------------------------------------------------------------------------

TOML = """\
format  = "gcomp-machine/1"
name    = "{name}"
control = "linuxcnc"
chain   = "w-X-Y-b-Z-t"
source  = "made up for the tests"
"""
LATHE_LINES = {
    '"w-X-Y-b-Z-t"': '"w-b-Z-X-t"\ndiameter = ["X"]',
    "C0Y = 12.0\n": "",
    "A0Z = -9.0\n": "",
}
SQUARE = """
[squareness]
C0Y = 12.0
A0Z = -9.0
B0Z = 7.0
"""
AXIS = """
[axes.{axis}]
travel = [-{far}, {far}]
least_increment = {least}
"""
WAVES = {  # component: um or urad, mm of a wave, phase
    "XX": (8.0, 410.0, 0.3),
    "YX": (5.0, 230.0, 1.1),
    "ZX": (6.0, 310.0, 2.0),
    "AX": (2.0, 900.0, 0.5),
    "BX": (1.5, 700.0, 1.0),
    "CX": (2.0, 800.0, 0.1),
    "XY": (6.0, 260.0, 1.7),
    "YY": (9.0, 380.0, 0.9),
    "ZY": (4.0, 170.0, 0.2),
    "AY": (1.5, 650.0, 1.4),
    "BY": (2.0, 950.0, 0.7),
    "CY": (1.0, 500.0, 2.2),
    "XZ": (5.0, 210.0, 0.8),
    "YZ": (7.0, 290.0, 1.9),
    "ZZ": (8.0, 350.0, 0.6),
    "AZ": (2.0, 850.0, 0.9),
    "BZ": (1.5, 750.0, 1.8),
    "CZ": (1.0, 600.0, 0.4),
}
GAP_UM = 3.0  # half of it each way


@dataclass(frozen=True)
class Variant:
    """How a program is run on the machine with a map."""

    two_way: bool = True
    least: float = 0.0001
    tolerance_um: float = 1.0

    def __str__(self) -> str:
        ways = "both directions" if self.two_way else "one direction"
        return f"{ways}, least increment {self.least:g} mm, tolerance {self.tolerance_um:g} um"


MAIN = Variant()
VARIANTS = (
    MAIN,
    Variant(False),
    Variant(True, 0.0001, 5.0),
    Variant(False, 0.0001, 5.0),
    Variant(True, 0.001),
    Variant(True, 0.001, 5.0),
)


def write_zero(folder: Path, lathe: bool = False) -> Path:
    """X Y Z A B C (a lathe: X and Z) without errors."""
    folder.mkdir(parents=True)
    text = TOML.format(name=folder.name)
    for axis in "XZ" if lathe else XYZ + ROTARY:
        text += AXIS.format(axis=axis, far=FAR + 100 if axis in XYZ else 1e6, least=0.0001)
        if axis in XYZ:
            text += f'table = "{axis}.csv"\n'
            rows = [f"{axis}_mm,E{axis}{axis}_um", f"{-FAR},0.0", f"{FAR},0.0"]
            (folder / f"{axis}.csv").write_text("\n".join(rows) + "\n")
    return _written(folder, text, lathe)


def write_smooth(folder: Path, two_way: bool, least: float, lathe: bool = False) -> Path:
    """X Y Z with all errors of their slides as smooth waves of a few um, and A B C without tables;
    a lathe: X and Z."""
    folder.mkdir(parents=True)
    text = TOML.format(name=folder.name) + SQUARE
    nodes = np.arange(-FAR, FAR + 1, 25.0)
    for axis in "XZ" if lathe else XYZ + ROTARY:
        text += AXIS.format(axis=axis, far=FAR + 100 if axis in XYZ else 1e6, least=least)
        if axis not in XYZ:
            continue
        text += f'table = "{axis}.csv"\n'
        columns = {f"{axis}_mm": nodes}
        for direction, unit in ((d, u) for u, ds in (("um", XYZ), ("urad", ROTARY)) for d in ds):
            size, length, phase = WAVES[direction + axis]
            values = size * np.sin(2 * np.pi * nodes / length + phase)
            name = f"E{direction}{axis}_{unit}"
            if two_way and direction == axis:
                gap = GAP_UM * (0.8 + 0.2 * np.sin(nodes / 500.0))
                columns |= {name + "_fwd": values - gap / 2, name + "_rev": values + gap / 2}
            else:
                columns[name] = values
        rows = [
            ",".join(columns),
            *(",".join(f"{v:.4f}" for v in row) for row in zip(*columns.values(), strict=True)),
        ]
        (folder / f"{axis}.csv").write_text("\n".join(rows) + "\n")
    return _written(folder, text, lathe)


def _written(folder: Path, text: str, lathe: bool) -> Path:
    for old, new in LATHE_LINES.items() if lathe else ():
        text = text.replace(old, new)
    (folder / "machine.toml").write_text(text)
    return folder


class Machines:
    """The machines, written once into a folder."""

    def __init__(self, folder: Path):
        self.folder = folder
        self._read: dict[str, Machine] = {}

    def zero(self, lathe: bool = False) -> Machine:
        return self._machine("zero", lathe, lambda path: write_zero(path, lathe))

    def smooth(self, variant: Variant, lathe: bool = False) -> Machine:
        name = f"{'two' if variant.two_way else 'one'}-way-{variant.least:g}"
        return self._machine(
            name, lathe, lambda path: write_smooth(path, variant.two_way, variant.least, lathe)
        )

    def _machine(self, name: str, lathe: bool, write: Callable[[Path], Path]) -> Machine:
        name += "-lathe" if lathe else ""
        if name not in self._read:
            path = self.folder / name
            self._read[name] = read_machine(path if path.exists() else write(path))
        return self._read[name]


@lru_cache
def offsets() -> dict[str, dict[str, float]]:
    """Every work and tool offset that a program could name, zero."""
    zero = dict.fromkeys(XYZ + ROTARY, 0.0)
    names = (
        [f"G{n}" for n in range(54, 60)]
        + ["G59.1", "G59.2", "G59.3"]
        + [f"G{n}" for n in range(505, 600)]
    )
    names += [f"G54.1 P{n}" for n in range(1, 49)] + [f"T{n:02d}{n:02d}" for n in range(1, 100)]
    names += [f"{letter}{n}" for letter in "HDT" for n in range(100)] + [
        f"T{n}D1" for n in range(100)
    ]
    return {name: dict(zero, R=0.0) if name[0] in "DT" else zero for name in names}


# -- one run ---------------------------------------------------------------------------------------

NEEDS = "--expand is needed"
REASONS = (  # what a refusal is about, by what its message or advice says; the first that fits
    ("an offset that nobody stated", ("is not stated",)),
    (
        "an axis that the machine has not",
        ("the machine has no axis", "the letter E has no meaning", "ELX is not defined"),
    ),
    (
        "outside of the map or the travel",
        ("outside its table", "beyond the travel", "outside the travel"),
    ),
    (
        "an error in the program itself",
        (
            "misses its own end",
            "is not text",
            "a comment is opened",
            "words in one block",
            "without its centre words",
            "is not defined in this program",
        ),
    ),
    (NEEDS, ("--expand",)),
)
OTHER = "a construct that is not followed"
FRAGMENT = "not a program for a control"
BROKEN = "an error of gcomp"


@dataclass
class Outcome:
    """What became of a program. um: largest deviation; paths in mm; faults: laws that do not
    hold."""

    status: str = ""  # identical, verified, written (zero map, --expand), refused, broken
    line: int = 0
    message: str = ""
    advice: str = ""
    blocks: int = 0
    motions_in: int = 0
    motions_out: int = 0
    path_in: float = 0.0
    path_out: float = 0.0
    uncorrected: float = 0.0
    corrected: float = 0.0
    notices: list[str] = field(default_factory=list)
    faults: list[str] = field(default_factory=list)
    output: bytes = b""

    @property
    def good(self) -> bool:
        return self.status in ("identical", "verified", "written")

    @property
    def reason(self) -> str:
        """The class of a refusal."""
        if self.status == "broken":
            return BROKEN
        said = f"{self.message}\n{self.advice}"
        return next((name for name, signs in REASONS if any(sign in said for sign in signs)), OTHER)


def make_filter(
    machine: Machine,
    program: Program,
    tolerance_um: float | None = None,
    start: dict[str, float] | None = None,
) -> Filter:
    """A filter for the dialect; all offsets are zero, and the machine stands at zero where `start`
    does not say more."""
    dialect = dialects.load(program.dialect)
    machine = machine.carrying(dialect.carried)
    place = {x: 0.0 for x in machine.letters} | (start or {})
    setup = setup_of(machine, offsets(), place, arc_centre=program.arc_centre)
    options = Options(tolerance=tolerance_um * UM) if tolerance_um else Options()
    return Filter(machine, dialect, setup, options, program.path.name)


def output(
    filter_: Filter, text: bytes, expand: bool = False, cuts: tuple[int, ...] = ()
) -> Iterator[bytes]:
    """The output; the input is cut at these places ((0,): behind every line)."""
    if expand:
        yield from expansion.through(filter_, written_out(filter_, text), lambda n: None)
        return
    if cuts == (0,):
        parts = text.splitlines(keepends=True)
    else:
        edges = [0, *cuts, len(text)]
        parts = [text[a:b] for a, b in itertools.pairwise(edges)]
    for part in parts:
        yield filter_.feed(part)
    yield filter_.finish()


def written_out(filter_: Filter, text: bytes):
    """What --expand makes of it, to iterate over. No file is looked for: a program stands alone."""
    options = SimpleNamespace(file=None, library=[], max_steps=MAX_STEPS, max_depth=MAX_DEPTH)
    return expansion.written_out(filter_, io.BytesIO(text), options)


@contextlib.contextmanager
def at_most(seconds: float):
    """Raises TimeoutError when it takes longer, where the system can do that."""
    if not hasattr(signal, "SIGALRM") or threading.current_thread() is not threading.main_thread():
        yield
        return

    def late(number, frame):
        raise TimeoutError(f"not done after {seconds:g} s")

    before = signal.signal(signal.SIGALRM, late)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def run_zero(machines: Machines, program: Program, text: bytes, expand: bool) -> Outcome:
    """On the machine without errors."""
    outcome = _run(make_filter(machines.zero(program.lathe), program), text, expand)
    if outcome.status == "done":
        outcome.status = "written" if expand else "identical"
        if not expand and outcome.output != text:
            outcome.faults.append(
                "a map without errors moved a byte: " + first_difference(text, outcome.output)
            )
    return outcome


def run_smooth(
    machines: Machines, program: Program, text: bytes, expand: bool, variant: Variant = MAIN
) -> Outcome:
    """On a machine with a map: verified, and the laws measured."""
    machine = machines.smooth(variant, program.lathe)
    filter_ = make_filter(machine, program, variant.tolerance_um)
    verifier = Verifier(filter_)
    counts: list[tuple[int, np.ndarray, np.ndarray]] = []
    filter_.watchers.append(
        lambda words, motions, pieces, out, line: counts.append(
            (len(motions), pieces.motion, pieces.take_up)
        )
    )
    outcome = _run(filter_, text, expand)
    outcome.motions_in, outcome.motions_out = verifier.motions_in, verifier.motions_out
    outcome.uncorrected, outcome.corrected = (
        verifier.uncorrected.deviation / UM,
        verifier.corrected.deviation / UM,
    )
    if outcome.status != "done":
        return outcome
    outcome.status = "verified"
    if not verifier.passed:
        outcome.faults.append(f"not within the tolerance: {verifier.report()}")
    try:
        with at_most(LONGEST_S):
            plain = text
            if expand:
                plain = b"".join(
                    written_out(make_filter(machine, program, variant.tolerance_um), text)
                )
            _measure(outcome, filter_, plain, counts)
    except (GcompError, BlockFault, TimeoutError) as error:
        outcome.faults.append(f"input or output can not be followed as a whole: {error}")
    except Exception:
        outcome.faults.append(
            "input or output can not be followed as a whole: " + traceback.format_exc(limit=-2)
        )
    return outcome


def run_cut(
    machines: Machines, program: Program, text: bytes, cuts: tuple[int, ...] = ()
) -> Outcome:
    """On the machine with a map, the input cut in other places; not verified."""
    return _run(
        make_filter(machines.smooth(MAIN, program.lathe), program, MAIN.tolerance_um),
        text,
        False,
        cuts,
    )


def _run(filter_: Filter, text: bytes, expand: bool, cuts: tuple[int, ...] = ()) -> Outcome:
    outcome, out = Outcome(), []
    try:
        with at_most(LONGEST_S):
            for part in output(filter_, text, expand, cuts):
                out.append(part)
        outcome.status = "done"
    except ProgramError as error:
        out.append(error.delivered)
        outcome.status, outcome.message, outcome.advice = "refused", error.message, error.advice
        outcome.line = error.place.line if error.place else 0
        lines = text.count(b"\n") + 1
        if not 0 < outcome.line <= lines:
            outcome.faults.append(f"a refusal at line {outcome.line} of {lines}")
        if not error.advice:
            outcome.faults.append("a refusal without advice")
    except GcompError as error:
        outcome.status, outcome.message, outcome.advice = "broken", error.message, error.advice
        outcome.line = error.place.line if error.place else 0
        outcome.faults.append(f"{error}")
    except TimeoutError as error:
        outcome.status, outcome.message = "broken", str(error)
        outcome.faults.append(str(error))
    except Exception as error:
        outcome.status, outcome.message = "broken", f"{type(error).__name__}: {error}"
        outcome.faults.append(traceback.format_exc(limit=-4))
    outcome.output = b"".join(out)
    outcome.blocks = filter_.summary.blocks
    outcome.notices = [notice.message for notice in filter_.notices]
    return outcome


# -- laws ------------------------------------------------------------------------------------------


def first_difference(a: bytes, b: bytes) -> str:
    """The first line in which two texts differ."""
    first, second = a.split(b"\n"), b.split(b"\n")
    for number, (x, y) in enumerate(zip(first, second, strict=False), 1):
        if x != y:
            return f"line {number}: {x[:80]!r} and {y[:80]!r}"
    return f"{len(first)} lines and {len(second)}"


def whole(filter_: Filter, text: bytes) -> Motions:
    """Motions of a whole program in one batch; "%" lines taken out as a control does."""
    lines, kept, begun = text.split(b"\n"), [], False
    for line in lines:
        if line.strip()[:1] == b"%":
            if begun:
                break
            begun = True
            continue
        kept.append(line)
        begun = begun or bool(line.strip())
    interpreter = Interpreter(filter_.dialect, filter_.setup)
    words = lex(b"\n".join(kept), filter_.dialect.grammar)
    motions, state, _ = interpreter.run(words, interpreter.initial())
    if words.fault and not state.ended:
        raise words.fault
    return motions


def lengths(motions: Motions, rows: list[int]) -> np.ndarray:
    """(N,) mm along X Y Z: straight ways, arcs by their sweep, holes down and up; 0 where an end is
    not known."""
    way = (motions.target - motions.start)[rows] / TICKS_PER_MM
    length = np.sqrt((way**2).sum(axis=0))
    arcs = motions.arcs
    if len(arcs):
        radius = (arcs.radius + arcs.radius_end) / 2
        square = (radius * arcs.sweep) ** 2
        for i, row in enumerate(rows):
            beside = (arcs.first != row) & (arcs.second != row)
            square = square + np.where(beside, way[i, arcs.motion], 0.0) ** 2
        length[arcs.motion] = np.sqrt(square)
    holes = motions.holes
    if len(holes):
        across = np.array([[row != axis for axis in holes.axis] for row in rows])
        length[holes.motion] = np.sqrt(((way[:, holes.motion] * across) ** 2).sum(axis=0))
        length[holes.motion] += 2 * np.abs(holes.level - holes.bottom) / TICKS_PER_MM
    known = (motions.start_known[rows] & motions.target_known[rows]).all(axis=0) & (
        motions.code != FOREIGN
    )
    return np.where(known, length, 0.0)


def _measure(outcome: Outcome, filter_: Filter, plain: bytes, counts) -> None:
    """Motions and ways of input and output, each read as a whole."""
    machine, tolerance = filter_.machine, filter_.compensator.tolerance
    rows = [machine.letters.index(x) for x in XYZ if x in machine.letters]
    nominal, out = whole(filter_, plain), whole(filter_, outcome.output)
    if len(nominal) != sum(n for n, _, _ in counts) or len(nominal) != outcome.motions_in:
        outcome.faults.append(f"{len(nominal)} motions as a whole, {outcome.motions_in} in batches")
        return
    begin, owner = 0, []
    for n, motion, _ in counts:
        owner.append(motion + begin)
        begin += n
    owner_all = np.concatenate(owner) if owner else np.zeros(0, np.int64)
    take_up = np.concatenate([t for _, _, t in counts]) if counts else np.zeros(0, bool)
    if len(out) != len(owner_all):
        outcome.faults.append(
            f"{len(owner_all)} pieces were planned, {len(out)} motions stand in the output"
        )
        return
    if len(np.unique(owner_all)) != len(nominal):
        outcome.faults.append(
            f"{len(nominal) - len(np.unique(owner_all))} motions have no piece in the output"
        )
    a, b = lengths(nominal, rows), lengths(out, rows)
    outcome.path_in, outcome.path_out = float(a.sum()), float(b.sum())
    # Where the place is lost and found again the way up to there is not known; both sums leave it
    # out.
    slack = (
        1e-3 * outcome.path_in
        + tolerance * len(out)
        + (GAP_UM + 1) * UM * int(take_up.sum())
        + 0.05
    )
    if len(out) > 4 * len(nominal) + outcome.path_in / 2 + 100:
        outcome.faults.append(
            f"{len(nominal)} motions became {len(out)} on {outcome.path_in:.0f} mm"
        )
    if abs(outcome.path_in - outcome.path_out) > slack:
        outcome.faults.append(
            f"{outcome.path_in:.3f} mm in, {outcome.path_out:.3f} mm out, {slack:.3f} allowed"
        )
    if len(owner_all):
        _same_places(outcome, filter_, nominal, out, owner_all)


def _same_places(
    outcome: Outcome, filter_: Filter, nominal: Motions, out: Motions, owner: np.ndarray
) -> None:
    """The end of each motion's last piece: by no more than a correction beside the nominal end,
    rotary axes on it."""
    last = np.flatnonzero(np.append(owner[1:] != owner[:-1], True))
    away = np.abs(out.target[:, last] - nominal.target[:, owner[last]]) / TICKS_PER_MM
    known = out.target_known[:, last] & nominal.target_known[:, owner[last]]
    if (out.target_known[:, last] != nominal.target_known[:, owner[last]]).any():
        outcome.faults.append(
            "a place is known in the input and not in the output, or the other way round"
        )
    if (out.code[last] == HOLE).any() != (nominal.code == HOLE).any():
        outcome.faults.append("holes were lost or came in")
    for row, letter in enumerate(filter_.machine.letters):
        most = filter_.summary.largest + 0.003 if letter in XYZ else 1e-9
        worst = np.where(known[row], away[row], 0.0)
        if worst.max(initial=0.0) > most:
            k = int(worst.argmax())
            outcome.faults.append(
                f"{letter} ends {worst[k]:.4f} mm from the nominal place in motion"
                f" {int(owner[last[k]])}, largest correction {filter_.summary.largest:.4f}"
            )


# -- tables of places ------------------------------------------------------------------------------


# The tables were made with this one's axes where another program of its folder leaves them.
TABLE_BEGINS = {"sinumerik/increment.mpf": {"Y": 900.0}}


def table_of(program: Program) -> list[tuple[float, ...]] | None:
    """The places X Y Z A B C, each other than the one before, that a table beside the program says
    it reaches."""
    stem = program.path.with_suffix("")
    path = next(
        (p for p in (stem.with_suffix(".csv"), Path(f"{stem}_raw.csv")) if p.exists()), None
    )
    if path is None:
        return None
    begin = TABLE_BEGINS.get(program.name, {})
    with path.open(newline="", encoding="utf-8") as file:
        rows = [
            tuple(float(row.get(x) or begin.get(x, 0.0)) for x in XYZ + ROTARY)
            for row in csv.DictReader(file)
        ]
    return _changing(program, rows)


def places_of(
    machines: Machines, program: Program, text: bytes, expand: bool
) -> list[tuple[float, ...]]:
    """The same, as the program takes the machine there. Raises GcompError or BlockFault where it is
    refused."""
    filter_ = make_filter(machines.zero(), program, start=TABLE_BEGINS.get(program.name))
    plain = b"".join(output(filter_, text, expand))
    target = whole(filter_, plain).target / TICKS_PER_MM
    rows = [filter_.machine.letters.index(x) for x in XYZ + ROTARY]
    return _changing(program, [tuple(map(float, place[rows])) for place in target.T])


def _changing(program: Program, rows: list[tuple[float, ...]]) -> list[tuple[float, ...]]:
    begin = TABLE_BEGINS.get(program.name, {})
    found: list[tuple[float, ...]] = [tuple(begin.get(x, 0.0) for x in XYZ + ROTARY)]
    for row in rows:
        if max(abs(a - b) for a, b in zip(row, found[-1], strict=True)) > 1e-4:
            found.append(row)
    return found


def table_fault(machines: Machines, program: Program) -> str:
    """Where the places of a program, as it is and written out, first differ from those of its
    table; "" if nowhere, if there is no table, or if the program is refused."""
    table = table_of(program)
    for expand in (False, True) if table else ():
        try:
            found = places_of(machines, program, program.text, expand)
        except (GcompError, BlockFault):
            continue
        how = "written out" if expand else "as it is"
        for number, (a, b) in enumerate(zip(found, table, strict=False)):
            if max(abs(x - y) for x, y in zip(a, b, strict=True)) > 1e-3:
                return f"{how}, place {number} is {a}, the table says {b}"
        if len(found) != len(table):
            return f"{how}, {len(found)} places, the table has {len(table)}"
    return ""
