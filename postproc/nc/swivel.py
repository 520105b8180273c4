"""CYCLE800 of Sinumerik: a tilted plane from its arguments, and the swivel of the rotary axes into
it.

CYCLE800(_FR, _TC, _ST, _MODE, _X0, _Y0, _Z0, _A, _B, _C, _X1, _Y1, _Z1, _DIR, ..): the plane's zero
X0 Y0 Z0, turns by A B C one after the other, each about an axis that the ones before have turned,
and a shift X1 Y1 Z1 in the plane. _MODE: two bits each for the first, second and third turn (1 X, 2
Y, 3 Z), and above them 0, axis by axis. _DIR: 0 does not swivel, else the sign of the axis that
tilts. Without arguments the plane ends (SINUMERIK 840D sl Programming Manual Job Planning, "Swivel
plane CYCLE800"; Operating Manual Milling, "Swivel"). A plane that neither turns nor shifts, as
posts write before work from above, is none where no rotary axis carries the tool or the work.
"""

from __future__ import annotations

import re

import numpy as np

from postproc.expressions import expression
from postproc.nc.batch import AxisWords, Batch
from postproc.nc.planes import plane_off, tilt, turn_to, turned
from postproc.nc.tips import PLANE
from postproc.nc.zeros import with_known

CALL = expression(rb"CYCLE800[ \t]*(?:\(([^()\n]*)\))?", re.IGNORECASE)
WORD = "CYCLE800"
MODE, ZERO, ANGLES, SHIFT, DIRECTION = 3, slice(4, 7), slice(7, 10), slice(10, 13), 13
BY_AXIS = 57  # X, then Y, then Z


def swivel(b: Batch, axis_words: AxisWords, word: str) -> None:
    """The plane of the call in the first block."""
    given = _arguments(b)
    if given is None:
        refuse(b, "its arguments are not plain numbers", "--expand writes variables out")
        return
    values = [given[k] if k < len(given) else 0.0 for k in range(DIRECTION + 1)]
    if not any(values[4:DIRECTION]) and (not values[MODE] or b.setup.kinematics is None):
        plane_off(b, axis_words, word)
        if values[DIRECTION] and b.setup.kinematics is None:
            turn_to(b, b.state.position)
        return
    mode = int(values[MODE]) or BY_AXIS
    #   57 = 00 11 10 01    two bits a turn, the first at the right: 1, 2, 3 are X, Y, Z.
    order = tuple((mode >> (2 * k)) % 4 - 1 for k in range(3))
    if mode >> 6 or -1 in order:
        refuse(
            b,
            f"its mode {mode} does not turn axis by axis",
            "let the CAM program write it axis by axis (mode 57)",
        )
        return
    # _ST: with a last digit of 0 the plane is a new one, else it counts from the one in force
    if given[2] and int(given[2]) % 10:
        refuse(
            b,
            "it adds to the plane before",
            "let the CAM program write the whole plane into one call",
        )
        return
    # a place w of the plane is X0 + R (X1 + w): the second shift counts in the plane
    turn = turned(order, values[ANGLES])
    tilt(b, word, turn, np.array(values[ZERO]) + turn @ np.array(values[SHIFT]), None)


def direction(b: Batch) -> float:
    """_DIR of the call in the first block; 0: the rotary axes stay."""
    given = _arguments(b) or []
    return given[DIRECTION] if len(given) > DIRECTION else 0.0


def retracts(b: Batch) -> bool:
    """Whether the call in the first block takes the slides back first, to a place of the machine's
    data."""
    given = _arguments(b) or [0.0]
    return bool(given and given[0])


def refuse(b: Batch, message: str, advice: str) -> None:
    """No plane that can be followed."""
    b.frame = with_known(b.frame, PLANE, (f"CYCLE800 (tilted plane): {message}", advice))


def _arguments(b: Batch) -> list[float] | None:
    """The numbers of the call, its name as 0; None where one is no number."""
    w = b.words
    found = CALL.search(w.text[w.block_start[0] : w.block_stop[0]])
    parts = (found[1] or b"").decode("latin-1").split(",") if found else []
    try:
        return [0.0 if not p.strip() or p.strip().startswith('"') else float(p) for p in parts]
    except ValueError:
        return None
