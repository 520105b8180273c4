"""When names are no answer: something is left that none explains, a curve takes many of them, or the recordings can not be
trusted."""

from __future__ import annotations

from collections import Counter

import numpy as np

from postproc.diagnose import again, shared_jump, structure
from postproc.diagnose.answer import Diagnosis, Finding, floor
from postproc.diagnose.unknown import Unknown, mapped

CURVES, MANY = ("cyclic", "pitch_shape"), 3  # a curve that takes so many names has none
FULLEST = 9  # the highest degree of a curve
HELPINGS = 3  # of one effect, on whatever axes
MUCH_LEFT = 0.1  # of what the largest of them explains: many names that leave so much are none
MOST_LEFT = 0.04  # of what was there: with more left, names are no answer
CONCERNS = 0.3  # of what is left in a signal
NEARLY = 0.3  # of the rms that was there: a single name that leaves no more is the effect
OF_PARTS_MM, OF_EXPLAINED = 1.3e-3, 0.4  # what features have in common and nothing explains: beyond it is unknown
BREAKAWAY = 0.5  # of the friction in motion: so much more may hold a slide when it starts
FAR_OFF, NO_BETTER = 2.5, 0.5  # of the noise, of what it was before: then runs held out do not bear the names out


def _left_of_feature(d: Diagnosis, which: np.ndarray) -> float:
    """mm: what several readings of one feature have in common, over the parts, less three times what chance gives; 0 where it
    was read once a part."""
    products, chance = [], 0.0
    for part in np.unique(d.rows.run[which]):
        own = which & (d.rows.run == part)
        y, n = d.after[own], int(own.sum())
        if n > 1:
            products.append((y.sum() ** 2 - (y**2).sum()) / (n * (n - 1)))
            chance += 2 / (n * (n - 1)) * float(np.mean(floor(d)[own] ** 2)) ** 2
    if not products:
        return 0.0
    return float(np.sqrt(max(np.mean(products) - 3 * np.sqrt(chance) / len(products), 0.0)))


def _of_parts(d: Diagnosis) -> list[structure.Left]:
    """Features that were read several times and have something in common that nothing explains."""
    found = []
    for signal in range(len(d.rows.signals)):
        which = d.rows.signal == signal
        if not which.any() or d.rows.sees[which][0] != "part":
            continue
        rms = _left_of_feature(d, which)
        explained = sum((f.contribution for f in d.findings), np.zeros(len(d.rows)))[which]
        # a part is measured by something that is not exact either
        gauge = 1.3 * (d.recordings[int(d.rows.file[which][0])].u or 0.0)
        ground = np.hypot(np.hypot(OF_PARTS_MM, gauge), OF_EXPLAINED * float(np.sqrt(np.mean(explained**2))))
        if rms > ground:
            share = rms**2 / max(float(np.mean(d.before[which] ** 2)), 1e-30)
            found.append(structure.Left(signal, "place", rms, min(1.0, share)))
    return found


def unknown(d: Diagnosis) -> Unknown | None:
    """What is left that no name explains, with its map. Names become tentative where they are no answer: something like what
    they explain is left, a curve takes many of them, or one effect is needed again and again."""
    false = _curves(d)
    left = structure.unexplained(d.rows, (d.before, d.alone), d.after, d.sigma, ~d.held)
    left += again.left(d.rows, (d.before, d.alone), d.after, d.sigma, d.held, _foretold(d))
    left = sorted(left, key=lambda there: -there.rms) + _of_parts(d)
    rough = max((f.value["size_um"] for f in d.findings if f.block.name == "stick_slip"), default=0.0) / np.sqrt(12.0)
    left = [
        there for there in left if there.rms > rough * 1e-3
    ]  # of what jumps nobody foretells where each reading lies
    for there in left:
        which = (d.rows.signal == there.signal) & ~d.held
        if _takes_nearly_all(d, which):
            continue
        for f in d.findings:
            if f.block.module is shared_jump:
                continue  # several readings bear it out, whatever else one of them holds
            if there.share > MOST_LEFT and float(np.std(f.contribution[which])) > CONCERNS * there.rms:
                f.status = "tentative"
    for f in false:
        f.status = "tentative"
    accepted = [f for f in d.findings if f.status == "accepted"]
    signals = np.unique(d.rows.signal)
    largest = max((float(np.std(f.contribution[d.rows.signal == s])) for f in accepted for s in signals), default=0.0)
    # What takes so many names and is not explained yet is not understood.
    if len(accepted) >= MANY and left and left[0].rms > MUCH_LEFT * largest:
        for f in accepted:
            f.status = "tentative"
    if left:
        return mapped(d, left[0].signal, left[0].rms, left[0].share, d.after)
    if not false:
        return None
    part = sum((f.contribution for f in false), np.zeros(len(d.rows)))
    spread = {int(s): float(np.std(part[d.rows.signal == s])) for s in np.unique(d.rows.signal)}
    signal = max(spread, key=lambda s: spread[s])
    rest = d.after + part
    total = float((d.before**2 / d.sigma**2)[~d.held].sum())
    share = min(1.0, float((rest**2 / d.sigma**2)[~d.held].sum()) / max(total, 1e-9))
    return mapped(d, signal, spread[signal], share, rest - rest[d.rows.signal == signal].mean())


def _takes_nearly_all(d: Diagnosis, which: np.ndarray) -> bool:
    """Whether a single name takes nearly all that these rows (N,) bool hold: then it is that effect, of a form that the library does not
    draw, and what is left is told beside it. Several that share it patch what has another name."""
    names = {f.block.key for f in d.findings if float(np.std(f.contribution[which])) > 0}
    before, after = (float(np.sqrt(np.mean(v[which] ** 2))) for v in (d.before, d.after))
    return len(names) == 1 and after <= NEARLY * before


def _bent(d: Diagnosis) -> set[str]:
    """Axes whose curve of the highest degree needs a swing beside it that is no shorter than what such a curve can follow."""
    shape = {f.block.axis: f.value["degree"] for f in d.findings if f.block.name == "pitch_shape"}
    return {
        f.block.axis for f in d.findings
        if f.block.name == "cyclic" and shape.get(f.block.axis, 0.0) >= FULLEST
        and f.value["period_mm"] * FULLEST > np.ptp(d.rows.state.travel[f.block.axis])
    }  # fmt: skip


def _curves(d: Diagnosis) -> list[Finding]:
    """Findings that imitate another one together: many shapes of one axis, one effect on all axes and more, steps lost by
    several axes."""
    shapes = Counter(f.block.axis for f in d.findings if f.block.name in CURVES)
    names = Counter(f.block.name for f in d.findings)
    bent = _bent(d)
    return [
        f for f in d.findings
        if (f.block.name in CURVES and (shapes[f.block.axis] >= MANY or f.block.axis in bent))
        or names[f.block.name] > (1 if f.block.name == "step_loss" else HELPINGS)
    ]  # fmt: skip


def _turns(d: Diagnosis) -> list[Finding]:
    """Excursions after a turn that are how the friction of that axis turns round, not another cause: with them the axis never lags
    by much more than that friction makes it lag."""
    friction: dict[str, float] = {}
    for f in d.findings:
        if f.block.name == "coulomb_friction":
            friction[f.block.axis] = friction.get(f.block.axis, 0.0) + f.value["size_um"] / 2
    q = np.linspace(0.0, 8.0, 81)
    found = []
    for f in d.findings:
        level = friction.get(f.block.axis, 0.0)
        if f.block.name == "reversal_spike" and level > 0:
            excursion = (f.value["size_um"] + f.value["slope_um"] * q) * np.exp(-q)
            # from minus the friction, before it has turned, to the friction of a slide that starts
            if excursion.min() > -(2 + BREAKAWAY) * level and excursion.max() < BREAKAWAY * level:
                found.append(f)
    return found


def _around_steps(d: Diagnosis) -> np.ndarray:
    """(N,) bool: rows held out between the last reading before a lost step and the first after it: nobody knows when it was."""
    result = np.zeros(len(d.rows), bool)
    t = d.rows.state.time
    for f in d.findings:
        if f.block.name == "step_loss":
            before, after = (t[~d.held & way] for way in (t <= f.value["t_s"], t > f.value["t_s"]))
            result |= (t > before.max(initial=-np.inf)) & (t < after.min(initial=np.inf))
    return result


def _foretold(d: Diagnosis) -> np.ndarray:
    """(N,) bool: readings of which the findings tell what they are in a run that took no part, too. The phase of an oscillation is
    not known there, nor is the moment of a lost step."""
    swings = [f.block.columns for f in d.findings if f.block.name == "vibration"]
    swinging = {int(s) for c in swings for s in np.unique(d.rows.signal[~d.held][np.any(c != 0, axis=1)])}
    return ~np.isin(d.rows.signal, list(swinging)) & ~_around_steps(d)


def _borne_out(d: Diagnosis, f: Finding, rows: np.ndarray) -> bool:
    """Whether these other rows that took no part (N,) bool agree better with a finding than without it."""
    if not rows.any() or float(np.std(f.contribution[rows])) < float(np.sqrt(np.mean(floor(d)[rows] ** 2))):
        return False
    with_it, without = (float(np.mean(v[rows] ** 2)) for v in (d.after, d.after + f.contribution))
    return with_it < NO_BETTER**2 * without


def doubted(d: Diagnosis) -> None:
    """No name is accepted where the recordings can not be trusted, or where the runs that took no part do not bear it out."""
    for f in d.findings if d.doubts else _turns(d):
        f.status = "tentative"
    told = d.held & _foretold(d)
    off = []
    for signal in np.unique(d.rows.signal[told]):
        own = told & (d.rows.signal == signal)
        before, after = (float(np.sqrt(np.mean(v[own] ** 2))) for v in (d.before, d.after))
        ground = float(np.sqrt(np.mean(floor(d)[own] ** 2)))
        which = d.rows.signal == signal
        concerned = [f for f in d.findings if float(np.std(f.contribution[which])) > CONCERNS * after]
        if after > FAR_OFF * ground and after > NO_BETTER * before and concerned:
            off.append((after / ground, int(signal), before, after, ground))
            for f in concerned:
                if not _borne_out(d, f, told & ~which):
                    f.status = "tentative"
    if off and not any(f.status == "accepted" for f in d.findings):
        _, signal, before, after, ground = max(off)
        d.doubts.append(
            f"the runs that took no part are {after * 1e3:.2f} um off in {d.rows.signals[signal]} with these effects and {before * 1e3:.2f} um "
            f"without, where their noise is {ground * 1e3:.2f} um: the recordings contradict each other, or something changed between them"
        )
