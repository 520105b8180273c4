"""Whether the controller's zero still lies where an interrupted job had it: what must be certain
before a tool goes back into a cut.

A GRBL that has restarted believes that it stands at machine zero, wherever it is, until it is
homed; its work offsets (EEPROM) count from there. What G53 or a plunge does then is off by all of
that. So a restart needs proof: homed in this session, or a controller that has not restarted and
stands on the way on which the journal left it.
"""

from __future__ import annotations

import math
import re

import numpy as np

from postproc.errors import UsageError
from postproc.streaming import journal
from postproc.streaming.journal import Past
from postproc.streaming.live import SAME_MM, Live
from postproc.streaming.outcome import ABORTED, ALARM, DISCONNECTED, RESET
from postproc.streaming.path import nearest
from postproc.streaming.protocols import Controller

NEAR_MM = 0.1  # of the way: a journal's arcs are chords that miss by 45 um, a report is rounded
FEED = re.compile(r"F *0*[1-9]|F *0*\.0*[1-9]", re.IGNORECASE)
HOMED, UNLOCKED = "homed", "unlocked"
TOUCHED = (
    "touch off the work zero anew, look where the tool stands, and say --zero-is-right (--yes"
    " does not say that)"
)


def moved(past: dict[str, dict[str, float]], now: dict[str, dict[str, float]]) -> str:
    """The first work offset that is not what it was, in words; ""."""
    for name in sorted({*past, *now}):
        mine, theirs = past.get(name, {}), now.get(name, {})
        for axis in sorted({*mine, *theirs}):
            a, b = mine.get(axis, 0.0), theirs.get(axis, 0.0)
            if abs(a - b) > SAME_MM:
                return (
                    f"{name} had {axis} = {a:g} mm when the job began, and has {axis} = {b:g}"
                    " mm now"
                )
    return ""


def stopped(past: Past) -> str:
    """How the job's end may have cost the zero, in words; ""."""
    if past.outcome in (ALARM, RESET) or past.state == "alarm":
        return (
            "the job ended in an alarm, or the controller restarted in it: steps may have been lost"
        )
    # GRBL, doc/markdown/interface.md, "Machine State": Hold:0 and Door:0 stand; Hold:1 and Door:2
    # still brake, Door:3 goes on again, and Door:1 stands with the door open.
    still = past.state == "idle" or (past.state in ("hold", "door") and past.detail in ("", "0"))
    if past.outcome == ABORTED and not still:
        return "the job was stopped while the machine moved: steps may have been lost"
    return ""


def forgot(past: Past, controller: Controller) -> bool:
    """Whether a controller has lost the feed that the job gave it, as it does when it restarts
    (gcode.c, gc_init). Where the job ended in a hold, the reset that leads out of it does that too,
    and nothing follows."""
    if past.outcome not in ("", DISCONNECTED) or past.state in ("hold", "door"):
        return False
    fed = any(
        FEED.search(str(e.get("text", ""))) for e in past.recent if int(e["sent"]) <= past.answered
    )
    return fed and "F0" in controller.modal


def found(past: Past, place: tuple[float, ...], near: float) -> tuple[int | None, float]:
    """On which line of past.recent it stands: the first that comes so near (mm), None where none
    does; and the least distance, mm, nan where one is not known. place: nan for an axis that is not
    reported."""
    way = journal.way(past)
    here = np.array(place)
    if way is None or np.isnan(here).all():
        return None, math.nan
    least = math.inf
    for index, places in way:
        width = min(len(here), *map(len, places))
        points = np.array([[np.nan if v is None else v for v in at[:width]] for at in places])
        # An axis that the journal or the report leaves open is left out: 0 in both.
        unknown = np.isnan(points) | np.isnan(here[:width])
        points = np.where(unknown, 0.0, points)
        to = np.where(unknown.any(axis=0), 0.0, here[:width])
        points[:, unknown.any(axis=0)] = 0.0
        # the last place twice: a way of one place has no leg, and one of length 0 will do
        _, off = nearest(np.vstack([points, points[-1:]]), to)
        if off <= near:
            return index, off
        least = min(least, off)
    return None, least


def beside(past: Past, place: tuple[float, ...], near: float, letters: tuple[str, ...]) -> str:
    """Where it stands instead of on the way on which the journal left it, in words; ""."""
    index, off = found(past, place, near)
    if index is not None:
        return ""
    if math.isnan(off):
        return (
            "where the machine can have stopped is not known, from the journal or from its reports"
        )
    said = " ".join(
        f"{x}{v:.3f}" for x, v in zip(letters, place, strict=False) if not math.isnan(v)
    )
    return (
        f"the controller stands at {said} (machine coordinates), {off:.3f} mm from where the"
        " journal left it"
    )


def certain(past: Past, live: Live, letters: tuple[str, ...], controller: Controller) -> int:
    """The source line with which to begin again, of a controller of which there is no doubt(): by
    where it stands, if that is on the way, else by what the journal says was over."""
    place = tuple(live.place.get(x, math.nan) for x in letters)
    index, _ = found(past, place, within(controller))
    return past.certain if index is None else journal.begins(past, max(index, past.first))


def within(controller: Controller) -> float:
    """mm from its way at which a machine stands on it."""
    return NEAR_MM + 2 * controller.coarsest_step


def _of_unlocked(past: Past | None) -> str:
    """Why homing moves the zero of a job."""
    if past is None or past.head.get("zero") != UNLOCKED:
        return ""
    return "the job ran on a controller that was unlocked and not homed: homing moves its zero"


def zero_lost(
    past: Past | None,
    live: Live,
    letters: tuple[str, ...],
    controller: Controller,
    restarted: bool,
    done: str,
) -> str:
    """Why the zero may not be where the job had it, in words; "": it is. past: the job's journal;
    letters: the machine's axes in its order; restarted: it has greeted as one that has just
    started; done: HOMED, UNLOCKED or "", in this session."""
    # In the order in which one settles it: offsets that were changed (homing does not bring them
    # back); homed here, which is proof; restarted or unlocked, which is none; then what the journal
    # says.
    if past is not None and (words := moved(past.head.get("offsets", {}), live.work)):
        return words
    if done == HOMED:
        return _of_unlocked(past)
    if restarted:
        return (
            "the controller has just restarted and was not homed since: it has forgotten where the"
            " machine stands (where opening the port does that, --no-reset-on-open prevents it the"
            " next time)"
        )
    if done == UNLOCKED:
        return "the controller was locked, and unlocking does not tell it where the machine stands"
    if past is None:
        return "there is no journal of this program here that says where the machine stopped"
    if forgot(past, controller):
        return (
            "the controller has forgotten the feed that the job gave it: it has restarted since,"
            " and was not homed"
        )
    place = tuple(live.place.get(x, math.nan) for x in letters)
    return stopped(past) or beside(past, place, within(controller), letters)


def refuse(words: str, controller: Controller) -> None:
    """Raises UsageError for a doubt."""
    if words:
        homes = controller.homing is not False
        raise UsageError(
            f"nothing was sent: the zero may be lost. {words[0].upper()}{words[1:]}",
            f"home it (--home), or {TOUCHED}" if homes else TOUCHED,
        )
