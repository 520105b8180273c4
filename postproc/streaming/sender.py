"""The job: lines go out as the protocol allows, answers come in, and it ends in exactly one
outcome.

Bytes and time in, bytes out: receive(data, now), tick(now), bytes_out(). A line that has left is
never sent again by the sender (a protocol that numbers its lines may do so on request). Success is
said only when every line is answered, and of a controller that reports its state when it stands
still in two reports, with nothing strange in between, where the last line ends; of a link without
answers nothing more is said than that all was sent.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable

from postproc.streaming import endings, events, holds
from postproc.streaming.holds import Hold
from postproc.streaming.limits import AGAIN, Limits, Poll
from postproc.streaming.lines import WireLine
from postproc.streaming.outcome import Outcome, Tally, off_by, verdict, with_rest
from postproc.streaming.outgoing import Outgoing
from postproc.streaming.path import CLEAR, LOOK, OFF, Path
from postproc.streaming.protocols import Protocol

RUNNING, HELD, HALTING, STOPPING = "running", "held", "halting", "stopping"
RESTS = {"idle", "check"}
LOOKS = 0.25  # s between two looks at the clock, beyond which the computer was busy, or asleep
BACKLOG = 512  # bytes that wait for the port, beyond which no further line is taken


class Sender:
    """One job on one connection. `check`: a dry run in the controller's check mode. `on_error`:
    "stop"; "continue"; or "ask": hold, and wait for decide(), `asks` being the lines that were
    refused, with the controller's words.

    order: where each axis of a line's `end` stands in the controller's reports; (): in the same
    order, None: it does not report them.
    spindle_off: stop the spindle when the job has ended in a hold, where the controller can (it
    starts again with resume).
    path: to see whether it stands on the lines' path while it moves; None: it is not asked.
    `log` is drained by the owner: ("sent", line, time), ("answered", line, time), ("rejected",
    line, time), ("status", status, time), ("told", text, time), and ("hold", text, time),
    ("resumed", text, time) for what gcomp did not order.
    """

    def __init__(
        self,
        protocol: Protocol,
        limits: Limits = Limits(),
        on_error: str = "stop",
        check: bool = False,
        order: tuple[int, ...] | None = (),
        path: Path | None = None,
        spindle_off: bool = False,
    ):
        self.protocol, self.limits, self.order = protocol, limits, order
        self.on_error, self.check, self.spindle_off = on_error, check, spindle_off
        self.path = path or Path(protocol.controller, order or (), watched=False)
        self.account = self.path.account
        self.outcome: Outcome | None = None
        self.tally = Tally()
        self.state = RUNNING
        self.status: events.Status | None = None
        self.log: list[tuple[str, object, float]] = []
        self.asks: list[tuple[WireLine, str]] = []
        self._queue: deque[WireLine] = deque()
        self._sent: dict[int, WireLine] = {}
        self.out = Outgoing()
        self._last: WireLine | None = None  # the last line answered
        self._end: tuple[float, ...] = ()
        self._heard = self._moved = self._ticked = -math.inf
        self._reports = Poll()
        self._drained: float | None = None
        self._rests = self._own = 0
        self._idle_since: float | None = None
        self._deadline = math.inf
        self._pending: Outcome | None = None
        self._hold = Hold()
        self._ended = self._started = self._check_off = False
        # that it has stopped; it is held to see whether it stands on the path
        self._confirmed = self._looks = False
        for text in (*protocol.opening, *[protocol.check_mode()] * check):
            self._insert(text)

    # -- what the owner gives ----------------------------------------------------------------------

    def give(self, lines: Iterable[WireLine]) -> None:
        """Lines to send, in order, with rising numbers."""
        self._queue.extend(lines)

    def end(self) -> None:
        """No more lines will come."""
        if not self._ended:
            self._ended = True
            for text in self.protocol.closing:
                self._insert(text)

    @property
    def queued(self) -> int:
        return len(self._queue)

    def _insert(self, text: bytes) -> None:
        self._own -= 1  # from -1 down: in no tally, journal or account
        self._queue.append(WireLine(self._own, 0, 0, text))

    # -- what a person does ------------------------------------------------------------------------

    def hold(self, now: float) -> None:
        """Feed hold: the machine slows down and stands; no further line leaves."""
        if self.outcome is None and self.state in (RUNNING, HELD):
            self.out.urgent += self.protocol.urgent("hold")
            self.state = HELD
            self._hold.order(now)

    def resume(self, now: float) -> None:
        """Go on where the hold was, also one that the program (M0) or the machine made, or a
        refused line."""
        if self.outcome is None and self.state in (RUNNING, HELD):
            self.out.urgent += self.protocol.urgent("resume")
            self.asks.clear()
            self._hold.release(now)
            self._goes_on(now)

    @property
    def held(self) -> bool:
        """Whether it shall hold, or does, whoever said so."""
        return self.state == HELD or self._hold.stands

    def override(self, what: str) -> bool:
        """Change the rate of feed, rapids or spindle while it runs ("feed+", "rapid 50", ...);
        False: there is no such order."""
        data = self.protocol.urgent(what)
        self.out.urgent += data
        return bool(data)

    def decide(self, go_on: bool, now: float) -> None:
        """The answer to `asks`: go on without these lines, or end the job here."""
        if go_on:
            self.resume(now)
        elif self.asks:
            line, words = self.asks[0]
            self._end_soon(
                endings.refused(line, words, len(self._sent), self.protocol),
                now,
                HALTING,
                hold=True,
            )

    def stop(self, now: float, why: str = "stopped by the user") -> None:
        """What was sent and not executed is dropped, where the protocol can do that."""
        if self.outcome is None and self.state != STOPPING:
            self.out.urgent += self.protocol.urgent("stop")
            self.out.drop()
            self._queue.clear()
            self._end_soon(endings.stopped(why, self.protocol), now, STOPPING)

    def give_up(self, why: str, now: float) -> None:
        """What is needed to prepare lines is gone: hold, and let nothing more leave."""
        if self.outcome is None and self.state in (RUNNING, HELD):
            self._end_soon(endings.given_up(why, len(self._sent), self.protocol), now, hold=True)

    def lost(self, why: str, now: float) -> None:
        """The port is gone."""
        self._finish(endings.lost(why))

    # -- bytes and time ----------------------------------------------------------------------------

    def receive(self, data: bytes, now: float) -> None:
        if data and self.outcome is None:
            self._heard = now
            for event in self.protocol.receive(data):
                if self.outcome is None:
                    self._take(event, now)

    def tick(self, now: float) -> None:
        """Fill the window and look at the clock. Call it after every receive(), and at least every
        50 ms."""
        if self.outcome is not None:
            return
        if not self._started:
            self._started, self._heard, self._moved = True, now, now
            self._ticked = now
        self._missed(now)
        self._fill(now)
        self._poll(now)
        self._watch(now)

    def urgent_out(self) -> bytes:
        """Realtime bytes (a hold, a stop, a question), to be written before anything is told or
        kept."""
        return self.out.take_urgent()

    def bytes_out(self) -> bytes:
        """What to write now, at most what the protocol lets go; the rest comes next time."""
        if self.out.urgent:
            return self.urgent_out()
        return self.out.take(self.protocol.release())

    def written(self) -> tuple[int, WireLine | None]:
        """Of a link without answers: bytes that have left, and the last line of which all have."""
        return self.out.left, self.out.written()

    def unwritten(self, data: bytes) -> None:
        """The port did not take these bytes: they go first next time. Realtime bytes still pass
        them."""
        self.out.give_back(data)

    @property
    def waiting(self) -> tuple[WireLine, ...]:
        """Lines sent and not answered, oldest first."""
        return tuple(self._sent.values())

    # -- the parts ---------------------------------------------------------------------------------

    def _fill(self, now: float) -> None:
        if self._all_answered and self.check and not self._check_off:
            self._check_off = True
            self._insert(self.protocol.check_mode())
        if self.path.watched and self.status is None and now - self._moved < AGAIN:
            return  # where does it stand?
        while self.state == RUNNING and len(self.out) < BACKLOG and self._may_send():
            self._put(self._queue.popleft(), now)
            self._drained, self._rests = None, 0

    def _may_send(self) -> bool:
        return bool(self._queue) and self.protocol.ready(self._queue[0].text)

    def _put(self, line: WireLine, now: float) -> None:
        """One line on its way."""
        if not self._sent:
            self._moved = now  # waiting begins with the first line that waits
            self._idle_since = None
        data = self.protocol.send(line.number, line.text)
        answered = self.protocol.confirms != "nothing"
        if answered:
            self._sent[line.number] = line
        self.out.put(data, None if answered else line)
        self.tally.peak = max(self.tally.peak, getattr(self.protocol, "used", 0))
        if line.number > 0:
            self.tally.sent += 1
            self.tally.bytes += len(data)
            self.log.append(("sent", line, now))
            self.account.sent(line)

    def _missed(self, now: float) -> None:
        """Time in which nobody looked is no silence of the controller: what it said then has yet to
        be read."""
        late = now - self._ticked - LOOKS
        self._ticked = now
        if late > 0:
            self._heard += late  # a sleeping laptop finds no hour of silence
            self._moved += late
            self._deadline += late
            if self._idle_since is not None:
                self._idle_since += late

    def _poll(self, now: float) -> None:
        request = self.protocol.urgent("status")
        watched = self.path.watched and self.state in (RUNNING, HELD)
        if request and self._reports.due(
            now, self.limits, watched, self.path.off_path > 0, self._moved
        ):
            self.out.urgent += request
            self._reports.ask(now)

    @property
    def _all_answered(self) -> bool:
        """Whether all lines of the program were sent and answered."""
        return self._ended and not self._queue and not self._sent

    def _watch(self, now: float) -> None:
        """The clock's part: orders that are overdue, silence, standstill, the end."""
        if now >= self._deadline and self._pending is not None:
            self._overdue(self._pending)
            return
        text = self._oldest()
        patience = self._patience(self.limits.silence, text)
        if self.protocol.urgent("status"):
            heard, silent = max(self._heard, self._moved), self._reports.waits
        else:
            heard, silent = self._moved, bool(text)
        if silent and now - heard > patience:
            self._silent(now)
        elif self._all_answered and not (self.out or self._pending or self.asks):
            self._drain(now)

    def _patience(self, least: float, text: bytes) -> float:
        """s for which nothing need come while this line is executed; b"": none is."""
        return max(least, self.protocol.patience(text) if text else 0.0)

    def _oldest(self) -> bytes:
        """The line that has waited longest for its answer; b"": none."""
        waits = [self._sent[k] for k in self.protocol.outstanding()[:1] if k in self._sent]
        return waits[0].text if waits else b""

    def _silent(self, now: float) -> None:
        """Nothing has come for too long: no report, or where none is asked for no answer."""
        if self.protocol.urgent("status"):
            self._finish(endings.silent(now - self._heard))
        elif self.state == RUNNING and not self._hold.stands:
            self._stalled(now, f"there was no answer for {now - self._moved:.1f} s")

    def _overdue(self, outcome: Outcome) -> None:
        """The end that is due, or that nothing has confirmed it."""
        silent = self.state == STOPPING and self.protocol.confirms == "idle" and not self._confirmed
        late = endings.unconfirmed(outcome, self.limits.grace)
        self.outcome = self._completed(late if silent else outcome)

    def _drain(self, now: float) -> None:
        """All is answered: is it done?"""
        if self.protocol.confirms == "answers":
            self._done(self.status)
        elif self.protocol.confirms == "nothing":
            self._finish(endings.sent(self.tally.sent, self.out.left))
        elif self._drained is None:
            self._drained, self._rests = now, 0

    def _take(self, event: events.Event, now: float) -> None:
        if isinstance(event, events.Accepted):
            self._answered(event.number, now)
        elif isinstance(event, events.Status):
            self._reported(event, now)
        elif isinstance(event, events.Rejected):
            self._rejected(event, now)
        elif isinstance(event, events.Alarm):
            self._alarmed(event, now)
        elif isinstance(event, events.Restarted):
            self._restarted(event, now)
        elif isinstance(event, events.Stray):
            self._end_soon(endings.stray(event), now, hold=True)
        elif isinstance(event, events.Altered):
            self._end_soon(endings.altered(event, self._sent.get(event.number)), now, hold=True)
        else:
            self._heard_of(event, now)

    def _heard_of(self, event: events.Event, now: float) -> None:
        """What ends nothing and answers nothing."""
        if isinstance(event, events.Write):
            if self.state in (RUNNING, HELD):
                self.out.put(event.data)
                self._moved = now
        elif isinstance(event, events.Busy):
            self._moved = now
            if "paused" in event.text and not self._hold.foreign:
                self._hold.foreign = True
                self.log.append(("hold", holds.PAUSED, now))
        elif isinstance(event, events.Message):
            self.log.append(("told", event.text, now))

    def _answered(self, number: int, now: float) -> None:
        line = self._sent.pop(number, None)
        self._moved, self._idle_since = now, None
        self._hold.foreign = self._hold.foreign and self._hold.stands
        if line is None or number <= 0:
            return
        self.account.answered(number, self.protocol.emptied(line.text))
        self._last = line
        self.tally.answered += 1
        self.tally.seconds += line.seconds
        self.tally.source = line.source
        self._end = line.end
        self.log.append(("answered", line, now))

    def _rejected(self, event: events.Rejected, now: float) -> None:
        """A line was refused: the job ends, asks, or goes on, as it was told to."""
        line = self._sent.pop(event.number, None)
        self._moved, self._idle_since = now, None
        if line is None:
            return
        words = endings.said(event)
        if line.number <= 0:
            self._end_soon(endings.own_refused(line, words), now)
            return
        self.tally.rejected.append((line, words))
        self.tally.answered += 1
        self.path.lose()
        self.account.refused(line.number)
        self.log.append(("rejected", line, now))
        if self.on_error == "continue" or self.check:
            return
        if self.on_error == "ask" and self.state in (RUNNING, HELD):
            self.asks.append((line, words))
            if self.state == RUNNING:
                self.hold(now)
            return
        self._end_soon(
            endings.refused(line, words, len(self._sent), self.protocol), now, HALTING, hold=True
        )

    def _alarmed(self, event: events.Alarm, now: float) -> None:
        if self.state == STOPPING:
            self.log.append(("told", endings.said(event), now))
            self._confirmed = True
            return
        self._finish(endings.alarm(event, self.waiting))

    def _restarted(self, event: events.Restarted, now: float) -> None:
        if self.state == STOPPING:
            self.outcome = self._completed(self._pending) if self._pending else None
            return
        if self._check_off:  # leaving check mode ends in a restart
            self._sent.clear()
            self._moved = now
            return
        self._finish(endings.restarted(event, self.waiting))

    def _reported(self, status: events.Status, now: float) -> None:
        asked = self._reports.asked if self.protocol.urgent("status") else math.inf
        asked_after_drain = (
            self._drained is not None
            and self._reports.waits
            and self._reports.asked >= self._drained
        )
        self._reports.waits = False
        self.status = status
        self.log.append(("status", status, now))
        if status.state == "alarm" and self.state != STOPPING:
            self._finish(endings.alarm_state())
            return
        self._halted(status, now)
        if self.state in (RUNNING, HELD):
            self._looked(self.path.judge(status), status, now)
        if news := self._hold.reported(status.state, asked):
            self._held(news, status, now)
        elif not self._hold.ordered:
            self._at_rest(status, asked_after_drain, now)

    def _halted(self, status: events.Status, now: float) -> None:
        """Where the job ends and the machine stands: the spindle's stop, and the end now."""
        stands = status.state in ("hold", "idle") and status.detail != "1"  # Hold:1 still brakes
        if self.state == HALTING and stands and not self.out.urgent:
            if self.spindle_off and status.state == "hold":
                self.out.urgent += self.protocol.urgent("spindle stop")
            self._deadline = min(self._deadline, now)

    def _looked(self, seen: str, status: events.Status, now: float) -> None:
        """Beside the path: hold, look again, and end or go on."""
        if seen == LOOK:
            self._looks = self.state == RUNNING
            if self._looks:
                self.hold(now)
        elif seen == OFF:
            self._end_soon(endings.astray(self.path, status, self.protocol), now, hold=True)
        elif seen == CLEAR and self._looks and self.state == HELD:
            self.log.append(("resumed", holds.NOT_SEEN_AGAIN.format(self.path.distance), now))
            self.resume(now)

    def _held(self, news: str, status: events.Status, now: float) -> None:
        """A hold, or its end, that was not ordered; or an order that was lost."""
        self._moved = now
        if news == holds.AGAIN:
            # it was lost on the way, or while EEPROM was written
            self.out.urgent += self.protocol.urgent("hold")
        elif self.state in (RUNNING, HELD) and news == holds.FOREIGN:
            self.log.append(
                ("hold", holds.words(status, next(iter(self._sent.values()), None)), now)
            )
        elif self.state in (RUNNING, HELD):
            self.log.append(("resumed", "the machine goes on, and not by gcomp's order", now))
            if not self.asks:
                self._goes_on(now)

    def _goes_on(self, now: float) -> None:
        self.state, self._moved, self._idle_since, self._rests = RUNNING, now, None, 0

    def _at_rest(self, status: events.Status, asked_after_drain: bool, now: float) -> None:
        """Is it idle with lines unanswered, or at the end?"""
        if status.state in RESTS:
            if self._sent and self.state == RUNNING:
                self._idle_since = now if self._idle_since is None else self._idle_since
                text = next((line.text for line in self.waiting), b"")
                patience = self._patience(self.limits.stall, text)
                if now - max(self._idle_since, self._moved) >= patience:
                    silent = f"has answered nothing for {now - self._moved:.1f} s"
                    self._stalled(now, f"it stands still ({status.state}) and {silent}")
            elif asked_after_drain and self.state == RUNNING:
                self._rests += 1  # once may be before it moves
                if self._rests >= 2:
                    self._done(status)
        else:
            self._idle_since, self._rests = None, 0

    # -- ends --------------------------------------------------------------------------------------

    def _done(self, status: events.Status | None = None) -> None:
        off = (
            None
            if status is None or self.check
            else off_by(status.place, self._end, self.order, self.limits.off_mm)
        )
        self._finish(Outcome(*verdict(self.tally, off, self.check)))

    def _stalled(self, now: float, how: str) -> None:
        overdue_line = self.protocol.overdue()
        if not overdue_line:
            self._end_soon(endings.stalled(self.waiting, how), now, hold=True)
            return
        self.out.put(overdue_line)  # a numbered line that the receiver will not take twice
        self._moved, self._idle_since = now, None

    def _end_soon(
        self, outcome: Outcome, now: float, state: str = HALTING, hold: bool = False
    ) -> None:
        """Nothing more leaves; the outcome stands, and is told when the controller has come to
        rest, or the grace is over."""
        if self._pending is None or state == STOPPING:  # the first reason stands
            self._pending = outcome
        self._hold.release(now)
        if hold:
            self.out.urgent += self.protocol.urgent("hold")
            self._hold.order(now)
        self.state = state
        self.asks.clear()
        self._deadline = min(self._deadline, now + self.limits.grace)

    def _finish(self, outcome: Outcome) -> None:
        if self.outcome is None:
            self.outcome = self._completed(self._pending or outcome)

    def _completed(self, outcome: Outcome) -> Outcome:
        at = unsure = None
        if not self.check and self.protocol.confirms != "nothing":
            parts = self.account.running(self.status) if self.status else self.account.parts
            unsure = parts[0].line if parts else None
            at = self.account.at(self.status)
        return with_rest(outcome, self._last, self.waiting, self.tally, at, unsure)
