"""LinuxCNC without a display, driven over standard input: `/usr/bin/python3.11 headless_host.py
FOLDER '{"parameters": ..., "tools": ...}'`.

Run by headless.py in namespaces of its own, never imported by a test; nothing of gcomp is imported
here. Starts the server of messages, io, motion and task as LinuxCNC's own launcher does, then
answers one JSON line for each that comes in:

- {"program": text}: run in auto mode; at every M0 the joints are read and the program resumed
- {"mdi": [line, ...]}: one line after the other in MDI mode, the joints read behind each

Ends with standard input. Being process 1 of its namespace, it takes all that it started with it.
"""

import contextlib
import json
import os
import subprocess
import sys
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
INI, HAL = str(HERE / "headless.ini"), str(HERE / "headless.hal")
START = 30.0  # s, for a part of it to come up
OVERRIDE = 50.0  # of the feed: the machine is fast, the programs are a mill's
STALL = 20.0  # s without any change
BEHIND = 1e-9  # mm


class Trouble(Exception):
    """What LinuxCNC says, or does not do."""


def start(folder, parameters, tools):
    """All processes of the controller, their chatter in FOLDER/log; returns once they answer."""
    os.chdir(folder)
    lines = (
        f"{number}\t{value:.6f}\n"
        for number, value in sorted((int(n), v) for n, v in parameters.items())
    )
    Path("parameters.var").write_text("".join(lines))
    Path("tool.tbl").write_text(
        "".join(f"T{number} P{number} Z{length}\n" for number, length in tools.items())
    )
    log = open("log", "w")

    def run(*command):
        subprocess.run(
            command, stdin=subprocess.DEVNULL, stdout=log, stderr=log, check=True, timeout=START
        )

    def stay(*command):
        return subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=log, stderr=log)

    # leaves a process of its own behind once the channels are there
    run("linuxcncsvr", "-ini", INI)
    run("halcmd", "loadusr", "-Wn", "iocontrol", "io", "-ini", INI)
    run("halcmd", "-i", INI, "-f", HAL)
    task = stay("milltask", "-ini", INI)
    run("halcmd", "start")
    return task


class Machine:
    """The channels to a running controller."""

    def __init__(self, task):
        import linuxcnc  # only here: it needs the libraries that are laid over /usr

        self.lib, self.task = linuxcnc, task
        until = time.monotonic() + START
        while True:
            try:
                self.stat, self.command, self.errors = (
                    linuxcnc.stat(),
                    linuxcnc.command(),
                    linuxcnc.error_channel(),
                )
                self.stat.poll()
                break
            except linuxcnc.error:
                if time.monotonic() > until or task.poll() is not None:
                    raise Trouble("task does not come up") from None
                time.sleep(0.02)

    def prepare(self):
        """Out of emergency stop, on, and homed where it stands (zero)."""
        self.done(self.command.state, self.lib.STATE_ESTOP_RESET)
        self.done(self.command.state, self.lib.STATE_ON)
        for joint in range(3):
            self.done(self.command.home, joint)
        self.wait(lambda: all(self.stat.homed[:3]), "homing")
        self.command.feedrate(OVERRIDE)

    def done(self, command, *arguments):
        """Give a command and wait for its end."""
        command(*arguments)
        answer = self.command.wait_complete(STALL)
        self.look()
        if answer != self.lib.RCS_DONE:
            raise Trouble(f"{command.__name__}{arguments} ends with {answer}")

    def look(self):
        """Read the state; what the controller complains of is an exception."""
        self.stat.poll()
        message = self.errors.poll()
        if message and message[0] in (self.lib.NML_ERROR, self.lib.OPERATOR_ERROR):
            raise Trouble(message[1].strip())
        if self.task.poll() is not None:
            raise Trouble(f"task ended with {self.task.returncode}")

    def forget(self):
        """Drop what is still said of a program that was given up."""
        with contextlib.suppress(self.lib.error):
            self.command.abort()
            self.command.wait_complete(1.0)
        until = time.monotonic() + 0.2
        while self.errors.poll() or time.monotonic() < until:
            time.sleep(0.005)

    def wait(self, holds, what):
        """Until `holds()`; a controller that does not change for STALL seconds is an exception."""
        last, until = None, time.monotonic() + STALL
        while True:
            self.look()
            if holds():
                return
            if (seen := (self.stat.motion_line, self.stat.read_line, self.joints())) != last:
                last, until = seen, time.monotonic() + STALL
            if time.monotonic() > until:
                raise Trouble(f"{what}: nothing changes, {self.state()}")
            time.sleep(0.001)

    def state(self):
        """What decides whether it stands, for a message."""
        s = self.stat
        return (
            f"at line {s.motion_line}: interpreter {s.interp_state}, command {s.echo_serial_number}"
            f" of {self.command.serial}, state {s.state}, in position {s.inpos}, queue {s.queue},"
            f" to go {s.distance_to_go}, joints {self.joints()}, position {s.position[:3]}"
        )

    def joints(self):
        """(3,) mm: the feedback, not the command."""
        return list(self.stat.joint_actual_position[:3])

    def begin(self, text):
        Path("program.ngc").write_text(text)
        self.done(self.command.mode, self.lib.MODE_AUTO)
        self.done(self.command.program_open, "program.ngc")
        self.command.auto(self.lib.AUTO_RUN, 0)
        self.command.wait_complete(0.01)
        self.wait(
            lambda: self.stat.interp_state != self.lib.INTERP_IDLE or self.stat.motion_line > 0,
            "start",
        )

    def still(self):
        """It stands: nothing to go, and the joints, which follow the planner a few periods behind,
        are there."""
        behind = max(abs(a - b) for a, b in zip(self.joints(), self.stat.position))
        return (
            self.stat.inpos
            and self.stat.queue == 0
            and self.stat.distance_to_go == 0.0
            and behind < BEHIND
        )

    def idle(self):
        return self.stat.interp_state == self.lib.INTERP_IDLE and self.still()

    def program(self, text):
        """Auto mode; [(line of the motion before, joints)] at every M0, and the joints at the
        end."""
        self.begin(text)
        stops, given = [], self.command.serial

        def stopped():
            # Once the resumption is echoed, a pause is the next one.
            paused = (
                self.stat.interp_state == self.lib.INTERP_PAUSED
                and self.stat.echo_serial_number == given
            )
            return self.idle() or (paused and self.still())

        while True:
            self.wait(stopped, "auto")
            if self.idle():
                return {"stops": stops, "end": self.joints()}
            stops.append((self.stat.motion_line, self.joints()))
            self.command.auto(self.lib.AUTO_RESUME)
            given = self.command.serial

    def mdi(self, lines):
        """MDI, each line given when the one before is done; the joints behind each."""
        self.done(self.command.mode, self.lib.MODE_MDI)
        reached = []
        for line in lines:
            self.done(self.command.mdi, line)
            self.wait(self.still, "MDI")
            reached.append(self.joints())
        return {"reached": reached}


def answer(machine, request):
    [(kind, argument)] = request.items()
    try:
        return {"program": machine.program, "mdi": machine.mdi}[kind](argument)
    except Trouble as trouble:
        machine.forget()
        return {"trouble": str(trouble)}


def main(folder, settings):
    task = start(folder, settings.get("parameters", {}), settings.get("tools", {}))
    machine = Machine(task)
    machine.prepare()
    print(json.dumps({"ready": machine.lib.version}), flush=True)
    for line in sys.stdin:
        print(json.dumps(answer(machine, json.loads(line))), flush=True)


if __name__ == "__main__":
    try:
        main(sys.argv[1], json.loads(sys.argv[2]) if len(sys.argv) > 2 else {})
    except (Trouble, OSError, subprocess.SubprocessError) as trouble:
        print(json.dumps({"trouble": f"LinuxCNC does not start: {trouble}"}), flush=True)
