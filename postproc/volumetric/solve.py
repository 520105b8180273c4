"""Least squares over all readings at once: the unknown errors, what belongs to the set-ups, and the
covariance of both."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import compress

import numpy as np
from scipy.optimize import least_squares

from postproc.iso.chance import student
from postproc.machine.chain import XYZ
from postproc.volumetric import VolumetricError, step_diagonals
from postproc.volumetric.rows import Rows, angle_columns, nominal_tip, to_machine, unit_of
from postproc.volumetric.unknowns import Group, Unknowns

FIRST = 1.0  # um or urad: of readings that state none, until their own scatter is known
ROUNDS = 20  # of finding u of readings that state none
SETTLED = 0.01  # of a variance: from one round to the next
# Degrees of freedom below which a scatter tells no u: at 5 its own 95 % reach from 0.6 to 2.5 of it
FEWEST = 5
NOTHING = 1e-4  # um or urad, below any instrument's digit: readings that leave less repeat
# of what one of its own unknowns does to a set-up's readings, mm by mm or rad: less is rounding
FLAT = 1e-6
STATE_IT = "state it: --head u_um=0.5 (standard uncertainty of one reading, um; of angles, urad)"


@dataclass(frozen=True)
class Fit:
    """numbers (P,), covariance (P, P): of the unknowns; rows with their u; left: residuals of each,
    mm or rad; chi: square of the residuals in units of u per degree of freedom, of the readings
    that state their u where some do; free: that number; widened: whether the covariance is
    multiplied by chi; factor: by which it is multiplied in all, Student's t of few degrees of
    freedom with it."""

    unknowns: Unknowns
    numbers: np.ndarray
    covariance: np.ndarray
    rows: tuple[Rows, ...]
    left: tuple[np.ndarray, ...]
    chi: float
    free: int
    widened: bool = False
    factor: float = 1.0

    def values(self, group: Group) -> tuple[np.ndarray, np.ndarray]:
        """(K,) at its nodes (or the one number), and (K,) their standard uncertainty; mm or rad."""
        where = self.unknowns.slices[self.unknowns.groups.index(group)]
        u = np.sqrt(
            np.maximum(
                np.einsum("km,mn,kn->k", group.basis, self.covariance[where, where], group.basis),
                0.0,
            )
        )
        return group.basis @ self.numbers[where], u

    def at(
        self, q: np.ndarray, approach: np.ndarray, tool: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """(3, N) mm deviation of the tip by what was found, and (3, N) its standard uncertainty,
        covariances and all."""
        columns = self.unknowns.columns(q, approach, tool)
        off = np.einsum("p,pin->in", self.numbers, columns)
        return off, np.sqrt(
            np.maximum(np.einsum("pin,pr,rin->in", columns, self.covariance, columns), 0.0)
        )


def _reweighted(
    rows: list[Rows], said: list[bool], found: dict[str, tuple[float, float]]
) -> list[Rows]:
    """The readings with the u that what is left asks for, where none is said. found: chi2 of each
    degree of freedom, and these, by kind."""
    return [
        r if s else replace(r, u=max(r.u * np.sqrt(found[r.kind][0]), NOTHING * unit_of(r) / 2))
        for r, s in zip(rows, said, strict=True)
    ]


def fit(rows: Sequence[Rows], unknowns: Unknowns) -> Fit:
    """Readings that state no u share one for each kind, out of what all set-ups of that kind leave.

    Raises VolumetricError where there are fewer readings than unknowns of the set-ups alone, where
    a set-up does not tell its own unknowns, and where so little is left over that no u follows.
    """
    own = sum(len(r.start) for r in rows)
    number = sum(map(len, rows))
    if number <= own:
        raise VolumetricError(
            f"{number} readings, and the set-ups alone have {own} unknowns",
            "more readings in each set-up",
        )
    said = [not np.isnan(r.u) for r in rows]
    one = _solution(rows, said, unknowns)
    rows, found = one.rows, one.found
    _enough(rows, said, found)
    left = np.split(one.residual[:number], np.cumsum(list(map(len, rows)))[:-1])
    # found out of few degrees of freedom a u is itself uncertain: the least known kind decides
    factor = max([1.0, *(_few(free) for _, free in found.values())])
    # kind "": of all that state their u
    chi, free = _left_over(one.jacobian, one.inverse, one.residual, rows, said, "")
    # Readings that scatter more than they say: what was found is known as much worse.
    # chi squared per degree of freedom scatters by sqrt(2 / free) about 1: three of these are no
    # chance
    widened = any(said) and chi > 1 + 3 * np.sqrt(2 / free)
    if widened:
        factor *= chi * _few(free) * _repeated(rows, said, left)
    # u was made of these very residuals: chi is 1 by construction and judges nothing
    if not any(said):
        chi, free = 1.0, sum(free for _, free in found.values())
    return Fit(
        unknowns, one.x[: unknowns.number],
        one.inverse[: unknowns.number, : unknowns.number] * factor, tuple(rows),
        tuple(part * r.counted for part, r in zip(left, rows, strict=True)), float(chi),
        max(round(free), 1), bool(widened), float(factor),
    )  # fmt: skip


@dataclass(frozen=True)
class _Solution:
    """x: all unknowns, those of the set-ups behind the machine's; found: chi2 of each degree of
    freedom, and these, by kind of reading that states no u; rows: with the u that was found."""

    rows: list[Rows]
    x: np.ndarray
    jacobian: np.ndarray
    inverse: np.ndarray
    residual: np.ndarray
    found: dict[str, tuple[float, float]]


def _solution(rows: Sequence[Rows], said: list[bool], unknowns: Unknowns) -> _Solution:
    """Least squares, the readings weighed again until their u is what is left of them."""
    rows = [replace(r, u=FIRST * unit_of(r)) if np.isnan(r.u) else r for r in rows]
    fixed = [_Fixed.of(r, unknowns) for r in rows]
    # errors begin at zero: they are 1e-4 of the lengths, so that the problem is nearly linear from
    # there
    start = np.concatenate([np.zeros(unknowns.number), *(r.start for r in rows)])
    kinds = sorted({r.kind for r in compress(rows, np.logical_not(said))})
    # u of readings that state none is what is left of them, and what is left depends on the weights
    # that u gives: so in turn, until u stays (a variance component for each kind).
    for _ in range(ROUNDS):
        x, jacobian, residual = _solved(rows, fixed, unknowns, start)
        inverse = _inverse(jacobian, rows, unknowns.number)
        found = {k: _left_over(jacobian, inverse, residual, rows, said, k) for k in kinds}
        one = _Solution(rows, x, jacobian, inverse, residual, found)
        if all(abs(chi - 1) < SETTLED for chi, _ in found.values()):
            break
        rows, start = _reweighted(rows, said, found), x
    return one


def _few(free: float) -> float:
    """By what a variance out of so many degrees of freedom is multiplied, so that 2 u hold as many
    as 2 u of a known one do: Student's t."""
    return float(max(student(max(round(free), 1)) / 2, 1.0) ** 2)


def _repeated(rows: Sequence[Rows], said: Sequence[bool], left: Sequence[np.ndarray]) -> float:
    """How many readings of one place are off alike, on average: 1 where the instrument scatters,
    the number of readings where the model has no nodes for what the machine does there. A variance
    out of readings that were taken as independent is that much too small (the design effect of
    clusters, Kish 1965)."""
    alike = each = 0.0
    for r, s, part in zip(rows, said, left, strict=True):
        # circles have told by `alike` already how many of their readings make one
        if not s or r.alike > 1:
            continue
        at = np.unique(np.round(r.q, 3), axis=1, return_inverse=True)[1].ravel()
        for one in part.reshape(-1, r.q.shape[1]):
            sums = np.bincount(at, one)
            alike, each = alike + float(sums @ sums), each + float(one @ one)
    return max(alike / each, 1.0) if each else 1.0


def _left_over(
    jacobian: np.ndarray,
    inverse: np.ndarray,
    residual: np.ndarray,
    rows: Sequence[Rows],
    said: Sequence[bool],
    kind: str,
) -> tuple[float, float]:
    """Chi squared per degree of freedom, and the degrees of freedom, of the readings of a kind that
    state no u; kind "": of all that state one. What the readings themselves decide is no freedom of
    theirs."""
    mine = [not s and r.kind == kind if kind else s for r, s in zip(rows, said, strict=True)]
    which = np.repeat(mine, [len(r) for r in rows])
    # `counted` has made residuals smaller, so that alike readings weigh as one: taken back for
    # their scatter
    each = residual[: len(which)] * np.repeat(np.sqrt([r.alike for r in rows]), [*map(len, rows)])
    part, scatter = jacobian[: len(which)][which], each[which]
    # trace of the hat matrix of these rows: by how many degrees of freedom they decide the unknowns
    free = len(part) - float(np.einsum("ni,ij,nj->", part, inverse, part, optimize=True))
    return float(scatter @ scatter) / max(free, 1e-6), max(free, 1.0 if not kind else 0.0)


def _enough(
    rows: Sequence[Rows], said: Sequence[bool], found: dict[str, tuple[float, float]]
) -> None:
    """Raises VolumetricError where the scatter of a kind tells no u."""
    for r, s in zip(rows, said, strict=True):
        if s:
            continue
        free = found[r.kind][1]
        if free < FEWEST:
            raise VolumetricError(
                f"{r.name} states no uncertainty, and the readings of its kind ({r.kind}) leave"
                f" {free:.1f} degrees of freedom to tell it by their scatter: {FEWEST} are needed",
                f"{STATE_IT}; or read every place again, or fewer --nodes",
            )
        if r.u < NOTHING * unit_of(r):
            raise VolumetricError(
                f"{r.name} states no uncertainty, and its readings repeat to their last digit: they"
                " tell none",
                STATE_IT,
            )


@dataclass(frozen=True)
class _Fixed:
    """What of a set-up does not change while the unknowns do: columns (P, 3, N), angles (P, N),
    nominal and known (3, N) mm."""

    columns: np.ndarray
    angles: np.ndarray
    nominal: np.ndarray
    known: np.ndarray

    @classmethod
    def of(cls, r: Rows, unknowns: Unknowns) -> _Fixed:
        columns, known = (
            step_diagonals.on_the_beam(partial(of, r.q, r.approach), r.tool, r.aside)
            if r.kind == "stair"
            else of(r.q, r.approach, r.tool)
            for of in (unknowns.columns, unknowns.already)
        )
        if r.kind == "shift" and unknowns.bare.chain.rotary:
            turn = to_machine(unknowns.bare, r.q)
            columns = np.einsum("ijn,pjn->pin", turn, columns)
            known = np.einsum("ijn,jn->in", turn, known)
        return cls(
            columns, angle_columns(unknowns, r), nominal_tip(unknowns.bare, r.q, r.tool), known
        )


def _solved(
    rows: list[Rows], fixed: list[_Fixed], unknowns: Unknowns, start: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Numbers and nuisances, and Jacobian and residuals there, in units of u; the prior stands
    below."""
    #                  unknowns (P)   set-up 1   set-up 2
    #    readings 1    by             more       0            each row in units of its u
    #    readings 2    by             0          more
    #    prior         1 / prior      0          0            holds what no reading tells
    #    stated        0              loose      loose        a place that the file says
    p = unknowns.number
    edges = p + np.cumsum([0, *(len(r.start) for r in rows)])
    stated = np.concatenate([r.start for r in rows])
    loose = np.concatenate([r.loose if len(r.loose) else np.zeros(len(r.start)) for r in rows])

    def residual(x: np.ndarray) -> np.ndarray:
        found = []
        for k, (r, f) in enumerate(zip(rows, fixed, strict=True)):
            off = f.known + np.einsum("p,pin->in", x[:p], f.columns)
            angle = x[:p] @ f.angles if f.angles.shape[1] else np.zeros(r.q.shape[1])
            found.append(r.residual(off, x[edges[k] : edges[k + 1]], f.nominal, angle) / r.counted)
        return np.concatenate([*found, x[:p] / unknowns.prior, (x[p:] - stated) * loose])

    def jacobian(x: np.ndarray) -> np.ndarray:
        made = np.zeros((sum(map(len, rows)) + len(x), len(x)))
        at = 0
        for k, (r, f) in enumerate(zip(rows, fixed, strict=True)):
            off = f.known + np.einsum("p,pin->in", x[:p], f.columns)
            by, more = r.slopes(f.columns, off, x[edges[k] : edges[k + 1]], f.nominal, f.angles)
            made[at : at + len(r), :p] = by / r.counted
            made[at : at + len(r), edges[k] : edges[k + 1]] = more / r.counted
            at += len(r)
        made[at:] = np.diag(np.concatenate([1 / unknowns.prior, loose]))
        return made

    # mm, rad and slopes stand side by side: a step is long or short by what each may be, not by its
    # number.
    scale = np.concatenate([unknowns.prior, np.ones(len(start) - p)])
    done = least_squares(
        residual, start, jacobian, x_scale=scale, method="trf", xtol=1e-12, ftol=1e-12, gtol=1e-12
    )
    return done.x, np.asarray(done.jac), done.fun


def _inverse(jacobian: np.ndarray, rows: Sequence[Rows], unknowns: int) -> np.ndarray:
    """The covariance of everything, k = 1. Raises VolumetricError for a set-up whose own unknowns
    its readings do not tell: each set-up has its own, and the prior holds all others."""
    at, first, last = unknowns, 0, len(jacobian) - jacobian.shape[1]
    for r in rows:
        own = slice(at, at + len(r.start))
        # Its own columns alone, scaled to length 1: a smallest singular value of 0 means that its
        # nuisances move along some direction without any reading of it changing.
        read, held = jacobian[first : first + len(r), own] * r.counted, jacobian[last:, own]
        block = np.vstack([read, held])
        size = np.linalg.norm(block, axis=0)
        least = np.linalg.svd(block / np.maximum(size, FLAT), compute_uv=False)[-1]
        if (size < FLAT).any() or least < FLAT**2:
            raise _too_few(r)
        at, first = own.stop, first + len(r)
    size = np.linalg.norm(jacobian, axis=0)
    # columns of unlike units, scaled before the inverse and back behind it: else digits are lost
    scaled = jacobian / size
    return np.linalg.inv(scaled.T @ scaled) / np.outer(size, size)


def _too_few(r: Rows) -> VolumetricError:
    ways = {
        "length": "columns station_X_mm station_Y_mm station_Z_mm with the station's place, or"
        " lengths at other places too: off the plane through the station",
        "cloud": "points that lie on no line",
    }
    return VolumetricError(
        f"{r.name}: a set-up of {len(r)} readings ({r.kind}) does not tell where it stands",
        ways.get(r.kind, "readings at other places too"),
    )


def corners(fitted: Fit, tool: np.ndarray) -> float:
    """mm: the largest standard uncertainty of the deviation at the corners and the middle of the
    travels."""
    m = fitted.unknowns.bare
    slides = [x for x in XYZ if x in m.letters]
    ends = np.array(
        # ends and middle of each travel: 27 places of three slides
        np.meshgrid(
            *[[m.axes[x].travel[0], sum(m.axes[x].travel) / 2, m.axes[x].travel[1]] for x in slides]
        )
    )
    q = m.at(dict(zip(slides, ends.reshape(len(slides), -1), strict=True)), ends[0].size)
    u = fitted.at(q, np.zeros_like(q), tool)[1]
    return float(np.sqrt((u**2).sum(axis=0)).max())
