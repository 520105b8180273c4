"""What stands in the readings alone: light in the air, beams, instruments that drift, readings that
are wrong; and lost steps.

Light: -0.93 ppm for 1 K and 0.27 ppm for 1 hPa (Edlen's formula at 20 degrees C and 1013 hPa); a
beam that is not parallel reads short by half the square of its angle.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .base import Array, Redraw, Rng, log_uniform, pick, sign
from .case import Case
from .recordings import Recording
from .registry import NUISANCES, Hidden, along, form, read

JUMPS = "laser probing ts_lin tt_lin"
DRIFTS = "laser probing straight ballbar load thermal_etve"
WRONG = "laser probing straight diag ballbar thermal_etve ts_lin features"
AIR = -0.93  # ppm for 1 K

NUISANCES["step_loss"] = lambda c, rec: [rec.project({c.axis: rec.t})]


@form("step_loss", JUMPS)
def jump(c: Case, r: Rng) -> Hidden:
    """jump at any moment that stays"""
    when, s = r.uniform(0.2, 0.8) * c.span, sign(r)
    return along(c.axis, lambda rec: s * (rec.t > when).astype(float))


@form("step_loss", JUMPS)
def jump_at_reversal(c: Case, r: Rng) -> Hidden:
    """jump at a reversal (start against the load), against the new direction"""
    rec = c.recs[0]
    rows = np.flatnonzero(np.diff(rec.sense_of[c.axis])) + 1
    rows = rows[(rows > 0.15 * rec.n) & (rows < 0.85 * rec.n)]
    if not len(rows):
        raise Redraw
    i = pick(r, rows.tolist())
    when, s = rec.t[i] - 1e-6, -rec.sense_of[c.axis][i]
    return along(c.axis, lambda rec: s * (rec.t > when).astype(float))


def _in_air(
    c: Case,
    ppm: Callable[[Recording], Array],
    after: Callable[[Recording, float], None],
    most: float,
    least: float = 0.0,
) -> Hidden:
    """The air's index along the beam, from the first target on."""
    start = c.recs[0].pos[c.axis][0]

    def value(rec: Recording) -> Array:
        return sum(rec.sensitive.values()) * (rec.pos[c.axis] - start) * ppm(rec) * 1e-3

    return read(value, after=after, most=most, least=least)


def _warmer(c: Case) -> Callable[[Recording, float], None]:
    """Thermometers that go with a larger swing of the room."""

    def after(rec: Recording, size: float) -> None:
        for name, true in (
            ("T_air_C", c.room.air(rec.t)),
            ("T_bed_C", c.room.lag(rec.t, c.bed_tau)),
        ):
            if name in rec.more:
                rec.more[name] = rec.more[name] + (size - 1) * (true - 20)

    return after


@form("laser_air", "laser_temp", "")
def uncorrected_air(c: Case, r: Rng) -> Hidden:
    """no correction of the air's temperature (-0.93 ppm/K)"""
    return _in_air(c, lambda rec: AIR * (c.room.air(rec.t) - 20), _warmer(c), 4.0, 0.15)


@form("laser_air", "laser_temp", "")
def lagging_station(c: Case, r: Rng) -> Hidden:
    """the weather station's thermometer lags behind the beam's air"""
    tau = log_uniform(r, 600, 3000)

    def ppm(rec: Recording) -> Array:
        return AIR * (c.room.air(rec.t) - c.room.lag(rec.t, tau))

    return _in_air(c, ppm, _warmer(c), 4.0, 0.15)


@form("laser_air", "laser_long", "")
def weather_front(c: Case, r: Rng) -> Hidden:
    """pressure entered once by hand (+0.27 ppm/hPa), weather front passes"""
    s, end = sign(r), c.span
    noted, seed = r.random() < 0.6, int(r.integers(1 << 30))

    def pressure(rec: Recording) -> Array:
        return s * 4 * np.clip((rec.t / end - 0.1), 0, 1) ** 1.3 + 0.5 * s

    def after(rec: Recording, size: float) -> None:
        if noted:
            scatter = np.random.default_rng(seed).normal(0, 0.05, rec.n)
            rec.more["p_air_hPa"] = 1000 + size * pressure(rec) + scatter

    return _in_air(c, lambda rec: 0.268 * pressure(rec), after, 10.0)


def _dead_path(length: float, warmer: Callable[[Recording], Array]) -> Hidden:
    """length: mm, before the first target; warmer: K, since the laser was set to zero."""
    return read(lambda rec: AIR * warmer(rec) * length * 1e-3, most=3000 / abs(length))


@form("dead_path", "laser_temp", "")
def dead_path_in_room(c: Case, r: Rng) -> Hidden:
    """dead path times the change of the air's temperature since zero"""
    length = r.uniform(300, 1500) * sign(r)
    return _dead_path(length, lambda rec: c.room.air(rec.t) - c.room.air(0))


@form("dead_path", "laser_temp", "")
def dead_path_in_hood(c: Case, r: Rng) -> Hidden:
    """dead path in warm air of the machine's hood (air with a lag)"""
    length, tau = r.uniform(300, 1500) * sign(r), log_uniform(r, 60, 400)
    return _dead_path(length, lambda rec: c.room.lag(rec.t, tau) - c.room.lag(0, tau))


@form("cosine", "laser laser_long", "")
def beam_not_parallel(c: Case, r: Rng) -> Hidden:
    """beam not parallel to the motion: reads too short by theta squared / 2"""
    if "laser" not in c.recs[0].head["instrument"]:
        raise Redraw
    start = c.recs[0].pos[c.axis][0]
    return read(lambda rec: -(rec.pos[c.axis] - start) * 1e-2)


@form("cosine", "probing", "")
def inclined_gauge(c: Case, r: Rng) -> Hidden:
    """gauge line inclined: reads too long by theta squared / 2"""
    start = c.recs[0].pos[c.axis][0]
    return read(lambda rec: (rec.pos[c.axis] - start) * 1e-2)


@form("sensor_drift", DRIFTS, "")
def straight_drift(c: Case, r: Rng) -> Hidden:
    """straight drift with time"""
    s = sign(r)
    return read(lambda rec: s * rec.t / c.span)


@form("sensor_drift", DRIFTS, "")
def warming_electronics(c: Case, r: Rng) -> Hidden:
    """electronics or ballbar warming up exponentially"""
    s, tau = sign(r), r.uniform(0.1, 0.5) * c.span
    return read(lambda rec: s * np.exp(-rec.t / tau))


@form("sensor_drift", DRIFTS, "")
def creep(c: Case, r: Rng) -> Hidden:
    """logarithmic creep of the glue or the stand"""
    s, begin = sign(r), r.uniform(0.02, 0.1) * c.span
    return read(lambda rec: s * np.log1p(rec.t / begin))


def _wrong(c: Case, r: Rng, times: int, rows: int) -> Hidden:
    """Some rows on end are wrong, as often as is said, in one recording."""
    where = c.recs[int(r.integers(len(c.recs)))]
    channel = c.axis if where.kind == "trace" else pick(r, where.channels)
    y = np.zeros(where.n)
    for _ in range(times):
        i = int(r.integers(1, where.n - rows))
        y[i : i + rows] = sign(r) * r.uniform(0.6, 1)
    c.wrong_rows = (where.name, (np.flatnonzero(y) + 1).tolist())
    return Hidden(lambda rec: {channel: y} if rec is where else {})


@form("outlier", WRONG, "")
def single_readings(c: Case, r: Rng) -> Hidden:
    """one to three single readings wrong"""
    return _wrong(c, r, int(r.integers(1, 4)), 1)


@form("outlier", WRONG, "")
def burst(c: Case, r: Rng) -> Hidden:
    """a burst of neighbouring readings wrong"""
    return _wrong(c, r, 1, int(r.integers(2, 5)))
