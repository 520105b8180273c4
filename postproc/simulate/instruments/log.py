"""Axis log: commanded and actual position of every slide at a sample rate, as the axis' own scale
or an instrument at the tool sees it."""

from __future__ import annotations

import numpy as np

from postproc.errors import UsageError
from postproc.simulate.actual import Reality
from postproc.simulate.instruments import Settings, Signal, channel_names, commands, refuse_more

TITLE = "axis log"
SETTINGS = {
    "rate": "Hz, samples (1000)",
    "sees": (
        "scale (the axis' own, without the geometric tables) or tool (an instrument at the tool)"
    ),
    "from": "s, of the program, where the recording begins (0)",
    "to": "s, where it ends (its end)",
}


def measure(reality: Reality, settings: Settings) -> Signal:
    """mm commanded and actual, evenly in time. Raises UsageError for a span without samples, or too
    many."""
    timeline = reality.timeline
    sees = settings.text("sees", "scale")
    if sees not in ("scale", "tool"):
        raise UsageError(f"--set sees={sees}", "scale or tool")
    rate = settings.above_zero("rate", 1000.0)
    begin = max(settings.number("from", 0.0), 0.0)
    end = min(settings.number("to", timeline.duration), timeline.duration)
    if end < begin:
        raise UsageError(
            f"nothing lies between {begin:g} and {end:g} s",
            f"the program takes {timeline.duration:.3f} s",
        )
    number = int((end - begin) * rate + 1e-9) + 1
    refuse_more(number, "a lower rate, or --set from=... --set to=...")
    time = begin + np.arange(number) / rate
    piece = timeline.plan.at(time)[0]
    run = timeline.steps.part[timeline.path.step[piece]].astype(float)
    state = timeline.state(time, None, run)
    _, space = reality.reading(state, (sees, "trace"))
    error = reality.error(state, (sees,), piece, tables=sees == "tool") + space
    commanded = commands(state)
    actual = {f"{n[0]}_act_mm": p + error["XYZ".index(n[0])] for n, p in commanded.items()}
    columns = {"run": run, "t_s": state.time, **commanded, **actual}
    columns["line"] = timeline.line(time).astype(float)
    head = {
        "instrument": "grid encoder" if sees == "tool" else TITLE,
        "sees": sees,
        "rate_hz": rate,
    }
    return Signal(
        "trace", head, columns, dict.fromkeys(actual, 1e3), state,
        tuple(c for c in channel_names(state) if not c.startswith("T_bed")),
    )  # fmt: skip
