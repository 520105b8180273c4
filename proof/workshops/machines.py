"""Machines of workshops, what their owners measured of them, and what is true (ISO 230-1)."""

from __future__ import annotations

from typing import Any

import numpy as np

from .base import Array, Fields, Rng, log_uniform, pick, smooth_curve

DIRECTIONS = "XYZ"
ROTATIONS = "ABC"
MILL_CONTROLS = ["linuxcnc", "fanuc-mill", "haas", "siemens", "heidenhain-iso"]
# kind: chains; least and most travel, mm; controls
KINDS: dict[str, tuple[list[str], dict[str, tuple[float, float]], list[str]]] = {
    "lathe": (
        ["w-b-Z-X-t"],
        {"Z": (150, 1500), "X": (80, 300)},
        ["fanuc-lathe", "linuxcnc", "siemens"],
    ),
    "grinder": (
        ["w-b-Z-X-t"],
        {"Z": (200, 1000), "X": (80, 250)},
        ["fanuc-lathe", "siemens", "linuxcnc"],
    ),
    "surface-grinder": (
        ["w-X-b-Z-Y-t"],
        {"X": (300, 900), "Y": (120, 300), "Z": (150, 400)},
        ["siemens", "fanuc-mill"],
    ),
    "mill": (
        ["w-X-Y-b-Z-t", "w-Y-b-X-Z-t"],
        {"X": (300, 1200), "Y": (200, 600), "Z": (150, 600)},
        MILL_CONTROLS,
    ),
    "router": (
        ["w-b-Y-X-Z-t"],
        {"X": (400, 1500), "Y": (600, 2500), "Z": (80, 200)},
        ["grbl", "linuxcnc"],
    ),
    "gantry": (
        ["w-b-X-Y-Z-t"],
        {"X": (1500, 3000), "Y": (800, 2000), "Z": (200, 600)},
        ["siemens", "fanuc-mill", "heidenhain-iso"],
    ),
    "rotary-table-mill": (
        ["w-Y-b-X-Z-t"],
        {"X": (300, 800), "Y": (250, 600), "Z": (200, 500)},
        ["linuxcnc", "haas", "fanuc-mill"],
    ),
}
LONG = ("lathe", "grinder", "mill", "router", "gantry")  # kinds whose longest axis may have 1 m
TURNING = ("lathe", "grinder")


class Machine:
    """A machine as drawn. Of every axis: travel, mm; lead, mm, of screw, rack or belt; vmax,
    mm/min; amax, mm/s2; nodes, mm; known: what the tables say, true: what is, um and urad by
    column. square: urad. U: um, k = 2, of a table. declared: the lost motion that is known."""

    def __init__(
        self,
        r: Rng,
        long: bool = False,
        flat: bool = False,
        kinds: list[str] | None = None,
        coarse: bool | None = None,
    ) -> None:
        """long: the longest axis has 1 m at least; flat: the control corrects all of it, the tables
        are zero; coarse: tables and gauges of 10 um."""
        names = [k for k in kinds or KINDS if not long or k in LONG]
        self.kind = pick(r, names)
        chains, lengths, controls = KINDS[self.kind]
        self.chain = pick(r, chains)
        self.control = pick(r, controls)
        work, _, tool = self.chain.partition("b")
        self.tool_axes = [a for a in tool if a in DIRECTIONS]
        self.axes = [a for a in DIRECTIONS if a in work + tool]
        self.flat, self.turning = flat, self.kind in TURNING
        rough = 0.6 if self.kind == "router" else 0.12
        self.coarse = coarse if coarse is not None else bool(r.random() < rough)
        self.travel: dict[str, tuple[float, float]] = {}
        self.lead: dict[str, float] = {}
        self.vmax: dict[str, float] = {}
        self.amax: dict[str, float] = {}
        longest = max(lengths, key=lambda a: lengths[a][1])
        for a in self.axes:
            low, high = lengths[a]
            if long and a == longest:
                low = max(low, 1000)
                high = max(high, low * 1.05)
            self._draw_axis(r, a, low, high)
        self._draw_tool(r)
        self.states_u = bool(r.random() < 0.6)
        size = r.uniform(10, 40) if self.coarse else log_uniform(r, 1, 10)
        self.U = r.uniform(2, 5) if self.coarse else r.uniform(0.15, 0.5)
        self.nodes: dict[str, Array] = {}
        self.known: dict[str, Fields] = {}
        self.true: dict[str, Fields] = {}
        for a in self.axes:
            self._draw_table(r, a, 0 if flat else size)
        self._draw_squareness(r)
        self.declared: list[dict[str, Any]] = []

    def _draw_axis(self, r: Rng, a: str, low: float, high: float) -> None:
        length = round(log_uniform(r, low, high) / 10) * 10
        below = -float(length) if a == "Z" and not self.turning else 0.0
        start = -5.0 if r.random() < 0.5 else below
        self.travel[a] = (start, start + length)
        drive = "rack" if self.kind == "gantry" and length > 1500 else "screw"
        if self.kind == "router" and a != "Z":
            drive = pick(r, ["screw", "rack", "belt"])
        self.lead[a] = {
            "screw": pick(r, [4.0, 5.0, 5.0, 6.0, 10.0, 12.7 / 2, 16.0]),
            "rack": pick(r, [np.pi * 1.5, np.pi * 2, 5.0]),
            "belt": pick(r, [3.0, 5.0]),
        }[drive]
        self.vmax[a] = float(pick(r, [2000, 3000, 6000, 10000, 15000, 20000]))
        self.amax[a] = float(pick(r, [300, 500, 1000, 1500, 3000]))

    def _draw_tool(self, r: Rng) -> None:
        """The tool, where each axis was measured, and least increments."""
        if self.turning:
            x, z = np.round(r.uniform(-20, 60), 1), np.round(r.uniform(-80, 80), 1)
            self.tool = {"X": float(x), "Z": float(z)}
        else:
            self.tool = {"X": 0.0, "Y": 0.0, "Z": float(-np.round(r.uniform(40, 180), 1))}
        self.measured_at = {
            a: {
                b: round(float(np.mean(self.travel[b]) + r.uniform(-0.2, 0.2) * self.length(b)), 1)
                for b in self.axes
                if b != a
            }
            for a in self.axes
        }
        rough = self.kind in ("router", "gantry") or self.coarse
        self.increment = {a: 0.001 if rough else pick(r, [0.001, 0.0001]) for a in self.axes}

    def _draw_table(self, r: Rng, a: str, size: float) -> None:
        n = int(r.integers(6, 30))
        low, high = self.travel[a]
        x = np.linspace(low, high, n)
        if r.random() < 0.25:
            x[1:-1] += r.uniform(-0.3, 0.3, n - 2) * (high - low) / (n - 1)
        self.nodes[a] = x = np.round(x, 3)
        u = (x - low) / (high - low)
        columns = self._positioning(r, a, u, size)
        for d in self.axes:
            if d != a and r.random() < 0.5:
                columns[f"E{d}{a}_um"] = size * 0.4 * smooth_curve(r)(u)
        if self.carried(a):
            columns |= self._angles(r, a, u)
        digits = 1 if self.coarse else 2
        self.known[a] = {name: np.round(y, digits) for name, y in columns.items()}
        self.true[a] = {}
        unknown: Fields = {}
        for name, y in self.known[a].items():
            both = name.removesuffix("_fwd").removesuffix("_rev")
            if both not in unknown:
                of = 0.5 * self.U * smooth_curve(r, 6)(u) if self.states_u else np.zeros(n)
                unknown[both] = of * 0.5 if both.endswith("urad") else of
            self.true[a][name] = y + unknown[both]

    def _positioning(self, r: Rng, a: str, u: Array, size: float) -> Fields:
        y = size * smooth_curve(r)(u) + size * 0.5 * r.normal() * (u - 0.5)
        y -= y[0]
        name = f"E{a}{a}_um"
        if not (r.random() < 0.4 and not self.flat):
            return {name: y}
        lost = size * r.uniform(0.1, 0.5) + 0.2 * size * smooth_curve(r)(u)
        return {f"{name}_fwd": y - lost / 2, f"{name}_rev": y + lost / 2}

    def _angles(self, r: Rng, a: str, u: Array) -> Fields:
        two, found = len(self.axes) == 2, {}
        for about in "B" if two else ROTATIONS:
            if r.random() < (0.9 if two else 0.55):
                size = 0 if self.flat else log_uniform(r, 3, 15) * (2 if self.coarse else 1)
                y = size * smooth_curve(r, 3)(u)
                found[f"E{about}{a}_urad"] = y - y[0]
        return found

    def _draw_squareness(self, r: Rng) -> None:
        self.square: dict[str, float] = {}
        self.square_u: dict[str, float] = {}
        self.square_true: dict[str, float] = {}
        for name in ["B0X"] if len(self.axes) == 2 else ["C0Y", "B0Z", "A0Z"]:
            y = 0.0 if self.flat else round(float(r.normal() * (60 if self.coarse else 15)), 2)
            u = round(4 * self.U / max(100, self.length(name[2])) * 1e3 * 0.5, 3)
            self.square[name], self.square_u[name] = y, u
            self.square_true[name] = y + (r.normal() * u / 2 if self.states_u else 0)

    def length(self, a: str) -> float:
        """mm."""
        return self.travel[a][1] - self.travel[a][0]

    def middle(self, a: str) -> float:
        """mm."""
        return 0.5 * (self.travel[a][0] + self.travel[a][1])

    def share(self, a: str, x: Array) -> Array:
        """0 to 1 over the travel."""
        return (x - self.travel[a][0]) / self.length(a)

    def carried(self, a: str) -> list[str]:
        """Axes between a and the tool."""
        return self.tool_axes[self.tool_axes.index(a) + 1 :] if a in self.tool_axes else []

    def by_sides(self, a: str) -> float:
        """um, mean of what a table's two directions differ by; 0 where it has one."""
        name = f"E{a}{a}_um"
        if f"{name}_fwd" not in self.true[a]:
            return 0.0
        return float(np.mean(np.abs(self.true[a][f"{name}_fwd"] - self.true[a][f"{name}_rev"])))

    def deviation(self, pos: Fields, side: Fields) -> Fields:
        """um by direction, of the true tables. pos: mm; side: -1 to 1, the sign of the motion."""
        n = len(next(iter(pos.values())))
        moved: Fields = {d: np.zeros(n) for d in DIRECTIONS}
        for a in self.axes:
            angle = np.zeros((3, n))
            for name, y in self.true[a].items():
                weight = {"fwd": 0.5 * (1 + side[a]), "rev": 0.5 * (1 - side[a])}
                value = np.interp(pos[a], self.nodes[a], y) * weight.get(name[-3:], 1.0)
                if name.endswith("urad"):
                    angle[ROTATIONS.index(name[1])] += value
                else:
                    moved[name[1]] += value
            if a in self.tool_axes:
                turn(moved, angle, self.arm(a, pos))
        for name, lean in self.square_true.items():
            angle = np.zeros((3, n))
            angle[ROTATIONS.index(name[0])] = lean
            turn(moved, angle, {name[2]: pos[name[2]]})
        for effect in self.declared:
            moved[effect["axis"]] += -side[effect["axis"]] * effect["size_um"] / 2
        return {d: moved[d] for d in self.axes}

    def arm(self, a: str, pos: Fields) -> dict[str, Any]:
        """mm by direction: from where the axis was measured to the tool's tip."""
        arm: dict[str, Any] = {d: self.tool.get(d, 0.0) for d in DIRECTIONS}
        for b in self.carried(a):
            arm[b] = arm[b] + pos[b] - self.measured_at[a][b]
        return arm


def turn(moved: Fields, angle: Array, arm: dict[str, Any]) -> None:
    """Adds a rotation at an arm: angle (3, n) urad; arm mm; moved um (rigid body, first order)."""
    x, y, z = (arm.get(d, 0.0) for d in DIRECTIONS)
    moved["X"] += 1e-3 * (angle[1] * z - angle[2] * y)
    moved["Y"] += 1e-3 * (angle[2] * x - angle[0] * z)
    moved["Z"] += 1e-3 * (angle[0] * y - angle[1] * x)
