"""Take a program apart with gcodeparser, line by line.

    python benchmarks/peer_gcodeparser.py FILE

It knows words and no state, and passes over lines without a code (a bare X1 Y2).
"""

import sys

from gcodeparser import parse_gcode_lines

with open(sys.argv[1], encoding="ascii") as file:
    for _ in parse_gcode_lines(file):
        pass
