"""Figures of a diagnosis: what is left along position, direction and time; what each effect does; before and after; the map.

Blue came from below (approach +), red from above, grey from nowhere in particular; gold rings are the region that stands out; green took no
part in naming or fitting; the grey band holds 95 % of the noise.
"""

from __future__ import annotations

import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from postproc.diagnose import words
from postproc.diagnose.answer import Diagnosis, floor
from postproc.diagnose.summary import UM, middle, rms, scaled

SIDES = ((1, "tab:blue", "approached in +"), (-1, "tab:red", "approached in -"), (0, "tab:gray", "no direction"))
DRAWN = 3000  # points of a signal: more can not be told apart
DENSE = 400  # points: beyond it they are drawn as pixels, and the page stays small
FEW = 200  # points: they are drawn larger
FEWEST = 8  # readings of a figure
STYLE: Any = {
    "savefig.dpi": 160,
    "svg.hashsalt": "gcomp",
    "svg.fonttype": "none",
    "font.size": 9,
    "font.family": "sans-serif",
}
RINGS = {"marker": "o", "ls": "", "ms": 9, "color": "gold", "alpha": 0.5, "zorder": 1}


def figures(d: Diagnosis) -> Iterator[tuple[str, str]]:
    """(caption, svg) of everything there is to be drawn. Raises ImportError without matplotlib."""
    import matplotlib

    matplotlib.use("svg")
    with matplotlib.rc_context(STYLE):
        if d.held.any():
            yield _before_after(d)
        if d.findings:
            yield _shares(d)
        if d.unknown and len(d.unknown.cells) > 1:
            yield _map(d)
        for signal in np.unique(d.rows.signal):
            which = np.flatnonzero(d.rows.signal == signal)
            if len(which) >= FEWEST and d.rows.sees[which[0]] != "part":
                yield _left(d, int(signal), which)
        if np.any(d.rows.sees == "part"):
            yield _features(d)
        for k in range(len(d.findings)):
            if np.any(d.findings[k].contribution[d.rows.sees != "part"]):  # of parts the features say it
                yield _contribution(d, k)


def _name(d: Diagnosis, signal: int) -> str:
    first = int(np.flatnonzero(d.rows.signal == signal)[0])
    return f"{Path(d.recordings[int(d.rows.file[first])].file).name}, {d.rows.signals[signal]}"


def _axis(d: Diagnosis, which: np.ndarray) -> str:
    """The axis that moves most."""
    return max(d.rows.state.position, key=lambda x: float(np.ptp(d.rows.state.position[x][which])))


def _times(d: Diagnosis, which: np.ndarray) -> tuple[np.ndarray, str]:
    """When rows were read; where nobody wrote it down, which came first."""
    time = d.rows.state.time[which]
    if np.ptp(time) > 0:
        return time, "time, s"
    return np.arange(1.0, len(which) + 1), "number of the reading (no times were recorded)"


def _thin(which: np.ndarray) -> tuple[np.ndarray, str]:
    if len(which) <= DRAWN:
        return which, ""
    return which[np.linspace(0, len(which) - 1, DRAWN).astype(int)], f"; {DRAWN} of {len(which)} readings are drawn"


def _pixels(plots, points: int) -> None:
    """Many points as an image."""
    if points > DENSE:
        for line in (line for plot in plots for line in plot.lines):
            line.set_rasterized(True)


def _left(d: Diagnosis, signal: int, which: np.ndarray) -> tuple[str, str]:
    """Before and after, along position, direction and time."""
    import matplotlib.pyplot as plt

    axis = _axis(d, which)
    scale, unit = scaled(d, signal)
    band = 1.96 * float(np.median(d.sigma[which])) * scale
    which, thinned = _thin(which)
    place, (time, when_said) = d.rows.state.position[axis][which], _times(d, which)
    side, held = np.sign(d.rows.state.approach[axis][which]), d.held[which]
    region = np.zeros(len(which), bool)
    for found in (p for p in d.places if p.signal == signal and p.axis == axis):
        own = (place >= found.low) & (place <= found.high)
        region |= own & (True if found.approach == "both" else side == (1 if found.approach == "+" else -1))
    size = 3 if len(which) > FEW else 6
    figure, plots = plt.subplots(2, 3, figsize=(12, 6), sharey=True, width_ratios=(5, 1.4, 5))
    for row, (values, label) in enumerate(((d.before, "before"), (d.after, "after"))):
        y = values[which] * scale
        at, ways, when = plots[row]
        if row == 0 and region.any():
            at.plot(place[region], y[region], **RINGS, label="stands out")
            when.plot(time[region], y[region], **RINGS)
        for k, (way, colour, name) in enumerate(SIDES):
            some = side == way
            if some.any():
                at.plot(place[some], y[some], ".", ms=size, color=colour, label=name)
                ways.plot(k + np.linspace(-0.25, 0.25, int(some.sum())), y[some], ".", ms=2, color=colour, alpha=0.4)
                ways.plot([k - 0.4, k + 0.4], [y[some].mean()] * 2, color="black", lw=1.5)
        when.plot(time[~held], y[~held], ".", ms=size, color="tab:gray", label="fitted")
        if held.any():
            when.plot(time[held], y[held], ".", ms=size, color="tab:green", label="held out")
        at.set_ylabel(f"{label}: measured - model, {unit}")
        ways.set_xticks([k for k, (way, _, _) in enumerate(SIDES) if np.any(side == way)])
        ways.set_xticklabels([s for s, (way, _, _) in zip("+-0", SIDES, strict=True) if np.any(side == way)])
        for plot in plots[row]:
            plot.axhspan(-band, band, color="0.9", zorder=0)
            plot.tick_params(labelleft=plot is at)
    plots[1, 0].set_xlabel(f"position of {axis}, mm")
    plots[1, 1].set_xlabel(f"direction of {axis}")
    plots[1, 2].set_xlabel(when_said)
    for column in (0, 2):
        plots[0, column].legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=4, fontsize=8, frameon=False)
    _pixels(plots.flat, len(which))
    figure.tight_layout()
    return (
        f"{_name(d, signal)}: what the machine's file leaves (above) and what is left with the effects found (below), along the position "
        f"of {axis}, by its direction (black: the mean) and in time; grey: 95 % of the noise{thinned}",
        _svg(figure),
    )


def _features(d: Diagnosis) -> tuple[str, str]:
    """Features of parts, before and after."""
    import matplotlib.pyplot as plt

    signals = [int(s) for s in np.unique(d.rows.signal[d.rows.sees == "part"])]
    figure, plot = plt.subplots(figsize=(12, 1.4 + 0.32 * len(signals)))
    for k, signal in enumerate(signals):
        which = np.flatnonzero(d.rows.signal == signal)
        band = 1.96 * float(np.median(d.sigma[which])) * UM
        plot.barh(k, 2 * band, left=-band, color="0.9", height=0.9, zorder=0)
        plot.plot(d.before[which] * UM, np.full(len(which), k - 0.15), "o", ms=4, mfc="none", color="tab:red")
        for held, colour in ((False, "tab:gray"), (True, "tab:green")):
            some = which[d.held[which] == held]
            plot.plot(d.after[some] * UM, np.full(len(some), k + 0.15), "o", ms=4, color=colour)
    plot.axvline(0, color="0.6", lw=0.8)
    plot.set_yticks(range(len(signals)), [_name(d, s) for s in signals])
    plot.invert_yaxis()
    plot.set_xlabel("measured - model, um")
    figure.tight_layout()
    return (
        "Features of parts: red rings, what the machine's file leaves; filled, what is left with the effects found (green: held out); "
        "grey: 95 % of the noise",
        _svg(figure),
    )


def _before_after(d: Diagnosis) -> tuple[str, str]:
    """rms of what took no part, signal by signal."""
    import matplotlib.pyplot as plt

    signals = [int(s) for s in np.unique(d.rows.signal[d.held])]
    figure, plot = plt.subplots(figsize=(12, 1.2 + 0.55 * len(signals)))
    ground = floor(d)
    for k, signal in enumerate(signals):
        which = d.held & (d.rows.signal == signal)
        scale, unit = scaled(d, signal)
        sizes = [rms(values[which]) * scale for values in (d.before, d.after, ground)]
        other = "" if unit == "um" else f" {unit}"
        for offset, size, colour in zip((-0.27, 0.0, 0.27), sizes, ("tab:red", "tab:green", "0.7"), strict=True):
            plot.barh(k + offset, size, height=0.25, color=colour)
            plot.text(size, k + offset, f" {size:.2f}{other}", va="center", fontsize=8)
    for label, colour in (("before", "tab:red"), ("after", "tab:green"), ("noise", "0.7")):
        plot.barh([0], [0], color=colour, label=label)
    plot.set_yticks(range(len(signals)), [_name(d, s) for s in signals])
    plot.invert_yaxis()
    plot.margins(x=0.08)
    plot.set_xlabel("rms of what took no part, um")
    plot.legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=3, fontsize=8, frameon=False)
    figure.tight_layout()
    return f"Held out ({d.held_name}): before and after the effects found, and the noise of single readings", _svg(
        figure
    )


def _shares(d: Diagnosis) -> tuple[str, str]:
    """How much each effect explains, beside what is left."""
    import matplotlib.pyplot as plt

    names = [words.named(f.block.key) for f in d.findings] + ["left", "noise"]
    sizes = [rms(f.contribution - middle(d, f.contribution)) * UM for f in d.findings]
    sizes += [rms(d.after) * UM, rms(floor(d)) * UM]
    colours = ["tab:blue" if f.status == "accepted" else "lightblue" for f in d.findings] + ["tab:green", "0.7"]
    figure, plot = plt.subplots(figsize=(12, 0.9 + 0.35 * len(names)))
    plot.barh(range(len(names)), sizes, color=colours)
    for k, size in enumerate(sizes):
        plot.text(size, k, f" {size:.2f}", va="center", fontsize=8)
    plot.set_yticks(range(len(names)), names)
    plot.invert_yaxis()
    plot.margins(x=0.08)
    plot.set_xlabel("rms of all readings, um")
    figure.tight_layout()
    return "What each effect explains (pale: not accepted), what is left with all of them, and the noise", _svg(figure)


def _contribution(d: Diagnosis, k: int) -> tuple[str, str]:
    """What one effect does to the signal that shows it best."""
    import matplotlib.pyplot as plt

    f = d.findings[k]
    part = f.contribution - middle(d, f.contribution)
    signal = max(
        (int(s) for s in np.unique(d.rows.signal[d.rows.sees != "part"])), key=lambda s: rms(part[d.rows.signal == s])
    )
    which, thinned = _thin(np.flatnonzero(d.rows.signal == signal))
    own = f.block.axis if f.block.axis in d.rows.state.position else ""
    axis = own if own and np.ptp(d.rows.state.position[own][which]) > 1e-3 else _axis(d, which)
    place, side = d.rows.state.position[axis][which], np.sign(d.rows.state.approach[axis][which])
    (time, when_said), (scale, unit) = _times(d, which), scaled(d, signal)
    figure, plots = plt.subplots(1, 2, figsize=(12, 3), sharey=True)
    for way, colour, name in SIDES:
        some = side == way
        if some.any():
            both = (d.after + f.contribution)[which][some] * scale
            for plot, x in zip(plots, (place, time), strict=True):
                plot.plot(x[some], both, ".", ms=2, color=colour, alpha=0.3)
                plot.plot(x[some], f.contribution[which][some] * scale, "_", ms=7, mew=2, color=colour, label=name)
    plots[0].set_ylabel(f"{words.named(f.block.key)}, {unit}")
    plots[0].set_xlabel(f"position of {axis}, mm")
    plots[1].set_xlabel(when_said)
    plots[0].legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=3, fontsize=8, frameon=False)
    _pixels(plots, len(which))
    figure.tight_layout()
    return (
        f"{words.named(f.block.key)} in {_name(d, signal)}: what it adds to each reading (strokes), and the readings without all other effects "
        f"(dots){thinned}",
        _svg(figure),
    )


def _map(d: Diagnosis) -> tuple[str, str]:
    """What no name explains, cell by cell."""
    import matplotlib.pyplot as plt

    u = d.unknown
    assert u is not None
    scale, unit = scaled(d, u.signal)
    by_side = u.depends == ("direction",)
    figure, plot = plt.subplots(figsize=(12, 3.2))
    for way, colour, name in SIDES:
        own = [c for c in u.cells if c.approach == way]
        if own:
            x, y, e = (
                np.array(v)
                for v in zip(
                    *((way if by_side else (c.low + c.high) / 2, c.mean * scale, 1.96 * c.error * scale) for c in own),
                    strict=True,
                )
            )
            plot.errorbar(
                x, y, yerr=e, fmt="o-", ms=4, lw=0.8, capsize=2, color=colour, label=name if way else "both directions"
            )
    plot.axhline(0, color="0.6", lw=0.8)
    if by_side:
        plot.set_xticks([-1, 1], ["-", "+"])
        plot.set_xlim(-3, 3)
        plot.set_xlabel("direction of approach")
    else:
        plot.set_xlabel("time, s" if u.along == "time" else f"position of {u.along}, mm")
    plot.set_ylabel(f"not explained, {unit}")
    plot.legend(fontsize=8, frameon=False)
    figure.tight_layout()
    return (
        f"{_name(d, u.signal)}: the mean of what no name explains, cell by cell, with 95 % limits of the mean; no compensator applies it",
        _svg(figure),
    )


def _svg(figure) -> str:
    import matplotlib.pyplot as plt

    out = io.StringIO()
    figure.savefig(out, format="svg", metadata={"Date": None})
    plt.close(figure)
    text = out.getvalue()
    return text[text.index("<svg") :]
