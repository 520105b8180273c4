"""Numbers of Fanuc's custom macro B: what its operators and functions make of them, and what has no
value.

Numbers are IEEE doubles, as in Series 30i and 0i-F. Sources: B-64304EN and B-64484EN, "Custom
macro", "Arithmetic and logic operation"; angles as with parameter 6004 bit 0 (NAT) at 0: ASIN from
270 to 90 degrees, ATAN of two sides from 0 to
360. ADP and PRM are left out: they depend on parameters of the control.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from postproc.nc.expand import Refusal, cut

Value = float | None
ALARM = "the control stops here as well: look what the variables hold"


class Unknown(Refusal):
    """A variable is read whose value only the machine knows."""


def whole(value: Value, what: str) -> int:
    """A value as a whole number, the vacant one as 0. Raises Refusal where it has a fraction."""
    # results such as 2.9999999999 are meant as 3
    near = round(value or 0.0)
    if abs((value or 0.0) - near) > 1e-6:
        raise Refusal(f"{what} is {value:g}, not a whole number", "ROUND, FIX or FUP make it whole")
    return near


def nearest(value: float) -> float:
    """Rounded to a whole number, halves away from zero, as ROUND does."""
    # 2.5 to 3 and -2.5 to -3; Python's round would give the even one
    return math.copysign(math.floor(abs(value) + 0.5), value)


def index(value: Value) -> int:
    """The number of a variable: rounded, as the control does."""
    number = value or 0.0
    if not 0 <= number < 1e8:
        raise Refusal(
            f"there is no variable #{number:g}", "variables: #1 to #33, #100 to #199, #500 to #999"
        )
    return int(nearest(number))


# -- what operators and functions do ---------------------------------------------------------------


def _mod(a: float, b: float) -> float:
    """Both are rounded first, and the remainder has the sign of the dividend (B-64484EN)."""
    # (fmod, not %: that takes the sign of the divisor)
    return math.fmod(nearest(a), nearest(b))


def _bits(name: str) -> Callable[[float, float], float]:
    join: Callable[[int, int], int] = {"AND": int.__and__, "OR": int.__or__, "XOR": int.__xor__}[
        name
    ]

    def work(a: float, b: float) -> float:
        return float(join(whole(a, f"an operand of {name}"), whole(b, f"an operand of {name}")))

    return work


ARITHMETIC: dict[str, Callable[[float, float], float]] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b,
    "MOD": _mod,
    "AND": _bits("AND"),
    "OR": _bits("OR"),
    "XOR": _bits("XOR"),
    "GT": lambda a, b: float(a > b),
    "GE": lambda a, b: float(a >= b),
    "LT": lambda a, b: float(a < b),
    "LE": lambda a, b: float(a <= b),
}


def _sin(degrees: float) -> float:
    # so that SIN[30] is 0.5 and SIN[180] is 0
    return round(math.sin(math.radians(math.fmod(degrees, 360))), 15)


def _cos(degrees: float) -> float:
    return round(math.cos(math.radians(math.fmod(degrees, 360))), 15)


def _bcd(value: float) -> float:
    # BCD[25] is 37, hexadecimal 25: the digits written in groups of four bits. BIN is the way back.
    number = whole(value, "the argument of BCD")
    if not 0 <= number < 10**8:
        raise ValueError
    return float(int(str(number), 16))


def _bin(value: float) -> float:
    number = whole(value, "the argument of BIN")
    if number < 0:
        raise ValueError
    return float(int(f"{number:x}"))


def turn(y: float, x: float, full: float = 360) -> float:
    """Degrees of the direction with the sides y and x: from 0 to `full`, or with 0 from -180 to
    180."""
    if not x and not y:
        raise ValueError
    angle = math.degrees(math.atan2(y, x))
    return angle % full if full else angle


FUNCTIONS: dict[str, Callable[..., float]] = {
    "SIN": _sin,
    "COS": _cos,
    "TAN": lambda x: _sin(x) / _cos(x),
    "ASIN": lambda x: math.degrees(math.asin(x)) % 360,
    "ACOS": lambda x: math.degrees(math.acos(x)),
    "ATAN": lambda x: math.degrees(math.atan(x)),
    "SQRT": math.sqrt,
    "ABS": abs,
    "ROUND": nearest,
    "FIX": lambda x: float(math.trunc(cut(x))),
    "LN": math.log,
    "EXP": math.exp,
    "BIN": _bin,
    "FUP": lambda x: math.copysign(math.ceil(abs(cut(x))), x),
    "BCD": _bcd,
    "POW": math.pow,
    "ATAN2": lambda y, x: turn(y, x, 0),
}
# two letters stand for a function
SHORT = {name[:2]: name for name in FUNCTIONS if name != "ATAN2"} | {"SQR": "SQRT", "RND": "ROUND"}


def to_places(value: float, places: int) -> float:
    """Rounded to decimals, halves away from zero."""
    return nearest(value * 10.0**places) / 10.0**places if abs(value) < 1e15 else value


def computed(
    name: str, function: Callable[..., float], values: Sequence[float], place: tuple[int, int]
) -> float:
    """What a function or an operator makes of numbers; what has no value is a Refusal at
    `place`."""
    try:
        result = function(*values)
    except (ValueError, OverflowError, ZeroDivisionError):
        # what Python refuses and what it gives as inf or nan is told alike, below
        result = math.inf
    except Refusal as wrong:
        raise Refusal(wrong.message, wrong.advice, *place) from None
    if math.isfinite(result):
        return result
    if name in ("/", "MOD") and not values[1]:
        raise Refusal(f"division of {values[0]:g} by zero", ALARM, *place)
    shown = [f"{value:g}" for value in values]
    what = f" {name} ".join(shown) if name in ARITHMETIC else f"{name}[{', '.join(shown)}]"
    raise Refusal(f"{what} has no value", ALARM, *place)
