"""The side of the oracle that loads LinuxCNC: programs in, canonical motions out.

Run by oracle.py, never imported by a test: `python3.11 canon.py RESULTS < jobs.json`. Each program
runs in a child of its own (fork), so one that makes the interpreter crash, or leave a mode behind,
harms no other. One JSON line per program is written to RESULTS; standard output belongs to the
interpreter, which chatters.
"""

import ctypes
import hashlib
import json
import math
import os
import re
import resource
import shutil
import subprocess
import sys

import gcode

MM_PER_INCH = 25.4
AXES = 9  # X Y Z A B C U V W, as the interpreter passes them
LENGTH = (0, 1, 2, 6, 7, 8)  # which of them are lengths
LINE_LENGTH = 252
SECONDS = 3  # of processor time, for one program
MEMORY = 2 << 30
# name; first, second, normal axis
PLANES = {1: ("XY", 0, 1, 2), 2: ("YZ", 1, 2, 0), 3: ("ZX", 2, 0, 1)}
# A fresh interpreter takes its position as zero of the *program*, and a feed of 1 as given. Put the
# machine at machine zero, as after homing, and take back what that needs: G0 as motion mode, and
# the feed.
START = ("G21 G53 G0 X0 Y0 Z0 A0 B0 C0", "G80 F0")
NO_TOOL = (-1, *[0.0] * 12, 0)
MAP = ".tool.mmap"  # of tools, in $HOME
TOOL_WORDS = "XYZABCUVWDIJQ"  # of a tool table, in the order get_tool answers


class Canon:
    """What the interpreter calls. It speaks inches and program coordinates; `motions` are mm and
    machine."""

    def __init__(self, parameter_file, block_delete, tools):
        self.parameter_file = parameter_file
        self.block_delete = block_delete
        self.tools = [NO_TOOL, *(tool_entry(number, words) for number, words in tools.items())]
        self.motions = []
        self.started = False  # becomes true with START's own motion, which is not the program's
        self.line = 0
        self.plane = 1
        self.g5x = self.g92 = self.tool = (0.0,) * AXES
        self.rotation = 0.0  # degrees, about Z
        self.program = (0.0,) * AXES  # last end, program coordinates
        self.machine = (0.0,) * AXES  # the same point, machine coordinates
        self.missing = None  # line, what this oracle does not translate, motions before it

    # -- what the interpreter asks

    def get_block_delete(self):
        return self.block_delete

    def get_axis_mask(self):
        return 0b111111  # XYZABC

    def get_external_length_units(self):
        return 1.0  # user units per mm: a metric machine, parameters in mm

    def get_external_angular_units(self):
        return 1.0  # user units per degree

    def get_tool(self, pocket):
        return self.tools[pocket] if 0 <= pocket < len(self.tools) else NO_TOOL

    def check_abort(self):
        return False

    # -- what it tells

    def next_line(self, state):
        if state.sequence_number > 0:  # the moves of G70 to G73 are counted as line -1
            self.line = state.sequence_number

    def set_plane(self, plane):
        self.plane = plane

    def set_g5x_offset(self, index, *offset):
        self.g5x = millimetres(offset)

    def set_g92_offset(self, *offset):
        self.g92 = millimetres(offset)

    def change_tool(self, pocket):
        self.tools[0] = self.get_tool(pocket) if pocket > 0 else NO_TOOL  # 0 is the spindle

    def tool_offset(self, *offset):
        self.tool = millimetres(offset)

    def set_xy_rotation(self, degrees):
        self.rotation = degrees

    def straight_traverse(self, *end):
        self.moved("rapid", millimetres(end))

    def straight_feed(self, *end):
        self.moved("feed", millimetres(end))

    def arc_feed(self, end_1, end_2, centre_1, centre_2, turns, end_normal, *rest):
        plane, first, second, normal = PLANES[self.plane]
        end, centre = [0.0] * 3, list(self.program[:3])
        end[first], end[second], end[normal] = end_1, end_2, end_normal
        end = millimetres((*end, *rest))
        centre[first], centre[second] = centre_1 * MM_PER_INCH, centre_2 * MM_PER_INCH
        centre = self.to_machine((*centre, *end[3:]))
        if self.rotation and self.plane != 1 and self.missing is None:
            self.missing = (
                self.line,
                "an arc outside XY while the coordinate system is rotated",
                list(self.motions),
            )
        self.moved("arc", end, plane=plane, centre=(centre[first], centre[second]), turns=turns)

    def dwell(self, seconds):
        self.moved("dwell", self.program, seconds=seconds)

    def straight_probe(self, *end):
        """As if it tripped just where it ends."""
        self.moved("probe", millimetres(end))

    def rigid_tap(self, *end):
        """Down and back: where it returns to is where the interpreter goes on from."""
        machine = self.machine
        there = self.to_machine((*millimetres(end), *(0.0,) * (AXES - len(end))))
        for end in (*there[:3], *machine[3:]), machine:
            self.motions.append(
                {"line": self.line, "kind": "feed", "start": self.machine[:6], "end": end[:6]}
            )
            self.machine = end

    def user_defined_function(self, *arguments):
        pass

    def ignore(self, *arguments):
        pass

    comment = message = set_feed_rate = set_traverse_rate = set_feed_mode = ignore

    # -- bookkeeping

    def to_machine(self, point):
        """G92, then the rotation, then G5x, then the tool: the order of LinuxCNC's own
        controller."""
        x, y, *others = (p + offset for p, offset in zip(point, self.g92))
        if self.rotation:
            cosine, sine = (
                math.cos(math.radians(self.rotation)),
                math.sin(math.radians(self.rotation)),
            )
            x, y = x * cosine - y * sine, x * sine + y * cosine
        return tuple(p + g5x + tool for p, g5x, tool in zip((x, y, *others), self.g5x, self.tool))

    def moved(self, kind, end, **more):
        start = self.machine
        if kind != "dwell":  # an offset change moves nothing: only a motion sets a new position
            self.program, self.machine = end, self.to_machine(end)
        if self.started:
            self.motions.append(
                {
                    "line": self.line,
                    "kind": kind,
                    "start": start[:6],
                    "end": self.machine[:6],
                    **more,
                }
            )
        self.started = True


def millimetres(point):
    """Scale the lengths of a nine-axis point from inches; angles stay."""
    return tuple(p * MM_PER_INCH if axis in LENGTH else p for axis, p in enumerate(point))


def tool_entry(number, words):
    values = [words.get(letter, 0.0) for letter in TOOL_WORDS]
    return (int(number), *map(float, values[:-1]), int(values[-1]))


def tool_map(maps, tools, rs274):
    """Path of the map that `rs274 -t` makes in $HOME of a tool table, as LinuxCNC's controller
    would have made it; of equal tables in one folder of `maps`, since rs274 takes four times as
    long as a program."""
    lines = []
    for number, tool in tools.items():
        words = " ".join(f"{letter}{value!r}" for letter, value in tool.items())
        lines.append(f"T{number} P{number} {words}\n")
    text = "".join(lines)
    home = os.path.join(maps, hashlib.sha256(text.encode()).hexdigest())
    made = os.path.join(home, MAP)
    if not os.path.exists(made):
        os.makedirs(home)
        table, nothing = os.path.join(home, "tool.tbl"), os.path.join(home, "nothing.ngc")
        with open(table, "w") as out:
            out.write(text)
        with open(nothing, "w") as out:
            out.write("M2\n")
        subprocess.run(
            [rs274, "-g", "-t", table, nothing],
            cwd=home,
            env={**os.environ, "HOME": home},
            check=True,
            stdout=subprocess.DEVNULL,
        )
    return made


def attach_tool_table(home, made):
    """Give the interpreter a tool table, its own copy of the map `made`. Without one it crashes on
    the first T, M6 or G43."""
    shutil.copyfile(made, os.path.join(home, MAP))
    ctypes.CDLL("libtooldata.so.0")["_Z14tool_mmap_userv"]()


def uses_tools(text):
    return (
        re.search(r"(?i)[th]\s*\d|m\s*0*61?\b|g\s*(4[123]|10)|[tmgh]\s*[#[]|#\s*54[01]", text)
        is not None
    )


def first_line_too_long(text):
    """The interpreter skips a first line of more than 252 characters in silence (any other is an
    error)."""
    return len(text.split("\n", 1)[0].rstrip("\r").encode()) > LINE_LENGTH


def run(job, home, tools):
    """Run one program, tools: its map of tools or None; {"motions": ...} or {"error": ..., "line":
    ..., "motions": those before}."""
    program, parameters = os.path.join(home, "program.ngc"), os.path.join(home, "parameters.var")
    with open(program, "w", newline="") as out:
        out.write(job["text"])
    with open(parameters, "w") as out:
        out.writelines(
            f"{number} {value!r}\n" for number, value in sorted(job["parameters"].items())
        )
    if first_line_too_long(job["text"]):
        return {"error": "Command too long", "line": 1, "motions": []}
    os.environ["HOME"] = home
    os.chdir(home)
    if tools:
        attach_tool_table(home, tools)
    canon = Canon(parameters, job["block_delete"], job["tools"])
    result, _ = gcode.parse(program, canon, *START)
    if canon.missing is not None:
        line, reason, before = canon.missing
        return {"error": f"not covered by the oracle: {reason}", "line": line, "motions": before}
    # canon.line: the line number gcode.parse returns is one too high at times
    if result > gcode.MIN_ERROR:
        return {"error": gcode.strerror(result), "line": canon.line, "motions": canon.motions}
    return {"motions": canon.motions}


def run_in_child(job, home, tools):
    """`run`, in a fork; the answer comes back through a file."""
    os.makedirs(home)
    answer = os.path.join(home, "answer.json")
    child = os.fork()
    if child == 0:
        status = 1
        resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS))  # some programs never end
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        try:
            outcome = run({**job, "parameters": dict(job["parameters"])}, home, tools)
            with open(answer, "w") as out:
                json.dump(outcome, out)
            status = 0
        finally:
            os._exit(status)  # no clean-up: the interpreter's own destructors are not safe
    _, status = os.waitpid(child, 0)
    if status:
        return {
            "error": f"LinuxCNC's interpreter died (wait status {status})",
            "line": 0,
            "motions": [],
        }
    with open(answer) as source:
        return json.load(source)


def main():
    results, rs274 = sys.argv[1:]
    home = os.environ["HOME"]
    with open(results, "w") as out:
        for i, job in enumerate(json.load(sys.stdin)):
            needed = job["tools"] or uses_tools(job["text"])
            tools = tool_map(os.path.join(home, "tools"), job["tools"], rs274) if needed else None
            json.dump(run_in_child(job, os.path.join(home, str(i)), tools), out)
            out.write("\n")


if __name__ == "__main__":
    main()
