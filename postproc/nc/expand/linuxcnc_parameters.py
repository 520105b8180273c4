"""RS274/NGC parameters: numbered and named ones, and those by which LinuxCNC tells where and how it
stands.

What only the machine knows while it runs (probe results, inputs, HAL pins, INI values) is refused,
never guessed. Lengths that are kept between programs (#5161, #5211, #5221, #5401 and on) are
millimetres, whatever G20 says, as on a machine that counts in millimetres; where the machine stands
(#5420 and on, #<_x>) is in the program's unit, X always a radius.

Sources: LinuxCNC documentation, "G-code overview", sections "Numbered parameters", "Subroutine
parameters", "Named parameters", "Predefined named parameters", "System parameters"; values measured
on LinuxCNC 2.9 (tests/expand/test_linuxcnc.py).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Container
from functools import partial

from postproc.errors import BlockFault, GcompError
from postproc.nc.expand import Refusal
from postproc.nc.expand.linuxcnc_expressions import Node
from postproc.nc.expand.tracker import Tracker
from postproc.nc.frames import WORK_OF_P
from postproc.nc.state import Frame, no_frame
from postproc.units import MM_PER_INCH, TICKS_PER_MM

LAST = 5601  # the largest parameter number
LOCAL = range(1, 31)  # parameters that every call has its own of
AXES = "XYZABCUVW"  # in the order of the parameters
#   1..30      of each call             5211..   G92 and G52, by axis
#   5061..     found by a probe         5220     number of the work offset in force
#   5161..     G28.1, by axis           5221..   G54 by axis, R at 5230; 5241.. G55, 20 apart
#   5181..     G30.1, by axis           5400..   tool, its offsets; 5420.. where it stands
PROBE, FIRST_REFERENCE, SECOND_REFERENCE = range(5061, 5071), range(5161, 5170), range(5181, 5190)
PRESET = range(5210, 5220)
WORK = range(5220, 5391)
INPUT = 5399
TOOL = range(5400, 5410)
TOOL_SHAPE = range(5410, 5414)
POSITION, DEBUG, CHANGER = range(5420, 5429), 5599, range(5600, 5602)
OWN = ("_value", "_value_returned", "_line", "_call_level")  # what the run itself knows
SAY = "say it with --start or --offset, or write the value itself in its place"
WRITE_VALUE = (
    "write the value itself in its place: gcomp knows the program, not what the machine finds while"
    " it runs"
)


class Memory:
    """All parameters of a run. `locals` has a dictionary per call, the program's own first, which
    also holds the names that begin with an underscore; value and value_returned: what the last
    subprogram gave back; line: that of the program.
    noticed: kinds of codes after which the tracker no longer tells what LinuxCNC would."""

    def __init__(self, tracker: Tracker):
        self.tracker = tracker
        self.numbers: dict[int, float] = {}
        self.locals: list[dict[str, float]] = [{}]
        self.value, self.value_returned, self.line = 0.0, 0.0, 0
        self.defining = False
        self.noticed: set[str] = set()
        self._decimals: dict[str, int] = {}

    def notice(self, g: list[float], m: list[float], letters: str) -> None:
        """A block was executed: its G and M numbers, and the letters of its words."""
        if not (g or m):
            return
        codes = {round(10 * value) for value in g}
        self.noticed |= {kind for kind, numbers in NOTICED.items() if codes & numbers}
        if 100 in codes and "r" in letters:
            self.noticed.add("turned")
        if 61 in map(round, m):
            self.noticed.add("tool")
        if codes & {200, 210} or 72 in map(round, m):
            self._decimals.clear()

    def decimals(self, letter: str) -> int:
        """How many decimals a number behind this letter is written with; the tracker is asked once
        per unit."""
        if letter not in self._decimals:
            self._decimals[letter] = self.tracker.decimals(letter)
        return self._decimals[letter]

    # -- reading

    def number(self, index: int) -> float:
        """#index. Raises Refusal where it is none, or unknown."""
        if 1 <= index < PROBE.start:
            return self.numbers.get(index, 0.0)
        _check(index)
        read = next((read for numbers, read in NUMBERED if index in numbers), None)
        if read is not None:
            self._check_stale(index, f"#{index}")
            return self._asked(partial(read, index=index), f"#{index}")
        return self.numbers.get(index, 1.0 if index == DEBUG else 0.0)

    def named(self, name: str) -> float:
        """#<name>, in small letters without blanks. Raises Refusal where it has no value, or nobody
        knows it."""
        names = self._names(name)
        if name in names:
            return names[name]
        own = {
            "_value": self.value,
            "_value_returned": self.value_returned,
            "_line": float(self.line),
            "_call_level": len(self.locals) - 1.0,
        }.get(name)
        if own is not None:
            if math.isnan(own):
                raise Refusal(
                    f"#<{name}> is not known: no sub has run since the last definition",
                    "call one before",
                )
            return own
        if name in PREDEFINED:
            self._check_stale(name, f"#<{name}>")
            return self._asked(PREDEFINED[name], f"#<{name}>")
        if name in UNKNOWN or name.startswith(("_hal[", "_ini[")):
            raise Refusal(f"#<{name}> is known to the machine only", WRITE_VALUE)
        if self.defining:
            return 0.0
        raise Refusal(
            f"#<{name}> has no value yet",
            "give it one before this line; a name without _ is known in its own sub only",
        )

    def exists(self, parameter: int | str) -> bool:
        """What EXISTS tells. Raises Refusal where only the machine knows."""
        if isinstance(parameter, int):
            return 1 <= parameter <= LAST
        if parameter.startswith(("_hal[", "_ini[")):
            raise Refusal(f"#<{parameter}> is known to the machine only", WRITE_VALUE)
        return parameter in self._names(parameter) or _is_predefined(parameter)

    def _names(self, name: str) -> dict[str, float]:
        return self.locals[0 if name.startswith("_") else -1]

    def _check_stale(self, parameter: int | str, what: str) -> None:
        for kind, parameters, reason in STALE:
            if kind in self.noticed and parameter in parameters:
                raise Refusal(f"{what} is not known, because {reason}", WRITE_VALUE)

    def _asked(self, read: Callable[[Tracker], float | None], what: str) -> float:
        """What the tracker tells. Raises Refusal where it does not know."""
        try:
            value = read(self.tracker)
        except (BlockFault, GcompError) as e:
            raise Refusal(
                f"{what} is not known, because of a line before: {e.message}", e.advice
            ) from None
        if value is None:
            raise Refusal(
                f"{what} is not known: nothing in the program before this line says it",
                OTHERWISE.get(what, SAY),
            )
        return value

    # -- writing

    def declare(self, name: str) -> None:
        """A line gives #<name> a value; until it is read to its end, a new name is worth 0. Raises
        Refusal."""
        if _is_predefined(name) or name.startswith(("_hal[", "_ini[")):
            raise Refusal(f"#<{name}> can be read only", "use another name")
        self._names(name).setdefault(name, 0.0)

    def set_named(self, name: str, value: float) -> None:
        """#<name>=value; it has been declared."""
        self._names(name)[name] = value

    def check_writable(self, index: int) -> None:
        """Raises Refusal for a number that a program can not write, or whose effect plain lines can
        not have."""
        _check(index)
        for numbers, advice in NOT_WRITTEN:
            if index in numbers:
                raise Refusal(f"#{index} belongs to the control", advice)

    def give_back(self, values: list[Node], defining: bool = False) -> None:
        """endsub or return is read, perhaps with a value; LinuxCNC reads it in a definition too:
        unset names are 0 then."""
        self.defining = defining
        try:
            # o1 endsub [5] gives 5 to #<_value>
            self.value = values[0](self) if values else 0.0
        except Refusal:
            if not defining:
                raise
            self.value = math.nan
        finally:
            self.defining = False
        self.value_returned = float(bool(values))

    def enter(self, values: list[float] | None) -> list[float] | None:
        """A call begins, with names of its own, and values for #1 to #30 unless None; gives what
        these were."""
        self.locals.append({})
        if values is None:
            return None
        # all 30 are set, those that are not handed over to 0
        kept = [self.numbers.get(i, 0.0) for i in LOCAL]
        self.numbers.update(zip(LOCAL, [*values, *[0.0] * (len(LOCAL) - len(values))], strict=True))
        return kept

    def leave(self, kept: list[float] | None) -> None:
        """A call ends; kept: #1 to #30 as they were, None: they stay as they are."""
        if kept is not None:
            self.numbers.update(zip(LOCAL, kept, strict=True))
        self.locals.pop()


def _check(index: int) -> None:
    if not 1 <= index <= LAST:
        raise Refusal(f"there is no parameter #{index}", f"their numbers are 1 to {LAST}")


def _is_predefined(name: str) -> bool:
    return name in PREDEFINED or name in UNKNOWN or name in OWN


# -- what the control tells of itself --------------------------------------------------------------


def _frame(tracker: Tracker) -> Frame:
    frame = tracker.state.frame
    return no_frame(len(tracker.setup.axes)) if frame is None else frame


def _work(tracker: Tracker, axis: str) -> float | None:
    """Where the axis stands, program coordinates and unit, radius."""
    if axis not in tracker.setup.axes:
        return 0.0
    if tracker.code("cutter") in (410, 411, 420, 421):
        raise Refusal(
            "the position is read while cutter radius compensation is on",
            "LinuxCNC refuses this: G40 first",
        )
    value = tracker.work(axis)
    return value / 2 if value is not None and tracker.is_diameter(axis) else value


def _machine(tracker: Tracker, axis: str) -> float | None:
    """Where the axis stands, machine coordinates, the program's unit, radius."""
    if axis not in tracker.setup.axes:
        return 0.0
    value = tracker.machine(axis)
    return (
        value / MM_PER_INCH if value is not None and tracker.inch and axis not in "ABC" else value
    )


def _preset(tracker: Tracker, index: int) -> float | None:
    """#5211 on: what G92 and G52 have set, mm."""
    frame, axis = _frame(tracker), AXES[index - 5211]
    if index == 5210 or any(part.startswith("preset") for part in frame.unknown):
        return None
    return (
        float(frame.preset[tracker.setup.axes.index(axis)] / TICKS_PER_MM)
        if axis in tracker.setup.axes
        else 0.0
    )


def _work_offset(tracker: Tracker, index: int) -> float | None:
    """#5220: the work offset in force, 1 is G54; #5221 on: nine axes and the angle of each, mm and
    degrees."""
    number, place = divmod(index - 5220, 20)
    if index == 5220:
        word = tracker.dialect.by_number.get(tracker.code("work offset"))
        return float(WORK_OF_P.index(word.word)) if word else None
    if not 1 <= place <= 10:
        return 0.0
    if any(part.startswith("data") for part in _frame(tracker).unknown):
        return None
    return tracker.offset(WORK_OF_P[number + 1], f"{AXES}R"[place - 1])


def _tool(tracker: Tracker, index: int) -> float | None:
    """#5400: the tool in the spindle; #5401 on: its offsets in the tool table, mm."""
    # -1: not said; 0: none, whose offsets are 0
    tool = tracker.state.tool_number
    if tool < 0 or index == 5400 or tool == 0:
        return None if tool < 0 else float(tool)
    axis = AXES[index - 5401]
    offset = tracker.offset(f"H{tool}", axis)
    return tracker.offset(f"T{tool}", axis) if offset is None else offset


def _feed(tracker: Tracker) -> float | None:
    """F, which has another number after G20 or G21 and in G93."""
    if tracker.inch or tracker.code("feed mode") != 940:
        return None
    return 0.0 if math.isnan(tracker.state.feed) else tracker.state.feed


def _unknown(tracker: Tracker, index: int) -> float | None:
    raise Refusal(f"#{index} is known to the machine only", WRITE_VALUE)


def _code(group: str, start: int) -> Callable[[Tracker], float]:
    """Ten times the G number in force; start: the one in force before any."""
    return lambda tracker: float(code if (code := tracker.code(group)) >= 0 else start)


def _is(group: str, number: int, start: int) -> Callable[[Tracker], float]:
    code = _code(group, start)
    return lambda tracker: float(code(tracker) == number)


def _tool_number(number: int) -> float | None:
    return float(number) if number >= 0 else None


NUMBERED: tuple[tuple[range, Callable[..., float | None]], ...] = (
    (POSITION, lambda tracker, index: _work(tracker, AXES[index - 5420])),
    (WORK, _work_offset),
    (PRESET, _preset),
    (TOOL, _tool),
    (FIRST_REFERENCE, lambda tracker, index: tracker.offset("G28", AXES[index - 5161])),
    (SECOND_REFERENCE, lambda tracker, index: tracker.offset("G30", AXES[index - 5181])),
    (PROBE, _unknown),
    (TOOL_SHAPE, _unknown),
    (range(INPUT, INPUT + 1), _unknown),
    (CHANGER, _unknown),
)
NOT_WRITTEN = (
    (POSITION, "it can be read only"),
    (TOOL, "it can be read only"),
    (TOOL_SHAPE, "it can be read only"),
    (WORK, "G10 L2 P1 X.. sets the work offset G54 in a plain line, and G54 to G59.3 choose one"),
    (PRESET, "G92 X.. or G52 X.. set it in a plain line"),
    (FIRST_REFERENCE, "G28.1 sets it in a plain line"),
    (SECOND_REFERENCE, "G30.1 sets it in a plain line"),
    (PROBE, "a probing motion sets it: use another number"),
    (range(INPUT, INPUT + 1), "M66 sets it: use another number"),
    (CHANGER, "the tool changer sets it: use another number"),
)
PREDEFINED: dict[str, Callable[[Tracker], float | None]] = {
    "_motion_mode": _code("motion", 800),
    "_plane": _code("plane", 170),
    "_ccomp": (
        lambda tracker: {-1: 400.0, 411: 410.0, 421: 420.0}.get(
            code := tracker.code("cutter"), float(code)
        )
    ),
    "_metric": _is("units", 210, 210),
    "_imperial": _is("units", 200, 210),
    "_absolute": _is("distance", 900, 900),
    "_incremental": _is("distance", 910, 900),
    "_inverse_time": _is("feed mode", 930, 940),
    "_units_per_minute": _is("feed mode", 940, 940),
    "_units_per_rev": _is("feed mode", 950, 940),
    "_coord_system": lambda tracker: (
        float(code) if (code := tracker.code("work offset")) >= 0 else None
    ),
    "_tool_offset": lambda tracker: (
        None if "length" in (f := _frame(tracker)).unknown else float(f.length.any())
    ),
    "_retract_r_plane": _is("return", 990, 990),
    "_retract_old_z": _is("return", 980, 990),
    "_spindle_rpm_mode": _is("spindle mode", 970, 970),
    "_spindle_css_mode": _is("spindle mode", 960, 970),
    "_ijk_absolute_mode": _is("arc centre", 901, 911),
    "_lathe_diameter_mode": lambda tracker: float(tracker.is_diameter("X")),
    "_lathe_radius_mode": lambda tracker: float(not tracker.is_diameter("X")),
    "_feed": _feed,
    "_current_tool": lambda tracker: _tool_number(tracker.state.tool_number),
    "_selected_tool": lambda tracker: _tool_number(tracker.state.next_tool),
    "_remap_level": lambda tracker: 0.0,
    "_task": lambda tracker: 1.0,
    **{f"_{x.lower()}": partial(_work, axis=x) for x in AXES},
    **{f"_abs_{x.lower()}": partial(_machine, axis=x) for x in AXES},
}
SAY_TOOL = "say which tool is in the spindle before the program, 0 for none: --start T1"
OTHERWISE = {  # the way out where neither a place nor an offset says it
    **dict.fromkeys(("#<_current_tool>", "#5400"), SAY_TOOL),
    "#<_selected_tool>": "write T and its number before it",
}
NOTICED = {"cycle": {730, 740, 760, *range(810, 900, 10)}, "G28": {281}, "G30": {301}}
STALE: tuple[tuple[str, Container[int | str], str], ...] = (
    ("turned", (5420, 5421, *range(5230, 5391, 20), "_x", "_y"), "G10 R has turned coordinates"),
    ("tool", (*TOOL, "_current_tool", "_selected_tool"), "M61 has changed the tool"),
    ("cycle", ("_motion_mode",), "cycles are written out"),
    ("G28", FIRST_REFERENCE, "G28.1 has changed it"),
    ("G30", SECOND_REFERENCE, "G30.1 has changed it"),
)
_UNKNOWN = """
    _vmajor _vminor _rpm _spindle_on _spindle_cw _mist _flood _speed_override _feed_override
    _adaptive_feed _feed_hold _selected_pocket _current_pocket
"""
UNKNOWN = frozenset(_UNKNOWN.split())  # known to the machine only
