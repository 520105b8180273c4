"""A control that is fed over RS-232: a buffer, DC1 and DC3 with hysteresis, and an alarm where
bytes come on after DC3.

General knowledge of Fanuc's reader interface (unverified on hardware): DC1 when reading begins, DC3
when the buffer is nearly full, DC1 when it has room, DC4 at the end or in alarm; what finds no room
is lost (alarm 087), and a wrong parity stops reading. The program is what stands between the first
`%` and the second.
"""

from __future__ import annotations

from tests.streaming.models_wire import NEVER, Receiver

DC1, DC3, DC4 = b"\x11", b"\x13", b"\x14"


class DncModel(Receiver):
    """rate: bytes/s that it executes; high, low: filling at which it says stop and go; after: bytes
    that it has taken since it said stop, the most of them; begins: s until it says go (None: it
    never does and reads all the same)."""

    def __init__(
        self,
        baud: int = 9600,
        rx: int = 100,
        high: int = 70,
        low: int = 20,
        rate: float = 300.0,
        bits: int = 11,
        begins: float | None = 2.0,
        stops: bool = True,
        seven: bool = True,
        pauses: dict[int, float] | None = None,
    ):
        super().__init__(baud, rx, bits)
        self.high, self.low, self.rate, self.stops, self.seven = high, low, rate, stops, seven
        self.pauses = pauses or {}  # after so many bytes executed: s of standstill
        self.text = bytearray()
        self.after = self.most_after = 0
        self.alarm = ""
        self.odd: list[int] = []
        self.ended = False
        self._off = False
        self._go_at = begins if begins is not None else NEVER
        self._eats_at = 0.0
        self._marks = self._eaten = 0
        self.early = 0
        self._waits = begins is not None

    def restart(self) -> None:
        """Somebody presses reset: it reads no more."""
        self.alarm = "reset"
        self.say(DC4)

    @property
    def received(self) -> list[str]:
        """Blocks between the marks."""
        return [row for row in self.text.decode("latin-1").replace("\r", "").split("\n") if row]

    def _arrive(self, value: int) -> None:
        if value >= 0x80 and self.seven:
            self.odd.append(value)
            self._stop("parity")
        if ord("a") <= value <= ord("z"):
            self.odd.append(value)
        self.early += self._waits
        if self.alarm or self.ended:
            return
        if self._off:
            self.after += 1
            self.most_after = max(self.most_after, self.after)
        full = len(self.rx) >= self.rx_size
        self.keep(value)
        if full and self.stops:
            self._stop("087")
        if not self._off and len(self.rx) >= self.high:
            self._off, self.after = True, 0
            self.say(DC3)

    def _stop(self, why: str) -> None:
        if not self.alarm:
            self.alarm = why
            self.say(DC4)

    def _next(self) -> float:
        times = [self._go_at]
        if self.rx and not self.alarm:
            times.append(max(self._eats_at, self.now))
        return min(times)

    def _act(self) -> None:
        if self._go_at <= self.now:
            self._go_at, self._waits = NEVER, False
            self.say(DC1)
            return
        value = self.rx.popleft()
        self._eaten += 1
        self._eats_at = self.now + 1.0 / self.rate + self.pauses.get(self._eaten, 0.0)
        if value == ord("%"):
            self._marks += 1
            if self._marks == 2:
                self.ended = True
                self.say(DC3 + DC4)
        elif self._marks == 1:
            self.text.append(value)
        if self._off and len(self.rx) <= self.low and not self.ended:
            self._off = False
            self.say(DC1)
