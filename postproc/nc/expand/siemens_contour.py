"""The contour that a turning cycle of Sinumerik cuts: its blocks, run by themselves, as lines and
arcs in the ZX plane.

Siemens "SINUMERIK 840D sl / 828D / 808D", "Contour definition" of CYCLE95: a subprogram, or the
part of the program from one label to another; the first place that it names is the start of the
contour, and must name both axes. Feeds and speeds in it are passed over, motions of other axes too.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from postproc.errors import BlockFault, ProgramError
from postproc.motions import CLOCKWISE, COUNTER, FEED, RAPID, Motions
from postproc.nc.cycles.profile import Element
from postproc.nc.cycles.scene import CLOCKWISE as G2
from postproc.nc.cycles.scene import COUNTER as G3
from postproc.nc.expand import Limits, Program, Refusal
from postproc.nc.expand.siemens_flow import read
from postproc.nc.expand.siemens_frames import Frame
from postproc.nc.expand.siemens_source import Source, missing
from postproc.nc.expand.siemens_statements import Call
from postproc.nc.expand.tracker import Tracker
from postproc.nc.expand.written import Written
from postproc.nc.interpreter import Interpreter
from postproc.nc.lexer import lex
from postproc.nc.state import Setup
from postproc.units import TICKS_PER_INCH, TICKS_PER_MM

CODE = {RAPID: 0, FEED: 10, CLOCKWISE: G2, COUNTER: G3}
MOST_LINES = 10_000
NEAR = 1e-9
CHECK = "check the contour of the cycle"


def contour_of(
    frame: Frame, library: Callable[[str], Source | None], call: Call
) -> Callable[[str], list[bytes]]:
    """What gives the plain lines of a contour by its name; frame: of the program that calls."""

    def lines(name: str) -> list[bytes]:
        source, begin = frame.source, 0
        if ":" in name:
            first, last = (part.strip().upper() for part in name.split(":", 1))
            begin, stop = source.section(first, last, frame.at)
        else:
            inner = library(name)
            if inner is None:
                raise missing(name, call.start, call.stop)
            source, stop = inner, len(inner.lines) - 1
        found = []
        for raw in source.lines[begin : stop + 1]:
            statement = read(raw.decode("latin-1"))
            # M17 or M2 ends the contour, as it ends the subprogram that holds it
            if statement.ends:
                break
            if statement.control == "PROC":
                continue
            if statement.control or statement.call or statement.jumps:
                text = raw.decode("latin-1").strip()
                raise Refusal(
                    f"the contour of CYCLE95 has more than motions: {text}",
                    "write its motions alone",
                )
            found.append((statement.written(frame.scope) or "").encode("latin-1"))
        return found

    return lines


def elements(tracker: Tracker, lines: list[bytes]) -> list[Element]:
    """The contour in (z, x radius), program's unit. Raises Refusal."""
    dialect, axes = tracker.dialect, tracker.setup.axes
    if "X" not in axes or "Z" not in axes:
        raise Refusal("CYCLE95 turns in X and Z", "choose the right --machine")
    # Without offsets, G500 alone, so that places come in the contour's own coordinates; the modes
    # are those that hold where the cycle is called (_head).
    setup = Setup(
        axes,
        diameter=tracker.setup.diameter,
        least_increment=tracker.setup.least_increment,
        offsets={"G500": {}},
    )
    interpreter = Interpreter(dialect, setup)
    text = b"\n".join([_head(tracker), *lines, b""])
    try:
        program = Program("the contour of CYCLE95", text)
        # expanded once more by itself: RND and CHF in a contour become arcs and chamfers here
        plain = b"".join(Written(program, interpreter, Limits(MOST_LINES, 1)))
        words = lex(plain, dialect.grammar, tracker.setup.block_delete)
        motions = interpreter.run(words, interpreter.initial())[0]
    except (ProgramError, BlockFault) as error:
        raise Refusal(f"the contour of CYCLE95: {error.message}", error.advice) from None
    if words.fault is not None:
        raise Refusal(f"the contour of CYCLE95: {words.fault.message}", words.fault.advice)
    bad = motions.reason.nonzero()[0]
    if len(bad):
        message, advice = motions.reasons[motions.reason[bad[0]]]
        raise Refusal(f"the contour of CYCLE95: {message}", advice)
    return _shape(motions, [axes.index(x) for x in "ZX"], tracker.inch)


def _head(tracker: Tracker) -> bytes:
    """The modes in which the contour is read."""
    words = ["G500"]
    for group in ("units", "plane", "distance", "diameter", "motion"):
        held = tracker.code(group)
        words += [
            code.word
            for code in tracker.dialect.codes
            if code.group == group and code.number == held and not code.refuses
        ][:1]
    return " ".join(words).encode()


def _shape(motions: Motions, rows: list[int], inch: bool) -> list[Element]:
    unit = TICKS_PER_INCH if inch else TICKS_PER_MM
    mm = 25.4 if inch else 1.0
    # the way to the first place is none of the contour: the cycle goes there by itself
    if not len(motions.block) or not motions.target_known[rows, 0].all():
        raise Refusal("the contour of CYCLE95 does not begin at a place in X and Z", CHECK)
    # (N, 2): z and x, a radius whatever the words are
    places = motions.target[rows].T / unit
    arc_of = {int(k): i for i, k in enumerate(motions.arcs.motion)}
    found: list[Element] = []
    for k in range(1, len(places)):
        start, end = ((float(places[i][0]), float(places[i][1])) for i in (k - 1, k))
        code = CODE.get(int(motions.code[k]))
        if code is None:
            raise Refusal("the contour of CYCLE95 has more than lines and arcs", CHECK)
        if k in arc_of:
            centre = motions.arcs.centre[:, arc_of[k]] / mm
            found.append(Element(code, start, end, (), (float(centre[0]), float(centre[1]))))
        elif np.hypot(end[0] - start[0], end[1] - start[1]) > NEAR:
            found.append(Element(code, start, end))
    if not found:
        raise Refusal("the contour of CYCLE95 has no way", CHECK)
    return found
