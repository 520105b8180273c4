"""Sets of effects and what each is worth, at the errors of form of what it explains.

A set is worth twice the logarithm of its evidence, less what its members cost: a rare cause, one of
many shapes that were tried. No effect has exactly the form of the library: beside each member stand
terms by which it may differ, and no unit's noise is taken for less than that.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import partial
from itertools import islice

import numpy as np

from postproc import effects
from postproc.diagnose import library
from postproc.diagnose.block import Block
from postproc.diagnose.evidence import QUIETEST, Evidence, Fit, On
from postproc.diagnose.explained import wandered, white
from postproc.diagnose.library import FOUND
from postproc.diagnose.parts import Part
from postproc.diagnose.prior import cost_of, plausible, unusual
from postproc.diagnose.rows import Rows

Key = tuple[object, ...]  # members of a set, where it was fitted, by which way

MATERIAL = 1e-3  # mm: of less nobody can say that it comes back, slides repeat to 1 or 2 um
UNNAMED = 16.0  # of something that has no name: fifty times seldomer than what has one
UNUSUAL = 8.0  # twice ln(55): of a parameter with the sign that it seldom has
# of what an effect explains at most, a textbook form is wrong by in single readings, where its
# module does not state it; less is its error of form
FORM = 0.1
FORM_SD = 0.1  # of what it explains, by the place, by the time
BUILT_UP, AFTER_TURN = 5.0, (0.01, 0.05, 0.2)  # times that: while it builds up after a turn; s
# of what an effect predicts for a recording at rest: with less left of it, its error of form
# counted, it is another effect
THERE = 0.4
FORMED = 1e-3  # mm: the error of form of less is nothing
VISIBLE = 0.2  # of the white noise
OPEN = 5e-3  # mm: a set-up that may be so far off is open
AT_ONCE = 32  # blocks: the columns of all of them together take as much memory as they do whitened
RENEWED = 3  # steps in which sizes are learned again beside a new member


@dataclass(frozen=True)
class Found:
    """A set: its fit, what it is worth, and the least variance of each unit at which that was
    found."""

    fit: Fit
    score: float
    least: np.ndarray
    members: tuple[int, ...] = ()

    @property
    def key(self) -> Key:
        return tuple(sorted(self.members)), self.fit.on

    def added_to(self, parent: Found) -> int:
        """The member that it has beside those of another."""
        return next(k for k in self.members if k not in parent.members)


class Sets:
    """The dictionary, and every set of it that was fitted: `seen`. cost: of each block as a member;
    tried: by effect, axis and shape the last blocks that were tried beside it, None where they do
    not show."""

    def __init__(self, rows: Rows, evidence: Evidence, blocks: Iterable[Block]):
        self.rows, self.evidence = rows, evidence
        self.cost = np.zeros(0)
        self.tried: dict[tuple[str, object], Block | None] = {}
        self._number: dict[tuple[str, object], int] = {}  # of each name and shape
        rest = iter(blocks)
        while some := list(islice(rest, AT_ONCE)):
            self.add(some)
        self._open = [_open(part) for part in evidence.parts]
        self.seen: dict[Key, Found] = {}
        # members, and a process that is worth nothing beside them
        self.hopeless: set[tuple[tuple[int, ...], tuple[int, str]]] = set()
        self._of_form: dict[int, int] = {}  # terms of an error of form to the member whose it is

    @property
    def blocks(self) -> list[Block]:
        return self.evidence.blocks

    def let_in(self, block: Block) -> int:
        """The number of a block, which is added where it is new."""
        known = self._number.get((block.key, block.shape))
        return self.add([block])[0] if known is None else known

    def add(self, blocks: list[Block]) -> list[int]:
        """Let blocks in; their numbers."""
        self.cost = np.append(self.cost, [cost_of(b) for b in blocks])
        numbers = self.evidence.add(blocks)
        for k, b in zip(numbers, blocks, strict=True):
            self._number.setdefault((b.key, b.shape), k)
        return numbers

    def special(self, k: int) -> int:
        """The number of the special case of a block, or its own where it is of no general form."""
        block = self.blocks[k]
        case = getattr(block.module, "special", lambda **_: None)(**dict(block.shape))
        if case is None:
            return k
        name, shape = case
        module = effects.load(name)
        make = partial(library.read, self.rows, module, block.axis, shape)
        siblings = next((b.siblings for b in self.blocks if b.key == f"{name}:{block.axis}"), 1)
        return self.let_in(Block(module, block.axis, library.named(shape), make, siblings))

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
            worth = self.worth_of(fit) - self.worth_of(base.fit)
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

    def worth_of(self, fit: Fit) -> float:
        """Of a fit: its evidence, less what its members cost."""
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

    def everywhere(self, state: Found) -> bool:
        """Whether every member is, with its error of form, in each recording of readings at rest in
        which it should show: one that is there in one and gone in the next is another effect."""
        fit = self.at_own_form(state).fit
        wrong = {k: np.zeros(len(self.rows)) for k in state.members}
        for f in fit.chosen:
            if self._of_form.get(f, -1) in wrong:
                wrong[self._of_form[f]] += self.blocks[f].columns @ self.value(fit, f)
        rests = [part.unit.rows for part in self.evidence.parts if not part.unit.dense]
        for k, error in wrong.items():
            said = self.blocks[k].columns @ self.value(fit, k)
            for own in rests:
                size, off = said[own], error[own]
                if np.abs(size).max() > FORMED and size @ (size + off) < THERE * (size @ size):
                    return False
        return True

    def _forms(self, fit: Fit) -> list[int]:
        """Terms by which what is explained may be of another form, in all instruments alike: larger
        on one end of the travel, at one time, or a little later."""
        made: list[Block] = []
        whose: list[int] = []
        for k in self.members(fit):
            block, value = self.blocks[k], self.value(fit, k)
            if np.abs(block.columns @ value).max() < FORMED:
                continue
            whose.append(k)
            shape = (("form", float(len(self.blocks) + len(made))),)
            terms = partial(_terms, self.rows, block, value)
            made.append(Block(block.module, block.axis, shape, terms))
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
                size = min(_amplitude(shown), float(np.sqrt(2 * np.mean(shown**2))))
                size *= form_of(self.blocks[k])
                most[u] = max(most[u], size / float(np.median(p.unit.r)))
        return np.maximum(QUIETEST, most**2)

    def says_the_same(self, best: Found, other: Found) -> bool:
        """Whether two sets differ by less than the error of form of what they do not explain by the
        same members; the form is that of the members of the other one."""
        both = tuple(k for k in best.members if k in other.members)
        wrong = (form_of(self.blocks[k]) for k in other.members if k not in both)
        by = max(wrong, default=FORM)
        common = self.of(both, best.fit.on, best)
        most, less, least = (self.explained(state) for state in (best, other, common))
        sigma = white(self.evidence, best.fit)
        return self.shown(most - less, sigma) < by * self.shown(most - least, sigma)

    def explained(self, state: Found) -> np.ndarray:
        """(N,) mm that the members say of the readings, without terms for errors of form."""
        fit = state.fit
        if fit.chosen != state.members:
            fit = self.evidence.learn(state.members, fit, fit.on, RENEWED)
        parts = (self.blocks[k].columns @ self.value(fit, k) for k in state.members)
        return sum(parts, np.zeros(len(self.rows)))

    def shown(self, values: np.ndarray, sigma: np.ndarray) -> float:
        """Root of the sum of squares of values (N,) over the noise sigma (N,), without what zeros
        that are open may take."""
        total = 0.0
        for part, free in zip(self.evidence.parts, self._open, strict=True):
            own = values[part.unit.rows]
            left = (own - free @ (free.T @ own)) / sigma[part.unit.rows]
            total += float(left @ left)
        return float(np.sqrt(total))

    def value(self, fit: Fit, k: int) -> np.ndarray:
        """(K,) coefficients of a member."""
        return fit.mean[self.part(fit, k)]

    def part(self, fit: Fit, k: int) -> slice:
        """Where a member's coefficients stand among the shared ones."""
        before = fit.chosen[: fit.chosen.index(k)]
        at = self.evidence.shared.shape[1] + sum(self.blocks[other].width for other in before)
        return slice(at, at + self.blocks[k].width)

    def worth(self, state: Found, k: int) -> float:
        """Of a member beside the others."""
        state = self.at_own_form(state)
        return state.score - self.without(state, k).score

    def without(self, state: Found, k: int) -> Found:
        return self.of(tuple(c for c in state.members if c != k), state.fit.on, state)

    def fits(self, fit: Fit, k: int) -> bool:
        """Whether a member is of a plausible size, and somewhere large enough to matter: beside the
        noise, and beside the error of form of the others."""
        value = self.value(fit, k)
        if not plausible(self.blocks[k], value):
            return False
        others = [
            form_of(self.blocks[c]) * self.blocks[c].columns @ self.value(fit, c)
            for c in self.members(fit)
            if c != k
        ]
        own = self.blocks[k].columns @ value
        for unit, free in zip(self.evidence.parts, self._open, strict=True):
            rows = unit.unit.rows
            if not own[rows].any():
                continue
            scale = 1e-3 if unit.unit.sees == "angle" else 1.0
            least = max(MATERIAL * scale, VISIBLE * float(np.median(unit.unit.r)))
            shown = [
                _amplitude(part[rows] - free @ (free.T @ part[rows])) for part in (own, *others)
            ]
            if shown[0] > max([least, *shown[1:]]):
                return True
        return False

    def scores(self, state: Found) -> np.ndarray:
        """(B,) worth of every block beside a set, implausible ones -inf."""
        scores, coefficients, _ = self.evidence.scan(state.fit)
        scores -= self.cost
        for k, b in enumerate(self.blocks):
            if k in self.evidence.fixed:
                continue
            first = self.evidence.first[k]
            value = coefficients[first : first + b.width]
            scores[k] -= UNUSUAL * unusual(b, value)
            if scores[k] > 0 and not plausible(b, value):
                scores[k] = -np.inf
        return np.asarray(scores)


def form_of(block: Block) -> float:
    """Of what a block explains at most: by how much its form is wrong in single readings."""
    return float(getattr(block.module, "FORM", FORM))


def _terms(rows: Rows, block: Block, value: np.ndarray) -> np.ndarray:
    """(N, M) mm: by what a block at a size may be of another form than its own."""
    part, state = block.columns @ value, rows.state
    terms = [part * np.clip(state.share(x), -1.2, 1.2) for x in block.axis if x in state.position]
    t = state.time
    # -1 to 1 from the first to the last moment: it grows or fades
    terms.append(part * (2 * (t - t.min()) / max(float(np.ptp(t)), 1e-9) - 1))
    if block.name not in FOUND:  # a wave has its own phase
        terms.append(_later(rows, part))
    for x in block.axis:
        if x in state.since:
            since = np.where(state.passage >= 0, state.since[x], np.inf)
            # less, or more, while it builds up: at rest since is inf, and nothing of it
            terms += [BUILT_UP * part * np.exp(-since / tau) for tau in AFTER_TURN]
    return np.stack([c for c in terms if np.abs(c).max() > 1e-9]).T


def _later(rows: Rows, part: np.ndarray) -> np.ndarray:
    """(N,) by how much what is explained differs from sample to sample of an unbroken motion."""
    result = np.zeros(len(part))
    passage = rows.state.passage
    same = (np.diff(passage) == 0) & (passage[1:] >= 0) & (np.diff(rows.signal) == 0)
    result[1:][same] = np.diff(part)[same]
    return result


def _amplitude(values: np.ndarray) -> float:
    """The size that so many readings have at least as there must be to show a short spike."""
    few = min(len(values), max(2, len(values) // 2000))
    return float(np.partition(np.abs(values), len(values) - few)[len(values) - few])


def _open(part: Part) -> np.ndarray:
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
