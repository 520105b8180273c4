"""A machine.toml with another name and further sections; comments, order, spacing and line ends of
what stands there stay as they are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import tomlkit
from tomlkit.items import Array, InlineTable, Table

Section = tuple[Mapping[str, Any], str]  # its entries, and a comment to it ("": none)


def with_sections(
    text: str, name: str, key: str, sections: Sequence[Section], note: str = ""
) -> str:
    """The text under another name, with a section [[key]] for each of `sections` behind all that
    stands there. note: a comment to the first of them. Where the entries stand as a list
    (`key = [{...}]`) they become lines of that list: TOML lets no [[key]] stand beside it."""
    document = tomlkit.parse(text)
    document["name"] = name
    listed = document.get(key)
    # new sections go behind all that stands there, as text: nothing of it moves
    if isinstance(listed, Array):
        _lengthen(listed, sections, note)
        made = tomlkit.dumps(document)
    else:
        made = tomlkit.dumps(document)
        for k, section in enumerate(sections):
            # a section needs no empty line before it in TOML; people do
            made += _gap(made) + _table(key, section, note if k == 0 else "")
    return _line_ends(made, text)


def _table(key: str, section: Section, note: str) -> str:
    """[[key]] and its entries."""
    entries, comment = section
    table = tomlkit.table()
    if note:
        table.add(tomlkit.comment(note))
    _fill(table, entries)
    if comment:
        table.add(tomlkit.comment(comment))
    return f"[[{key}]]\n{table.as_string()}"


def _lengthen(listed: Array, sections: Sequence[Section], note: str) -> None:
    """The sections as lines of a list, each behind its comments."""
    for k, (entries, comment) in enumerate(sections):
        for said in (note if k == 0 else "", comment):
            if said:
                listed.add_line(comment=said, add_comma=False)
        line = tomlkit.inline_table()
        _fill(line, entries)
        listed.add_line(line)
    if sections and not listed.as_string().removesuffix("]").endswith("\n"):
        listed.add_line(indent="", add_comma=False)


def _fill(table: Table | InlineTable, entries: Mapping[str, Any]) -> None:
    for key, value in entries.items():
        if isinstance(value, Mapping):
            inner = tomlkit.inline_table()
            inner.update(value)
            value = inner
        table.add(key, value)


def _gap(text: str) -> str:
    """What is wanting to an empty line behind the text."""
    plain = text.replace("\r\n", "\n")
    return "" if plain.endswith("\n\n") else "\n" if plain.endswith("\n") else "\n\n"


def _line_ends(made: str, text: str) -> str:
    """Those of the text, where all of its lines end alike."""
    if "\r\n" not in text or text.count("\n") != text.count("\r\n"):
        return made
    return made.replace("\r\n", "\n").replace("\n", "\r\n")
