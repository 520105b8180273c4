"""Ways to damage a recording: text in, text out."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np

Change = Callable[[str], str]


def split(text: str) -> tuple[list[str], list[str], list[list[str]]]:
    """Lines of the head, names of the columns, cells of the rows."""
    lines = text.splitlines()
    k = next(i for i, line in enumerate(lines) if line.startswith("run,"))
    return lines[:k], lines[k].split(","), [line.split(",") for line in lines[k + 1 :]]


def joined(head: list[str], names: list[str], rows: list[list[str]]) -> str:
    return "\n".join([*head, ",".join(names), *(",".join(row) for row in rows)]) + "\n"


def cells(name: str, change: Callable[[str, int], str]) -> Change:
    """A column, cell by cell: change(cell, row)."""

    def done(text: str) -> str:
        head, names, rows = split(text)
        i = names.index(name)
        for k, row in enumerate(rows):
            row[i] = change(row[i], k)
        return joined(head, names, rows)

    return done


def times(factor: float, *columns: str) -> Change:
    def done(text: str) -> str:
        for name in columns:
            text = cells(name, lambda v, k: f"{float(v) * factor:.9g}")(text)
        return text

    return done


def all_of(value: str, *columns: str) -> Change:
    def done(text: str) -> str:
        for name in columns:
            text = cells(name, lambda v, k: value)(text)
        return text

    return done


def one(name: str, value: str, row: int = 5) -> Change:
    return cells(name, lambda v, k: value if k == row else v)


def rows(change: Callable[[list[list[str]]], list[list[str]]]) -> Change:
    def done(text: str) -> str:
        head, names, every = split(text)
        return joined(head, names, change(every))

    return done


def without(*columns: str) -> Change:
    def done(text: str) -> str:
        head, names, every = split(text)
        keep = [i for i, name in enumerate(names) if name not in columns]
        return joined(head, [names[i] for i in keep], [[row[i] for i in keep] for row in every])

    return done


def shuffled(*columns: str) -> Change:
    """The rows in another order, or of some columns only."""

    def done(text: str) -> str:
        head, names, every = split(text)
        order = np.random.default_rng(0).permutation(len(every))
        if not columns:
            return joined(head, names, [every[k] for k in order])
        for name in columns:
            i = names.index(name)
            for row, value in zip(every, [every[k][i] for k in order], strict=True):
                row[i] = value
        return joined(head, names, every)

    return done


def backwards(name: str) -> Change:
    """One column upside down."""

    def done(text: str) -> str:
        head, names, every = split(text)
        i = names.index(name)
        for row, value in zip(every, [row[i] for row in every][::-1], strict=True):
            row[i] = value
        return joined(head, names, every)

    return done


def head(key: str, value: str | None) -> Change:
    """Another value of a key, or none."""

    def done(text: str) -> str:
        changed = re.sub(
            rf"(?m)^# {key} = .*\n", "" if value is None else f"# {key} = {value}\n", text, count=1
        )
        assert changed != text
        return changed

    return done
