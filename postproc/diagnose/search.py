"""Which set of effects makes the readings most probable: a beam search over sets, each with its own
noise.

A member must be worth more beside the others than noise alone reaches in one of a hundred such
experiments. What comes back at the same places and has no name is a member like the others: a
smooth process of one instrument.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from postproc.diagnose import abrupt, processes, shapes
from postproc.diagnose.evidence import Fit, On
from postproc.diagnose.explained import drawn, shares, wandered, white
from postproc.diagnose.library import found
from postproc.diagnose.prior import plausible, rarity
from postproc.diagnose.sets import RENEWED, Found, Key, Sets

MOST = 6  # members of a set
# sets that are kept, members that are tried beside each, and of these with shapes of their own
WIDTH, CHILDREN, POLISHED = 4, 5, 3
EXCHANGED, ROUNDS = 3, 3  # names that are tried in the place of a member; how often
AHEAD = 3  # members
SEVERAL = 2  # members up to which several jumps at once are looked for
NAMES = 6  # that may stand in the place of a member of what was found
LOOKED_AT = 6  # sets of all that were tried that are compared at one error of form
ALIKE = 6.0  # twice ln(20)
CONVERGED = 12  # steps after which they stay
LEAST = 8.0  # twice ln(55): posterior odds that a member must have at least
NULLS, CHANCE = 64, 0.01


class Search:
    """least: what a member must be worth beside the others."""

    def __init__(self, sets: Sets):
        self.sets = sets
        self.least = LEAST
        self._looked: set[tuple[int, ...]] = set()
        self._with_process: dict[Key, list[Found]] = {}
        self._barred: set[str] = set()  # names whose jumps no readings bear out
        # of fits, by their identity: themselves, and at usual sizes; of these a block's likelier
        # shape: what a search knows that begins again without such a name
        self._usual: dict[int, tuple[Fit, Fit]] = {}
        self._polished: dict[tuple[int, int], int] = {}

    def calibrate(self, rng: np.random.Generator) -> None:
        """The worth that the best of all blocks reaches by noise alone in 1 % of such experiments:
        of nulls drawn with the noise that was learned, by a Gumbel distribution of their maxima."""
        if not len(self.sets.cost):  # no name for what was recorded: rotations alone
            return
        null = self.sets.null()
        draws = drawn(self.sets.evidence, null.fit, rng, NULLS)
        best = (self.sets.evidence.scan(null.fit, draws)[0] - self.sets.cost[:, None]).max(axis=0)
        # Gumbel's distribution has the deviation pi scale / sqrt 6 and the mean mode + 0.5772 scale
        # (Euler's constant); a part p lies beyond mode - scale ln(-ln(1 - p)).
        scale = float(np.std(best)) * np.sqrt(6.0) / np.pi
        tail = float(np.mean(best)) - 0.5772 * scale - scale * np.log(-np.log(1 - CHANCE))
        self.least = max(LEAST, tail)

    def run(self) -> Found:
        """The most probable set of which no jump is one by name only."""
        while True:
            state = self._chosen()
            false = {
                self.sets.blocks[k].key
                for k in state.members
                if self.sets.blocks[k].name == abrupt.NAME
                and not abrupt.borne_out(self.sets, state, k)
            }
            if not false:
                return state
            self._barred |= false

    def _chosen(self) -> Found:
        """The most probable set of which every member is worth its place. Names first; what comes
        back and has no name may take the place of some of them, or come before all of them."""
        alone = self._grown(self.sets.null(), self._processes)
        # Something is there: two or three effects together may say it where none of them alone
        # does.
        something = bool(alone[-1].fit.on) or wandered(self.sets.evidence, self.sets.null().fit)
        named = self._grown(self.sets.null(), self.children, AHEAD if something else 0)
        ends = [*named, *alone[-1:]]
        ends += [self._settled(self._grown(state, self._processes)[-1]) for state in named[-2:]]
        if alone[-1].fit.on:
            ends.append(self._settled(self._grown(alone[-1], self.children)[-1]))
        best = sorted(
            (f for f in self.sets.seen.values() if (f.members or f.fit.on) and self._free(f)),
            key=lambda f: -f.score,
        )[:LOOKED_AT]
        states = [*ends, *best]
        states += [special for state in states for special in self._special(state)]
        return self._dropped(self._commonest(self._likeliest(states), states))

    def _exact(self, states: list[Found]) -> Found | None:
        """The set that says it all: at the noise that it leaves none is better, and none gains by
        terms for an error of its form. None where there is no such set."""
        plain, formed = [], []
        for state in states:
            own = self.sets.at_own_form(state)
            each = [
                self.sets.worth_of(self.sets.evidence.learn(chosen, None, own.fit.on))
                for chosen in (own.members, own.fit.chosen)
            ]
            plain.append(each[0])
            formed.append(each[1] if own.members else -np.inf)
        best = int(np.argmax(plain))
        others = [w for k, w in enumerate(plain) if k != best]
        most = max([*others, *formed], default=-np.inf)
        state = states[best]
        certain = state.members and plain[best] > most + self.least
        return state if certain and self._plausible(state) else None

    # Whole: the rules by which sets are held against one another, in order.
    def _likeliest(self, states: list[Found]) -> Found:
        """Of several sets, all at the same error of form: the largest that any of them has. What
        many explain a little better than one does is that one of another form."""
        least = np.max([self.sets.at_own_form(state).least for state in states], axis=0)

        def worths(state: Found) -> tuple[float, float]:
            """With terms for an error of form, and the larger of that and without them."""
            own = self.sets.at_own_form(state)
            each = [
                self.sets.worth_of(
                    self.sets.evidence.learn(chosen, own.fit, own.fit.on, RENEWED, least)
                )
                for chosen in dict.fromkeys((own.fit.chosen, own.members))
            ]
            return each[0], max(each)

        of_key = {state.key: state for state in states}
        if (exact := self._exact(list(of_key.values()))) is not None:
            return exact
        worth = {key: worths(state) for key, state in of_key.items()}
        found = [(worth[key][0], state) for key, state in of_key.items()]
        most = max(w for w, _ in found)
        if any(w > most - ALIKE and self._plausible(s) for w, s in found):
            # what says the same stands in for a size that can not be
            found = [(w, s) for w, s in found if self._plausible(s)]
        # A process has no form to be wrong: against others of them a name may have exactly its own.
        beside: dict[On, tuple[float, Found]] = {}
        for one in found:
            on = one[1].fit.on
            beside[on] = max(beside.get(on, one), one, key=lambda one: one[0])
        most, best = max(beside.values(), key=lambda one: worth[one[1].key][1])
        # Names that the errors of form do not part are parted as they fit.
        size, on = len(best.members), best.fit.on
        alike = [
            s for w, s in found if w > most - ALIKE and len(s.members) <= size and s.fit.on == on
        ]
        return max(alike, key=self._as_it_fits) if len(alike) > 1 else best

    def _commonest(self, best: Found, states: list[Found]) -> Found:
        """Of the sets that say the same as the best, the one of the commonest names. Two say the
        same where they differ by no more than textbook forms are wrong by: the evidence, which
        takes what is left for noise, parts them by that when there are many readings."""
        rests = [self.sets.without(best, k) for k in best.members]
        states = [*states, *(s for rest in rests for s in self.children(rest, NAMES, best))]
        states += self._special(best)
        for other in sorted(states, key=self._rarity):
            if self._rarity(other) >= self._rarity(best):
                return best
            fewer = len(other.members) <= len(best.members) and other.fit.on == best.fit.on
            if fewer and self._plausible(other) and self.sets.says_the_same(best, other):
                return other
        return best

    def _rarity(self, state: Found) -> float:
        return sum(rarity(self.sets.blocks[k]) for k in state.members)

    def _special(self, state: Found) -> list[Found]:
        """The sets with the special case in the place of a general form; without what else has the
        name of that, and with its shape refined."""
        found = []
        for k in state.members:
            case = self.sets.special(k)
            if case == k:
                continue
            key = self.sets.blocks[case].key
            rest = tuple(m for m in state.members if m != k and self.sets.blocks[m].key != key)
            on, least = state.fit.on, state.least
            case = self._polish(self.sets.evidence.learn(rest, state.fit, on, 0, least), case)
            found.append(self.sets.of((*rest, case), on, state))
        return found

    def _as_it_fits(self, state: Found) -> float:
        """What a set is worth without errors of form, its sizes learned to the end: scores on the
        way there depend on the way."""
        return self.sets.worth_of(
            self.sets.evidence.learn(state.members, state.fit, state.fit.on, CONVERGED)
        )

    def _grown(
        self, start: Found, children: Callable[[Found], list[Found]], ahead: int = 0
    ) -> list[Found]:
        """The best of the sets that grow from one, with each number of members; up to `ahead` of
        them also where a member is worth nothing yet."""
        #     start - children of it -> the WIDTH best -> children of each -> the WIDTH best -> ...
        #                                   |                                    |
        #                             best with one more                best with two more
        # A set is reached by several orders of its members: its key keeps it once.
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
        if state.key not in self._with_process:
            self._with_process[state.key] = processes.more(self.sets, state, CHILDREN)
        return self._with_process[state.key]

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
            best = self.sets.at_own_form(best)
            rests = [self.sets.without(best, k) for k in best.members]
            if not self._plausible(best):
                # One may be of no plausible size, or too small, because of another beside it.
                best = max(rests, key=lambda rest: (self._plausible(rest), rest.score))
                continue
            rests += [
                self.sets.of(best.members, best.fit.on - {process}, best) for process in best.fit.on
            ]
            # a set that can not be stands for no other
            likeliest = max(filter(self._plausible, rests), key=lambda r: r.score, default=None)
            if likeliest is None or best.score - likeliest.score >= self.least:
                return best
            best = likeliest

    def _exchanged(self, state: Found) -> list[Found]:
        """Sets in which another name stands in the place of one of the members."""
        result = []
        for k in state.members:
            rest = self.sets.without(state, k)
            # as it is learned without the member, and as it is learned with it
            with_it = self.sets.evidence.learn(
                rest.fit.chosen, state.fit, rest.fit.on, 0, state.least
            )
            others = {
                other
                for fit in (rest.fit, with_it)
                for other in self._best(fit, EXCHANGED).values()
            }
            # of neither an error of form is known there
            own = self.sets.of((*rest.members, k), rest.fit.on, rest).score
            for other in others - {k}:
                child = self.sets.of((*rest.members, other), rest.fit.on, rest)
                if self._fits(child, other):
                    result.append(replace(child, score=state.score + child.score - own))
        return result

    # Whole: one step of the search: look, rank, fit, keep.
    def children(
        self, state: Found, names: int = CHILDREN, like: Found | None = None
    ) -> list[Found]:
        """Sets with one more member, the most promising ones; at the error of form of `like`, else
        of the set itself."""
        state = state if like else self.sets.at_own_form(state)
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
        for number, now in enumerate((self._at_usual_sizes(state), fit)):
            best |= {key: (now, k) for key, k in self._best(now, names).items() if key not in best}
            if len(chosen) < SEVERAL:  # jumps that only together show
                several = [k for k in shapes.jumps(self.sets, now) if self._allowed(chosen, k)]
                best |= {f"{self.sets.blocks[k].key} {number}": (now, k) for k in several}
        result = []
        for number, (now, k) in enumerate(best.values()):
            tried = {self._polish(now, k), k} if number < POLISHED else {k}
            found = [(self.sets.of((*chosen, one), fit.on, like), one) for one in tried]
            fitting = [child for child, one in found if self._fits(child, one)]
            result += [max(fitting, key=lambda child: child.score)] if fitting else []
        return result

    def _at_usual_sizes(self, state: Found) -> Fit:
        fit = state.fit
        if id(fit) not in self._usual:
            usual = self.sets.evidence.learn(fit.chosen, None, fit.on, 0, state.least)
            self._usual[id(fit)] = fit, usual
        return self._usual[id(fit)][1]

    def _polish(self, fit: Fit, k: int) -> int:
        key = id(fit), k
        if key not in self._polished:
            self._polished[key] = shapes.polished(self.sets, fit, k)
        return self._polished[key]

    def _fits(self, child: Found, k: int) -> bool:
        """Whether a new member can be what its name says."""
        jump = self.sets.blocks[k].name == abrupt.NAME
        return self.sets.fits(child.fit, k) and (not jump or abrupt.borne_out(self.sets, child, k))

    def _best(self, fit: Fit, names: int) -> dict[str, int]:
        """Names that are worth most beside a fit at its sizes, and the block of each."""
        scores, coefficients, _ = self.sets.evidence.scan(fit)
        scores = scores - self.sets.cost
        best: dict[str, int] = {}
        for k in map(int, np.argsort(-scores)):
            if scores[k] < self.least or len(best) >= names:
                break
            block = self.sets.blocks[k]
            if block.key in best or not self._allowed(self.sets.members(fit), k):
                continue
            first = self.sets.evidence.first[k]
            if plausible(block, coefficients[first : first + block.width]):
                best[block.key] = k
        return best

    def _allowed(self, chosen: tuple[int, ...], k: int) -> bool:
        """An effect and axis once: what its shape leaves is a process. An instrument is set up anew
        for each recording."""
        barred = self.sets.blocks[k].key in self._barred
        return not barred and not any(self._excludes(c, k) for c in chosen)

    def _excludes(self, one: int, other: int) -> bool:
        blocks = self.sets.blocks[one], self.sets.blocks[other]
        if {b.name for b in blocks} == {"servo_lag", "servo_mismatch"}:
            # where each lag shows by itself they are two lags
            return any(b.apart for b in blocks) and bool(
                set.intersection(*(set(b.axis) for b in blocks))
            )
        if {b.name for b in blocks} == {"backlash", "backlash_position"}:
            return blocks[0].axis == blocks[1].axis  # the second has a mean
        files = {dict(b.shape).get("file", -1.0) for b in blocks}
        anew = blocks[0].module.KIND == "instrument" and len(files) > 1 and min(files) >= 0
        return blocks[0].key == blocks[1].key and not anew

    def _free(self, state: Found) -> bool:
        return not any(self.sets.blocks[k].key in self._barred for k in state.members)

    def _plausible(self, state: Found) -> bool:
        sized = all(self.sets.fits(state.fit, k) for k in state.members)
        return sized and self.sets.everywhere(state)

    def _look(self, state: Found) -> None:
        """Let in what is periodic in what a set leaves."""
        said = shares(self.sets.evidence, state.fit)
        left = self.sets.evidence.y - sum(v for name, v in said.items() if name not in ("noise",))
        sigma = white(self.sets.evidence, state.fit)
        sigma[sigma == 0.0] = np.inf  # readings of units that take no part
        known = {(b.key, b.shape) for b in self.sets.blocks}
        new = [
            b
            for b in found(self.sets.rows, left / sigma**2, sigma)
            if (b.key, b.shape) not in known
        ]
        if new:
            self.sets.add(new)
