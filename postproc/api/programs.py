"""Programs in, corrected programs out, and how well they keep the nominal path."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable
from contextlib import closing
from pathlib import Path
from typing import Any, BinaryIO, TypedDict, Unpack

from postproc import intake, ports
from postproc.api.machines import machine_of
from postproc.commands import attempts, outcome, reading, values
from postproc.commands import compensate as command
from postproc.commands.outcome import Compensated, Verified
from postproc.errors import UsageError
from postproc.filter import Filter
from postproc.machine.model import Machine


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
    machine; dialect: "auto" looks at the program; integers: "units" or "least-increments";
    scaling: what cycle 11 of a Heidenhain scales, "plane" or "space".
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
    scaling: str
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
    folder. verify: replay the result too, and refuse it if more is left than is let pass
    (Verified.allowed_um). Raises ProgramError with line, columns and the way out where a program
    can not be corrected, UsageError for a setting that can not be.
    """
    options = _options(dict(settings), program)
    options.verify = verify
    done = attempt(program, machine_of(machine), options)
    with closing(done.spool) as spool:
        spool.seek(0)
        return outcome.of(done, spool.read())


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
            return attempts.Tries(
                options, machine, _kept(source), name, ports.head(source), lambda size: None
            ).best()
    with _text(program) as source:
        head = source.read(ports.HEAD)
        source.seek(0)
        return attempts.Tries(
            options, machine, _kept(source), "<program>", head, lambda size: None
        ).best()


def defaults() -> argparse.Namespace:
    """The options of `gcomp compensate` as they are by default."""
    parser = argparse.ArgumentParser(add_help=False)
    command.arguments(parser)
    return parser.parse_args([])


def _kept(source: BinaryIO) -> ports.Kept:
    return ports.Kept(source, intake.PROGRAM)


def _text(program: str | bytes | Iterable[str | bytes]) -> BinaryIO:
    """The program in a file without a name."""
    spool = ports.spool()
    for piece in [program] if isinstance(program, str | bytes) else program:
        # bytes of no UTF-8 that came in through str (surrogateescape) go out as they were
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
    "scaling": ("plane", "space"),
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
            # tolerance_um=1 is --tolerance 1um: judged by the same function, with the same
            # sentences
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
