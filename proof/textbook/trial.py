"""The cases of the textbooks as the trials of `proof.worlds` want them."""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

from proof import worlds

from .tiers import make


def made(
    seed: int, counts: dict[str, int], folder: Path, jobs: int
) -> tuple[dict[str, worlds.Truth], dict[str, Any]]:
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
    worlds.write(case.name, case.files, folder)
    return case.name, case.truth


def judgeable(truth: dict[str, Any]) -> tuple[worlds.Truth, dict[str, Any]]:
    """A case's truth as the score wants it, and its tier, plan and noise."""
    hidden = truth["truth"]
    if "alien" in truth:
        hidden = [{"effect": "alien", "axis": "", **truth["alien"]}]
    hidden = [t | {"twins": t.get("confusable", [])} for t in hidden]
    return worlds.judged_by(truth["tier"], hidden, truth["plan"], truth["noise"])
