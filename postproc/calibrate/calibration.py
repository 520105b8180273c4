"""Recordings in, a calibration out: which components there are, what they are, what was left out,
what looks wrong."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from postproc.calibrate import CalibrationError, Finding, Options, checks, outliers, squaring
from postproc.calibrate.arms import bring_together
from postproc.calibrate.assign import Diagonal, Series, assign
from postproc.calibrate.component import Component, build, elsewhere
from postproc.calibrate.outliers import Outlier
from postproc.calibrate.square import Squareness
from postproc.calibrate.statistics import cells_of
from postproc.errors import GcompError, Place
from postproc.machine.axis import Axis
from postproc.machine.chain import XYZ
from postproc.machine.lacks import lacks
from postproc.machine.model import Limits, Machine
from postproc.machine.tables import COMPONENTS, AxisTable
from postproc.recordings import Recording


@dataclass(frozen=True)
class Calibration:
    """components: those that are written, by name; left_out: the others with the reason ("range",
    "noise"); refused: recordings that fit nothing, with why; measured_at: axis to other axis to mm;
    optics: axis to "", tool or workpiece.
    """

    options: Options
    components: dict[str, Component]
    left_out: list[tuple[Component, str]]
    refused: list[GcompError]
    outliers: list[Outlier]
    diagonals: list[Diagonal]
    measured_at: dict[str, dict[str, float]]
    optics: dict[str, str]
    circles: list[Recording] = field(default_factory=list)
    squareness: dict[str, Squareness] = field(default_factory=dict)
    findings: list[Finding] = field(default_factory=list)

    @property
    def measured(self) -> dict[str, Component]:
        """All components that were measured, written or not."""
        return self.components | {c.name: c for c, _ in self.left_out}

    def axes(self) -> list[str]:
        """Axes of the chain that have a component to be written."""
        return [
            x
            for x in self.options.chain.axes
            if any(c.letter == x for c in self.components.values())
        ]

    def of(self, letter: str) -> list[Component]:
        """Components of an axis that are written, in the order of a table."""
        mine = [c for c in self.components.values() if c.letter == letter]
        return sorted(mine, key=lambda c: COMPONENTS.index(c.name[:2]))

    def nodes(self, letter: str) -> np.ndarray:
        """(K,) all targets of the axis' components: each is linear between its own, so nothing is
        lost."""
        return np.unique(np.concatenate([c.nodes for c in self.of(letter)]))

    def values(self, component: Component) -> np.ndarray:
        """(2, K) of a component at all nodes of its axis, held beyond its own."""
        value = np.tile(component.mean, (2, 1)) if self.options.mean else component.value
        return np.stack(
            [np.interp(self.nodes(component.letter), component.nodes, v) for v in value]
        )

    def two_way(self, component: Component) -> bool:
        """Whether a component is written with a column for each direction."""
        return component.two_way and not self.options.mean

    def travel(self, letter: str) -> tuple[float, float]:
        """mm: as stated, else from the first target to the last."""
        if letter in self.options.travel:
            return self.options.travel[letter]
        nodes = [c.nodes for c in self.measured.values() if c.letter == letter]
        return (min(n[0] for n in nodes), max(n[-1] for n in nodes)) if nodes else (0.0, 1.0)

    @cached_property
    def machine(self) -> Machine:
        """The machine that the components make, without squareness."""
        axes = {}
        for x in sorted(self.options.chain.axes, key=(XYZ + "ABC").index):
            table = None
            if x in self.axes():
                both = np.zeros((2, 6, len(self.nodes(x))))
                for component in self.of(x):
                    both[:, COMPONENTS.index(component.name[:2])] = self.values(component)
                stated = tuple(COMPONENTS.index(c.name[:2]) for c in self.of(x))
                table = AxisTable(x, self.nodes(x), both[0], both[1], stated)
            at = np.array([self.measured_at.get(x, {}).get(i, 0.0) for i in XYZ])
            small = tuple(c.name for c, _ in self.left_out if c.letter == x)
            axes[x] = Axis(
                x, self.travel(x), 1e-4, at, table, self.optics.get(x, ""), left_out=small
            )
        return Machine(
            "", "", "", self.options.chain, axes, tool=np.array(self.options.point),
            limits=Limits(outside=self.options.outside), signs="unverified",
        )  # fmt: skip

    @property
    def lacks(self) -> list[str]:
        """What the machine to be written does not hold, in words."""
        return lacks(replace(self.machine, square_stated=tuple(self.squareness)))


@dataclass
class Sorted:
    """Recordings by what they measured: series of a component, diagonals, those that fit nothing,
    and what was found and is to be said on the way."""

    series: dict[str, list[Series]] = field(default_factory=dict)
    diagonals: list[Diagonal] = field(default_factory=list)
    refused: list[GcompError] = field(default_factory=list)
    outliers: list[Outlier] = field(default_factory=list)
    told: list[Finding] = field(default_factory=list)

    def take(self, recording: Recording, options: Options) -> None:
        """Puts a recording where it belongs."""
        try:
            one = assign(recording)
            _of_chain(one, recording, options)
        except CalibrationError as error:
            self.refused.append(error)
            return
        if isinstance(one, Diagonal):
            self.diagonals.append(one)
            return
        before = self.series.get(one.component, [])
        away = elsewhere(before[0], one) if before else None
        if away is not None:
            self.refused.append(away)
            return
        self.series.setdefault(one.component, []).append(self._heard(one, options))

    def _heard(self, one: Series, options: Options) -> Series:
        """A series after what there is to say of it, without its outliers where they are to go."""
        self.told += [
            Finding("assignment", "note", one.component, f"{one.file}: {text}") for text in one.told
        ]
        mine = outliers.find(one, cells_of(one.position, one.approach, one.reading))
        self.outliers += mine
        if options.drop_outliers and mine:
            one = one.pick(~np.isin(np.arange(len(one.reading)), [o.row for o in mine]))
        unknown = int((one.approach == 0).sum())
        if unknown and np.any(one.approach):
            text = (
                f"{one.file}: of {unknown} of its readings the direction of approach is not known,"
                " they are not used"
            )
            found = Finding("assignment", "doubt", one.component, text, {"readings": unknown})
            self.told.append(found)
        return one


def _of_chain(one: Series | Diagonal, recording: Recording, options: Options) -> None:
    """Raises CalibrationError for an axis that the chain has not."""
    axes = [one.letter] if isinstance(one, Series) else list(one.path)
    if missing := [x for x in axes if x not in options.chain.axes]:
        raise CalibrationError(
            f"{missing[0]} moves, and the chain {'-'.join(options.chain.axes)} has no {missing[0]}",
            "--chain names all axes",
            Place(recording.file, 1),
        )


def calibrate(recordings: Sequence[Recording], options: Options) -> Calibration:
    """All of it. Raises CalibrationError where no recording fits a component, or one that does can
    not be used."""
    got = Sorted(told=_state(recordings))
    round_ = [r for r in recordings if r.kind == "ballbar"]
    for recording in recordings:
        if recording.kind != "ballbar":
            got.take(recording, options)
    if not got.series:
        raise _nothing(got.refused)
    measured = {name: build(parts, options) for name, parts in got.series.items()}
    left_out, kept = _standing_out(measured, options)
    kept, measured_at, optics, carried = bring_together(kept, options)
    told = got.told + [Finding("measured-at", "note", "", text) for text in carried]
    result = Calibration(
        options, kept, left_out, got.refused, got.outliers, got.diagonals, measured_at, optics,
        round_,
    )  # fmt: skip
    square, says = squaring.determine(result)
    result = replace(result, squareness=square, findings=told + says)
    return replace(result, findings=result.findings + _checked(result))


def _nothing(refused: list[GcompError]) -> GcompError:
    """Why there is no series of one axis."""
    if len(refused) == 1:
        return refused[0]
    if refused:
        return CalibrationError("\n".join(map(str, refused)))
    return CalibrationError(
        "no recording of one axis moving alone", "calibration begins with single axes"
    )


def _standing_out(
    measured: dict[str, Component], options: Options
) -> tuple[list[tuple[Component, str]], dict[str, Component]]:
    """Components left out as small, with why, and those to be written. Raises CalibrationError
    where there are none of these."""
    left_out = [(c, c.small) for c in measured.values() if c.small and not options.keep_all]
    kept = {n: c for n, c in measured.items() if n not in {c.name for c, _ in left_out}}
    if not kept:
        names = ", ".join(f"{c.name} ({why})" for c, why in left_out)
        raise CalibrationError(
            f"no component stands out of its uncertainty: {names}",
            "there is nothing to correct; --keep-all writes them",
        )
    return left_out, kept


def _state(recordings: Sequence[Recording]) -> list[Finding]:
    """What is said of recordings made after compensation; one before among them makes a map of
    neither machine. Raises CalibrationError."""
    after = [r.file for r in recordings if r.head.get("compensated") is True]
    before = [r for r in recordings if r.head.get("compensated") is not True]
    if after and before:
        raise CalibrationError(
            f"{before[0].file} was measured before compensation, and {after[0]} after it"
            " (compensated = true)",
            "a map is of one state: name those of before; gcomp accept compares them with those of"
            " after",
            Place(before[0].file, 1),
        )
    if not after:
        return []
    text = (
        f"{', '.join(after)}: measured after compensation, so this map is of what was left by the"
        " one that was used"
    )
    return [Finding("state", "doubt", "", text)]


def _checked(calibration: Calibration) -> list[Finding]:
    """What every check in checks/ finds."""
    found: list[Finding] = []
    for module in sorted(pkgutil.iter_modules(checks.__path__), key=lambda m: m.name):
        found += importlib.import_module(f"{checks.__name__}.{module.name}").check(calibration)
    return found
