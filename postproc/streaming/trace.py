"""Positions that the controller reports while a job runs, as rows of a recording (contract
gcomp-recording/1, kind trace).

act: what was reported. cmd: the nearest place on the commanded path, because a report does not say
which place of the path it belongs to; so what lies across the path is seen, what lies along it
(lag) is not. line: the source line of that place.
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from postproc.recordings import Recording, contract
from postproc.streaming.lines import WireLine
from postproc.streaming.path import nearest

ROTARY = "ABC"
CHORD = 0.0005  # mm: how far sampled arcs may miss
LINES = 200  # of the path that are kept: more than a planner and a receive buffer hold


class Trace:
    """head() once, then row() for every report. letters: the machine's axes, all of them reported;
    start: where they stand."""

    def __init__(
        self, machine: str, letters: tuple[str, ...], controller: str, start: tuple[float, ...] = ()
    ):
        self.letters = letters
        self.axes = len(letters)
        self._info = {
            "machine": machine, "instrument": f"position reports of {controller}", "sees": "scale",
            "commanded": "nearest place on the commanded path",
        }  # fmt: skip
        self._path: deque[tuple[np.ndarray, int]] = deque(maxlen=LINES)
        self._last: np.ndarray | None = np.array(start) if len(start) == len(letters) else None

    def _recording(self, rows: list[list[float]]) -> str:
        names = ["run", "t_s"]
        for x in self.letters:
            unit = "deg" if x in ROTARY else "mm"
            names += [f"{x}_cmd_{unit}", f"{x}_act_{unit}"]
        names.append("line")
        columns = np.array(rows, float).reshape(-1, len(names)).T
        return contract.write(
            Recording("trace", dict(self._info), dict(zip(names, columns, strict=True)))
        )

    def head(self) -> str:
        return self._recording([])

    def sent(self, line: WireLine) -> None:
        """A line that left: a part of the path."""
        if not line.end or any(map(math.isnan, line.end)):
            return
        end = np.array(line.end)
        if self._last is not None:
            points = [self._last, *map(np.array, line.points), end]
            self._path.append((np.array(points), line.source))
        self._last = end

    def row(self, place: tuple[float, ...], t: float) -> str:
        """The text of one row; "" as long as there is no path."""
        if not self._path or len(place) < self.axes:
            return ""
        actual = np.array(place[: self.axes])
        best, where, source = math.inf, actual, 0
        for points, line in self._path:
            near, distance = nearest(points, actual)
            if distance < best:
                best, where, source = distance, near, line
        row = [1.0, t]
        for i in range(self.axes):
            row += [float(where[i]), float(actual[i])]
        return self._recording([[*row, float(source)]]).splitlines()[-1] + "\n"
