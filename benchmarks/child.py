"""Run one command and print what it used: exit status, CPU seconds (user + system), wall seconds,
peak memory in MB.

    python -I -S benchmarks/child.py COMMAND ...

A process of its own, as small as Python gets: on Linux a child's peak counts the memory of the
process it was forked from, so a larger parent would hide a small child (the floor is about 9 MB).
The command's output is thrown away and its standard error is passed on.
"""

import os
import sys
import time


def main() -> None:
    command = sys.argv[1:]
    null = os.open(os.devnull, os.O_RDWR)
    start = time.perf_counter()
    actions = [(os.POSIX_SPAWN_DUP2, null, 0), (os.POSIX_SPAWN_DUP2, null, 1)]
    child = os.posix_spawnp(command[0], command, os.environ, file_actions=actions)
    _, status, used = os.wait4(child, 0)
    wall = time.perf_counter() - start
    peak = used.ru_maxrss / 1024.0  # the kernel gives kB
    print(os.waitstatus_to_exitcode(status), used.ru_utime + used.ru_stime, wall, peak)


main()
