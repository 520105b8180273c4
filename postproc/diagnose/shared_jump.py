"""One local departure that several readings of an axis show at the same places: one cause, and not
which.

Positioning, straightness and angle of an axis are measured one after the other, with other optics.
Where they all leave their lines over the same stretch, and what they leave them by keeps one ratio,
the carriage moves there as a whole: it turns (an angle times the arms of the optics), it is pushed
aside along one direction (a dent of the way, a nut that strains), or something of the set-up gives
(a beam that is clipped, a cover that drags). The readings alone can not say which.

Looked for among windows of neighbouring targets: outside the window each signal follows a line,
inside it each target has a value of its own. A window counts where that leaves less than a
polynomial of fifth order does, which has six terms for the whole travel: what is smooth is no jump.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from postproc.diagnose.locate import SIGNIFICANT, Place
from postproc.diagnose.rows import Rows
from postproc.machine.chain import XYZ

PARAMETERS = {
    "from_mm": "mm, the first target that departs",
    "to_mm": "mm, the last",
    "largest_um": "um, the largest departure of the signal that departs most (of an angle urad)",
    "ratio": "um per um, of the signal that departs less to the other",
    "correlation": "1, of the two over all targets",
}
KIND, USE = "machine", "simulate"
TEXT = (
    "Several readings of the axis leave their lines at the same places and in one ratio: one cause."
)
#     value |             * *
#           |           *     *           inside: a value of each target
#           | * * * * *         * * *     outside: one line through both ends
#           +---------[window ]------- place
#
# twice, of two signals: inside one is `ratio` times the other
FEWEST, OUTSIDE = 10, 8  # targets that are wanted, and outside the window
WIDEST = 0.4  # of all targets
CLEAR = 6.0  # times what the rest of the travel departs by
# times the variance (mean of the two signals, by ratios) that a polynomial of fifth order leaves
BETTER = 4.0
ALIKE = 0.95  # correlation
SMALLEST = 2e-3  # mm, or mrad
NEAR = 0.02  # mm: the same target
ONSET = 0.1  # of the largest departure


@dataclass(frozen=True)
class Profile:
    """One signal of one axis: number, kind of signal, places (P,) mm and the mean there over runs
    and directions (P,) mm or rad; sigma of such a mean; rows (P lists) that belong to each
    place."""

    signal: int
    sees: str
    place: np.ndarray
    value: np.ndarray
    sigma: float
    rows: list[np.ndarray]


@dataclass(frozen=True)
class SharedJump:
    """axis; window low, high mm; first, second: the profiles, the larger departure first, and (P,)
    what they depart from their lines by; ratio of second to first and its standard error;
    correlation; left_mm: rms of the second when the first times the ratio is taken off, before_mm:
    when nothing but a line is; polynomial_mm: when a polynomial of fifth order is."""

    axis: str
    low: float
    high: float
    first: Profile
    second: Profile
    departures: tuple[np.ndarray, np.ndarray]
    ratio: float
    ratio_error: float
    correlation: float
    left_mm: float
    before_mm: float
    polynomial_mm: float
    turn: str = ""  # the letter of the axis about which a turn would do this
    angle: str = (
        # whether that angle, measured at these places, "moves" there or is "still"; "" where it was
        # not measured
        ""
    )

    def parameters(self) -> dict[str, float]:
        """As PARAMETERS names them, in its units."""
        return {
            "from_mm": self.low,
            "to_mm": self.high,
            "largest_um": float(self.departures[0][np.abs(self.departures[0]).argmax()] * 1e3),
            "ratio": self.ratio,
            "correlation": self.correlation,
        }

    def inside(self) -> np.ndarray:
        """(P,) bool: targets of the window."""
        return (self.first.place >= self.low - 1e-6) & (self.first.place <= self.high + 1e-6)


def profiles(
    rows: Rows, residual: np.ndarray, sigma: np.ndarray
) -> Iterator[tuple[str, list[Profile]]]:
    """Of every axis the signals of targets in which it alone moves, at enough places."""
    found: dict[str, list[Profile]] = {}
    for signal in range(len(rows.signals)):
        which = np.flatnonzero(rows.signal == signal)
        if not len(which) or rows.kinds[rows.file[which[0]]] != "targets":
            continue
        moving = [x for x, p in rows.state.position.items() if np.ptp(p[which]) > 1e-3]
        if len(moving) != 1:
            continue
        place = np.round(rows.state.position[moving[0]][which], 2)
        places = np.unique(place)
        if len(places) < FEWEST:
            continue
        groups = [which[place == p] for p in places]
        value = np.array([residual[g].mean() for g in groups])
        noise = float(np.median(sigma[which])) / np.sqrt(np.median([len(g) for g in groups]))
        found.setdefault(moving[0], []).append(
            Profile(signal, str(rows.sees[which[0]]), places, value, noise, groups)
        )
    yield from found.items()


def find(rows: Rows, residual: np.ndarray, sigma: np.ndarray) -> list[SharedJump]:
    """At most one of each axis: the clearest pair of signals."""
    result = []
    for axis, several in profiles(rows, residual, sigma):
        pairs = [
            jump
            for i, a in enumerate(several)
            for b in several[i + 1 :]
            if "angle" not in (a.sees, b.sees)
            and _crossing(rows, a, b)
            and (jump := _pair(axis, a, b)) is not None
        ]
        if pairs:
            result.append(_with_angle(rows, max(pairs, key=lambda j: j.correlation**2), several))
    return result


def _with_angle(rows: Rows, jump: SharedJump, several: list[Profile]) -> SharedJump:
    """With what is known of the turn that would do this: about the direction that neither of the
    two is read along."""
    a, b = (rows.direction[p.rows[0][0]] for p in (jump.first, jump.second))
    # positioning along X and straightness in Z: about Y
    k = int(np.abs(np.cross(a, b)).argmax())
    angles = [
        p for p in several if p.sees == "angle" and abs(rows.direction[p.rows[0][0]][k]) > 0.5
    ]
    known = ["moves" if _departs(p, jump) else "still" for p in angles]
    return replace(jump, turn=XYZ[k], angle=known[0] if known else "")


def columns(jump: SharedJump, rows: Rows) -> np.ndarray:
    """(N, K): of each signal and each target of the window, the rows that stand there. What they
    have in common is the jump."""
    place = rows.state.position[jump.axis]
    own = jump.first.place[jump.inside()]
    found = [
        (rows.signal == p.signal) & (np.abs(place - x) < NEAR) & (rows.sees != "angle")
        for p in (jump.first, jump.second)
        for x in own
    ]
    return np.stack(found, axis=1).astype(float)


def causes(jump: SharedJump) -> list[str]:
    """What would do this, as the contract writes names."""
    turn = [] if jump.angle == "still" else [f"abbe:{jump.axis}"]
    return [*turn, f"guideway_dent:{jump.axis}", f"optics:{jump.axis}"]


def words(jump: SharedJump, files: tuple[str, str]) -> str:
    """What was found, in sentences."""
    axis, inside = jump.axis, int(jump.inside().sum())
    largest = jump.parameters()["largest_um"]
    turn = {
        "": (
            f"it turns about {jump.turn} there (that angle was not measured) and the optics stand"
            " off the axis of the turn"
        ),
        "still": f"it does not turn about {jump.turn} there, that angle was measured",
        "moves": (
            f"it turns about {jump.turn} there, as the measured angle does, and the optics stand"
            " off the axis of the turn"
        ),
    }[jump.angle]
    return (
        f"From {jump.low:g} to {jump.high:g} mm of {axis} {files[0]} leaves its line, by"
        f" {largest:.1f} um at most, and {files[1]} follows it with {jump.ratio:.3f} +-"
        f" {1.96 * jump.ratio_error:.3f} um per um (correlation {jump.correlation:.4f}): of its"
        f" {jump.before_mm * 1e3:.2f} um rms {jump.left_mm * 1e3:.2f} are left, and"
        f" {jump.polynomial_mm * 1e3:.2f} with a polynomial of fifth order. One cause, and these"
        f" readings can not say which: the carriage moves as a whole ({turn}; or a dent of the way,"
        " a strained nut or cover pushes it aside in one direction), or the optics gave the same"
        f" false reading twice (a beam clipped near the end). Only {inside} of"
        f" {len(jump.first.place)} targets carry it, and any two jumps at one place look alike so"
        " far. Correct nothing before it is told apart."
    )


def next_test(jump: SharedJump, machine: str) -> str:
    """The experiment that tells the causes apart."""
    axis = jump.axis
    two = (
        f"positioning of {axis} on two lines as far apart across {axis} as the machine allows: a"
        " turn gives two sizes, a dent one, and optics that were mounted anew none: gcomp simulate"
        f" --test positioning:{axis} --machine {machine} --program-out positioning_{axis}.nc"
    )
    if jump.angle:
        return two
    return (
        f"the angle of {axis} about {jump.turn} by angular optics, at the same targets: gcomp"
        f" simulate --test angle:{axis} --machine {machine} --program-out angle_{axis}.nc; or {two}"
    )


def _crossing(rows: Rows, a: Profile, b: Profile) -> bool:
    """Whether two readings are taken along different directions: twice the same tells nothing of a
    common cause."""
    return abs(float(rows.direction[a.rows[0][0]] @ rows.direction[b.rows[0][0]])) < 0.5


def _windows(n: int) -> Iterator[slice]:
    for width in range(3, int(WIDEST * n) + 1):
        if n - width >= OUTSIDE:
            yield from (slice(a, a + width) for a in range(n - width + 1))


def _off_line(profile: Profile, inside: np.ndarray) -> tuple[np.ndarray, float]:
    """(P,) departures from the line through what lies outside, and their rms there (two terms
    counted)."""
    line = np.polyfit(profile.place[~inside], profile.value[~inside], 1)
    off = profile.value - np.polyval(line, profile.place)
    return off, float(np.sqrt(np.sum(off[~inside] ** 2) / ((~inside).sum() - 2)))


def _smooth(profile: Profile) -> float:
    """rms of what a polynomial of fifth order leaves (six terms counted)."""
    u = np.interp(profile.place, [profile.place[0], profile.place[-1]], [-1, 1])
    left = profile.value - np.polynomial.legendre.legval(
        u, np.polynomial.legendre.legfit(u, profile.value, 5)
    )
    return float(np.sqrt(np.sum(left**2) / (len(u) - 6)))


def _pair(axis: str, a: Profile, b: Profile) -> SharedJump | None:
    """The jump that two signals share, if there is one."""
    shared = np.intersect1d(a.place, b.place)
    if len(shared) < FEWEST or len(shared) < max(len(a.place), len(b.place)):
        return None
    best: tuple[float, np.ndarray] | None = None
    n = len(shared)
    for window in _windows(n):
        inside = np.zeros(n, bool)
        inside[window] = True
        # Twice the negative log-likelihood of what is left outside, and the logarithm of n for each
        # target that has a value of its own (Bayesian information criterion): a wide window must
        # earn its width.
        cost = sum(
            (n - inside.sum()) * np.log(max(_off_line(p, inside)[1], p.sigma) ** 2)
            + inside.sum() * np.log(n)
            for p in (a, b)
        )
        if best is None or cost < best[0]:
            best = cost, inside
    if best is None:
        return None
    inside = best[1]
    off, usual = zip(*(_off_line(p, inside) for p in (a, b)), strict=True)
    better = 1.0
    for p, o, rest in zip((a, b), off, usual, strict=True):
        floor = max(rest, p.sigma)
        if np.abs(o[inside]).max() < max(CLEAR * floor, SMALLEST):
            return None
        # of the two as one: each by the ratio of standard deviations, so the product of two is one
        # of variances
        better *= _smooth(p) / floor
    if better < BETTER:
        return None
    correlation = float(np.corrcoef(*off)[0, 1])
    if abs(correlation) < ALIKE:
        return None
    larger = 0 if np.abs(off[0]).max() >= np.abs(off[1]).max() else 1
    first, second = ((a, b), (b, a))[larger]
    x, y = off[larger], off[1 - larger]
    # with a constant: the lines were fitted outside, and both of them a little wrong
    design = np.stack([x, np.ones(n)], axis=1)
    solved = np.linalg.lstsq(design, y, rcond=None)[0]
    left = y - design @ solved
    error = float(np.sqrt(left @ left / (n - 2) / np.sum((x - x.mean()) ** 2)))
    departs = shared[inside & (np.abs(x) > ONSET * np.abs(x).max())]
    return SharedJump(
        axis,
        float(departs.min()),
        float(departs.max()),
        first,
        second,
        (x, y),
        float(solved[0]),
        error,
        correlation,
        float(np.sqrt(np.mean(left**2))),
        float(np.std(second.value)),
        _smooth(second),
    )


def _departs(angle: Profile, jump: SharedJump) -> bool:
    """Whether a measured angle leaves its line over the same stretch."""
    inside = (angle.place >= jump.low - 1e-6) & (angle.place <= jump.high + 1e-6)
    if (~inside).sum() < 4 or not inside.any():
        return False
    off, usual = _off_line(angle, inside)
    return bool(np.abs(off[inside]).max() > CLEAR * max(usual, angle.sigma))


def places(jump: SharedJump, rows: Rows, contribution: np.ndarray) -> list[Place]:
    """Where it is, in each of the signals."""
    result = []
    for profile in (jump.first, jump.second):
        place = rows.state.position[jump.axis]
        inside = np.flatnonzero(
            (rows.signal == profile.signal) & (place > jump.low - NEAR) & (place < jump.high + NEAR)
        )
        off, there = contribution[inside], place[inside]
        result.append(
            Place(
                int(rows.file[inside[0]]),
                profile.signal,
                jump.axis,
                float(there.min()),
                float(there.max()),
                "both",
                tuple(int(r) for r in np.unique(rows.run[inside])[:50]),
                (float(rows.state.time[inside].min()), float(rows.state.time[inside].max())),
                (int(rows.line[inside].min()), int(rows.line[inside].max())),
                float(np.sqrt(np.mean(off**2))),
                float(np.abs(off).max()),
                SIGNIFICANT / 2,
            )
        )
    return result
