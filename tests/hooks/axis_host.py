"""AXIS with a filter, driven as a person would: `/usr/bin/python3.11 axis_host.py FOLDER`.

Run by test_axis.py in namespaces of its own, where LinuxCNC and Xvfb lie over /usr; nothing of
gcomp is imported here. FOLDER holds filter.txt (lines for [FILTER]), good.ngc and bad.ngc. Prints
one JSON object: opened, what AXIS has loaded of good.ngc; said, the text of its window when
bad.ngc is opened; then, what is loaded after that. Where a call of X or Tk does not come back, it
says which on standard error ("Timeout") and ends.
"""

import faulthandler
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
import tkinter
from pathlib import Path

SAMPLE = Path("/usr/share/doc/linuxcnc/examples/sample-configs/sim/axis")
START = 60.0  # s
HANGS = 170.0  # s; it takes 2 on an idle computer, 9 under a load of 8
TEXTS = """proc texts w {
    set found ""
    if {[winfo class $w] eq "Text"} {append found [$w get 0.0 end]}
    foreach c [winfo children $w] {append found [texts $c]}
    return $found
}"""


def until(holds, what):
    end = time.monotonic() + START
    while time.monotonic() < end:
        found = holds()
        if found:
            return found
        time.sleep(0.05)
    log = Path("log")
    raise SystemExit(f"{what} does not come: {log.read_text()[-2000:] if log.exists() else ''}")


def configured(folder):
    """A simulated mill with our filter, which opens good.ngc when it starts."""
    (folder / "axis").mkdir()
    for file in filter(Path.is_file, SAMPLE.iterdir()):
        shutil.copy(file, folder / "axis")
    text = (SAMPLE / "axis_mm.ini").read_text()
    text = text.replace("[FILTER]\n", "[FILTER]\n" + (folder / "filter.txt").read_text())
    opens = [
        f"OPEN_FILE = {folder}/good.ngc" if x.startswith("OPEN_FILE") else x
        for x in text.splitlines()
    ]
    if opens == text.splitlines():
        opens = text.replace(
            "[DISPLAY]\n", f"[DISPLAY]\nOPEN_FILE = {folder}/good.ngc\n"
        ).splitlines()
    (folder / "axis" / "gcomp.ini").write_text("\n".join(opens) + "\n")
    return folder / "axis"


def screen(folder):
    """A display of its own, its name in DISPLAY."""
    read, write = os.pipe()
    command = ["Xvfb", "-displayfd", str(write), "-screen", "0", "1280x900x24", "-nolisten", "tcp"]
    subprocess.Popen(
        command, pass_fds=[write], stdout=open(folder / "xvfb", "w"), stderr=subprocess.STDOUT
    )
    os.environ["DISPLAY"] = ":" + os.read(read, 16).decode().strip()


def loaded():
    import linuxcnc

    state = linuxcnc.stat()
    state.poll()
    return state.file


class Again:
    """A command, started again for as long as it fails."""

    def __init__(self, command):
        self.command = command
        self.process = subprocess.Popen(command)

    def runs(self):
        if self.process.poll():
            self.process = subprocess.Popen(self.command)
        return True


def main(folder):
    faulthandler.dump_traceback_later(HANGS, exit=True)
    os.chdir(configured(folder))
    screen(folder)
    subprocess.Popen(
        ["linuxcnc", "gcomp.ini"],
        stdin=subprocess.DEVNULL,
        stdout=open("log", "w"),
        stderr=subprocess.STDOUT,
    )
    remote = tkinter.Tk()
    remote.withdraw()

    def asked(script):
        try:
            return remote.tk.call("send", "axis", script)
        except tkinter.TclError:
            return ""

    until(lambda: asked("expr 1"), "AXIS")
    opened = until(lambda: loaded().endswith("good.ngc") and loaded(), "the first program")
    answer = {"opened": Path(opened).read_text()}
    # A screen that still starts refuses what it is asked, with an exit code; when it has taken
    # the program, axis-remote waits until the window is closed.
    second = Again(["axis-remote", str(folder / "bad.ngc")])
    # Tk takes all scripts that have arrived meanwhile at once, and runs one after the other: one
    # of ours beside that of axis-remote would wait until somebody closes the window. So none is
    # sent before AXIS has begun to filter the program.
    until(
        lambda: second.runs() and any(Path(tempfile.gettempdir()).glob("*/bad.ngc")),
        "the filter of the second program",
    )
    answer["said"] = until(
        lambda: asked(TEXTS + "; if {[winfo exists .error]} {texts .error}"),
        "the message of the second program",
    )
    answer["then"] = Path(loaded()).read_text()
    print(json.dumps(answer), flush=True)


main(Path(sys.argv[1]))
os._exit(0)  # process 1 of its namespace: all that it started ends with it
