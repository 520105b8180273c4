"""Marlin's side of the wire, as its source has it, in simulated time.

MarlinFirmware/Marlin, Marlin/src/gcode/queue.cpp: a receive buffer of 128 bytes that drops, bytes
read only while one of the four command slots is free; N first, then its number, then its checksum;
a line that fails throws the rest of the buffer away and asks for last + 1 (with an ok of its own,
or without, as one time's build did); a line without N is taken unchecked. gcode.cpp: busy every two
seconds while a command does not end. parser.cpp: an unknown command is repeated, and answered with
ok. Not simulated: heaters, acceleration, arcs (a chord).
"""

from __future__ import annotations

import re
from collections import deque

from tests.streaming.models_wire import NEVER, Moves, Receiver

WORD = re.compile(r"([A-Z])(-?\d*\.?\d*)")
KNOWN = {
    "G0",
    "G1",
    "G2",
    "G3",
    "G4",
    "G17",
    "G20",
    "G21",
    "G28",
    "G90",
    "G91",
    "G92",
    "M0",
    "M3",
    "M5",
    "M17",
    "M82",
    "M92",
    "M105",
    "M108",
    "M110",
    "M113",
    "M114",
    "M115",
    "M117",
    "M400",
    "M410",
    "M503",
}
KEEPALIVE, PARSE, WAIT = 2.0, 0.0008, 1.0
STEPS = (80.0, 80.0, 400.0)


class MarlinModel(Receiver):
    """`executed`: commands in the order in which they were executed, without number and checksum;
    `unchecked`: those that had none."""

    def __init__(
        self,
        baud: int = 115200,
        rx: int = 128,
        slots: int = 4,
        advanced: bool = False,
        own_ok: bool = True,
        keepalive: bool = True,
        says_wait: bool = False,
        temperatures: float = 0.0,
        deaf: float = 0.0,
        settings: tuple[str, ...] = ("M420 S0 Z0.00", "M852 I0.0000 J0.0000 K0.0000"),
    ):
        super().__init__(baud, rx)
        self.slots, self.advanced, self.own_ok, self.keepalive = slots, advanced, own_ok, keepalive
        self.says_wait, self.temperatures, self.deaf, self.settings = (
            says_wait,
            temperatures,
            deaf,
            settings,
        )
        self.unchecked: list[str] = []
        self.most_lines = 0
        self.moves = Moves()
        self.zero = [0.0, 0.0, 0.0]
        self._reset()
        self.say("start\nMarlin 2.1.2\necho: Last Updated: 2023-01-01\n")

    def _reset(self) -> None:
        self.rx.clear()
        self.last_n = 0
        self._line = bytearray()
        self._ring: deque[str] = deque()
        self._since: float | None = None  # when the command in execution began
        self._free = self.now
        self._busy_at = self._wait_at = NEVER
        self._temperature_at = self.now + self.temperatures if self.temperatures else NEVER
        self._deaf_until = 0.0
        self._paused = False

    def restart(self) -> None:
        self.moves = Moves()
        self._reset()
        self.say("start\n")

    @property
    def place(self) -> list[float]:
        return self.moves.place

    # -- time --------------------------------------------------------------------------------------

    def _reads(self) -> float:
        if not self.rx or len(self._ring) >= self.slots:
            return NEVER
        return max(self.now, self._deaf_until)

    def _ends(self) -> float:
        """When the command in execution is done."""
        if not self._ring:
            return NEVER
        code, words = self._code(self._ring[0])
        started = self._since if self._since is not None else max(self._free, self.now)
        if self._paused:
            return NEVER
        if code in ("M400", "G92", "G28"):
            return self.moves.rest_at(started) + (3.0 if code == "G28" else 0.0)
        if code == "G4":
            return self.moves.rest_at(started) + words.get("P", 0.0) / 1000 + words.get("S", 0.0)
        if code in ("G0", "G1", "G2", "G3"):
            return max(started + PARSE, self.moves.room_at(self.now))
        return started + PARSE

    def _next(self) -> float:
        if self._ring and self._since is None:
            return max(self.now, self._free)
        idle = not self._ring and not self.rx and self.says_wait
        if idle and self._wait_at == NEVER:
            self._wait_at = self.now + WAIT
        elif not idle:
            self._wait_at = NEVER
        return min(self._reads(), self._ends(), self._busy_at, self._wait_at, self._temperature_at)

    def _act(self) -> None:
        if self._ring and self._since is None:
            self._since = self.now
            self._busy_at = self.now + KEEPALIVE if self.keepalive else NEVER
            code = self._code(self._ring[0])[0]
            if code == "M0":
                self._paused = True
            self._deaf_until = self.now + self.deaf
            return
        if self._ends() <= self.now:
            self._execute(self._ring[0])
            self._ring.popleft()
            self._since, self._free, self._busy_at = None, self.now, NEVER
        elif self._reads() <= self.now:
            self._read(self.rx.popleft())
        elif self._busy_at <= self.now:
            self.say(f"echo:busy: {'paused for user' if self._paused else 'processing'}\n")
            self._busy_at = self.now + KEEPALIVE
        elif self._temperature_at <= self.now:
            self.say(" T:21.30 /0.00 B:21.30 /0.00 @:0 B@:0\n")
            self._temperature_at = self.now + self.temperatures
        elif self._wait_at <= self.now:
            self.say("wait\n")
            self._wait_at = self.now + WAIT

    # -- lines in ----------------------------------------------------------------------------------

    def _read(self, value: int) -> None:
        if value not in b"\r\n":
            if len(self._line) < 95:
                self._line.append(value)
            return
        raw, self._line = self._line.split(b";")[0], bytearray()
        command = raw.decode("latin-1").lstrip(" ")
        if not command:
            return
        if command.startswith("N"):
            renumbers = "M110" in command
            at = command.find("N", 4) if renumbers else 0
            n = self._number(command[max(at, 0) + 1 :])
            if n != self.last_n + 1 and not renumbers:
                return self._fault("Line Number is not Last Line Number+1")
            star = command.rfind("*")
            if star < 0:
                return self._fault("No Checksum with line number")
            value = 0
            for byte in command[:star].encode("latin-1"):
                value ^= byte
            if self._number(command[star + 1 :]) != value:
                return self._fault("checksum mismatch")
            self.last_n = n
        elif command.startswith("M108"):
            self._paused = False
        elif command.startswith("M410"):
            self.moves.ends.clear()
            self.moves.last = self.now
        self._ring.append(command)
        self.most_lines = max(self.most_lines, len(self._ring))

    @staticmethod
    def _number(text: str) -> int:
        found = re.match(r" *(-?\d+)", text)
        return int(found[1]) if found else 0

    def _fault(self, what: str) -> None:
        self.say(f"Error:{what}, Last Line: {self.last_n}\n")
        self.rx.clear()
        self.say(f"Resend: {self.last_n + 1}\n" + ("ok\n" if self.own_ok else ""))

    # -- commands ----------------------------------------------------------------------------------

    @staticmethod
    def _bare(command: str) -> str:
        return re.sub(r"^N-?\d+ *", "", command).split("*")[0].rstrip()

    def _code(self, command: str) -> tuple[str, dict[str, float]]:
        words = [
            (k, v)
            for k, v in WORD.findall(self._bare(command).replace(" ", ""))
            if v not in ("", "-", ".")
        ]
        values = {k: float(v) for k, v in words if v.strip("-.")}
        first = words[0] if words else ("", "")
        code = first[0] + first[1].lstrip("0") if first[1].lstrip("0") else first[0] + "0"
        return code, values

    def _execute(self, command: str) -> None:
        text = self._bare(command)
        code, words = self._code(command)
        if not command.startswith("N"):
            self.unchecked.append(text)
        if code not in KNOWN or text[:1] not in ("G", "M", "T"):
            self.say(f'echo:Unknown command: "{text}"\n')
        else:
            self.executed.append(text)
            self._does(code, words, text)
        words_of_ok = ""
        if self.advanced:
            number = re.match(r"N(-?\d+)", command)
            free = 15 - len(self.moves.ends)
            words_of_ok = (
                f" N{number[1]}" if number else ""
            ) + f" P{max(free, 0)} B{self.slots - len(self._ring)}"
        self.say(f"ok{words_of_ok}\n")

    def _does(self, code: str, words: dict[str, float], text: str) -> None:
        moves = self.moves
        if code in ("G0", "G1", "G2", "G3"):
            moves.take(words, self.now)
        elif code in ("G90", "G91"):
            moves.absolute = code == "G90"
        elif code == "G28":
            moves.place = [0.0, 0.0, 0.0]
        elif code == "G92":
            self.zero = [
                self.zero[i] if x not in words else moves.place[i] - words[x]
                for i, x in enumerate("XYZ")
            ]
        elif code == "M110":
            self.last_n = int(words.get("N", self.last_n))
        elif code == "M115":
            self.say(
                "FIRMWARE_NAME:Marlin 2.1.2 (Jan 1 2023 12:00:00)"
                " SOURCE_CODE_URL:github.com/MarlinFirmware/Marlin PROTOCOL_VERSION:1.0"
                " MACHINE_TYPE:Router EXTRUDER_COUNT:0\nCap:EEPROM:0\nCap:EMERGENCY_PARSER:0\n"
            )
        elif code == "M113":
            self.say(f"echo:M113 S{2 if self.keepalive else 0}\n")
        elif code == "M503":
            self.say(
                "".join(
                    f"echo:  {line}\n"
                    for line in (
                        "M92 X80.00 Y80.00 Z400.00",
                        "M203 X500.00 Y500.00 Z5.00",
                        *self.settings,
                    )
                )
            )
        elif code == "M114":
            p, z = moves.place, self.zero
            counts = [round(v * s) for v, s in zip(p, STEPS, strict=True)]
            self.say(
                f"X:{p[0] - z[0]:.2f} Y:{p[1] - z[1]:.2f} Z:{p[2] - z[2]:.2f} E:0.00 Count"
                f" X:{counts[0]} Y:{counts[1]} Z:{counts[2]}\n"
            )
