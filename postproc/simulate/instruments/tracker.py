"""Laser tracker: the place of a reflector at every rest, in the tracker's own frame, which stands
as it stands.

The reflector sits where the tool's point is, and `tool` mm beside it. With `station` it is an
interferometer that only tells its distance from there (multilateration): a constant, its dead path,
is not known.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from postproc.simulate.actual import Reality
from postproc.simulate.instruments import Settings, Signal, channel_names
from postproc.simulate.instruments import _targets as targets

TITLE = "laser tracker"
SETTINGS = {
    **targets.SETTINGS,
    "tool": "X0,Y0,Z-100: mm from the tool's point to the reflector",
    "station": "X-500,Y-400,Z900: where an interferometer stands that tells distances alone",
    "turned": "degrees by which the tracker's frame is turned about Z (17)",
    "dead": "mm, dead path of a station (123.4)",
}
XYZ = "XYZ"


def measure(reality: Reality, settings: Settings) -> Signal:
    """mm in the tracker's frame at every rest, or mm from a station."""
    found = targets.captures(reality, settings)
    state = found.state
    beside = settings.place("tool")
    arm = np.array([beside.get(x, 0.0) for x in XYZ])
    place = np.array([state.position.get(x, np.zeros(len(found.piece))) for x in XYZ])
    machine = replace(reality.machine, tool=reality.machine.tool + arm)
    there = replace(reality, timeline=replace(reality.timeline, machine=machine))
    tip = place + machine.tool[:, None] + there.error(state, ("tool",), found.piece)
    columns = found.columns()
    head = {
        "instrument": TITLE,
        "tool": {x: float(arm[i]) for i, x in enumerate(XYZ) if x in state.position},
    }
    if station := settings.place("station"):
        away = tip - np.array([station.get(x, 0.0) for x in XYZ])[:, None]
        columns["length_mm"] = np.linalg.norm(away, axis=0) - settings.number("dead", 123.4)
        return Signal("lengths", head, columns, {"length_mm": 1e3}, state, channel_names(state))
    angle = np.radians(settings.number("turned", 17.0))
    turn = np.array(
        [[np.cos(angle), np.sin(angle), 0.0], [-np.sin(angle), np.cos(angle), 0.0], [0.0, 0.0, 1.0]]
    )
    # a frame of its own, as a tracker has: turned and shifted, which whoever fits must find
    seen = turn @ (tip - np.array([[-900.0], [-700.0], [350.0]]))
    columns |= {f"m{x.lower()}_mm": seen[i] for i, x in enumerate(XYZ)}
    noisy = {f"m{x.lower()}_mm": 1e3 for x in XYZ}
    return Signal("points", head, columns, noisy, state, channel_names(state))
