"""Tests in motion: ballbars (ISO 230-4), and logs of a control on real programs; and parts.

Every plan adds its recordings to the case and returns them.
"""

from __future__ import annotations

import numpy as np

from .base import TURN, Array, Redraw, pick
from .case import Case
from .readings import add
from .recordings import Recording
from .rest_plans import name

RADII = (30.0, 50.0, 100.0, 150.0, 300.0)  # mm, of ballbars
PROGRAMS = ["circles", "pocket", "contour", "p2p", "p2p", "strokes"]


def ballbar(c: Case, a: str, b: str, feeds: list[float] | None = None) -> list[Recording]:
    """Circles at one or two feeds, mm/min, mostly in both senses."""
    r, m = c.r, c.machine
    room = min(m.length(a), m.length(b)) / 2 * 0.9
    radius = float(max((known for known in RADII if known <= room), default=round(room)))
    if r.random() < 0.3 and radius >= 100:
        radius /= 2
    if not feeds:
        one = r.random() < 0.5
        feeds = (
            [float(pick(r, [500, 1000, 1500]))] if one else [500.0, float(pick(r, [2000, 3000]))]
        )
    centre = {
        x: round(m.middle(x) + r.uniform(-0.02, 0.02) * (m.length(x) - 2 * radius), 1)
        for x in (a, b)
    }
    found = [_circles(c, centre, radius, feed) for feed in feeds]
    said = "/".join(f"{feed:g}" for feed in feeds)
    c.plan.append(f"ballbar {a}{b} R{radius:g} at {said} mm/min")
    return found


def _circles(c: Case, centre: dict[str, float], radius: float, feed: float) -> Recording:
    r, m = c.r, c.machine
    a, b = centre
    rec = Recording("ballbar", name(c, f"ballbar_{a.lower()}{b.lower()}_F{feed:.0f}"))
    around = TURN * radius / (feed / 60)
    n = int(np.clip(around * pick(r, [20, 30, 60]), 250, 900))
    over = int(np.radians(pick(r, [45, 90, 180])) / (TURN / n))
    times: list[Array] = []
    angles, taken, senses = [], [], []
    t = c.t
    for sense in (1, -1) if r.random() < 0.85 else (1,):
        start = float(pick(r, [0, np.pi / 2, np.pi]))
        steps = np.arange(-over, n + over + 1)
        taken.append(len(steps) * len(times) + over + np.arange(n))
        times.append(t + np.arange(len(steps)) * (around / n))
        angles.append(start + sense * (TURN / n) * steps)
        senses.append(np.full(n, sense))
        t = times[-1][-1] + 5.0
    angle = np.concatenate(angles)
    way = {x: np.full(len(angle), round(m.middle(x), 1)) for x in m.axes}
    way[a] = centre[a] + radius * np.cos(angle)
    way[b] = centre[b] + radius * np.sin(angle)
    rec.set_way(np.concatenate(times), way, np.concatenate(taken))
    rec.run, rec.sense = np.repeat(np.arange(1, len(senses) + 1), n), np.concatenate(senses)
    # of the circle, as the pause between the senses does not count
    w = rec.sense * (feed / 60) / radius
    x, y = rec.pos[a] - centre[a], rec.pos[b] - centre[b]
    rec.vel[a], rec.vel[b] = -w * y, w * x
    rec.acc[a], rec.acc[b] = -w * w * x, -w * w * y
    rec.unit, rec.radius = {a: x / radius, b: y / radius}, radius
    rec.head |= {"instrument": "ballbar", "centre": centre}
    rec.head |= {"radius_mm": radius, "feed_mm_min": feed}
    c.t = round(t + r.uniform(60, 400), 1)
    noise = r.uniform(0.2, 0.6) * (3 if m.coarse else 1)
    add(c, rec, noise, float(r.uniform(0, 0.4)))
    return rec


class _Program:
    """Samples of a program: every block from rest to rest (a trapezoid of speed, or a triangle)."""

    def __init__(self, c: Case, axes: list[str], last: float, rate: float, top: float | None):
        """last: s; rate: Hz; top: mm/s."""
        m, r = c.machine, c.r
        self.r, self.last, self.rate = r, last, rate
        self.acceleration = min(m.amax[a] for a in axes) * r.uniform(0.4, 1)
        fastest = min(m.vmax[a] for a in axes) / 60
        self.fastest = min(fastest, top) if top else fastest
        self.reach = np.array([m.length(a) for a in axes]) * 0.4
        self.middle = np.array([m.middle(a) for a in axes])
        # so that some tens of blocks fit
        self.size = min(self.reach.min(), max(0.5, self.fastest * last / 25))
        self.at, self.t = self.middle.copy(), 0.0
        self.places: list[Array] = []
        self.lines: list[Array] = []
        self.number = 10

    def shares(self, length: float, speed: float) -> Array:
        """0 to 1 of a block at the samples; mm, mm/s."""
        a = self.acceleration
        v = min(speed, np.sqrt(length * a))
        rise = v / a
        whole = length / v + rise
        t = np.arange(0, whole, 1 / self.rate)
        self.t += whole
        rising, steady = 0.5 * a * t * t, 0.5 * v * rise + v * (t - rise)
        falling = length - 0.5 * a * np.maximum(whole - t, 0) ** 2
        gone = np.where(t < rise, rising, np.where(t < whole - rise, steady, falling))
        return (gone / length)[:, None]

    def block(self, places: Array) -> None:
        """Places of a block, mm (n, axes); the next has another number."""
        self.stay(places)
        self.number += 10

    def stay(self, places: Array) -> None:
        """Places between blocks, mm (n, axes)."""
        self.places.append(places)
        self.lines.append(np.full(len(places), self.number))

    def line(self, to: Array, speed: float) -> None:
        """A block to a place, mm, cut to what the program may use; mm/s."""
        to = np.clip(to, self.middle - self.reach, self.middle + self.reach)
        length = np.linalg.norm(to - self.at)
        if length >= 1e-6:
            self.block(self.at + (to - self.at) * self.shares(float(length), speed))
            self.at = to

    def hold(self, time: float) -> None:
        """A rest, s."""
        self.stay(np.repeat(self.at[None], max(1, int(time * self.rate)), 0))
        self.t += time

    def circles(self, speed: float, _: int) -> None:
        """A full circle through where it stands, and a rest."""
        radius, sense = self.size * self.r.uniform(0.15, 0.45), pick(self.r, [-1, 1])
        start = self.r.uniform(0, 6.28)
        centre = self.at - radius * np.array([np.cos(start), np.sin(start)])
        angle = start + sense * TURN * self.shares(TURN * radius, speed)[:, 0]
        self.block(centre + radius * np.c_[np.cos(angle), np.sin(angle)])
        self.hold(min(0.5, self.last / 30))

    def pocket(self, speed: float, _: int) -> None:
        """Six rows to and fro."""
        w, h = self.size * self.r.uniform(0.4, 1), self.size * self.r.uniform(0.3, 0.8)
        corner = self.middle - 0.5 * np.array([w, h])
        self.line(corner, self.fastest)
        for k in range(6):
            for row in (k, k + 1):
                self.line(corner + np.array([w * ((k + 1) % 2), h * row / 5]), speed)
            if self.t > self.last:
                break
        self.hold(min(0.3, self.last / 30))

    def contour(self, speed: float, _: int) -> None:
        """An uneven polygon around the middle."""
        n = int(self.r.integers(5, 12))
        angle = np.linspace(0, TURN, n + 1)[:-1]
        radius = self.size * self.r.uniform(0.2, 0.5, n)
        for k in range(n):
            direction = np.array([np.cos(angle[k]), np.sin(angle[k])])
            self.line(self.middle + radius[k] * direction, speed)
            if self.t > self.last:
                break

    def strokes(self, speed: float, number: int) -> None:
        """To and fro along one axis, then the other."""
        for side in (1, -1, 0):
            to = self.middle.copy()
            to[number % len(to)] += side * self.size * 0.9
            self.line(to, speed)
            self.hold(min(0.4, self.last / 40))

    def p2p(self, speed: float, _: int) -> None:
        """A block to anywhere, and a rest."""
        to = self.middle + self.size * self.r.uniform(-1, 1, len(self.at))
        self.line(to, speed if self.r.random() < 0.6 else self.fastest)
        self.hold(self.r.uniform(0.1, 1.0) * min(0.6, self.last / 40))

    def run(self, kind: str) -> tuple[Array, Array]:
        """mm (n, axes), smoothed as by a limited jerk, and the number of the line."""
        self.hold(min(0.3, self.last / 20))
        for number in range(400):
            if self.t >= self.last:
                break
            speed = self.fastest * pick(self.r, [0.1, 0.25, 0.5, 1.0])
            getattr(self, kind)(speed, number)
        n = int(self.last * self.rate)
        x, lines = np.concatenate(self.places)[:n], np.concatenate(self.lines)[:n]
        half = max(1, int(self.r.uniform(0.005, 0.03) * self.rate))
        return _smoothed(_smoothed(x, half), half), lines


def _smoothed(x: Array, half: int) -> Array:
    """A moving mean over half to either side."""
    wide = np.concatenate([np.repeat(x[:1], half, 0), x, np.repeat(x[-1:], half, 0)])
    total = np.cumsum(wide, 0)
    n = 2 * half + 1
    return (total[n - 1 :] - np.concatenate([np.zeros((1, x.shape[1])), total[:-n]])) / n


def trace(
    c: Case,
    axes: list[str] | None = None,
    kind: str | None = None,
    rate: float | None = None,
    sees: str = "scale",
    top: float | None = None,
) -> Recording:
    """A log of two axes on a program. kind: of PROGRAMS; rate: Hz; sees: scale, the control's own,
    or tool, an instrument of two directions; top: mm/s. Redraw where the axes hardly move."""
    r, m = c.r, c.machine
    both = len(m.axes) == 2 or (axes is None and r.random() < 0.7)
    axes = axes or (m.axes[:2] if both else [m.axes[0], m.axes[-1]])
    kind = kind or pick(r, PROGRAMS)
    rate = rate or pick(r, [50, 100, 250, 500, 1000, 2000, 4000])
    x, lines = _moving(c, axes, kind, float(rate), top)
    n = len(x)
    rec = Recording("trace", name(c, f"servo_{kind}"), sees=sees, axes=axes)
    way = {a: np.full(n, round(m.middle(a), 3)) for a in m.axes}
    way |= {a: np.round(x[:, i], 6) for i, a in enumerate(axes)}
    rec.set_way(c.t + np.arange(n) / rate, way, np.arange(n))
    rec.run = 1 + (np.arange(n) * int(pick(r, [1, 2, 3, 4]))) // n
    steps = [1.0, 2.0, 5.0] if m.coarse else [0.05, 0.1, 0.1, 0.5, 1.0]
    rec.step = rec.step_of_scale = pick(r, steps)
    instrument = pick(r, ["grid encoder", "tracking interferometer"]) if sees == "tool" else ""
    rec.head |= {"instrument": instrument or "controller log", "sample_hz": float(rate)}
    if r.random() < 0.5:
        rec.more["line"] = lines
    noise = r.uniform(0.15, 0.6) * (5 if m.coarse else 1)
    memory = min(0.93, float(np.exp(-1 / (rate * r.uniform(0.001, 0.008)))))
    c.t = round(c.t + n / rate + r.uniform(30, 300), 1)
    said = f"servo log {kind} of {''.join(axes)} at {rate:.0f} Hz, {n / rate:.0f} s, sees {sees}"
    c.plan.append(said)
    add(c, rec, noise, memory)
    rec.head["u_um"] = round(rec.noise[rec.channels[0]], 3)
    return rec


def _moving(
    c: Case, axes: list[str], kind: str, rate: float, top: float | None
) -> tuple[Array, Array]:
    """A program in which every axis moves, both ways."""
    for _ in range(12):
        x, lines = _Program(c, axes, min(60.0, 9000.0 / rate), rate, top).run(kind)
        steps = np.diff(x, axis=0)
        moving = (np.abs(steps) > 1e-7).sum(0) > 0.06 * len(x)
        ways = (steps.min(0) < -1e-6) & (steps.max(0) > 1e-6)
        if np.all((np.ptp(x, axis=0) > 0.05) & moving & ways):
            return x, lines
    raise Redraw("the axes do not move in so short a log")


def features(
    c: Case, n: int | None = None, kinds: list[str] | None = None, repeats: int | None = None
) -> Recording:
    """Features of n parts, measured off the machine."""
    r, m = c.r, c.machine
    rec = Recording("features", name(c, "parts_cmm"))
    axes = ["X"] if m.turning else ["X", "Y"]
    if not kinds:
        kinds = ["boss_diameter", "bore_diameter"]
        if not m.turning:
            kinds = ["centre_distance", "pocket_size", *kinds]
            kinds += ["step"] if r.random() < 0.5 else []
    asked = [feature for kind in kinds for feature in _of_kind(c, kind, axes)]
    n = n or int(r.integers(2, 6))
    repeats = repeats or int(r.integers(1, 4))
    rows = [
        (*feature, part, reading)
        for part in range(1, n + 1)
        for feature in asked
        for reading in range(1, repeats + 1)
    ]
    heads = ("feature", "kind", "axis", "nominal_mm", "part", "reading")
    rec.parts = {k: np.array(y) for k, y in zip(heads, zip(*rows, strict=True), strict=True)}
    rec.n = len(rows)
    if m.coarse:
        instrument, rec.step, noise = "caliper", 10.0, r.uniform(4, 7)
    else:
        choices = [("CMM", 0.1, r.uniform(0.4, 1.0)), ("micrometer", 1.0, r.uniform(0.6, 1.3))]
        instrument, rec.step, noise = pick(r, choices)
    u = round(float(np.sqrt(noise**2 + rec.step**2 / 12)), 2)
    rec.head |= {"instrument": instrument, "u_um": u}
    c.plan.append(f"features of {n} parts by {instrument}")
    add(c, rec, noise)
    return rec


def _of_kind(c: Case, kind: str, axes: list[str]) -> list[tuple[str, str, str, float]]:
    """One to three features of a kind, of distances along every axis: name, kind, axis, mm."""
    r, found = c.r, []
    for number in range(1, int(r.integers(1, 4)) + 1):
        if kind in ("centre_distance", "pocket_size"):
            along = axes
        else:
            along = ["Z"] if kind == "step" else [pick(r, axes)]
        for a in along:
            most = min(c.machine.length(a) * 0.6, 400)
            nominal = {
                "step": r.uniform(2, 40),
                "centre_distance": r.uniform(0.1, 1) * most,
                "pocket_size": r.uniform(0.1, 0.5) * most,
                "boss_diameter": r.uniform(10, max(12, min(100, 0.5 * most))),
                "bore_diameter": r.uniform(8, max(10, min(80, 0.4 * most))),
            }[kind]
            found.append((f"{kind[:2]}{number}{a}", kind, a, round(nominal, 1)))
    return found
