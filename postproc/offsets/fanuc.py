"""Fanuc's offsets as the control punches them: a program of G10 blocks. Haas and others take the
same blocks.

    G10 L2 P0 X.. Z..       the external offset, common to all: "EXT"        G10 L2 P1 to P6     G54
                            to G59
    G10 L20 P1 X..          additional work offset: "G54.1 P1"
    G10 L10 P1 R..          length geometry of H1, L11 (or L1) its wear, L12 radius geometry of D1,
                            L13 its wear
    G10 P1 X.. Z.. R.. Q..  lathe: wear of offset 1, P10001 its geometry; U V W C are increments of
                            X Y Z R

Geometry and wear are added. Memories A and B of a mill have no L12 and L13: H1 and D1 are then the
same register. A lathe offset is chosen by the last digits of T; it is called as where tool and
offset have the same number, "T0101".

X of a lathe: tool offsets are diameters unless parameter 5004#1 (ORC) is 1, work offsets are as the
axis is (1006#3, DIA). Nothing in the file tells that. Unless the user says it, X is a diameter in
files with lathe offsets and a radius in all others. R of L12 and L13 is taken as a radius (5004#2,
ODI; Haas setting 40 may say diameter). The tables of work and tool offsets that some controls print
are not read, for want of a source.

Sources: Fanuc 16i/18i-TB operator's manual B-63524EN 14.5.2 (G10 P_ X_ Z_ R_ Q_), 16i/18i-PA
B-63124EN 15.3 (L11, L1), 16/18-TC operator's manual B-62754EN 9.4 (DIA, ORC); Haas and Mitsubishi
M700V manuals, 12.7 (L2, L10 to L13, L20).
"""

from __future__ import annotations

import re
from collections.abc import Container
from dataclasses import dataclass, field

from postproc.offsets import AXES, ROTARY, Offsets, Source
from postproc.units import MM_PER_INCH

TITLE = "G10 program of Fanuc, Haas and others"
LOOK = re.compile(r"(?<![A-Z0-9.])G10(?![0-9.])")
COMMENT = re.compile(r"\([^()]*\)")
WORD = re.compile(r"([A-Z])\s*([-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+))\s*")
LENGTH_WEAR, LENGTH, RADIUS, RADIUS_WEAR = "11", "10", "12", "13"
REGISTERS = {
    "1": LENGTH_WEAR,
    **{code: code for code in (LENGTH, LENGTH_WEAR, RADIUS, RADIUS_WEAR)},
}
WORK = {"2": range(7), "20": range(1, 301)}  # P of work offsets by L
STEPS = {"U": "X", "V": "Y", "W": "Z", "C": "R"}  # of lathe offsets
GEOMETRY = 10_000
Form = tuple[str, str, Container[int]]  # kind of register, letters, numbers
TURNING: Form = (
    "",
    "XYZR" + "".join(STEPS),
    {*range(1, 1000), *range(GEOMETRY + 1, GEOMETRY + 1000)},
)
# the tape's mark, the program's number or name
HEAD = re.compile(r"\s*%?\s*([O:]\s*[0-9]+|<[^<>]*>)?\s*")
LAST = re.compile(r"M0*(2|30|99)\s*")
ADVICE = "give the G10 blocks that the control punched, or state the offsets one by one"
NO_X = "X is read as a {}: it was not stated whether the control stores it as diameter or radius"


@dataclass
class Memory:
    """The registers that a program has set so far: (kind, number) to letter to mm, X as the file
    has it."""

    place: dict[tuple[str, int], dict[str, float]] = field(default_factory=dict)
    incremental: bool = False
    inch: bool | None = None
    bare: bool = False  # whether a length without a decimal point was met
    # number of a lathe tool's orientation, by offset
    nose: dict[int, float] = field(default_factory=dict)

    def write(self, key: tuple[str, int], letter: str, value: float, step: bool) -> bool:
        """Set or change a value; False where a step has nothing to step from."""
        place = self.place.setdefault(key, {})
        if step and letter not in place:
            return False
        place[letter] = place.get(letter, 0.0) * step + value
        return True


def recognises(source: Source) -> bool:
    """Whether a G10 stands somewhere, outside comments."""
    return any(
        LOOK.search(COMMENT.sub(" ", line.upper())) for _, line in source.lines() if "$" not in line
    )


def read(source: Source) -> Offsets:
    """Work offsets, tools "H1", "D1", or "T0101" of a lathe. Raises UsageError for any block that
    is no G10."""
    memory = Memory(inch=source.inch)
    for number, line in source.lines():
        text = HEAD.sub("", COMMENT.sub(" ", line.upper()), count=1)
        for block in text.split(";"):
            _block(source, number, block.strip(), memory)
    return _assembled(source, memory)


def _words(source: Source, number: int, block: str) -> tuple[dict[str, str], list[str]]:
    """Words by letter, and the G codes. Raises UsageError."""
    words: dict[str, str] = {}
    codes: list[str] = []
    end = 0
    while end < len(block):
        word = WORD.match(block, end)
        if not word:
            raise source.fault(
                number, f"{block[end : end + 20]!r} is not a word of a G10 block", ADVICE
            )
        end = word.end()
        if word[1] == "G":
            codes.append(word[2].lstrip("0"))
        elif word[1] in words:
            raise source.fault(number, f"{word[1]} stands twice", ADVICE)
        else:
            words[word[1]] = word[2]
    return words, codes


def _block(source: Source, number: int, block: str, memory: Memory) -> None:
    words, codes = _words(source, number, block)
    words.pop("N", None)
    # modal: what G90 or G91 set before stays where a block says neither
    memory.incremental = "91" in codes or (memory.incremental and "90" not in codes)
    if "20" in codes or "21" in codes:
        memory.inch = "20" in codes
    if "10" in codes:
        _register(source, number, words, memory)
    elif set(codes) - {"90", "91", "20", "21", "11"} or (words and not LAST.fullmatch(block)):
        raise source.fault(number, "this block is no G10: only offsets are read here", ADVICE)


def _register(source: Source, number: int, words: dict[str, str], memory: Memory) -> None:
    """One G10 block into the memory."""
    lathe = "L" not in words
    code, p = words.pop("L", "").lstrip("0"), words.pop("P", "")
    if not re.fullmatch(r"[0-9]{1,6}", p):
        raise source.fault(number, "G10 needs P, the number of the offset", ADVICE)
    n = int(p)
    if lathe:
        _check_lathe(source, number, n, words, memory)
        if n == 0:
            return
    kind, allowed, numbers = TURNING if lathe else _form(source, number, code, words)
    # a P that no control has may be a slip: its offset would be found under no name of a program
    if n not in numbers:
        raise source.fault(
            number, f"there is no offset P{n} of G10{' L' * bool(code)}{code}", ADVICE
        )
    memory.place.setdefault((kind, n), {})
    for letter, text in words.items():
        if letter not in allowed:
            raise source.fault(
                number, f"{letter} does not belong into G10{' L' * bool(code)}{code}", ADVICE
            )
        if not _take(memory, (kind, n), letter, text, source.number(number, text), lathe):
            raise source.fault(
                number, f"{letter}{text} is a step from a value that the file does not have", ADVICE
            )


def _form(source: Source, number: int, code: str, words: dict[str, str]) -> Form:
    """What G10 L takes. Raises UsageError."""
    if code in WORK:
        if set(words) & set("UVW"):
            raise source.fault(
                number, "U V W may be axes, or steps of X Y Z", "state this offset one by one"
            )
        return code, AXES, WORK[code]
    if code not in REGISTERS:
        raise source.fault(number, f"G10 L{code or 0} sets no offset", ADVICE)
    if "R" not in words:
        raise source.fault(number, f"G10 L{code} needs R, the offset's value", ADVICE)
    return REGISTERS[code], "R", range(1, 1000)


def _take(
    memory: Memory, key: tuple[str, int], letter: str, text: str, value: float, lathe: bool
) -> bool:
    """One word into a register; False where a step has nothing to step from."""
    # X1000 may be 1000 mm or 1000 increments (1 mm), by parameter 3401#0 (DPI): the file does not
    # say which, so a notice does.
    memory.bare |= "." not in text and value != 0
    if lathe or letter not in ROTARY:
        value *= MM_PER_INCH if memory.inch else 1.0
    if lathe:
        return memory.write(key, STEPS.get(letter, letter), value, letter in STEPS)
    return memory.write(key, letter, value, memory.incremental)


def _check_lathe(
    source: Source, number: int, n: int, words: dict[str, str], memory: Memory
) -> None:
    """Of a lathe's offset: its orientation Q is taken out, steps beside their own axis refused."""
    if nose := words.pop("Q", ""):
        # P10001 is the geometry of offset 1, P1 its wear: one tool, one orientation
        memory.nose[n % GEOMETRY] = source.number(number, nose)
    for letter in set(words) & set(STEPS):
        if STEPS[letter] in words:
            raise source.fault(
                number, f"{STEPS[letter]} and its step {letter} stand together", ADVICE
            )
    if n == 0 and any(source.number(number, x) for x in words.values()):
        raise source.fault(
            number, "P0 shifts the work coordinates of a lathe", "add it to EXT, and drop the line"
        )


def _assembled(source: Source, memory: Memory) -> Offsets:
    """Geometry and wear added, X halved where it is a diameter, names as programs say them."""
    offsets = Offsets(notices=source.unit_notice() if memory.inch is None else [])
    if memory.bare:
        offsets.notices.append(
            "numbers without a decimal point are read as whole mm or inches, not as least"
            " increments"
        )
    # "": lathe offsets; "2" and "20": work offsets; "10" to "13": length and radius, geometry and
    # wear
    has = {kind for kind, _ in memory.place}
    diameter = _is_diameter(source, memory, "" in has, offsets)
    shared = _is_shared(has, offsets)
    for (kind, n), place in memory.place.items():
        # only lengths along X are diameters: R and the registers of a mill have no X of a lathe
        if diameter and kind in ("", "2", "20") and "X" in place:
            place = {**place, "X": place["X"] / 2}
        if kind in ("2", "20"):
            # L2 P1 is G54, P0 the external offset; L20 P1 is G54.1 P1
            offsets.work[_work_offset(kind, n)] = place
        elif kind == "":
            _add_turning_tool(offsets, n % GEOMETRY, place, memory)
        else:
            _add_milling_tool(offsets, kind, n, place["R"], shared)
    return offsets


def _is_shared(has: set[str], offsets: Offsets) -> bool:
    """Whether H and D of a number are the same register, with a notice where there are any."""
    if has & {RADIUS, RADIUS_WEAR}:
        offsets.notices.append(
            "R of L12 and L13 is read as a radius (on a Fanuc parameter 5004#2 ODI, on a Haas"
            " setting 40)"
        )
        return False
    if has & {LENGTH, LENGTH_WEAR}:
        offsets.notices.append(
            "no L12 or L13: offset memory A or B, where H and D of a number are the same"
        )
    return True


def _work_offset(kind: str, n: int) -> str:
    """As programs say it."""
    if kind == "20":
        return f"G54.1 P{n}"
    return f"G{53 + n}" if n else "EXT"


def _add_turning_tool(
    offsets: Offsets, offset: int, place: dict[str, float], memory: Memory
) -> None:
    """Geometry or wear of a tool, and where its nose points."""
    name = f"T{offset:02d}{offset:02d}"
    _add(offsets.tools, name, place)
    if offset in memory.nose:
        offsets.tools[name]["Q"] = memory.nose[offset]


def _add_milling_tool(offsets: Offsets, kind: str, n: int, value: float, shared: bool) -> None:
    """A length or a radius. shared: one number is both."""
    length = kind in (LENGTH, LENGTH_WEAR)
    if length:
        _add(offsets.tools, f"H{n}", {"Z": value})
    if shared or not length:
        _add(offsets.tools, f"D{n}", {"R": value})


def _is_diameter(source: Source, memory: Memory, lathe: bool, offsets: Offsets) -> bool:
    """Whether X is stored as a diameter; where it is not stated, and it matters, with a notice."""
    if source.diameter is not None:
        return source.diameter
    places = memory.place.values()
    mill = any("Y" in place for place in places) or any(
        kind not in ("", "2", "20") for kind, _ in memory.place
    )
    if any(place.get("X") for place in places) and (lathe or not mill):
        offsets.notices.append(NO_X.format("diameter" if lathe else "radius"))
    return lathe


def _add(tools: dict[str, dict[str, float]], name: str, place: dict[str, float]) -> None:
    tool = tools.setdefault(name, {})
    for letter, value in place.items():
        tool[letter] = tool.get(letter, 0.0) + value
