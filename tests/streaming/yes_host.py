"""A receiver on a pseudo-terminal that takes everything at once: for figures of the sender alone
(memory, lines a second)."""

from __future__ import annotations

import contextlib
import os
import re
import select
import subprocess
import sys
import threading
import time
import tty
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PLACE = re.compile(rb"X(-?[0-9.]+)\s*Y(-?[0-9.]+)\s*Z(-?[0-9.]+)")
ZERO = (0.0, 0.0, -200.0)
ANSWERS = {
    b"$I": b"[VER:1.1h.20190825:]\r\n[OPT:V,15,1024]\r\n",
    b"$$": b"$13=0\r\n$22=0\r\n$110=3000\r\n",
    b"$#": b"[G54:0.000,0.000,-200.000]\r\n[TLO:0.000]\r\n",
    b"$G": b"[GC:G0 G54 G17 G21 G90 G94 M5 M9 T0 F0 S0]\r\n",
}


class YesHost:
    """`path` is the port; lines: how many were taken; received: they themselves, where `keep` says
    so."""

    def __init__(self, keep: bool = False) -> None:
        self.keep, self.received = keep, list[bytes]()
        self.master, self._slave = os.openpty()
        tty.setraw(self._slave)
        self.path = os.ttyname(self._slave)
        self.lines, self._stop, self._rest, self._place = 0, False, b"", ZERO
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self) -> YesHost:
        self._thread.start()
        return self

    def __exit__(self, *_) -> None:
        self._stop = True
        self._thread.join(5)
        os.close(self.master), os.close(self._slave)

    def _run(self) -> None:
        while not self._stop:
            if not select.select([self.master], [], [], 0.05)[0]:
                continue
            data = self._rest + os.read(self.master, 65536)
            asked = data.count(b"?")
            *lines, self._rest = data.replace(b"?", b"").split(b"\n")
            found = PLACE.findall(data)
            if found:
                self._place = tuple(float(v) + z for v, z in zip(found[-1], ZERO, strict=True))
            self.lines += len(lines)
            if self.keep:
                self.received += lines
            back = b"".join(ANSWERS.get(line, b"") + b"ok\r\n" for line in lines)
            if asked:
                back += b"<Idle|MPos:%.3f,%.3f,%.3f|FS:0,0>\r\n" % self._place
            while back:
                with contextlib.suppress(BlockingIOError):
                    back = back[os.write(self.master, back) :]


def rows(n: int) -> Iterator[str]:
    """n lines of motion on the example mill, every word on every line."""
    yield "G90 G21 G94 G17 G54\n"
    for i in range(n):
        yield f"G1 X{i * 7 % 2000 / 10:.3f} Y{i * 3 % 1500 / 10:.3f} Z{i % 90 / 10:.3f} F3000\n"


def measure(n: int, folder: Path, *options: str) -> tuple[float, float, int]:
    """Peak memory of a job of n lines in MB, its seconds, and the lines that were taken. Raises
    where it did not end well."""
    with open(folder / "job.nc", "w") as file:
        file.writelines(rows(n))
    started = time.monotonic()
    with YesHost() as host:
        peak = send(host, folder, *options)
        return peak, time.monotonic() - started, host.lines


def send(host: YesHost, folder: Path, *options: str) -> float:
    """Let gcomp send job.nc; its peak memory in MB. Raises where that did not end well."""
    with open(folder / "err", "w+") as err:
        process = subprocess.Popen(
            [
                sys.executable,
                "-m",
                "postproc",
                "stream",
                "--machine",
                "example-mill",
                "--dialect",
                "grbl",
                "--port",
                host.path,
                "--check-first",
                "never",
                *options,
                "job.nc",
            ],
            cwd=folder,
            stdout=subprocess.DEVNULL,
            stderr=err,
            env={**os.environ, "PYTHONPATH": str(ROOT)},
        )
        peak = 0.0
        while process.poll() is None:
            peak = max(peak, peak_of(process.pid))
            time.sleep(0.02)
        if process.returncode:
            err.seek(0)
            raise RuntimeError(err.read()[-2000:])
        return peak


def peak_of(process: int) -> float:
    """MB that a running process has had at most. (What wait4 says of a child is at least what its
    parent had when it was begun.)"""
    try:
        found = re.search(r"VmHWM:\s*(\d+) kB", Path(f"/proc/{process}/status").read_text())
    except OSError:
        return 0.0
    return int(found[1]) / 1024.0 if found else 0.0
