"""LinuxCNC by its own remote interface, linuxcncrsh on TCP: it runs the program in auto mode from a
file that both can see.

Rules: linuxcncrsh(1) and LinuxCNC's src/emc/usr_intf/emcrsh.cc (a command a line, of 255 bytes at
most; hello, enable; SET .. ACK or NAK where verbose is on). Its `mdi` takes ten lines a second,
whatever they move, and goes on with the next line behind one that it refuses (both seen on 2.9): so
the program is not sent line by line. gcomp writes it into a file, has it opened and run, and takes
a line for answered when `program_line` has gone past it. A message behind a dwell at the program's
end says that it came to its end (another panel may take the message away: then the last motion must
have been seen in execution); without that, what ended was not the whole program. Line numbers of
the file are those of the wire and one more, for its first line is %.

    out   hello EMC gcomp 1.0                  in   HELLO ACK ..
    out   set mode auto, set open .., set run  in   SET MODE ACK, SET OPEN ACK, SET RUN ACK
    out   get program_line .. abs_act_pos      in   PROGRAM_LINE 12 .. ABS_ACT_POS 1.000000 ..
                                                    wire lines below 11 are over: two reports of 12
"""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Iterable, Iterator, Mapping

from postproc.streaming.events import Accepted, Alarm, Event, Message, Rejected, Restarted, Status
from postproc.streaming.lines import Unsendable
from postproc.streaming.protocols import Controller, Protocol

TITLE = "LinuxCNC (linuxcncrsh)"
POKE = b""  # its hello would be a line to execute for others
COMMENT = re.compile(rb"\([^()\n]*\)|;[^\n]*")
FOREIGN = re.compile(rb"[^\t\x20-\x7e]")
ENDS = re.compile(rb"^(?:N[0-9]+)?\s*M0*(?:2|30)(?![0-9.])", re.IGNORECASE)
LONGEST = 255  # LINELEN, emc/nml_intf/emcglb.h
COMMAND = 250  # bytes; linuxcncrsh keeps a command in 256 and does not look
AHEAD = 2000  # lines that are taken for sent beyond the one in execution
DWELL = b"G4 P1"  # s at the end: long enough that reports see it
DONE = "gcomp: the program has come to its end"
OPENS = 30.0  # s that a long program may take to be opened
STARTS = 10  # reports of idle behind the order to run
# Numbered parameters of the work offsets, G92 and the tool length (LinuxCNC's manual, G-code
# overview, numbered parameters): linuxcncrsh itself reports an offset that it read at its start as
# 0 (seen on 2.9).
SYSTEMS = ("G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3")
ZEROS = {name: 5221 + 20 * i for i, name in enumerate(SYSTEMS)} | {"G92": 5211, "TLO": 5401}
G92_ON = 5210
ASKS = (SYSTEMS[:3], SYSTEMS[3:6], SYSTEMS[6:], ("G92", "TLO"))  # a message has 255 characters
STATUS = (
    b"get error", b"get operator_display", b"get operator_text", b"get machine",
    b"get program_line", b"get program_status", b"get abs_act_pos",
)  # fmt: skip
URGENT = {
    "status": STATUS, "hold": (b"set pause",), "resume": (b"set resume",), "stop": (b"set abort",),
    "feed 100": (b"set feed_override 100",), "spindle 100": (b"set spindle_override 100",),
}  # fmt: skip
DOES = {
    "hold": "it was told to pause: resume goes on, abort ends the program",
    "stop": "it was told to abort: the program has ended where the machine stands",
}
NUMBER = re.compile(r"-?[0-9.]+")
HEARD = re.compile(r"([GT][0-9.LO]*)((?: -?[0-9.]+){3})")
AXIS = re.compile(rb"[A-CI-KRU-Z] *[-+.0-9#\[]", re.IGNORECASE)
AT = re.compile(r"\bon line ([0-9]+)")
STATES = {"IDLE": "idle", "RUNNING": "run", "PAUSED": "hold"}


def _zeros(names: tuple[str, ...]) -> tuple[bytes, ...]:
    """Questions for where these lie."""
    numbers = {name: " ".join(f"#{ZEROS[name] + k}" for k in range(3)) for name in names}
    words = " ".join(f"{name} {three}" for name, three in numbers.items())
    on = f" on #{G92_ON}" if "G92" in names else ""
    return (f"set mdi (DEBUG,{words}{on})".encode(), b"set wait done", b"get operator_display")


def recognises(banner: str) -> bool:
    """It says nothing before it is greeted."""
    return banner.startswith("HELLO ACK")


class Linuxcnc(Protocol):
    """One connection. `counting` means nothing here."""

    title = TITLE
    confirms = "idle"
    modal = True
    handed = True  # the program is put into a file
    does: Mapping[str, str] = DOES
    questions: tuple[bytes, ...] = (
        b"hello EMC gcomp 1.0", b"set echo off", b"set verbose on", b"set enable EMCTOO",
        b"set linear_unit_conversion mm", b"get joint_homed", b"get program_codes", b"set mode mdi",
        *(question for names in ASKS for question in _zeros(names)),
    )  # fmt: skip
    hails = questions[:4]  # before it answers anything
    closing: tuple[bytes, ...] = ()

    def __init__(self, counting: bool = True):
        self.controller = Controller(TITLE, window=COMMAND, line_limit=LONGEST, planner=0)
        self.opening: tuple[bytes, ...] = ()
        self._asked: deque[tuple[int, bytes]] = deque()
        self._lines: deque[int] = deque()  # numbers of program lines that are not over
        self._rest = b""
        self._said: dict[str, str] = {}
        self._place: tuple[float, ...] = ()
        self._run = self._moved = self._ended = False
        self._homed, self._axes = True, 6
        self._idle = 0
        self._line = 0  # of the file, in the report before
        self._last = self._seen = 0  # wire lines: the last that moves, and that was seen moving

    def file_of(self, lines: Iterable[bytes]) -> Iterator[bytes]:
        """The file that it runs, of the wire lines; each keeps its number, plus one."""
        yield b"%\n"
        mark = DWELL + b"\n(MSG," + DONE.encode() + b")\n"
        for line in lines:
            if mark and ENDS.match(line):
                yield mark
                mark = b""
            yield line + b"\n"
        yield mark + b"%\n"

    def hand_over(self, path: str) -> None:
        """The file is there: what opens and runs it."""
        opens = b"set open " + path.encode()
        if len(opens) > COMMAND:
            raise Unsendable(
                f"the path {path} is too long for linuxcncrsh, which takes {COMMAND} bytes",
                "--hand-over a shorter one",
            )
        self.opening = (b"set mode auto", opens, b"set run")

    # -- lines out -------------------------------------------------------------------------------

    def prepare(self, text: bytes) -> bytes:
        text = text.strip()
        if text.startswith(b"%"):
            return b""
        text = COMMENT.sub(b"", text).strip()
        if found := FOREIGN.search(text):
            what = f"the line has byte {found[0][0]} in it"
            raise Unsendable(what, "take it out; in comments it does no harm")
        if len(text) > LONGEST:
            what = f"the line has {len(text)} characters, and LinuxCNC takes {LONGEST}"
            raise Unsendable(what, "split it")
        return text

    def alone(self, text: bytes) -> bool:
        return text.startswith((b"set ", b"get ", b"hello "))

    def ready(self, text: bytes) -> bool:
        return not self._asked and (self.alone(text) or len(self._lines) < AHEAD)

    def send(self, number: int, text: bytes) -> bytes:
        if not self.alone(text):
            self._lines.append(number)
            self._last = number if AXIS.search(text) else self._last
            return b""  # it stands in the file
        self._asked.append((number, text))
        return text + b"\r\n"

    def urgent(self, what: str) -> bytes:
        return b"".join(command + b"\r\n" for command in URGENT.get(what, ()))

    def outstanding(self) -> list[int]:
        return [number for number, _ in self._asked] + list(self._lines)

    def patience(self, text: bytes) -> float:
        return OPENS if self.alone(text) else 2.0

    def forget(self) -> None:
        self._asked.clear()
        self._lines.clear()

    # -- answers in ------------------------------------------------------------------------------

    def receive(self, data: bytes) -> list[Event]:
        *lines, self._rest = (self._rest + data).replace(b"\r", b"\n").split(b"\n")
        events: list[Event] = []
        for line in lines:
            if text := line.decode("latin-1").strip():
                events += self._meaning(text)
        return events

    def _answered(self, text: str) -> list[Event]:
        """The answer to the question that has waited longest."""
        number, question = self._asked.popleft()
        if text.endswith(" NAK"):
            why = "switched off, in emergency stop, or held by another client"
            return [Rejected(number, text, why)]
        self._run = self._run or question == b"set run"
        heard = [] if question.startswith(b"set") else [Message(text)]
        return [*heard, Accepted(number)]

    def _meaning(self, text: str) -> list[Event]:
        if self._asked and self._answers(text):
            return self._answered(text)
        key, _, value = text.partition(" ")
        if key.lower().encode() in (command[4:] for command in STATUS):
            self._said[key] = value.strip()
            return self._reported() if key == "ABS_ACT_POS" else []
        if text == "SET ABORT ACK":
            self._run = False
            return [Restarted("the program was aborted")]
        return [] if key == "SET" else [Message(text)]

    def _answers(self, text: str) -> bool:
        """Whether it is the answer to the oldest question."""
        question = self._asked[0][1].decode("latin-1")
        if question == "set echo off":
            return text in (question, "SET ECHO ACK")  # its own echo; or it was verbose before
        verb, name = question.split()[:2]
        start = {"get": name.upper() + " ", "set": f"SET {name.upper()} ", "hello": "HELLO "}[verb]
        return text.startswith(start)

    def _reported(self) -> list[Event]:
        """A report is whole."""
        said = self._said
        values = list(filter(NUMBER.fullmatch, said["ABS_ACT_POS"].split()))
        place = tuple(map(float, values[: self._axes]))
        state = STATES.get(said.get("PROGRAM_STATUS", ""), "unknown")
        stands, self._place = place == self._place, place
        detail = f"{int(not stands)}" if state == "hold" else ""
        if said.get("MACHINE") == "OFF":
            state = "off"
        elif state == "idle" and not self._homed:
            state = "unhomed"
        before, self._line = self._line, int(said.get("PROGRAM_LINE", "0") or 0)
        mark = said.get("OPERATOR_DISPLAY", "") + said.get("OPERATOR_TEXT", "")
        self._ended = self._ended or DONE in mark
        events = self._trouble(said.pop("ERROR", "OK"), state)
        if self._run and not events:
            events = self._progress(state, min(self._line, before) - 1)
        return [*events, Status(state, detail, place, line=self._line)]

    def _trouble(self, fault: str, state: str) -> list[Event]:
        """What it complains of. It reads ahead: the line is the one in execution, or one behind
        it."""
        if fault == "OK" and not (self._run and state == "off"):
            return []
        if not self._run:
            return [Message(f"LinuxCNC says: {fault}")]
        self._run = False
        if fault == "OK":
            return [Alarm("off", "LinuxCNC was switched off, or is in emergency stop")]
        at = AT.search(fault)
        number = int(at[1]) - 1 if at else 0
        if number in self._lines:
            words = fault.replace(at[0], f"on its line {at[1]}") if at else fault
            return [Rejected(number, "error", words)]
        return [Alarm("error", f"{fault}. LinuxCNC reads ahead: it may be about a line farther on")]

    def _progress(self, state: str, line: int) -> list[Event]:
        """What became of the lines. line: of the wire, in execution; the lower one of two reports,
        for the first behind an order to run may still say the last line of the program before."""
        if state in ("run", "hold"):
            self._moved, self._seen = True, max(self._seen, line)
            return self._past(line)
        self._idle = self._idle + 1 if state == "idle" else 0
        if self._ended or (self._moved and self._seen >= self._last):
            return self._past(1 << 62)
        if self._lines and self._idle >= (2 if self._moved else STARTS):
            self._run = False
            why = "the program was ended before its end, by LinuxCNC's own panel or another client"
            return [Alarm("ended", why)]
        return []

    def _past(self, number: int) -> list[Event]:
        """All lines before this one are over."""
        events: list[Event] = []
        while self._lines and self._lines[0] < number:
            events.append(Accepted(self._lines.popleft()))
        return events

    # -- what it says of itself ------------------------------------------------------------------

    def _learn_offsets(self, text: str) -> None:
        preset = not text.endswith(" on 0.000000")
        for name, values in HEARD.findall(text):
            if name != "G92" or preset:
                place = values.split()[2:] if name == "TLO" else values.split()
                self.controller.offsets.append(f"[{name}:{','.join(place)}]")

    def learn(self, question: bytes, answers: list[str]) -> None:
        words = answers[-1].split() if answers else []
        if question.startswith(b"hello") and len(words) > 2:
            self.controller.name = "LinuxCNC"
            self.controller.version = f"(linuxcncrsh {' '.join(words[2:])})"
        elif question == b"get joint_homed":
            self._homed = "YES" in words
            self._axes = max(3, words.count("YES"))  # it reports six, whatever it has
        elif question == b"get program_codes":
            self.controller.modal = words[1:]
        elif question == b"get operator_display" and answers:
            self._learn_offsets(answers[-1])


PROTOCOL = Linuxcnc
