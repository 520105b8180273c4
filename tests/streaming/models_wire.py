"""What the models of receivers share: bytes at a baud rate, a receive buffer that drops, and one
desk for a sender and a model."""

from __future__ import annotations

from collections import deque

from postproc.streaming.protocols import UNLIMITED
from tests.streaming.bench import Faults

NEVER = float("inf")


class Receiver:
    """write(), advance(), read() in simulated time. A model fills in _arrive(byte), _next() (when
    its main loop acts) and _act()."""

    def __init__(self, baud: int, rx: int, bits: int = 10):
        self.byte = bits / baud if baud else 0.0
        self.rx_size = rx
        self.now = 0.0
        self.executed: list[str] = []
        self.dropped = self.peak = 0
        self.rx: deque[int] = deque()
        self._wire: deque[tuple[float, int]] = deque()
        self._tx: deque[tuple[float, bytes]] = deque()
        self._wire_free = self._tx_free = 0.0

    @property
    def received(self) -> list[str]:
        """Lines that it has taken, in order."""
        return self.executed

    def write(self, data: bytes, now: float) -> None:
        for value in data:
            self._wire_free = max(self._wire_free, now) + self.byte
            self._wire.append((self._wire_free, value))

    def on_the_way(self) -> int:
        """Bytes that have left the sender and not arrived."""
        return len(self._wire)

    def read(self, now: float) -> bytes:
        out = []
        while self._tx and self._tx[0][0] <= now:
            out.append(self._tx.popleft()[1])
        return b"".join(out)

    def say(self, text: str | bytes) -> None:
        data = text.encode("latin-1") if isinstance(text, str) else text
        for i in range(0, len(data), 16):
            piece = data[i : i + 16]
            self._tx_free = max(self._tx_free, self.now) + self.byte * len(piece)
            self._tx.append((self._tx_free, piece))

    def advance(self, now: float) -> None:
        while True:
            arrives = self._wire[0][0] if self._wire else NEVER
            acts = max(self._next(), self.now)
            when = min(arrives, acts)
            if when > now:
                break
            self.now = max(when, self.now)
            if arrives <= acts:
                self._arrive(self._wire.popleft()[1])
            else:
                self._act()
        self.now = max(now, self.now)

    def due(self) -> float:
        """When something happens next at the earliest: at any time."""
        return self.now

    def keep(self, value: int) -> None:
        """Into the receive buffer, or lost."""
        if len(self.rx) >= self.rx_size:
            self.dropped += 1
        else:
            self.rx.append(value)
            self.peak = max(self.peak, len(self.rx))

    def _arrive(self, value: int) -> None:
        self.keep(value)

    def _next(self) -> float:
        return NEVER

    def _act(self) -> None:
        raise NotImplementedError


def run(
    sender,
    model,
    lines,
    faults: Faults | None = None,
    limit: float = 900.0,
    tick: float = 0.005,
    actions=(),
    ahead: int = 64,
):
    """Until there is an outcome; returns the simulated time. A protocol that lets few bytes go gets
    to write when those before have left, as a port that is drained does it."""
    faults = faults or Faults()
    if model.now == 0.0:  # its greeting has been heard before
        model.advance(1.0)
        model.read(1.0)
    now = started = model.now
    lines, actions, late = iter(lines), sorted(actions, key=lambda a: a[0]), []
    more = True
    while sender.outcome is None:
        if now - started > limit:
            raise AssertionError(
                f"no outcome within {limit} s: {sender.state} {sender.status} {sender.waiting[:2]}"
            )
        while more and sender.queued < ahead:
            line = next(lines, None)
            if line is None:
                sender.end()
                more = False
            else:
                sender.give([line])
        while actions and now - started >= actions[0][0]:
            actions.pop(0)[1](sender, now)
        sender.tick(now)
        if sender.protocol.release() >= UNLIMITED:
            while data := sender.bytes_out():
                model.write(faults.pass_on("to", data), now)
        elif not model.on_the_way():
            model.write(faults.pass_on("to", sender.bytes_out()), now)
        now += tick
        model.advance(now)
        if now - started >= faults.reset:
            model.restart()
            faults.reset = NEVER
        if now - started >= faults.cut:
            sender.lost("the port was closed", now)
        data = faults.pass_on("back", model.read(now))
        if data:
            late.append((now + faults.lag, data))
        stalled = faults.stall[0] <= now - started < faults.stall[0] + faults.stall[1]
        while late and late[0][0] <= now and not stalled:
            sender.receive(late.pop(0)[1], now)
    return now - started


def greet(greeting, model, limit: float = 60.0, tick: float = 0.01):
    """The talk before a job, to its end."""
    now = model.now
    started = now
    while not greeting.done and greeting.fault is None:
        assert now - started < limit
        greeting.tick(now)
        model.write(greeting.bytes_out(), now)
        now += tick
        model.advance(now)
        data = model.read(now)
        greeting.receive(data, now)
    return greeting


class Moves:
    """A planner: motions in order, each with its seconds; where the machine ends up. mm and mm/min,
    absolute or not."""

    def __init__(self, blocks: int = 16):
        self.blocks = blocks
        self.ends: deque[float] = deque()
        self.last = 0.0
        self.place = [0.0, 0.0, 0.0]
        self.feed, self.absolute, self.motion = 1500.0, True, 1

    def clear(self, now: float) -> None:
        while self.ends and self.ends[0] <= now:
            self.ends.popleft()

    def room_at(self, now: float) -> float:
        """When there is room for one more."""
        self.clear(now)
        return now if len(self.ends) < self.blocks else self.ends[len(self.ends) - self.blocks]

    def rest_at(self, now: float) -> float:
        return max(now, self.last)

    def take(self, words: dict[str, float], now: float) -> None:
        """A block's words, as they come: codes are told apart by the caller."""
        if "F" in words:
            self.feed = max(words["F"], 1.0)
        target = list(self.place)
        for i, axis in enumerate("XYZ"):
            if axis in words:
                target[i] = words[axis] if self.absolute else target[i] + words[axis]
        length = sum((a - b) ** 2 for a, b in zip(target, self.place, strict=True)) ** 0.5
        self.place = target
        if length:
            self.last = max(self.last, now) + length / self.feed * 60.0
            self.ends.append(self.last)
