"""Follow a program with pygcode's `Machine`, line by line, as its documentation shows.

    python benchmarks/peer_pygcode.py FILE

It writes nothing and stops at the first word that it does not know.
"""

import sys

from pygcode import Line, Machine

machine = Machine()
with open(sys.argv[1], encoding="ascii") as file:
    for text in file:
        machine.process_block(Line(text).block)
