"""Jobs of gcomp on the real GRBL image: clean, interrupted and begun again, with faults on the
wire."""

from __future__ import annotations

import contextlib
import random
import signal
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from postproc.streaming import journal
from proof.streaming.judge import WITHIN, Verdict, Way, judged
from proof.streaming.programs import Program
from tests.streaming import real_grbl
from tests.streaming.real_grbl import RealGrbl

ZERO = (-170.0, -170.0, -30.0)  # mm: G54, within the travel of 300 mm of ee_homing.bin
SECOND = tuple(a + b for a, b in zip(ZERO, (20.0, 10.0, 0.0), strict=True))  # G55
# Motions that may be cut twice, begun ones and one on which the plunge lies counted: where the
# controller still knows where it stands; and where it does not, and what it can hold comes to them.
KNOWN, LOST = journal.MARGIN + 3, journal.MARGIN + 3 + 21
HOME = (1000, 1000, 1000)  # steps: where the homing switches are
REPEATS = 3.0  # steps, to which a homing finds its place again


REFUSED, LIED = 2, "a zero that was lost was accepted"
PATIENCE = 120.0  # s


@dataclass
class Row:
    """One job: what was done, what came of it, and whether that is as promised."""

    what: str
    said: str
    right: bool
    verdict: Verdict | None = None
    status: int = 0
    behind: float = 0.0  # s that the simulator fell behind the clock
    unseen: float = 0.0  # mm aside in a job that ended as done


@contextlib.contextmanager
def folder() -> Iterator[Path]:
    with tempfile.TemporaryDirectory(prefix="gcomp-real-") as name:
        yield Path(name)


def written(place: Path, program: Program) -> None:
    (place / "job.nc").write_text(program.text)


def zeros(real: RealGrbl) -> None:
    for p, place in ((1, ZERO), (2, SECOND)):
        real.talk(f"G10 L2 P{p} X{place[0]} Y{place[1]} Z{place[2]}")
    real.talk("G21 G90 G54")


def clean(program: Program) -> Row:
    """A whole job: every place in order, nothing beside."""
    with folder() as place:
        written(place, program)
        with RealGrbl(place) as real:
            zeros(real)
            n = len(real.steps())
            status, said = real_grbl.stream(place, real.path, "job.nc", "--quiet")
            steps, behind = real.steps()[n:], real.behind
    verdict = judged(Way(program, ZERO), steps, np.zeros((0, 3)))
    right = status == 0 and verdict.right(0)
    return Row(f"{program.name}: whole", short(said), right, verdict, status, behind)


# -- interruptions --------------------------------------------------------------------------------


def hold_and_go_on(real, process) -> None:
    process.send_signal(signal.SIGINT)
    time.sleep(1.2)
    process.send_signal(signal.SIGUSR1)


def stopped_in_a_hold(real, process) -> None:
    process.send_signal(signal.SIGTERM)


def reset_in_motion(real, process) -> None:
    process.send_signal(signal.SIGINT)
    process.send_signal(signal.SIGINT)
    time.sleep(0.05)
    process.send_signal(signal.SIGINT)


def killed(real, process) -> None:
    process.kill()


def cable(real, process) -> None:
    real.tell("cut")
    process.wait(30)
    real.tell("plug")


def power(real, process) -> None:
    real.tell("power")


def reset_button(real, process) -> None:
    real.tell("btn reset 1")
    time.sleep(0.1)
    real.tell("btn reset 0")


@dataclass(frozen=True)
class Interruption:
    """do: what happens. homes: whether the way back needs homing (else it must be refused
    without)."""

    do: Callable
    homes: bool = False


ALL = (
    Interruption(hold_and_go_on),
    Interruption(stopped_in_a_hold),
    Interruption(killed),
    Interruption(cable),
    Interruption(reset_in_motion, True),
    Interruption(power, True),
    Interruption(reset_button, True),
)


def interrupted(program: Program, how: Interruption, seed: int) -> Row:
    """A job that is interrupted at a random line, and begun again as gcomp says."""
    r = random.Random(f"{program.name} {how.do.__name__} {seed}")
    answered = r.randrange(8, max(9, program.text.count("\n") - 6))
    switches = ("-home", *map(str, HOME)) if how.homes else ()
    eeprom = "ee_homing.bin" if how.homes else "ee_router.bin"
    with folder() as place:
        written(place, program)
        with RealGrbl(place, *switches, eeprom=eeprom) as real:
            if how.homes:
                real.talk("$X")
            zeros(real)
            n = len(real.steps())
            status, said = _broken(real, place, how, answered)
            real.rest()
            first = real.steps()[n:]
            if status:
                status, said, accepted = _begun_again(real, place, how)
            else:
                accepted = ", and it went on to the end"
            second = real.steps()[n + len(first) :]
            behind = real.behind
    what = f"{program.name}: {how.do.__name__} at line {answered}"
    if accepted == LIED:
        return Row(what, f"{LIED}: {said}", False, None, status, behind)
    if status == REFUSED:
        return Row(what, "refused: " + short(said), not len(second), None, status, behind)
    way = Way(program, _zero_of(how))
    verdict = judged(way, first, second, WITHIN + REPEATS * how.homes)
    margin = LOST if how.homes else KNOWN + way.near(first[-1], way.reached(first))
    right = status == 0 and verdict.right(margin)
    return Row(f"{what}{accepted}", short(said), right, verdict, status, behind)


def _begun_again(real: RealGrbl, place: Path, how: Interruption) -> tuple[int, str, str]:
    """The way back. A controller that is locked has lost its zero: without homing that must be
    refused, and move nothing."""
    resume = ("job.nc", "--quiet", "--resume-from", "job.nc.journal", "--yes")
    locked = how.homes and "Alarm" in real.talk("?")
    if locked:
        n = len(real.steps())
        status, said = real_grbl.stream(place, real.path, *resume)
        if status != REFUSED or len(real.steps()) != n:
            return status, said, LIED
    elif how.homes and how.do is power:
        return 0, "it is not locked", LIED
    homed = ("--home",) if locked else ()
    return *real_grbl.stream(place, real.path, *resume, *homed), ", homed" * locked


def _zero_of(how: Interruption) -> tuple[float, ...]:
    """mm: where G54 lies by the count of the motors, which is 0 where they were switched on: homing
    puts machine zero at the switches."""
    if not how.homes:
        return ZERO
    return tuple(z + h / real_grbl.STEPS for z, h in zip(ZERO, HOME, strict=True))


def _broken(real: RealGrbl, place: Path, how: Interruption, answered: int) -> tuple[int, str]:
    """The job, and what happens to it when so many lines are answered."""
    homed = ("--home",) if how.homes else ()
    process = real_grbl.start(place, real.path, "job.nc", "--quiet", *homed)
    kept = place / "job.nc.journal"
    deadline = time.monotonic() + PATIENCE
    while process.poll() is None and time.monotonic() < deadline:
        if kept.exists() and kept.read_bytes().count(b'"answered"') >= answered:
            how.do(real, process)
            break
        time.sleep(0.004)
    said = process.communicate(timeout=PATIENCE)[1]
    return process.returncode, said


def short(said: str) -> str:
    return " ".join(said.split())[-300:]
