"""Shared vocabulary: random streams, recordings as states of the machine, contributions.

All places are slide positions (radius) in mm, all deviations are actual - commanded in um
(tool relative to workpiece, ISO 841), rotations in urad, times in s.  Vectors are always
(X, Y, Z); a two-axis machine simply never moves Y.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

Rng = np.random.Generator
Array = np.ndarray
AX = "XYZ"


def digest(*keys: object) -> str:
    """Hex digest of a tuple of keys; the only source of names and of random seeds."""
    return hashlib.sha256("\x1f".join(str(k) for k in keys).encode()).hexdigest()


def stream(*keys: object) -> Rng:
    """An independent random stream for a tuple of keys (PCG64 seeded by SHA-256)."""
    return np.random.default_rng(int(digest(*keys)[:32], 16))


def logu(r: Rng, a: float, b: float) -> float:
    """Log-uniform draw between a and b (any unit)."""
    return float(np.exp(r.uniform(np.log(a), np.log(b))))


def pick(r: Rng, items: Any) -> Any:
    """One item of a sequence, uniformly."""
    items = list(items)
    return items[int(r.integers(len(items)))]


def smooth(r: Rng, x: Array, length: float) -> Array:
    """A smooth random function with unit variance and correlation length `length` (unit of x).

    Random Fourier features of a squared-exponential kernel (Rahimi and Recht 2007).
    """
    k = r.normal(0, 1 / length, 40)
    return np.sqrt(2 / 40) * np.cos(np.outer(x, k) + r.uniform(0, 2 * np.pi, 40)).sum(1)


@dataclass
class Rec:
    """One file of an experiment: the state of the machine at each row, plus the path there.

    t s; pos mm (n,3); vel mm/s; acc mm/s2; run; via/via_t the turning points (or samples) of
    the commanded path, row_at the index into via of each row.  sgn (+1, 0, -1), since (mm) and
    revt (s) say for every axis in which direction it last moved, how far and how long ago it
    turned.  For kind "features" there are two contact states (rows) for each reading.
    """

    name: str
    kind: str
    t: Array
    pos: Array
    vel: Array
    acc: Array
    run: Array
    via: Array
    via_t: Array
    row_at: Array
    feed: Array
    meta: dict[str, Any]
    sgn: Array = field(default_factory=lambda: np.zeros(0))
    since: Array = field(default_factory=lambda: np.zeros(0))
    revt: Array = field(default_factory=lambda: np.zeros(0))
    activity: list[tuple[float, float, int, float]] = field(default_factory=list)

    def finish(self) -> Rec:
        """Fill sgn, since, revt from the path."""
        s, d, u = history(self.via, self.via_t)
        self.sgn, self.since, self.revt = s[self.row_at], d[self.row_at], u[self.row_at]
        if self.kind == "ballbar":
            for a in range(3):
                nz = np.flatnonzero(self.sgn[:, a])
                if nz.size:
                    self.sgn[: nz[0], a] = self.sgn[nz[0], a]
        return self

    @property
    def axes(self) -> list[int]:
        """Indices of the machine's axes."""
        return self.meta["axes"]

    @property
    def moving(self) -> list[int]:
        """Axes that move between rows of this file."""
        return [a for a in self.axes if np.ptp(self.pos[:, a]) > 1e-6]

    @property
    def n_obs(self) -> int:
        """Readings in one channel."""
        return len(self.t) // 2 if self.kind == "features" else len(self.t)

    @property
    def t_obs(self) -> Array:
        """Time of each reading, s."""
        return self.t[::2] if self.kind == "features" else self.t

    @property
    def channels(self) -> list[int]:
        """Channel identifiers: axis numbers for a trace, [0] otherwise."""
        return self.axes if self.kind == "trace" else [0]

    @property
    def outside(self) -> bool:
        """True where an instrument outside the drive sees the tool (not the axis's scale)."""
        return not (self.kind == "trace" and self.meta["sees"] == "scale")

    @property
    def laser(self) -> bool:
        """True for a displacement laser."""
        return self.kind == "targets" and self.meta["quantity"] == "displacement"


def history(via: Array, via_t: Array) -> tuple[Array, Array, Array]:
    """Direction (+1/0/-1), distance (mm) and time (s) since the last reversal of each axis."""
    m = len(via)
    sgn, since, revt = np.zeros((m, 3)), np.zeros((m, 3)), np.full((m, 3), 1e6)
    for a in range(3):
        d = np.diff(via[:, a], prepend=via[0, a])
        s = np.where(np.abs(d) > 1e-9, np.sign(d), 0.0)
        idx = np.maximum.accumulate(np.where(s != 0, np.arange(m), -1))
        full = np.where(idx >= 0, s[np.maximum(idx, 0)], 0.0)
        turn = np.flatnonzero(np.diff(full, prepend=0.0) != 0)
        cum = np.cumsum(np.abs(d))
        last = np.maximum.accumulate(np.where(np.isin(np.arange(m), turn), np.arange(m), -1))
        ok = last >= 0
        start = np.maximum(last - 1, 0)
        sgn[:, a] = full
        since[ok, a] = (cum - cum[start])[ok]
        revt[ok, a] = (via_t - via_t[start])[ok]
    return sgn, since, revt


@dataclass
class Part:
    """Contribution of one cause to one file.

    tool (n,3) um: the functional point moves so; scale (n,3) um: the axis's own sensor reports
    so; reading: added by the instrument itself (n_obs,) or (n,3) for a trace; rot (n,3) urad.
    """

    tool: Array | None = None
    scale: Array | None = None
    reading: Array | None = None
    rot: Array | None = None


def observe(rec: Rec, part: Part) -> Array:
    """Channels x readings (um, or urad for angle) that a contribution puts into a file."""
    out = np.zeros((len(rec.channels), rec.n_obs))
    meta = rec.meta
    if rec.kind == "targets":
        if meta["quantity"] == "angle":
            return out if part.rot is None else (part.rot @ meta["rotvec"])[None, :]
        if part.tool is not None:
            out[0] += part.tool @ meta["sensitive"]
    elif rec.kind == "ballbar":
        if part.tool is not None:
            out[0] += (part.tool * meta["unit"]).sum(1)
    elif rec.kind == "features":
        if part.tool is not None:
            out[0] += ((part.tool[1::2] - part.tool[::2]) * meta["direction"]).sum(1)
    else:
        seen = part.tool if meta["sees"] == "tool" else part.scale
        if seen is not None:
            out += seen[:, rec.axes].T
        if part.reading is not None:
            out += part.reading[:, rec.axes].T
        return out
    if part.reading is not None:
        out[0] += part.reading
    return out


@dataclass
class Shape:
    """A drawn effect: `field(rec, amp)` for one file, `params(amp)` as the contract names them."""

    field: Callable[[Rec, float], Part]
    axis: str
    params: Callable[[float], dict[str, float]] = lambda amp: {}
    linear: bool = True
    start: float = 1.0
    most: float = np.inf


@dataclass
class Case:
    """A drawn case: file texts, hidden truth, details for the report, follow-up files."""

    name: str
    files: dict[str, str]
    truth: list[dict]
    details: dict
    follow_up: dict[str, str]
