"""Follow a program with nc-gcode-interpreter, which makes a table of it.

    python benchmarks/peer_nc_gcode_interpreter.py FILE

It reads Sinumerik's language: what that does not have (%, comments in parentheses, G91.1, which is
how Sinumerik reads I J K anyway) is taken out before, and the table is thrown away.
"""

import sys

from nc_gcode_interpreter import nc_to_dataframe

with open(sys.argv[1], encoding="ascii") as file:
    text = "".join(line.replace("G91.1 ", "") for line in file if line[0] not in "%(")
nc_to_dataframe(text)
