"""Captures at rest: what laser, straightness and angle optics have in common."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from postproc.effects import State
from postproc.errors import GcompError
from postproc.simulate.actual import Reality
from postproc.simulate.instruments import Settings
from postproc.simulate.path import Path

XYZ = "XYZ"
SETTINGS = {
    "dwell": "s, the shortest rest that is a capture (1)",
    "ignore": "mm of travel at either end that is overrun and no target (0)",
    "runs": "number of runs, where their number is not seen from the direction of travel",
}
STILL = 1e-6  # mm


@dataclass(frozen=True)
class Captures:
    """N captures. state: of the rows; piece (N,): of the path; moving: the axes that travel, the
    one with the longest way first; feed (N,) mm/min: of the motion that led there, nan of a
    rapid."""

    state: State
    piece: np.ndarray
    moving: tuple[str, ...]
    feed: np.ndarray

    def columns(self) -> dict[str, np.ndarray]:
        """The columns of a recording that say where and when."""
        s = self.state
        found = {"run": s.run, "t_s": s.time}
        found |= {f"{x}_{'mm' if x in XYZ else 'deg'}": p for x, p in s.position.items()}
        found |= {f"approach_{x}": a for x, a in s.approach.items()}
        return found


def captures(reality: Reality, settings: Settings) -> Captures:
    """Every rest that is long enough. Raises GcompError where there is none."""
    timeline = reality.timeline
    path, plan, steps = timeline.path, timeline.plan, timeline.steps
    least = settings.above_zero("dwell", 1.0)
    wait = np.nan_to_num(steps.wait[path.step], nan=0.0)
    piece = np.flatnonzero(wait >= least - 1e-9)
    if not len(piece):
        raise GcompError(
            f"the program never rests for {least:g} s, so nothing is captured",
            f"its longest rest is {wait.max(initial=0.0):g} s: --set dwell=..., or G4 at every"
            " target",
        )
    moving = _moving(path, piece, reality.machine.letters)
    ignore = settings.number("ignore", 0.0)
    if moving and ignore > 0:
        p = path.begin[path.letters.index(moving[0]), piece]
        piece = piece[(p >= p.min() + ignore) & (p <= p.max() - ignore)]
        if not len(piece):
            raise GcompError(f"nothing is left when {ignore:g} mm are ignored at either end")
    # at the end of each rest, when all has settled
    time = plan.start[piece + 1]
    run: np.ndarray = np.ones(len(piece))
    if settings.text("runs"):
        number = settings.whole("runs", 1)
        run = 1.0 + np.arange(len(piece)) * number // len(piece)
    elif moving:
        row = path.letters.index(moving[0])
        run = _passages(path.begin[row, piece], timeline.turns.approach[row, piece])
    state = timeline.state(time, piece, run)
    return Captures(state, piece, moving, _feeds(reality, piece))


def _moving(path: Path, piece: np.ndarray, letters: Sequence[str]) -> tuple[str, ...]:
    """The slides that travel between rests in these pieces, the one with the longest way first."""
    ways = {x: np.ptp(path.begin[i, piece]) for i, x in enumerate(path.letters)}
    slides = [x for x, way in ways.items() if x in XYZ and x in letters and way > STILL]
    return tuple(sorted(slides, key=ways.__getitem__, reverse=True))


def _passages(place: np.ndarray, approach: np.ndarray) -> np.ndarray:
    """(N,) 1, 2, ...: there and back is one run; a new one begins where the travel goes the first
    way again."""
    known = approach[approach != 0]
    first = known[0] if len(known) else 1.0
    run, result = 1, [1]
    for k in range(1, len(place)):
        #    > > > >    The first way begins a run, the way back belongs to it, the first way again
        #    < < < <    begins the next. Where readings never come back a jump against the first way
        #    > > > >    begins one.
        begins = approach[k] == first and (
            approach[k - 1] == -first
            or (approach[k - 1] in (0.0, first) and (place[k] - place[k - 1]) * first < -STILL)
        )
        run += bool(begins)
        result.append(run)
    return np.array(result, float)


def _feeds(reality: Reality, piece: np.ndarray) -> np.ndarray:
    """(N,) mm/min of the last motion before each capture."""
    steps, step = reality.timeline.steps, reality.timeline.path.step[piece]
    moves = np.isnan(steps.wait)
    last = np.maximum.accumulate(np.where(moves, np.arange(len(steps)), -1))[step]
    feed = np.where(last >= 0, steps.feed[np.maximum(last, 0)] * 60.0, np.nan)
    return np.where(steps.inverse[np.maximum(last, 0)], np.nan, feed)


def direction(captures: Captures, settings: Settings) -> np.ndarray:
    """(3,) unit vector along which is measured: as set, else from the first target to the one
    farthest from it."""
    given = settings.direction("along", captures.state.position)
    if given is not None:
        return given
    place = np.stack([captures.state.position.get(x, np.zeros(len(captures.piece))) for x in XYZ])
    away = place - place[:, :1]
    # from the first target to the farthest: the diagonal, also of a stair's corners
    vector = away[:, int(np.argmax((away**2).sum(axis=0)))]
    if len(captures.moving) == 1:
        vector = np.array([1.0 if x == captures.moving[0] else 0.0 for x in XYZ])
    size = float(np.linalg.norm(vector))
    if size == 0:
        raise GcompError(
            "the axes never move between two captures: no direction to measure along",
            "--set along=Z",
        )
    return vector / size


def along(captures: Captures, vector: np.ndarray) -> State:
    """The state with the length of a beam along the vector, from the nearest target on."""
    place = sum(vector[XYZ.index(x)] * p for x, p in captures.state.position.items() if x in XYZ)
    # the laser's zero lies before the nearest target: the beam is never shorter than nothing
    return replace(captures.state, beam=np.asarray(place) - np.min(place))


def head(captures: Captures, vector: np.ndarray, quantity: str, instrument: str) -> dict:
    """What a recording's head says of the reading; sensitive: cosines of vector (3,)."""
    letters = [x for x in captures.state.position if x in XYZ]
    return {
        "instrument": instrument, "quantity": quantity,
        "sensitive": {x: float(vector[XYZ.index(x)]) for x in letters},
    }  # fmt: skip
