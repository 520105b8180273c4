"""PLANE of Heidenhain Klartext: a tilted plane by spatial or Euler angles, and the turn of the
rotary axes into it.

PLANE SPATIAL SPA SPB SPC: about X, Y and Z of the coordinates that are not tilted, in this order;
PLANE EULER EULPR EULNU EULROT: about Z, about the new X, about the new Z; the datum in force stays
the zero. PLANE RESET ends the plane. TURN turns the rotary axes into it (RESET: to zero), MOVE
takes the slides along besides, STAY turns nothing; MB draws the tool back before. SEQ + or - is the
sign of the rotary axis nearest to the tool; without it the control takes the shorter way
(HEIDENHAIN TNC 640, iTNC 530 user's manuals, Klartext programming, "The PLANE function: Tilting the
working plane").
"""

from __future__ import annotations

import numpy as np

from postproc.expressions import expression
from postproc.nc.batch import AxisWords, Batch
from postproc.nc.planes import plane_align, plane_off, tilt, turn_to, turned
from postproc.nc.queries import lose
from postproc.nc.tips import PLANE
from postproc.nc.zeros import with_known

WORD = "PLANE"
KIND = expression(rb"PLANE[ \t]+([A-Z]+)")
ANGLE = expression(rb"(SP[ABC]|EUL(?:PR|NU|ROT))[ \t]*([-+]?[0-9]*\.?[0-9]+)")
HOW = expression(rb"[ \t](TURN|MOVE)\b")
SIGN = expression(rb"\bS(?:EQ|YM)[ \t]*([-+])")
# Turns about axes that stay, X then Y then Z, are those about axes that turn along in the opposite
# order: both are the matrix Rz(SPC) Ry(SPB) Rx(SPA).
NAMES = {b"SPATIAL": (b"SPC", b"SPB", b"SPA"), b"EULER": (b"EULPR", b"EULNU", b"EULROT")}
ABOUT = {b"SPATIAL": (2, 1, 0), b"EULER": (2, 0, 2)}  # the same turns, about axes that turn along
LEVEL = 1e-9
OTHER = "let the CAM program write PLANE SPATIAL with SPA, SPB and SPC"


def spatial(b: Batch, axis_words: AxisWords, word: str) -> None:
    """The plane of the first block."""
    text = _text(b)
    found = KIND.search(text)
    kind = found[1] if found else b""
    if kind == b"RESET":
        plane_off(b, axis_words, word)
        return
    given = {name: float(value) for name, value in ANGLE.findall(text)}
    reason = None
    if kind not in NAMES or set(given) != set(NAMES[kind]):
        reason = ("PLANE defines its plane otherwise than by three angles", OTHER)
        kind, given = b"SPATIAL", dict.fromkeys(NAMES[b"SPATIAL"], 0.0)
    turn = turned(ABOUT[kind], [given[name] for name in NAMES[kind]])
    # the normal has no part in X and Y, and X is turned: a plane that lies level, turned about Z
    if b"TABLE ROT" in text and np.hypot(*turn[:2, 2]) < LEVEL and turn[0, 0] < 1 - LEVEL:
        reason = (
            "PLANE turns the table in a plane that is not tilted (TABLE ROT)",
            "turn the table by a block of its own, or write COORD ROT",
        )
    tilt(b, WORD, turn, np.zeros(3), None)
    if reason is not None:
        b.frame = with_known(b.frame, PLANE, reason)


def turned_in(b: Batch) -> None:
    """TURN and MOVE of the first block; behind `tips.settle`."""
    text = _text(b)
    how = HOW.search(text)
    if how is None:
        return
    if how[1] == b"MOVE" or b" MB" in text:
        lose(b, "XYZ")
    found = KIND.search(text)
    if found is not None and found[1] == b"RESET":
        turn_to(b, np.zeros(len(b.rows), np.int64))
        return
    sign = SIGN.search(text)
    plane_align(b, WORD, 0.0 if sign is None else 1.0 if sign[1] == b"+" else -1.0)


def _text(b: Batch) -> bytes:
    """The first block, in capitals."""
    w = b.words
    return w.text[w.block_start[0] : w.block_stop[0]].upper().partition(b";")[0]
