"""The pass in which the controller reads the program in its check mode, before anything moves.

It ends in a reset: what that would change, and the program goes by, forbids it.
"""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from postproc.errors import UsageError
from postproc.streaming import live as lives
from postproc.streaming.live import Live

if TYPE_CHECKING:
    from postproc.commands.stream.job import Job
    from postproc.commands.stream.signals import Signals
    from postproc.streaming.greeting import Greeting
    from postproc.streaming.rates import Load

PASSED = "the controller has read the program in its check mode, and refuses none of it"
SECONDS, SHARE = 10.0, 0.05  # that it may take on the wire, s, or of the job


def _changes_nothing(job: Job) -> bool:
    """Whether all that is in force now is so again behind check mode's reset."""
    assert job.known is not None
    # a reset forgets both; G54 to G59 lie in EEPROM
    dropped = "G92" in job.live.work or any(job.live.length.values())
    return job.known.checkable() and not dropped


def wanted(options: argparse.Namespace, job: Job, load: Load) -> bool:
    """Whether the controller shall read the program first. Raises UsageError where that is asked
    for and would change something."""
    how = options.check_first
    if how == "never" or options.check or not job.protocol.check_mode():
        return False
    checkable = _changes_nothing(job)
    if how == "always" and not checkable:
        raise UsageError(
            "a pass in check mode ends in a reset, which would drop a G92, a tool length, modes, a"
            " feed or a speed that are in force now, or stop the spindle, and the program's own"
            " settings (G10, G28.1) would be stored in it",
            "--check-first never",
        )
    seconds = load.bytes / load.rate if load.rate else 0.0
    return checkable and (how == "always" or seconds <= max(SECONDS, SHARE * load.expected))


def reconnected(
    port, options: argparse.Namespace, greeting: Greeting, machine, job: Job, signals: Signals
) -> Greeting:
    """The controller behind the pass, with the same zeros and modes as before. Raises
    UsageError."""
    from postproc.commands.stream import loop
    from postproc.streaming.greeting import Greeting

    greeted = Greeting(greeting.found[0], counting=not options.simple)
    signals.at_once = lambda name: loop.interrupt(port, greeted, name)
    loop.greet(port, greeted)
    assert greeted.protocol is not None
    now = lives.read(greeted.protocol.controller, greeted.status, machine.letters)
    if changed := changes(job.live, now):
        raise UsageError(
            "nothing has moved: the controller's check of the program ended in a reset, and that"
            f" has changed something: {changed}",
            "start the job again, or --check-first never",
        )
    job.protocol = greeted.protocol
    signals.at_once = None
    return greeted


def changes(before: Live, now: Live) -> str:
    """What is not as it was, in words; "": nothing. A motion in force (G0, G1) is left out: a
    program that goes by it is not read first."""
    modes = [
        " ".join(sorted(word for word in live.modal if word not in lives.MOTIONS))
        for live in (before, now)
    ]
    found = [f"the modes were {modes[0]} and are {modes[1]}"] if modes[0] != modes[1] else []
    places = {
        **{
            name: (before.work.get(name, {}), now.work.get(name, {}))
            for name in before.work | now.work
        },
        "the tool length": (before.length, now.length),
        "its place": (before.place, now.place),
    }
    found += [
        f"{name} was {_said(a)} and is {_said(b)}" for name, (a, b) in places.items() if a != b
    ]
    return "; ".join(found)


def _said(place: dict[str, float]) -> str:
    return " ".join(f"{axis}{value:g}" for axis, value in place.items()) or "not set"
