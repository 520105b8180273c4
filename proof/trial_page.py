"""A score as the part of docs/PROOF.md that stands between two marks."""

from __future__ import annotations

from typing import Any

from proof.score_table import HEAD, wilson


def block(found: dict[str, Any]) -> str:
    """Markdown: which trial, the table, the methods beside it, the loop by effect."""
    sealed, leak = found["commitment"], found["leak"]
    counts = ", ".join(f"{n} {tier}" for tier, n in sealed["tiers"].items())
    parts = [
        f"Trial of commit `{sealed['freeze'][:10]}`: {sealed['cases']} cases ({counts}).  ",
        (
            f"SHA-256 of the cases `{sealed['cases_sha256'][:16]}...`, of the salted truth"
            f" `{sealed['truth_sha256'][:16]}...`, of the answers"
            f" `{sealed['first_sha256'][:16]}...`; in full, with every outcome, in"
            " `proof/trials/`.  "
        ),
        (
            f"Metadata alone told null from single in {leak['right']} of {leak['count']} cases"
            f" ({leak['interval'][0]:.2f} to {leak['interval'][1]:.2f}; chance is 0.50):"
            f" {'no leak seen' if leak['at_chance'] else '**a leak**'}."
        ),
        "",
        _rows(HEAD, [line["cells"] for line in found["lines"]]),
        "Other methods on the same nulls, singles and masked cases:",
        "",
        _rows(
            (
                "method",
                "nulls named",
                "first name right",
                "held out over noise: median",
                "90th percentile",
            ),
            [_method(m) for m in found["baselines"]],
        ),
        "Largest path error of a test program on the true machine, um (medians):",
        "",
        _rows(
            (
                "hidden",
                "cases",
                "as it is",
                "map alone",
                "diagnosed",
                "nothing hidden",
                "diagnosed / map alone",
            ),
            _loops(found["loop"]),
        ),
    ]
    for failed in found["loop_failed"]:
        parts.append(f"Not followed: {failed}\n")
    return "\n".join(parts)


def _rows(head: tuple[str, ...], rows: list[list[str]]) -> str:
    return (
        "\n".join("| " + " | ".join(r) + " |" for r in [list(head), ["---"] * len(head), *rows])
        + "\n"
    )


def _method(m: dict[str, Any]) -> list[str]:
    if not m["names"]:
        return [
            m["method"],
            "gives no names",
            "gives no names",
            f"{m['median']:.2f}",
            f"{m['p90']:.2f}",
        ]
    low, high = wilson(m["top"], m["effects"])
    share = f"{m['top']} of {m['effects']} ({low:.2f} to {high:.2f})"
    return [
        m["method"],
        f"{m['null_named']} of {m['nulls']}",
        share,
        f"{m['median']:.2f}",
        f"{m['p90']:.2f}",
    ]


def _loops(loops: list[dict[str, Any]]) -> list[list[str]]:
    by: dict[str, list[dict[str, Any]]] = {}
    for x in loops:
        by.setdefault(x["truth"][0].partition(":")[0], []).append(x)
    rows = [[name, *_medians(by[name])] for name in sorted(by)]
    return [*rows, ["all", *_medians(loops)]] if loops else rows


def _medians(loops: list[dict[str, Any]]) -> list[str]:
    def middle(key: str) -> float:
        ordered = sorted(x[key] for x in loops)
        return (ordered[(len(ordered) - 1) // 2] + ordered[len(ordered) // 2]) / 2

    return [
        str(len(loops)),
        *(f"{middle(k):.1f}" for k in ("uncompensated", "geometry", "diagnosed", "limit")),
        f"{middle('ratio'):.2f}",
    ]


def rewritten(page: str, text: str, begin: str, end: str) -> str:
    """The page with `text` between the marks. Raises ValueError where they are not there once
    each."""
    if page.count(begin) != 1 or page.count(end) != 1 or page.index(begin) > page.index(end):
        raise ValueError(f"the page must hold {begin} and then {end}, once each")
    return page[: page.index(begin) + len(begin)] + "\n" + text + page[page.index(end) :]
