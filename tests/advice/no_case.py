"""Sentences that no case provokes, and why. What has no way out is said so here."""

ADVICE = (
    "the way out of other sentences, which are made in several steps: the page shows it by itself"
)
MACHINE = "the machine's folder is at fault, not the program: tests/test_refusals.py edits one"
NO_DIALECT = "no control here has both such words and such a cycle that is corrected in place"
ELSEWHERE = "provoked in tests/expand; what follows from its advice is not tried yet"

NO_CASE: dict[str, str] = {
    " is missing": ADVICE,
    "#* is read: a tool's length is in force, and controls differ on whether it counts here": (
        ELSEWHERE
    ),
    "'%' within *": ELSEWHERE,
    "the axis * in a polynomial": (
        "wants a machine with an axis beside X Y Z; A is no axis of the one here"
    ),
    "* along * in diameters": ELSEWHERE,
    "* begins no word": ELSEWHERE,
    "* brings back what * has changed, which is not followed": ELSEWHERE,
    "* brings the * back, and none was named before": ELSEWHERE,
    "* can not be followed": ADVICE,
    "* cuts of * pecks each": ELSEWHERE,
    "* has * digits": ELSEWHERE,
    "* in a block that makes no hole": ELSEWHERE,
    "* in an arc": ELSEWHERE,
    "* is an axis, not a string": ELSEWHERE,
    "* is cut to a whole number, and is one but for rounding": ELSEWHERE,
    "* is expected here": ADVICE,
    "G16 in G90 without *, behind a pole set in G91": ELSEWHERE,
    "X is a diameter within *": ELSEWHERE,
    "* of a direction has no decimal point, and others have one": ELSEWHERE,
    "* with D0, which has no radius": ELSEWHERE,
    "a pole or polar words while X is a diameter": ELSEWHERE,
    "a comment is opened and not closed in its line, or opened twice": ELSEWHERE,
    "a corner has a size above 0": ADVICE,
    "a corner, and then more than words and numbers": ELSEWHERE,
    "a label is missing behind *": ADVICE,
    "a weight of *": ELSEWHERE,
    "an arc in a program that calls labels": ELSEWHERE,
    "the shape has more than words and numbers: *": "the language has worked them out before",
    "there is no subroutine O* in this file": "the language has looked for it before",
    "CYCLE95 turns in X and Z": "wants a machine without X or Z",
    "the contour of CYCLE95: *": ADVICE,
    "an arc to a place that Q parameters say": ELSEWHERE,
    "an increment for the bottom of a hole": NO_DIALECT,
    "complete the control structure; blocks with / may have been left out": ADVICE,
    "tapping begins at *, above the initial level * of the holes before": ELSEWHERE,
    "the arc would take * lines": ELSEWHERE,
    "the machine has an axis *, and * is an increment of * on *": MACHINE,
    "the correction does not settle: it still changes by * um after * rounds": MACHINE,
    "the correction of * is * * (limit max_correction = * mm)": MACHINE,
    "the frames together leave nothing of an axis": ELSEWHERE,
    "this shape is never roughed out": ELSEWHERE,
    "to hold the tip there * goes to * *, beyond the * of * (* to * *)": ELSEWHERE,
    "what holds here is not known, because of a line before: *": ELSEWHERE,
    "within a cycle or a frame, and this block is more than words and numbers": ELSEWHERE,
    "* turns the tool, and *": MACHINE,
    "* holds no numbers": ELSEWHERE,
    "the tool comes nearer than * mm to the line of C, where C turns half around within the width"
    " of a correction": "wants a lathe with C; tests/test_polar_interpolation.py has one",
}
