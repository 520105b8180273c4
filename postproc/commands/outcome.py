"""What became of one program: in one line, as Python sees it, and as JSON (gcomp-program/1)."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from postproc import ports
from postproc.commands import as_json, attempts
from postproc.errors import Notice
from postproc.units import UM

if TYPE_CHECKING:
    from postproc.verify import Verifier

FORMAT = "gcomp-program/1"


@dataclass(frozen=True)
class Verified:
    """The corrected program, replayed on the machine's model. All lengths in um.

    compared: False where no place of the path is known in all of its axes, and nothing was;
    deviation_um, deviation_line: the largest distance from the nominal path, and the line where;
    uncorrected_um,
    uncorrected_line: the same of the program as it was; lost_motion_um: the same with every slide
    in its play;
    tolerance_um: what was asked; allowed_um: what is let pass there (tolerance, hysteresis, half an
    increment, what a slide that turns back moves the others by); map_u_um: how well the map itself
    is known on the path (95 %), None where its folder does not say; not_stated: errors of the map
    whose uncertainty is not stated; report: all of it as a sentence.
    """

    passed: bool
    compared: bool
    deviation_um: float
    deviation_line: int
    uncorrected_um: float
    uncorrected_line: int
    lost_motion_um: float
    tolerance_um: float
    allowed_um: float
    map_u_um: float | None
    not_stated: tuple[str, ...]
    motions_in: int
    motions_out: int
    report: str

    def to_json(self) -> str:
        """As JSON, the keys as the fields here."""
        return as_json.text(asdict(self))


@dataclass(frozen=True)
class Compensated:
    """A corrected program and what was done.

    program: its bytes; name: of the program in messages; machine, map: the machine's name and the
    digest of its map;
    dialect: in which it was read; changed, added: motions changed, blocks put in;
    largest_correction_um: of one axis;
    written_out: why the program was written out as plain blocks without being asked, "" where it
    was not; notices: what a person should know; verified: None unless asked for.
    """

    program: bytes = field(repr=False)
    name: str
    machine: str
    map: str
    dialect: str
    lines: int
    motions: int
    changed: int
    added: int
    largest_correction_um: float
    tolerance_um: float
    written_out: str
    notices: tuple[Notice, ...]
    summary: str
    verified: Verified | None = None

    @property
    def text(self) -> str:
        """The program as text: UTF-8, with bytes that are none kept as surrogates (PEP 383)."""
        return self.program.decode("utf-8", "surrogateescape")

    def save(self, path: str | Path, overwrite: bool = False) -> Path:
        """Write the program, whole or not at all. Raises UsageError where a file stands and
        `overwrite` is not set."""
        return ports.write_new(path, self.program, overwrite)

    def to_json(self) -> str:
        """As JSON (format gcomp-program/1), all but the program itself."""
        return as_json.text(self.as_dict())

    def as_dict(self) -> dict[str, Any]:
        """What `to_json` writes."""
        own = {
            f.name: getattr(self, f.name)
            for f in fields(self)
            if f.name not in ("program", "notices", "verified")
        }
        notices = [
            {"code": n.code, "message": n.message, "line": n.line or None} for n in self.notices
        ]
        return {
            "format": FORMAT,
            **own,
            "notices": notices,
            "verified": asdict(self.verified) if self.verified else None,
        }


def of(done: attempts.Attempt, program: bytes) -> Compensated:
    """What a finished attempt says."""
    filter_, summary = done.filter, done.filter.summary
    return Compensated(
        program, filter_.name, filter_.machine.name, filter_.machine.digest, filter_.dialect.name,
        summary.lines, summary.motions, summary.changed, summary.added, summary.largest / UM,
        filter_.compensator.tolerance / UM, done.why, tuple(filter_.notices), done.summary,
        verified_by(done.verifier) if done.verifier else None,
    )  # fmt: skip


def verified_by(verifier: Verifier) -> Verified:
    """What a verifier has measured."""
    after, before, known = verifier.corrected, verifier.uncorrected, verifier.map.known
    return Verified(
        verifier.passed, not verifier.blind, after.deviation / UM, after.line,
        before.deviation / UM, before.line, after.slide / UM, verifier.tolerance / UM,
        verifier.let_pass / UM,
        verifier.map.largest / UM if known.parts else None, known.missing, verifier.motions_in,
        verifier.motions_out, verifier.report(),
    )  # fmt: skip
