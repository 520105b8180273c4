"""GRBL 1.1 as its documents describe it, in simulated time: a receive buffer that drops, EEPROM
writes that lose bytes, paced bytes.

From gnea/grbl: serial.h (128 bytes usable; realtime bytes are taken out in the interrupt; what
finds no room is dropped), protocol.c (a line ends with either line end, is answered once, an empty
one with ok; blanks, control characters and comments do not count; more than 79 characters give
error:11), interface.md (reports, messages, streaming and EEPROM), system.c ($ commands). Not
simulated: acceleration, overrides, limits, parking. While EEPROM is written all bytes that arrive
are lost (interrupts are off).
"""

from __future__ import annotations

import math
import re
from collections import deque

from tests.streaming.grbl_motion import report, target, way

WORD = re.compile(r"([A-Z])([-+]?[0-9]*\.?[0-9]*)")
KNOWN_G = {
    "0",
    "1",
    "2",
    "3",
    "4",
    "10",
    "17",
    "18",
    "19",
    "20",
    "21",
    "28",
    "28.1",
    "30",
    "30.1",
    "38.2",
    "40",
    "43.1",
    "49",
    "53",
    "54",
    "55",
    "56",
    "57",
    "58",
    "59",
    "61",
    "80",
    "90",
    "91",
    "91.1",
    "92",
    "92.1",
    "93",
    "94",
}
WORK = ("G54", "G55", "G56", "G57", "G58", "G59")
IDLE, RUN, HOLD, ALARM, CHECK, HOME = "Idle", "Run", "Hold", "Alarm", "Check", "Home"
NEVER, REALTIME = math.inf, b"?!~\x18"
SEGMENTS, SEGMENT_S = 5, 0.01
EEPROM_S, PARSE_S, READ_S, HOMING_S = 0.020, 0.0006, 0.00001, 3.0


class GrblModel:
    """write() what is on the wire, advance() the time, read() what comes back. `received`: lines as
    the firmware saw them."""

    banner = "\r\nGrbl 1.1h ['$' for help]\r\n"

    def __init__(
        self,
        baud: int = 115200,
        rx: int = 128,
        blocks: int = 15,
        echo: bool = False,
        homing: bool = False,
        settings: dict[str, str] | None = None,
        version: str = "1.1h.20190825:",
        options: str = "V,15,{rx}",
    ):
        self.byte = 10.0 / baud if baud else 0.0
        self.rx_size, self.blocks, self.echo, self.version = rx, blocks, echo, version
        self.options = options.format(rx=rx)
        self.settings = {
            "10": "3",
            "13": "0",
            "22": "1" if homing else "0",
            "100": "800.000",
            "110": "3000.000",
        } | (settings or {})
        self.now = 0.0
        self.dropped = self.dropped_realtime = self.peak = 0
        self.received: list[str] = []
        self.accepted: list[str] = []
        self.told_shift, self.reports = [0.0, 0.0, 0.0], 1
        self.ends: list[list[float]] = []  # where each motion goes, machine coordinates
        self.made = 0  # of these motions, how many are over
        self.stored = {name: [0.0, 0.0, 0.0] for name in WORK}
        self._wire: deque[tuple[float, int]] = deque()
        self._wire_free = self._tx_free = 0.0
        self._tx: deque[tuple[float, bytes]] = deque()
        self.state = ALARM if homing else IDLE
        self.place = [0.0, 0.0, 0.0]
        self.lost = [0.0, 0.0, 0.0]  # mm by which its zero lies off since the power was lost
        self.plate = -math.inf  # mm, machine coordinates: where a probe that goes down touches
        self.probed = [0.0, 0.0, 0.0]
        self._reset()
        self._say(self.banner)
        if homing:
            self._say("[MSG:'$H'|'$X' to unlock]\r\n")

    def _reset(self) -> None:
        self._rx: deque[int] = deque()
        self._line = bytearray()
        self._ready = self.now
        self._deaf = 0.0
        self._planner: deque[list] = deque()  # [seconds left, seconds, from, to]
        self._planned = self.now
        self._pending: tuple[str, str] | None = None  # a line that waits, and for what
        self._until = 0.0
        self.modal = {
            "motion": "0",
            "work": "G54",
            "units": "21",
            "distance": "90",
            "feed": "94",
            "plane": "17",
        }
        self.target = list(self.place)
        self.preset, self.length, self.rate = [0.0] * 3, 0.0, 0.0
        self._hold_done = 0.0

    # -- the wire ----------------------------------------------------------------------------------

    def write(self, data: bytes, now: float) -> None:
        for value in data:
            self._wire_free = max(self._wire_free, now) + self.byte
            self._wire.append((self._wire_free, value))

    def read(self, now: float) -> bytes:
        out = []
        while self._tx and self._tx[0][0] <= now:
            out.append(self._tx.popleft()[1])
        return b"".join(out)

    def _say(self, text: str) -> None:
        data = text.encode("latin-1")
        self._tx_free = max(self._tx_free, self.now) + self.byte * len(data)
        self._tx.append((self._tx_free, data))

    def advance(self, now: float) -> None:
        """Let everything happen that happens up to `now`, in order."""
        while True:
            self._texts(now)
            arrives = self._wire[0][0] if self._wire else NEVER
            acts = self._next()
            ends = (
                self._planned + self._planner[0][0]
                if self._planner and self.state == RUN
                else NEVER
            )
            when = min(arrives, acts, ends)
            if when > now:
                break
            self._move(max(when, self.now))
            if when == ends:
                continue
            if when == arrives:
                self._arrive(self._wire.popleft()[1])
            else:
                self._act()
        self._move(now)

    def due(self) -> float:
        """When something happens next at the earliest, where nothing is written until then."""
        ends = [self._wire[0][0] if self._wire else NEVER, self._tx[0][0] if self._tx else NEVER]
        if self._planner and self.state == RUN:
            over = self._planned + self._planner[0][0]
            room = self._pending is not None and self._pending[1] == "room"
            ends.append(over - SEGMENTS * SEGMENT_S * room)
        return min(*ends, self._next())

    def _texts(self, now: float) -> None:
        """Characters within lines that arrive or are read up to `now`, before anything else
        happens: nearly all that happens is these, and the motors do not care."""
        if self.state not in (RUN, IDLE):
            return
        wire, rx, waits = self._wire, self._rx, self._pending is not None
        ends = self._planned + self._planner[0][0] if self._planner and self.state == RUN else NEVER
        acts = self._next()  # does not change while a line waits
        at, ready = self.now, self._ready
        while True:
            if not waits:
                acts = max(ready, at) if rx else NEVER
            arrives = wire[0][0] if wire else NEVER
            when = arrives if arrives <= acts else acts
            if when > now or when >= ends:
                break
            if when == arrives:
                value = wire[0][1]
                if value in REALTIME or value >= 0x80:
                    break
                wire.popleft()
                at = max(when, at)
                if at < self._deaf or len(rx) >= self.rx_size:
                    self.dropped += 1
                else:
                    rx.append(value)
                    self.peak = max(self.peak, len(rx))
            elif waits or rx[0] in b"\r\n":
                break
            else:
                at = max(when, at)
                self._line.append(rx.popleft())
                ready = at + READ_S
        self.now, self._ready = at, ready

    def _arrive(self, value: int) -> None:
        if self.now < self._deaf:
            self.dropped_realtime += value in REALTIME
            self.dropped += value not in REALTIME
        elif value in REALTIME or value >= 0x80:
            self._realtime(value)
        elif len(self._rx) >= self.rx_size:
            self.dropped += 1
        else:
            self._rx.append(value)
            self.peak = max(self.peak, len(self._rx))

    def _realtime(self, value: int) -> None:
        if value == ord("?"):
            if self.state != HOME:
                self._report()
        elif value == ord("!") and self.state in (RUN, IDLE):
            self.state, self._hold_done = HOLD, self.now + 0.05
        elif value == ord("~") and self.state == HOLD:
            self.state = RUN if self._planner else IDLE
            self._planned = self.now
            if self._pending and self._pending[1] == "resume":
                self._finish(self._pending[0])
        elif value == 0x18:
            moving = self.state in (RUN, HOME) or (
                self.state == HOLD and self.now < self._hold_done
            )
            if moving:
                self._say("ALARM:3\r\n")
            self.restart(ALARM if moving else (self.state if self.state == ALARM else IDLE))

    def power(self) -> None:
        """The power goes and comes: it believes that it stands at zero, wherever it is."""
        self.lost = [a + b for a, b in zip(self.lost, self.place, strict=True)]
        self.place = [0.0, 0.0, 0.0]
        self.restart(ALARM if self.settings["22"] == "1" else IDLE)

    def restart(self, state: str = IDLE) -> None:
        """What a reset leaves: the place, and what EEPROM holds."""
        self.state = state
        self._reset()
        self._say(self.banner)
        if state == ALARM:
            self._say("[MSG:'$H'|'$X' to unlock]\r\n")

    # -- the main loop -----------------------------------------------------------------------------

    def _next(self) -> float:
        """When the main loop can do something."""
        if self._pending:
            wants = self._pending[1]
            if wants == "room":
                free = self.planned < self.blocks
            elif wants == "rest":
                free = not self._planner
            elif wants == "time":
                return max(self._until, self.now)
            else:
                return float("inf")
            return max(self.now, self._ready) if free else float("inf")
        if not self._rx or self.state == HOLD:
            return float("inf")
        return max(self._ready, self.now)

    def _act(self) -> None:
        if self._pending:
            text, wants = self._pending
            self._pending = None
            if wants == "time":
                self._finish(text)
            else:
                self._execute(text, waited=wants)
            return
        value = self._rx.popleft()
        self._ready = self.now + READ_S
        if value not in b"\r\n":
            self._line.append(value)
            return
        raw, self._line = self._line.decode("latin-1"), bytearray()
        text = self._bare(raw)
        self.received.append(text)
        self._ready = self.now + PARSE_S
        if self.echo:
            self._say(f"[echo: {text}]\r\n")
        if len(text) > 79:
            self._say("error:11\r\n")
        elif not text:
            self._say("ok\r\n")
        else:
            self._execute(text)

    @staticmethod
    def _bare(raw: str) -> str:
        text = re.sub(r"\([^)]*\)?", "", raw.split(";")[0] if "(" not in raw else raw)
        text = text.split(";")[0]
        return "".join(c for c in text if c > " " and c != "/").upper()

    def _finish(self, text: str, answer: str = "ok") -> None:
        self._pending = None
        if answer == "ok":
            self.accepted.append(text)
        self._say(answer + "\r\n")

    def _execute(self, text: str, waited: str = "") -> None:
        if text.startswith("$"):
            self._system(text, waited)
        elif self.state == ALARM:
            self._finish(text, "error:9")
        else:
            self._block(text, waited)

    def _system(self, text: str, waited: str) -> None:
        if text == "$I":
            self._say(f"[VER:{self.version}]\r\n[OPT:{self.options}]\r\n")
        elif text in ("$$", "$+"):
            self._say("".join(f"${k}={v}\r\n" for k, v in self.settings.items()))
        elif text == "$#":
            places = {**self.stored, "G28": [0.0] * 3, "G30": [0.0] * 3, "G92": self.preset}
            for name, place in places.items():
                self._say(f"[{name}:{','.join(f'{v:.3f}' for v in place)}]\r\n")
            self._say(f"[TLO:{self.length:.3f}]\r\n{self._touch()}")
        elif text == "$G":
            m = self.modal
            self._say(
                f"[GC:G{m['motion']} {m['work']} G{m['plane']} G{m['units']} G{m['distance']}"
                f" G{m['feed']} M5 M9 T0 F{self.rate:.0f} S0]\r\n"
            )
        elif text == "$X":
            self.state = IDLE
            self._say("[MSG:Caution: Unlocked]\r\n")
        elif text == "$C" and self.state == CHECK:
            self._say("[MSG:Disabled]\r\n")
            self._finish(text)
            self.restart()
            return
        elif text == "$C" and self.state == IDLE:
            self.state = CHECK
            self._say("[MSG:Enabled]\r\n")
        elif text == "$H" and not waited:
            self.state, self._until, self._pending = HOME, self.now + HOMING_S, (text, "time")
            return
        elif re.fullmatch(r"\$\d+=[-0-9.]+", text) and self.state == IDLE:
            self.settings[text[1:].split("=")[0]] = text.split("=")[1]
            self._eeprom(text)
            return
        else:
            self._finish(text, "error:8" if text[1:2] in "$CN" or "=" in text else "error:3")
            return
        self._finish(text)

    def _eeprom(self, text: str) -> None:
        """Interrupts are off while it writes; then it answers."""
        self._deaf = self._until = self.now + EEPROM_S
        self._pending = (text, "time")

    def _block(self, text: str, waited: str) -> None:
        words = WORD.findall(text)
        if "".join(a + b for a, b in words) != text:
            self._finish(text, "error:1" if not text[0].isalpha() else "error:2")
            return
        try:
            values = [(a, float(b)) for a, b in words]
        except ValueError:
            self._finish(text, "error:2")
            return
        codes = [f"{v:g}" for a, v in values if a == "G"]
        if any(c not in KNOWN_G for c in codes) or any(a in "ABCDEHOQUVW" for a, _ in values):
            self._finish(text, "error:20")
            return
        letters = [a for a, _ in values if a not in "GM"]
        if len(set(letters)) != len(letters):
            self._finish(text, "error:25")
            return
        number = dict(values)
        m_words = [int(v) for a, v in values if a == "M"]
        stores = bool({"10", "28.1", "30.1"} & set(codes))
        if (
            (
                stores
                or "38.2" in codes
                or any(m in (0, 1, 2, 30, 3, 4, 5, 7, 8, 9) for m in m_words)
                or "4" in codes
            )
            and waited != "rest"
            and self._planner
        ):
            self._pending = (text, "rest")
            return
        if self.state == CHECK:
            if (
                self._axes_move(codes, number)
                and (self.modal["motion"] if not codes else codes[-1]) in "123"
                and not number.get("F", self.rate)
            ):
                self._finish(text, "error:22")
            else:
                self.rate = number.get("F", self.rate)
                self._take_codes(codes)
                self._finish(text)
            return
        motion = next((c for c in codes if c in "0123"), self.modal["motion"])
        moves = self._axes_move(codes, number)
        rate = number.get("F", 0.0) * (25.4 if self._units(codes) == "20" else 1.0) or self.rate
        if moves and motion in "123" and not rate:
            self._finish(text, "error:22")
            return
        if moves and self.planned >= self.blocks:
            self._pending = (text, "room")
            return
        self.rate = rate
        self._take_codes(codes)
        self.modal["motion"] = motion
        if stores:
            name = WORK[int(number.get("P", 1)) - 1]
            for i, axis in enumerate("XYZ" if "10" in codes else ""):
                if axis in number:
                    self.stored[name][i] = (
                        number[axis] if number.get("L") == 2 else self.target[i] - number[axis]
                    )
            self._eeprom(text)
            return
        if "92" in codes:
            for i, axis in enumerate("XYZ"):
                if axis in number:
                    self.preset[i] = (
                        self.target[i] - self.stored[self.modal["work"]][i] - number[axis]
                    )
        elif "92.1" in codes:
            self.preset = [0.0] * 3
        elif "43.1" in codes or "49" in codes:
            self.length = number.get("Z", 0.0)
        elif "4" in codes and number.get("P"):
            self._until, self._pending = self.now + number["P"], (text, "time")
            return
        elif moves and "38.2" in codes:
            self._probe(text, codes, number)
            return
        elif moves:
            self._plan(codes, number, motion)
        if 0 in m_words:
            self.state, self._hold_done, self._pending = HOLD, self.now, (text, "resume")
            return
        if 2 in m_words or 30 in m_words:
            self._say("[MSG:Pgm End]\r\n")
            self.modal.update(motion="1", work="G54", distance="90", feed="94", plane="17")
        self._finish(text)

    def _touch(self) -> str:
        place = ",".join(f"{v:.3f}" for v in self.probed)
        return f"[PRB:{place}:{int(any(self.probed))}]\r\n"

    def _probe(self, text: str, codes: list[str], number: dict[str, float]) -> None:
        """Down to the plate, at once; an alarm where it is not met (motion_control.c,
        mc_probe_cycle)."""
        end = target(self, codes, number, 25.4 if self.modal["units"] == "20" else 1.0)
        if end[2] > self.plate:
            self._say("ALARM:5\r\n")
            self.state = ALARM
            return
        end[2] = self.plate
        self.place, self.target, self.probed = end, list(end), list(end)
        self._say(self._touch())
        self._finish(text)

    def _units(self, codes: list[str]) -> str:
        return next((c for c in codes if c in ("20", "21")), self.modal["units"])

    @staticmethod
    def _axes_move(codes: list[str], number: dict[str, float]) -> bool:
        return any(a in number for a in "XYZ") and not {
            "10",
            "92",
            "43.1",
            "4",
            "28.1",
            "30.1",
        } & set(codes)

    def _take_codes(self, codes: list[str]) -> None:
        for code in codes:
            if f"G{code}" in WORK:
                self.modal["work"] = f"G{code}"
            for group, members in (
                ("units", ("20", "21")),
                ("distance", ("90", "91")),
                ("feed", ("93", "94")),
                ("plane", ("17", "18", "19")),
            ):
                if code in members:
                    self.modal[group] = code

    @property
    def planned(self) -> int:
        """Blocks in the planner: those that the stepper has taken whole into its segments have left
        it (stepper.c: a segment lasts 10 ms, or to the end of its block)."""
        segments = taken = 0
        for left, *_ in self._planner:
            segments += math.ceil(left / SEGMENT_S - 1e-9) or 1
            if segments > SEGMENTS:
                break
            taken += 1
        return len(self._planner) - taken

    def _steps(self, place: list[float]) -> list[int]:
        return [
            round(v * float(self.settings.get(str(100 + i), "800"))) for i, v in enumerate(place)
        ]

    def _plan(self, codes: list[str], number: dict[str, float], motion: str) -> None:
        unit = 25.4 if self.modal["units"] == "20" else 1.0
        start, end = list(self.target), target(self, codes, number, unit)
        speed = float(self.settings["110"]) if motion == "0" else self.rate
        self.target = end
        self.ends.append(end)
        places = way(start, end, number, motion, self.modal["plane"], unit)
        last = places[-1]
        for place in places:
            seconds = sum((a - b) ** 2 for a, b in zip(start, place)) ** 0.5 / speed * 60.0
            if self._steps(place) != self._steps(start):  # else it makes no block (planner.c)
                self._planned = self._planned if self._planner else self.now
                self._planner.append(
                    [seconds, seconds, start, place, len(self.ends) if place is last else 0]
                )
                self.state = RUN if self.state == IDLE else self.state
            start = place

    def _move(self, now: float) -> None:
        """The steppers, up to `now`."""
        if self.state == HOME and now >= self._until:
            self.state, self.place, self.target, self.lost = IDLE, [0.0] * 3, [0.0] * 3, [0.0] * 3
        spent = now - self._planned
        # a hold takes its time, along the path
        slows = self.state == HOLD and self.now < self._hold_done
        if self.state == RUN or (slows and self._planner):
            while self._planner and spent >= self._planner[0][0] - 1e-12:
                spent -= self._planner[0][0]
                self._planned += self._planner[0][0]
                *_, place, number = self._planner.popleft()
                self.place, self.made = list(place), number or self.made
            if self._planner:
                left, whole, start, end, _ = self._planner[0]
                share = 1.0 - (left - max(spent, 0.0)) / whole
                self.place = [a + (b - a) * share for a, b in zip(start, end)]
                self._planner[0][0] = left - max(spent, 0.0)
            elif not slows:
                self.state = IDLE
        self._planned = now
        self.now = now

    def _report(self) -> None:
        state = self.state
        if state == HOLD:
            state = "Hold:1" if self.now < self._hold_done else "Hold:0"
        self._say(report(self, state))
