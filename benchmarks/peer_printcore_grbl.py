"""Send a program to a GRBL with printrun's printcore: python peer_printcore_grbl.py PORT FILE.
Prints when it began and ended, s.

What GRBL refuses is left out of what printcore sends: line numbers, checksums, M105 and M110; the
rest of it is as it comes."""

import sys
import time

from printrun import gcoder
from printrun.printcore import printcore


class Plain(printcore):
    def _send(self, command, lineno=0, calcchecksum=False):
        super()._send("" if command.startswith(("M105", "M110")) else command, lineno, False)


port, path = sys.argv[1:]
with open(path) as stream:
    lines = [line.strip() for line in stream if line.strip()]
ends = []
core = Plain()
core.endcb = lambda: ends.append(time.monotonic())
core.connect(port, 115200)
while not core.online:
    time.sleep(0.02)
begun = time.monotonic()
core.startprint(gcoder.LightGCode(lines))
while not ends:
    time.sleep(0.02)
print(begun, ends[0], flush=True)
core.disconnect()
