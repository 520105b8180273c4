"""Which set of effects makes the readings most probable: a beam search over sets, each with its own
noise.

A set is worth twice the logarithm of its evidence, less what its members cost: a rare cause, one of
many shapes that were tried. A member must be worth more beside the others than noise alone reaches
in one of a hundred such experiments. What comes back at the same places and has no name is a member
like the others: a smooth process of one instrument.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from postproc.diagnose import shapes
from postproc.diagnose.evidence import QUIETEST, Evidence, Fit, On
from postproc.diagnose.explained import drawn, shares, wandered, white
from postproc.diagnose.library import Block, found
from postproc.diagnose.prior import cost_of, plausible, unusual
from postproc.diagnose.rows import Rows

MOST = 6  # members of a set
WIDTH, CHILDREN, POLISHED = (
    2,
    5,
    3,
)  # sets that are kept, members that are tried beside each, and of these with shapes of their own
EXCHANGED, ROUNDS = 3, 3  # names that are tried in the place of a member; how often
AHEAD = 3  # members
SEVERAL = 2  # members up to which several jumps at once are looked for
LOOKED_AT = 6  # sets of all that were tried that are compared at one error of form
ALIKE = 6.0  # twice ln(20)
RENEWED = 3  # steps in which sizes are learned again beside a new member
CONVERGED = 12  # steps after which they stay
UNNAMED = 16.0  # of something that has no name: fifty times seldomer than what has one
UNUSUAL = 8.0  # twice ln(55): of a parameter with the sign that it seldom has
LEAST = 8.0  # twice ln(55): posterior odds that a member must have at least
NULLS, CHANCE = 64, 0.01
MATERIAL = 7e-4  # mm
FORM = 0.1  # of what an effect explains at most, a textbook form is wrong by in single readings
OF_OTHERS = 0.1  # of the largest effect that an instrument shows: less is its error of form
FORM_SD = 0.1  # of what it explains, by the place, by the time
BUILT_UP, AFTER_TURN = 5.0, (0.01, 0.05, 0.2)  # times that: while it builds up after a turn; s
FORMED = 1e-3  # mm: the error of form of less is nothing
TOLD = 0.2  # of the white noise
OPEN = 5e-3  # mm: a set-up that may be so far off is open


@dataclass(frozen=True)
class Found:
    """A set: its fit, what it is worth, and the least variance of each unit at which that was
    found."""

    fit: Fit
    score: float
    least: np.ndarray
    members: tuple[int, ...] = ()

    @property
    def key(self) -> tuple:
        return tuple(sorted(self.members)), self.fit.on


class Search:
    def __init__(self, rows: Rows, evidence: Evidence, blocks: list[Block]):
        self.rows, self.evidence = rows, evidence
        evidence.add(blocks)
        self.cost = np.array([cost_of(b) for b in blocks])
        self.least = LEAST
        self._open = [_open(part) for part in evidence.parts]
        self.seen: dict[tuple, Found] = {}
        self._looked: set[tuple] = set()
        self._of_form: dict[int, int] = {}  # terms of an error of form to the member whose it is

    @property
    def blocks(self) -> list[Block]:
        return self.evidence.blocks

    def let_in(self, block: Block) -> int:
        """The number of a block, which is added where it is new."""
        for k, known in enumerate(self.blocks):
            if (known.key, known.shape) == (block.key, block.shape):
                return k
        self.cost = np.append(self.cost, cost_of(block))
        return self.evidence.add([block])[0]

    # -- sets --------------------------------------------------------------------------------------

    def null(self) -> Found:
        """No effect at all."""
        if () not in self.seen:
            fit = self.evidence.learn((), None, steps=3 * RENEWED)
            self.seen[()] = Found(fit, 0.0, np.full(len(self.evidence.parts), QUIETEST))
        return self.seen[()]

    def of(self, chosen: tuple[int, ...], on: On, like: Found) -> Found:
        """A set at the error of form of another one, that it is compared with; its score is that of
        the other and the difference."""
        base = self.at_own_form(like)
        forms = tuple(f for f in base.fit.chosen if self._of_form.get(f, -1) in chosen)
        key = tuple(sorted(chosen)), on, base.fit.chosen, base.fit.on
        if key not in self.seen:
            fit = self._learned((*key[0], *forms), base, on, base.least)
            worth = self._value(fit) - self._value(base.fit)
            self.seen[key] = Found(fit, base.score + worth, base.least, key[0])
        return self.seen[key]

    def _learned(self, chosen: tuple[int, ...], like: Found, on: On, least: np.ndarray) -> Fit:
        """The likelier of two: from what was learned before, and from what is usual. Of a slow
        drift and a wander only one is large."""
        fit = self.evidence.learn(chosen, like.fit, on, RENEWED, least)
        if not wandered(self.evidence, like.fit):
            return fit
        return max(
            fit,
            self.evidence.learn(chosen, like.fit, on, RENEWED, least, afresh=True),
            key=lambda fit: fit.value,
        )

    def _value(self, fit: Fit) -> float:
        members = self.members(fit)
        odd = sum(unusual(self.blocks[k], self.value(fit, k)) for k in members)
        return (
            fit.value
            - float(self.cost[list(members)].sum())
            - UNNAMED * len(fit.on)
            - UNUSUAL * odd
        )

    def at_own_form(self, state: Found) -> Found:
        """The same set with the errors of form of what it explains: terms, and noise no less than
        that."""
        members = self.members(state.fit)
        if not members:
            return state
        key = "own", members, state.fit.on
        if key not in self.seen:
            least, forms = self.form(state.fit), self._forms(state.fit)
            fit = self.evidence.learn((*members, *forms), state.fit, state.fit.on, RENEWED, least)
            self.seen[key] = Found(fit, state.score, least, members)
        return self.seen[key]

    def members(self, fit: Fit) -> tuple[int, ...]:
        """Of a set: the effects, without the terms of their errors of form."""
        return tuple(k for k in fit.chosen if k not in self.evidence.fixed)

    def _forms(self, fit: Fit) -> list[int]:
        """Terms by which what is explained may be of another form, in all instruments alike: larger
        on one end of the travel, at one time, or a little later."""
        made: list[Block] = []
        whose: list[int] = []
        for k in self.members(fit):
            block, value = self.blocks[k], self.value(fit, k)
            part = block.columns @ value
            if np.abs(part).max() < FORMED:
                continue
            terms = [
                part * np.clip(self.rows.state.share(x), -1.2, 1.2)
                for x in block.axis
                if x in self.rows.state.position
            ]
            t = self.rows.state.time
            terms.append(part * (2 * (t - t.min()) / max(float(np.ptp(t)), 1e-9) - 1))
            terms.append(_later(self.rows, part))
            for x in block.axis:
                if x in self.rows.state.since:
                    since = np.where(self.rows.state.passage >= 0, self.rows.state.since[x], np.inf)
                    terms += [BUILT_UP * part * np.exp(-since / tau) for tau in AFTER_TURN]
            columns = np.stack([c for c in terms if np.abs(c).max() > 1e-9], axis=1)
            whose.append(k)
            made.append(
                Block(
                    block.module,
                    block.axis,
                    (("form", float(len(self.blocks) + len(made))),),
                    columns,
                )
            )
        self.cost = np.append(self.cost, np.full(len(made), np.inf))
        numbers = self.evidence.add(made, FORM_SD) if made else []
        self._of_form |= dict(zip(numbers, whose, strict=True))
        return numbers

    def form(self, fit: Fit) -> np.ndarray:
        """(U,) variance of each unit that the error of form of its largest effect gives (1: of its
        white noise)."""
        most = np.zeros(len(self.evidence.parts))
        for k in self.members(fit):
            part = self.blocks[k].columns @ self.value(fit, k)
            for u, (p, free) in enumerate(zip(self.evidence.parts, self._open, strict=True)):
                shown = part[p.unit.rows]
                shown = shown - free @ (free.T @ shown)
                # Of a spike that few readings show, all have the error of a harmonic of its power.
                size = min(_swing(shown), float(np.sqrt(2 * np.mean(shown**2))))
                most[u] = max(most[u], size / float(np.median(p.unit.r)))
        return np.maximum(QUIETEST, (FORM * most) ** 2)

    def value(self, fit: Fit, k: int) -> np.ndarray:
        """(K,) coefficients of a member."""
        return fit.mean[self.part(fit, k)]

    def part(self, fit: Fit, k: int) -> slice:
        """Where a member's coefficients stand among the shared ones."""
        at = self.evidence.shared.shape[1]
        for other in fit.chosen:
            width = self.blocks[other].columns.shape[1]
            if other == k:
                return slice(at, at + width)
            at += width
        raise KeyError(k)

    def calibrate(self, rng: np.random.Generator) -> None:
        """The worth that the best of all blocks reaches by noise alone in 1 % of such experiments:
        of nulls drawn with the noise that was learned, by a Gumbel distribution of their maxima."""
        null = self.null()
        draws = drawn(self.evidence, null.fit, rng, NULLS)
        best = (self.evidence.scan(null.fit, draws)[0] - self.cost[:, None]).max(axis=0)
        scale = float(np.std(best)) * np.sqrt(6.0) / np.pi
        tail = float(np.mean(best)) - 0.5772 * scale - scale * np.log(-np.log(1 - CHANCE))
        self.least = max(LEAST, tail)

    def run(self) -> Found:
        """The most probable set of which every member is worth its place. Names first; what comes
        back and has no name may take the place of some of them, or come before all of them."""
        alone = self._grown(self.null(), self._processes)
        # Something is there: two or three effects together may say it where none of them alone
        # does.
        something = bool(alone[-1].fit.on) or wandered(self.evidence, self.null().fit)
        named = self._grown(self.null(), self.children, AHEAD if something else 0)
        ends = [*named, *alone[-1:]]
        ends += [self._settled(self._grown(state, self._processes)[-1]) for state in named[-2:]]
        if alone[-1].fit.on:
            ends.append(self._settled(self._grown(alone[-1], self.children)[-1]))
        best = sorted(
            (f for f in self.seen.values() if f.members or f.fit.on), key=lambda f: -f.score
        )[:LOOKED_AT]
        return self._dropped(self._likeliest([*ends, *best]))

    def _likeliest(self, states: list[Found]) -> Found:
        """Of several sets, all at the same error of form: the largest that any of them has. What
        many explain a little better than one does is that one of another form."""
        least = np.max([self.at_own_form(state).least for state in states], axis=0)

        def worth(state: Found) -> float:
            own = self.at_own_form(state)
            return self._value(
                self.evidence.learn(own.fit.chosen, own.fit, own.fit.on, RENEWED, least)
            )

        found = [(worth(state), state) for state in {state.key: state for state in states}.values()]
        most, best = max(found, key=lambda one: one[0])
        # Names that the errors of form do not part are parted as they fit.
        size, on = len(best.members), best.fit.on
        alike = [
            s for w, s in found if w > most - ALIKE and len(s.members) <= size and s.fit.on == on
        ]
        return max(alike, key=self._as_it_fits) if len(alike) > 1 else best

    def _as_it_fits(self, state: Found) -> float:
        """What a set is worth without errors of form, its sizes learned to the end: scores on the
        way there depend on the way."""
        return self._value(self.evidence.learn(state.members, state.fit, state.fit.on, CONVERGED))

    def _grown(
        self, start: Found, children: Callable[[Found], list[Found]], ahead: int = 0
    ) -> list[Found]:
        """The best of the sets that grow from one, with each number of members; up to `ahead` of
        them also where a member is worth nothing yet."""
        beam, best = [start], [start]
        for level in range(MOST):
            grown = {}
            for state in beam:
                for child in children(state):
                    if level < ahead or child.score > state.score + self.least:
                        grown[child.key] = child
            if not grown:
                break
            beam = sorted(grown.values(), key=lambda c: -c.score)[:WIDTH]
            if beam[0].score > best[-1].score:
                best.append(beam[0])
            elif level >= ahead:
                break
        return best

    def _processes(self, state: Found) -> list[Found]:
        """Sets with one more process, the most promising ones."""
        state = self.at_own_form(state)
        tried = [
            state.fit.on | {(u, kind)}
            for u, part in enumerate(self.evidence.parts)
            for kind, columns in part.processes.items()
            if columns.any() and (u, kind) not in state.fit.on
        ]
        worth = [
            self.evidence.learn(state.fit.chosen, state.fit, on, 1, state.least).value
            for on in tried
        ]
        best = sorted(range(len(tried)), key=lambda k: -worth[k])[:CHILDREN]
        return [self.of(state.members, tried[k], state) for k in best]

    def _settled(self, best: Found) -> Found:
        """Members dropped that are not worth their place, and exchanged for others that are worth
        more there."""
        for _ in range(ROUNDS):
            best = self._dropped(best)
            better = max([best, *self._exchanged(best)], key=lambda c: c.score)
            if better.score <= best.score + 1.0:
                return best
            best = better
        return self._dropped(best)

    def _dropped(self, best: Found) -> Found:
        """Without members, the weakest first, until every one is worth its place."""
        while True:
            best = self.at_own_form(best)
            rests = [(k, self.without(best, k)) for k in best.members]
            worth = [
                (best.score - rest.score if self._fits(best.fit, k) else -np.inf, rest)
                for k, rest in rests
            ]
            for process in best.fit.on:
                rest = self.of(best.members, best.fit.on - {process}, best)
                worth.append((best.score - rest.score, rest))
            weakest = min(worth, key=lambda w: w[0], default=None)
            if weakest is None or weakest[0] >= self.least:
                return best
            best = weakest[1]

    def worth(self, state: Found, k: int) -> float:
        """Of a member beside the others."""
        state = self.at_own_form(state)
        return state.score - self.without(state, k).score

    def without(self, state: Found, k: int) -> Found:
        return self.of(tuple(c for c in state.members if c != k), state.fit.on, state)

    def _exchanged(self, state: Found) -> list[Found]:
        """Sets in which another name stands in the place of one of the members."""
        result = []
        for k in state.members if len(state.members) > 1 or state.fit.on else ():
            rest = self.without(state, k)
            for other in self._best(rest.fit, EXCHANGED).values():
                if other != k:
                    child = self.of((*rest.members, other), rest.fit.on, state)
                    if self._fits(child.fit, other):
                        result.append(child)
        return result

    def children(
        self, state: Found, names: int = CHILDREN, like: Found | None = None
    ) -> list[Found]:
        """Sets with one more member, the most promising ones; at the error of form of `like`, else
        of the set itself."""
        state = state if like else self.at_own_form(state)
        like = like or state
        chosen, fit = state.members, state.fit
        if (
            like is state
            and state.members not in self._looked
            and len(state.members) not in {len(m) for m in self._looked}
        ):
            self._looked.add(state.members)
            self._look(state)
        # Wander and map may have grown to say what an effect says better: it is asked for beside
        # their usual sizes, too.
        best: dict[str, tuple[Fit, int]] = {}
        for number, now in enumerate(
            (self.evidence.learn(fit.chosen, None, fit.on, 0, state.least), fit)
        ):
            best |= {key: (now, k) for key, k in self._best(now, names).items() if key not in best}
            if len(chosen) < SEVERAL:  # jumps that only together show
                several = [k for k in shapes.jumps(self, now) if self._allowed(chosen, k)]
                best |= {f"{self.blocks[k].key} {number}": (now, k) for k in several}
        result = []
        for number, (now, k) in enumerate(best.values()):
            tried = {shapes.polished(self, now, k), k} if number < POLISHED else {k}
            found = [(self.of((*chosen, one), fit.on, like), one) for one in tried]
            fitting = [child for child, one in found if self._fits(child.fit, one)]
            result += [max(fitting, key=lambda child: child.score)] if fitting else []
        return result

    def _best(self, fit: Fit, names: int) -> dict[str, int]:
        """Names that are worth most beside a fit at its sizes, and the block of each."""
        scores, coefficients, _ = self.evidence.scan(fit)
        scores = scores - self.cost
        best: dict[str, int] = {}
        for k in map(int, np.argsort(-scores)):
            if scores[k] < self.least or len(best) >= names:
                break
            block = self.blocks[k]
            if block.key in best or not self._allowed(self.members(fit), k):
                continue
            first = self.evidence.first[k]
            if plausible(block, coefficients[first : first + block.columns.shape[1]]):
                best[block.key] = k
        return best

    def _allowed(self, chosen: tuple[int, ...], k: int) -> bool:
        """An effect and axis once: what its shape leaves is a process."""
        return self.blocks[k].key not in [self.blocks[c].key for c in chosen]

    def new(self, child: Found, parent: Found) -> int:
        """The member that a set has beside those of another."""
        return next(k for k in child.members if k not in parent.members)

    def _fits(self, fit: Fit, k: int) -> bool:
        """Whether a member is of a plausible size, and somewhere large enough to matter: beside the
        noise, and beside the error of form of the others."""
        value = self.value(fit, k)
        if not plausible(self.blocks[k], value):
            return False
        others = [self.blocks[c].columns @ self.value(fit, c) for c in self.members(fit) if c != k]
        own = self.blocks[k].columns @ value
        for part, free in zip(self.evidence.parts, self._open, strict=True):
            rows = part.unit.rows
            if not own[rows].any():
                continue
            scale = 1e-3 if part.unit.sees == "angle" else 1.0
            least = max(MATERIAL * scale, TOLD * float(np.median(part.unit.r)))
            least = max([least, *(OF_OTHERS * _swing(other[rows]) for other in others)])
            if _swing(own[rows] - free @ (free.T @ own[rows])) > least:
                return True
        return False

    def _look(self, state: Found) -> None:
        """Let in what is periodic in what a set leaves."""
        said = shares(self.evidence, state.fit)
        left = self.evidence.y - sum(v for name, v in said.items() if name not in ("noise",))
        sigma = white(self.evidence, state.fit)
        known = {(b.key, b.shape) for b in self.blocks}
        new = [b for b in found(self.rows, left / sigma**2, sigma) if (b.key, b.shape) not in known]
        if new:
            self.cost = np.append(self.cost, [cost_of(b) for b in new])
            self.evidence.add(new)

    def scores(self, state: Found) -> np.ndarray:
        """(B,) worth of every block beside a set, implausible ones -inf."""
        scores, coefficients, _ = self.evidence.scan(state.fit)
        scores = scores - self.cost
        for k, b in enumerate(self.blocks):
            if k in self.evidence.fixed:
                continue
            first = self.evidence.first[k]
            value = coefficients[first : first + b.columns.shape[1]]
            scores[k] -= UNUSUAL * unusual(b, value)
            if scores[k] > 0 and not plausible(b, value):
                scores[k] = -np.inf
        return scores


def _later(rows: Rows, part: np.ndarray) -> np.ndarray:
    """(N,) by how much what is explained differs from sample to sample of an unbroken motion."""
    result = np.zeros(len(part))
    passage = rows.state.passage
    same = (np.diff(passage) == 0) & (passage[1:] >= 0) & (np.diff(rows.signal) == 0)
    result[1:][same] = np.diff(part)[same]
    return result


def _swing(values: np.ndarray) -> float:
    """The size that so many readings have at least as there must be to show a short spike."""
    few = min(len(values), max(2, len(values) // 2000))
    return float(np.partition(np.abs(values), len(values) - few)[len(values) - few])


def _open(part) -> np.ndarray:
    """(n, M) orthonormal columns of a unit's zeros and set-ups."""
    which = np.isin(
        part.of,
        [k for k, g in enumerate(part.groups) if g.kind in ("zero", "set-up") and g.sd > OPEN],
    )
    if not which.any():
        return np.zeros((len(part.unit), 0))
    q, r = np.linalg.qr(part.raw[part.use][:, which])
    size = np.abs(np.diag(r))
    return q[:, size > 1e-9 * size.max(initial=0.0)]
