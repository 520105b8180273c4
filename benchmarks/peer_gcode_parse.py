"""Read a program with LinuxCNC's `gcode.parse` and a canon that does nothing: its interpreter at
its fastest.

    python benchmarks/peer_gcode_parse.py FILE [--count]

Needs the module `gcode` on PYTHONPATH and its libraries on LD_LIBRARY_PATH. With `--count` the
canon counts the motions instead, and they are printed.
"""

import os
import sys
import tempfile

import gcode


class Canon:
    """Answers what the interpreter asks; every other call (motion, dwell, spindle, plane ...) is
    ignored."""

    def __init__(self, folder):
        self.parameter_file = os.path.join(folder, "parameters")
        open(self.parameter_file, "w").close()

    def get_tool(self, pocket):
        return (-1,) + (0.0,) * 12 + (0,)

    def get_external_angular_units(self):
        return 1.0

    def get_external_length_units(self):
        return 1.0

    def get_axis_mask(self):
        return 7  # X Y Z

    def get_block_delete(self):
        return False

    def check_abort(self):
        return False

    def ignore(self, *args):
        pass

    # the frequent
    next_line = straight_traverse = straight_feed = arc_feed = dwell = set_feed_rate = comment = (
        ignore
    )

    def __getattr__(self, name):
        return self.ignore  # the rare


class CountingCanon(Canon):
    motions = 0

    def count(self, *args):
        self.motions += 1

    straight_traverse = straight_feed = arc_feed = dwell = count


def main():
    with tempfile.TemporaryDirectory() as folder:
        canon = (CountingCanon if "--count" in sys.argv else Canon)(folder)
        result, line = gcode.parse(sys.argv[1], canon, "G21", "")
    if result > gcode.MIN_ERROR:
        sys.exit(f"line {line}: {gcode.strerror(result)}")
    if isinstance(canon, CountingCanon):
        print(canon.motions)


main()
