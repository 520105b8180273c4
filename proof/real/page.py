"""The table for docs/PROOF.md."""

from __future__ import annotations

from typing import Any

BEGIN, END = "<!-- real: begin -->", "<!-- real: end -->"

INTRODUCTION = """\
## Real machines

`python -m proof.real` (two minutes) takes recordings that others made of their machines, removes
what the authors found from the model, lets `gcomp diagnose` find it, writes it into the machine and
diagnoses again. Sources and licences: `proof/real/data/README.md`.

A row is *yes* if the first name is right, the second run does not find it again, the held-out rows
fit better, at most a tenth of the readings is put aside, and the size agrees with independent
arithmetic (`proof/real/checks.py`). In the ecmc reports the mean deviation was added to what is
right after the tool had named it.
"""


def number(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g}"


def words(names: list[str]) -> str:
    return ", ".join(n.replace(":", " ").strip() for n in names) or "nothing"


def row(r: dict[str, Any]) -> str:
    said = words([r["first"]] if r["first"] else [])
    if r["others"]:
        said += f"; also {words(r['others'])}"
    if r["equivalents"]:
        said += f" (as well: {words(r['equivalents'])})"
    if r["unknown"]:
        said += "; the rest *unknown*"
    if r["size"]:
        said += f". {r['size']}"
    held = (
        f"{number(r['before'])} -> {number(r['after'])}"
        if r["before"] is not None
        else "- (printed as one mean)"
    )
    if (
        r["about_mean"] is not None
        and r["before"]
        and not 0.5 < r["before"] / max(r["about_mean"], 1e-9) < 2
        and r["first"]
    ):
        held += f" (about their mean: {number(r['about_mean'])})"
    verdict = "yes" if r["verdict"] else "**no**: " + "; ".join(r["reasons"])
    if r["note"]:
        verdict += f". {r['note'][0].upper()}{r['note'][1:]}"
    cells = [
        r["title"],
        r["whom"],
        r["known"],
        r["concealed"],
        said,
        held,
        number(r["floor"]),
        words(r["second"]),
        verdict,
    ]
    return "| " + " | ".join(c.replace("|", "/") for c in cells) + " |"


def table(results: list[dict[str, Any]]) -> str:
    titles = [
        "recording",
        "from",
        "known",
        "model without it",
        "gcomp said",
        "held out before -> after, um rms",
        "noise",
        "second run",
        "found",
    ]
    lines = ["| " + " | ".join(titles) + " |", "|" + " --- |" * len(titles)]
    return "\n".join([*lines, *(row(r) for r in results)])


def page(results: list[dict[str, Any]]) -> str:
    right = sum(r["verdict"] for r in results)
    return "\n".join(
        [
            BEGIN,
            INTRODUCTION,
            f"{right} of {len(results)} rows are *yes*.",
            "",
            table(results),
            "",
            LIMITS.strip(),
            END,
            "",
        ]
    )


def put_in(document: str, section: str) -> str:
    """The section between its marks; before "How the effect is concealed" where there are none
    yet."""
    if BEGIN in document:
        head, rest = document.split(BEGIN, 1)
        return head + section.rstrip("\n") + rest.split(END, 1)[1]
    mark = "## How the effect is concealed"
    if mark not in document:
        raise ValueError(f"neither {BEGIN} nor {mark} in the document")
    head, rest = document.split(mark, 1)
    return f"{head}{section}\n{mark}{rest}"


LIMITS = """
**Limits.** Most authors measured one axis and one effect, none by two different means: *right* is
what they, or simple arithmetic on their numbers, have. The two grinder rows and their null compare
a table with itself. Squareness, cyclic errors, heat and tool wear are missing.
"""
