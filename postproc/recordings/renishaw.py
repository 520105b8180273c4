"""Renishaw laser text of readings at targets: .rtl linear, .rta angular, .rts straightness.

Sections headed by capitals and `::`. TARGET DATA:: has Target-count and the targets, some to a
line, up to Flags:; RUNS:: has Run-count; DEVIATIONS:: has rows of run, target number, deviation, in
any order. The layout is known from public readers and writers of such files, not from the maker:
unverified against original files. By these readers targets are in mm (degrees of a rotary axis),
linear deviations in um, angular ones in mm/m; of straightness none says it.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from postproc import intake
from postproc.errors import Place
from postproc.recordings import Fault, ReadingOptions, Recording, RecordingError, Source
from postproc.recordings import _components as components
from postproc.recordings import _environment as environment
from postproc.recordings import _targets as targets
from postproc.recordings import _text as text
from postproc.recordings._units import UNITS, Unit

TITLE = "Renishaw laser text (.rtl linear, .rta angular, .rts straightness)"
TAKES = ("axis", "component", "unit", "bidirectional", "first", "others", "machine", "head")
EXTRA = {"decimal": ". or ,: the decimal sign, where the file has both"}
# GBK first: cp1252 takes nearly any bytes, and nothing would be left for it
ENCODINGS = ("gbk", "cp1252")
#     HEADER::
#     ...
#     TARGET DATA::
#     Target-count: 3
#     Targets :
#     0.0 50.0
#     100.0
#     Flags: 0 0 2 0
#     RUNS::
#     Run-count: 2
#     DEVIATIONS::
#     Run Target Data:
#     1 1 0.2               run, number of the target from 1, deviation
#     2 3 -0.1
#     EOF::
SECTION = re.compile(r"([A-Z][A-Z -]*)::\s*")
ROW = re.compile(r"([0-9]{1,6})\s+([0-9]{1,6})\s+(\S+)")
KINDS = {"rtl": "displacement", "rta": "angle", "rts": "straightness"}
WORDS = {"linear": "displacement", "angular": "angle", "straight": "straightness"}
UNIT_OF = {"displacement": "um", "angle": "mm/m"}
FLAGS = {"0 0 2 0": True, "0 1 2 0": False}  # as one public writer of such files has them
LISTS = {("TARGET DATA", "targets"): "targets", ("DEVIATIONS", "run target data"): "rows"}
MOST = 100_000  # runs or targets


@dataclass
class _File:
    """What stands in the sections. section, list_of: where the reading is, and in which list."""

    keys: dict[tuple[str, str], tuple[str, int]] = field(default_factory=dict)
    environment: list[tuple[str, str]] = field(default_factory=list)
    targets: list[tuple[str, int]] = field(default_factory=list)
    rows: list[tuple[int, str]] = field(default_factory=list)
    sections: dict[str, int] = field(default_factory=dict)
    last: int = 1
    section: str = ""
    list_of: str = ""

    def take(self, line: int, plain: str) -> None:
        """A line that is not blank. Targets are collected up to the first line that is no numbers:
        their count is not trusted."""
        self.last = line
        if heading := SECTION.fullmatch(plain):
            self.section, self.list_of = heading[1].strip(), ""
            self.sections.setdefault(self.section, line)
        elif self.list_of == "targets" and ":" not in plain:
            self.targets += [(word, line) for word in plain.split()]
        elif self.list_of == "rows":
            self.rows.append((line, plain))
        elif ":" in plain:
            self._take_key(line, *plain.split(":", 1))

    def _take_key(self, line: int, key: str, value: str) -> None:
        """A line of key: value, which may begin a list."""
        name = " ".join(key.lower().split())
        self.list_of = LISTS.get((self.section, name), "")
        if self.list_of == "targets":
            self.targets += [(word, line) for word in value.split()]
        elif self.section == "ENVIRONMENT":
            self.environment.append((key, value))
        elif not self.list_of:
            self.keys.setdefault((self.section, key.strip().lower()), (value.strip(), line))

    def key(self, section: str, name: str) -> str:
        return self.keys.get((section, name), ("", 0))[0]

    def line(self, section: str, name: str = "") -> int:
        return self.keys[(section, name)][1] if name else self.sections.get(section, self.last)


def recognises(source: Source) -> bool:
    head = source.data[:20_000]
    return b"HEADER::" in head[:200] and b"TARGET DATA::" in head


def read(source: Source, options: ReadingOptions) -> Recording:
    """Raises RecordingError for a file that is cut off or contradicts itself, and where unit or
    axis are open."""
    content, notices = text.decoded(source, ENCODINGS)
    found = _sections(content)
    for section in ("TARGET DATA", "DEVIATIONS"):
        if section not in found.sections:
            raise source.fault(
                found.last,
                f"there is no section {section}::",
                "is the file cut off, or of another kind?",
            )
    if "EOF" not in found.sections:
        notices.append("there is no EOF:: at the end: the file may be cut off")
    decimal = _decimal(source, found, options, notices)
    places = _places(source, found, decimal, options, notices)
    runs = _count(source, found, "RUNS", "Run-count")
    rows, faults = _rows(source, found, decimal, options, len(places), runs)
    _missing(found, rows, len(places), runs, faults, notices)

    quantity = _quantity(source, found, options)
    component = components.component_of(
        options, source, components.axis_in(found.key("USER-TEXT", "axis")), quantity,
        found.line("USER-TEXT"),
    )  # fmt: skip
    said = _usual_unit(options, component, notices)
    unit = components.unit_for(options, source, component, said, found.line("DEVIATIONS"))
    columns, noted, more = environment.taken(found.environment)
    if options.bidirectional is None and runs != 1:
        _notice_flags(found, notices)
    readings = _readings(rows, places, columns)
    head = {
        "machine": found.key("USER-TEXT", "machine"),
        "instrument": "Renishaw laser interferometer",
        "serial_number": found.key("USER-TEXT", "serial no"),
        "date": found.key("USER-TEXT", "date"),
        "operator": found.key("USER-TEXT", "by"),
        "location": found.key("USER-TEXT", "location"),
        "environment": noted or None,
    }
    first = 1 if places[-1] >= places[0] else -1
    return targets.recording(
        source, options, component, unit, readings, head, [*notices, *more], faults, first
    )


def _usual_unit(
    options: ReadingOptions, component: components.Component, notices: list[str]
) -> Unit | None:
    """The unit that other readers take, with a notice; None: --unit says it, or there is none."""
    if options.unit or component.quantity not in UNIT_OF:
        return None
    said = UNITS[UNIT_OF[component.quantity]]
    notices.append(
        f"the unit is not in the file: taken as {said.name}, as other readers of this format do"
        " (--unit)"
    )
    return said


def _readings(
    rows: dict[tuple[int, int], tuple[float, int]], places: list[float], columns: dict[str, float]
) -> targets.Readings:
    """places: mm, of the targets by number; columns: temperatures, the same for all."""
    return targets.Readings(
        [r for r, _ in rows], [places[k - 1] for _, k in rows], [v for v, _ in rows.values()],
        [i for _, i in rows.values()], columns={n: [v] * len(rows) for n, v in columns.items()},
    )  # fmt: skip


def _notice_flags(found: _File, notices: list[str]) -> None:
    """A notice where the flags mean one direction."""
    flags = " ".join(found.key("TARGET DATA", "flags").split())
    if FLAGS.get(flags) is False:
        notices.append(
            f"Flags: {flags} means one direction in one public writer of this format:"
            " --bidirectional no?"
        )


def _sections(content: str) -> _File:
    """The lines by section."""
    found = _File()
    for i, line in enumerate(intake.lines_of(content), 1):
        if plain := line.strip():
            found.take(i, plain)
    return found


def _decimal(source: Source, found: _File, options: ReadingOptions, notices: list[str]) -> str:
    cells = [(line, word) for word, line in found.targets]
    cells += [(line, row.split()[-1]) for line, row in found.rows]
    decimal, more = text.decimal_of(source, cells, text.stated_decimal(options.extra))
    notices += more
    return decimal


def _count(source: Source, found: _File, section: str, name: str) -> int:
    """A count that the file states; 0 where it does not."""
    if (section, name.lower()) not in found.keys:
        return 0
    value, line = found.keys[(section, name.lower())]
    if not re.fullmatch(r"[0-9]{1,6}", value) or not 0 < int(value) <= MOST:
        raise source.fault(line, f"{name} is {value!r}: that is not a whole number from 1 on")
    return int(value)


def _places(source, found, decimal, options, notices) -> list[float]:
    """The targets, mm."""
    result = []
    for word, line in found.targets:
        value = text.number(word if decimal == "," else word.rstrip(","), decimal)
        if value is None:
            raise source.fault(line, f"the target {word!r} is not a number")
        result.append(value)
    if not result:
        raise source.fault(
            found.line("TARGET DATA"), "there are no targets", "they stand below Targets :"
        )
    stated = _count(source, found, "TARGET DATA", "Target-count")
    if stated and stated != len(result):
        at = Place(source.name, found.line("TARGET DATA", "target-count"))
        message = f"Target-count is {stated}, and {len(result)} targets stand below it"
        if options.strict:
            raise RecordingError(
                message, "mend the count or the list; --lenient takes the list as it stands", at
            )
        notices.append(f"line {at.line}: {message}: the list is taken as it stands")
    return result


def _rows(
    source, found, decimal, options, n_targets, runs
) -> tuple[dict[tuple[int, int], tuple[float, int]], list[Fault]]:
    """(run, target number) to deviation and line: the order of the rows says nothing."""
    rows: dict[tuple[int, int], tuple[float, int]] = {}
    faults: list[Fault] = []
    for line, row in found.rows:
        words = ROW.fullmatch(row)
        value = text.number(words[3], decimal) if words else None
        if words is None or value is None:
            wrong = f"{row[:60]!r} is not a run, a target's number and a deviation"
        else:
            place = int(words[1]), int(words[2])
            wrong = _wrong_place(*place, runs, n_targets, rows)
            if not wrong:
                rows[place] = (value, line)
        if wrong:
            fault = Fault(line, "Run Target Data", wrong)
            faults.append(source.unusable(fault, options.strict, row))
    if not rows:
        raise source.fault(
            found.line("DEVIATIONS"), "there are no deviations", "they stand below Run Target Data:"
        )
    return rows, faults


def _wrong_place(run: int, target: int, runs: int, n_targets: int, rows) -> str:
    """What is wrong with the numbers of a run and of a target; "": nothing. runs: 0 where the file
    does not say; rows: those before."""
    if run < 1 or (runs and run > runs):
        return f"run {run}, and the runs are 1 to {runs or MOST}"
    if not 1 <= target <= n_targets:
        return f"target number {target}, and the targets are 1 to {n_targets}"
    if (run, target) in rows:
        first = rows[(run, target)][1]
        return f"run {run} has target {target} twice: here and in line {first}"
    return ""


def _missing(found, rows, n_targets, runs, faults, notices) -> None:
    """A fault for each reading that is not there, and one notice."""
    if not runs:
        runs = max(run for run, _ in rows)
        notices.append(f"Run-count is not stated: {runs} runs, as the rows number them")
    # a mistyped Run-count of 100,000 would list millions of readings one by one
    if runs * n_targets > 10 * len(rows) + 1000:
        notices.append(
            f"{len(rows)} readings of {runs} runs x {n_targets} targets: the rest is missing"
        )
        return
    gone = [
        (r, k) for r in range(1, runs + 1) for k in range(1, n_targets + 1) if (r, k) not in rows
    ]
    line = found.line("DEVIATIONS")
    faults += [Fault(line, f"run {r} target {k}", "the reading is missing") for r, k in gone]
    if gone:
        some = ", ".join(f"run {r} target {k}" for r, k in gone[:4]) + ", ..." * (len(gone) > 4)
        notices.append(f"{len(gone)} of {runs} x {n_targets} readings are missing: {some}")


def _quantity(source: Source, found: _File, options: ReadingOptions) -> str:
    """What the file's kind says was measured, or nothing; --component overrules words in the
    file."""
    ending = source.name.rpartition(".")[2].lower()
    if ending in KINDS:
        return KINDS[ending]
    if options.component:
        return ""
    words = " ".join(
        found.key(section, name).lower()
        for section, name in (
            ("HEADER", "file type"),
            ("TARGET DATA", "filetype"),
            ("HEADER", "owner"),
        )
    )
    hits = {q for word, q in [*KINDS.items(), *WORDS.items()] if word in words}
    return hits.pop() if len(hits) == 1 else ""
