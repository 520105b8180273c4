"""What runs next in a LinuxCNC program: labels, branches, loops, subs.

LinuxCNC keeps one table of labels, skips lines until it meets the label that it waits for, and has
one flag each for "a branch was taken", "break" and "continue"; all of this is done here as there. A
label of a branch or a loop belongs to the sub in which it stands, the label of a sub to the whole
run.

Sources: LinuxCNC documentation, "O codes"; measured on LinuxCNC 2.9
(tests/expand/test_linuxcnc.py).
"""

from __future__ import annotations

from dataclasses import dataclass, field

from postproc.nc.expand import Program, Refusal
from postproc.nc.expand.linuxcnc_blocks import Block, Control, special_lines
from postproc.nc.expand.linuxcnc_expressions import CORRECT, whole
from postproc.nc.expand.linuxcnc_parameters import Memory

GLOBAL = ("sub", "", "endsub", "return", "call")  # keywords whose labels are known everywhere
CLOSED_BY = {
    "sub": "endsub",
    "if": "endif",
    "while": "endwhile",
    "repeat": "endrepeat",
    "do": "while",
}
MOST_REPEATS = 2**31


@dataclass
class File:
    """A program's lines. name: "" for the main program. special: which lines may be more than plain
    words; met: which of them have been looked at; read: what those are that were met again."""

    name: str
    program: Program
    read: dict[int, Block | Control] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.lines = self.program.whole_lines()
        self.special = special_lines(self.program.text, len(self.lines))
        self.met = bytearray(len(self.lines))


@dataclass
class Place:
    """A line that can be gone to: what its label stands for, and the rest of a repeat's count (-1:
    begins anew)."""

    kind: str
    file: File
    at: int
    count: int = -1

    def is_at(self, other: Place) -> bool:
        """Whether both are the same line."""
        return self.at == other.at and self.file is other.file


@dataclass
class Call:
    """A sub that runs. back: where to go on; numbers: #1 to #30 as they were, None: called by M98,
    which keeps them."""

    name: str
    back: Place
    numbers: list[float] | None

    @property
    def fanuc(self) -> bool:
        return self.numbers is None


class Flow:
    """Where a program is: the line that is read next, what is skipped, the calls that run."""

    def __init__(self, program: Program, memory: Memory, depth: int):
        self.program, self.memory, self.depth = program, memory, depth
        self.file = self.main = File("", program)
        self.files: dict[str, File | None] = {}
        self.at = 0  # the line that is read next
        self.labels: dict[str, Place] = {}
        self.calls: list[Call] = []
        # how often M98 with L runs its program once more, for each level of calls (-1: none runs)
        self.left = [-1]
        self.skip: str | None = None  # the label up to which lines are skipped
        self.seek = False  # it is a sub to call
        # where skipping began, and what to say if it never ends
        self.since: tuple[Place, Refusal] | None = None
        self.defining = ""  # the sub whose definition is skipped
        self.was_true, self.breaking, self.continuing = True, False, False

    @property
    def sub(self) -> str:
        """What runs, for errors."""
        return f"sub o{shown(self.calls[-1].name)}" if self.calls else "the program"

    @property
    def way_back(self) -> str:
        """What ends the sub that runs."""
        return "M99" if self.calls[-1].fanuc else f"o{shown(self.calls[-1].name)} endsub"

    # Whole: one branch to a kind of O word, and to what is skipped.
    def control(self, control: Control, place: Place) -> None:
        """Execute an O-word, M98 or M99. Raises Refusal."""
        kind = control.kind
        if kind in ("m98", "m99"):
            if self.skip is None:
                self._call_fanuc(control, place) if kind == "m98" else self._return(control, "")
            return
        label = control.label(self.memory)
        name = (
            label
            if kind in GLOBAL
            else f"{self.calls[-1].name if self.calls else self.defining}#{label}"
        )
        if kind in ("sub", "") and self.defining:
            raise Refusal(
                f"o{shown(label)} begins within the definition of sub o{shown(self.defining)}",
                "end that one before",
            )
        if self.skip is not None and (name != self.skip or (self.seek and kind not in ("sub", ""))):
            return
        if self.defining and kind not in ("endsub", "return"):
            return
        if kind in ("sub", ""):
            self._sub_begins(control, name, place)
        elif kind in ("endsub", "return"):
            self._return(control, name)
        elif kind == "call":
            self._call(control, label, place)
        elif kind in ("if", "elseif", "else", "endif"):
            self._branch(control, name, place)
        else:
            self._loop(control, name, place)

    def _test(self, control: Control) -> bool:
        return control.values()[0](self.memory) != 0

    def _skip_to(self, name: str, place: Place, opened: str) -> None:
        """Skip lines up to the one with this label that closes what `opened` names."""
        label = shown(name.rpartition("#")[2])
        message = f"o{label} {opened} has no o{label} {CLOSED_BY[opened]} behind this line"
        self.skip, self.since = name, (place, Refusal(message, "write it at its end"))

    def _opened(self, name: str, control: Control, kinds: tuple[str, ...]) -> Place:
        """The place where a label's block begins."""
        place, label = self.labels.get(name), shown(name.rpartition("#")[2])
        if place is None or place.kind not in kinds:
            what = (
                "is not open"
                if place is None
                else f"belongs to the {place.kind} of line {place.at + 1}"
            )
            raise Refusal(
                f"{control.kind}: o{label} {what}",
                f"it goes with o{label} {' or '.join(kinds)} in the same sub, before it",
            )
        return place

    def _mark(self, name: str, place: Place) -> Place:
        """Remember where a label's block begins."""
        known = self.labels.setdefault(name, place)
        if not known.is_at(place):
            label = shown(name.rpartition("#")[2])
            raise Refusal(
                f"o{label} is used already, in line {known.at + 1}",
                "give each block a label of its own",
            )
        return known

    def _branch(self, control: Control, name: str, place: Place) -> None:
        """if, elseif, else, endif."""
        #   o1 if [..]        true: on, and was_true; else skip to the next line with o1
        #   o1 elseif [..]    behind a branch that was taken: skip on; else asked like the if
        #   o1 else           taken where none was
        #   o1 endif          nothing is skipped any more
        if control.kind == "if":
            self._mark(name, place)
            self.was_true = self._test(control)
            self.skip = None
            if not self.was_true:
                self._skip_to(name, place, "if")
            return
        self._opened(name, control, ("if",))
        if control.kind == "endif":
            control.values()
            self.skip, self.was_true = None, True
        elif self.was_true:
            self._skip_to(name, place, "if")
        elif control.kind == "else" or self._test(control):
            control.values()
            self.skip, self.was_true = None, True

    def _loop(self, control: Control, name: str, place: Place) -> None:
        """do, while, endwhile, repeat, endrepeat, break, continue."""
        kind = control.kind
        known = self.labels.get(name)
        # o1 while is the end of a loop where an o1 do stands before, else the begin of one
        if kind == "while" and known and known.kind == "do":
            self.skip = None
            if self._test(control) and not self.breaking:
                self._go(known)
            else:
                self.breaking = False
        elif kind in ("do", "while", "repeat"):
            self.skip = None
            self._begin(control, name, self._mark(name, place))
        elif kind in ("break", "continue"):
            opened = self._opened(name, control, ("while", "do"))
            control.values()
            if kind == "break":
                self.breaking = True  # even where the loop is skipped: LinuxCNC does so
            elif self.skip is None:
                self.continuing = True
            if self.skip is None:
                self._skip_to(name, place, opened.kind)
        else:
            opened = self._opened(name, control, (kind.removeprefix("end"),))
            control.values()
            repeats = self.skip is None or self.continuing
            self.continuing = self.continuing and self.skip is None
            self.skip = None
            if repeats:
                self._go(opened)

    def _begin(self, control: Control, name: str, place: Place) -> None:
        """The line of do, while or repeat, reached from above or from the end of its loop."""
        if control.kind == "do":
            control.values()
        elif control.kind == "while":
            if not self._test(control):
                self._skip_to(name, place, "while")
        else:
            if place.count == -1:
                value = control.values()[0](self.memory)
                if not abs(value) < MOST_REPEATS:
                    raise Refusal(f"a repeat count of {value:.10g}", CORRECT)
                place.count = round(value)  # the even one of two whole numbers equally near
            if place.count > 0:
                place.count -= 1
            else:
                place.count = -1
                self._skip_to(name, place, "repeat")

    # -- subs --------------------------------------------------------------------------------------

    def _sub_begins(self, control: Control, name: str, place: Place) -> None:
        """sub, or an O number alone: called, sought or defined."""
        control.values()
        fanuc = not control.kind
        if self.calls and self.calls[-1].fanuc != fanuc:
            what, way = (
                ("a Fanuc-style program", f"M98 P{name}")
                if fanuc
                else ("a sub", f"o{shown(name)} call")
            )
            raise Refusal(f"o{shown(name)} is {what}", f"call it with {way}")
        if self.skip is not None or not (self.calls or fanuc):
            self._define(name, place)
        self.skip, self.seek = None, False
        if fanuc:
            return
        if not self.calls:
            self.defining = name
            self._skip_to(name, place, "sub")
        elif (known := self.labels.get(base(self.calls[-1].name))) is None or not known.is_at(
            place
        ):
            raise Refusal(
                f"sub o{shown(name)} begins within {self.sub}",
                f"{self.way_back} ends that one before",
            )

    def _define(self, name: str, place: Place) -> None:
        known = self.labels.get(name)
        if known:
            raise Refusal(
                f"sub o{shown(name)} is met again: it was read or called before, line"
                f" {known.at + 1}",
                "each sub has its own name; one that is called before its definition stands"
                " behind M2",
            )
        self.labels[name] = place

    def _call(self, control: Control, name: str, place: Place) -> None:
        values = [value(self.memory) for value in control.values()]
        self._enter(name, place, Place("", self.file, self.at), values)

    def _call_fanuc(self, control: Control, place: Place) -> None:
        """M98 P L: LinuxCNC comes back to the line itself until it has run L times."""
        nodes = control.values()
        name, back = str(whole(nodes[0](self.memory), "P")), Place("", self.file, self.at)
        if len(nodes) > 1:
            # -1: the line is met for the first time; behind the last run it is -1 again
            left = self.left[-1]
            if left == -1:
                left = whole(nodes[1](self.memory), "L")
                if left < 0:
                    raise Refusal(
                        f"L is {left}", "it says how often the program runs: 0, 1, 2 and on"
                    )
            self.left[-1] = left - 1 if left > 1 else -1
            if left > 1:
                back = place
            elif left == 0:
                return
        self._enter(name, place, back, None)

    def _enter(self, name: str, place: Place, back: Place, values: list[float] | None) -> None:
        """Begin a call: a sub that is known, in a file of its name, or further down."""
        if len(self.calls) >= self.depth:
            raise Refusal(
                f"calls nest deeper than {self.depth}",
                "does a sub call itself? LinuxCNC goes 9 deep, or raise the limit",
            )
        self.calls.append(Call(name, back, self.memory.enter(values)))
        self.left.append(-1)
        short = base(name)
        known = self.labels.get(short)
        if known:
            self._go(known)
            return
        file = self._load(name)
        where = f"further down, and no file {short}.ngc"
        if file:
            self.file, self.at, where = file, 0, f"in {file.name}"
        what = "program O" + short if values is None else f"sub o{shown(short)}"
        advice = (
            "define it before its call or behind M2, or have its file where gcomp looks (--library)"
        )
        # not read yet: lines are passed over up to its o-word, in its file or further down this one
        self.skip = short
        self.seek = True
        self.since = (place, Refusal(f"there is no {what} {where}", advice))

    def _load(self, name: str) -> File | None:
        if name not in self.files:
            text = self.program.library(name)
            if text is None and base(name) != name:
                text = self.program.library(base(name))
            self.files[name] = None if text is None else File(f"{name}.ngc", Program(name, text))
        return self.files[name]

    def _go(self, place: Place) -> None:
        self.file, self.at = place.file, place.at

    def _return(self, control: Control, name: str) -> None:
        """endsub, return, M99."""
        kind = control.kind
        if not self.calls:
            if kind == "m99":
                raise Refusal(
                    "M99 in the main program: it begins again without end", "M2 or M30 ends it"
                )
            if not self.defining:
                raise Refusal(
                    f"{kind} outside of any sub", f"it goes with o{shown(name)} sub before it"
                )
            self.memory.give_back(control.values(), defining=True)
            if kind == "endsub":
                self.skip, self.defining = None, ""
            return
        if self.calls[-1].fanuc != (kind == "m99"):
            raise Refusal(
                f"{kind} within {self.sub}, which was called in the other way",
                f"{self.way_back} ends it",
            )
        self.memory.give_back(control.values())
        call = self.calls.pop()
        self.left.pop()
        self.memory.leave(call.numbers)
        self._go(call.back)


def base(name: str) -> str:
    """A sub's name without the folder of its file."""
    return name.rpartition("/")[2]


def shown(label: str) -> str:
    """A label as it is written behind O."""
    return label if label.isdigit() else f"<{label}>"
