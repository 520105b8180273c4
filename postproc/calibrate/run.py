"""From recordings to a calibration: each is put where it belongs, components are built, brought
together and checked."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from postproc.calibrate import CalibrationError, Finding, Options, checks, outliers, squaring
from postproc.calibrate.arms import bring_together
from postproc.calibrate.assign import Diagonal, Series, assign
from postproc.calibrate.calibration import Calibration
from postproc.calibrate.component import Component, build, elsewhere
from postproc.calibrate.outliers import Outlier
from postproc.calibrate.statistics import cells_of
from postproc.errors import GcompError, Place
from postproc.recordings import Recording


@dataclass
class Sorted:
    """Recordings by what they measured: series of a component, diagonals, those that fit nothing,
    and what was found and is to be said on the way."""

    series: dict[str, list[Series]] = field(default_factory=dict)
    diagonals: list[Diagonal] = field(default_factory=list)
    refused: list[GcompError] = field(default_factory=list)
    outliers: list[Outlier] = field(default_factory=list)
    findings: list[Finding] = field(default_factory=list)

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
        # Two lines of one axis are two tables; the first file says which one this is. Angles alone
        # are the same on all of them.
        away = elsewhere(before[0], one) if before else None
        if away is not None:
            self.refused.append(away)
            return
        self.series.setdefault(one.component, []).append(self._heard(one, options))

    def _heard(self, one: Series, options: Options) -> Series:
        """A series after what there is to say of it, without its outliers where they are to go."""
        self.findings += [
            Finding("assignment", "note", one.component, f"{one.file}: {text}")
            for text in one.notices
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
            self.findings.append(found)
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
    got = Sorted(findings=_state(recordings))
    round_ = [r for r in recordings if r.kind == "ballbar"]
    for recording in recordings:
        if recording.kind != "ballbar":
            got.take(recording, options)
    if not got.series:
        raise _nothing(got.refused)
    measured = {name: build(parts, options) for name, parts in got.series.items()}
    # before they are brought together: an angle that is noise may not move a straightness by its
    # arm
    left_out, kept = _standing_out(measured, options)
    kept, measured_at, optics, carried = bring_together(kept, options)
    findings = got.findings + [Finding("measured-at", "note", "", text) for text in carried]
    result = Calibration(
        options, kept, left_out, got.refused, got.outliers, got.diagonals, measured_at, optics,
        round_,
    )  # fmt: skip
    # needs the machine of all components: each source is asked what they leave of it
    square, says = squaring.determine(result)
    result = replace(result, squareness=square, findings=findings + says)
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
            f"no component exceeds its uncertainty: {names}",
            "there is nothing to correct; --keep-all writes them",
        )
    return left_out, kept


def _state(recordings: Sequence[Recording]) -> list[Finding]:
    """What is said of recordings made after compensation; one before among them makes a map of
    neither machine. Raises CalibrationError."""
    # what says nothing counts as before compensation, as most recordings are
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
        # a check is a file in checks/: nothing else has to name it
        found += importlib.import_module(f"{checks.__name__}.{module.name}").check(calibration)
    return found
