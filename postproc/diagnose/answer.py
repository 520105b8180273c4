"""What a diagnosis answers: findings, and all that a reader may want to check of them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from postproc.diagnose import drive, locate
from postproc.diagnose.block import Block
from postproc.diagnose.rows import Rows
from postproc.diagnose.unknown import Unknown
from postproc.machine.model import Machine
from postproc.recordings import Recording

# of the squares of a force, what the drive's terms leave of the halves that took no part in their
# fit: more is cutting or drift (real slides and mills: 0.001 to 0.37)
ANOTHER = 0.5
UNEVEN, MEAN = "friction_asymmetry:", "coulomb_friction:"


@dataclass
class Finding:
    """One accepted effect. names: how probable it and each name that explains the readings as well
    is, by what the readings tell and what is believed beforehand, if it is one of these; they sum
    to 1. aliases: mm, other periods that targets at even distances show alike."""

    block: Block
    value: dict[str, float]
    ci95: dict[str, tuple[float, float]]
    contribution: np.ndarray
    score: float
    delta_chi2: float
    equivalent: list[str]
    status: str = "accepted"
    text: str = ""  # where the effect's own sentence would say too little
    next_test: str = ""
    predictive: bool = True  # whether a curve says what targets read that took no part in its fit
    names: dict[str, float] = field(default_factory=dict)
    aliases: list[float] = field(default_factory=list)


@dataclass
class Diagnosis:
    """All that was found. rows: every reading that was used; held (N,) bool: took no part; before,
    after (N,) mm; sigma (N,) mm; places: where the mismatch is; limits: effect:axis to mm; blind:
    effects that can not be seen here; faults: (file, line, what, mm); noise (N,) mm: standard
    deviation of a reading by white noise, wander and zeros of runs; unknown: None or what is left;
    drives: what forces and currents ask for; scatter (N,) mm: the noise of these readings
    themselves."""

    machine: Machine
    recordings: list[Recording]
    rows: Rows
    held: np.ndarray
    held_name: str
    before: np.ndarray
    after: np.ndarray
    sigma: np.ndarray
    findings: list[Finding]
    places: list[locate.Place]
    limits: dict[str, float]
    blind: list[tuple[str, str, str]]
    faults: list[tuple[int, int, str, float]]
    least: float
    noise: np.ndarray
    unknown: Unknown | None = None
    notices: list[str] = field(default_factory=list)
    disagreements: list[str] = field(default_factory=list)
    drives: list[drive.Drive] = field(default_factory=list)
    scatter: np.ndarray = field(default_factory=lambda: np.zeros(0))

    @property
    def verdict(self) -> str:
        if any(f.status == "accepted" for f in self.findings) or any(felt(self)):
            return "left-out-physics"
        return "unknown" if self.unknown or self.disagreements else "nothing-left-out"


def felt(d: Diagnosis) -> Iterator[tuple[drive.Drive, drive.Fitted]]:
    """What forces and currents show of the effects that the contract knows, where neither the
    positions say it already nor a delay of the force would; of a force that is for the most part
    another than the drive's, nothing. Friction that differs with the direction has a mean, which is
    no friction beside it."""
    said = {f.block.key for f in d.findings if f.status == "accepted"}
    said |= {key.replace(UNEVEN, MEAN) for key in said if key.startswith(UNEVEN)}
    for one in d.drives:
        # what is left of the squares: a force that is mostly cutting tells nothing of the drive
        for term in one.fitted if one.after**2 < ANOTHER * one.raw**2 else ():
            key = f"{term.term.name}:{one.axis}"
            if term.term.name in drive.NAMES and key not in said and not term.delayed:
                yield one, term


def floor(d: Diagnosis) -> np.ndarray:
    """(N,) mm: the noise of single readings, as they have it."""
    return d.scatter if len(d.scatter) else d.noise
