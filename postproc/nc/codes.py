"""What a row of a dialect's table of codes says: modal group, what it takes, what it does, whether
it can be followed.

Groups and numbers follow NIST RS274/NGC (NISTIR 6556, table 4) and Fanuc B-64304EN (G-code system
B). A code with `refuses` is known but can not be followed: it is passed where no correction depends
on it (a map without errors) and refused, with this sentence, where one does. Rows that several
dialects share are in postproc.nc.rows.
"""

from __future__ import annotations

from functools import cache

from postproc.records import record


@record
class Code:
    """A row: `word` as written ("G1"), modal `group` ("" for one that acts in its own block only),
    the axis words it `takes` away from the motion (True for G10 G28 G92 ...), what it means, and
    why it can not be followed.

    `does`: what it does beyond naming a mode, as a key that the interpreter knows (DOES), "" for
    nothing. `like`: the G code of another control that it is (G70 of Siemens is like "G20", DIAMON
    like "G7"): then it counts as that one everywhere, and only its spelling differs."""

    word: str
    group: str
    meaning: str
    takes: bool = False
    refuses: str = ""
    does: str = ""
    like: str = ""

    @property
    def number(self) -> int:
        """Ten times the number: G54.1 is 541, so that codes are whole numbers. Keywords count from
        KEYWORD on."""
        return code_number(self.like or self.word)


# codes that are words (TRANS, DIAMON) rather than a letter and a number lie from here on
KEYWORD = 10_000
KEYWORDS: list[str] = []  # every keyword that a dialect has named so far, in that order
# What a code does to the coordinates: G52; G92, which without a word does nothing, or takes itself
# back, or means all axes; G92.1, G92.2, G92.3; G10; G43 H, G43.1, G43.2, G44, G49; G54.1 P; G54
# where a letter chooses the offset; G59 P; TRANS, ATRANS, G58, G59; G43.4, TRAORI, TRAFOOF; G68.2,
# G69, G53.1, CYCLE800, PLANE; G12.1, G13.1.
FRAME_KEYS = (
    "local", "datum shift", "set", "set or off", "set or all", "set zero", "set off", "set back",
    "data", "length", "length by tool", "length or none", "length words", "length more",
    "length minus", "no length", "extended", "fixture", "trans", "atrans", "axis shift",
    "further axis shift", "no frame", "store", "frame", "numbered", "tip", "tip on", "tip off",
    "plane", "plane off", "plane align", "swivel", "spatial", "polar on", "polar off",
)  # fmt: skip
# Cycles that are corrected in place: holes, holes that are tapped; an engraving, of which the place
# and the depth are; threads and single passes, of which only ends are.
CYCLE_KEYS = ("drill", "tap", "there and back", "tap Z", "tap X", "engrave", "thread")
CUTTER_KEYS = ("cutter",)  # the path lies beside the programmed one by the tool's radius
STAY_KEYS = (
    "thread cycle",
    "thread by diameter",
    "tapping cycle",
)  # passes in step with the spindle: they stay as they are, uncorrected (left.py)
SPLINE_KEYS = ("spline",)  # the axis words are a control point of a B-spline
# the axis words are data (limits, a pole): nothing moves, every place stays known
QUIET_KEYS = ("words",)
DOES = (*FRAME_KEYS, *CYCLE_KEYS, *CUTTER_KEYS, *STAY_KEYS, *SPLINE_KEYS, *QUIET_KEYS)


@cache
def code_number(word: str) -> int:
    """The number of a code as it is written: "G54.1" is 541."""
    if word[1:].replace(".", "").isdigit():
        return round(float(word[1:]) * 10)
    if word not in KEYWORDS:
        KEYWORDS.append(word)
    return KEYWORD + KEYWORDS.index(word)


# Sentences of refusal: what is wrong, a colon, the way out.
EXPAND = "--expand writes it out as plain blocks"
# before a way out that a person must choose: nothing is written out by itself then
IF_IT_IS = "if it is"
CYCLE = f"its motions are worked out by the control: {EXPAND}"
THREADING = (
    "it goes in step with the spindle and stays as it is: let the CAM program write its passes as"
    " G32 or G33"
)
FRAME = f"it turns, mirrors, scales or bends the coordinates: {EXPAND}"
SPLINE = "corrected points do not lie on such a curve: --expand writes it out as straight lines"
CALL = f"the same text runs at several places: {EXPAND}"
LENGTH = "tool lengths come with the T word here: program with G49"
CUTTER = (
    "it leads the tool beside the words by a radius: let the CAM program write the tool centre path"
)
WRITE_OUT = (
    "its motions are the control's own: let the CAM program write it out as G0, G1, G2 and G3"
)
PROBE = "where it ends is known at the machine alone: keep measuring in a program of its own"
CURVE = "corrected points do not lie on such a curve: let the CAM program write lines and arcs"
TRANSFORM = (
    "the control makes other motions of the words: let the CAM program write the motions of the"
    " axes themselves"
)
TILTED = (
    "the words are coordinates of a tilted plane: let the CAM program write coordinates of the"
    " machine's own axes"
)
TOOL_POINT = (
    "the control moves the slides about the tool tip: let the CAM program write the places of the"
    " axes themselves"
)
DIRECTION = "its I J K are the tool's direction: --expand writes the rotary axes, under G43.4"
ITSELF = "the control moves an axis by itself: write its motion out, or take it out"
CORNER = "it changes the contour before it: write the corner out"
# The same where nothing writes it out.
INLINE = "the same text runs at several places: write it out in line"
UNTURNED = "it turns, scales or mirrors the coordinates: let the CAM program write them as they are"
RESTORED = "modes come back from where they were kept: write the codes out"
BROUGHT_BACK = "modes come back from where they were kept: --expand writes the codes out"

END_OF_PROGRAM = (2, 30)  # M codes after which the control reads no further
CALLS = {
    97: "local subprogram",
    98: "subprogram call",
    99: "end of subprogram, or again from the top",
}
SPINDLE_AND_COOLANT = {
    0: "stop", 1: "optional stop", 2: "end of program", 3: "spindle clockwise",
    4: "spindle counter-clockwise", 5: "spindle stop", 6: "tool change", 7: "mist coolant",
    8: "coolant", 9: "coolant off", 19: "orient the spindle", 30: "end of program, rewind",
    48: "overrides on", 49: "overrides off", 60: "pallet change and stop",
}  # fmt: skip
TURNED = ("spindle clockwise", "spindle counter-clockwise")
WITH_COOLANT = {13: 3, 14: 4}  # M13 as M3, M14 as M4, where a control has them so


def spindle_codes(m_codes: dict[int, str]) -> dict[int, int]:
    """Of the M numbers of a control those that turn the spindle or stop it: as M3, M4 or M5."""
    also = (n for n in WITH_COOLANT if m_codes.get(n, "").startswith(TURNED))
    return {3: 3, 4: 4, 5: 5, **{n: WITH_COOLANT[n] for n in also}}


# M codes that a control executes when the block's motion is done
AFTER_MOTION = (0, 1, 2, 30, 60, 5, 9)
