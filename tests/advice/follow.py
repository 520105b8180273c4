"""Runs a program on a machine with a map, and says what stops it.

A case is a program that is refused, and the program (or the options) that a person comes to who
does what the advice says. `|` ends a line. The second one must be corrected and verified, or be
stopped by the sentence of `then`, another one.
"""

from __future__ import annotations

import re
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from types import SimpleNamespace

from postproc.commands import expansion
from postproc.compensate import Options
from postproc.errors import ProgramError
from postproc.filter import Filter, setup_of
from postproc.machine.file import read_machine
from postproc.nc import dialects
from postproc.units import UM
from postproc.verify import Verifier
from tests.corpus.machines import MAIN, Machines, offsets
from tests.corpus.programs import ROOT
from tests.refusals_doc import sentences

CHAPTERS = (
    "The text of a program",
    "Words, codes and motions",
    "Shifts of the coordinates",
    "Holes in place",
    "What the error map can not answer",
    "Written out: cycles, turned and scaled coordinates",
    "Written out: LinuxCNC's O-words and expressions",
    "Written out: Fanuc's macros",
    "Written out: Sinumerik's control structures",
    "Written out: Heidenhain Klartext",
    "Written out: Fadal's subroutines",
    "Written out: Okuma's user tasks",
    "Written out: all languages",
)
WRITE = {"expand": True}
NOWHERE: dict[str, float] = {}


@dataclass(frozen=True)
class Case:
    """first, also: options of the one run and of the other, beside those of both (`how`).

    expand; start: mm, of all axes zero if missing; offsets: all zero if missing; hole_um;
    centre; steps, depth;
    library: name to text; delete: block delete; outside; integers; lathe: X and Z alone; machine:
    one of the project's."""

    dialect: str
    before: str
    after: str
    then: str = ""
    first: Mapping = field(default_factory=dict)
    also: Mapping = field(default_factory=dict)
    how: Mapping = field(default_factory=dict)

    def __str__(self) -> str:
        return f"{self.dialect}: {self.before[-60:]!r}"


@lru_cache
def machines() -> Machines:
    """The machines, in a folder of this process."""
    return Machines(Path(tempfile.mkdtemp(prefix="gcomp-advice-")))


def stopped(dialect: str, text: str, how: Mapping) -> ProgramError | None:
    """What stops the program; None: it is corrected, and verified."""
    spoken = dialects.load(dialect)
    machine = (
        machines()
        .smooth(MAIN, "lathe" in dialect or bool(how.get("lathe")))
        .carrying(spoken.carried)
    )
    if "machine" in how:
        machine = read_machine(ROOT / "machines" / how["machine"])
    start = how.get("start", dict.fromkeys(machine.letters, 0.0))
    setup = setup_of(
        machine,
        how.get("offsets", offsets()),
        start,
        how.get("delete", False),
        how.get("centre", "incremental"),
        how.get("integers", ""),
        how.get("scaling", ""),
    )
    hole = how.get("hole_um")
    options = Options(1.0 * UM, how.get("outside"), hole_tolerance=hole and hole * UM)
    filter_ = Filter(machine, spoken, setup, options, "part.nc")
    verifier = Verifier(filter_)
    whole = text.replace("|", "\n").encode("latin-1") + b"\n"
    try:
        if how.get("expand"):
            limits = SimpleNamespace(
                max_steps=how.get("steps", 20_000), max_depth=how.get("depth", 20)
            )
            library = {
                name: body.replace("|", "\n").encode()
                for name, body in how.get("library", {}).items()
            }
            written = expansion.of_text(filter_, whole, library.get, limits)
            for _ in expansion.through(filter_, written, lambda size: None):
                pass
        else:
            filter_.feed(whole)
            filter_.finish()
    except ProgramError as error:
        return error
    assert verifier.passed, verifier.report()
    return None


def bare(message: str) -> str:
    """A sentence without the names of what is put in: two that differ by these alone are one."""
    return re.sub(r"(\*[^* ]+\*)+", "*", message)


@lru_cache
def patterns() -> list[tuple[re.Pattern[str], int, str]]:
    """Every sentence that stops a program: what fits it, how much of it is fixed, and itself."""
    found = []
    for message in {bare(m) for chapter in CHAPTERS for m, _ in sentences().get(chapter, ())}:
        parts = message.split("*")
        found.append(
            (
                re.compile(".*".join(map(re.escape, parts)) + r"\Z", re.DOTALL),
                len("".join(parts)),
                message,
            )
        )
    return found


def sentence(message: str) -> str:
    """The sentence of docs/REFUSALS.md that a message is, the most definite one; "" where it is
    none."""
    message = message.partition(" (in the block that was written out")[0]
    return max(
        ((n, text) for pattern, n, text in patterns() if pattern.match(message)), default=(0, "")
    )[1]
