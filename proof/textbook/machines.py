"""Machines: axes, travels, and two sets of tables: what the user's calibration states, and what is.

Both differ by smooth shapes of the size of the stated uncertainty (ISO 230-2, annex on measurement
uncertainty). Components are named as in ISO 230-1: EZY is what Y's motion does in Z. A table of
angles acts by its arm from where it was measured, plus the tool; a squareness by the rotation
vector times the own travel.
"""

from __future__ import annotations

from collections import defaultdict

import numpy as np

from .base import ABOUT, AT, Array, Fields, Rng, log_uniform, pick
from .recordings import Recording

# tool side from the base on; lengths, mm; controls
KINDS: dict[str, tuple[str, dict[str, tuple[float, float]], list[str]]] = {
    "lathe": ("ZX", {"X": (100, 400), "Z": (250, 2000)}, ["fanuc-lathe", "haas", "siemens"]),
    "grinder": ("ZX", {"X": (100, 400), "Z": (250, 2000)}, ["siemens", "fanuc-lathe"]),
    "mill": (
        "XYZ",
        {"X": (400, 1500), "Y": (300, 800), "Z": (250, 700)},
        ["fanuc-mill", "haas", "siemens", "heidenhain-iso"],
    ),
    "gantry": (
        "XYZ",
        {"X": (1200, 3000), "Y": (800, 2000), "Z": (300, 900)},
        ["siemens", "heidenhain-iso"],
    ),
    "router": ("XY", {"X": (300, 1500), "Y": (200, 1000)}, ["linuxcnc", "grbl"]),
}
NO_UNCERTAINTY = 1e-6  # where none is stated, the tables are exact


class Machine:
    """A machine as it is, and as its user knows it.

    known, true: axis -> component -> table forward and backward, um or urad at `nodes` (mm).
    modes: axis -> component -> [(standard deviation, shape)], what `known` may lack.
    """

    def __init__(
        self,
        r: Rng,
        three: bool = False,
        angles: bool = False,
        min_travel: float = 0.0,
        flat: bool = False,
    ) -> None:
        """three: with X, Y and Z. angles: all tables of angles, and large ones. min_travel: mm.
        flat: tables of zero."""
        self._draw_axes(r, three, min_travel)
        self.quality = log_uniform(r, 0.6, 3.0)
        self.lead = pick(r, [4.0, 5.0, 10.0, 10.0, 16.0, 20.0])
        self.maxv = {a: float(pick(r, [6000, 10000, 15000, 30000])) for a in self.axes}
        self.maxa = {a: float(pick(r, [500, 1000, 1500, 3000])) for a in self.axes}
        self.tool = dict.fromkeys(self.axes, 0.0)
        if self.kind in ("mill", "gantry"):
            self.tool["Z"] = -float(pick(r, [0, 80, 120, 150]))
        self.states_u = r.random() < 0.75
        self.measured_at: dict[str, dict[str, float]] = defaultdict(dict)
        self.known: dict[str, dict[str, tuple[Array, Array]]] = defaultdict(dict)
        self.true: dict[str, dict[str, tuple[Array, Array]]] = defaultdict(dict)
        self.modes: dict[str, dict[str, list[tuple[float, Array]]]] = defaultdict(dict)
        self.u: dict[str, dict[str, float]] = defaultdict(dict)
        for a in self.axes:
            for other in self.carried(a):
                self.measured_at[a][other] = float(np.round(r.uniform(*self.travel[other]), 0))
            for name in self._components(r, a, angles):
                self._draw_table(r, a, name, angles, flat)
        self._draw_squareness(r, flat)
        self.increment = pick(r, [0.0001, 0.001]) if self.kind != "router" else 0.001
        self.name = f"{self.kind}-{int(r.integers(100, 999))}"
        self.declared: list[dict[str, object]] = []

    def _draw_axes(self, r: Rng, three: bool, min_travel: float) -> None:
        self.kind = pick(r, ["mill", "gantry", "mill"] if three else list(KINDS))
        chain, lengths, controls = KINDS[self.kind]
        self.tool_side, self.work_side = list(chain), list("")
        if self.kind == "mill" and r.random() < 0.25:
            self.tool_side, self.work_side = ["Z"], ["X", "Y"]
        drawn = {a: log_uniform(r, *lengths[a]) for a in lengths}
        self.control = pick(r, controls)
        self.diameter = ["X"] if chain == "ZX" else []
        self.axes = sorted(chain)
        self.travel: dict[str, tuple[float, float]] = {}
        self.nodes: dict[str, Array] = {}
        for a in self.axes:
            length = round(max(drawn[a], min_travel) / 10) * 10.0
            low = pick(r, [0.0, 0.0, -5.0, -length, -round(length / 2)])
            self.travel[a] = (float(low), float(low + length))
            count = int(r.integers(11, 32))
            self.nodes[a] = np.round(np.linspace(low, low + length, count), 3)

    def _components(self, r: Rng, a: str, angles: bool) -> list[str]:
        found = [f"E{d}{a}_um" for d in self.axes]
        if a not in self.work_side and self.carried(a):
            about = [q for q in "ABC" if self._shows(a, q)]
            found += [f"E{q}{a}_urad" for q in about if angles or r.random() < 0.75]
        return found

    def _draw_table(self, r: Rng, a: str, name: str, angles: bool, flat: bool) -> None:
        x = self.nodes[a]
        xn = 2 * (x - x[0]) / (x[-1] - x[0]) - 1
        own = name == f"E{a}{a}_um"
        size, u = self._draw_size(r, name.endswith("urad"), own, angles, (x[-1] - x[0]) / 1000)
        table = _table(r, size, xn, own)
        table = table - table[int(np.argmin(abs(x)))] if own else table - table[0]
        if flat:
            table, u = np.zeros_like(table), 0.2
        modes = _modes(u / 2, 1.0 if self.states_u else 0.0, xn)
        error = sum(r.normal() * sd * f for sd, f in modes) * (0.0 if flat else 1.0)
        forward = backward = np.round(table, 3)
        if own and not flat and r.random() < 0.35:  # the table knows a reversal error
            size = log_uniform(r, 0.5, 4.0) * pick(r, [1, 1, 1, -1])
            reversal = np.round(size * (1 + 0.15 * np.cos(np.pi * xn)), 3)
            # backward lies higher where motion is lost
            forward = np.round(forward - reversal / 2, 3)
            backward = np.round(backward + reversal / 2, 3)
        self.known[a][name] = forward, backward
        self.true[a][name] = forward + error, backward + error
        self.modes[a][name], self.u[a][name] = modes, round(u, 3)

    def _draw_size(
        self, r: Rng, angle: bool, own: bool, large: bool, metres: float
    ) -> tuple[float, float]:
        """Size of a table and its U, um or urad."""
        if angle:
            size = self.quality * log_uniform(r, 3, 12) * (2.5 if large else 1)
            return size, log_uniform(r, 0.6, 1.6)
        low, high, fixed, by_length = (1.5, 5, 0.5, 0.6) if own else (0.6, 2.5, 0.4, 0.4)
        size = self.quality * log_uniform(r, low, high) * (0.6 + metres)
        return size, 0.3 + fixed * r.random() + by_length * metres * r.random()

    def _draw_squareness(self, r: Rng, flat: bool) -> None:
        self.square: dict[str, float] = {}  # urad, as stated
        self.square_true: dict[str, float] = {}
        self.square_u: dict[str, float] = {}
        two = ["B0X"] if self.axes == ["X", "Z"] else ["C0Y"]
        for name in two if len(self.axes) == 2 else ["C0Y", "B0Z", "A0Z"]:
            lean = 0.0 if flat else round(float(r.normal() * 12 * min(self.quality, 2)), 2)
            u = round(log_uniform(r, 0.8, 3.0), 2)
            u = u if self.states_u else NO_UNCERTAINTY
            self.square[name], self.square_u[name] = lean, u
            self.square_true[name] = lean + (0 if flat else r.normal() * u / 2)

    def carried(self, a: str) -> list[str]:
        """The axes between axis a and the tool."""
        if a not in self.tool_side:
            return []
        return self.tool_side[self.tool_side.index(a) + 1 :]

    def _shows(self, a: str, about: str) -> bool:
        """Whether an angle of axis a meets an arm that is not along it, and shows in an axis."""
        arms = set(self.carried(a)) | {d for d in self.axes if self.tool[d]}
        along = "XYZ"[ABOUT[about]]
        return bool({"XYZ"[3 - ABOUT[about] - AT[d]] for d in arms if d != along} & set(self.axes))

    def by_component(self, pos: Fields, a: str, name: str, value: Array) -> Fields:
        """What a table's value (um or urad) moves at the tool, direction -> um."""
        if name.endswith("_um"):
            return {name[1]: value}
        arm = np.zeros((3, *np.shape(value)))
        carried = self.carried(a)
        for d in self.axes:
            at = pos[d] - self.measured_at[a].get(d, 0.0) if d in carried else 0.0
            arm[AT[d]] = self.tool[d] + at
        turned = np.zeros_like(arm)
        turned[ABOUT[name[1]]] = value
        moved = np.cross(turned, arm, axis=0) * 1e-3  # urad mm are nm
        return {d: moved[AT[d]] for d in self.axes}

    def by_squareness(self, pos: Fields, name: str, urad: float) -> Fields:
        """What a lean of an axis moves at the tool, direction -> um (ISO 230-1)."""
        own = pos[name[2]]
        turned, at = np.zeros((3, *np.shape(own))), np.zeros((3, *np.shape(own)))
        turned[ABOUT[name[0]]] = urad
        at[AT[name[2]]] = own
        moved = np.cross(turned, at, axis=0) * 1e-3
        return {d: moved[AT[d]] for d in self.axes}

    def deviation(self, rec: Recording) -> Fields:
        """Direction -> um, by the tables as they are; a table's lost motion is crossed as play."""
        out = {d: np.zeros(rec.n) for d in self.axes}
        for a in self.axes:
            for name, (forward, backward) in self.true[a].items():
                value = np.interp(rec.pos[a], self.nodes[a], forward)
                if not np.array_equal(forward, backward):
                    back = np.interp(rec.pos[a], self.nodes[a], backward)
                    width = np.maximum(abs(back - value), 1e-6)
                    side = rec.sense_of[a] * np.clip(2 * rec.since_mm[a] * 1e3 / width - 1, -1, 1)
                    value = (value + back) / 2 + side * (value - back) / 2
                for d, e in self.by_component(rec.pos, a, name, value).items():
                    out[d] += e
        for name, urad in self.square_true.items():
            for d, e in self.by_squareness(rec.pos, name, urad).items():
                out[d] += e
        return out

    def unknown_modes(self, rec: Recording) -> list[tuple[float, Fields]]:
        """[(standard deviation, direction -> um for one)] of what the user's tables may lack."""
        out = []
        for a in self.axes:
            for name, modes in self.modes[a].items():
                for sd, shape in modes:
                    value = np.interp(rec.pos[a], self.nodes[a], shape)
                    out.append((sd, self.by_component(rec.pos, a, name, value)))
        for name, u in self.square_u.items():
            out.append((u / 2, self.by_squareness(rec.pos, name, 1.0)))
        return out


def _modes(half: float, stated: float, xn: Array) -> list[tuple[float, Array]]:
    """Standard deviations and shapes that add up to what a table may lack."""
    return [
        (0.7 * half * stated, xn),
        (0.5 * half * stated, np.cos(np.pi * xn)),
        (0.4 * half * stated, np.sin(1.5 * np.pi * xn)),
        (0.3 * half * stated, np.cos(2.5 * np.pi * xn)),
    ]


def _table(r: Rng, size: float, xn: Array, own: bool) -> Array:
    """A smooth curve over the travel: slope or parabola, and waves of half a period to two."""
    b = r.normal(size=6) * np.array([1, 0.6, 0.5, 0.35, 0.25, 0.2])
    waves = (
        b[0] * (xn if own else xn**2)
        + b[1] * np.cos(np.pi * xn)
        + b[2] * np.sin(np.pi * 1.5 * xn)
        + b[3] * np.cos(2.5 * np.pi * xn)
        + b[4] * np.sin(3.5 * np.pi * xn)
        + b[5] * np.cos(4.5 * np.pi * xn)
    )
    return size * 0.6 * waves
