"""A trial of the tool on cases of the textbooks: they are made, answered and scored.

The only module here that knows the tool, by its command, and the score of the other trials.
"""

from __future__ import annotations

import io
import json
import subprocess
import tarfile
import tempfile
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict
from pathlib import Path
from typing import Any

from proof import score, score_table, strangers_trial, trial_run, trial_seal

from .tiers import Made, make

# Faults of the data are reported as such, and not as effects (contract of answers).
FAULTS = {"outlier", "sensor_drift"}
TOOL = ("postproc", "machines")  # what a commit's tool needs


def trial(seed: int, counts: dict[str, int], out: Path, jobs: int, beside: str | None) -> str:
    """Cases, answers, truth and score under a folder; the table. counts: tier -> cases; beside: a
    commit whose tool answers the same cases, too. FileExistsError where the folder holds any,
    SealError where there is no such commit."""
    cases = out / "cases"
    if cases.exists():
        raise FileExistsError(f"{cases} exists: name another folder")
    other = beside and trial_seal.git("rev-parse", "--verify", f"{beside}^{{commit}}").strip()
    truth, details = made(seed, counts, cases, jobs)
    for name, value in (("truth.json", truth), ("details.json", details)):
        (out / name).write_text(json.dumps(value, indent=1) + "\n")
    answers = {"now": out / "answers"}
    trial_run.run(cases, answers["now"], jobs)
    if other:
        answers["before"] = out / "answers_before"
        with tempfile.TemporaryDirectory() as tool:
            checked_out(other, Path(tool))
            strangers_trial.with_tool(Path(tool), cases, answers["before"], jobs)
    outcomes = {w: strangers_trial.judged(of, truth, details) for w, of in answers.items()}
    rows = {who: strangers_trial.lines(found) for who, found in outcomes.items()}
    (out / "score.json").write_text(
        score.kept({who: [asdict(o) for o in found] for who, found in outcomes.items()})
    )
    (out / "FAILURES.md").write_text(score_table.failures(rows["now"]))
    text = strangers_trial.table(rows, outcomes["now"], details)
    (out / "TABLE.md").write_text(text)
    return text


def made(
    seed: int, counts: dict[str, int], folder: Path, jobs: int
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Cases under the folder; truth and details by name, as the score wants them."""
    work = [(seed, tier, k, folder) for tier, n in counts.items() for k in range(n)]
    truth, details = {}, {}
    with ProcessPoolExecutor(jobs) as pool:
        for name, found in pool.map(_made, work, chunksize=2):
            truth[name], details[name] = judgeable(found)
    return truth, details


def _made(work: tuple[int, str, int, Path]) -> tuple[str, dict[str, Any]]:
    seed, tier, number, folder = work
    case = make(seed, tier, number)
    write(case, folder)
    return case.name, case.truth


def write(case: Made, folder: Path) -> None:
    """The case as the trials lay it: machine/..., and recordings as r00_<name>, r01_<name> in the
    order of their names."""
    files = {path: text for path, text in case.files.items() if path.startswith("machine/")}
    for k, path in enumerate(sorted(case.files.keys() - files.keys())):
        files[f"r{k:02d}_{Path(path).name}"] = case.files[path]
    for path, text in files.items():
        place = folder / case.name / path
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(text, encoding="utf-8")


def judgeable(truth: dict[str, Any]) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """A case's truth as the score wants it, and its tier, plan and noise. A case with a fault of
    the data has a tier of its own: the rows of singles and pairs leave it out."""
    hidden = [t for t in truth["truth"] if t["effect"] not in FAULTS]
    tier = truth["tier"] + ("_fault" if len(hidden) < len(truth["truth"]) else "")
    if "alien" in truth:
        hidden = [{"effect": "alien", "axis": "", **truth["alien"]}]
    hidden = [t | {"twins": t.get("confusable", [])} for t in hidden]
    noise = {"all": {"signal": [{"kind": kind} for kind in truth["noise"]]}}
    return hidden, {"tier": tier, "plan": truth["plan"], "noise": noise}


def checked_out(commit: str, folder: Path) -> None:
    """The tool of a commit, into a folder."""
    packed = subprocess.run(
        ["git", "archive", commit, *TOOL], cwd=trial_seal.ROOT, capture_output=True, check=True
    )
    with tarfile.open(fileobj=io.BytesIO(packed.stdout)) as archive:
        archive.extractall(folder, filter="data")
