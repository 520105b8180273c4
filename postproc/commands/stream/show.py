"""What a person, or a program, sees of a running job: a line that is kept up to date on a terminal,
JSON lines otherwise."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Iterator
from typing import Any

from postproc.commands.stream.keys import IN_REFUSAL
from postproc.commands.stream.outlets import Outlet
from postproc.commands.stream.report import History
from postproc.streaming.events import Status
from postproc.streaming.outcome import Outcome
from postproc.streaming.rates import Clock
from postproc.streaming.sender import Sender

EVERY = {"terminal": 0.2, "lines": 1.0}  # s


class Show:
    """Call it often with the time; it speaks when it is due, and never waits. total: lines of the
    job, 0: not known. keys: whether keys may be pressed. out, err: where it is told."""

    def __init__(
        self,
        sender: Sender,
        clock: Clock | None,
        total: int,
        letters: tuple[str, ...],
        quiet: bool,
        keys: bool = False,
    ):
        self.sender, self.clock, self.total, self.letters = sender, clock, total, letters
        self.terminal = sys.stderr is not None and sys.stderr.isatty()
        self.quiet, self.keys = quiet, keys
        self._next = 0.0
        self._started: float | None = None
        self._looked = 0.0
        self._rates: tuple[float, ...] = ()
        self._live: Any = None
        self._events: list[dict[str, Any]] = []
        self.history = History()
        self.out = Outlet(sys.stdout)
        self.err = Outlet(sys.stderr, self._draw if self.terminal else None, self._above)

    def __call__(self, now: float) -> None:
        self._look(now)
        if self.history.due(now):
            self.history.add(now, self.state(now))
        if self.quiet or now < self._next:
            return
        self._next = now + EVERY["terminal" if self.terminal else "lines"]
        state = self.state(now)
        if self.terminal:
            self.err.refresh(state)
        elif not self.out.stalls():  # nobody reads: the newest will do
            self._line({"event": "progress", **state})

    def _look(self, now: float) -> None:
        """Keep the time in which the job is held, and the newest overrides."""
        if self._started is None:
            self._started = self._looked = now
        if self.clock is not None and (self.sender.held or self._waits()):
            # what a hold lasts says nothing of the machine's pace
            self.clock.held += now - self._looked
        self._looked = now
        if self.sender.status and self.sender.status.rates:
            self._rates = self.sender.status.rates

    def unread(self) -> bool:
        """Whether whoever read the events on standard output is gone."""
        return not self.terminal and not self.quiet and self.out.unread()

    def state(self, now: float) -> dict[str, Any]:
        """Position (mm, degrees, machine and work coordinates), buffers, feed, rates, last line,
        what is over and what is left."""
        sender, tally, status = self.sender, self.sender.tally, self.sender.status
        executed = sender.account.executed
        result: dict[str, Any] = {
            "state": status.state if status else "unknown",
            "sent": tally.sent,
            "answered": tally.answered,
            "executed": executed,
            "executed_source_line": sender.account.source,
            "total": self.total or None,
            "percent": round(100 * executed / self.total, 2) if self.total else None,
            "source_line": tally.source,
            "buffer_bytes": getattr(sender.protocol, "used", None),
            "held": sender.held,
            "asks": len(sender.asks),
            **self._likely(status),
            "elapsed_s": round(now - (now if self._started is None else self._started), 2),
        }
        if status:
            result.update(self._of_report(status))
        if self._rates:
            names = ("feed", "rapid", "spindle")
            result["override_percent"] = dict(zip(names, self._rates, strict=False))
        if sender.protocol.confirms == "nothing":
            result.update(self._fed())
        if sender.waiting:
            result["oldest_unanswered"] = sender.waiting[0].text.decode("ascii", "replace")
        if self.clock is not None:
            result["eta_s"] = self._left(self.clock, now, result)
        return result

    def _of_report(self, status: Status) -> dict[str, Any]:
        """What the controller's last report says: position, buffers, feed."""
        result: dict[str, Any] = {}
        if status.place:
            result["position_mm"] = self._place(status.place)
            if status.shift and len(status.shift) == len(status.place):
                work = (v - s for v, s in zip(status.place, status.shift, strict=True))
                result["work_mm"] = self._place(work)
        if status.free:
            result["planner_free"], result["receive_free"] = status.free
        if status.feed is not None:
            result["feed_mm_min"] = round(status.feed, 1)
        return result

    def _place(self, values: Iterable[float]) -> dict[str, float]:
        return {x: round(v, 4) for x, v in zip(self.letters, values, strict=False)}

    def _left(self, clock: Clock, now: float, state: dict[str, Any]) -> float:
        """s until the job is over: by the bytes that have left, or by the lines that are over."""
        if "bytes" in state:
            clock.done = clock.expected * (state["percent"] or 0.0) / 100
        else:
            clock.over(self.sender.account, self.sender.status)
        clock.rate = self._rates[0] / 100 if self._rates and self._rates[0] > 0 else 1.0
        return round(clock.left(now), 1)

    def _likely(self, status: Status | None) -> dict[str, Any]:
        """The source line in which the tool probably is, and the percent that is over by that. In
        check mode it moves nowhere."""
        account = self.sender.account
        line, share = (account.executed, 0.0) if self.sender.check else account.likely(status)
        at = None if self.sender.check else account.at(status)
        return {
            "at_source_line": at.source if at else account.source,
            "at_percent": round(100 * (line + share) / self.total, 2) if self.total else None,
        }

    def _fed(self) -> dict[str, Any]:
        """Of a control that answers nothing: what has left, and whether it lets more leave. No line
        is known to be over."""
        bytes_, line = self.sender.written()
        return {
            "state": self._waits() or "sending",
            "bytes": bytes_,
            "sent": line.number if line else 0,
            "executed": None,
            "executed_source_line": None,
            "at_source_line": None,
            "at_percent": None,
            "source_line": line.source if line else 0,
            "percent": (
                round(100 * (line.number if line else 0) / self.total, 2) if self.total else None
            ),
        }

    def _waits(self) -> str:
        """What a control that steers the link waits for, in words; ""."""
        return str(getattr(self.sender.protocol, "waits", ""))

    def _words(self, state: dict[str, Any]) -> str:
        """One line of it."""
        if "bytes" in state:
            parts = [
                str(state["state"]),
                f"{state['percent']:.1f} %" if state["percent"] is not None else "",
                f"line {state['source_line']} sent, {state['bytes']} bytes",
                *_times(state),
            ]
        else:
            parts = [
                str(state["state"]),
                f"{state['at_percent']:.1f} %" if state["total"] else "",
                f"in line {state['at_source_line']}, {state['executed_source_line']} surely over,"
                f" {state['source_line']} answered",
                *_moves(state),
                *_buffers(state),
                *_times(state),
                self._keys_now(state),
            ]
        return "  ".join(part for part in parts if part)

    def _keys_now(self, state: dict[str, Any]) -> str:
        """What a person may do about a refused line, or a hold; "": neither is."""
        if state["asks"]:
            return f"REFUSED: {IN_REFUSAL}"
        if state["state"] not in ("hold", "door") and not state["held"]:
            return ""
        if self.keys:
            return "HOLD: r goes on, s stops, x resets"
        return "HOLD: SIGUSR1 goes on, Ctrl-C stops"

    def _draw(self, state: dict[str, Any]) -> None:
        """Of the outlet's own thread."""
        if self._live is None:
            from rich.console import Console
            from rich.live import Live

            self._live = Live(console=Console(stderr=True), auto_refresh=False, transient=True)
            self._live.start()
        self._live.update(self._words(state), refresh=True)

    def _above(self, text: str) -> bool:
        """A line above what is drawn."""
        if self._live is None:
            return False
        self._live.console.print(text, markup=False, highlight=False, soft_wrap=True)
        return True

    def _line(self, fields: dict[str, Any]) -> None:
        self.out.say(json.dumps(fields))

    def tell(self, message: str) -> None:
        """For a person, whatever happens."""
        self.err.say(f"gcomp: {message}")

    def event(self, kind: str, message: str) -> None:
        """What happened by itself."""
        self._events.append(
            {
                "s": round(self._looked - (self._started or self._looked), 2),
                "event": kind,
                "message": message,
            }
        )
        if not self.terminal and not self.quiet:
            self._line({"event": kind, "message": message})

    def end(self, outcome: Outcome) -> None:
        """The last event; then whoever has not read by now is not waited for."""
        if not self.terminal and not self.quiet:
            self._line(
                {
                    "event": "outcome",
                    "outcome": outcome.kind,
                    "exit_status": outcome.exit_status,
                    "message": outcome.message,
                    "last_answered": outcome.last_certain,
                    "source_line": outcome.certain_source,
                    "at_source_line": outcome.at.source if outcome.at else None,
                    "unanswered": [
                        {
                            "line": x.number,
                            "source_line": x.source,
                            "text": x.text.decode("ascii", "replace"),
                        }
                        for x in outcome.unanswered
                    ],
                }
            )
        self.out.close()

    def report(self, outcome: Outcome, now: float, about: dict[str, Any]) -> dict[str, Any]:
        """The run, format gcomp-run/1. about: what else is known of it."""
        tally, started = self.sender.tally, now if self._started is None else self._started
        return {
            "format": "gcomp-run/1",
            **about,
            "outcome": outcome.kind,
            "exit_status": outcome.exit_status,
            "message": outcome.message,
            "seconds": round(now - started, 2),
            "held_s": round(self.clock.held, 2) if self.clock else None,
            "expected_s": round(self.clock.expected, 2) if self.clock else None,
            "lines": self.total or None,
            "sent": tally.sent,
            "answered": tally.answered,
            "executed": self.sender.account.executed,
            "bytes": tally.bytes,
            "buffer_bytes_at_most": tally.peak,
            "refused": [
                {
                    "source_line": line.source,
                    "text": line.text.decode("ascii", "replace"),
                    "words": words,
                }
                for line, words in tally.rejected
            ],
            "at_source_line": outcome.at.source if outcome.at else None,
            "events": self._events,
        }

    def close(self) -> None:
        """Give the terminal back."""
        self.err.close(lambda: self._live.stop() if self._live is not None else None)


def _moves(state: dict[str, Any]) -> list[str]:
    """Where the tool is, how fast, and by which overrides."""
    parts = [
        f"{which} " + " ".join(f"{x}{v:.3f}" for x, v in state[name].items())
        for name, which in (("work_mm", "work"), ("position_mm", "machine"))
        if name in state
    ]
    if "feed_mm_min" in state:
        parts.append(f"F{state['feed_mm_min']:g}")
    changed = [f"{k} {v:g} %" for k, v in state.get("override_percent", {}).items() if v != 100]
    return [*parts, " ".join(changed)]


def _buffers(state: dict[str, Any]) -> Iterator[str]:
    if state["buffer_bytes"] is not None:
        yield f"{state['buffer_bytes']} bytes in the buffer"
    if "planner_free" in state:
        yield f"{state['planner_free']} blocks free"


def _times(state: dict[str, Any]) -> list[str]:
    gone = f"{_minutes(state['elapsed_s'])} gone"
    return [gone, f"{_minutes(state['eta_s'])} left"] if "eta_s" in state else [gone]


def _minutes(seconds: float) -> str:
    minutes, rest = divmod(int(seconds), 60)
    return f"{minutes}:{rest:02d}"
