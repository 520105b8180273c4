"""Programs in, corrected programs out, and how well they keep the nominal path."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable
from contextlib import closing
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any, BinaryIO, TypedDict, Unpack

from postproc import intake, ports
from postproc.api import results
from postproc.api.machines import machine_of
from postproc.commands import attempts, reading, values
from postproc.commands import compensate as command
from postproc.errors import Notice, UsageError
from postproc.filter import Filter
from postproc.machine.model import Machine
from postproc.units import UM
from postproc.verify import Verifier

FORMAT = "gcomp-program/1"


class Settings(TypedDict, total=False):
    """How a program is corrected and read; each is the option of the same name of `gcomp
    compensate`, and none has to be given.

    Lengths end in their unit. offsets: name to axis to mm, {"G54": {"X": 1.0, "Z": 2.0}}, radius,
    machine coordinates;
    offset_files: files of the control that hold offsets; start: mm by axis, where the machine
    stands before the program;
    expand: True writes loops and subprograms out, False refuses what needs it, None (the rule of
    `gcomp FILE`) does so where nothing else corrects the program, and says so in
    `Compensated.written_out`; block_delete: whether blocks that begin with / are skipped at the
    machine; dialect: "auto" looks at the program; integers: "units" or "least-increments".
    temperatures: a log of thermometers, each block meets the temperature of its moment; log_begin:
    when in it the program begins; pace: factor by which the machine takes longer than the program
    says; hold_temperature: holds the log's last row behind it.
    """

    tolerance_um: float
    hole_tolerance_um: float
    hysteresis_um: float
    reversal: str
    ramp_mm: float
    outside: str
    orientation: bool
    cut_rapids: bool
    dialect: str
    offsets: dict[str, dict[str, float]]
    offset_files: list[str | Path]
    offsets_unit: str
    offsets_x: str
    integers: str
    expand: bool | None
    library: list[str | Path]
    max_steps: int
    max_depth: int
    start: dict[str, float]
    block_delete: bool
    arc_centre: str
    temperatures: str | Path
    log_begin: str
    pace: float
    hold_temperature: bool


@dataclass(frozen=True)
class Verified:
    """The corrected program, replayed on the machine's model. All lengths in um.

    deviation_um, deviation_line: the largest distance from the nominal path, and the line where;
    uncorrected_um,
    uncorrected_line: the same of the program as it was; lost_motion_um: the same with every slide
    in its play;
    tolerance_um: what was asked; allowed_um: what is let pass (tolerance, hysteresis, half an
    increment); map_u_um: how well the map itself is known on the path (95 %), None where its folder
    does not say; not_stated: errors of the map whose uncertainty nobody states; report: all of it
    as a sentence.
    """

    passed: bool
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
        return results.as_text(asdict(self))


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
        return results.write(path, self.program, overwrite)

    def to_json(self) -> str:
        """As JSON (format gcomp-program/1), all but the program itself."""
        return results.as_text(self.as_dict())

    def as_dict(self) -> dict[str, Any]:
        """What `to_json` writes."""
        own = {
            f.name: getattr(self, f.name)
            for f in fields(self)
            if f.name not in ("program", "notices", "verified")
        }
        told = [
            {"code": n.code, "message": n.message, "line": n.line or None} for n in self.notices
        ]
        return {
            "format": FORMAT,
            **own,
            "notices": told,
            "verified": asdict(self.verified) if self.verified else None,
        }


def compensate(
    program: str | bytes | Path | Iterable[str | bytes],
    machine: Machine | str | Path,
    *,
    verify: bool = False,
    **settings: Unpack[Settings],
) -> Compensated:
    """Correct a program for a machine.

    program: a Path is a file; str and bytes are the program's text; anything else that can be
    iterated gives its pieces, cut anywhere. machine: as `load_machine` returned it, or its name or
    folder. verify: replay the result too, and refuse it if it is over the tolerance. Raises
    ProgramError with line, columns and the way out where a program can not be corrected, UsageError
    for a setting that can not be.
    """
    options = _options(dict(settings), program)
    options.verify = verify
    done = attempt(program, machine_of(machine), options)
    with closing(done.spool) as spool:
        spool.seek(0)
        return result(done, spool.read())


def verify(
    program: str | bytes | Path | Iterable[str | bytes],
    machine: Machine | str | Path,
    **settings: Unpack[Settings],
) -> Verified:
    """How far a nominal program would be off as it is, and once corrected; no program is kept. As
    `gcomp FILE --verify`."""
    verified = compensate(program, machine, verify=True, **settings).verified
    assert verified is not None
    return verified


def live_filter(machine: Machine | str | Path, **settings: Unpack[Settings]) -> Filter:
    """A filter for programs that come piece by piece: `feed(bytes) -> bytes` as often as there is
    something, `finish() -> bytes` at the end, `notices`. Any cut of the input gives the same bytes.
    As `gcomp --unbuffered`: what has left can not be taken back, and nothing is written out as
    plain blocks."""
    return reading.filter_of(_options(dict(settings), ""), machine_of(machine))


def attempt(program: Any, machine: Machine, options: argparse.Namespace) -> attempts.Attempt:
    """The program, corrected as the options of the command line want it; its output is in the
    attempt's spool."""
    if isinstance(program, Path):
        with ports.opened(str(program)) as (source, name, _):
            return attempts.best(
                options, machine, _kept(source), name, ports.head(source), lambda size: None
            )
    with _text(program) as source:
        head = source.read(ports.HEAD)
        source.seek(0)
        return attempts.best(options, machine, _kept(source), "<program>", head, lambda size: None)


def result(done: attempts.Attempt, program: bytes) -> Compensated:
    """What a finished attempt says."""
    filter_, summary = done.filter, done.filter.summary
    return Compensated(
        program,
        filter_.name,
        filter_.machine.name,
        filter_.machine.digest,
        filter_.dialect.name,
        summary.lines,
        summary.motions,
        summary.changed,
        summary.added,
        summary.largest / UM,
        filter_.compensator.tolerance / UM,
        done.why,
        tuple(filter_.notices),
        command.summary(filter_),
        verified_by(done.verifier) if done.verifier else None,
    )


def verified_by(verifier: Verifier) -> Verified:
    """What a verifier has measured."""
    after, before, known = verifier.corrected, verifier.uncorrected, verifier.map.known
    return Verified(
        verifier.passed,
        after.deviation / UM,
        after.line,
        before.deviation / UM,
        before.line,
        after.slide / UM,
        verifier.tolerance / UM,
        verifier.allowed / UM,
        verifier.map.largest / UM if known.parts else None,
        known.missing,
        verifier.motions_in,
        verifier.motions_out,
        verifier.report(),
    )


def defaults() -> argparse.Namespace:
    """The options of `gcomp compensate` as they are where nobody says anything."""
    parser = argparse.ArgumentParser(add_help=False)
    command.arguments(parser)
    return parser.parse_args([])


def _kept(source: BinaryIO) -> ports.Kept:
    return ports.Kept(source, intake.PROGRAM)


def _text(program: str | bytes | Iterable[str | bytes]) -> BinaryIO:
    """The program in a file without a name."""
    spool = ports.spool()
    for piece in [program] if isinstance(program, str | bytes) else program:
        spool.write(piece.encode("utf-8", "surrogateescape") if isinstance(piece, str) else piece)
    spool.seek(0)
    return spool


# -- settings --------------------------------------------------------------------------------------

UNITS = {
    "tolerance_um": values.tolerance,
    "hole_tolerance_um": values.hole_tolerance,
    "hysteresis_um": values.tolerance,
    "ramp_mm": values.length,
}
CHOICES = {
    "reversal": ("mean", "step", "ramp", "off"),
    "outside": ("error", "clamp"),
    "offsets_unit": ("mm", "inch"),
    "offsets_x": ("radius", "diameter"),
    "integers": ("units", "least-increments"),
    "arc_centre": ("incremental", "absolute"),
}


# Setting to the option that it is, and its value made of the setting's.
TAKEN: dict[str, tuple[str, Callable[[Any], Any]]] = {
    "offsets": ("offset", lambda value: [_offset(key, place) for key, place in value.items()]),
    "offset_files": ("offsets", lambda value: [str(path) for path in value]),
    "library": ("library", lambda value: [str(path) for path in value]),
    "temperatures": ("temperatures", str),
    "block_delete": ("block_delete", lambda value: "on" if value else "off"),
}


def _options(settings: dict[str, Any], program: Any) -> argparse.Namespace:
    """What the command line would have made of the settings. Raises TypeError for a name that is
    none, UsageError for a value."""
    options = defaults()
    known = Settings.__annotations__
    if unknown := sorted(set(settings) - set(known)):
        raise TypeError(f"there is no setting {unknown[0]!r}; settings: {', '.join(known)}")
    for name, value in settings.items():
        if name in CHOICES and value not in CHOICES[name]:
            raise UsageError(f"{name}={value!r} is none of {', '.join(CHOICES[name])}")
        if name in UNITS:
            setattr(options, name.rpartition("_")[0], _length(name, value))
        elif name in TAKEN:
            option, made = TAKEN[name]
            setattr(options, option, made(value))
        else:
            setattr(options, name, value)
    options.file = str(program) if isinstance(program, Path) else None
    return options


def _length(name: str, value: float) -> float:
    """mm, judged as the command line judges it."""
    try:
        return UNITS[name](f"{value!r}{name.rpartition('_')[2]}")
    except argparse.ArgumentTypeError as error:
        raise UsageError(f"{name}={value!r}: {error}") from None


def _offset(name: str, place: dict[str, float]) -> tuple[str, dict[str, float]]:
    try:
        return values.offset(
            f"{name}=" + ",".join(f"{axis}{value:.9f}" for axis, value in place.items())
        )
    except argparse.ArgumentTypeError as error:
        raise UsageError(f"offsets: {error}") from None
