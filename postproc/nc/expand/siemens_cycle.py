"""A call of one of Sinumerik's cycles that are written out: its values by their names."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

from postproc.nc.codes import code_number
from postproc.nc.expand import Refusal
from postproc.nc.expand.siemens_values import Value
from postproc.nc.expand.tracker import Tracker

DIAM90 = code_number("DIAM90")


def in_diameters(tracker: Tracker, axes: Iterable[str]) -> bool:
    """Whether places of one of these axes are diameters."""
    half = tracker.code("diameter") == DIAM90
    return any(tracker.is_diameter(axis) or (half and axis == "X") for axis in axes)


def by_name(
    cycle: str, names: Sequence[str], values: Sequence[Value | None], advice: str
) -> dict[str, float]:
    """The values of a cycle's call by their names, without those that it leaves out. Raises Refusal
    for more values than names, and, with `advice`, for one that is no number."""
    if len(values) > len(names):
        raise Refusal(
            f"{cycle} takes {len(names)} values, here are {len(values)}", "correct the call"
        )
    given = {}
    for name, value in zip(names, values, strict=False):
        # CYCLE81(10,0,2,,5): a value that is left out is not one of 0; each cycle says what it
        # means then
        if value is None or value == "":
            continue
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise Refusal(f"{name} of {cycle} is no number", advice)
        given[name] = float(value)
    return given


@dataclass
class Cycle(ABC):
    """A call with its values. words: the cycles of a kind, and the names of their values in order;
    needed: those that every call has; advice: the way out where one is no number; sense: 1 where
    the spindle turns by M3, -1 by M4."""

    words: ClassVar[Mapping[str, str]]
    needed: ClassVar[str] = ""
    advice: ClassVar[str] = "correct the call"
    name: str
    given: dict[str, float]
    sense: int = 1

    @classmethod
    def of(cls, name: str, values: Sequence[Value | None], sense: int = 1) -> Self:
        """Raises Refusal for values that are none of a cycle that can be written out."""
        # with the values as they are where the call stands: MCALL keeps them for all holes behind
        # it
        call = cls(name, by_name(name, cls.words[name].split(), values, cls.advice), sense)
        call.check()
        return call

    def check(self) -> None:
        """Raises Refusal for values that are wrong wherever the cycle is called."""
        self.needs(self.needed)

    @abstractmethod
    def lines(self, tracker: Tracker, feed: bytes, speed: bytes = b"") -> list[bytes]:
        """The plain lines, from where the axes stand. feed, speed: the F and S words in force.
        Raises Refusal."""

    def get(self, word: str) -> float:
        """A value, 0 where it is left out."""
        return self.given.get(word, 0.0)

    def needs(self, words: str) -> None:
        """Raises Refusal where a value is missing."""
        for word in words.split():
            if word not in self.given:
                raise Refusal(f"{self.name} without {word}", "write its value")
