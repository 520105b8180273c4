"""Small machines and a short way from text to a timeline."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from postproc import effects
from postproc.filter import Filter, setup_of
from postproc.machine.axis import Axis
from postproc.machine.chain import parse
from postproc.machine.file import read_machine
from postproc.machine.model import Machine
from postproc.nc import dialects
from postproc.simulate import timeline as timelines
from postproc.simulate.actual import Reality, Term, terms_of
from postproc.simulate.instruments import Noise, Settings, load, recorded
from postproc.simulate.limits import Limits
from postproc.simulate.program import Reader
from postproc.simulate.timeline import Conditions, Timeline

ROOT = Path(__file__).resolve().parents[2]
STUDER, MILL = (read_machine(ROOT / "machines" / name) for name in ("studer-s36", "example-mill"))
STRICT = Conditions(corner=0.0, cycle=0.0)


def exact(letters: str = "XYZ", reach: float = 1000.0, diameter: tuple[str, ...] = ()) -> Machine:
    """A machine without errors: every axis from -reach to +reach, G54 at zero."""
    axes = {x: Axis(x, (-reach, reach), 0.001, np.zeros(3)) for x in letters}
    chain = parse("w-b-" + "-".join(letters) + "-t")
    return Machine(
        "exact",
        "",
        "linuxcnc",
        chain,
        axes,
        diameter=diameter,
        offsets={"G54": dict.fromkeys(letters, 0.0)},
    )


def limits(
    machine: Machine, velocity: float = 100.0, acceleration: float = 1000.0, jerk: float = np.inf
) -> Limits:
    """mm/s, mm/s2, mm/s3, the same for every axis."""
    n = len(machine.axes)
    return Limits(np.full(n, velocity), np.full(n, acceleration), np.full(n, jerk))


def timed(
    text: str | bytes,
    machine: Machine,
    conditions: Conditions = STRICT,
    bounds: Limits | None = None,
    parts: int = 1,
) -> Timeline:
    """A program in time; it is read in the machine's own dialect."""
    dialect = dialects.load(machine.control)

    def make(bare: Machine, start: dict[str, float]) -> Filter:
        carrying = bare.carrying(dialect.carried)
        return Filter(carrying, dialect, setup_of(carrying, start=start))

    reader = Reader(machine, make, "program.nc")
    start: dict[str, float] = {}
    for part in range(1, parts + 1):
        start = reader.read([text.encode() if isinstance(text, str) else text], part, start)
    steps = reader.steps(dict.fromkeys(machine.axes, 0.0))
    return timelines.of(steps, machine, bounds or limits(machine), conditions, reader.letters)


def term(name: str, axis: str, **parameters: float) -> Term:
    """An effect at work."""
    return Term(effects.load(name), axis, parameters)


def real(timeline: Timeline, *terms: Term) -> Reality:
    """The timeline with the machine's own effects and further ones."""
    return Reality(timeline, (*terms_of(timeline.machine), *terms))


def read(instrument: str, reality: Reality, noise: Noise = Noise(), **given: str):
    """The recording of an instrument."""
    module = load(instrument)
    signal = module.measure(reality, Settings(instrument, module.SETTINGS, given))
    return recorded(signal, noise, {"machine": reality.machine.name})


def without_tables(machine: Machine) -> Machine:
    """The machine with nothing left but its axes."""
    return replace(
        machine, axes={x: a.bare for x, a in machine.axes.items()}, square={}, effects=()
    )
