"""Whether the machine shall hold, whether it does, and who ended that: gcomp, a button at the
machine, or the program."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from postproc.streaming.events import Status
from postproc.streaming.lines import WireLine

HOLDING = {"hold", "door"}
AGAIN, FOREIGN, RESUMED = "again", "foreign", "resumed"
PAUSED = (
    "the controller is paused and waits for a person: at its own buttons, or r (or SIGUSR1); Ctrl-C"
    " stops the job"
)
NOT_SEEN_AGAIN = (
    "one report said that the machine was {:.3f} mm beside the path; held and asked again, it"
    " stands on it, and goes on. The report was damaged, or a coordinate was: check the cable, and"
    " look at the part"
)
STOP = re.compile(rb"M0*[01](?![0-9])", re.IGNORECASE)


@dataclass
class Hold:
    """ordered: it shall hold, and gcomp said so at `since`; stands: it reported that it does;
    foreign: and nobody here asked."""

    ordered: bool = False
    stands: bool = False
    foreign: bool = False
    since: float = -math.inf

    def order(self, now: float) -> None:
        self.ordered, self.since, self.foreign = True, now, False

    def release(self, now: float) -> None:
        self.ordered = self.stands = self.foreign = False
        self.since = now

    def reported(self, state: str, asked: float) -> str:
        """What a report means that was asked for at `asked`: AGAIN, the order was lost on the way;
        FOREIGN, somebody else made it hold; RESUMED, somebody else made it go on; "": nothing
        new."""
        if asked < self.since:
            return ""  # it was on its way before the order
        was, self.stands = self.stands, state in HOLDING
        if self.stands:
            self.foreign = self.foreign or not (was or self.ordered)
            return FOREIGN if self.foreign and not was else ""
        return self._moves(was, state)

    def _moves(self, was: bool, state: str) -> str:
        """What it means that it does not hold. was: it did by the report before."""
        #     it held             we ordered it   somebody else did
        #     now it runs         RESUMED         RESUMED
        #     now it is idle      still held      RESUMED
        if was and (self.foreign or (self.ordered and state == "run")):
            self.release(self.since)
            return RESUMED
        self.stands = was and self.ordered
        return AGAIN if self.ordered and state == "run" else ""


def words(status: Status, oldest: WireLine | None) -> str:
    """A hold that gcomp did not order, for a person. oldest: the line that waits for its answer."""
    if status.state == "door":
        return (
            "the safety door is open: close it, then r (or SIGUSR1) goes on; Ctrl-C stops the job"
        )
    if oldest is not None and STOP.search(oldest.text):
        return (
            f"the program stops here, {oldest.where()}: r (or SIGUSR1) goes on; Ctrl-C stops"
            " the job"
        )
    return (
        "the machine holds, and not by gcomp's order: a button at the machine, or another program."
        " Its own button goes on, or r (or SIGUSR1); Ctrl-C stops the job"
    )
