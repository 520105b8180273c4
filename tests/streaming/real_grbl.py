"""A real GRBL 1.1h image with motion behind a pseudo-terminal, in real time; what its motors did,
step by step.

The image and its host lie beside the project (../shared/receivers); without them nothing here can
run.
"""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import subprocess
import sys
import threading
import time
from collections import deque
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
RECEIVERS = ROOT.parent / "shared" / "receivers"
STEPS = 250.0  # a mm, of ee_router.bin
RECORD = np.dtype([("cycle", "<u8"), ("at", "<i4", 3), ("pad", "<u4")])
PATIENCE = 60.0  # s
BEHIND = (
    # s: a simulator that lost more against the clock, within ten seconds, was starved, and says
    # nothing of gcomp
    0.5
)
SPAN = 10.0  # s
STAT = 0.2  # s: so often its clock is written


def missing() -> str:
    """Why it can not run here, or ""."""
    if not (RECEIVERS / "grblhost").exists():
        return "../shared/receivers is not here"
    done = subprocess.run([RECEIVERS / "grblhost", "-elf", "none"], capture_output=True, text=True)
    return "" if "no elf" in done.stderr else f"its host does not run: {done.stderr.strip()[:100]}"


class RealGrbl:
    """`path` is the port; folder: where the files go. options: of grblhost ("-dtr"). lost: `behind`
    of the last one."""

    lost = 0.0

    def __init__(self, folder: Path, *options: str, eeprom: str = "ee_router.bin"):
        self.folder, self.path = folder, str(folder / "port")
        self.behind = 0.0  # s by which it fell behind the clock at most within SPAN
        self._fifo, self._trace = folder / "ctl", folder / "t.bin"
        shutil.copy(RECEIVERS / eeprom, folder / "ee.bin")
        os.chmod(folder / "ee.bin", 0o644)
        files = (
            "-eeprom",
            "ee.bin",
            "-trace",
            "t.bin",
            "-rx",
            "rx.bin",
            "-stat",
            "s.json",
            "-events",
            "ev.txt",
        )
        self._command = [
            str(RECEIVERS / "grblhost"),
            "-elf",
            str(RECEIVERS / "grbl_1.1h_uno.elf"),
            "-link",
            "port",
            *files,
            "-ctl",
            "ctl",
            *options,
        ]

    def __enter__(self) -> RealGrbl:
        self._process = subprocess.Popen(self._command, cwd=self.folder, stderr=subprocess.DEVNULL)
        deadline = time.monotonic() + PATIENCE
        while not (os.path.exists(self.path) and self._fifo.exists()):
            assert time.monotonic() < deadline and self._process.poll() is None
            time.sleep(0.02)
        time.sleep(0.5)  # it starts
        self._watching = threading.Thread(target=self._watch, daemon=True)
        self._watching.start()
        return self

    def _watch(self) -> None:
        """How much time the simulator lost: its own clock beside the wall's."""
        seen: deque[tuple[float, float]] = deque()
        while self._process.poll() is None:
            with contextlib.suppress(OSError, ValueError, KeyError):
                ran = json.loads((self.folder / "s.json").read_text())["avr_s"]
                lost = time.monotonic() - ran
                seen.append((time.monotonic(), lost))
                while seen[0][0] < seen[-1][0] - SPAN:
                    seen.popleft()
                RealGrbl.lost = self.behind = max(
                    self.behind, lost - min(v for _, v in seen) - STAT
                )
            time.sleep(0.1)

    def __exit__(self, *_) -> None:
        with contextlib.suppress(OSError):
            self.tell("quit")
        try:
            self._process.wait(5)
        except subprocess.TimeoutExpired:
            self._process.kill()

    def tell(self, command: str) -> None:
        """A cable cut, the power, a button: as grblhost's notes say."""
        fd = os.open(self._fifo, os.O_WRONLY | os.O_NONBLOCK)
        os.write(fd, command.encode() + b"\n")
        os.close(fd)
        time.sleep(0.05)

    def talk(self, *lines: str, seconds: float = 1.0) -> str:
        """Say something to it as another program would, and hear the answer."""
        import serial

        with serial.Serial(self.path, 115200, timeout=0.1) as port:
            heard = b""
            for line in lines:
                port.write(line.encode() + b"\n")
                deadline = time.monotonic() + seconds
                while time.monotonic() < deadline and not heard.endswith(b"ok\r\n"):
                    heard += port.read(4096)
                heard += b"|"
        return heard.decode("latin-1")

    def steps(self) -> np.ndarray:
        """(N, 3) whole steps since power-up of the motors, one row a step pulse."""
        self.tell("stat")
        time.sleep(0.1)
        data = self._trace.read_bytes()
        rows = np.frombuffer(data[: len(data) // RECORD.itemsize * RECORD.itemsize], RECORD)
        return rows["at"].astype(float)

    def rest(self) -> None:
        """Until no step has come for a while."""
        n, deadline = -1, time.monotonic() + PATIENCE
        while n != (n := len(self.steps())):
            assert time.monotonic() < deadline
            time.sleep(0.5)


def start(
    folder: Path, port: str, *arguments: str, machine: str = "perfect", stdin=subprocess.DEVNULL
):
    """gcomp stream as a process."""
    return subprocess.Popen(
        [
            sys.executable,
            "-m",
            "postproc",
            "stream",
            "--machine",
            machine,
            "--dialect",
            "grbl",
            "--port",
            port,
            "--check-first",
            "never",
            *arguments,
        ],
        cwd=folder,
        stdin=stdin,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={
            **os.environ,
            "PYTHONPATH": str(ROOT),
            "HOME": str(folder),
            "XDG_CONFIG_HOME": str(folder),
        },
    )


def stream(folder: Path, port: str, *arguments: str, **how) -> tuple[int, str]:
    """Exit status, and what it said."""
    _, err = (process := start(folder, port, *arguments, **how)).communicate(timeout=300)
    assert "Traceback" not in err, err
    return process.returncode, err


def in_order(steps: np.ndarray, vertices: np.ndarray, within: float) -> int:
    """How many of the vertices (M, 3; steps) the motors came by, in order, within so many steps."""
    at = 0
    for n, vertex in enumerate(vertices):
        near = np.flatnonzero(np.abs(steps[at:] - vertex).max(axis=1) <= within)
        if not len(near):
            return n
        at += int(near[0])
    return len(vertices)
