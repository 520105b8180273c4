"""Programs that go round without end: a way back that is taken again with the same memory."""

from __future__ import annotations

import re
from collections.abc import Sequence

from postproc.nc.expand import Refusal
from postproc.nc.expand.fanuc_calls import Frame
from postproc.nc.expand.fanuc_variables import Variables

SYSTEM = re.compile(rb"#[ \t]*(?:[1-9][0-9]{3}|[^0-9 \t])")  # also what may be one: #[...], names


class Rounds:
    """Where a program has taken a way back, and what it remembered then. That decides its ways
    alone where the texts name no system variable."""

    def __init__(self) -> None:
        self._taken: dict[tuple[int, int], tuple[object, ...]] = {}
        self._more = False  # whether the texts are found to name one

    def back(self, at: int, frames: Sequence[Frame], variables: Variables, repeated: bool) -> None:
        """A way back from an entry of the program that runs; `repeated`: all of it runs once more.
        Raises Refusal where it has no end."""
        if self._more:
            return
        # The same entry again, with the same calls open and the same variables: what comes now came
        # before. Only a clock, an input or a place could make it differ, which are variables of the
        # system.
        levels = ((id(f.source), f.at, f.left, *sorted(f.local.items())) for f in frames)
        state = (repeated, *levels, *sorted(variables.common.items()))
        site = (id(frames[-1].source), at)
        if self._taken.get(site) == state:
            self._more = variables.mentions(SYSTEM)
            if not self._more:
                raise Refusal(
                    "from here the program goes round without end: nothing that decides its way"
                    " changes any more",
                    "M30 ends it after one piece",
                )
        self._taken[site] = state
