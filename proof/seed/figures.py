"""Three figures of the story, as PNG."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from postproc.diagnose.answer import Diagnosis
from postproc.style import LIGHT
from proof.seed.experiment import X, Z, table
from proof.seed.suspects import column, sizes


def draw(d: Diagnosis, folder: Path) -> list[Path]:
    """Raises ImportError without matplotlib."""
    import matplotlib

    matplotlib.use("agg")
    import matplotlib.pyplot as plt

    plt.rcParams["axes.prop_cycle"] = plt.cycler(
        color=[LIGHT[role] for role in ("plus", "minus", "after", "limit", "still")]
    )
    place = np.array([float(row["x_mm"]) for row in table(X)])
    jump = next(f for f in d.findings if f.block.name == "shared_jump")
    ratio, start = jump.value["ratio"], jump.value["from_mm"]
    outside = place < start
    straight, along = column(X, "dzx_avg_mm"), column(X, "dxx_avg_mm")
    off = [
        y - np.polyval(np.polyfit(place[outside], y[outside], 1), place) for y in (straight, along)
    ]
    paths = [folder / f"seed_{name}.png" for name in ("jump", "reversal", "parts")]

    figure, plots = plt.subplots(1, 2, figsize=(11, 4))
    plots[0].plot(place, off[0], "o-", label="straightness, in Z")
    plots[0].plot(place, off[1], "s-", label="positioning, in X")
    plots[0].plot(place, ratio * off[0], "k:", label=f"{ratio:.3f} times the straightness")
    plots[0].axvspan(start, place[-1], color=LIGHT["open"], alpha=0.2)
    plots[0].set(
        xlabel="X, mm",
        ylabel="departure from the line before, um",
        title="Two measurements, one jump",
    )
    plots[0].legend()
    plots[1].plot(place, off[1] - ratio * off[0], "o-")
    plots[1].set(xlabel="X, mm", ylabel="um", title="What one ratio leaves of the positioning")
    _save(plt, figure, paths[0])

    figure, plots = plt.subplots(1, 2, figsize=(11, 4))
    z = np.array([float(row["z_mm"]) for row in table(Z)])
    plots[0].plot(
        place,
        column(X, "dxx_forward_mm") - column(X, "dxx_reverse_mm"),
        "o-",
        label="X, positioning",
    )
    plots[0].plot(
        place,
        column(X, "dzx_forward_mm") - column(X, "dzx_reverse_mm"),
        "s-",
        label="X, straightness",
    )
    plots[0].axvline(90, color=LIGHT["limit"], ls=":", label="the slip at 90 mm")
    plots[0].set(xlabel="X, mm", ylabel="forward minus reverse, um", title="Reversal of X")
    plots[0].legend()
    plots[1].plot(z, column(Z, "dzz_forward_mm") - column(Z, "dzz_reverse_mm"), "o-")
    plots[1].set(xlabel="Z, mm", title="Reversal of Z")
    _save(plt, figure, paths[1])

    figure, plot = plt.subplots(figsize=(7, 4))
    said = sizes()
    labels = {
        "pockets": "tool, by the pockets",
        "boss": "tool, by the boss",
        "holes": "hole distances: no tool in them",
    }
    for i, (name, label) in enumerate(labels.items()):
        plot.bar(np.arange(2) + 0.25 * i - 0.25, said[name], 0.22, label=label)
    plot.set(
        xticks=[0, 1],
        xticklabels=["part 1", "part 2"],
        ylabel="too large by, um",
        title="Table 7.3",
    )
    plot.legend(loc="upper center", bbox_to_anchor=(0.5, -0.08), ncols=3, fontsize=8, frameon=False)
    _save(plt, figure, paths[2])
    return paths


def _save(plt, figure, path: Path) -> None:
    figure.tight_layout()
    figure.savefig(path, dpi=100, metadata={"Software": None})
    plt.close(figure)
