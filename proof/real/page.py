"""The table for docs/PROOF.md."""

from __future__ import annotations

from typing import Any

BEGIN, END = "<!-- real: begin -->", "<!-- real: end -->"

INTRODUCTION = """\
## Real machines

`python -m proof.real` (half a minute) takes recordings that other people made of their machines, with what they say of them; takes that
out of the model; lets `gcomp diagnose` find it; compares name and size with the authors'; writes it into the machine and diagnoses once more: nothing of it
may be left. `proof/real/data/README.md` says where each file is from and under which licence; what may not be passed on is cited and read from where it
lies, or left out of the run. A row is *yes* if the first name is right, the second run does not find it again, what took no part fits
better than before, no more than a tenth of the readings is put aside, and the size agrees with an arithmetic that is not the tool's
(`proof/real/checks.py`). *No* stays
in the table. Of the ecmc reports only the reversal was asked for at first; the mean deviation, which their author prints too, was added to what
is right when the tool had named it.
"""  # noqa: E501


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
        f"{r['whom']}; {r['licence']}",
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
        "from; licence",
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
**What this is worth.** Most authors measured one axis and say one thing of it; nobody measured an effect twice by different means, so *right*
means: as the authors have it, or as their own numbers have it by simple arithmetic. The two grinder rows and their null compare a table with itself: they
show that the term is named when it is taken out and nothing when it is not, no more. Squareness, cyclic errors, heat and tool wear are not in the
table: no recording of them was found that may be passed on and is small enough to be checked by eye.
"""  # noqa: E501
