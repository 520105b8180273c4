"""One row per G and M code: modal group, what it takes, what it means, and whether it can be followed.

Groups and numbers follow NIST RS274/NGC (NISTIR 6556, table 4) and Fanuc B-64304EN (G-code system B). A code with
`refuses` is known but can not be followed: it is passed where no correction depends on it (a map without errors) and
refused, with this sentence, where one does.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Code:
    """A row: `word` as written ("G1"), modal `group` ("" for one that acts in its own block only), the axis words it
    `takes` away from the motion (True for G10 G28 G92 ...), what it means, and why it can not be followed.

    `does`: what it does beyond naming a mode, as a key that the interpreter knows (FRAME_KEYS, CYCLE_KEYS), "" for
    nothing. `like`: the G code of another control that it is (G70 of Siemens is like "G20", DIAMON like "G7"): then it
    counts as that one everywhere, and only its spelling differs."""

    word: str
    group: str
    meaning: str
    takes: bool = False
    refuses: str = ""
    does: str = ""
    like: str = ""

    @property
    def number(self) -> int:
        """Ten times the number: G54.1 is 541, so that codes are whole numbers. Keywords count from KEYWORD on."""
        return code_number(self.like or self.word)


KEYWORD = 10_000  # codes that are words (TRANS, DIAMON) rather than a letter and a number lie from here on
KEYWORDS: list[str] = []  # every keyword that a dialect has named so far, in that order
# What a code does to the coordinates: G52; G92, G92.1, G92.2, G92.3; G10; G43 H, G43.1, G43.2, G44, G49; G54.1 P; TRANS, ATRANS.
FRAME_KEYS = (
    "local", "set", "set zero", "set off", "set back", "data", "length", "length words", "length more", "length minus",
    "no length", "extended", "trans", "atrans", "no frame",
)  # fmt: skip
# Cycles that are corrected in place: holes, holes that are tapped; threads and single passes, of which only ends are.
CYCLE_KEYS = ("drill", "tap", "thread")


def code_number(word: str) -> int:
    """The number of a code as it is written: "G54.1" is 541."""
    if word[1:].replace(".", "").isdigit():
        return round(float(word[1:]) * 10)
    if word not in KEYWORDS:
        KEYWORDS.append(word)
    return KEYWORD + KEYWORDS.index(word)


def _rows(letter: str, group: str, table: dict[str, str], takes: bool = False, refuses: str = "") -> list[Code]:
    return [Code(letter + number, group, meaning, takes, refuses) for number, meaning in table.items()]


CYCLE = "canned cycles are not compensated yet: let the CAM program write them out as G0 and G1"
CUTTER = "cutter radius compensation is not followed yet: let the CAM program write the tool centre path (G40)"
FRAME = "this shift of the coordinates is not followed yet: program in G54-G59 with --offset, or without it"
LENGTH = "tool lengths are not followed yet: program from the spindle nose with G49"

MOTION = _rows(
    "G", "motion", {"0": "rapid", "1": "straight feed", "2": "arc, clockwise", "3": "arc, counter-clockwise"}
)
PLANE = _rows("G", "plane", {"17": "XY plane", "18": "ZX plane", "19": "YZ plane"})
DISTANCE = _rows("G", "distance", {"90": "absolute words", "91": "incremental words"})
UNITS = _rows("G", "units", {"20": "inch", "21": "millimetre"})
FEED_MODE = _rows("G", "feed mode", {"93": "feed as inverse time", "94": "feed per minute", "95": "feed per turn"})
WORK = _rows("G", "work offset", {str(n): f"work offset {n - 53}" for n in range(54, 60)})
SPINDLE = _rows("G", "spindle mode", {"96": "constant surface speed", "97": "constant spindle speed"})
CUTTER_ROWS = _rows("G", "cutter", {"40": "no cutter radius compensation"}) + _rows(
    "G", "cutter", {"41": "cutter radius left", "42": "cutter radius right"}, refuses=CUTTER
)
LENGTH_ROWS = _rows("G", "tool length", {"49": "no tool length"}) + _rows(
    "G", "tool length", {"43": "tool length"}, refuses=LENGTH
)
REFERENCE = _rows("G", "", {"28": "to the reference point", "30": "to the second reference point"}, takes=True)
MACHINE_FRAME = [Code("G53", "", "this block in machine coordinates")]
DWELL = [Code("G4", "", "dwell")]
COMMON = [
    *MOTION, *PLANE, *DISTANCE, *UNITS, *WORK, *SPINDLE, *CUTTER_ROWS, *LENGTH_ROWS, *REFERENCE, *MACHINE_FRAME, *DWELL,
]  # fmt: skip

END_OF_PROGRAM = (2, 30)  # M codes after which the control reads no further
CALLS = {97: "local subprogram", 98: "subprogram call", 99: "end of subprogram, or again from the top"}
CALL = "the same text would run at several places: write the subprogram out in line"
SPINDLE_AND_COOLANT = {
    0: "stop", 1: "optional stop", 2: "end of program", 3: "spindle clockwise", 4: "spindle counter-clockwise",
    5: "spindle stop", 6: "tool change", 7: "mist coolant", 8: "coolant", 9: "coolant off", 19: "orient the spindle",
    30: "end of program, rewind", 48: "overrides on", 49: "overrides off", 60: "pallet change and stop",
}  # fmt: skip
AFTER_MOTION = (0, 1, 2, 30, 60, 5, 9)  # M codes that a control executes when the block's motion is done
