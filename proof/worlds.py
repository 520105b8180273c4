"""Trials of the tool on worlds that know nothing of it: cases are made, answered and scored.

What `proof.textbook` and `proof.workshops` share, and all that they know of `proof`. It knows the
tool by its command, and the score of the other trials.
"""

from __future__ import annotations

import argparse
import io
import json
import os
import subprocess
import sys
import tarfile
import tempfile
from collections.abc import Callable, Iterable
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

from proof import score, score_table, strangers_trial, trial_run, trial_seal

COUNTS = {"null": 40, "adversarial": 15, "single": 90, "pair": 24, "alien": 24}
# Faults of the data are reported as such, and not as effects (contract of answers).
FAULTS = {"outlier", "sensor_drift"}
TOOL = ("postproc", "machines")  # what a commit's tool needs

Truth = list[dict[str, Any]]
# seed, tier -> cases, folder, jobs: cases under the folder; truth and details by name
Make = Callable[[int, dict[str, int], Path, int], tuple[dict[str, Truth], dict[str, Any]]]


def main(world: str, doc: str | None, make: Make, argv: list[str] | None) -> int:
    """The command `python -m proof.<world>`; returns its status."""
    parser = argparse.ArgumentParser(
        prog=f"python -m proof.{world}",
        description=doc,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--seed", type=int, required=True, help="every case follows from it")
    parser.add_argument(
        "--counts",
        type=partial(strangers_trial.counts, tiers=COUNTS),
        default=COUNTS,
        help="how many cases of which tiers, such as null=60,single=128",
    )
    parser.add_argument(
        "-o", "--output", type=Path, help=f"a new folder (build/{world}/<seed> of the repository)"
    )
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--beside", metavar="COMMIT", help="its tool on the same cases, too")
    options = parser.parse_args(argv)
    out = options.output or trial_seal.ROOT / "build" / world / str(options.seed)
    try:
        print(trial(make, options.seed, options.counts, out, options.jobs, options.beside))
    except (FileExistsError, trial_seal.SealError) as error:
        print(f"{world}: {error}", file=sys.stderr)
        return 2
    return 0


def trial(
    make: Make, seed: int, counts: dict[str, int], out: Path, jobs: int, beside: str | None
) -> str:
    """Cases, answers, truth and score under a folder; the table. counts: tier -> cases; beside: a
    commit whose tool answers the same cases, too. FileExistsError where the folder holds any,
    SealError where there is no such commit."""
    cases = out / "cases"
    if cases.exists():
        raise FileExistsError(f"{cases} exists: name another folder")
    other = beside and trial_seal.git("rev-parse", "--verify", f"{beside}^{{commit}}").strip()
    truth, details = make(seed, counts, cases, jobs)
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


def write(name: str, files: dict[str, str], folder: Path) -> None:
    """A case as the trials lay it: machine/..., and recordings as r00_<name>, r01_<name> in the
    order of their names."""
    recordings = sorted(path for path in files if not path.startswith("machine/"))
    to = {path: f"r{k:02d}_{Path(path).name}" for k, path in enumerate(recordings)}
    for path, text in files.items():
        place = folder / name / to.get(path, path)
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(text, encoding="utf-8")


def judged_by(
    tier: str, hidden: Truth, plan: Any, noises: Iterable[str]
) -> tuple[Truth, dict[str, Any]]:
    """A case's truth as the score wants it, and its tier, plan and noise. A case with a fault of
    the data has a tier of its own: the rows of singles and pairs leave it out."""
    effects = [t for t in hidden if t["effect"] not in FAULTS]
    tier = tier + ("_fault" if len(effects) < len(hidden) else "")
    noise = {"all": {"signal": [{"kind": kind} for kind in noises]}}
    return effects, {"tier": tier, "plan": plan, "noise": noise}


def checked_out(commit: str, folder: Path) -> None:
    """The tool of a commit, into a folder."""
    packed = subprocess.run(
        ["git", "archive", commit, *TOOL], cwd=trial_seal.ROOT, capture_output=True, check=True
    )
    with tarfile.open(fileobj=io.BytesIO(packed.stdout)) as archive:
        archive.extractall(folder, filter="data")
