"""Is every sign right? What is left of the deviation before, as a ratio, for each direction of
approach and for the reversal.

With b before and a after, both about their own zero (a straightness about its line), a = ratio * b
in the least squares of b: 0 where the correction took b out, 1 where nothing happened, 2 where it
was added instead. The scatter of the means of b lengthens sum(b^2), and is taken off it; U is of
first order in both (JCGM 100, 5.1.2), with Student's t.
"""

from __future__ import annotations

import numpy as np

from postproc.accept import Ratio
from postproc.iso.chance import student
from postproc.iso.positioning import Positioning
from postproc.iso.sampling import noise_of

WAYS = ("approached in +", "approached in -")
REVERSAL = "reversal"
# half way between 0, 1 and 2
LIMITS = ((-0.5, "too much"), (0.5, "good"), (1.5, "nothing"), (np.inf, "turned"))
LEAST = 0.3e-3  # mm or rad * m: an rms of less no correction is judged by


def ratios(before: Positioning, after: Positioning, line: bool) -> list[Ratio]:
    """One for each direction that both have, and one for the reversal where both directions speak
    alike.

    line: whether a slope is the set-up's (a straightness), and not looked at.
    """
    ub, ua = _u(before), _u(after)
    dof = _dof(before, after)
    out = []
    order = 2 if line else 1
    for way in (0, 1):
        used = np.isfinite(before.mean[way]) & np.isfinite(after.mean[way])
        if used.sum() > order + 1:
            # a constant, or a line and a constant: what setting up the instrument decides, before
            # and after alike
            terms = np.vander(before.target[used] / max(before.length, 1e-9), order)
            b, a = (_about(m[way][used], terms) for m in (before.mean, after.mean))
            out.append(_ratio(WAYS[way], b, a, ub[way][used], ua[way][used], dof, terms.shape[1]))
    verdicts = {r.verdict for r in out} - {"undecided", "between"}
    used = before.both & after.both
    # Where one direction says taken out and the other turned, a ratio of the reversal would be of
    # two things at once, and name neither.
    if before.two_way and after.two_way and len(verdicts) < 2 and used.any():
        b, a = before.reversal[used], after.reversal[used]
        u = np.sqrt((np.stack([ub, ua])[:, :, used] ** 2).sum(axis=1))
        out.append(_ratio(REVERSAL, b, a, u[0], u[1], dof, 0))
    return out


def _about(y: np.ndarray, terms: np.ndarray) -> np.ndarray:
    """What is left of y beside its zero, or its line."""
    return y - terms @ np.linalg.lstsq(terms, y, rcond=None)[0]


def _u(test: Positioning) -> np.ndarray:
    """(2, m) mm or rad: standard uncertainty of the means by the scatter of the runs, 0 where each
    has one run."""
    noise = noise_of(test.s, test.n)
    return np.zeros(test.mean.shape) if noise is None else np.nan_to_num(noise.u)


def _dof(*tests: Positioning) -> float:
    found = [noise_of(t.s, t.n) for t in tests]
    return float(min((np.nanmax(n.dof) for n in found if n is not None), default=0.0))


def _ratio(
    of: str, b: np.ndarray, a: np.ndarray, ub: np.ndarray, ua: np.ndarray, dof: float, taken: int
) -> Ratio:
    share = (len(b) - taken) / len(b)
    # E(b b) is the true b squared and the variances of its means: without this the ratio of noisy
    # means would come out too near 0. The zero (and line) took the share of `taken` of them.
    size2 = float(b @ b) - share * float(ub @ ub)
    rms = float(np.sqrt(b @ b / max(len(b) - taken, 1)))
    if size2 <= 0 or rms < LEAST:
        return Ratio(of, 0.0, None, rms, "undecided")
    value = float(a @ b) / size2
    # d value / d b_i is (a_i - 2 value b_i) / size2, d value / d a_i is b_i / size2
    slope = a - 2 * value * b
    u = np.sqrt(float((b**2) @ (ua**2) + slope**2 @ (ub**2))) / size2
    # a = value b + what does not follow b: with one run each, its scatter is all that is known of
    # either mean.
    if not dof:  # single runs: what does not follow b is all that is known of the scatter
        free = max(len(b) - taken - 1, 1)
        u, dof = np.sqrt(float(np.sum((a - value * b) ** 2)) / free / size2), free
    wide = student(dof) * u
    return Ratio(of, value, wide, rms, _verdict(value, wide))


def _verdict(value: float, wide: float) -> str:
    """Where the whole interval lies; "undecided" where it reaches over more than two of the
    ranges."""
    # limits half way between 0, 1 and 2: below 0.5 taken out, to 1.5 nothing happened, beyond it
    # turned
    low, high = (
        (next(v for limit, v in LIMITS if at < limit)) for at in (value - wide, value + wide)
    )
    if low == high:
        return low
    return "undecided" if wide > 0.5 else "between"
