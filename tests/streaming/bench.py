"""A sender and a model on one desk, in simulated time: what passes between them, and what faults do
to it."""

from __future__ import annotations

import math
import random
from dataclasses import dataclass, field

from postproc.streaming import journal
from postproc.streaming.lines import WireLine
from postproc.streaming.path import Path
from postproc.streaming.protocols.grbl import Grbl
from postproc.streaming.sender import Sender
from tests.streaming.grbl_model import GrblModel

TICK = 0.002


@dataclass
class Faults:
    """What happens on the way, by the count of bytes that have passed. `to` and `back`: byte number
    to "drop", "flip" or "double"; stall: (time, seconds) in which nothing passes back; cut: time at
    which the port closes; reset: time at which the controller restarts; power: at which it loses
    its zero, too; lag: s that answers are late; asleep: (time, seconds) in which the sender's own
    computer does nothing."""

    to: dict[int, str] = field(default_factory=dict)
    back: dict[int, str] = field(default_factory=dict)
    stall: tuple[float, float] = (0.0, 0.0)
    cut: float = float("inf")
    reset: float = float("inf")
    power: float = float("inf")
    lag: float = 0.0
    asleep: tuple[float, float] = (math.inf, 0.0)
    random: random.Random = field(default_factory=lambda: random.Random(0))
    _count: dict[str, int] = field(default_factory=lambda: {"to": 0, "back": 0})

    def pass_on(self, way: str, data: bytes) -> bytes:
        plan = self.to if way == "to" else self.back
        begin = self._count[way]
        self._count[way] += len(data)
        if not plan or not any(begin <= k < begin + len(data) for k in plan):
            return data
        out = bytearray()
        for i, value in enumerate(data, begin):
            what = plan.get(i)
            if what == "drop":
                continue
            out.append(value ^ (1 << self.random.randrange(7)) if what == "flip" else value)
            if what == "double":
                out.append(value)
        return bytes(out)


def lines_of(text: str, ends: list[tuple[float, ...]] | None = None) -> list[WireLine]:
    """Wire lines of plain text, source lines counted from 1."""
    rows = text.strip().split("\n")
    return [
        WireLine(i, i, 0, row.encode(), ends[i - 1] if ends else ())
        for i, row in enumerate(rows, 1)
    ]


def run(
    sender: Sender,
    model: GrblModel,
    lines,
    faults: Faults | None = None,
    limit: float = 600.0,
    tick: float = TICK,
    ready: bool = True,
    actions=(),
    kept: list[bytes] | None = None,
) -> float:
    """Until there is an outcome; returns the simulated time. `actions`: (time, callable(sender,
    now)) in order; kept: takes the journal's records."""
    faults = faults or Faults()
    now = model.now
    if ready:  # the greeting has been heard before
        model.advance(now := now + 1.0)
        model.read(now)
    started = now
    lines, actions, late, logged = iter(lines), list(actions), [], 0
    more = True
    while sender.outcome is None:
        if now - started > limit:
            raise AssertionError(
                f"no outcome within {limit} s: {sender.state} {sender.status} {sender.waiting[:2]}"
            )
        while more and sender.queued < 64:
            line = next(lines, None)
            if line is None:
                sender.end()
                more = False
            else:
                sender.give([line])
        while actions and now - started >= actions[0][0]:
            actions.pop(0)[1](sender, now)
        if now - started >= faults.asleep[0]:
            now, faults.asleep = now + faults.asleep[1], (math.inf, 0.0)
        sender.tick(now)
        while data := sender.bytes_out():
            model.write(faults.pass_on("to", data), now)
        now += tick
        if now - started >= faults.reset:
            model.advance(now)
            model.restart()
            faults.reset = float("inf")
        if now - started >= faults.power:
            model.advance(now)
            model.power()
            faults.power = float("inf")
        if now - started >= faults.cut:
            sender.lost("the port was closed", now)
        model.advance(now)
        data = faults.pass_on("back", model.read(now))
        if data:
            late.append((now + faults.lag, data))
        stalled = faults.stall[0] <= now - started < faults.stall[0] + faults.stall[1]
        while late and late[0][0] <= now and not stalled:
            sender.receive(late.pop(0)[1], now)
        if kept is not None:
            executed = sender.account.executed
            kept += [journal.record(*entry, executed) for entry in sender.log[logged:]]
            logged = len(sender.log)
    return now - started


def new_sender(
    model: GrblModel, counting: bool = True, window: int | None = None, watched: bool = False, **how
) -> Sender:
    """A sender that knows the model's buffer. watched: it looks whether the machine stays on the
    path."""
    protocol = Grbl(counting=counting)
    controller = protocol.controller
    controller.window = window or model.rx_size
    controller.planner, controller.segments = model.blocks + 1, 5
    controller.settings, controller.inches = dict(model.settings), model.settings["13"] == "1"
    return Sender(protocol, path=Path(controller) if watched else None, **how)


def zigzag(
    n: int, seed: int = 1, feed: int = 6000, step: float = 0.3, still: bool = False
) -> tuple[str, list[tuple[float, ...]]]:
    """n lines of motion with lengths of text that differ, and where each ends. still: every other
    line is one that makes no block: words without a motion, or a motion below a step of the
    motors."""
    r = random.Random(seed)
    place = [0.0, 0.0, 0.0]
    rows, ends = ["G21G90G94"], [(0.0, 0.0, 0.0)]
    for i in range(n - 1):
        if still and i and r.random() < 0.5:
            below = f"G1 Z{place[2] + r.uniform(-0.0002, 0.0002):.6f}"
            rows.append(r.choice(("G94", "G90 G94", f"F{feed}", below)))
            ends.append(tuple(place))
            continue
        words = []
        for k, axis in enumerate("XYZ"):
            if r.random() < 0.7 or (axis == "Z" and not words):
                place[k] = round(place[k] + r.uniform(-step, step), r.choice((1, 3, 4)))
                words.append(f"{axis}{place[k]:.{r.choice((4, 6))}f}")
        gap = r.choice(("", " "))
        rows.append(gap.join([f"G1{gap}F{feed}" if i == 0 or r.random() < 0.2 else "G1", *words]))
        ends.append(tuple(place))
    return "\n".join(rows), ends
