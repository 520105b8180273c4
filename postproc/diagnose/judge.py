"""When names are no answer: something comes back that none explains, or the recordings can not be
trusted."""

from __future__ import annotations

import numpy as np
from scipy.special import chdtrc

from postproc.diagnose import locate, telegraph
from postproc.diagnose.answer import Diagnosis, Finding, floor
from postproc.diagnose.block import Block
from postproc.diagnose.explained import shares, white
from postproc.diagnose.noise import FEW, Unit, spread, step
from postproc.diagnose.nuisances import PROCESSES
from postproc.diagnose.sets import MATERIAL, Found, Sets
from postproc.diagnose.unknown import Unknown, mapped

OF_ALL = 0.2  # of what was there: less is not worth a word
OF_EXPLAINED = 0.25  # of what the names explain in a unit: less is an error of their form
# readings; parts into which targets are cut; of the squares without a curve
FEWEST, FOLDS, PREDICTED = 6, 5, 0.95
# times the noise of readings that took no part: 84 nulls left 2.05 at most
UNPREDICTED = 2.5
# mm: what an instrument of which nothing is stated is taken to scatter by at most (unverified; 345
# signals of 100 nulls scattered by 1.44 um at most)
SCATTERS = 1e-3
# mm: samples of a motion, whatever is stated of one reading (237 signals of 170 nulls: 1.16 um at
# most)
MOVING = 1.5e-3
# of what the resolution gives: one division, as which a scale is read (unverified: dial gauges
# repeat to a third of one)
DIVISIONS = 12.0**0.5
# lags and fewest readings of a test of white noise; one recording in a million fails it by chance
LAGS, SERIES, BY_CHANCE = 8, 24, 1e-6
Said = dict[str, np.ndarray]
# Readings at rest, and samples of motions, that lie so many times the scatter of the others off: of
# 409 signals of 160 nulls two and three at most did, by more than 1 um.
TARGETS, SAMPLES, FAR_OFF = 3, 15, 8.0
# times what its file states of one reading a zero wanders by (188 signals of 160 nulls: 5.1 at
# most, where it was more than 1 um)
WANDERS = 5.5
CLEAR = 1 / (locate.DRAWS + 1)  # chance of a region: none of the draws departs as far
NO_BETTER = 1.0  # of the squares without a name, in runs that took no part
NOT_PREDICTABLE = ("vibration", "step_loss")  # in another run: its phase, its moment


def judged(d: Diagnosis, sets: Sets, state: Found) -> Unknown | None:
    """What no name explains, with its map. Names become tentative where the recordings can not be
    trusted, where runs that took no part do not bear them out, where noise reaches what they
    explain, and where more of that comes back than they explain."""
    for f in d.findings:
        if d.disagreements:
            f.status = "tentative"
    said = shares(sets.evidence, state.fit)
    rest = sets.evidence.y - sum(value for kind, value in said.items() if kind != "noise")
    found = [*_left(d, sets, state, said), *_unpredicted(d, sets)]
    found += [*_autocorrelated(sets, state, said, rest), *_scattered(d, sets, said, rest)]
    found += _located(d, sets) + _far_off(sets, said, rest)
    left = sorted(found + _scattered_samples(d, sets, said, rest), reverse=True)
    parts = [part.whole.rows for part in sets.evidence.parts]
    for f in d.findings:
        sizes = [_size(f.contribution[own]) for own in parts]
        if any(sizes[unit] == max(sizes) < rms for _, rms, unit in found):
            f.status = "tentative"
    _borne_out(d)
    _significant(d)
    _electronics(d, sets)
    _curves(d)
    if not left:
        return None
    _, rms, unit = left[0]
    own = sets.evidence.parts[unit].whole.rows
    signal = int(d.rows.signal[own[0]])
    total = float(np.mean(d.before[own] ** 2))
    return mapped(d.rows, d.held, signal, rms, min(1.0, rms**2 / max(total, 1e-30)), d.after)


def _significant(d: Diagnosis) -> None:
    """A name is tentative where the others, with the errors of their forms, leave so little to it
    that noise reaches it: of chi squared its expectation, one for each size, and the threshold."""
    for f in d.findings:
        if f.delta_chi2 < f.block.width + d.least:
            f.status = "tentative"


def _electronics(d: Diagnosis, sets: Sets) -> None:
    """A lost step is tentative where an instrument of the same recording switches between levels:
    one change of its reading may be of that kind too."""
    units = [part.whole for part in sets.evidence.parts]
    files = telegraph.switching(d.rows, units, telegraph.levels(d.rows, units))
    files |= telegraph.switching(d.rows, units, telegraph.steps(d.rows, units))
    for f in d.findings:
        # of all recordings only those whose instrument switches
        own = [f.contribution[d.rows.file == file] for file in files]
        if f.block.name == "step_loss" and any(np.ptp(values) > 0 for values in own):
            f.status = "tentative"


def _curves(d: Diagnosis) -> None:
    """A curve over the place that does not predict the places that are left out of its fit is what
    it says at the targets, no more: as many terms as targets go through all of them and say nothing
    of what lies between. It goes into no machine unasked."""
    for f in d.findings:
        rest = d.rows.state.passage < 0
        own = np.flatnonzero(np.any(f.block.columns != 0, axis=1) & rest & ~d.held)
        if "degree" not in f.block.module.PARAMETERS or f.status != "accepted" or len(own) < FEWEST:
            continue
        place = d.rows.state.position[f.block.axis[0]][own]
        target = np.unique(np.round(place, 2), return_inverse=True)[1]
        with_it, without = _left_out(d, f, own, target)
        f.predictive = with_it <= PREDICTED * without


def _left_out(d: Diagnosis, f: Finding, own: np.ndarray, target: np.ndarray) -> tuple[float, float]:
    """Sums of squares (mm2, over the noise) at targets that were left out, each in its turn with a
    fifth of the others: with the curve fitted to the rest, and without it. own: rows; target: their
    numbers."""
    signals = (d.rows.signal[own][:, None] == np.unique(d.rows.signal[own])).astype(float)
    curve = f.block.columns[own]
    y, w = d.after[own] + f.contribution[own], 1.0 / d.noise[own]
    slab = (
        3.0
        * max(float(np.abs(f.contribution[own]).max()), 1e-6)
        / np.maximum(np.abs(curve).max(axis=0), 1e-12)
    )
    sums = [0.0, 0.0]
    for fold in range(FOLDS):
        # every fifth target in all runs and directions: runs of a target that stays in would tell
        # it
        out = target % FOLDS == fold
        for k, columns in enumerate((np.column_stack([signals, curve]), signals)):
            # zeros are free; terms of the curve at most three times what they are in the whole fit,
            # for with few targets left they would grow without bound
            prior = np.concatenate([np.zeros(signals.shape[1]), 1.0 / slab**2])[: columns.shape[1]]
            a = columns[~out] * w[~out, None]
            normal = a.T @ a + np.diag(prior + 1e-12)
            value = np.linalg.lstsq(normal, a.T @ (y * w)[~out], rcond=None)[0]
            sums[k] += float((((y - columns @ value) * w)[out] ** 2).sum())
    return sums[0], sums[1]


def _size(values: np.ndarray) -> float:
    """mm, the rms of values (N,) where they are: what shows in few of many readings is as large as
    there. That of values spread normally over all of them is their rms."""
    off = values - values.mean()
    # Fourth moment over three times the second: a share p of readings with the variance s2, and 0
    # elsewhere, has 3 p s2^2 / (3 p s2) = s2, whatever p.
    square = float(np.mean(off**2))
    return float(np.sqrt(np.mean(off**4) / (3.0 * square))) if square > 0 else 0.0


def _least(unit: Unit) -> float:
    """mm or rad: what is smaller is as little worth a word as a name of it is."""
    return MATERIAL * 1e-3 if unit.sees == "angle" else MATERIAL


def _left(d: Diagnosis, sets: Sets, state: Found, said: Said) -> list[tuple[float, float, int]]:
    """(times what is worth a word, rms mm, unit) of processes that are no error of form. said: of
    `shares`."""
    found = []
    for unit in sorted({u for u, _ in state.fit.on}):
        part = sets.evidence.parts[unit]
        own = part.unit.rows
        values = sum((said[kind][own] for kind in PROCESSES if kind in said), np.zeros(len(own)))
        rms, explained = _size(values), _size(said["effects"][own])
        least = _least(part.unit)
        there = float(np.std(d.before[own]))
        if rms > max(least, OF_EXPLAINED * explained, OF_ALL * there):
            found.append((rms / least, rms, unit))
    return found


def _unpredicted(d: Diagnosis, sets: Sets) -> list[tuple[float, float, int]]:
    """The same of units whose readings that took no part lie much farther off than their noise,
    whatever wander the others were given: not all that is there was found."""
    found = []
    for unit, part in enumerate(sets.evidence.parts):
        own = part.whole.rows[d.held[part.whole.rows]]
        if len(own) < FEWEST:
            continue
        rms, ground = (float(np.sqrt(np.mean(v[own] ** 2))) for v in (d.after, d.noise))
        explained = float(np.std((d.before - d.after)[own]))
        least = _least(part.whole)
        if rms > max(UNPREDICTED * ground, least, OF_EXPLAINED * explained):
            found.append((rms / least, rms, unit))
    return found


def _autocorrelated(
    sets: Sets, state: Found, said: Said, rest: np.ndarray
) -> list[tuple[float, float, int]]:
    """The same of units of targets whose white noise is none: readings resemble those some readings
    before. Box and Ljung, On a measure of lack of fit in time series models, Biometrika 65, 1978,
    297, on residuals cut at three standard deviations. rest (N,) mm: white noise as fitted."""
    sigma = white(sets.evidence, state.fit)
    found = []
    for unit, part in enumerate(sets.evidence.parts):
        own = part.unit.rows
        if part.unit.dense or len(own) < SERIES:
            continue
        z = np.clip(rest[own] / sigma[own], -3.0, 3.0)
        z -= z.mean()
        if not z.any():
            continue
        lags = np.arange(1, LAGS + 1)
        r = np.array([z[k:] @ z[:-k] for k in lags]) / (z @ z)
        n = len(z)
        # Q of Ljung and Box: chi squared of LAGS degrees of freedom where the noise is white
        portmanteau = n * (n + 2) * float(np.sum(r**2 / (n - lags)))
        rms, least = float(np.std(rest[own])), _least(part.unit)
        worth = max(least, OF_EXPLAINED * _size(said["effects"][own]))
        if chdtrc(LAGS, portmanteau) < BY_CHANCE and rms > worth:
            found.append((rms / least, rms, unit))
    return found


def _scattered(
    d: Diagnosis, sets: Sets, said: Said, rest: np.ndarray
) -> list[tuple[float, float, int]]:
    """The same of units of targets whose readings scatter, or whose zero wanders, by much more than
    their file states that one reading is uncertain, or than instruments do where it states nothing:
    something varies that was not recorded."""
    found = []
    for unit, part in enumerate(sets.evidence.parts):
        own, least = part.unit.rows, _least(part.unit)
        stated = d.recordings[int(d.rows.file[own[0]])].u
        resolution = step(d.rows.y[own])
        sure = stated or max(SCATTERS * least / MATERIAL, DIVISIONS * resolution)
        sure = max(sure, resolution)
        worth = max(least, OF_EXPLAINED * _size(said["effects"][own]))
        wanders = float(np.std(said["wander"][own])) if stated and "wander" in said else 0.0
        limits = [(spread(rest[own]), UNPREDICTED * sure), (wanders, WANDERS * sure)]
        if not part.unit.dense and len(own) >= FEW:
            found += [(rms / least, rms, unit) for rms, most in limits if rms > max(worth, most)]
    return found


def _scattered_samples(
    d: Diagnosis, sets: Sets, said: Said, rest: np.ndarray
) -> list[tuple[float, float, int]]:
    """The same of units of samples of motions, by the standard deviation of the rest (N,) mm. These
    scatter by the moments at which they were taken too, which is no reason to doubt a name."""
    found = []
    for unit, part in enumerate(sets.evidence.parts):
        own, least, rms = part.unit.rows, _least(part.unit), float(np.std(rest[part.unit.rows]))
        stated = d.recordings[int(d.rows.file[own[0]])].u or 0.0
        sure = UNPREDICTED * max(stated, DIVISIONS * step(d.rows.y[own]))
        explained = OF_EXPLAINED * _size(said["effects"][own])
        if part.unit.dense and rms > max(MOVING * least / MATERIAL, sure, explained):
            found.append((rms / least, rms, unit))
    return found


def _far_off(sets: Sets, said: Said, rest: np.ndarray) -> list[tuple[float, float, int]]:
    """The same of units in which several readings lie far beyond what the others scatter by: one
    alone would be an outlier, together they are something that comes and goes. rest (N,) mm."""
    found = []
    for unit, part in enumerate(sets.evidence.parts):
        own, least = part.unit.rows, _least(part.unit)
        if len(own) < SERIES:
            continue
        usual = max(spread(rest[own]), step(sets.evidence.y[own]))
        off = np.abs(rest[own] - np.median(rest[own]))
        most = float(np.sort(off)[-SAMPLES if part.unit.dense else -TARGETS])
        rms, worth = _size(rest[own]), max(least, OF_EXPLAINED * _size(said["effects"][own]))
        if most > max(FAR_OFF * usual, worth) and rms > worth:
            found.append((rms / least, rms, unit))
    return found


def _located(d: Diagnosis, sets: Sets) -> list[tuple[float, float, int]]:
    """The same of units of targets in which a region departs by more than all draws of the noise
    do, and still does beside the names. What a trace or a circle wanders by within a second is not
    among these draws."""
    unit_of = np.full(len(d.rows), -1)
    for unit, part in enumerate(sets.evidence.parts):
        if not part.unit.dense:
            unit_of[part.whole.rows] = unit
    found = []
    for place in d.places:
        own = np.flatnonzero(locate.inside(place, d.rows))
        unit = int(unit_of[own[0]]) if len(own) else -1
        if unit < 0 or place.p > CLEAR or len(own) < FEWEST:
            continue
        square = float(np.mean(d.after[own] ** 2)) - float(np.median(floor(d)[own])) ** 2
        rms, least = float(np.sqrt(max(square, 0.0))), _least(sets.evidence.parts[unit].unit)
        explained = float(np.std((d.before - d.after)[own]))
        if rms > max(least, OF_EXPLAINED * explained):
            found.append((rms / least, rms, unit))
    return found


def predictable(block: Block) -> bool:
    """Whether other runs say how an effect is in a run that took no part; slips are where they
    are seen."""
    return block.name not in NOT_PREDICTABLE and not dict(block.shape).get("scatter")


def _borne_out(d: Diagnosis) -> None:
    """A name is tentative where runs that took no part are no better off with it, though it is
    larger there than their noise."""
    ground = float(np.sqrt(np.mean(d.noise[d.held] ** 2))) if d.held.any() else 0.0
    for f in d.findings:
        own = d.held & (f.contribution != 0)
        if not predictable(f.block) or not own.any() or float(np.std(f.contribution[own])) < ground:
            continue
        with_it, without = (
            float(np.mean((v[own] / d.noise[own]) ** 2))
            for v in (d.after, d.after + f.contribution)
        )
        if with_it > NO_BETTER * without:
            f.status = "tentative"
