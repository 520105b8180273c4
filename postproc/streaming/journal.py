"""What was sent, what was answered, and what is over, one JSON object a line, only ever appended:
readable after any crash.

    {"format": "gcomp-journal/1", "program": ..., "sha256": ..., "machine": ..., "map": ...,
    "holds": 21, "begin": 1,
     "zero": "", "offsets": {"G54": {"X": 0.0}}, "place_mm": [0.0, 0.0]}
    {"t": 0.013, "sent": 1, "source": 3, "piece": 0, "text": "G0X10", "correction_um": [1.2, 0.0],
    "end_mm": [10.0, 0.0]} {"t": 0.014, "sent": 2, "source": 1, "piece": 0, "text": "G1X4",
    "correction_um": [0.4, 0.0], "file": "pocket.ngc"} {"t": 0.020, "answered": 1}
    {"t": 0.220, "state": "run", "place_mm": [1.0, 2.0], "executed": 1}
    {"offsets": {"G54": {"X": 0.0}}}
    {"t": 9.1, "outcome": "done", "message": "...", "position": "known"}

file: of a line that stands in a subprogram's file. A last line that was cut by a crash is no error.
What was answered was accepted, not executed: what is surely over says `executed`. end_mm, via_mm:
where a line goes, machine coordinates, and places on an arc before it;
null: not known. zero: "homed" or "unlocked" where gcomp did that before the job. offsets: the
controller's, when the job began, and again behind a tool change that touched off.
"""

from __future__ import annotations

import json
import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from postproc.errors import Place, UsageError
from postproc.streaming.events import Status
from postproc.streaming.lines import WireLine
from postproc.streaming.outcome import RESET, Outcome

FORMAT = "gcomp-journal/1"
MARGIN = 3  # motions before the first that may not be over, with which a job begins again
RECENT = 1 << 15  # lines sent of which is known where they go
OLD_HOLDS = 130  # lines, in a journal that does not say what was over
VIA = 3  # every so manieth place of an arc is kept: chords of 5 um then miss it by 45 um
Spot = tuple[float | None, ...]
POSITION_LOST = ("alarm", "disconnected", "aborted", RESET)


def _record(**fields: Any) -> bytes:
    return json.dumps(fields, separators=(",", ":")).encode() + b"\n"


def head(
    program: str,
    sha256: str,
    machine: str,
    digest: str,
    holds: int,
    begin: int = 1,
    expanded: bool = False,
    zero: str = "",
    offsets: dict[str, dict[str, float]] | None = None,
    place: Sequence[float | None] = (),
) -> bytes:
    """The first line. sha256: of the program's bytes; holds: motions that the controller may have
    answered and not executed;
    begin: source line with which the job began; expanded: its lines were written out, so that a
    source line may have been executed more than once; zero, offsets, place: the controller's, when
    the job began."""
    return _record(
        format=FORMAT, program=program, sha256=sha256, machine=machine, map=digest, holds=holds,
        begin=begin, expanded=expanded, zero=zero, offsets=offsets or {}, place_mm=list(place),
    )  # fmt: skip


def zeros(offsets: dict[str, dict[str, float]]) -> bytes:
    """A line for work offsets that were set in the middle of the job."""
    return _record(offsets=offsets)


def record(kind: str, what: object, t: float, executed: int = 0) -> bytes:
    """A line for an entry of the sender's log; b"" for what is not kept. t: s since the job began;
    executed: the last wire line that is over."""
    time = round(t, 3)
    if isinstance(what, WireLine):
        if kind == "sent":
            um = [round(c * 1000, 2) for c in what.correction]
            return _record(
                t=time, sent=what.number, source=what.source, piece=what.piece,
                text=what.text.decode("ascii", "replace"), correction_um=um,
                **({"file": what.file} if what.file else {}), **_way(what),
            )  # fmt: skip
        return _record(t=time, **{kind: what.number})
    if isinstance(what, Status):
        detail = {"detail": what.detail} if what.detail else {}
        return _record(
            t=time, state=what.state, **detail, place_mm=list(what.place or ()), executed=executed
        )
    return _record(t=time, told=str(what))


def _way(line: WireLine) -> dict[str, Any]:
    """Where it goes, where that is known."""
    if not (line.end and line.straight):
        return {}
    via = [_rounded(place) for place in line.points[::VIA]]
    return {"end_mm": _rounded(line.end), **({"via_mm": via} if via else {})}


def _rounded(place: Sequence[float]) -> list[float | None]:
    return [None if math.isnan(v) else round(v, 4) for v in place]


def end(outcome: Outcome, t: float) -> bytes:
    """The last line."""
    position = "unknown" if outcome.kind in POSITION_LOST else "known"
    return _record(t=round(t, 3), outcome=outcome.kind, message=outcome.message, position=position)


@dataclass
class Past:
    """What a journal says. certain: source line with which to begin again so that nothing is left
    out: MARGIN motions before the first line that may not have been executed. executed, answered,
    sent: numbers of the last wire lines. state, detail: of the last report; place: where it stood
    when the job began; recent: the last lines sent, of which recent[first] is the first that may
    not be over."""

    head: dict[str, Any]
    certain: int = 1
    executed: int = 0
    answered: int = 0
    sent: int = 0
    state: str = ""
    detail: str = ""
    place: Spot = ()
    recent: list[dict[str, Any]] = field(default_factory=list)
    first: int = 0
    outcome: str = ""
    source: dict[int, int] = field(default_factory=dict)


def read(data: bytes, name: str) -> Past:
    """Raises UsageError for what is no journal, with its line. A last line without an end is left
    out."""
    lines = data.split(b"\n")
    lines.pop()  # what stands behind the last line end was cut
    past: Past | None = None
    recent: deque[dict[str, Any]] = deque(maxlen=RECENT)
    for number, line in enumerate(lines, 1):
        try:
            entry = _entry(line)
            if past is None:
                past = _started(entry, name)
            else:
                _taken(past, entry, recent)
        except (ValueError, TypeError, KeyError, RecursionError, OverflowError):
            if number == len(lines):
                break
            raise UsageError(
                "this is no line of a journal",
                "",
                Place(name, number, line[:100].decode("latin-1")),
            ) from None
    if past is None:
        raise UsageError(f"{name} is empty", "name the file that --journal wrote")
    past.source = {entry["sent"]: entry["source"] for entry in recent}
    _set_restart(past, list(recent))
    return past


def _entry(line: bytes) -> dict[str, Any]:
    """A line. Raises ValueError for what is none, RecursionError for one that nests too deep."""
    entry = json.loads(line)
    if not isinstance(entry, dict):
        raise ValueError
    return entry


def _started(entry: dict[str, Any], name: str) -> Past:
    """The first line."""
    if entry.get("format") != FORMAT:
        raise UsageError(
            f"{name} is no journal of gcomp stream", "name the file that --journal wrote"
        )
    entry["begin"] = int(entry.get("begin", 1))
    entry["offsets"] = _offsets(entry.get("offsets", {}))
    return Past(entry, place=_spot(entry.get("place_mm", ())))


def _spot(value: Any) -> Spot:
    return tuple(None if v is None else float(v) for v in value)


def _offsets(value: Any) -> dict[str, dict[str, float]]:
    if not isinstance(value, dict) or not all(isinstance(place, dict) for place in value.values()):
        raise ValueError
    return {name: {x: float(v) for x, v in place.items()} for name, place in value.items()}


def _taken(past: Past, entry: dict[str, Any], recent: deque[dict[str, Any]]) -> None:
    """Any other line. Raises ValueError, TypeError, KeyError for what gcomp did not write."""
    if "sent" in entry:
        entry = entry | {"sent": int(entry["sent"]), "source": int(entry["source"])}
        if "end_mm" in entry:
            entry["end_mm"] = _spot(entry["end_mm"])
        if "via_mm" in entry:
            entry["via_mm"] = [_spot(place) for place in entry["via_mm"]]
        past.sent = entry["sent"]
        recent.append(entry)
    elif "answered" in entry:
        past.answered = int(entry["answered"])
    elif "state" in entry:
        past.state, past.detail = str(entry["state"]), str(entry.get("detail", ""))
        past.executed = max(past.executed, int(entry.get("executed", 0)))
    elif "offsets" in entry:
        past.head["offsets"] = _offsets(entry["offsets"])
    elif "outcome" in entry:
        past.outcome = str(entry["outcome"])


def _set_restart(past: Past, recent: list[dict[str, Any]]) -> None:
    """Where to begin, and the way on which the machine may have stopped."""
    if "holds" not in past.head:  # written before it was counted what is over
        past.executed = max(past.executed, past.answered - OLD_HOLDS)
    past.recent = recent
    past.first = next(
        (i for i, entry in enumerate(recent) if entry["sent"] > past.executed), len(recent)
    )
    past.certain = begins(past, past.first)


def begins(past: Past, first: int) -> int:
    """The source line with which to begin again where the line recent[first] may not be over."""
    # Lines that move count alone: dwells and M words are no margin.
    left, back = MARGIN, first
    while back > 0 and left:
        back -= 1
        left -= _moves(past.recent, back)
    # Lines of another file are those of a tool change, whose own line comes with them.
    sources = [
        entry["source"] for entry in past.recent[back:] if entry["source"] and "file" not in entry
    ]
    return min(sources, default=past.head["begin"])


def way(past: Past) -> list[tuple[int, list[Spot]]] | None:
    """Where the machine may have stopped: for every line from the last that is surely over its
    index in `recent`, and its places from where the one before ends. None: it is not known."""
    first = max(past.first - 1, 0)
    # All is over up to `first`: the machine stands where that line ends, or on its way from there
    # on.
    start = (
        past.place
        if past.executed == 0
        else past.recent[first].get("end_mm", ())
        if past.recent
        else ()
    )
    if not any(v is not None for v in start):
        return None
    found, at = [(first, [start])], start
    for i in range(first, len(past.recent)):
        entry = past.recent[i]
        if "end_mm" not in entry:
            return None
        places = [*entry.get("via_mm", ()), entry["end_mm"]]
        found.append((i, [at, *places]))
        at = places[-1]
    return found


def _moves(recent: list[dict[str, Any]], i: int) -> bool:
    """Whether an entry has another end than the one before, or is an arc."""
    return "via_mm" in recent[i] or (
        i > 0 and recent[i].get("end_mm") != recent[i - 1].get("end_mm")
    )
