"""The only unit conversions. Inside: mm, rad, s, float64; programmed positions are whole ticks.

A tick is 0.1 pm. Positions that are sums of programmed words are kept as int64 ticks, because sums
of integers do not depend on where the input was cut, and a chain of incremental words can not
drift. The range is +-900 km.
"""

import re

import numpy as np

# words of ten decimals of a mm, and of nine of an inch (254 ticks each), are whole ticks
TICKS_PER_MM = 10_000_000_000
# Without axes: an operator with a number takes twice as long where a batch is one block, and one
# that must convert whole numbers first four times as long.
_PER_MM = np.array(float(TICKS_PER_MM))
MM_PER_INCH = 25.4
TICKS_PER_INCH = 254_000_000_000

UM = 1e-3  # mm
URAD = 1e-6  # rad
# a larger coordinate is a slip of the pen, and would come near the end of int64
LARGEST_WORD_MM = 1e6

# What a heading of times says that are no seconds: "Time (min)", t_min, elapsed_h, time_ms.
OTHER_TIME = re.compile(
    r"(?:^|[\s_(\[])(min(?:ute)?s?|h(?:ou)?rs?|h|days?|[mµμun]s)[)\].]*$", re.IGNORECASE
)


def in_mm(ticks: np.ndarray) -> np.ndarray:
    """float64 mm of int64 ticks, of any shape."""
    return ticks.astype(np.float64) / _PER_MM


def in_ticks(place: np.ndarray) -> np.ndarray:
    """int64 ticks of mm, of any shape: rounded once, half to even."""
    # 2**53 ticks are 900 m: a place up to there is exact to the tick
    return np.rint(place * _PER_MM).astype(np.int64)
