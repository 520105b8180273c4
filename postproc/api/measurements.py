"""Recordings: read, evaluated by ISO 230, made a machine of, and compared with one."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from postproc import intake, ports
from postproc.api.machines import machine_of
from postproc.commands import as_json
from postproc.errors import UsageError
from postproc.machine.model import Machine
from postproc.recordings import ReadingOptions, Recording, Source, read_all

if TYPE_CHECKING:
    from postproc.calibrate.calibration import Calibration
    from postproc.diagnose.answer import Diagnosis
    from postproc.iso import Result


def read_recordings(path: str | Path, format: str = "", **options: Any) -> list[Recording]:
    """All recordings of a file, one at least. format: its name (`gcomp recordings --list`), where
    the file does not show it.

    options: what the file leaves open, the fields of `ReadingOptions`: axis, component, unit,
    bidirectional, first, layout, columns, others, machine, strict, extra, head. Raises GcompError
    with the line of what can not be read.
    """
    return read_all(
        Source(str(path), ports.read_whole(Path(path), intake.RECORDING)),
        format,
        replace(ReadingOptions(), **options),
    )


def read_recording(path: str | Path, format: str = "", **options: Any) -> Recording:
    """The one recording of a file, as `read_recordings`. Raises UsageError where it holds
    several."""
    found = read_recordings(path, format, **options)
    if len(found) > 1:
        names = ", ".join(str(r.head.get("component", r.kind)) for r in found)
        raise UsageError(
            f"{path} holds {len(found)} recordings: {names}",
            "component=... names one; read_recordings reads all",
        )
    return found[0]


@dataclass(frozen=True)
class Evaluated:
    """Tests of the ISO 230 series. text: the tables that `gcomp iso` prints; left_out: what was not
    evaluated; details: the results, in mm and rad, whose fields may change."""

    text: str
    left_out: tuple[str, ...]
    data: dict[str, Any] = field(repr=False)
    details: list[Result] = field(repr=False)

    def to_json(self) -> str:
        """As JSON, format gcomp-iso/1."""
        return as_json.text(self.data)


def evaluate(
    recordings: Iterable[Recording],
    line: str = "least-squares",
    leads: Mapping[str, float] | None = None,
) -> Evaluated:
    """Evaluate recordings as ISO 230 does, as `gcomp iso`. line: reference line of straightness and
    squareness; leads: mm of the screw by axis, "" for any axis. Raises GcompError where a recording
    is for none of its tests."""
    from postproc.iso import Options, choose, report

    found, left = choose.results(list(recordings), Options(line, dict(leads or {})))
    return Evaluated(report.text(found, left), tuple(left), report.as_json(found, left), found)


@dataclass(frozen=True)
class Diagnosed:
    """What the machine's model leaves out. verdict: "left-out-physics", "nothing-left-out" or
    "unknown"; effects: accepted ones as EFFECT:AXIS; text: what `gcomp diagnose` prints; details:
    all of it, whose fields may change."""

    verdict: str
    effects: tuple[str, ...]
    text: str
    data: dict[str, Any] = field(repr=False)
    details: Diagnosis = field(repr=False)

    def to_json(self) -> str:
        """As JSON, format gcomp-diagnosis/1 (docs/DIAGNOSIS.md)."""
        return as_json.text(self.data)

    def save_report(self, path: str | Path, overwrite: bool = False) -> Path:
        """Write the page with figures that `gcomp diagnose --report` writes."""
        from postproc.pages import diagnosis

        return ports.write_new(path, diagnosis.page(self.details).html().encode("utf-8"), overwrite)


def diagnose(
    recordings: Sequence[str | Path],
    machine: Machine | str | Path,
    held_out: str = "",
    compensated: bool = False,
    told: Callable[[str], None] = lambda word: None,
) -> Diagnosed:
    """Compare recordings with the machine's model, as `gcomp diagnose`.

    recordings: files of one experiment, of any format. held_out: "run=3", the run that takes no
    part in naming. compensated: recorded with a corrected program, readings against its nominal
    targets (a head that says so does without): then what the map has left is looked at. told:
    called with a word on each step, since a search may take a minute. Raises GcompError for what
    can not be compared.
    """
    from postproc import recordings as formats
    from postproc.commands.diagnose import corrected
    from postproc.diagnose import report
    from postproc.diagnose.analysis import Options
    from postproc.diagnose.analysis import diagnose as analysed
    from postproc.simulate.program import without_errors

    model = machine_of(machine)
    sources = [
        Source(str(path), ports.read_whole(Path(path), intake.RECORDING)) for path in recordings
    ]
    read = [formats.read(source, options=ReadingOptions(strict=False)) for source in sources]
    model = without_errors(model) if corrected(read, compensated) else model
    found = analysed(read, model, Options(held_out=held_out, progress=told))
    answer = report.of_files(found, {s.name: s.sha256 for s in sources})
    names = tuple(f.block.key for f in found.findings if f.status == "accepted")
    return Diagnosed(found.verdict, names, report.as_text(found), answer, found)


@dataclass(frozen=True)
class Calibrated:
    """A machine made of recordings. text: the table that `gcomp calibrate` prints; files: name to
    text of the machine's folder; details: all of it, whose fields may change."""

    text: str
    files: dict[str, str] = field(repr=False)
    data: dict[str, Any] = field(repr=False)
    details: Calibration = field(repr=False)

    def to_json(self) -> str:
        """As JSON, format gcomp-calibration/1."""
        return as_json.text(self.data)

    def save(self, folder: str | Path, overwrite: bool = False) -> Path:
        """Write the machine's folder in one step, read again before it has its name; the old one
        stays beside it as .bak. Raises UsageError where one stands and `overwrite` is not set."""
        from postproc.commands.calibrate import write_folder

        write_folder(Path(folder), self.files, overwrite)
        return Path(folder)


def calibrate(
    recordings: Iterable[Recording],
    like: str | Path | None = None,
    *,
    name: str = "unnamed",
    title: str = "",
    chain: str | None = None,
    control: str | None = None,
    travel: Mapping[str, tuple[float, float]] | None = None,
    least_increment_mm: float | None = None,
    **options: Any,
) -> Calibrated:
    """Make a machine of recordings of single axes, as `gcomp calibrate`; `save` writes it.

    like: a machine from which is taken what machines of a kind share. chain: who carries whom,
    "w-b-Z-X-t"; travel: mm by axis. options: further options of the command by their names with _
    for -, with values as the command reads them, like datum=["Z=0"] or mean=True. Raises UsageError
    naming what is missing, GcompError for recordings that fit nothing.
    """
    from postproc.calibrate import folder, report
    from postproc.calibrate.run import calibrate as reckoned
    from postproc.commands import calibrate as command

    said = _defaults(command)
    for key in options:
        if not hasattr(said, key):
            raise TypeError(f"gcomp calibrate has no option {key!r}")
    # Options as the command line would have made them, so that there is one set of rules for both.
    said.__dict__.update(options, title=title or None, chain=chain, control=control, output=name)
    said.travel, said.least_increment = list((travel or {}).items()), least_increment_mm
    copied = command.like_of(str(like) if like else None)
    head, axes, decided = command.machine_of(said, copied)
    found = reckoned(list(recordings), decided)
    return Calibrated(
        report.table(found), folder.folder(found, head, axes), report.data(found), found
    )


def _defaults(command: Any) -> argparse.Namespace:
    parser = argparse.ArgumentParser(add_help=False)
    command.arguments(parser)
    return parser.parse_args(["-"])
