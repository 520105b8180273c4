"""Tables of places beside real programs: where the program, as it is and written out, first differs
from them."""

from __future__ import annotations

import csv
from pathlib import Path

from postproc.errors import BlockFault, GcompError
from postproc.units import TICKS_PER_MM
from tests.corpus.laws import whole
from tests.corpus.machines import Machines
from tests.corpus.programs import ROTARY, XYZ, Program
from tests.corpus.run import make_filter, output

# The tables were made with this one's axes where another program of its folder leaves them.
TABLE_BEGINS = {"sinumerik/increment.mpf": {"Y": 900.0}}


def table_of(program: Program) -> list[tuple[float, ...]] | None:
    """The places X Y Z A B C, each other than the one before, that a table beside the program says
    it reaches."""
    stem = program.path.with_suffix("")
    path = next(
        (p for p in (stem.with_suffix(".csv"), Path(f"{stem}_raw.csv")) if p.exists()), None
    )
    if path is None:
        return None
    begin = TABLE_BEGINS.get(program.name, {})
    with path.open(newline="", encoding="utf-8") as file:
        rows = [
            tuple(float(row.get(x) or begin.get(x, 0.0)) for x in XYZ + ROTARY)
            for row in csv.DictReader(file)
        ]
    return _changing(program, rows)


def places_of(
    machines: Machines, program: Program, text: bytes, expand: bool
) -> list[tuple[float, ...]]:
    """The same, as the program takes the machine there. Raises GcompError or BlockFault where it is
    refused."""
    filter_ = make_filter(machines.zero(), program, start=TABLE_BEGINS.get(program.name))
    plain = b"".join(output(filter_, text, expand))
    target = whole(filter_, plain).target / TICKS_PER_MM
    rows = [filter_.machine.letters.index(x) for x in XYZ + ROTARY]
    return _changing(program, [tuple(map(float, place[rows])) for place in target.T])


def _changing(program: Program, rows: list[tuple[float, ...]]) -> list[tuple[float, ...]]:
    begin = TABLE_BEGINS.get(program.name, {})
    found: list[tuple[float, ...]] = [tuple(begin.get(x, 0.0) for x in XYZ + ROTARY)]
    for row in rows:
        if max(abs(a - b) for a, b in zip(row, found[-1], strict=True)) > 1e-4:
            found.append(row)
    return found


def table_fault(machines: Machines, program: Program) -> str:
    """Where the places of a program, as it is and written out, first differ from those of its
    table; "" if nowhere, if there is no table, or if the program is refused."""
    table = table_of(program)
    for expand in (False, True) if table else ():
        try:
            found = places_of(machines, program, program.text, expand)
        except (GcompError, BlockFault):
            continue
        how = "written out" if expand else "as it is"
        for number, (a, b) in enumerate(zip(found, table, strict=False)):
            if max(abs(x - y) for x, y in zip(a, b, strict=True)) > 1e-3:
                return f"{how}, place {number} is {a}, the table says {b}"
        if len(found) != len(table):
            return f"{how}, {len(found)} places, the table has {len(table)}"
    return ""
