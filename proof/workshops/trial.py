"""The cases of workshops as the trials of `proof.worlds` want them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from proof import worlds

from .tiers import make


def made(
    seed: int, counts: dict[str, int], folder: Path, jobs: int
) -> tuple[dict[str, worlds.Truth], dict[str, Any]]:
    """Cases under the folder; truth and details by name, as the score wants them. jobs: not used,
    as which form comes next depends on the cases before."""
    truth, details = {}, {}
    for case in make(seed, counts):
        worlds.write(case.name, case.files, folder)
        truth[case.name], details[case.name] = judgeable(case.truth)
    return truth, details


def judgeable(truth: dict[str, Any]) -> tuple[worlds.Truth, dict[str, Any]]:
    """A case's truth as the score wants it, and its tier, plan and noise."""
    hidden = [t | {"twins": t["effect_also"]} for t in truth["truth"]]
    if truth["tier"] == "alien":
        hidden = [t | {"axis": ""} for t in hidden]
    noises = [kind for noise in truth["noise"] for kind in _kinds(noise)]
    return worlds.judged_by(truth["tier"], hidden, truth["plan"], noises)


def _kinds(noise: dict[str, Any]) -> list[str]:
    """What was done to the readings, or the first words of what is said of an instrument."""
    if "harsh" in noise:
        return [noise["harsh"]]
    return [" ".join(note.split()[:2]).strip(",") for note in noise["notes"]]
