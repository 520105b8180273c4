"""A program in time: where the control wants every axis at any moment, and all that an effect may
look at there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property

import numpy as np

from postproc.effects import State
from postproc.machine.model import Machine
from postproc.simulate import history
from postproc.simulate import path as paths
from postproc.simulate import plan as plans
from postproc.simulate.limits import Limits
from postproc.simulate.path import Path
from postproc.simulate.plan import Plan
from postproc.simulate.program import Steps

XYZ = "XYZ"
EDGE = 1e-6  # mm: how far beyond a travel counts as on its end


@dataclass(frozen=True)
class Conditions:
    """How the control runs and what is around. corner mm and cycle s: see path.py and plan.py; play
    mm: see history.turns; heat;
    begin s: time of the experiment at which the program starts; force: axis to N of each run in
    turn."""

    corner: float = 0.01
    cycle: float = 0.001
    play: float = 0.0
    heat: history.Heat = field(default_factory=history.Heat)
    begin: float = 0.0
    force: Mapping[str, tuple[float, ...]] = field(default_factory=dict)


def _by_axis(rows: dict[str, int], values: np.ndarray) -> dict[str, np.ndarray]:
    """Axis to its row of values (A, K)."""
    return {x: values[i] for x, i in rows.items()}


@dataclass(frozen=True)
class Timeline:
    """A program on a machine in time. Times are seconds since the program began."""

    machine: Machine
    conditions: Conditions
    steps: Steps
    path: Path
    plan: Plan

    @cached_property
    def duration(self) -> float:
        """s."""
        return float(self.plan.start[-1])

    def outside(self) -> tuple[int, str, float] | None:
        """Line, axis and mm of the first place beyond a travel, None if there is none."""
        for i, x in enumerate(self.path.letters):
            if x in self.machine.axes:
                low, high = self.machine.axes[x].travel
                p = np.stack([self.path.begin[i], self.path.end[i]])
                wrong = np.flatnonzero(((p < low - EDGE) | (p > high + EDGE)).any(axis=0))
                if len(wrong):
                    both = p[:, wrong[0]]
                    worst = both[int(np.argmax(np.maximum(low - both, both - high)))]
                    return int(self.steps.line[self.path.step[wrong[0]]]), x, float(worst)
        return None

    @cached_property
    def turns(self) -> history.Turns:
        """Sides, and ways and times since each axis turned."""
        return history.turns(self.path, self.plan, self.conditions.play)

    @cached_property
    def warmth(self) -> history.Warmth:
        """Temperatures over time."""
        return history.warmth(self.path, self.plan, self.conditions.heat)

    def state(
        self, time: np.ndarray, piece: np.ndarray | None = None, run: np.ndarray | None = None
    ) -> State:
        """What an effect may look at, at these times (K,). piece (K,): the rows stand at rest in
        these pieces, at the end of which they may be; without, they are samples in motion. run
        (K,): 1, 2, ... which passage of the instrument."""
        sampled = piece is None
        own, way, speed, rate = self.plan.at(time)
        if piece is not None:
            # At the very end of a rest the plan already tells of the next piece: a capture stands
            # still at the end of its own.
            over = own != piece
            own = np.where(over, piece, own)
            way = np.where(over, self.path.length[piece], way)
            speed, rate = np.where(over, 0.0, speed), np.where(over, 0.0, rate)
        place, direction, bend = self.path.at(own, way)
        # along the path as it speeds up, across it as it bends: curvature times speed squared
        velocity, acceleration = direction * speed, direction * rate + bend * speed**2
        turns, letters = self.turns, self.path.letters
        run = np.ones(len(time)) if run is None else run
        rows = {x: i for i, x in enumerate(letters) if x in self.machine.letters}
        slides = {x: i for x, i in rows.items() if x in XYZ}
        # since the piece began: within it an axis goes one way, so this adds to its distance since
        # a turn
        gone = np.abs(place - self.path.begin[:, own])
        return State(
            position=_by_axis(rows, place), approach=_by_axis(rows, turns.approach[:, own]),
            travel={x: self.machine.axes[x].travel for x in rows},
            velocity=_by_axis(rows, velocity), acceleration=_by_axis(rows, acceleration),
            distance=_by_axis(rows, np.minimum(turns.distance[:, own] + gone, history.FAR)),
            since=_by_axis(rows, np.minimum(time - turns.since[:, own], history.FAR)),
            time=time + self.conditions.begin, run=run,
            channels=self._channels(time, own, run, slides), angles=self._angles(place, own, rows),
            beam=np.zeros(len(time)), passage=run - 1.0 if sampled else np.full(len(time), -1.0),
            file=np.zeros(len(time)),
            turned=np.zeros(len(time), bool), arms=self._arms(place, own, rows, slides),
            on_arm="".join(x for x in slides if self.machine.on_own_arm(x)),
        )  # fmt: skip

    def _arms(self, place, piece, rows, slides) -> dict[str, np.ndarray]:
        """On what the rotations of each axis act, with the tool in use; rotary axes are not
        followed."""
        if self.machine.chain.rotary:
            return {}
        at, length = _by_axis(rows, place), self.tool(piece)
        # a longer tool takes the tip nearer to the carriages along its own direction
        # (Machine.with_tool)
        return {x: self.machine.arm_at(x, at) - length for x in slides}

    def _channels(self, time, piece, run, slides) -> dict[str, np.ndarray]:
        warm, step = self.warmth, self.path.step[piece]
        found = {
            "T_air_C": warm.air(time),
            "T_bed_C": warm.following(time, self.conditions.heat.bed_tau),
        }
        for x in slides:
            found[f"T_screw_{x}_C"] = warm.screw(x, time, piece)
            each = np.array(self.conditions.force.get(x, (0.0,)))
            # one force for each run, and from the first again where there are more runs
            found[f"force_{x}_N"] = each[(run.astype(np.int64) - 1) % len(each)]
        found["spindle_rpm"] = self.steps.rpm[step]
        found["part"] = self.steps.part[step].astype(float)
        found["material"] = np.zeros(len(time))
        return found

    def _angles(self, place, piece, rows) -> dict[str, np.ndarray]:
        """The measured rotations of each axis, as its table has them."""
        found = {}
        for x, i in rows.items():
            table = self.machine.axes[x].table
            if x in XYZ and table is not None and any(row >= 3 for row in table.rows):
                parts = table.evaluate(place[i], self.turns.approach[i, piece])[3:]
                found[x] = np.stack([np.zeros(len(piece)) if v is None else v for v in parts])
        return found

    def line(self, time: np.ndarray) -> np.ndarray:
        """(K,) line of the program."""
        return self.steps.line[self.path.step[self.plan.at(time)[0]]]

    def tool(self, piece: np.ndarray) -> np.ndarray:
        """(3, K) mm: length of the tool in use."""
        length = self.steps.length[:, self.path.step[piece]]
        rows = [self.path.letters.index(x) if x in self.path.letters else -1 for x in XYZ]
        return np.stack([length[i] if i >= 0 else np.zeros(len(piece)) for i in rows])


def of(
    steps: Steps, machine: Machine, limits: Limits, conditions: Conditions, letters: tuple[str, ...]
) -> Timeline:
    """The program in time. letters: of the rows of the steps, the machine's axes first."""
    path = paths.of(steps, letters, conditions.corner)
    bounds = limits.tiled(len(letters) - len(limits.velocity))
    return Timeline(machine, conditions, steps, path, plans.of(path, bounds, conditions.cycle))


def joined(first: State, second: State) -> State:
    """The rows of both, one behind the other."""

    def both(a, b):
        if isinstance(a, dict):
            return {k: both(a[k], b[k]) for k in a}
        return np.concatenate([a, b], axis=-1)

    rows = [f.name for f in fields(State) if f.name not in ("travel", "on_arm")]
    return replace(
        first, **{name: both(getattr(first, name), getattr(second, name)) for name in rows}
    )
