"""Results as a plain table for a person and as JSON for a program. What is not defined is "-" there
and null here."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from postproc.iso import Result
from postproc.iso.causes import Causes
from postproc.units import UM, URAD

FORMAT = "gcomp-iso/1"
MOST = 4  # digits after the point
WORDS = {"target", "n +", "n -", "run", "samples"}
CHUNK = 400  # rows of a table per target that are printed


def text(results: Sequence[Result], left: Sequence[str] = ()) -> str:
    """All results as plain text."""
    parts = ["\n".join(_lines(r)) for r in results]
    if left:
        parts.append("\n".join(["left out", *(f"  {line}" for line in left)]))
    return "\n\n".join(parts)


def as_json(results: Sequence[Result], left: Sequence[str] = ()) -> dict[str, Any]:
    """The results as plain dictionaries: numbers in the unit that a key names, null where not
    defined."""
    return {"format": FORMAT, "results": [_object(r) for r in results], "left_out": list(left)}


def decimals(result: Result) -> int:
    """One more digit than the noise has: 2 for a scatter of 0.3 um, 1 for 2 um."""
    noise = result.noise / scale(result)
    # 1e-9: log10 of 0.1 may lie a hair below -1
    return min(MOST, max(0, 1 - math.floor(math.log10(noise) + 1e-9))) if noise > 0 else MOST


def scale(result: Result) -> float:
    """mm or rad of one unit of the numbers shown."""
    return URAD if result.unit == "urad" else UM


def number(value: float | None, digits: int) -> str:
    """A number with so many digits after the point, never a negative zero; "-" where there is
    none."""
    if value is None or not math.isfinite(value):
        return "-"
    # round(-0.001, 2) is -0.0, and -0.0 + 0.0 is 0.0: a sign of nothing would look measured
    return f"{round(value, digits) + 0.0:.{digits}f}"


def _lines(result: Result) -> list[str]:
    digits, unit = decimals(result), scale(result)
    out = [
        f"{result.standard}  {result.test}  {result.subject}",
        f"  {', '.join(result.files)}",
        f"  {result.chosen}",
        "",
    ]
    rows = [["", result.unit, "U (k=2)", "of it runs", ""]]
    for p in result.parameters:
        shown = [None if v is None else v / unit for v in (p.value, p.U, p.runs)]
        said = ", ".join(filter(None, (p.means, p.at)))
        rows.append([p.name, *(number(v, digits) for v in shown), said])
    out += aligned(rows, left=(0, 4))
    if result.terms:
        out += ["", f"  in U, k = 1, {result.unit}"]
        rows = []
        for t in result.terms:
            acts = _acts(t.of, result)
            rows.append([t.name, number(t.u / unit, digits + 1), f"{t.said}; on {acts}"])
        out += aligned(rows, left=(0, 2))
    if result.columns:
        out += ["", *aligned(_cells(result, digits), left=())]
    if result.causes:
        out += [
            "",
            "  what makes it out of round, of each alone; % of the sum",
            *aligned(cause_rows(result.causes), left=(0, 3, 4)),
        ]
    return out + [""] * bool(result.notices) + [f"  note: {n}" for n in result.notices]


def cause_rows(causes: Causes) -> list[list[str]]:
    """Name, um, percent, size with U, and what + means, of each cause, the largest first; then what
    none explains."""
    rows = [
        [
            c.name,
            f"{c.range / UM:.2f}",
            f"{100 * c.share:.0f} %",
            f"{c.size:+.4g} +- {c.U:.2g} {c.unit}",
            f"+: {c.positive}",
        ]
        for c in causes.ranked
    ]
    return [
        *rows,
        [
            "rms before, rms that none of these explains",
            f"{causes.whole / UM:.2f}",
            f"{causes.left / UM:.2f}",
            "um",
            "",
        ],
    ]


def _acts(of: frozenset[str], result: Result) -> str:
    # "all" of those that have a value: a term that acts on a parameter without one is not told
    names = [p.name for p in result.parameters if p.name in of and p.value is not None]
    known = [p.name for p in result.parameters if p.value is not None]
    return "all" if names == known else ", ".join(names) or "nothing"


def _cells(result: Result, digits: int) -> list[list[str]]:
    names = list(result.columns)
    rows = [names]
    for row in list(zip(*result.columns.values(), strict=True))[:CHUNK]:
        rows.append(
            [
                (
                    f"{v:.7g}"
                    if n in WORDS and not isinstance(v, str)
                    else v
                    if isinstance(v, str)
                    else number(v, digits)
                )
                for n, v in zip(names, row, strict=True)
            ]
        )
    return rows


def aligned(rows: Sequence[Sequence[str]], left: tuple[int, ...], indent: str = "  ") -> list[str]:
    """Columns of one width, those numbered in `left` to the left, the others to the right."""
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    return [
        indent
        + "  ".join(
            c.ljust(w) if i in left else c.rjust(w)
            for i, (c, w) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in rows
    ]


def _object(result: Result) -> dict[str, Any]:
    unit = scale(result)

    def sized(value: float | None) -> float | None:
        return None if value is None or not math.isfinite(value) else value / unit

    return {
        "test": result.test,
        "standard": result.standard,
        "subject": result.subject,
        "chosen": result.chosen,
        "unit": result.unit,
        "files": list(result.files),
        "parameters": {
            p.name: {
                "value": sized(p.value),
                "U": sized(p.U),
                "U_runs": sized(p.runs),
                "means": p.means,
                "at": p.at,
            }
            for p in result.parameters
        },
        "terms": [
            {"name": t.name, "u": sized(t.u), "of": sorted(t.of), "said": t.said}
            for t in result.terms
        ],
        "columns": {
            n: [v if not isinstance(v, float) or math.isfinite(v) else None for v in c]
            for n, c in result.columns.items()
        },
        "notices": list(result.notices),
        "causes": (
            None
            if result.causes is None
            else {
                "ranked": [
                    {
                        "name": c.name,
                        "size": c.size,
                        "U": c.U,
                        "unit": c.unit,
                        "positive": c.positive,
                        "range_um": c.range / UM,
                        "U_range_um": c.U_range / UM,
                        "share": c.share,
                    }
                    for c in result.causes.ranked
                ],
                "left_rms_um": result.causes.left / UM,
                "rms_um": result.causes.whole / UM,
            }
        ),
    }
