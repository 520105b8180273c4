"""Which effects the readings ask for: one after the other, swapped, dropped again, under three guards.

The guards: the map's own error is a nuisance with a size; what has been explained leaves a form error in proportion, so that
the rest of a big effect is not explained by five small ones that are not there; and what is too small to matter is no
finding. score = fall of chi squared - columns * ln(rows) - 2 * ln(shapes of the same effect and axis).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import combinations

import numpy as np

from postproc.diagnose import library, waves
from postproc.diagnose.fit import Projector, inverse, set_ups, solve
from postproc.diagnose.library import Block, found
from postproc.diagnose.parted import parted
from postproc.diagnose.rows import Rows
from postproc.diagnose.stacked import Stack

LEAST_SCORE = 28.0
MATERIAL = 7e-4  # mm
MOST = 6
FORM, FORM_OF_LARGEST = 0.10, 0.03
SWAP, ONE_FOR_TWO = 2.0, 15.0
UNUSUAL = 4.0  # what an unusual sign costs; a module's ODD, if it has one, of the fall of chi squared
RARE = {  # what is taken only where it is clearly better than its kin; below zero: sooner (a circle alone shows no lag, only a difference)
    "servo_mismatch": -3.0, "viscous_friction": 2.0, "coulomb_friction": 2.0, "step_loss": 8.0, "clock_skew": 2.0, "sag": 2.0, "stick_slip": 8.0,
    "scale": 1.4,  # a misaligned beam always reads short, a scale error may be either: half as likely where both say the same
}  # fmt: skip
BESIDE = 12.0  # score that a refined shape must be worth beside the simpler one that its module names
CIRCLES, ALONE = "servo_mismatch", 9.0  # where a log shows each axis alone, each has its own lag
NOTHING = 1e-6  # of a column's power: with less left, the nuisances and the chosen say all that it could
SHORT = 8  # readings of a run
FAR, TURNS = 4.0, 3  # times the noise: a reading at rest so far off is an outlier; how often that is looked at
WIDE = 10.0  # prior standard deviation of chosen coefficients: none


@dataclass
class Model:
    """What was chosen. blocks; coefficients and covariance of all their columns in order; sigma (N,) as it came to be
    inflated; projector without the chosen."""

    blocks: list[Block] = field(default_factory=list)
    coefficients: np.ndarray = field(default_factory=lambda: np.zeros(0))
    covariance: np.ndarray = field(default_factory=lambda: np.zeros((0, 0)))
    sigma: np.ndarray = field(default_factory=lambda: np.zeros(0))
    scores: list[float] = field(default_factory=list)

    def part(self, k: int) -> slice:
        """Where the k-th block's coefficients stand."""
        first = sum(b.columns.shape[1] for b in self.blocks[:k])
        return slice(first, first + self.blocks[k].columns.shape[1])

    def contribution(self, k: int) -> np.ndarray:
        """(N,) mm that the k-th block explains."""
        return self.blocks[k].columns @ self.coefficients[self.part(k)]

    @property
    def explained(self) -> np.ndarray:
        n = len(self.sigma)
        return sum((self.contribution(k) for k in range(len(self.blocks))), np.zeros(n))


class Selector:
    """The readings, their noise, the nuisances, and the dictionary."""

    def __init__(
        self, rows: Rows, y: np.ndarray, sigma: np.ndarray, u: np.ndarray, prior: np.ndarray, blocks: list[Block]
    ):
        self.rows, self.y, self.sigma, self.u, self.prior, self.blocks = rows, y, sigma, u, prior, blocks
        self.least = LEAST_SCORE
        self._made: list[tuple[tuple[int, ...], np.ndarray, Projector]] = []
        self.stack = Stack(u)
        self._restack()
        self.signals = [np.flatnonzero(rows.signal == s) for s in np.unique(rows.signal)]
        self._open = set_ups(u, prior)
        self.short = _short_runs(rows)

    def _restack(self) -> None:
        n = len(self.y)
        self.stack.add([b.columns for b in self.blocks[len(self.stack.parts) :]])
        self.instead = np.array([_instead(b) for b in self.blocks], bool)
        logged = "trace" in self.rows.kinds
        self.penalty = np.array(
            [_penalty(b, n) + (ALONE if logged and b.name == CIRCLES else 0.0) for b in self.blocks]
        )

    def _look(self, chosen: list[int], sigma: np.ndarray) -> None:
        """Let in what is periodic in what the chosen leave."""
        weighted = self.projector(chosen, sigma)(self.y)
        known = {(b.key, b.shape) for b in self.blocks}
        new = [b for b in found(self.rows, weighted, sigma) if (b.key, b.shape) not in known]
        if new:
            self.blocks = self.blocks + new
            self._restack()

    # -- scores --------------------------------------------------------------------------------------------------------

    def projector(self, chosen: list[int], sigma: np.ndarray) -> Projector:
        """The nuisances and the chosen taken out."""
        for known, noise, p in self._made:
            if known == tuple(chosen) and noise is sigma:
                return p
        more = [self.blocks[k].columns for k in chosen]
        scales = [np.full(c.shape[1], WIDE / max(1e-12, float(np.abs(c).max()))) for c in more]
        p = Projector.of(sigma, np.concatenate([self.u, *more], axis=1), np.concatenate([self.prior, *scales]))
        self._made = [*self._made[-7:], (tuple(chosen), sigma, p)]
        return p

    def scores(self, chosen: list[int], sigma: np.ndarray, y: np.ndarray | None = None) -> np.ndarray:
        """(B,) score of every block given the chosen; implausible ones -inf. y may be (N, R): then (B, R), all plausible."""
        p = self.projector(chosen, sigma)
        values = self.y if y is None else y
        after, own, power, inner = self.stack.after(p, sigma, values)
        result = np.full((len(self.blocks), *after.shape[1:]), -np.inf)
        for k, part in enumerate(self.stack.parts):
            if np.any(power[part] < NOTHING * own[part]):
                continue
            b = after[part]
            solved = b / power[part.start] if part.stop - part.start == 1 else inverse(inner[k], own[part], NOTHING) @ b
            fall = np.einsum("i...,i...->...", b, solved)
            if y is None and not plausible(self.blocks[k], solved):
                continue
            odd = 0 if y is not None else unusual(self.blocks[k], solved)
            result[k] = fall - self.penalty[k] - odd * (UNUSUAL + getattr(self.blocks[k].module, "ODD", 0.0) * fall)
        return result

    def calibrate(self, rng: np.random.Generator, draws: int = 200) -> None:
        """The least score so that of recordings of this very design without any effect 1 % find one."""
        n = len(self.y)
        # What has no size beforehand is taken out of every draw again: it need not be put in.
        sized = np.where(self.prior < 0.005, self.prior, 0.0)
        nulls = (self.u * sized) @ rng.normal(size=(self.u.shape[1], draws))
        nulls += self.sigma[:, None] * rng.standard_t(6, size=(n, draws)) * np.sqrt(4 / 6)
        best = self.scores([], self.sigma, nulls)[~self.instead].max(axis=0)
        self.least = max(LEAST_SCORE, float(np.quantile(best, 0.99)))

    # -- selection -----------------------------------------------------------------------------------------------------

    def run(self) -> Model:
        """Choose, swap, drop, reweigh, until nothing changes."""
        chosen: list[int] = []
        sigma = self.sigma
        seen: set[tuple[int, ...]] = set()
        for _ in range(2 * MOST):
            grown = self._grow(chosen, sigma)
            grown = self._merged(self._swap(grown, sigma), sigma)
            grown = self._drop(grown, sigma)
            after = self._reweighed(grown)
            key = tuple(sorted(grown))
            chosen, sigma = grown, after
            if key in seen or len(chosen) >= MOST:
                break
            seen.add(key)
        chosen = parted(self, chosen, sigma, MOST)
        for _ in range(MOST):
            pruned = self._drop(chosen, self._steady(chosen))
            if pruned == chosen:
                break
            chosen = pruned
        return self.fitted(chosen)

    def _grow(self, chosen: list[int], sigma: np.ndarray) -> list[int]:
        self._look(chosen, sigma)
        score = np.where(self.instead, -np.inf, self.scores(chosen, sigma))
        for k in np.argsort(-score):
            if score[k] < self.least:
                break
            if self.fits(chosen, int(k), sigma):
                return [*chosen, waves.polished(self, chosen, int(k), sigma)]
        return chosen

    def fits(self, chosen: list[int], k: int, sigma: np.ndarray) -> bool:
        """Whether a block may stand beside the chosen, whatever its score."""
        alone = not self.instead[k] and self._counts([*chosen, k])
        return alone and self._beside(chosen, k, sigma) and self._material(chosen, k, sigma)

    def let_in(self, block: Block) -> int:
        """The number of a block, which is added where it is new."""
        for k, known in enumerate(self.blocks):
            if (known.key, known.shape) == (block.key, block.shape):
                return k
        self.blocks = [*self.blocks, block]
        self._restack()
        return len(self.blocks) - 1

    def _counts(self, chosen: list[int]) -> bool:
        """The same effect and axis twice is refinement of a shape: twice, no more, and no shape twice; an axis that lost its
        place again and again has drifted."""
        keys = [self.blocks[k].key for k in chosen]
        return len(set(chosen)) == len(chosen) and keys.count(keys[-1]) <= (
            1 if keys[-1].startswith("step_loss") else 2
        )

    def _beside(self, chosen: list[int], k: int, sigma: np.ndarray) -> bool:
        """Whether a block is worth BESIDE or more beside the simpler shape that its module names, if it names one."""
        block = self.blocks[k]
        plain = block.module.beside(dict(block.shape)) if hasattr(block.module, "beside") else None
        if plain is None:
            return True
        columns = library.read(self.rows, block.module, block.axis, plain)
        # Every set-up may have such an error of its own: its beam, its temperature.
        files = [columns * (self.rows.file == f)[:, None] for f in np.unique(self.rows.file)]
        columns = np.concatenate([c for c in files if np.abs(c).max() > 0] or [columns], axis=1)
        columns = columns / max(1e-12, float(np.abs(columns).max()))
        u = np.concatenate([self.u, *(self.blocks[c].columns for c in chosen), columns], axis=1)
        free = np.full(u.shape[1] - self.u.shape[1], WIDE / 1e-6)
        p = Projector.of(sigma, u, np.concatenate([self.prior, free]))
        _, covariance = solve(p, block.columns, self.y)
        after = block.columns.T @ p(self.y)
        return float(after @ covariance @ after) - float(self.penalty[k]) >= BESIDE

    def _swap(self, chosen: list[int], sigma: np.ndarray) -> list[int]:
        for place in range(len(chosen) - 1):
            rest = chosen[:place] + chosen[place + 1 :]
            score = self.scores(rest, sigma)
            score[self.instead & ~self.instead[chosen[place]]] = -np.inf
            good = np.flatnonzero(score > score[chosen[place]] + SWAP)
            for best in map(int, good[np.argsort(-score[good], kind="stable")]):
                if not self._beside(rest, best, sigma):
                    continue  # a plainer shape of the same may do
                if self._counts([*rest, best]) and self._material(rest, best, sigma):
                    chosen = [*chosen[:place], best, *chosen[place + 1 :]]
                break
        return chosen

    def _merged(self, chosen: list[int], sigma: np.ndarray) -> list[int]:
        """Two that one alone says as well are that one."""
        if not 2 <= len(chosen) <= 3:
            return chosen
        for a, b in combinations(chosen, 2):
            rest = [k for k in chosen if k not in (a, b)]
            both = self.projector(rest, sigma).chi2(self.y) - self.projector([*rest, a, b], sigma).chi2(self.y)
            worth = both - float(self.penalty[a] + self.penalty[b])
            score = self.scores(rest, sigma)
            best = int(np.argmax(score))
            if score[best] < worth - ONE_FOR_TWO or best in rest or not self._counts([*rest, best]):
                continue
            if self._beside(rest, best, sigma) and self._material(rest, best, sigma):
                return [*rest, best]
        return chosen

    def _drop(self, chosen: list[int], sigma: np.ndarray) -> list[int]:
        """Without those that the others make needless."""
        while chosen:
            worth = []
            for place, k in enumerate(chosen):
                rest = chosen[:place] + chosen[place + 1 :]
                worth.append(self.worth(rest, k, sigma) if self._material(rest, k, sigma) else -np.inf)
            weakest = int(np.argmin(worth))
            if worth[weakest] >= self.least:
                return chosen
            chosen = chosen[:weakest] + chosen[weakest + 1 :]
        return chosen

    def worth(self, rest: list[int], k: int, sigma: np.ndarray) -> float:
        """The score of one block given the rest."""
        p = self.projector(rest, sigma)
        value, covariance = solve(p, self.blocks[k].columns, self.y)
        b = self.blocks[k].columns.T @ p(self.y)
        if not plausible(self.blocks[k], value):
            return -np.inf
        fall = float(b @ covariance @ b)
        odd = UNUSUAL + getattr(self.blocks[k].module, "ODD", 0.0) * fall
        return fall - float(self.penalty[k]) - unusual(self.blocks[k], value) * odd

    def _material(self, rest: list[int], k: int, sigma: np.ndarray) -> bool:
        """Whether what it adds, after each signal's zero, is large enough somewhere to matter."""
        value, _ = solve(self.projector(rest, sigma), self.blocks[k].columns, self.y)
        return self.size(self.blocks[k].columns @ value) > 1.0

    def size(self, contribution: np.ndarray) -> float:
        """Largest share of what would be material in some signal."""
        worst = 0.0
        for which in self.signals:
            part = contribution[which]
            zero = 0.0 if self.rows.sees[which[0]] == "part" else float(np.median(part))  # features have no set-up zero
            away = np.abs(part - zero)
            few = min(len(away), max(4, len(away) // 400))  # a spike is short: so many readings must show it
            swing = float(np.partition(away, len(away) - few)[len(away) - few])
            worst = max(worst, swing / max(MATERIAL, 0.5 * float(np.median(self.sigma[which]))))
        return worst

    def _reweighed(self, chosen: list[int]) -> np.ndarray:
        """(N,) noise with the form error of what is explained."""
        model = self.fitted(chosen, self.sigma)
        extra = np.zeros(len(self.y))
        for k in range(len(chosen)):
            part = model.contribution(k)
            part = part - self._open @ (self._open.T @ part)  # what a zero takes has no form
            extra += (FORM * part) ** 2
            if (unsure := getattr(self.blocks[chosen[k]].module, "unsure", None)) is not None:
                named = model.blocks[k].module.parameters(
                    model.coefficients[model.part(k)], dict(model.blocks[k].shape)
                )
                extra[np.any(model.blocks[k].columns != 0, axis=1)] += unsure(**named) ** 2
            for run in self.short:  # what comes with time is wrong by the same in all readings of a short run
                extra[run] += (FORM * part[run].mean()) ** 2 * (len(run) - 1)
            for which in self.signals:
                middle = part[which] - np.median(part[which])
                extra[which] += (FORM_OF_LARGEST * np.abs(middle).max()) ** 2
        return np.sqrt(self.sigma**2 + extra)

    def _steady(self, chosen: list[int]) -> np.ndarray:
        """(N,) noise in which readings at rest that lie far off even so count for less: no name rests on a few of them."""
        sigma = self._reweighed(chosen)
        rest = self.rows.state.passage < 0
        steady = sigma
        for _ in range(TURNS):
            p = self.projector(chosen, steady)
            off = np.abs(p(self.y)) / p.w
            steady = np.where(rest & (off > FAR * sigma), np.maximum(sigma, off / 2), sigma)
        return steady

    def fitted(self, chosen: list[int], sigma: np.ndarray | None = None) -> Model:
        """The joint fit of the chosen."""
        model = Model(sigma=self.sigma if sigma is None else sigma)
        if not chosen:
            return model
        if sigma is None:
            model.sigma = self._reweighed(chosen)
        p = self.projector([], model.sigma)
        columns = np.concatenate([self.blocks[k].columns for k in chosen], axis=1)
        model.coefficients, model.covariance = solve(p, columns, self.y)
        model.blocks = [self.blocks[k] for k in chosen]
        if sigma is None:
            model.scores = [self.worth([c for c in chosen if c != k], k, model.sigma) for k in chosen]
        return model


def _short_runs(rows: Rows) -> list[np.ndarray]:
    """The rows of each run of SHORT readings or fewer at rest."""
    still = np.flatnonzero(np.isin(rows.file, [f for f, kind in enumerate(rows.kinds) if kind == "targets"]))
    _, number = np.unique(np.stack([rows.file[still], rows.run[still]]), axis=1, return_inverse=True)
    runs = [still[number.ravel() == k] for k in range(int(number.max(initial=-1)) + 1)]
    return [run for run in runs if len(run) <= SHORT]


def _penalty(block: Block, rows: int) -> float:
    """What a block pays for its columns, for the shapes that it was chosen from, and for a second axis."""
    return block.columns.shape[1] * np.log(rows) + 2 * np.log(block.siblings) + RARE.get(block.name, 0.0)


def _instead(block: Block) -> bool:
    """Whether a shape stands for two causes of one kind, and is taken in their place only."""
    instead = getattr(block.module, "instead", None)
    return instead is not None and instead(dict(block.shape))


def unusual(block: Block, coefficients: np.ndarray) -> int:
    """How many of the named parameters have another sign than they usually have."""
    expected = getattr(block.module, "EXPECTED", None)
    if not expected:
        return 0
    named = block.module.parameters(coefficients, dict(block.shape))
    return sum(named[name] * sign < 0 for name, sign in expected.items())


def plausible(block: Block, coefficients: np.ndarray) -> bool:
    """Whether the named parameters are such as machines have, and such as the name says."""
    limits, sensible = getattr(block.module, "PLAUSIBLE", {}), getattr(block.module, "sensible", None)
    if not limits and sensible is None:
        return True
    named = block.module.parameters(coefficients, dict(block.shape))
    if sensible is not None and not sensible(**named):
        return False
    return all(low <= named[name] <= high for name, (low, high) in limits.items())
