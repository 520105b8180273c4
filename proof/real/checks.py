"""What was found against what is known, by arithmetic that is not the tool's: of the readings, the
answer and the residuals."""

from __future__ import annotations

import csv
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from proof.real import convert


@dataclass(frozen=True)
class Check:
    said: str
    right: bool
    reason: str = "the size is off"


@dataclass
class Outcome:
    """Answers of both runs, and where the files are."""

    answer: dict[str, Any]
    again: dict[str, Any]
    residuals: list[dict[str, str]]
    recordings: list[Path]
    # um: the largest reading of a positioning test over the whole travel of the written machine
    far: float


def key(effect: dict[str, Any]) -> str:
    return f"{effect['effect']}:{effect['axis'] or ''}"


def accepted(answer: dict[str, Any]) -> list[dict[str, Any]]:
    """Accepted effects, the one that explains most of the positions first."""
    found = [e for e in answer["effects"] if e["status"] == "accepted"]
    return sorted(found, key=lambda e: -e["rms_explained_um"])


def named(answer: dict[str, Any], name: str, parameter: str) -> dict[str, Any] | None:
    return next(
        (
            e["parameters"][parameter]
            for e in accepted(answer)
            if key(e) == name and parameter in e["parameters"]
        ),
        None,
    )


def of_drive(answer: dict[str, Any], term: str, parameter: str) -> dict[str, Any] | None:
    """Of what the force of the first drive is made of."""
    terms = (t for one in answer["drives"][:1] for t in one["terms"])
    return next((t["parameters"][parameter] for t in terms if t["term"] == term), None)


def interval(found: dict[str, Any] | None, unit: str) -> str:
    if found is None:
        return "not given"
    return f"{found['value']:.3g} {unit} ({found['ci95'][0]:.3g} to {found['ci95'][1]:.3g})"


def reversal(outcome: Outcome, axis: str) -> dict[float, float]:
    """Forward - reverse of what the effects explain, um, at every target."""
    (path,) = outcome.recordings
    columns = convert.recording_columns(path)
    first = next(
        i for i, x in enumerate(path.read_text().splitlines(), 1) if not x.startswith("# ")
    )
    explained: dict[tuple[float, float], list[float]] = {}
    for row in outcome.residuals:
        i = int(row["row"]) - first - 1
        place = (columns[f"{axis}_mm"][i], columns[f"approach_{axis}"][i])
        explained.setdefault(place, []).append(float(row["before_um"]) - float(row["after_um"]))
    return {
        x: float(np.mean(explained[x, 1.0]) - np.mean(explained[x, -1.0]))
        for x in sorted({place for place, _ in explained})
        if (x, 1.0) in explained and (x, -1.0) in explained
    }


def reversal_at(places: list[float], known: list[float], near: float) -> Callable[[Outcome], Check]:
    """Reversal at targets. The authors' own means hold a first cycle that is far off; the median of
    the cycles does not."""

    def check(outcome: Outcome) -> Check:
        found = reversal(outcome, "X")
        columns = convert.recording_columns(outcome.recordings[0])
        x, way, y = (np.array(columns[n]) for n in ("X_mm", "approach_X", "reading_um"))
        middle = [
            np.median(y[(x == p) & (way > 0)]) - np.median(y[(x == p) & (way < 0)]) for p in places
        ]
        off = max(abs(found.get(p, 0.0) - m) for p, m in zip(places, middle, strict=True))
        text = ", ".join(f"{found.get(p, 0.0):.1f}" for p in places)
        theirs = ", ".join(f"{m:.1f}" for m in middle)
        wide = [p for p, m, k in zip(places, middle, known, strict=True) if abs(m - k) > 10]
        bad = (
            f"; the authors' means at {', '.join(f'{p:g}' for p in wide)} mm hold a first cycle"
            " that is far off"
            if wide
            else ""
        )
        return Check(f"reversal {text} um; medians of the cycles {theirs} um{bad}", off < near)

    return check


def reversal_of_table(axis: str, near: float) -> Callable[[Outcome], Check]:
    def check(outcome: Outcome) -> Check:
        found = reversal(outcome, axis)
        columns = convert.recording_columns(outcome.recordings[0])
        read = dict(
            zip(
                zip(columns[f"{axis}_mm"], columns[f"approach_{axis}"], strict=True),
                columns["reading_um"],
                strict=True,
            )
        )
        off = [found[x] - (read[x, 1.0] - read[x, -1.0]) for x in found]
        rms = float(np.sqrt(np.mean(np.square(off)))) if off else np.inf
        return Check(
            f"reversal within {max(map(abs, off), default=0):.1f} um of the table's at every"
            f" target, {rms:.2f} um rms",
            rms < near,
        )

    return check


def within_readings(axis: str, travel: tuple[float, float]) -> Callable[[Outcome], Check]:
    """Nothing that is written into the machine may be far larger than anything that was read."""

    def check(outcome: Outcome) -> Check:
        largest = max(map(abs, convert.recording_columns(outcome.recordings[0])["reading_um"]))
        text = (
            f"the written machine errs by up to {outcome.far:.0f} um between {travel[0]:g} and"
            f" {travel[1]:g} mm; read were {largest:.0f} um at most"
        )
        return Check(
            text,
            outcome.far < 3 * largest,
            "what is written into the machine runs away where nobody measured",
        )

    return check


def lost_motion_of_chamber(outcome: Outcome) -> Check:
    columns = convert.recording_columns(outcome.recordings[0])
    z, way, y = (np.array(columns[n]) for n in ("Z_mm", "approach_Z", "reading_um"))
    both = [
        np.mean(y[(z == p) & (way > 0)]) - np.mean(y[(z == p) & (way < 0)])
        for p in np.unique(z)
        if len(set(way[z == p])) == 2
    ]
    mean = -float(np.mean(both))
    found = named(outcome.answer, "backlash:Z", "size_um") or named(
        outcome.answer, "windup:Z", "size_um"
    )
    right = found is not None and found["ci95"][0] <= mean <= found["ci95"][1]
    return Check(
        f"{interval(found, 'um')}; mean of the table {mean:.1f} um, of a gauge of 10 um", right
    )


def servo(outcome: Outcome) -> Check:
    """Half of the rests come after a command, half after a pull: one number for both lies between
    theirs, by the log's own means."""
    found = [-v / convert.COUNT_MM / 1e3 for v in reversal(outcome, "X").values()]
    text = ", ".join(f"{s:.1f}" for s in found) or "no"
    right = bool(found) and 7.03 < found[0] < 11
    return Check(f"{text} counts at the middle target, over both kinds of rests", right)


def within(
    name: str, parameter: str, low: float, high: float, unit: str
) -> Callable[[Outcome], Check]:
    def check(outcome: Outcome) -> Check:
        found = named(outcome.answer, name, parameter)
        return Check(interval(found, unit), found is not None and low <= found["value"] <= high)

    return check


def steady_lag(outcome: Outcome) -> Check:
    """Off by speed, where both speeds agree and a place has three digits that are worth
    something."""
    said, right = [], True
    read = [
        {n: np.array(v) for n, v in convert.recording_columns(p).items()}
        for p in outcome.recordings
    ]
    for axis in "XYZ":
        over = under = 0.0
        for c in read:
            v, real = c[f"{axis}_cmd_velocity_mm_s"], c[f"{axis}_act_velocity_mm_s"]
            steady = (
                (np.abs(v) > 5)
                & (np.abs(real - v) < 0.03 * np.abs(v))
                & (np.abs(c[f"{axis}_cmd_mm"]) < 100)
            )
            over += float(((c[f"{axis}_cmd_mm"] - c[f"{axis}_act_mm"]) * v)[steady].sum())
            under += float((v**2)[steady].sum())
        found = named(outcome.answer, f"servo_lag:{axis}", "tau_ms")
        by_hand = f"by division {1e3 * over / under:.2f}" if under else "no place under 100 mm"
        said.append(f"{axis} {interval(found, 'ms')}, {by_hand}")
        right &= found is not None and (
            not under or found["ci95"][0] <= 1e3 * over / under <= found["ci95"][1]
        )
    return Check("; ".join(said), right)


def feed_drive(outcome: Outcome) -> Check:
    """The drive's voltage is kv (kp (command - place) - speed): kp and kv by least squares. A
    steady speed v then lags by (1 + friction / (kv gain)) / kp, and dry friction adds a step."""
    (path,) = outcome.recordings
    c = {n: np.array(v) for n, v in convert.recording_columns(path).items()}
    speed = np.gradient(c["X_act_mm"], c["t_s"])
    (a, b), *_ = np.linalg.lstsq(
        np.c_[c["X_cmd_mm"] - c["X_act_mm"], speed], c["X_drive_V"], rcond=None
    )
    kp, force = (
        -a / b,
        float(np.median(c["force_X_N"][c["X_drive_V"] != 0] / c["X_drive_V"][c["X_drive_V"] != 0])),
    )
    lag = 1e3 * (1 + 203.5 / (-b * 1e3 * force)) / kp
    step = 20.4 / (-b * force * kp) * 1e3
    found = named(outcome.answer, "servo_lag:X", "tau_ms")
    mass = of_drive(outcome.answer, "inertia", "N_per_m_s2")
    viscous = named(outcome.answer, "viscous_friction:X", "N_per_m_s")
    dry = named(outcome.answer, "coulomb_friction:X", "size_N")
    text = (
        f"lag {interval(found, 'ms')}, by the loop {lag:.2f} ms and a step of {step:.1f} um by dry"
        f" friction; mass {interval(mass, 'kg')} (its drive), viscous"
        f" {interval(viscous, 'N s/m')}, dry {interval(dry, 'N')}"
    )
    near = [(found, lag, 0.05), (mass, 95.1, 0.02), (viscous, 203.5, 0.1), (dry, 20.4, 0.1)]
    return Check(text, all(f is not None and abs(f["value"] / k - 1) < tol for f, k, tol in near))


def residual_rows(path: Path) -> list[dict[str, str]]:
    with open(path, newline="", encoding="utf-8") as lines:
        return list(csv.DictReader(lines))
