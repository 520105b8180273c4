"""The text of a machine folder, as file.py reads it: machine.toml with a comment where a number
needs its source, and the CSV table of an axis; `Z_uncertainty.csv` has the same form, and a further
table tells the runs behind each value.

Writes no file. Numbers are given in the units of the format, deviations to 0.1 nm and 0.1 nrad.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from postproc import toml_text as toml
from postproc.machine.chain import LINEAR

DECIMALS = 4
FIRST = ("format", "name", "title", "control", "chain", "diameter", "reversal", "source", "signs")
NESTED = ("axes", "squareness")  # what they hold by a name is a section of its own
# what a machine takes of the axis of one that it is like: nothing that was measured
KEPT = ("travel", "least_increment", "max_velocity", "max_acceleration", "max_jerk", "centre")
SECTIONS = ("axes", "squareness", "location", "tool", "offsets", "limits", "effect")


def _rank(order: Sequence[str]) -> Callable[[str], int]:
    """A key for sorting: in this order, all others behind as they come."""
    rank = {key: i for i, key in enumerate(order)}
    return lambda key: rank.get(key, len(rank))


def machine_toml(data: Mapping[str, Any], comments: Mapping[str, str]) -> str:
    """machine.toml. data: as TOML reads it; comments: dotted key ("axes.Z.travel", or "" for the
    top of the file) to what stands behind it. Keys keep their order within the order of the
    format."""
    lines = [f"# {toml.comment(line)}" for line in comments.get("", "").splitlines()]
    plain = [k for k in data if not _is_section(data[k])]
    lines += [toml.entry(k, data[k], comments.get(k, "")) for k in sorted(plain, key=_rank(FIRST))]
    sections = [k for k in data if _is_section(data[k])]
    for key in sorted(sections, key=_rank(SECTIONS)):
        for section in _sections(key, data[key], comments):
            lines += ["", *section]
    return "\n".join(lines) + "\n"


def _sections(key: str, value: Any, comments: Mapping[str, str]) -> list[list[str]]:
    """The lines of a section and of those below it, or of each of a list."""
    if isinstance(value, list):
        return [[f"[[{key}]]", *(toml.entry(k, v, "") for k, v in part.items())] for part in value]
    below = {k: part for k, part in value.items() if key in NESTED and isinstance(part, Mapping)}
    own = {k: value[k] for k in value if k not in below}
    # no heading [axes] of its own, since every axis has one; [squareness] has angles beside
    # [squareness.u]
    found = [_section(key, own, comments)] * (key != "axes")
    return found + [
        _section(f"{key}.{toml.key(name)}", part, comments) for name, part in below.items()
    ]


def axis_table(
    letter: str, nodes: np.ndarray, columns: Mapping[str, np.ndarray], comments: Iterable[str] = ()
) -> str:
    """`Z.csv`. columns: name with unit and direction ("EZZ_um_fwd") to (K,) values in that unit;
    comments: lines above."""
    position = f"{letter}_mm" if letter in LINEAR else f"{letter}_deg"
    lines = [f"# {toml.comment(c)}" for c in comments] + [",".join([position, *columns])]
    for k, node in enumerate(nodes):
        lines.append(
            ",".join(
                [number(float(node), 6), *(number(float(c[k]), DECIMALS) for c in columns.values())]
            )
        )
    return "\n".join(lines) + "\n"


def runs_table(letter: str, rows: Iterable[Mapping[str, Any]], comments: Iterable[str] = ()) -> str:
    """`Z_runs.csv`: a row for every value that stands behind the axis table. rows: the columns
    below by name; None and NaN are left empty. No reader of machines needs it."""
    position = f"{letter}_mm" if letter in LINEAR else f"{letter}_deg"
    names = (position, "component", "approach", "unit", "runs", "mean", "s", "value", "u", "U95")
    lines = [f"# {toml.comment(c)}" for c in comments] + [",".join(names)]
    for row in rows:
        cells = []
        for name in names:
            value = row.get(name)
            if isinstance(value, float):
                cells.append(
                    "" if np.isnan(value) else number(value, 6 if name == position else DECIMALS)
                )
            else:
                cells.append("" if value is None else str(value))
        lines.append(",".join(cells))
    return "\n".join(lines) + "\n"


def number(value: float, decimals: int) -> str:
    """Without the zeros that say nothing, and without a minus before nothing."""
    text = f"{value:.{decimals}f}"
    text = text.rstrip("0").rstrip(".") if "." in text else text
    # -0.00004 um would be written -0, which reads as a sign that was measured
    return "0" if text in ("-0", "") else text


def _is_section(value: Any) -> bool:
    return isinstance(value, Mapping) or (
        isinstance(value, list) and bool(value) and isinstance(value[0], Mapping)
    )


def _section(name: str, data: Mapping[str, Any], comments: Mapping[str, str]) -> list[str]:
    return [f"[{name}]"] + [
        toml.entry(key, value, comments.get(f"{name}.{key}", "")) for key, value in data.items()
    ]
