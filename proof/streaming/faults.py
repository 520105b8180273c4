"""Faults on the wire and at the machine while a job runs on the real image: does any job end as
done that was not?"""

from __future__ import annotations

import random
import re
import subprocess
import threading
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from postproc.streaming.limits import Limits
from proof.streaming import programs
from proof.streaming.judge import WITHIN, Way, judged
from proof.streaming.real import ZERO, Row, folder, short, written, zeros
from tests.streaming import real_grbl
from tests.streaming.real_grbl import STEPS, RealGrbl

RATE = 5000.0  # mm/min: the fastest that the machine moves ($110)
# What goes aside and comes back between two reports can not be seen (docs/STREAMING.md): mm.
UNSEEN = RATE / 60 * Limits.watch / 2
WAITS = 8.0  # s that a person lets a machine hold
JOBS = (
    programs.zigzag,
    programs.fine,
    programs.fast,
    programs.surface,
    programs.inch,
    programs.no_block,
)
Fault = tuple[str, tuple[str, ...], Callable[[RealGrbl, random.Random], None], bool]


def _tell(text: Callable[[random.Random], str]) -> Callable[[RealGrbl, random.Random], None]:
    return lambda real, r: real.tell(text(r))


def _mute(real: RealGrbl, r: random.Random) -> None:
    real.tell("mute")
    time.sleep(r.choice((0.3, 1.0, 4.0)))
    real.tell("unmute")


def _buttons(real: RealGrbl, r: random.Random) -> None:
    for what, pause in (("hold", r.uniform(0.3, 1.5)), ("start", 0.0)):
        real.tell(f"btn {what} 1")
        time.sleep(0.05)
        real.tell(f"btn {what} 0")
        time.sleep(pause)


def _reset(real: RealGrbl, r: random.Random) -> None:
    real.tell("btn reset 1")
    time.sleep(0.1)
    real.tell("btn reset 0")


def _cut(real: RealGrbl, r: random.Random) -> None:
    real.tell("cut")
    time.sleep(r.uniform(0.0, 3.0))
    real.tell("plug")


# Name; what happens; whether a job must come to its end although.
KINDS: dict[str, tuple[Callable[[RealGrbl, random.Random], None], bool]] = {
    "nothing": (lambda real, r: None, True),
    "hold and start buttons": (_buttons, True),
    "answers lost": (_tell(lambda r: f"txdrop {r.choice((1, 2, 5, 20, 100))}"), False),
    "bytes lost": (_tell(lambda r: f"drop {r.choice((1, 1, 2, 5))}"), False),
    "a bit flipped": (_tell(lambda r: f"flip {r.randrange(1, 300)} {1 << r.randrange(7)}"), False),
    "silent": (_mute, False),
    "cable": (_cut, False),
    "power": (_tell(lambda r: "power"), False),
    "reset button": (_reset, False),
}


def aside(way: Way, steps: np.ndarray) -> float:
    """mm: how far the tool was from the way at most, or the way from the tool."""
    off = cKDTree(steps).query(way.places, p=np.inf)[0].max() if len(steps) else np.inf
    return max(float(off) / STEPS, way.beside(steps) / STEPS)


def schedule(seed: int) -> Row:
    """One job with one or two faults at random times."""
    r = random.Random(f"faults {seed}")
    program = r.choice(JOBS)()
    names = [r.choice(list(KINDS)) for _ in range(r.choice((1, 1, 2)))]
    latency = ("-latency", str(r.choice((2, 10, 30)))) if r.random() < 0.25 else ()
    with folder() as place:
        written(place, program)
        with RealGrbl(place, *latency) as real:
            zeros(real)
            n = len(real.steps())
            process = real_grbl.start(place, real.path, "job.nc", "--quiet")
            doing = threading.Thread(target=_do, args=(real, place, r, names, process), daemon=True)
            doing.start()
            went_on: list[str] = []
            person = threading.Thread(
                target=_person, args=(real, place, process, went_on), daemon=True
            )
            person.start()
            try:
                said = process.communicate(timeout=180)[1]
            except subprocess.TimeoutExpired:
                process.kill()
                return Row(f"{program.name}: {', '.join(names)}", _odd(place, program), False)
            doing.join(30)
            real.rest()
            steps = real.steps()[n:]
            slow = real.behind
    way = Way(program, ZERO)
    status = process.returncode
    what = (
        f"{program.name}:"
        f" {', '.join([*names, *went_on])}{' ' + ' '.join(latency) if latency else ''}"
    )
    verdict = judged(way, steps, np.zeros((0, 3)))
    right = verdict.right(0)
    if status == 0 and not right:
        off = aside(way, steps)
        said = f"done although {off:.3f} mm aside"
        return Row(what, said, off <= UNSEEN, verdict, status, slow, unseen=off)
    if status and all(KINDS[name][1] for name in names):
        return Row(what, "a false alarm: " + short(said), False, verdict, status, slow)
    return Row(what, short(said), "Traceback" not in said, verdict, status, slow)


def _odd(place: Path, program: programs.Program) -> str:
    """What the controller has received that is no line of the program: a feed that lost a digit,
    say."""
    received = (place / "rx.bin").read_bytes().decode("latin-1")
    wanted = set(program.text.split("\n"))
    rows = [re.sub(r"[?!~]", "", row).strip() for row in received.split("\n")]
    return (
        "it has not ended; received and not sent:"
        f" {[row for row in rows if row not in wanted][-8:]}"
    )


def _do(real: RealGrbl, place: Path, r: random.Random, names: list[str], process) -> None:
    """The faults, when the job moves."""
    journal = place / "job.nc.journal"
    while process.poll() is None:
        if journal.exists() and b'"answered"' in journal.read_bytes():
            break
        time.sleep(0.01)
    for name in names:
        time.sleep(r.uniform(0.2, 6.0))
        if process.poll() is None:
            KINDS[name][0](real, r)


def _person(real: RealGrbl, place: Path, process: subprocess.Popen, went_on: list[str]) -> None:
    """Whoever stands at a machine that holds for no reason (a flipped bit makes `!` of a 1) presses
    start: gcomp waits for that, as it does at M0."""
    journal, since = place / "job.nc.journal", 0.0
    while process.poll() is None:
        time.sleep(0.5)
        states = re.findall(
            rb'"state":"([a-z]+)"', journal.read_bytes()[-2000:] if journal.exists() else b""
        )
        if not states or states[-1] != b"hold":
            since = time.monotonic()
        elif time.monotonic() - since > WAITS:
            real.tell("btn start 1")
            time.sleep(0.05)
            real.tell("btn start 0")
            went_on.append("a hold that nobody ordered, start pressed")
            since = time.monotonic()


def quick(number: int) -> Row:
    """A clean job of short pieces: no false alarm, every place in order."""
    program = programs.short(number)
    with folder() as place:
        written(place, program)
        with RealGrbl(place) as real:
            zeros(real)
            n = len(real.steps())
            status, said = real_grbl.stream(place, real.path, "job.nc", "--quiet")
            steps, slow = real.steps()[n:], real.behind
    verdict = judged(Way(program, ZERO), steps, np.zeros((0, 3)), WITHIN)
    return Row(program.name, short(said), status == 0 and verdict.right(0), verdict, status, slow)
