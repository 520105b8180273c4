"""gcomp, printcore and grbl-streamer against the same models of controllers, with the same seeded
faults: what does each lose?

    python benchmarks/streaming.py --fetch --jobs 20
    python benchmarks/streaming.py --memory 10000 1000000       # instead: peak memory of gcomp, and
                                                                lines a second

The models are those of the tests (tests/streaming): Marlin with its checks and its buffer of 128
bytes, GRBL with a buffer that drops. Each job is a process of its own on a pseudo-terminal. A
sender that says nothing for --limit seconds is stopped: it hangs. "executed otherwise" counts jobs
of which the controller executed another program than the one sent; "and said done" those of them
that ended as a success: a spoiled part that goes unnoticed.
"""

from __future__ import annotations

import argparse
import os
import random
import re
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from tests.streaming.bench import Faults, zigzag  # noqa: E402
from tests.streaming.grbl_model import GrblModel  # noqa: E402
from tests.streaming.models_marlin import MarlinModel  # noqa: E402
from tests.streaming.pty_host import PtyHost  # noqa: E402
from tests.streaming.yes_host import measure  # noqa: E402

CACHE = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "gcomp" / "senders"
AXIS_WORD = re.compile(r"([XYZ])(-?[0-9]+\.?[0-9]*|-?\.[0-9]+)")
LINES = 120
FEED = 6000  # mm/min
SPEED = 2.0  # model seconds in a second
KINDS = {
    "no faults": lambda r: Faults(),
    "one byte damaged, to the controller": lambda r: Faults(
        to={r.randrange(400, 3000): r.choice(("drop", "flip", "double"))}, random=r
    ),
    "one byte damaged, to the controller, slow feed": lambda r: Faults(
        to={r.randrange(400, 3000): r.choice(("drop", "flip", "double"))}, random=r
    ),
    "one byte damaged, from the controller": lambda r: Faults(
        back={r.randrange(100, 500): r.choice(("drop", "flip", "double"))}, random=r
    ),
    "restart in the middle": lambda r: Faults(),
}


@dataclass
class Row:
    jobs: int = 0
    right: int = 0
    said: int = 0
    wrong: int = 0
    lies: int = 0
    hangs: int = 0
    seconds: list[float] = field(default_factory=list)


def fetch() -> None:
    """Both peers into an environment of their own. printrun's GUI dependencies are left out."""
    if not (CACHE / "complete").exists():
        subprocess.run([sys.executable, "-m", "venv", CACHE], check=True)
        pip = [
            CACHE / "bin" / "python",
            "-m",
            "pip",
            "install",
            "-q",
            "--disable-pip-version-check",
        ]
        subprocess.run([*pip, "pyserial", "grbl-streamer"], check=True)
        subprocess.run([*pip, "--no-deps", "printrun"], check=True)
        (CACHE / "complete").touch()


def command(sender: str, control: str, port: str, path: Path) -> list[str]:
    if sender == "gcomp":
        return [
            sys.executable,
            "-m",
            "postproc",
            "stream",
            str(path),
            "--machine",
            "perfect",
            "--dialect",
            control,
            "--protocol",
            control,
            "--port",
            port,
            "--no-journal",
            "--quiet",
            "--check-first",
            "never",
        ]
    return [
        str(CACHE / "bin" / "python"),
        str(ROOT / "benchmarks" / f"peer_{sender.replace('-', '_')}.py"),
        port,
        str(path),
    ]


def job(
    sender: str, control: str, kind: str, seed: int, limit: float, folder: Path
) -> tuple[bool, bool, bool, float]:
    """Whether the program was executed as it is, whether success was said, whether it hung, and its
    seconds."""
    r = random.Random(f"{control} {kind} {seed}")
    text = (
        zigzag(LINES, seed=seed, feed=FEED // 10 if "slow" in kind else FEED)[0]
        .replace(" ", "")
        .replace("G21G90G94", "G90")
    )
    path = folder / "job.nc"
    path.write_text(text + "\n")
    model = MarlinModel(says_wait=r.random() < 0.5) if control == "marlin" else GrblModel()
    faults = KINDS[kind](r)
    begun = time.monotonic()
    with PtyHost(model, faults, speed=SPEED) as host:
        if kind == "restart in the middle":
            after(host, r.randrange(20, 100))
        process = subprocess.Popen(
            command(sender, control, host.path, path),
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            cwd=ROOT,
            text=True,
        )
        hung = False
        try:
            out = process.communicate(timeout=limit)[0]
        except subprocess.TimeoutExpired:
            process.kill()
            out, hung = process.communicate()[0], True
        time.sleep(0.2)
    said = not hung and (
        process.returncode == 0 if sender == "gcomp" else out.strip().endswith("done")
    )
    rows = model.executed if control == "marlin" else model.accepted
    return places(rows) == places(text.split("\n")), said, hung, time.monotonic() - begun


def places(rows: list[str]) -> list[tuple[tuple[str, float], ...]]:
    """The axis words of every block that has any, to the um that a machine resolves: senders ask
    questions of their own, write G1 as G01 and repeat feeds, and a nought that is lost does no
    harm."""
    blocks = [
        row.replace(" ", "") for row in rows if row.startswith("G") and not row.startswith("G92")
    ]
    found = [
        tuple((k, round(float(v), 3)) for k, v in AXIS_WORD.findall(block)) for block in blocks
    ]
    return [words for words in found if words]


def after(host: PtyHost, lines: int) -> None:
    """Let the controller restart when it has received so many lines."""
    model, once = host.model, []
    advance = model.advance

    def watched(now: float) -> None:
        advance(now)
        if not once and len(model.received) > lines:
            once.append(1)
            model.restart()

    model.advance = watched  # type: ignore[method-assign]


def memory(counts: list[int]) -> None:
    """Peak memory of a process that corrects and sends, its journal kept, to a receiver that takes
    everything at once."""
    print("| lines | peak MB | lines a second, reading the program twice |")
    print("|---:|---:|---:|")
    for n in counts:
        with tempfile.TemporaryDirectory() as place:
            peak, seconds, lines = measure(n, Path(place))
        print(f"| {n} | {peak:.1f} | {lines / seconds:.0f} |", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--fetch", action="store_true", help="install the peers into the cache first"
    )
    parser.add_argument(
        "--jobs",
        type=int,
        default=10,
        help="jobs of each sender on each model with each kind of fault",
    )
    parser.add_argument("--limit", type=float, default=40.0, help="s after which a job hangs")
    parser.add_argument(
        "--memory",
        type=int,
        nargs="+",
        metavar="LINES",
        help="jobs of so many lines, and their memory",
    )
    options = parser.parse_args()
    if options.memory:
        memory(options.memory)
        return
    if options.fetch:
        fetch()
    senders = {"marlin": ["gcomp", "printcore"], "grbl": ["gcomp", "grbl-streamer"]}
    print(f"{LINES} lines a job, {options.jobs} jobs a row, {options.limit:g} s to finish\n")
    print(
        "| model | fault | sender | executed as sent, and said done | stopped and said so |"
        " executed otherwise | and said done | hangs | median s |"
    )
    print("|---|---|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as place:
        for control, names in senders.items():
            for kind in KINDS:
                for sender in names:
                    if sender != "gcomp" and not (CACHE / "complete").exists():
                        print(
                            f"| {control} | {kind} | {sender} | not installed: --fetch | | | | | |"
                        )
                        continue
                    row = Row()
                    for seed in range(options.jobs):
                        right, said, hung, seconds = job(
                            sender, control, kind, seed, options.limit, Path(place)
                        )
                        row.right += right and said
                        row.said += not said and not hung
                        row.wrong += not right
                        row.lies += said and not right
                        row.hangs += hung
                        row.seconds.append(seconds)
                    median = sorted(row.seconds)[len(row.seconds) // 2]
                    print(
                        f"| {control} | {kind} | {sender} | {row.right} | {row.said} | {row.wrong}"
                        f" | {row.lies} | {row.hangs} | {median:.1f} |",
                        flush=True,
                    )


if __name__ == "__main__":
    main()
