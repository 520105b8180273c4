"""What a person, or a program, sees of a running job: a line that is kept up to date on a terminal, JSON lines otherwise."""

from __future__ import annotations

import json
import sys
from typing import Any

from postproc.streaming.outcome import Outcome
from postproc.streaming.rates import Clock
from postproc.streaming.sender import HELD, Sender

EVERY = {"terminal": 0.2, "lines": 1.0}  # s


class Show:
    """Call it often with the time; it speaks when it is due. total: lines of the job, 0: not known."""

    def __init__(self, sender: Sender, clock: Clock | None, total: int, letters: tuple[str, ...], quiet: bool):
        self.sender, self.clock, self.total, self.letters = sender, clock, total, letters
        self.terminal = sys.stderr is not None and sys.stderr.isatty()
        self.quiet = quiet
        self._next = 0.0
        self._live: Any = None

    def __call__(self, now: float) -> None:
        if self.quiet or now < self._next:
            return
        self._next = now + EVERY["terminal" if self.terminal else "lines"]
        state = self.state(now)
        if not self.terminal:
            self._line({"event": "progress", **state})
            return
        if self._live is None:
            from rich.console import Console
            from rich.live import Live

            self._live = Live(console=Console(stderr=True), auto_refresh=False, transient=True)
            self._live.start()
        self._live.update(self._words(state), refresh=True)

    def state(self, now: float) -> dict[str, Any]:
        """Position (mm, degrees, machine coordinates), buffer, feed, last line, what is left."""
        sender, tally, status = self.sender, self.sender.tally, self.sender.status
        result: dict[str, Any] = {
            "state": status.state if status else "unknown", "sent": tally.sent, "answered": tally.answered,
            "executed": sender.account.executed, "executed_source_line": sender.account.source, "total": self.total or None,
            "source_line": tally.source, "buffer_bytes": getattr(sender.protocol, "used", None), "held": sender.state == HELD,
        }  # fmt: skip
        if status and status.place:
            result["position_mm"] = {x: round(v, 4) for x, v in zip(self.letters, status.place, strict=False)}
        if status and status.free:
            result["planner_free"], result["receive_free"] = status.free
        if status and status.feed is not None:
            result["feed_mm_min"] = round(status.feed, 1)
        if sender.waiting:
            result["oldest_unanswered"] = sender.waiting[0].text.decode("ascii", "replace")
        if self.clock is not None:
            self.clock.done = sender.account.seconds
            result["eta_s"] = round(self.clock.left(now), 1)
        return result

    @staticmethod
    def _words(state: dict[str, Any]) -> str:
        parts = [str(state["state"])]
        if state["total"]:
            parts.append(f"{100 * state['executed'] / state['total']:.1f} %")
        parts.append(f"line {state['executed_source_line']} is over, {state['source_line']} answered")
        parts.append(" ".join(f"{x}{v:.3f}" for x, v in state.get("position_mm", {}).items()))
        if "feed_mm_min" in state:
            parts.append(f"F{state['feed_mm_min']:g}")
        if state["buffer_bytes"] is not None:
            parts.append(f"{state['buffer_bytes']} bytes in the buffer")
        if "eta_s" in state:
            minutes, seconds = divmod(int(state["eta_s"]), 60)
            parts.append(f"{minutes}:{seconds:02d} left")
        if state["state"] in ("hold", "door") or state["held"]:
            parts.append("HOLD: Enter goes on, Ctrl-C stops")
        return "  ".join(part for part in parts if part)

    @staticmethod
    def _line(fields: dict[str, Any]) -> None:
        print(json.dumps(fields), flush=True)

    def event(self, kind: str, message: str) -> None:
        """What happened by itself."""
        if not self.terminal and not self.quiet:
            self._line({"event": kind, "message": message})

    def end(self, outcome: Outcome) -> None:
        if self._live is not None:
            self._live.stop()
        if not self.terminal and not self.quiet:
            self._line(
                {
                    "event": "outcome", "outcome": outcome.kind, "exit_status": outcome.exit_status, "message": outcome.message,
                    "last_answered": outcome.last_certain, "source_line": outcome.certain_source,
                    "unanswered": [{"line": x.number, "source_line": x.source, "text": x.text.decode("ascii", "replace")} for x in outcome.unanswered],
                }
            )  # fmt: skip
