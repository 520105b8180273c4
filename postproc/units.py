"""The only unit conversions. Inside: mm, rad, s, float64; programmed positions are whole ticks.

A tick is 0.1 pm. Positions that are sums of programmed words are kept as int64 ticks, because sums
of integers do not depend on where the input was cut, and a chain of incremental words can not
drift. The range is +-900 km.
"""

TICKS_PER_MM = 10_000_000_000
MM_PER_INCH = 25.4
TICKS_PER_INCH = 254_000_000_000

UM = 1e-3  # mm
URAD = 1e-6  # rad
# a larger coordinate is a slip of the pen, and would come near the end of int64
LARGEST_WORD_MM = 1e6
