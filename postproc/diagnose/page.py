"""The answer as one HTML page: the text, and figures of what was left before and after, by position and time."""

from __future__ import annotations

import html
import io

import numpy as np

from postproc.diagnose.answer import Diagnosis
from postproc.diagnose.report import as_text

UM = 1e3
HEAD = """<!doctype html><html lang="en"><meta charset="utf-8"><title>Diagnosis of {name}</title>
<style>body{{font:16px/1.5 sans-serif;max-width:70em;margin:2em auto;padding:0 1em;color:#222}}pre{{white-space:pre-wrap;font:inherit}}
figure{{margin:2em 0}}figcaption{{color:#555}}svg{{max-width:100%;height:auto}}</style><h1>Diagnosis of {name}</h1>"""


def page(d: Diagnosis) -> str:
    """HTML with the figures in it; without matplotlib the text alone, and how to have figures."""
    parts = [HEAD.format(name=html.escape(d.machine.name)), f"<pre>{html.escape(as_text(d))}</pre>"]
    try:
        figures = list(_figures(d))
    except ImportError:
        figures = []
        parts.append("<p>Figures need matplotlib: pip install 'gcomp[figures]'</p>")
    for caption, svg in figures:
        parts.append(f"<figure>{svg}<figcaption>{html.escape(caption)}</figcaption></figure>")
    return "\n".join(parts) + "</html>\n"


def _figures(d: Diagnosis):
    """(caption, svg) of every signal, and of what each effect explains."""
    import matplotlib

    matplotlib.use("svg")
    import matplotlib.pyplot as plt

    for signal in np.unique(d.rows.signal):
        which = np.flatnonzero(d.rows.signal == signal)
        if len(which) < 8 or d.rows.sees[which[0]] == "part":
            continue
        file = d.recordings[int(d.rows.file[which[0]])].file
        axis = max(d.rows.state.position, key=lambda x: float(np.ptp(d.rows.state.position[x][which])))
        place, time = d.rows.state.position[axis][which], d.rows.state.time[which]
        side, held = d.rows.state.approach[axis][which], d.held[which]
        figure, plots = plt.subplots(2, 2, figsize=(12, 6), sharey=True)
        for row, (values, label) in enumerate(((d.before, "before"), (d.after, "after"))):
            y = values[which] * UM
            for way, colour, name in ((1, "tab:blue", "approached in +"), (-1, "tab:red", "in -"), (0, "tab:gray", "")):
                some = np.sign(side) == way
                plots[row, 0].plot(place[some], y[some], ".", ms=3, color=colour, label=name or None)
            plots[row, 1].plot(time[~held], y[~held], ".", ms=3, color="tab:gray", label="fitted")
            plots[row, 1].plot(time[held], y[held], ".", ms=3, color="tab:green", label="held out")
            plots[row, 0].set_ylabel(f"{label}, um")
            band = 1.96 * float(np.median(d.sigma[which])) * UM
            for plot in plots[row]:
                plot.axhspan(-band, band, color="0.9", zorder=0)
        for found in (p for p in d.places if p.signal == signal):
            plots[0, 0].axvspan(found.low, found.high, color="gold", alpha=0.25, zorder=0)
        plots[1, 0].set_xlabel(f"{axis}, mm")
        plots[1, 1].set_xlabel("time, s")
        plots[0, 0].legend(loc="upper right", fontsize=8)
        plots[0, 1].legend(loc="upper right", fontsize=8)
        figure.tight_layout()
        yield (
            f"{file}, {d.rows.signals[signal]}: left by the machine's file (above) and by the diagnosed one (below); grey: noise",
            _svg(figure),
        )
        plt.close(figure)
    if d.findings:
        figure, plot = plt.subplots(figsize=(12, 0.6 + 0.5 * len(d.findings)))
        names = [f"{f.block.name} {f.block.axis}" for f in d.findings]
        sizes = [float(np.std(f.contribution)) * UM for f in d.findings]
        plot.barh(names, sizes, color="tab:blue")
        plot.set_xlabel("explained, um rms")
        figure.tight_layout()
        yield "What each effect explains", _svg(figure)
        plt.close(figure)


def _svg(figure) -> str:
    out = io.StringIO()
    figure.savefig(out, format="svg", metadata={"Date": None})
    text = out.getvalue()
    return text[text.index("<svg") :]
