"""A TOML document that knows in which line a key stands, so that every complaint can name it."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Any

from postproc import intake
from postproc.errors import MachineError, Place
from postproc.machine.axis_file import text_of
from postproc.records import record

Parts = tuple[str, ...]


class TomlFile:
    """A TOML document that knows in which line a key stands."""

    def __init__(self, path: Path):
        self.path, self.text = path, text_of(path, intake.MACHINE)
        try:
            self.data: dict[str, Any] = intake.toml(self.text)
        except ValueError as error:
            found = re.search(r"line (\d+)", str(error))
            raise MachineError(
                f"not valid TOML: {error}", place=Place(str(path), int(found[1]) if found else 1)
            ) from None

    def line(self, section: str, key: str, index: int = 0) -> int:
        """Line of `key` in `section` ("axes.Z"; in the index-th of several), as good as the layout
        lets us find it."""
        outer = _parts(section)
        wanted = (*outer, key) if key else outer
        fallback = 0
        for number, here, count, name in self._entries():
            if here == outer and count != index:
                continue
            # [axes.X] may also stand as `X = { ... }` below [axes], and its keys as `axes.X.travel`
            path = (*here, *name)
            if path[: len(wanted)] == wanted:
                return number
            if outer and path[: len(outer)] == outer:
                fallback = fallback or number
        around, _, own = section.rpartition(".")
        return fallback or (self.line(around, own) if around else 1)

    def _entries(self) -> Iterator[tuple[int, Parts, int, Parts]]:
        """Line, section, which of several of that name, and key (none of the section itself)."""
        # tomllib tells values without their lines. So the text is read once more, by its layout,
        # and only when something is wrong: a heading, or `key =` at the start of a line. Keys that
        # a multi-line value holds may be taken for keys of the section: then a line beside the
        # right one is named.
        here: Parts = ()
        counts = Counter({here: 1})
        for number, line in enumerate(intake.lines_of(self.text), 1):
            if header := re.match(r"\s*\[+\s*([^\]]+?)\s*\]+", line):
                here = _parts(header[1])
                counts[here] += 1
                yield number, here, counts[here] - 1, ()
            elif key := re.match(r"\s*(.+?)\s*=", line):
                yield number, here, counts[here] - 1, _parts(key[1])

    @property
    def top(self) -> Section:
        """What stands before the first section."""
        return Section(self, "", self.data)

    def section(self, name: str, data: Any = None) -> Section:
        """[name], empty where it is missing; data: what it holds, where it lies in another one.
        Raises MachineError where it is none."""
        data = self.data.get(name, {}) if data is None else data
        if not isinstance(data, dict):
            raise self.top.fault(name, f"{name} = {data!r} must be a section [{name}]")
        return Section(self, name, data)

    def sections(self, name: str, what: str) -> list[Section]:
        """All [[name]]; what: they are called in messages."""
        entries = self.data.get(name, [])
        if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
            raise self.top.fault(name, f"{what} are sections [[{name}]], with two brackets")
        return [Section(self, name, entry, i) for i, entry in enumerate(entries)]


def _parts(key: str) -> Parts:
    """The parts of a dotted key, without quotes and blanks: axes and X of `axes . "X"`."""
    return tuple(part.strip("\"'") for part in re.findall(r"""".*?"|'.*?'|[^.\s]+""", key))


@record
class Section:
    """A section of a document. name: "axes.Z", "" for what stands before the first; data: its keys;
    index: which of several [[name]]. All that is not as it must be is a MachineError with its
    line."""

    toml: TomlFile
    name: str
    data: dict[str, Any]
    index: int = 0

    def __contains__(self, key: str) -> bool:
        return key in self.data

    def __getitem__(self, key: str) -> Any:
        return self.data[key]

    def get(self, key: str, default: Any = None) -> Any:
        """The value of a key, or `default` where it is missing; of any kind."""
        return self.data.get(key, default)

    def fault(self, key: str, message: str, advice: str = "") -> MachineError:
        """The error to raise at a key."""
        line = self.toml.line(self.name, key, self.index)
        return MachineError(message, advice, Place(str(self.toml.path), line))

    def check_keys(self, known: Collection[str]) -> None:
        """Raises MachineError, with its line, for a key that is not among the known ones."""
        for key in self.data:
            if key not in known:
                raise self.fault(
                    key,
                    f"{key!r} is not a key of [{self.name or 'machine'}]",
                    f"keys: {', '.join(sorted(known))}",
                )

    def number(
        self, key: str, default: float | None = None, at: str = "", of: dict[str, Any] | None = None
    ) -> float:
        """A finite number. at: the key of the table in which it stands, whose line is named; of:
        that table, where it is another one."""
        data = self.data.get(at, {}) if at else self.data
        value = (data if of is None else of).get(key, default)
        if value is None:
            raise self.fault(at or key, f"{key} is missing in [{self.name}]")
        if not intake.finite(value):
            raise self.fault(at or key, f"{key} = {value!r} is not a number")
        return float(value)

    def string(self, key: str, default: str | None = None) -> str:
        """A text. Raises MachineError where it is missing and has no default, or is none."""
        value = self.data.get(key, default)
        if not isinstance(value, str):
            message = f"{key} = {value!r} is not a text" if key in self else f"{key} is missing"
            raise self.fault(key, message)
        return value

    def flag(self, key: str) -> bool:
        """true or false; false where it is missing."""
        value = self.data.get(key, False)
        if not isinstance(value, bool):
            raise self.fault(key, f"{key} = {value!r} is neither true nor false")
        return value

    def span(self, key: str, value: Any) -> tuple[float, float]:
        """Two ascending numbers."""
        good = isinstance(value, list) and len(value) == 2 and all(map(intake.finite, value))
        if not good or value[0] >= value[1]:
            raise self.fault(key, f"{key} = {value!r} must be two ascending numbers, mm")
        return float(value[0]), float(value[1])

    def own(self, key: str, name: str) -> Path:
        """A file of its folder. Raises MachineError for one that lies elsewhere: a machine comes
        from a stranger as well, and may name no other file of this computer."""
        # links are followed first: a name that looks harmless may lead out by one
        path = intake.inside(self.toml.path.parent, name)
        if path is None:
            raise self.fault(
                key,
                f"{key} = {name!r} leads out of the machine's folder",
                "copy the file into the folder, and name it without a path",
            )
        return path
