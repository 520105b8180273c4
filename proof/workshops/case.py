"""A case: a machine, what its owner measured in a day, and the shop around both."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, TypeVar

import numpy as np

from .base import TURN, Array, Fields, Rng, log_uniform, pick, relaxed
from .machines import Machine
from .readings import noisy, rounded
from .recordings import Recording

T = TypeVar("T")
HEAT_STEP = 5.0  # s


@dataclass(eq=False)
class Hidden:
    """A form of an effect (or of an alien) in a case. shape: um by channel, of a recording and the
    size; parts: um of every feature for size 1; size: its parameter; most: what physics allows;
    rounds: of scaling, more where it is not linear; axes_too, names_too: what says the same;
    force: columns of a trace that pay for it; columns: what else it changes; believable: what must
    hold of the scaled; natural: physics gives the size."""

    effect: str
    axis: str
    form: str
    shape: Callable[[Recording, float], Fields]
    parts: Callable[[Recording], Array] | None = None
    size: float = 1.0
    most: float | None = None
    rounds: int = 1
    axes_too: list[str] = field(default_factory=list)
    names_too: list[str] = field(default_factory=list)
    params: dict[str, Any] = field(default_factory=dict)
    force: Callable[[Recording], dict[str, Array]] | None = None
    columns: Callable[[Recording], None] | None = None
    believable: Callable[[], bool] | None = None
    natural: bool = False
    peak: float = 0.0  # um
    stands_out: float = 0.0  # standard deviations

    def seen(self, rec: Recording) -> Fields:
        """um by channel, at its size."""
        if rec.kind == "features":
            return {"measured": self.size * self.parts(rec)} if self.parts else {}
        return self.shape(rec, self.size)


class Case:
    """t: s, when the next test begins; plan: the tests, in words; air: degrees C, begins at `mean`;
    speeds: (s, rpm) from when the spindle turns; unseen: (from, to, axis, mm/s), motions of which
    nothing was recorded; prefers: an axis that effects prefer, so that pairs meet on one."""

    def __init__(self, r: Rng, machine: Machine) -> None:
        self.r, self.machine = r, machine
        self.t = float(r.integers(0, 60))
        self.recs: list[Recording] = []
        self.plan: list[str] = []
        self.noise: list[dict[str, Any]] = []
        self.hidden: list[Hidden] = []
        self.mean = float(r.uniform(17, 26))
        self.swing, self.period = r.uniform(0.1, 1.2), r.uniform(3e3, 3e4)
        self.phase = r.uniform(0, 6.28)
        self.warming = 0.0  # K/h
        self.speeds: list[tuple[float, float]] = []
        self.unseen: list[tuple[float, float, str, float]] = []
        self.notes_air = bool(r.random() < 0.5)
        self.notes_feed = bool(r.random() < 0.6)
        self.feeds_vary = bool(r.random() < 0.3)
        self.usual_feed = float(pick(r, [500, 1000, 1500, 2000]))
        self.dwell = float(pick(r, [2, 3, 5, 8]))
        self.usual_over = float(pick(r, [0.5, 1, 2, 5, 10]))
        self.prefers = pick(r, machine.axes)
        self._done: list[tuple[Any, tuple[Any, ...], dict[str, Any], Any]] = []

    def once(self, plan: Callable[..., T], *args: Any, **how: Any) -> T:
        """Makes a test, or gives one that was made already and is what is asked for."""
        for made, of, known, found in self._done:
            if made is plan and of == args and all(known.get(k) == v for k, v in how.items()):
                return found
        return self.anew(plan, *args, **how)

    def anew(self, plan: Callable[..., T], *args: Any, **how: Any) -> T:
        """Makes a test, which others may take for theirs."""
        found = plan(self, *args, **how)
        self._done.append((plan, args, how, found))
        return found

    def axis(self, among: list[str] | None = None) -> str:
        """An axis for an effect."""
        among = among or self.machine.axes
        if self.prefers in among and self.r.random() < 0.6:
            return self.prefers
        return pick(self.r, among)

    def other(self, a: str) -> str:
        """Another axis."""
        return pick(self.r, [b for b in self.machine.axes if b != a])

    def both(self, a: str) -> list[str]:
        """The axis and another, in order."""
        b = self.other(a)
        return [x for x in self.machine.axes if x in (a, b)]

    def plane(self, a: str | None = None) -> tuple[str, str]:
        """A plane, of an axis where one is given, that has room for a ballbar if any has."""
        m = self.machine
        if len(m.axes) == 2:
            return m.axes[0], m.axes[1]
        planes = [p for p in (("X", "Y"), ("X", "Z"), ("Y", "Z")) if a is None or a in p]
        wide = [p for p in planes if min(m.length(p[0]), m.length(p[1])) >= 60]
        return pick(self.r, wide or planes)

    def share(self, a: str, rec: Recording) -> Array:
        """0 to 1 over the axis's travel."""
        return self.machine.share(a, rec.pos[a])

    def feed(self, a: str) -> float:
        """mm/min."""
        if not self.feeds_vary:
            return self.usual_feed
        return float(np.round(min(self.machine.vmax[a], log_uniform(self.r, 300, 5000)), -1))

    def over(self, a: str) -> float:
        """mm, by which a sweep passes its last target."""
        return float(min(self.usual_over, 0.03 * self.machine.length(a)))

    def air(self, t: Any) -> Any:
        """degrees C."""
        wave = np.sin(TURN * t / self.period + self.phase) - np.sin(self.phase)
        return self.mean + self.swing * wave + self.warming * np.asarray(t) / 3600

    def read_air(self, rec: Recording) -> Array:
        """degrees C, as a thermometer has it."""
        return np.round(self.air(rec.t) + self.r.normal(size=rec.n) * 0.03, 2)

    def rpm(self, t: Array) -> Array:
        """Of the spindle, at times, s."""
        found = np.zeros(np.shape(t))
        for begins, speed in self.speeds:
            found = np.where(t >= begins, speed, found)
        return found

    def heat(self, a: str, t: Array, tau: float) -> Array:
        """Of an axis, mm/s that it has moved with in the mean of its time constant, s, over all
        recordings so far and the pauses between."""
        recs = [rec for rec in self.recs if rec.kind != "features"]
        way_t = np.concatenate([rec.way_t for rec in recs])
        moved = np.concatenate([np.r_[0, np.abs(np.diff(rec.way[a]))] for rec in recs])
        end = max(way_t.max(), max((to for _, to, _, _ in self.unseen), default=0)) + 10
        grid = np.arange(0, end + 10, HEAT_STEP)
        edges = np.r_[grid, grid[-1] + HEAT_STEP]
        speed = np.histogram(way_t, bins=edges, weights=moved)[0] / HEAT_STEP
        for begins, ends, axis, mm_s in self.unseen:
            if axis == a:
                speed[(grid >= begins) & (grid < ends)] += mm_s
        return np.interp(t, grid, relaxed(speed, HEAT_STEP, tau))

    def late(self, drive: Callable[[Array], Array], t: Array, tau: float) -> Array:
        """What follows drive(t) with a time constant, s, from zero at t = 0."""
        end = float(np.max(t)) + 10
        dt = max(end / 4000, 0.5)
        grid = np.arange(0.0, end + dt, dt)
        return np.interp(t, grid, relaxed(drive(grid), dt, tau))

    def sides(self, rec: Recording) -> Fields:
        """-1 to 1 by axis: the side of the play that the machine's tables know."""
        m = self.machine
        found = {}
        for a in m.axes:
            declared = [effect["size_um"] for effect in m.declared if effect["axis"] == a]
            found[a] = rec.side(a, max([m.by_sides(a), *declared]))
        return found

    def measure(self) -> None:
        """Fills in the readings: map, what is hidden, noise, rounding."""
        for rec in self.recs:
            total = {channel: np.zeros(rec.n) for channel in rec.channels}
            if rec.sees_tables:
                by_map = self.machine.deviation(rec.pos, self.sides(rec))
                for channel, y in rec.project(by_map).items():
                    total[channel] = total[channel] + y
            for hidden in self.hidden:
                for channel, y in hidden.seen(rec).items():
                    total[channel] = total[channel] + y
            for channel, y in total.items():
                rec.read[channel] = rounded(rec, channel, y + noisy(self.r, rec, channel))
            if "T_air_C" in rec.more:
                rec.more["T_air_C"] = self.read_air(rec)
            self._columns(rec)

    def _columns(self, rec: Recording) -> None:
        for hidden in self.hidden:
            if hidden.columns:
                hidden.columns(rec)
        for hidden in self.hidden:
            if hidden.force and rec.kind == "trace":
                for name, y in hidden.force(rec).items():
                    rec.more[name] = rec.more[name] + y if name in rec.more else y


def stacked(c: Case, hidden: Hidden) -> tuple[Array, float]:
    """Of what is hidden, all readings less what their instruments can not know, in standard
    deviations of independent noise; and the largest, um."""
    rows, peak = [], 0.0
    for rec in c.recs:
        seen = hidden.seen(rec)
        for channel in rec.channels:
            if channel not in seen:
                rows.append(np.zeros(rec.n))
                continue
            y = rec.less_zeros(np.asarray(seen[channel], float) + np.zeros(rec.n))
            peak = max(peak, float(np.max(np.abs(y))))
            rho = rec.rho[channel]
            rows.append(y / rec.noise[channel] * np.sqrt((1 - rho) / (1 + rho)))
    return np.concatenate(rows), peak
