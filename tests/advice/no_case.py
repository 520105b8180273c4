"""Sentences that no case provokes, and why. What has no way out is said so here."""

ADVICE = "the way out of other sentences, which are made in several steps: the page shows it by itself"
MACHINE = "the machine's folder is at fault, not the program: tests/test_refusals.py edits one"
NO_DIALECT = "no control here has both such words and such a cycle that is corrected in place"
ELSEWHERE = "provoked in tests/expand; what follows from its advice is not tried yet"

NO_CASE: dict[str, str] = {
    "* is expected here": ADVICE,
    " is missing": ADVICE,
    "a corner has a size above 0": ADVICE,
    "a label is missing behind *": ADVICE,
    "complete the control structure; blocks with / may have been left out": ADVICE,
    "give the roughing a shape of its own without it, and G70 the one with it": ADVICE,
    "an increment for the bottom of a hole": NO_DIALECT,
    "the correction does not settle: it still changes by * um after * rounds": MACHINE,
    "the correction of * is * mm (limit max_correction = * mm)": MACHINE,
    "* in a block that makes no hole": ELSEWHERE,
    "* within *": ELSEWHERE,
    "* cuts of * pecks each": ELSEWHERE,
    "G16 in G90 without *, behind a pole set in G91": ELSEWHERE,
    "G70 along a shape that goes towards +Z": ELSEWHERE,
    "P behind the first block of a NURBS": ELSEWHERE,
    "RPL in *": ELSEWHERE,
    "X is a diameter within *": ELSEWHERE,
    "a corner, and then more than words and numbers": ELSEWHERE,
    "a distance to a shape of one X": ELSEWHERE,
    "a knot of the NURBS stands there more often than its rank, *, allows": ELSEWHERE,
    "a weight of *": ELSEWHERE,
    "a weight without a control point": ELSEWHERE,
    "an absolute centre word within *": ELSEWHERE,
    "an arc of the shape goes beyond a quadrant": ELSEWHERE,
    "tapping begins at *, above the initial level * of the holes before": ELSEWHERE,
    "the first block of the shape moves away from it": ELSEWHERE,
    "the frames together leave nothing of an axis": ELSEWHERE,
    "the shape does not vary in both X and Z": ELSEWHERE,
    "the shape of the cycle moves nothing": ELSEWHERE,
    "this hole would take more than * pecks of *": ELSEWHERE,
    "within a cycle or a frame, and this block is more than words and numbers": ELSEWHERE,
    "'%' within *": ELSEWHERE,
    "* begins no word": ELSEWHERE,
    "a comment is opened and not closed in its line, or opened twice": ELSEWHERE,
    "what holds here is not known, because of a line before: *": ELSEWHERE,
    "#* is read: a tool's length is in force, and controls differ on whether it counts here": ELSEWHERE,
    "* has * digits": ELSEWHERE,
    "* is an axis, not a string": ELSEWHERE,
}
