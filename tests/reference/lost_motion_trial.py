"""gcomp on random machines with play on every axis, as a user runs it, judged by a play operator on
each slide.

    python -m tests.reference.lost_motion_trial [--programs N] [--mode step|ramp] [--workers N]

Thirty machines, N programs each (10). Printed are, for each size of the play and altogether, what
is left of the path (um; rms and quantiles by its length), the share of it within tolerance +
hysteresis, the programs whose largest exceeds twice that, and by how much `--verify` says more (+)
or less (-) than what the judge finds, at its least. Then the example of a leaning axis that rests
on the nominal path: there the slide is crept back inside its play.
"""

import argparse
import contextlib
import io
import math
import multiprocessing
import re
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from postproc.cli import main

from .evaluate import Misaligned
from .lost_motion import follow, weighted_quantile
from .machine import UM, Machine
from .random_machines import CHAINS, PLAYS_UM, draw_machine, draw_program
from .samples import flat, write_machine

TOLERANCE = 0.5 * UM  # gcomp's default for machines with an increment of 0.1 um
EXAMPLE = "G0 X0 Y0 Z5\nG1 Z-1 F300\nG1 X100 F800\nG1 X20\nG1 Y100\n"
SAID = (r"lost motion[^0-9]*?([\d.]+) um", r"largest deviation from the nominal path ([\d.]+) um")


@dataclass
class Outcome:
    """One program. mm; distances are rounded to nm and weighed by mm of path."""

    machine: int
    program: int
    play_um: float
    bound: float  # tolerance + hysteresis
    failure: str = ""  # why there is no output, or why it can not be judged
    # what --verify said against its own output; it was then judged without --verify
    refused: str = ""
    said: float | None = None  # by --verify
    largest: float = 0.0
    where: tuple | None = None
    distances: np.ndarray = field(default_factory=lambda: np.zeros(0))
    weights: np.ndarray = field(default_factory=lambda: np.zeros(0))
    blocks: int = 0
    written: int = 0

    def __str__(self):
        return f"machine {self.machine} program {self.program}"


def gcomp(*arguments):
    """(exit status, standard error) of the command line."""
    with (
        contextlib.redirect_stderr(io.StringIO()) as complaint,
        contextlib.redirect_stdout(io.StringIO()),
    ):
        status = main([str(argument) for argument in arguments])
    return status, complaint.getvalue()


def verified(text):
    """mm: what --verify says is left; with lost motion, where it says that."""
    found = [match for pattern in SAID if (match := re.search(pattern, text))]
    return float(found[0][1]) * UM if found else None


def outcome(folder, dialect, text, result, mode):
    """Fill `result`: correct, verify and judge one program on the machine of a folder."""
    machine = Machine.load(folder, measured_at="stood")
    result.bound = TOLERANCE + machine.hysteresis
    with tempfile.TemporaryDirectory() as here:
        source, written = Path(here) / "job.nc", Path(here) / "job_comp.nc"
        source.write_text(text)
        command = ["--machine", folder, "--reversal", mode, "-o", written, source]
        status, complaint = gcomp("--verify", *command)
        result.said = verified(complaint)
        if status:
            result.refused = complaint.strip()
            status, complaint = gcomp(*command)
        if status:
            result.failure = complaint.strip()
            return result
        output = written.read_text()
    result.blocks, result.written = len(text.splitlines()), len(output.splitlines())
    try:
        left = follow(text, output, dialect, machine)
    except Misaligned as fault:
        result.failure = f"misaligned: {fault}"
        return result
    result.largest, result.where = left.largest_mm, left.where
    rounded, place = np.unique(np.round(left.distances / UM, 3), return_inverse=True)
    result.distances, result.weights = rounded * UM, np.bincount(place, left.weights, len(rounded))
    return result


def trial(job):
    """[Outcome] of one machine: (folder, machine number, program numbers, mode)."""
    folder, number, programs, mode = job
    drawn = draw_machine(folder, number)
    return [
        outcome(
            drawn.folder,
            drawn.dialect,
            draw_program(drawn, k),
            Outcome(number, k, drawn.play_um, 0.0),
            mode,
        )
        for k in programs
    ]


def trials(programs, mode, workers=2):
    """[Outcome] of all machines."""
    with (
        tempfile.TemporaryDirectory() as folder,
        multiprocessing.get_context("spawn").Pool(workers) as pool,
    ):
        jobs = [(folder, number, range(programs), mode) for number in range(len(CHAINS))]
        found = [each for some in pool.imap(trial, jobs) for each in some]
        # workers that are stopped instead complain: gcomp has its own answer to that signal
        pool.close()
        pool.join()
    return found


def example(mode):
    """Outcome of the example: Y leans by 400 µrad, X has 40 µm of play."""
    with tempfile.TemporaryDirectory() as folder:
        where = write_machine(
            Path(folder) / "leaning",
            "w-X-Y-b-Z-t",
            flat("XYZ", -1000.0, 1000.0),
            squareness={"C0Y": 400.0},
            offsets={"G54": dict.fromkeys("XYZ", 0.0)},
        )
        with open(where / "machine.toml", "a") as file:
            file.write('\n[[effect]]\nname = "backlash"\naxis = "X"\nsize_um = 40.0\n')
        return outcome(where, "linuxcnc", EXAMPLE, Outcome(-1, 0, 40.0, 0.0), mode)


@dataclass
class Figures:
    """Of some outcomes; mm."""

    programs: int
    rms: float
    p95: float
    p99: float
    largest: float
    within: float  # share of the path's length within the bound
    beyond: int  # programs whose largest exceeds twice the bound
    # the least of what --verify says - what the judge finds; nan: it says nothing
    least_said: float
    most_said: float
    growth: float  # blocks written for each block


def figures(outcomes):
    """Figures of the outcomes that were judged."""
    judged = [each for each in outcomes if not each.failure]
    distances, weights = (
        np.concatenate([np.zeros(0), *(getattr(each, name) for each in judged)])
        for name in ("distances", "weights")
    )
    within = sum(each.weights[each.distances <= each.bound].sum() for each in judged)
    said = [each.said - each.largest for each in judged if each.said is not None]
    total = max(weights.sum(), 1e-12)
    return Figures(
        len(judged),
        math.sqrt((weights * distances**2).sum() / total),
        weighted_quantile(distances, weights, 0.95),
        weighted_quantile(distances, weights, 0.99),
        max((each.largest for each in judged), default=0.0),
        within / total,
        sum(each.largest > 2 * each.bound for each in judged),
        min(said, default=math.nan),
        max(said, default=math.nan),
        sum(each.written for each in judged) / max(sum(each.blocks for each in judged), 1),
    )


def row(name, outcomes):
    f = figures(outcomes)
    left = " ".join(f"{value / UM:7.2f}" for value in (f.rms, f.p95, f.p99, f.largest))
    said = " ".join(f"{value / UM:+7.2f}" for value in (f.least_said, f.most_said))
    return (
        f"{name:>10} {f.programs:8} {left} {100 * f.within:8.2f} {f.beyond:7} {said}"
        f" {f.growth:7.2f}"
    )


HEAD = (
    "      play programs     rms     p95     p99     max within % >2bound  verify - judge  growth"
)


def say(outcomes, single):
    print(HEAD)
    for play in PLAYS_UM:
        print(row(f"{play:g} um", [each for each in outcomes if each.play_um == play]))
    print(row("all", outcomes))
    print(row("example", [single]))
    for each in outcomes:
        if each.failure:
            print(f"{each}: not judged: {each.failure}")
        elif each.refused:
            print(f"{each}: {each.refused}")
    worst = max(
        (each for each in outcomes if not each.failure), key=lambda each: each.largest / each.bound
    )
    line, output, what = worst.where
    print(
        f"worst: {worst}, {worst.largest / UM:.2f} um, nominal line {line}, output line {output},"
        f" {what}; bound {worst.bound / UM:g} um"
    )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description="gcomp on random machines with play on every axis, judged"
    )
    parser.add_argument(
        "--programs", type=int, default=10, metavar="N", help="for each of the 30 machines (10)"
    )
    parser.add_argument(
        "--mode", choices=("step", "ramp"), default="step", help="gcomp's --reversal"
    )
    parser.add_argument("--workers", type=int, default=2, metavar="N", help="processes (2)")
    options = parser.parse_args()
    say(trials(options.programs, options.mode, options.workers), example(options.mode))
