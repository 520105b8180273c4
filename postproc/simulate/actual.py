"""Where the tool really is: the machine's tables and every effect of its file, at a state of the
timeline.

Effects that a place alone decides stand in the machine's model as tables, for the compensator; here
they are taken from their own equations like all others, so that each acts once, with its whole
history.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from types import ModuleType

import numpy as np

from postproc import effects
from postproc.effects import State
from postproc.errors import GcompError
from postproc.machine.model import Machine
from postproc.simulate.timeline import Timeline, joined


@dataclass(frozen=True)
class Term:
    """An effect at work: its module, its axis ("" for the whole machine) and its parameters."""

    module: ModuleType
    axis: str
    parameters: dict[str, float]

    @property
    def name(self) -> str:
        """The effect's, as in the library."""
        return self.module.__name__.rsplit(".", 1)[1]

    @property
    def key(self) -> str:
        """effect:axis."""
        return f"{self.name}:{self.axis}" if self.axis else self.name


def terms_of(machine: Machine) -> tuple[Term, ...]:
    """The physics of the machine's file; what is the fault of an instrument or of data is not the
    machine's."""
    found = [Term(e.module, e.axis, e.parameters) for e in machine.effects if e.module is not None]
    return tuple(t for t in found if t.module.KIND == "machine")


@dataclass(frozen=True)
class Reality:
    """A timeline, and the effects at work: those of the machine and those that were asked for."""

    timeline: Timeline
    terms: tuple[Term, ...]

    @property
    def machine(self) -> Machine:
        """That of the timeline, with its errors."""
        return self.timeline.machine

    def error(
        self, state: State, sees: Sequence[str], piece: np.ndarray, tables: bool = True
    ) -> np.ndarray:
        """(3, N) mm: actual - commanded, as far as a signal of these kinds ("tool", "scale",
        "part") shows it.

        tables: whether the machine's geometric tables are in it."""
        result = self._geometry(state, piece) if tables else np.zeros((3, len(state)))
        for value in self._values(state, sees, machine=True):
            result += value
        return result

    def reading(self, state: State, sees: Sequence[str]) -> tuple[np.ndarray, np.ndarray]:
        """(N,) and (3, N) mm: what the instrument adds by itself, to its reading and along the
        axes."""
        line, space = np.zeros(len(state)), np.zeros((3, len(state)))
        for value in self._values(state, sees, machine=False):
            if value.ndim == 1:
                line += value
            else:
                space += value
        return line, space

    def _values(self, state: State, sees: Sequence[str], machine: bool):
        """What every effect gives that such a signal shows. They count heat and time from the
        program's begin, so its first moment goes along as a row in front, and so do the moments at
        which the spindle's speed changes."""
        # an effect shows in a signal that its module says it can be seen in (SEES)
        shown = [
            t
            for t in self.terms
            if (t.module.KIND == "machine") == machine and set(t.module.SEES) & set(sees)
        ]
        if not shown:
            return
        first, later = (self._then(state, t) for t in self._moments())
        if self.timeline.conditions.begin:
            # the experiment may have begun before this program: heat counts from its beginning
            first.time[0] = 0.0
        # At one and the same moment a capture at the end of a rest stands before what comes then.
        whole = joined(joined(first, state), later)
        for term in shown:
            try:
                value = effects.deviation(term.module, whole, term.axis, **term.parameters)
            except KeyError as missing:
                raise GcompError(
                    f"{term.key} needs {missing.args[0]!r}, which is not simulated on"
                    f" {self.machine.name}"
                ) from None
            # the first row and the moments were there for time and heat to count from: cut off
            # again
            yield value[..., 1 : 1 + len(state)]

    def _then(self, state: State, time: np.ndarray) -> State:
        """The state at other times, with the beam as it begins."""
        found = self.timeline.state(time, self.timeline.plan.at(time)[0])
        return replace(found, beam=np.full(len(time), state.beam[0] if len(state) else 0.0))

    def _moments(self) -> tuple[np.ndarray, np.ndarray]:
        """s: the begin, and every change of the spindle's speed."""
        rpm, start = self.timeline.steps.rpm[self.timeline.path.step], self.timeline.plan.start[:-1]
        return np.zeros(1), start[1:][rpm[1:] != rpm[:-1]]

    def _geometry(self, state: State, piece: np.ndarray) -> np.ndarray:
        bare = replace(
            # terms (heat) without a module stay: growth of a moment is tables alone, with no
            # equation of its own
            self.machine,
            effects=tuple(e for e in self.machine.effects if e.module is None),
        )
        position = np.stack([state.position[x] for x in bare.letters])
        approach = np.stack([state.approach[x] for x in bare.letters])
        # each tool has its own arms: a machine for each, as many as the program has
        length = self.timeline.tool(piece)
        if not bare.turns or not length.any():
            return bare.xyz(bare.deviation(position, approach))
        result = np.zeros((3, len(state)))
        tools, which = np.unique(length, axis=1, return_inverse=True)
        for k, (x, y, z) in enumerate(tools.T.tolist()):
            of = which.ravel() == k
            one = bare.with_tool((x, y, z))
            result[:, of] = one.xyz(one.deviation(position[:, of], approach[:, of]))
        return result
