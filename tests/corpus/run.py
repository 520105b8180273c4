"""Real programs, whole, on made-up machines: what comes out.

Each is run by a machine without errors (the output must be the input, to the byte) and by machines
with smooth maps (the output is replayed and measured, laws.py).
"""

from __future__ import annotations

import contextlib
import io
import itertools
import signal
import threading
import traceback
from collections.abc import Iterator
from types import SimpleNamespace

import numpy as np

from postproc.commands import expansion
from postproc.compensate import Options
from postproc.errors import BlockFault, GcompError, ProgramError
from postproc.filter import Filter, setup_of
from postproc.machine.model import Machine
from postproc.nc import dialects
from postproc.units import UM
from postproc.verify import Verifier
from tests.corpus.laws import first_difference, measure
from tests.corpus.machines import MAIN, Machines, Variant, offsets
from tests.corpus.outcome import Outcome
from tests.corpus.programs import Program

MAX_STEPS, MAX_DEPTH = 200_000, 50
LONGEST_S = 20


def make_filter(
    machine: Machine,
    program: Program,
    tolerance_um: float | None = None,
    start: dict[str, float] | None = None,
) -> Filter:
    """A filter for the dialect; all offsets are zero, and the machine stands at zero where `start`
    does not say more."""
    dialect = dialects.load(program.dialect)
    machine = machine.carrying(dialect.carried)
    place = {x: 0.0 for x in machine.letters} | (start or {})
    setup = setup_of(machine, offsets(), place, arc_centre=program.arc_centre)
    options = Options(tolerance=tolerance_um * UM) if tolerance_um else Options()
    return Filter(machine, dialect, setup, options, program.path.name)


def output(
    filter_: Filter, text: bytes, expand: bool = False, cuts: tuple[int, ...] = ()
) -> Iterator[bytes]:
    """The output; the input is cut at these places ((0,): behind every line)."""
    if expand:
        yield from expansion.through(filter_, written_out(filter_, text), lambda n: None)
        return
    if cuts == (0,):
        parts = text.splitlines(keepends=True)
    else:
        edges = [0, *cuts, len(text)]
        parts = [text[a:b] for a, b in itertools.pairwise(edges)]
    for part in parts:
        yield filter_.feed(part)
    yield filter_.finish()


def written_out(filter_: Filter, text: bytes):
    """What --expand makes of it, to iterate over. No file is looked for: a program stands alone."""
    options = SimpleNamespace(file=None, library=[], max_steps=MAX_STEPS, max_depth=MAX_DEPTH)
    return expansion.written_out(filter_, io.BytesIO(text), options)


@contextlib.contextmanager
def at_most(seconds: float):
    """Raises TimeoutError when it takes longer on the processor, where the system can tell."""
    if not hasattr(signal, "SIGPROF") or threading.current_thread() is not threading.main_thread():
        yield
        return

    def late(number, frame):
        raise TimeoutError(f"not done after {seconds:g} s")

    before = signal.signal(signal.SIGPROF, late)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


def run_zero(machines: Machines, program: Program, text: bytes, expand: bool) -> Outcome:
    """On the machine without errors."""
    outcome = _run(make_filter(machines.zero(program.lathe), program), text, expand)
    if outcome.status == "done":
        outcome.status = "written" if expand else "identical"
        if not expand and outcome.output != text:
            outcome.faults.append(
                "a map without errors moved a byte: " + first_difference(text, outcome.output)
            )
    return outcome


def run_smooth(
    machines: Machines, program: Program, text: bytes, expand: bool, variant: Variant = MAIN
) -> Outcome:
    """On a machine with a map: verified, and the laws measured."""
    machine = machines.smooth(variant, program.lathe)
    filter_ = make_filter(machine, program, variant.tolerance_um)
    verifier = Verifier(filter_)
    counts: list[tuple[int, np.ndarray, np.ndarray]] = []
    filter_.watchers.append(
        lambda words, motions, pieces, out, line: counts.append(
            (len(motions), pieces.motion, pieces.take_up)
        )
    )
    outcome = _run(filter_, text, expand)
    outcome.motions_in, outcome.motions_out = verifier.motions_in, verifier.motions_out
    outcome.uncorrected, outcome.corrected = (
        verifier.uncorrected.deviation / UM,
        verifier.corrected.deviation / UM,
    )
    if outcome.status != "done":
        return outcome
    outcome.status = "verified"
    if not verifier.passed:
        outcome.faults.append(f"not within the tolerance: {verifier.report()}")
    try:
        with at_most(LONGEST_S):
            plain = text
            if expand:
                plain = b"".join(
                    written_out(make_filter(machine, program, variant.tolerance_um), text)
                )
            measure(outcome, filter_, plain, counts)
    except (GcompError, BlockFault, TimeoutError) as error:
        outcome.faults.append(f"input or output can not be followed as a whole: {error}")
    except Exception:
        outcome.faults.append(
            "input or output can not be followed as a whole: " + traceback.format_exc(limit=-2)
        )
    return outcome


def run_cut(
    machines: Machines, program: Program, text: bytes, cuts: tuple[int, ...] = ()
) -> Outcome:
    """On the machine with a map, the input cut in other places; not verified."""
    return _run(
        make_filter(machines.smooth(MAIN, program.lathe), program, MAIN.tolerance_um),
        text,
        False,
        cuts,
    )


def _run(filter_: Filter, text: bytes, expand: bool, cuts: tuple[int, ...] = ()) -> Outcome:
    outcome, out = Outcome(), []
    try:
        with at_most(LONGEST_S):
            for part in output(filter_, text, expand, cuts):
                out.append(part)
        outcome.status = "done"
    except ProgramError as error:
        out.append(error.delivered)
        outcome.status, outcome.message, outcome.advice = "refused", error.message, error.advice
        outcome.line = error.place.line if error.place else 0
        lines = text.count(b"\n") + 1
        if not 0 < outcome.line <= lines:
            outcome.faults.append(f"a refusal at line {outcome.line} of {lines}")
        if not error.advice:
            outcome.faults.append("a refusal without advice")
    except GcompError as error:
        outcome.status, outcome.message, outcome.advice = "broken", error.message, error.advice
        outcome.line = error.place.line if error.place else 0
        outcome.faults.append(f"{error}")
    except TimeoutError as error:
        outcome.status, outcome.message = "broken", str(error)
        outcome.faults.append(str(error))
    except Exception as error:
        outcome.status, outcome.message = "broken", f"{type(error).__name__}: {error}"
        outcome.faults.append(traceback.format_exc(limit=-4))
    outcome.output = b"".join(out)
    outcome.blocks = filter_.summary.blocks
    outcome.notices = [notice.message for notice in filter_.notices]
    return outcome
