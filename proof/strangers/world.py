"""What goes on while the experiment runs, whether or not it moves anything that is measured.

Latent processes on a time grid: room and outside air, screw rises from the axes' own motion
(lumped, ISO 230-3), frame, spindle speed programme, loads, air pressure.  They belong to the
experiment, never to the hidden effect: an effect only couples to them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .base import Array, Rec, Rng, logu, pick, stream
from .machines import Machine


@dataclass
class World:
    """Machine, files and latent processes; temperatures are K above 20 C, load N, pressure hPa."""

    machine: Machine
    recs: list[Rec]
    grid: Array
    air: Array
    frame: Array
    duty: dict[int, Array]
    screw: dict[int, Array]
    rpm: Array
    spindle: Array
    load: dict[int, Array]
    pressure: Array
    record: dict[str, bool]
    family: str
    key: str

    def at(self, series: Array, t: Array) -> Array:
        """A latent series at times t, linear between grid points."""
        return np.interp(t, self.grid, series)

    def step(self, series: Array, t: Array) -> Array:
        """A latent series at times t, held between grid points."""
        return series[np.clip(np.searchsorted(self.grid, t, "right") - 1, 0, len(series) - 1)]

    def force(self, rec: Rec, ax: int) -> Array:
        """Load on an axis (N) at each state of a file; gravity of a moving mass is left out."""
        s = self.step(self.load[ax], rec.t)
        if rec.kind == "trace":
            g = stream("force", self.key, rec.name, ax)
            k = g.normal(0, 1, 1 + len(rec.t) // max(1, int(rec.meta["rate"] * 0.5)) + 1)
            x = np.linspace(0, len(k) - 1, len(rec.t))
            s = s * (1 + 0.3 * np.interp(x, np.arange(len(k)), k))
        return s


def lowpass(x: Array, dt: float, tau: float, start: float | None = None) -> Array:
    """First-order lag with time constant tau (s)."""
    from scipy.signal import lfilter

    a = 1 - np.exp(-dt / tau)
    s = x[0] if start is None else start
    return lfilter([a], [1, a - 1], x, zi=[(1 - a) * s])[0]


def slow_ou(r: Rng, n: int, dt: float, tau: float) -> Array:
    """Unit-variance Ornstein-Uhlenbeck series."""
    from scipy.signal import lfilter

    f = np.exp(-dt / tau)
    e = r.normal(0, np.sqrt(1 - f * f), n)
    e[0] = r.normal()
    return lfilter([1.0], [1.0, -f], e)


def draw_world(r: Rng, m: Machine, recs: list[Rec], family: str, drivers: dict) -> World:
    """Latent processes; `drivers` asks for loads or a spindle programme in this experiment."""
    end = max(float(x.t[-1]) for x in recs) + 60.0
    n = 3000
    grid = np.linspace(0, end, n)
    dt = grid[1]
    room = logu(r, 0.15, 1.5) * slow_ou(r, n, dt, logu(r, 900, 14400))
    room += r.uniform(0, 1.5) * np.sin(2 * np.pi * grid / 86400 + r.uniform(0, 6.3))
    if r.random() < 0.5:
        period = r.uniform(15, 40) * 60
        room += r.uniform(0.1, 0.6) * np.sin(2 * np.pi * grid / period + r.uniform(0, 6.3))
    if r.random() < 0.25:
        door = r.uniform(0.1, 0.9) * end
        room -= logu(r, 0.5, 3) * (grid > door) * np.exp(-np.maximum(grid - door, 0) / 900)
    room += r.normal(0, 0.8)
    frame = lowpass(room, dt, logu(r, 1800, 14400))
    duty, screw = {}, {}
    for a in m.axes:
        v = np.zeros(n)
        for x in recs:
            d = np.abs(np.diff(x.via[:, a]))
            np.add.at(v, np.minimum((x.via_t[1:] / dt).astype(int), n - 1), d / dt)
            for s, e, ax, speed in x.activity:
                if ax == a:
                    v[(grid >= s) & (grid < e)] += speed
        duty[a] = v
        rise = lowpass(v**1.0, dt, logu(r, 600, 4000), 0.0)
        top = logu(r, 0.6, 7) * min(1.0, float(v.mean()) / 20 + 0.15)
        screw[a] = top * rise / max(float(rise.max()), 1e-9)
    steps = np.sort(r.uniform(0, end, int(r.integers(2, 7))))
    levels = r.choice([0, 1000, 2000, 3000, 4500, 6000, 8000], len(steps) + 1).astype(float)
    rpm = levels[np.searchsorted(steps, grid)] if drivers.get("spindle") else np.zeros(n)
    spindle = lowpass((rpm / 6000) ** 1.5, dt, logu(r, 400, 2400), 0.0) * logu(r, 2, 12)
    load, rows = {}, np.concatenate([x.t for x in recs])
    for a in m.axes:
        cuts = np.sort(r.choice(rows, int(r.integers(3, 25))))
        level = np.round(r.choice([-1, 0, 0.5, 1.0, 2.0], len(cuts) + 1) * logu(r, 40, 400), 0)
        load[a] = level[np.searchsorted(cuts, grid)] * bool(drivers.get("load"))
    pressure = logu(r, 0.5, 12) * (slow_ou(r, n, dt, 2e4) + grid / end * r.normal())
    record = {
        "T": r.random() < 0.75 or bool(drivers.get("T")),
        "load": True,
        "rpm": True,
        "feed": r.random() < 0.5,
        "frame": r.random() < 0.5,
    }
    return World(
        m,
        recs,
        grid,
        room,
        frame,
        duty,
        screw,
        rpm,
        spindle,
        load,
        pressure,
        record,
        family,
        f"{int(r.integers(2**62)):016x}",
    )


THERMOMETERS = {  # of a family
    "unseen": ["good", "lag", "lag", "lag", "offset", "coarse"],
    "later": ["good", "good", "lag", "offset", "coarse", "coarse"],
    "apart": ["good", "good", "good", "lag", "offset", "coarse"],
    "distant": ["good", "good", "offset", "lag", "noise", "coarse"],
}


def thermometer(r: Rng, true: Array, t: Array, family: str) -> tuple[Array, dict]:
    """Readings (C) of a thermometer with offset, lag, noise, steps or a stuck stretch."""
    kinds = ["good", "offset", "lag", "noise", "coarse", "stuck"]
    kind = pick(r, THERMOMETERS.get(family, kinds))
    lag = r.uniform(60, 1200) if kind == "lag" else 5.0
    out = 20.0 + true.copy()
    if len(t) > 2:
        g = np.linspace(t[0], t[-1] + 1e-6, 2000)
        out = np.interp(t, g, lowpass(np.interp(g, t, out), g[1] - g[0], lag))
    out += r.normal(0, 0.6 if kind == "offset" else 0.05)
    out += r.normal(0, 0.15 if kind == "noise" else 0.01, len(t))
    if kind == "stuck":
        i = int(r.integers(0, max(1, len(t) - 1)))
        out[i : i + len(t) // 3 + 1] = out[i]
    q = float(pick(r, [0.1, 0.2, 0.5])) if kind == "coarse" else 0.01
    return np.round(np.round(out / q) * q, 2), {"kind": kind, "lag_s": round(lag, 1), "step_K": q}
