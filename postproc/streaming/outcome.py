"""How a job ended: one kind, one exit status, one message."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from postproc.streaming.lines import WireLine

DONE, ERROR, ALARM, RESET, DISCONNECTED, STALLED, ABORTED = (
    "done", "error", "alarm", "reset", "disconnected", "stalled", "aborted",
)  # fmt: skip
DRIFT, ALTERED, SENT, FAILED = "drift", "altered", "sent", "failed"
STATUS = {
    # Exit statuses, one to each kind, so that a script knows what to do; 130: as a shell says of
    # SIGINT; 17: all was sent on a link that confirms nothing.
    DONE: 0, ERROR: 10, ALARM: 11, RESET: 12, DISCONNECTED: 13, STALLED: 14, DRIFT: 15, ALTERED: 16,
    SENT: 17, ABORTED: 130, FAILED: 1,
}  # fmt: skip


def _span(what: str, first: int, last: int) -> str:
    """Lines from one number to another, in words."""
    return f"{what} {first}" if first == last else f"{what}s {first} to {last}"


@dataclass(frozen=True)
class Outcome:
    """kind: one of the names above; message: a fact; advice: the way out.

    last_certain: number of the last wire line that was answered; unanswered: lines that were sent
    and not answered, which may or may not have been executed; rejected: lines that the controller
    refused, with its words. at: the line in which the tool is by the last report; unsure: the first
    line that may not be over; None: there is none, or nothing says it.
    """

    kind: str
    message: str
    advice: str = ""
    last_certain: int = 0
    unanswered: tuple[WireLine, ...] = ()
    rejected: tuple[tuple[WireLine, str], ...] = ()
    certain_source: int = 0
    at: WireLine | None = None
    unsure: WireLine | None = None

    @property
    def exit_status(self) -> int:
        return STATUS[self.kind]

    def text(self) -> str:
        """For a person, at the end of a job."""
        lines = [self.message]
        if self.at and self.kind != DONE:
            lines.append(f"the tool is in {self.at.where()}, by its last report")
        if self.unsure and self.unsure is not self.at and self.kind != DONE:
            lines.append(f"surely over is all before {self.unsure.where()}")
        if self.unanswered:
            first, last = self.unanswered[0], self.unanswered[-1]
            which = _span("wire line", first.number, last.number)
            source = _span("source line", first.source, last.source)
            lines.append(f"sent and not answered: {which} ({source}); they may have been executed")
        if self.last_certain and self.kind != DONE:
            lines.append(
                f"last line answered: wire line {self.last_certain} (source line"
                f" {self.certain_source})"
            )
        if self.advice:
            lines.append(self.advice)
        return "\n    ".join(lines)


@dataclass
class Tally:
    """Counts of a job so far. seconds: of the programmed motion of the lines that were answered."""

    sent: int = 0
    answered: int = 0
    bytes: int = 0
    seconds: float = 0.0
    source: int = 0
    peak: int = 0
    rejected: list[tuple[WireLine, str]] = field(default_factory=list)


def with_rest(
    outcome: Outcome,
    last: WireLine | None,
    unanswered: Sequence[WireLine],
    tally: Tally,
    at: WireLine | None = None,
    unsure: WireLine | None = None,
) -> Outcome:
    """The outcome with what is certain and what is not; last: the line answered last; at, unsure:
    where the tool is, and the first line that may not be over."""
    return replace(
        outcome, last_certain=last.number if last else 0, rejected=tuple(tally.rejected),
        unanswered=tuple(line for line in unanswered if line.number > 0),
        certain_source=last.source if last else 0, at=at, unsure=unsure,
    )  # fmt: skip


def verdict(tally: Tally, off: float | None, check: bool) -> tuple[str, str, str]:
    """Kind, message and advice of a job whose lines are all answered and whose machine stands
    still; off: mm from where it should stand, None: nothing is wrong with that, or it is not
    known."""
    if tally.rejected:
        which = "\n    ".join(f"{line.where()}: {said}" for line, said in tally.rejected[:20])
        more = f"\n    and {len(tally.rejected) - 20} more" if len(tally.rejected) > 20 else ""
        return (
            ERROR,
            f"refused lines: {len(tally.rejected)} of {tally.sent}\n    {which}{more}",
            "",
        )
    if off is not None:
        return (
            ALTERED,
            (
                f"all {tally.sent} lines were accepted, but the machine stands {off:.3f} mm from"
                " where the last one ends"
            ),
            (
                "bytes were lost or altered on the way, or the axis was moved by something else: do"
                " not trust the part"
            ),
        )
    what = "checked, none refused" if check else "sent and accepted; the machine stands still"
    return DONE, f"{tally.sent} lines {what}", ""


def off_by(
    place: tuple[float, ...] | None,
    end: tuple[float, ...],
    order: tuple[int, ...] | None,
    limit: float,
) -> float | None:
    """mm between the reported place and where the last line ends (`order`: its axes among the
    reported ones), if that is more than the limit; None: it is not, or it is not known."""
    if place is None or not end or order is None:
        return None
    rows = order or range(len(end))
    # some axes are not reported
    pairs = [(place[i], b) for i, b in zip(rows, end, strict=False) if i < len(place)]
    worst = max((abs(a - b) for a, b in pairs if not math.isnan(b)), default=0.0)
    return worst if worst > limit else None
