"""Sinumerik values: types and their conversions, variables and arrays, what operators and functions
give.

Sources: Siemens "SINUMERIK 840D sl / 828D Job Planning", chapter "Flexible NC programming": user
variables, arithmetic functions, priority of the operations (comparisons bind least, so `A==1 AND
B==1` is `A==(1 AND B)==1`), relative equality of comparisons, possible type conversions. Angles are
degrees.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

from postproc.nc.expand import Refusal
from postproc.nc.expand.tracker import Tracker

LARGEST_INT, LARGEST_ARRAY = 2**31 - 1, 1_000_000
LARGEST_PARAMETER = 99_999
EXACT = 2**53  # whole numbers beyond are kept as REAL
AXIS_LETTERS = "XYZABCUVWEQS"
EQUAL = 1e-12  # relative difference below which numbers count as equal


@dataclass(frozen=True)
class Axis:
    """The name of an axis as a value (type AXIS)."""

    name: str


Value = float | int | bool | str | Axis


@dataclass
class Variable:
    """A variable or an array: its type ("REAL", "INT", "BOOL", "CHAR", "STRING", "AXIS"), the
    length of each dimension, and the values, last index fastest; None: has none."""

    kind: str
    shape: tuple[int, ...] = ()
    values: list[Value | None] = field(default_factory=lambda: [None])

    def offset(self, name: str, index: list[int]) -> int:
        """The place of an element. Raises Refusal where it is outside."""
        if len(index) != len(self.shape):
            raise Refusal(
                f"{name} has {len(self.shape)} indices, here are {len(index)}",
                "write one per dimension",
            )
        place = 0
        for i, length in zip(index, self.shape, strict=True):
            if not 0 <= i < length:
                raise Refusal(
                    f"index {i} of {name} is outside 0 to {length - 1}",
                    "correct the index or the DEF",
                )
            # last index fastest: of FELD[2,3] element [1,0] is the fourth
            place = place * length + i
        return place


EMPTY: dict[str, Value | None] = {
    "REAL": 0.0, "INT": 0, "BOOL": False, "CHAR": 0, "STRING": "", "AXIS": None,
}  # fmt: skip


@dataclass
class Scope:
    """What a line can see: the program's own variables, by upper case name, and the R parameters of
    the channel.

    decimals: how many are written behind an address, as far as asked for; inner: whether this is a
    subprogram."""

    tracker: Tracker
    parameters: dict[int, Variable]
    decimals: dict[str, int]
    inner: bool = False
    variables: dict[str, Variable] = field(default_factory=dict)

    def is_axis(self, name: str) -> bool:
        """Whether a name is one of the machine's axes, or of the form of one (X, C2)."""
        axes = (*self.tracker.setup.axes, *self.tracker.dialect.carried)
        return name in axes or (name[0] in AXIS_LETTERS and (len(name) == 1 or name[1:].isdigit()))

    def find(self, name: str, index: list[int]) -> tuple[Variable, int]:
        """The variable or R parameter and the place in it. Raises Refusal where there is none."""
        if name[0] == "R" and (name == "R" or name[1:].isdigit()):
            # R5, or R[5]
            number = int(name[1:]) if name != "R" else index[0] if len(index) == 1 else -1
            if not 0 <= number <= LARGEST_PARAMETER or (name != "R" and index):
                raise Refusal(
                    f"an R parameter has one number from 0 to {LARGEST_PARAMETER}",
                    "write R1 or R[1]",
                )
            return self.parameters.setdefault(number, Variable("REAL")), 0
        variable = self.variables.get(name)
        if variable is None:
            raise undefined(name)
        return variable, variable.offset(name, index)


Node = Callable[[Scope], Value]


def undefined(name: str) -> Refusal:
    """That a name is neither defined in the program nor a word of the language."""
    return Refusal(
        f"{name} is not defined in this program",
        f"a variable that the control holds: write DEF REAL {name}=... at the top; an axis: name it"
        " in the machine's file",
    )


# -- values ----------------------------------------------------------------------------------------


def numeric(value: Value) -> float | int:
    """A number or truth value as it is. Raises Refusal for others."""
    if isinstance(value, (int, float)):
        return value
    if isinstance(value, Axis):
        raise Refusal(
            f"{value.name} is an axis, not a number", f"$AA_IW[{value.name}] is where it stands"
        )
    raise Refusal("a string stands where a number is needed", "calculate with numbers")


def rounded(value: Value) -> int:
    """REAL to INT as the control does: 0.5 and more is rounded up, less is rounded down."""
    value = numeric(value)
    below = math.floor(value)
    if value < 0 and value - below == 0.5:
        raise Refusal(
            f"{value:.12g} lies half way between two whole numbers and is negative",
            "the manual does not tell which one the control takes: write the whole number",
        )
    return below + (value - below >= 0.5)


def truth(value: Value) -> bool:
    """Numbers other than 0 and strings with a character are true."""
    return bool(value) if isinstance(value, str) else numeric(value) != 0


def text_of(value: Value) -> str:
    """A value as `<<` chains it."""
    if isinstance(value, (bool, int)):
        return str(int(value))
    if isinstance(value, Axis):
        raise Refusal(
            f"{value.name} is an axis, not a string",
            "AXSTRING is not calculated: write the string itself",
        )
    return value if isinstance(value, str) else f"{value:.10g}"


def converted(kind: str, value: Value) -> Value:
    """A value as a variable of this type holds it. Raises Refusal where the manual's table has no
    conversion."""
    if kind in ("STRING", "AXIS"):
        if not isinstance(value, str if kind == "STRING" else Axis):
            raise Refusal(
                f"only a value of type {kind} can be assigned here",
                "assign one, or define another type",
            )
        return value
    if kind == "BOOL":
        return truth(value)
    if kind == "REAL":
        return float(numeric(value))
    if kind == "CHAR" and isinstance(value, str) and len(value) == 1:
        return ord(value)
    whole = rounded(value)
    low, high = (0, 255) if kind == "CHAR" else (-LARGEST_INT - 1, LARGEST_INT)
    if not low <= whole <= high:
        raise Refusal(
            f"{whole:.12g} is outside {low} to {high}, which type {kind} holds", "define it as REAL"
        )
    return whole


def fitting(value: float | int) -> float | int:
    """The same number, unless no REAL holds it."""
    # beyond 2^53 a float no longer holds every whole number
    if isinstance(value, int) and -EXACT <= value <= EXACT:
        return value
    if not math.isfinite(value):
        raise Refusal(
            "the result is beyond what REAL holds (1.8EX308)",
            "correct the expression or its values",
        )
    return float(value)


# -- operators and functions -----------------------------------------------------------------------


def equal(a: Value, b: Value) -> bool:
    """`==`: numbers that differ by less than 1e-12 of the larger one are equal."""
    # a character against a number is its code (CHAR); strings and axes among their own kind alone
    if isinstance(a, Axis) or isinstance(b, Axis) or (isinstance(a, str) and isinstance(b, str)):
        return a == b
    a, b = _code(a), _code(b)
    # 0.1 * 3 == 0.3 holds, as on the control: a loop counts as often as there
    return a == b or abs(a - b) <= EQUAL * max(abs(a), abs(b))


def _code(value: Value) -> float | int:
    return ord(value) if isinstance(value, str) and len(value) == 1 else numeric(value)


def less(a: Value, b: Value) -> bool:
    """`<`, and not equal."""
    if isinstance(a, str) and isinstance(b, str):
        return a < b
    return not equal(a, b) and _code(a) < _code(b)


def _divide(a: Value, b: Value) -> float | int:
    a, b = numeric(a), numeric(b)
    if b == 0:
        raise Refusal(f"division of {a:.12g} by zero", "correct the divisor, or test it before")
    return fitting(a / b)


def _whole_divide(a: Value, b: Value) -> int:
    a, b = numeric(a), numeric(b)
    # towards 0, as DIV does; Python's // goes down
    if isinstance(a, int) and isinstance(b, int) and b:
        quotient = abs(a) // abs(b)
        return -quotient if (a < 0) != (b < 0) else quotient
    return math.trunc(_divide(a, b))


def _modulo(a: Value, b: Value) -> float | int:
    a, b = numeric(a), numeric(b)
    if isinstance(a, int) and isinstance(b, int):
        return a - b * _whole_divide(a, b)
    _divide(a, b)
    return math.fmod(a, b)


def _within(value: Value, low: float, high: float, name: str) -> float | int:
    value = numeric(value)
    if not low <= value <= high:
        raise Refusal(f"{name} of {value:.12g} does not exist", "correct its argument")
    return value


def _tangent(value: Value) -> float:
    # tan(radians(90)) is 1.6e16 in floats: asked of the degrees
    angle = numeric(value) % 180
    if angle == 90:
        raise Refusal(f"TAN of {numeric(value):.12g} does not exist", "correct its argument")
    return math.tan(math.radians(angle))


def _exponential(value: Value) -> float:
    return math.exp(_within(value, -1e308, 709.7, "EXP"))


BINARY: dict[str, tuple[int, Callable[[Value, Value], Value]]] = {
    "*": (10, lambda a, b: fitting(numeric(a) * numeric(b))),
    "/": (10, _divide),
    "DIV": (10, _whole_divide),
    "MOD": (10, _modulo),
    "+": (9, lambda a, b: fitting(numeric(a) + numeric(b))),
    "-": (9, lambda a, b: fitting(numeric(a) - numeric(b))),
    "B_AND": (8, lambda a, b: rounded(a) & rounded(b)),
    "B_XOR": (7, lambda a, b: rounded(a) ^ rounded(b)),
    "B_OR": (6, lambda a, b: rounded(a) | rounded(b)),
    "AND": (5, lambda a, b: truth(a) and truth(b)),
    "XOR": (4, lambda a, b: truth(a) != truth(b)),
    "OR": (3, lambda a, b: truth(a) or truth(b)),
    "<<": (2, lambda a, b: text_of(a) + text_of(b)),
    "==": (1, equal),
    "<>": (1, lambda a, b: not equal(a, b)),
    "<": (1, less),
    ">": (1, lambda a, b: less(b, a)),
    "<=": (1, lambda a, b: less(a, b) or equal(a, b)),
    ">=": (1, lambda a, b: less(b, a) or equal(a, b)),
}
UNARY: dict[str, Callable[[Value], Value]] = {
    "+": numeric,
    "-": lambda a: -numeric(a),
    "NOT": lambda a: not truth(a),
    "B_NOT": lambda a: ~rounded(a),
    "<<": text_of,
}
FUNCTIONS: dict[str, tuple[int, Callable[..., Value]]] = {
    "SIN": (1, lambda a: math.sin(math.radians(numeric(a)))),
    "COS": (1, lambda a: math.cos(math.radians(numeric(a)))),
    "TAN": (1, _tangent),
    "ASIN": (1, lambda a: math.degrees(math.asin(_within(a, -1, 1, "ASIN")))),
    "ACOS": (1, lambda a: math.degrees(math.acos(_within(a, -1, 1, "ACOS")))),
    "ATAN2": (2, lambda a, b: math.degrees(math.atan2(numeric(a), numeric(b)))),
    "SQRT": (1, lambda a: math.sqrt(_within(a, 0, math.inf, "SQRT"))),
    "ABS": (1, lambda a: abs(numeric(a))),
    "POT": (1, lambda a: fitting(numeric(a) * numeric(a))),
    "TRUNC": (1, lambda a: math.trunc(numeric(a))),
    "ROUND": (1, rounded),
    "LN": (1, lambda a: math.log(_within(a, 5e-324, math.inf, "LN"))),
    "EXP": (1, _exponential),
    "MINVAL": (2, lambda a, b: min(numeric(a), numeric(b))),
    "MAXVAL": (2, lambda a, b: max(numeric(a), numeric(b))),
    "BOUND": (3, lambda low, high, a: min(max(numeric(a), numeric(low)), numeric(high))),
}
POSITIONS = {"$AA_IW": True, "$P_EP": True, "$AA_IM": False}  # whether in work coordinates


def position(scope: Scope, name: str, axis: Value) -> float:
    """Where an axis stands: $AA_IW, $P_EP (work) or $AA_IM (machine). Raises Refusal where nobody
    knows."""
    if not isinstance(axis, Axis) or axis.name not in scope.tracker.setup.axes:
        shown = axis.name if isinstance(axis, Axis) else "its index"
        raise Refusal(
            f"{name}: {shown} is none of the machine's axes",
            f"they are {', '.join(scope.tracker.setup.axes)}",
        )
    tracker = scope.tracker
    if not POSITIONS[name] and tracker.inch:
        raise Refusal(
            f"{name} is read while inch is in force",
            "calculate in work coordinates ($AA_IW), or in mm",
        )
    value = tracker.work(axis.name) if POSITIONS[name] else tracker.machine(axis.name)
    if value is None:
        raise Refusal(
            f"{name}[{axis.name}]: where {axis.name} stands is not known",
            f"program {axis.name} in absolute words before",
        )
    return value
