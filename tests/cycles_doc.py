"""The table of words in docs/CYCLES.md, made of what the cycles declare: `python -m
tests.cycles_doc` writes it."""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

from postproc.nc import codes, dialects
from postproc.nc.cycles import family
from postproc.nc.cycles.words import GENERAL, Form

DOC = Path(__file__).resolve().parents[1] / "docs" / "CYCLES.md"
TITLE = "## Every word of every cycle\n"
NAMES = (
    "linuxcnc",
    "fanuc-mill",
    "haas",
    "fanuc-lathe-a",
    "fanuc-lathe",
    "fanuc-lathe-c",
    "haas-lathe",
    "siemens",
    "grblhal",
    "heidenhain-iso",
    "fagor",
    "okuma",
    "okuma-lathe",
)
HEAD = f"""{TITLE}
Generated from the declarations in `postproc/nc/cycles` by `python -m tests.cycles_doc`;
`tests/expand/test_words.py` reads it. {" ".join(GENERAL)}, comments and `/` mean here what
they mean in any block. Every letter that a row does not name stops the program by its name, and so
does one that stands twice. *Kept*: this cycle has no use for it, one behind it has. *Known*: the
control has it, gcomp refuses it, and the sentence says so; *(0)*, *(1)*: unless its value is 0, or
1. *axes*: the other axes of the machine, on lathes with U V W H beside them.

| cycle | written | followed | kept | known, refused |
|---|---|---|---|---|
"""
CURVES = (
    50,
    51,
    52,
    53,
    62,
)  # G5 to G5.3, G6.2: several blocks are one curve; their words: tests/expand/test_splines.py
WHOLE = "refused, but where its hole bends by less than the tolerance: "
STAYS = "the block stays as it is written, with all its words"


class Row(NamedTuple):
    """One way to write cycles: the codes that are written so, by dialect."""

    form: Form
    codes: dict[str, list[int]]


def rows() -> list[Row]:
    """All ways to write a cycle that is declared."""
    found: list[Row] = []
    for name in NAMES:
        for code, cycle in sorted(family(dialects.load(name)).cycles.items()):
            if code in CURVES:
                continue
            for form in cycle.forms(code):
                row = next((r for r in found if r.form == form), None)
                if row is None:
                    found.append(row := Row(form, {}))
                row.codes.setdefault(name, []).append(code)
    return sorted(found, key=lambda r: (r.form.stays, bool(r.form.never)))


def passed_on() -> dict[str, list[str]]:
    """Cycles that nobody has written out, by dialect: they stay."""
    found = {}
    for name in NAMES:
        dialect, written = dialects.load(name), family(dialects.load(name))
        known = [
            c
            for c in dialect.codes
            if c.does in ("drill", "tap") or c.refuses in (codes.CYCLE, codes.WRITE_OUT)
        ]
        rest = [c.word for c in known if codes.code_number(c.word) not in written.codes]
        if rest:
            found[name] = rest
    return found


def text() -> str:
    """The section as it stands in the page."""
    lines = [_line(row) for row in rows()]
    lines += [
        f"| `{name}` {' '.join(words)} | | {STAYS} | | |\n" for name, words in passed_on().items()
    ]
    return HEAD + "".join(lines)


def _line(row: Row) -> str:
    form = row.form
    where: dict[str, list[str]] = {}
    for name, numbers in row.codes.items():
        where.setdefault(" ".join(f"G{n / 10:g}" for n in numbers), []).append(f"`{name}`")
    cycles = "; ".join(f"{' '.join(names)} {words}" for words, names in where.items())
    if form.stays or form.never:
        refused = (WHOLE if form.whole else "refused: ") + form.never
        return f"| {cycles} | | {STAYS if form.stays else refused} | | |\n"
    takes = _meanings(form.takes) + (", *axes*" if form.axes else "")
    refused = "; ".join(
        f"{x}{' (0)' * (x in form.zero)}{' (1)' * (x in form.one)}: {m}"
        for x, m in form.refused.items()
    )
    return f"| {cycles} | {form.name} | {takes} | {_meanings(form.keeps)} | {refused} |\n"


def _meanings(words: dict[str, str]) -> str:
    """Letters with what they mean, those of one meaning together."""
    by: dict[str, list[str]] = {}
    for letter, meaning in words.items():
        by.setdefault(meaning, []).append(letter)
    return ", ".join(f"{' '.join(letters)} {meaning}" for meaning, letters in by.items())


def page(old: str) -> str:
    """The whole page with the section written anew: up to the next heading."""
    before, _, rest = old.partition(TITLE)
    after = re.search(r"(?m)^## ", rest)
    return before + text() + ("\n" + rest[after.start() :] if after else "")


if __name__ == "__main__":
    DOC.write_text(page(DOC.read_text()))
