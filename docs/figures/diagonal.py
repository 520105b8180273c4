"""Draws the picture of the README: one G1 over the diagonal of a grinder, as it is and with gcomp.

    pip install -e '.[figures]'
    python docs/figures/diagonal.py

writes diagonal.svg and diagonal.png beside itself, and prints the largest deviations.

The program runs through the same Filter as every other; what it commands is put into the machine's
error model. A deviation is the whole vector from where the program says to where the tool is, at
the same part of the way: 0.1 um along the path counts as much as 0.1 um across it. (`--verify`
measures the distance to the path, never larger.)
"""

from __future__ import annotations

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from postproc.filter import Filter, setup_of
from postproc.machine import places
from postproc.machine.model import Machine
from postproc.nc import dialects
from postproc.style import LIGHT
from postproc.units import TICKS_PER_MM, UM

HERE = Path(__file__).resolve().parent
MACHINE = HERE.parents[1] / "machines" / "studer-s36"
PROGRAM = b"G90 G94 G21 G54\nG0 X0. Z0.\nG1 X340. Z510. F1000.\nM30\n"  # X is a diameter
MAGNIFIED = 2000
SAMPLES = 1021  # one in 0.5 mm of Z
EVERY = 30.0  # mm of Z between two error vectors: the spacing of the measurement
DPI = 112  # 9 inches: 1008 pixels

# Okabe and Ito's colours, which the colour-blind can tell apart; every curve differs in its line
# too.
NOMINAL, PLAIN, ENDS, GCOMP, INK = (
    LIGHT[role] for role in ("nominal", "before", "command", "after", "ink")
)


def commanded(machine: Machine) -> tuple[np.ndarray, np.ndarray, float]:
    """The blocks that the Filter makes of the diagonal, without the take-up on the spot before
    them.

    (2, K + 1) mm, X (radius) and Z of their ends; (K + 1,) the part of the way done there, 0 to 1;
    mm, the tolerance.
    """
    seen = []
    filter_ = Filter(machine, dialects.load(machine.control), setup_of(machine))
    filter_.watchers.append(lambda words, motions, pieces, output, lines: seen.append(pieces))
    filter_.feed(PROGRAM)
    pieces = seen[0]
    mine = (pieces.motion == 1) & ~pieces.take_up
    start, end = pieces.start[:, mine] / TICKS_PER_MM, pieces.end[:, mine] / TICKS_PER_MM
    return (
        np.column_stack([start[:, 0], end]),
        np.append(0.0, np.cumsum(pieces.share[mine])),
        filter_.compensator.tolerance,
    )


def deviations(machine: Machine) -> tuple[np.ndarray, dict[str, np.ndarray], np.ndarray, float]:
    """Every way to program the diagonal, on the machine's model.

    (2, N) mm, nominal X and Z; (2, N) mm for each way, deviation from it; (K + 1,) where gcomp
    cuts; mm, the tolerance.
    """
    block_end, part, tolerance = commanded(machine)
    t = np.linspace(0.0, 1.0, SAMPLES)
    nominal = np.outer([170.0, 510.0], t)
    forward = np.ones_like(nominal)
    command = {
        "plain": nominal,
        "ends": np.outer(block_end[:, 0], 1 - t) + np.outer(block_end[:, -1], t),
        "gcomp": np.stack([np.interp(t, part, row) for row in block_end]),
    }
    return (
        nominal,
        {name: at + machine.deviation(at, forward) - nominal for name, at in command.items()},
        part,
        tolerance,
    )


def paths(
    axes: Axes, nominal: np.ndarray, deviation: dict[str, np.ndarray], part: np.ndarray
) -> None:
    """Nominal and actual paths, deviations magnified."""
    magnified = {name: nominal + MAGNIFIED * d for name, d in deviation.items()}
    step = round(EVERY / 510.0 * (SAMPLES - 1))
    tail, head = nominal[::-1, ::step], magnified["plain"][::-1, ::step]
    axes.plot(
        *nominal[::-1], color=NOMINAL, linewidth=6, solid_capstyle="round", label="nominal path"
    )
    axes.quiver(
        *tail,
        *(head - tail),
        angles="xy",
        scale_units="xy",
        scale=1,
        color=PLAIN,
        alpha=0.55,
        width=0.0022,
        headwidth=5,
        headlength=6,
        zorder=3,
    )
    axes.plot(*magnified["plain"][::-1], color=PLAIN, linewidth=2.2, label="actual, uncompensated")
    axes.plot(
        *magnified["gcomp"][::-1],
        color=GCOMP,
        linewidth=1.8,
        zorder=4,
        label=f"actual, with gcomp ({len(part) - 1} blocks)",
    )
    at = [magnified["gcomp"][i] for i in (1, 0)]
    axes.plot(
        *[np.interp(part, np.linspace(0, 1, SAMPLES), row) for row in at],
        "o",
        color=GCOMP,
        markersize=4.5,
        zorder=5,
    )
    axes.set(
        xlim=(-12, 652), ylim=(-14, 252), xlabel="Z, mm", ylabel="X (radius), mm", aspect="equal"
    )
    axes.set_xticks(np.arange(0, 601, 100))
    axes.set_yticks([0, 50, 100, 150, 200])
    scale = 50 * UM * MAGNIFIED
    axes.plot([500, 500 + scale], [30, 30], color=INK, linewidth=2, marker="|", markersize=8)
    axes.text(500 + scale / 2, 22, "50 µm of deviation", ha="center", va="top", color=INK)
    axes.text(
        0,
        236,
        f"deviations by the measured error map,\nmagnified {MAGNIFIED}×",
        va="top",
        color=INK,
    )
    axes.legend(
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0),
        ncols=3,
        frameon=False,
        borderaxespad=0.2,
        handlelength=1.8,
        columnspacing=1.6,
    )


def sizes(
    large: Axes,
    small: Axes,
    nominal: np.ndarray,
    deviation: dict[str, np.ndarray],
    tolerance: float,
) -> None:
    """Size of the deviation over Z, on two scales."""
    size = {name: np.hypot(*d) / UM for name, d in deviation.items()}
    z = nominal[1]
    large.plot(
        z,
        size["plain"],
        color=PLAIN,
        linewidth=2.2,
        label=f"uncompensated: {size['plain'].max():.1f} µm",
    )
    large.plot(
        z,
        size["ends"],
        color=ENDS,
        linewidth=2.2,
        linestyle=(0, (5, 1.6)),
        label=f"only its ends corrected: {size['ends'].max():.1f} µm",
    )
    for axes in (large, small):
        axes.plot(
            z,
            size["gcomp"],
            color=GCOMP,
            linewidth=1.8,
            label=f"gcomp: {size['gcomp'].max():.2f} µm",
        )
        axes.set(xlim=(-10, 520), xticks=np.arange(0, 511, 60))
    small.fill_between(z, size["gcomp"], color=GCOMP, alpha=0.15, linewidth=0)
    small.plot(z, size["plain"], color=PLAIN, linewidth=2.2)
    small.plot(z, size["ends"], color=ENDS, linewidth=2.2, linestyle=(0, (5, 1.6)))
    small.axhline(tolerance / UM, color=INK, linewidth=1.5, linestyle=(0, (1, 1.5)))
    small.text(
        255,
        tolerance / UM - 0.02,
        f"tolerance {tolerance / UM:g} µm",
        ha="center",
        va="top",
        color=INK,
    )
    large.set(ylim=(-2, 80), yticks=[0, 20, 40, 60, 80])
    large.tick_params(labelbottom=False)
    small.text(16, 0.62, "the same, enlarged", va="center", color=INK)
    small.set(ylim=(-0.02, 0.7), yticks=[0, 0.2, 0.4, 0.6], xlabel="Z, mm")
    large.legend(
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0),
        ncols=3,
        frameon=False,
        borderaxespad=0.2,
        handlelength=2.2,
        columnspacing=1.6,
    )


def main() -> None:
    machine = places.load(str(MACHINE))
    nominal, deviation, part, tolerance = deviations(machine)
    plt.rcParams.update(
        {
            "font.family": "DejaVu Sans",
            "font.size": 11,
            "axes.labelsize": 11,
            "legend.fontsize": 11,
            "axes.titlesize": 12,
            "axes.edgecolor": INK,
            "axes.labelcolor": INK,
            "xtick.color": INK,
            "ytick.color": INK,
            "text.color": INK,
            "axes.spines.top": False,
            "axes.spines.right": False,
            "axes.grid": True,
            "grid.color": LIGHT["grid"],
            "axes.axisbelow": True,
            "svg.hashsalt": "gcomp",
        }
    )
    figure = plt.figure(figsize=(9.0, 8.6), dpi=DPI, facecolor="white")
    frame = {"left": 0.088, "right": 0.985}
    top = figure.add_gridspec(1, 1, top=0.925, bottom=0.495, **frame).subplots()
    large, small = figure.add_gridspec(
        2, 1, top=0.372, bottom=0.066, hspace=0.16, height_ratios=[1.5, 1], **frame
    ).subplots(sharex=True)
    paths(top, nominal, deviation, part)
    sizes(large, small, nominal, deviation, tolerance)
    top.set_title(
        "One G1 over the diagonal of a Studer S-36: X0 Z0 to X340 Z510",
        loc="left",
        pad=30,
        fontweight="bold",
    )
    large.set_title(
        "How far the tool is from where the program says, and the largest on the way",
        loc="left",
        pad=28,
        fontweight="bold",
    )
    figure.text(0.022, 0.22, "deviation, µm", rotation=90, ha="center", va="center")
    figure.savefig(HERE / "diagonal.svg", metadata={"Date": None})
    figure.savefig(HERE / "diagonal.png", dpi=DPI)
    for name, d in deviation.items():
        size = np.hypot(*d) / UM
        print(
            f"{name:6s} largest deviation {size.max():8.3f} um at Z {nominal[1][size.argmax()]:.1f}"
        )
    print(f"{len(part) - 1} blocks, tolerance {tolerance / UM:g} um")


if __name__ == "__main__":
    main()
