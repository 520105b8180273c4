"""Send a program with printrun's printcore: python peer_printcore.py PORT FILE. Prints done when it
says so."""

import sys
import time

from printrun import gcoder
from printrun.printcore import printcore

port, path = sys.argv[1:]
with open(path) as stream:
    lines = [line.strip() for line in stream if line.strip()]
errors = []
core = printcore()
core.errorcb = errors.append
core.connect(port, 115200)
while not core.online:
    time.sleep(0.02)
core.startprint(gcoder.LightGCode(lines))
while core.printing:
    time.sleep(0.02)
core.send_now("M400")
time.sleep(1.0)
print("done", flush=True)
core.disconnect()
