"""One case: diagnosed by the command line, written into the machine, diagnosed again."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from proof.real import checks, convert
from proof.real.cases import ROOT, Case, Job


class Refused(Exception):
    """The tool gave no answer."""


@dataclass
class Result:
    name: str
    title: str
    whom: str
    licence: str
    known: str
    concealed: str
    first: str  # the first accepted name, as effect:axis
    others: list[str]
    equivalents: list[str]
    size: str
    # um rms of the held-out readings about their mean, from the readings alone
    about_mean: float | None
    before: float | None
    after: float | None
    floor: float | None
    second: list[str]
    unknown: bool
    verdict: bool
    reasons: list[str]
    note: str

    def as_dict(self) -> dict[str, Any]:
        return asdict(self)


def gcomp(*words: str) -> str:
    """The command line of this tree."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run(
        [sys.executable, "-m", "postproc", *words],
        cwd=ROOT,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        raise Refused(
            done.stderr.strip().splitlines()[0]
            if done.stderr.strip()
            else f"exit status {done.returncode}"
        )
    return done.stdout


def diagnose(job: Job, machine: Path, folder: Path, step: int) -> dict[str, Any]:
    files = {
        "--json": f"answer{step}.json",
        "--residuals": f"residuals{step}.csv",
        "--write-machine": f"machine{step}",
    }
    words = [w for option, name in files.items() for w in (option, str(folder / name))]
    call = [
        "diagnose",
        *map(str, job.recordings),
        "--machine",
        str(machine),
        *job.options,
        *words,
        "--force",
        "--quiet",
    ]
    gcomp(*call)
    answer = json.loads((folder / files["--json"]).read_text(encoding="utf-8"))
    # What is not told apart, or does not predict targets between, is written only when it is asked
    # for: here it is. Of an instrument, or of forces, nothing is written.
    names = [
        f"{e['effect']}:{e['axis'] or ''}"
        for e in answer["effects"]
        if e["status"] == "accepted" and e["kind"] == "machine" and "signal" not in e
    ]
    if step == 1 and names:
        gcomp(*call, *(word for name in names for word in ("--accept", name)))
    return json.loads((folder / files["--json"]).read_text(encoding="utf-8"))


def far(axis: str, machine: Path, folder: Path) -> float:
    """um: the largest reading of a positioning test over the whole travel of a machine."""
    target = folder / "positioning.csv"
    gcomp(
        "simulate",
        "--test",
        f"positioning:{axis}",
        "--machine",
        str(machine),
        "-o",
        str(target),
        "--quiet",
    )
    return max(map(abs, convert.recording_columns(target)["reading_um"]))


def spread(rows: list[dict[str, str]]) -> float | None:
    """um rms about their mean, of the held-out readings of every signal."""
    signals: dict[tuple[str, str], list[float]] = {}
    for row in rows:
        if row["held_out"] == "1" and row["signal"].startswith("reading"):
            signals.setdefault((row["recording"], row["signal"]), []).append(
                float(row["measured_um"])
            )
    squares = [(v - np.mean(values)) ** 2 for values in signals.values() for v in values]
    return float(np.sqrt(np.mean(squares))) if squares else None


def run(case: Case, folder: Path) -> Result | None:
    """What came out, or None where the recording is not here."""
    folder.mkdir(parents=True, exist_ok=True)
    job = case.make(folder)
    if job is None:
        return None
    told = {
        k: getattr(case, k)
        for k in ("name", "title", "whom", "licence", "known", "concealed", "note")
    }
    try:
        answer = diagnose(job, job.machine, folder, 1)
        again = diagnose(job, folder / "machine1", folder, 2)
    except Refused as e:
        return Result(
            **told,
            first="",
            others=[],
            equivalents=[],
            size="",
            about_mean=None,
            before=None,
            after=None,
            floor=None,
            second=[],
            unknown=False,
            verdict=False,
            reasons=[f"refused: {e}"],
        )
    rows = checks.residual_rows(folder / "residuals1.csv")
    reach = far("X", folder / "machine1", folder) if case.name.endswith("-travel") else 0.0
    found = checks.accepted(answer)
    names = [checks.key(e) for e in found]
    second = [checks.key(e) for e in checks.accepted(again)]
    outcome = checks.Outcome(answer, again, rows, job.recordings, reach)
    checked = case.check(outcome) if case.check else None
    fit = answer["fit"]
    before, after = fit["rms_before_um"], fit["rms_after_um"]
    reasons = []
    if not case.right:
        if names or answer["verdict"] != "nothing-left-out":
            reasons.append(
                "something is named where nothing is left out" if names else "called unknown"
            )
    else:
        if not names:
            reasons.append(f"no name: {answer['verdict']}")
        elif names[0] not in case.right:
            inside = case.right & set(found[0]["equivalent"])
            reasons.append(
                "the right name is among the equivalents only"
                if inside
                else "the first name is another"
            )
        missing = sorted(case.all_of - set(names))
        if missing:
            reasons.append(f"not named: {', '.join(missing)}")
        left = sorted(case.right & set(second))
        if left:
            reasons.append(f"in the second run it is there again: {', '.join(left)}")
        if before is not None and not after < before:
            reasons.append("held out no better")
    aside = sum(f["fault"] == "outlier" for f in answer["data_faults"])
    total = sum(r["rows"] for r in answer["recordings"])
    if aside > 0.1 * total:
        reasons.append(f"{aside} of {total} readings put aside as outliers")
    if checked and not checked.right:
        reasons.append(checked.reason)
    return Result(
        **told,
        first=names[0] if names else "",
        others=names[1:],
        equivalents=found[0]["equivalent"] if found else [],
        size=checked.said if checked else "",
        about_mean=spread(rows),
        before=before,
        after=after,
        floor=fit["noise_floor_um"],
        second=second,
        unknown=bool(answer["unknown"]),
        verdict=not reasons,
        reasons=reasons,
    )
