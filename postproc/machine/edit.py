"""A machine.toml with another name and further sections; comments, order and spacing of what stands there stay as they are."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

import tomlkit
from tomlkit.items import AoT, Table


def with_sections(
    text: str,
    name: str,
    key: str,
    sections: Sequence[tuple[Mapping[str, Any], str]],
    note: str = "",
) -> str:
    """The text under another name, with a section [[key]] for each of `sections`: its entries, and a comment behind them ("":
    none). note: a comment before the first of them."""
    document = tomlkit.parse(text)
    document["name"] = name
    entries = document.get(key)
    if not isinstance(entries, AoT):
        entries = tomlkit.aot()
    for k, (section, comment) in enumerate(sections):
        entries.append(_table(section, comment, note if k == 0 else ""))
    if sections:
        _separated(document)
        document[key] = entries
    return re.sub(r"\n{3,}(\[\[|$)", r"\n\n\1", tomlkit.dumps(document)).rstrip("\n") + "\n"


def _table(section: Mapping[str, Any], comment: str, note: str) -> Table:
    table = tomlkit.table()
    if note:
        table.add(tomlkit.comment(note))
    for key, value in section.items():
        if isinstance(value, Mapping):
            inner = tomlkit.inline_table()
            inner.update(value)
            value = inner
        table.add(key, value)
    if comment:
        table.add(tomlkit.comment(comment))
    table.add(tomlkit.nl())
    return table


def _separated(document: tomlkit.TOMLDocument) -> None:
    """What is appended begins with a line of its own, behind an empty one."""
    text = tomlkit.dumps(document)
    if not text.endswith("\n"):
        document.add(tomlkit.nl())
    if not text.endswith("\n\n"):
        document.add(tomlkit.nl())
