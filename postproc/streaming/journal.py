"""What was sent and what was answered, one JSON object a line, only ever appended: readable after any crash.

    {"format": "gcomp-journal/1", "program": ..., "sha256": ..., "machine": ..., "map": ..., "planner": 16, "begin": 1}
    {"t": 0.013, "sent": 1, "source": 3, "piece": 0, "text": "G0X10", "correction_um": [1.2, 0.0]}
    {"t": 0.014, "sent": 2, "source": 1, "piece": 0, "text": "G1X4", "correction_um": [0.4, 0.0], "file": "pocket.ngc"}
    {"t": 0.020, "answered": 1}
    {"t": 0.220, "state": "run", "place_mm": [1.0, 2.0]}
    {"t": 9.1, "outcome": "done", "message": "...", "position": "known"}

file: of a line that stands in a subprogram's file. A last line that was cut by a crash is no error. What was answered was accepted, not executed: up to `planner` motions of it
may not have begun.
"""

from __future__ import annotations

import json
from collections import deque
from dataclasses import dataclass, field
from typing import Any

from postproc.errors import Place, UsageError
from postproc.streaming.events import Status
from postproc.streaming.lines import WireLine
from postproc.streaming.outcome import RESET, Outcome

FORMAT = "gcomp-journal/1"
POSITION_LOST = ("alarm", "disconnected", "aborted", RESET)


def _record(**fields: Any) -> bytes:
    return json.dumps(fields, separators=(",", ":")).encode() + b"\n"


def head(
    program: str, sha256: str, machine: str, digest: str, planner: int, begin: int = 1, expanded: bool = False
) -> bytes:
    """The first line. sha256: of the program's bytes; begin: source line with which the job began; expanded: its lines were
    written out, so that a source line may have been executed more than once."""
    return _record(
        format=FORMAT,
        program=program,
        sha256=sha256,
        machine=machine,
        map=digest,
        planner=planner,
        begin=begin,
        expanded=expanded,
    )


def record(kind: str, what: object, t: float) -> bytes:
    """A line for an entry of the sender's log; b"" for what is not kept. t: s since the job began."""
    time = round(t, 3)
    if isinstance(what, WireLine):
        if kind == "sent":
            um = [round(c * 1000, 2) for c in what.correction]
            return _record(
                t=time, sent=what.number, source=what.source, piece=what.piece, text=what.text.decode("ascii", "replace"),
                correction_um=um, **({"file": what.file} if what.file else {}),
            )  # fmt: skip
        return _record(t=time, **{kind: what.number})
    if isinstance(what, Status):
        return _record(t=time, state=what.state, place_mm=list(what.place or ()))
    return _record(t=time, told=str(what))


def end(outcome: Outcome, t: float) -> bytes:
    """The last line."""
    position = "unknown" if outcome.kind in POSITION_LOST else "known"
    return _record(t=round(t, 3), outcome=outcome.kind, message=outcome.message, position=position)


@dataclass
class Past:
    """What a journal says. certain: source line with which to begin again so that nothing is left out: that of the first line
    that may not have been executed. answered, sent: numbers of the last wire lines."""

    head: dict[str, Any]
    certain: int = 1
    answered: int = 0
    sent: int = 0
    outcome: str = ""
    source: dict[int, int] = field(default_factory=dict)


def read(data: bytes, name: str) -> Past:
    """Raises UsageError for what is no journal, with its line. A last line without an end is left out."""
    lines = data.split(b"\n")
    lines.pop()  # what stands behind the last line end was cut
    past: Past | None = None
    recent: deque[tuple[int, int]] = deque(maxlen=4096)
    for number, line in enumerate(lines, 1):
        try:
            entry = json.loads(line)
            if not isinstance(entry, dict):
                raise ValueError
        except ValueError:
            if number == len(lines):
                break
            raise UsageError(
                "this is no line of a journal", "", Place(name, number, line[:100].decode("latin-1"))
            ) from None
        if past is None:
            if entry.get("format") != FORMAT:
                raise UsageError(f"{name} is no journal of gcomp stream", "name the file that --journal wrote")
            past = Past(entry)
        elif "sent" in entry:
            past.sent = int(entry["sent"])
            recent.append((past.sent, int(entry["source"])))
        elif "answered" in entry:
            past.answered = int(entry["answered"])
        elif "outcome" in entry:
            past.outcome = str(entry["outcome"])
    if past is None:
        raise UsageError(f"{name} is empty", "name the file that --journal wrote")
    past.source = dict(recent)
    first = max(1, past.answered + 1 - int(past.head.get("planner", 16)))
    sources = [source for n, source in recent if n >= first and source]
    past.certain = min(sources, default=int(past.head.get("begin", 1)))
    return past
