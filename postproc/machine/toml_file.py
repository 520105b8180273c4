"""A TOML document that knows in which line a key stands, so that every complaint can name it."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from postproc import intake
from postproc.errors import MachineError, Place
from postproc.machine.axis_file import text_of


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
        fallback = 0
        for number, here, count, name in self._entries():
            if not name and here == f"{section}.{key}".lstrip("."):
                return number
            if (here, count) == (section, index):
                if name == key:
                    return number
                fallback = fallback if name else number
        outer, _, name = section.rpartition(".")
        return fallback or (self.line(outer, name) if outer else 1)

    def _entries(self) -> Iterator[tuple[int, str, int, str]]:
        """Line, section, which of several of that name, and key ("" of the section itself)."""
        here, counts = "", Counter({"": 1})
        for number, line in enumerate(self.text.splitlines(), 1):
            if header := re.match(r"\s*\[+\s*([^\]]+?)\s*\]+", line):
                here = header[1].replace('"', "")
                counts[here] += 1
                yield number, here, counts[here] - 1, ""
            elif key := re.match(r'\s*"?(.+?)"?\s*=', line):
                yield number, here, counts[here] - 1, key[1]

    def fault(
        self, section: str, key: str, message: str, advice: str = "", index: int = 0
    ) -> MachineError:
        return MachineError(message, advice, Place(str(self.path), self.line(section, key, index)))

    def table(self, key: str) -> dict[str, Any]:
        """A section, empty where it is missing."""
        value = self.data.get(key, {})
        if not isinstance(value, dict):
            raise self.fault("", key, f"{key} = {value!r} must be a section [{key}]")
        return value

    def check_keys(self, section: str, data: dict, known: set[str], index: int = 0) -> None:
        for key in data:
            if key not in known:
                where = f"[{section or 'machine'}]"
                raise self.fault(
                    section,
                    key,
                    f"{key!r} is not a key of {where}",
                    f"keys: {', '.join(sorted(known))}",
                    index,
                )

    def number(
        self,
        section: str,
        data: dict,
        key: str,
        default: float | None = None,
        at: str = "",
        index: int = 0,
    ) -> float:
        """A finite number; `at`: the key whose line to name, where this one stands inside a table
        of its own."""
        value = data.get(key, default)
        if value is None:
            raise self.fault(section, at or key, f"{key} is missing in [{section}]", index=index)
        if not intake.finite(value):
            raise self.fault(section, at or key, f"{key} = {value!r} is not a number", index=index)
        return float(value)

    def string(
        self, section: str, data: dict, key: str, default: str | None = None, index: int = 0
    ) -> str:
        value = data.get(key, default)
        if not isinstance(value, str):
            message = f"{key} = {value!r} is not a text" if key in data else f"{key} is missing"
            raise self.fault(section, key, message, index=index)
        return value

    def own(self, section: str, key: str, name: str, index: int = 0) -> Path:
        """A file of its folder. Raises MachineError for one that lies elsewhere: a machine comes
        from a stranger as well, and may name no other file of this computer."""
        path = intake.inside(self.path.parent, name)
        if path is None:
            raise self.fault(
                section,
                key,
                f"{key} = {name!r} leads out of the machine's folder",
                "copy the file into the folder, and name it without a path",
                index,
            )
        return path
