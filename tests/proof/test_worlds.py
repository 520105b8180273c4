"""Worlds that know nothing of the tool: what they share with others, and their trials."""

from __future__ import annotations

import ast
import importlib
import json
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
WORLDS = ("textbook", "workshops")
SOURCES = [path for world in WORLDS for path in sorted((ROOT / "proof" / world).glob("*.py"))]
SCORE = {"score", "score_table", "strangers_trial", "trial_run", "trial_seal"}


def imports(path: Path) -> tuple[set[str], set[str]]:
    """Modules of `proof`, and all other packages; of its own package it names none in full."""
    from_proof, packages = set(), set()
    for node in ast.walk(ast.parse(path.read_text())):
        names = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level <= 1, "of its own package, or in full"
            if node.level == 0:
                names = [f"{node.module}.{alias.name}" for alias in node.names]
        for name in names:
            package, _, rest = name.partition(".")
            if package == "proof":
                from_proof.add(rest.split(".")[0])
            else:
                packages.add(package)
    return from_proof, packages


@pytest.mark.parametrize("path", SOURCES, ids=lambda p: f"{p.parent.name}-{p.name}")
def test_a_world_shares_no_code_with_the_tool_nor_with_other_generators(path):
    """Only the trial knows of others, and of these only what turns cases into a score."""
    from_proof, packages = imports(path)
    assert from_proof <= ({"worlds"} if path.name in ("trial.py", "__main__.py") else set())
    assert not packages & {"postproc", "gcomp", "tests", "benchmarks"}


def test_trials_know_of_the_rest_only_the_score():
    from_proof, packages = imports(ROOT / "proof" / "worlds.py")
    assert from_proof == SCORE
    assert not packages & {"postproc", "gcomp", "tests", "benchmarks"}


@pytest.mark.parametrize(
    ("world", "names"),
    [("textbook", ["null_000", "single_000"]), ("workshops", ["shop-0001", "shop-0002"])],
)
def test_a_trial_leaves_answers_truth_and_score(world, names, tmp_path, capsys):
    main = importlib.import_module(f"proof.{world}.__main__").main
    words = ["--seed", "1", "--counts", "null=1,single=1", "-o", str(tmp_path), "--jobs", "1"]
    assert main(words) == 0
    table = capsys.readouterr().out
    assert "| nulls with any name | 1 |" in table and table.startswith("| what | n | value |")
    assert (tmp_path / "TABLE.md").read_text().strip() == table.strip()
    truth = json.loads((tmp_path / "truth.json").read_text())
    assert sorted(truth) == names and sorted(map(len, truth.values())) == [0, 1]
    for name in truth:
        assert (tmp_path / "answers" / name / "answer.json").is_file()
        assert (tmp_path / "cases" / name / "machine" / "machine.toml").is_file()
    assert len(json.loads((tmp_path / "score.json").read_text())["now"]) == 2
    assert main(words) == 2 and "name another folder" in capsys.readouterr().err
    other = [*words[:4], "-o", str(tmp_path / "other"), "--beside", "no-such-commit"]
    assert main(other) == 2 and "no-such-commit" in capsys.readouterr().err
    assert not (tmp_path / "other").exists()
