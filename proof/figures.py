"""The three figures of docs/PROOF.md, from the score of a trial alone: python -m proof.figures
proof/trials/<commit>"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from postproc import style
from proof.score_table import wilson

NAMED, TARGET, OTHER, LIGHT = (style.LIGHT[role] for role in ("command", "limit", "still", "rule"))
# rows of the table that are shares with a target, and how they are written beside the bars
SHOWN = {
    "nulls with any name": "nulls with a name",
    "adversarial nulls with any name": "adversarial nulls with a name",
    "one effect, 8 to 16 um: first name right": "one effect, 8 to 16 um",
    "one effect, 4 to 8 um: first name right": "4 to 8 um",
    "one effect, 2 to 4 um: first name right": "2 to 4 um",
    "one effect: right, given that something was named": "right, given a name",
    "pairs and triples: precision": "several: precision",
    "pairs and triples: recall": "several: recall",
    "masked tenfold, 4 to 8 um: first name right": "masked, 4 to 8 um",
    "masked tenfold, 2 to 4 um: first name right": "masked, 2 to 4 um",
    "driver withheld: truth named or in the set": "driver withheld",
    "blind test: the spot is named": "blind spot named",
    "blind test: and its program would show it": "its test would show it",
    "follow-up given: the effect named": "follow-up named",
    "alien physics: called unknown": "alien called unknown",
}


def draw(kept: Path, folder: Path) -> list[Path]:
    """Write proof_names.png, proof_loop.png and proof_methods.png; returns their paths."""
    try:
        import matplotlib
    except ImportError:
        raise SystemExit("figures need matplotlib: pip install 'gcomp[figures]'") from None
    matplotlib.use("Agg")
    from matplotlib import pyplot as plt

    found = json.loads((kept / "score.json").read_text())
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for name, painter in (("names", names), ("loop", loop), ("methods", methods)):
        figure = painter(plt, found)
        paths.append(folder / f"proof_{name}.png")
        figure.savefig(paths[-1], dpi=130, metadata={"Software": None})
        plt.close(figure)
    return paths


def _title(found: dict[str, Any]) -> str:
    sealed = found["commitment"]
    return f"sealed trial of commit {sealed['freeze'][:10]}, {sealed['cases']} cases"


def names(plt, found: dict[str, Any]):
    """Shares with their 95 % intervals, and the targets."""
    lines = [line for line in found["lines"] if line["name"] in SHOWN and line["count"]]
    figure, axes = plt.subplots(figsize=(8.0, 0.34 * len(lines) + 1.3), layout="constrained")
    for k, line in enumerate(lines):
        low, high = wilson(line["hits"], line["count"])
        axes.plot([low, high], [k, k], color=LIGHT, lw=6, solid_capstyle="butt", zorder=1)
        axes.plot(line["value"], k, "o", color=NAMED, ms=6, zorder=3)
        wanted = line["least"] if line["least"] is not None else line["most"]
        axes.plot(wanted, k, "|", color=TARGET, ms=14, mew=2.2, zorder=2)
        axes.text(
            1.02,
            k,
            f"{line['hits']} of {line['count']}",
            va="center",
            fontsize=8,
            transform=axes.get_yaxis_transform(),
        )
    axes.set_yticks(range(len(lines)), [SHOWN[line["name"]] for line in lines], fontsize=9)
    axes.invert_yaxis()
    axes.set(xlim=(-0.02, 1.02), xlabel="share of cases")
    axes.plot([], [], "o", color=NAMED, label="measured")
    axes.plot([], [], color=LIGHT, lw=6, label="95 % interval (Wilson)")
    axes.plot([], [], "|", color=TARGET, ms=12, mew=2.2, label="target")
    figure.legend(loc="outside lower center", ncols=3, fontsize=8, frameon=False)
    axes.set_title(
        f"What was concealed, and how often it was named\n{_title(found)}", fontsize=10, loc="left"
    )
    axes.spines[["top", "right"]].set_visible(False)
    return figure


def loop(plt, found: dict[str, Any]):
    """Largest path error of every case: as it is, with the map, with the diagnosed machine, and
    what the map's own error leaves."""
    cases = sorted(found["loop"], key=lambda x: -x["geometry"])
    figure, axes = plt.subplots(figsize=(8.0, 4.2), layout="constrained")
    for k, x in enumerate(cases):
        axes.plot([k, k], [x["geometry"], x["diagnosed"]], color=LIGHT, lw=2.5, zorder=1)
    at = range(len(cases))
    axes.plot(
        at, [x["uncompensated"] for x in cases], "x", color=OTHER, ms=6, label="program as it is"
    )
    axes.plot(
        at,
        [x["geometry"] for x in cases],
        "s",
        color=TARGET,
        ms=5,
        label="corrected by the map alone",
    )
    axes.plot(
        at,
        [x["diagnosed"] for x in cases],
        "o",
        color=NAMED,
        ms=6,
        label="corrected by the diagnosed machine",
    )
    axes.plot(
        at,
        [x["limit"] for x in cases],
        "_",
        color="black",
        ms=10,
        label="map alone, nothing hidden",
    )
    axes.set_yscale("log")
    axes.set_yticks([1, 2, 5, 10, 20, 50, 100], ["1", "2", "5", "10", "20", "50", "100"])
    axes.set(
        ylabel="largest path error on the true machine, um",
        xlabel="cases that a program can be corrected for, by what the map leaves",
    )
    axes.set_xticks([])
    figure.legend(loc="outside lower center", ncols=4, fontsize=8, frameon=False)
    axes.set_title(f"The loop closed\n{_title(found)}", fontsize=10, loc="left")
    axes.spines[["top", "right"]].set_visible(False)
    return figure


def methods(plt, found: dict[str, Any]):
    """gcomp and the other methods on the same cases."""
    rows = found["baselines"]
    figure, (left, middle, right) = plt.subplots(
        1, 3, figsize=(9.0, 3.0), layout="constrained", sharey=True
    )
    for k, m in enumerate(rows):
        color = NAMED if m["method"] == "gcomp" else OTHER
        for axes, hits, count in (
            (left, m["null_named"], m["nulls"]),
            (middle, m["top"], m["effects"]),
        ):
            if m["names"] and count:
                low, high = wilson(hits, count)
                axes.plot([low, high], [k, k], color=LIGHT, lw=6, solid_capstyle="butt")
                axes.plot(hits / count, k, "o", color=color)
            else:
                axes.text(0.03, k, "gives no names", va="center", fontsize=8, color=OTHER)
        right.plot([m["median"], m["p90"]], [k, k], color=LIGHT, lw=6, solid_capstyle="butt")
        right.plot(m["median"], k, "o", color=color)
        right.plot(m["p90"], k, "d", color=color, ms=5)
    left.set_yticks(range(len(rows)), [m["method"] for m in rows], fontsize=9)
    left.invert_yaxis()
    for axes, text in (
        (left, "nulls with a name"),
        (middle, "first name right"),
        (right, "held-out rms over noise floor"),
    ):
        axes.set_xlabel(text, fontsize=9)
        axes.spines[["top", "right"]].set_visible(False)
    left.set_xlim(-0.03, 1.03)
    middle.set_xlim(-0.03, 1.03)
    right.set_xscale("log")
    right.set_xticks([1, 2, 5, 10, 20], ["1", "2", "5", "10", "20"])
    right.minorticks_off()
    right.axvline(1.0, color="black", lw=0.8, ls=":")
    right.plot([], [], "o", color=OTHER, label="median")
    right.plot([], [], "d", color=OTHER, ms=5, label="90th percentile")
    right.legend(fontsize=7, frameon=False)
    figure.suptitle(
        f"Other methods on the same nulls, singles and masked cases; {_title(found)}",
        fontsize=10,
        x=0.01,
        ha="left",
    )
    return figure


if __name__ == "__main__":
    for path in draw(Path(sys.argv[1]), Path(__file__).resolve().parents[1] / "docs" / "figures"):
        print(path)
