"""What a controller says, as a protocol understood it. Numbers are those of the wire lines that
were given to send()."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Accepted:
    """A line was read and taken. It need not be executed yet."""

    number: int


@dataclass(frozen=True)
class Rejected:
    """A line was refused: the controller's code, its own words, and what they mean."""

    number: int
    code: str
    meaning: str = ""


@dataclass(frozen=True)
class Alarm:
    """The controller stopped by itself and locked."""

    code: str
    meaning: str = ""


@dataclass(frozen=True)
class Restarted:
    """Its greeting: it has just started. All that was sent and not executed is gone."""

    text: str


@dataclass(frozen=True)
class Status:
    """A report. state: idle, run, hold, jog, alarm, door, check, home, sleep, tool or what it said;
    detail: its sub-state.

    place: mm (degrees of rotary axes), machine coordinates, in the controller's order of axes, or
    None; feed: mm/min;
    free: planner blocks and receive bytes that are free, where it says so; line: N number in
    execution; rates: overrides of feed, rapids and spindle, %, () where this report does not say
    them; shift: of the work coordinates, mm, as it was said last.
    """

    state: str
    detail: str = ""
    place: tuple[float, ...] | None = None
    feed: float | None = None
    speed: float | None = None
    free: tuple[int, int] | None = None
    line: int | None = None
    rates: tuple[float, ...] = ()
    shift: tuple[float, ...] | None = None


@dataclass(frozen=True)
class Message:
    """Anything else in words. Never counted as an answer."""

    text: str


@dataclass(frozen=True)
class Stray:
    """An answer while no line waits for one: the count of answers has drifted."""

    text: str


@dataclass(frozen=True)
class Altered:
    """The controller echoes a line that is not the line that was sent."""

    number: int
    heard: str


@dataclass(frozen=True)
class Busy:
    """It works on a line and will answer: waiting starts anew."""

    text: str = ""


@dataclass(frozen=True)
class Write:
    """Bytes that the protocol itself wants out now, in their turn behind what is on its way (a line
    sent again on request)."""

    data: bytes


# What the sender does with each (sender.py): Accepted and Rejected end a line's waiting, Alarm,
# Restarted, Stray and Altered the job; Busy and Write begin its patience anew; a Status may tell
# rest, a hold or a place beside the path; a Message is shown.
Event = Accepted | Rejected | Alarm | Restarted | Status | Message | Stray | Altered | Busy | Write
