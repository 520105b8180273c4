"""The sentences with which a job ends: what happened, and the way out. Which of them holds is the
sender's to say."""

from __future__ import annotations

from collections.abc import Sequence

from postproc.streaming import outcome as ends
from postproc.streaming.events import Alarm, Altered, Rejected, Restarted, Status, Stray
from postproc.streaming.lines import WireLine
from postproc.streaming.outcome import Outcome
from postproc.streaming.path import Path
from postproc.streaming.protocols import Protocol

# How the sender comes to one of these (sender.py):
#
#     RUNNING <---- resume, CLEAR ----> HELD          lines leave only in RUNNING
#        |   hold, LOOK, on_error "ask"  |
#        +---------------+---------------+
#                        |  refused, altered, off the path, stalled: a hold is ordered
#                        v
#                     HALTING --- it stands, or the grace is over ---> outcome
#                        |  stop: a reset, what was sent is dropped
#                        v
#                     STOPPING -- restart seen, or the grace is over --> outcome
#
# Silence and a lost port end it at once; an alarm and a restart, too, but in STOPPING, where they
# are what the stop was to bring about.
LOOK = (
    "what the controller has received it may still execute; check where it stands before you"
    " restart"
)
CLEAR = "clear its cause, home or unlock, and restart the job"


def said(event: Rejected | Alarm) -> str:
    """The controller's words, and what they mean."""
    return event.code + (f" ({event.meaning})" if event.meaning else "")


def fact_of_refusal(line: WireLine, words: str) -> str:
    return f"the controller refused {line.where()}\n    {words}"


def behind(n: int) -> str:
    """What a refusal leaves in the controller."""
    lines = "1 more line" if n == 1 else f"{n} more lines"
    return f"it had {lines} by then, which it may still execute; " if n else ""


def refused(line: WireLine, words: str, n: int, protocol: Protocol) -> Outcome:
    """n: lines that were sent behind it and not answered."""
    return Outcome(ends.ERROR, fact_of_refusal(line, words), behind(n) + protocol.does["hold"])


def own_refused(line: WireLine, words: str) -> Outcome:
    return Outcome(ends.ERROR, f"the controller refused {line.text.decode()}: {words}")


def given_up(why: str, n: int, protocol: Protocol) -> Outcome:
    """n: lines that were sent and not answered."""
    return Outcome(
        ends.ERROR, f"no line can be prepared any more: {why}", behind(n) + protocol.does["hold"]
    )


def alarm(event: Alarm, waiting: Sequence[WireLine]) -> Outcome:
    at = f"; the oldest line unanswered is {waiting[0].where()}" if waiting else ""
    words = event.code + (f": {event.meaning}" if event.meaning else "")
    return Outcome(ends.ALARM, f"alarm: {words}{at}", CLEAR)


def alarm_state() -> Outcome:
    return Outcome(ends.ALARM, "the controller is in alarm", CLEAR)


def restarted(event: Restarted, waiting: Sequence[WireLine]) -> Outcome:
    at = f"; it may have been at {waiting[0].where()}" if waiting else ""
    return Outcome(
        ends.RESET,
        f"the controller has restarted in the middle of the job ({event.text.strip()}){at}",
        "its position is not certain any more: home it, and restart from a line before",
    )


def stray(event: Stray) -> Outcome:
    return Outcome(
        ends.DRIFT,
        f"the controller answered {event.text!r} while no line waits for an answer: answers were"
        " counted wrong, or somebody else sends too",
        "what it received is not certain; stop, look at the part, and restart",
    )


def altered(event: Altered, line: WireLine | None) -> Outcome:
    return Outcome(
        ends.ALTERED,
        f"the controller read {event.heard!r}, which is not what was sent:"
        f" {line.where() if line else ''}",
        "the link loses or alters bytes: check cable, baud rate and flow control",
    )


def astray(path: Path, status: Status, protocol: Protocol) -> Outcome:
    """It was seen twice beside the path."""
    lines = path.lines()
    first, last = lines[0], lines[-1]
    at = " ".join(f"{x}{v:.3f}" for x, v in zip("XYZABCUVW", status.place or (), strict=False))
    near = f"; nearest is {path.nearest.where()}" if path.nearest else ""
    return Outcome(
        ends.DRIFT,
        f"the machine stands {path.distance:.3f} mm beside the path of the lines that it may be"
        f" executing, source lines {first.source} to {last.source} (wire lines {first.number} to"
        f" {last.number}): it reports {at}, machine coordinates{near}",
        "a coordinate was altered on the way (or two reports were), or something else has moved"
        f" the machine; {protocol.does['hold']}. Look at the part, check cable and baud rate, and"
        " restart from a line before these",
    )


def stalled(waiting: Sequence[WireLine], how: str) -> Outcome:
    lines = "; ".join(line.where() for line in waiting[:4])
    return Outcome(
        ends.STALLED,
        f"{len(waiting)} lines were sent and not answered, and {how}. Oldest: {lines}",
        "an answer or a part of a line was lost; nothing is sent again, because a line executed"
        " twice is worse. Look at the machine, then restart: --resume-from its journal knows what"
        " is over",
    )


def lost(why: str) -> Outcome:
    return Outcome(ends.DISCONNECTED, f"the connection is lost: {why}", LOOK)


def silent(seconds: float) -> Outcome:
    return Outcome(
        ends.DISCONNECTED,
        f"the controller has said nothing for {seconds:.1f} s, not even its status",
        LOOK,
    )


def failed(error: BaseException, waiting: Sequence[WireLine], protocol: Protocol) -> Outcome:
    """gcomp's own fault."""
    at = f"; the oldest line unanswered is {waiting[0].where()}" if waiting else ""
    return Outcome(
        ends.FAILED,
        f"gcomp failed: {type(error).__name__}: {error}{at}",
        f"{protocol.does['hold']}. This is an error of gcomp: please report it with what stands"
        " above, and the journal",
        unanswered=tuple(line for line in waiting if line.number > 0),
    )


def stopped(why: str, protocol: Protocol) -> Outcome:
    return Outcome(ends.ABORTED, why, protocol.does["stop"])


def unconfirmed(outcome: Outcome, seconds: float) -> Outcome:
    """A stop that the controller would confirm, and did not."""
    more = (
        f"; it has not confirmed that within {seconds:g} s: look at the machine before you go"
        " near it"
    )
    return Outcome(outcome.kind, outcome.message, outcome.advice + more)


def sent(n: int, size: int) -> Outcome:
    return Outcome(
        ends.SENT,
        f"{n} lines, {size} bytes were sent; this link tells nothing of what became of them",
    )
