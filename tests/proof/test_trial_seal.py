"""A trial is sealed: seeds follow from the freeze, and every byte that was committed is checked."""

from __future__ import annotations

import hashlib
import json
import shutil
import subprocess

import pytest

from proof import trial, trial_leaks, trial_page, trial_run, trial_seal
from proof.trial_seal import Commitment, SealError

TIERS = {"null": 1, "blind": 1}
FREEZE = "0123456789abcdef0123456789abcdef01234567"


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("trial")
    places = trial.Places(FREEZE, True, folder / "work", folder / "kept")
    trial.make(FREEZE, TIERS, places, 1, salt="ab" * 32, say=lambda text: None)
    return places


@pytest.fixture
def places(made, tmp_path):
    """A copy that a test may spoil."""
    shutil.copytree(made.work, tmp_path / "work")
    shutil.copytree(made.kept, tmp_path / "kept")
    return trial.Places(FREEZE, True, tmp_path / "work", tmp_path / "kept")


def check(places):
    trial_seal.check(Commitment.read(places.commitment), places.cases, places.sealed, places.listed)


def test_what_was_committed_is_what_is_there(places):
    check(places)
    commitment = Commitment.read(places.commitment)
    assert commitment.cases == 2 and commitment.freeze == FREEZE
    assert commitment.seeds["null"] == hashlib.sha256(f"{FREEZE}/null".encode()).hexdigest()
    assert commitment.seeds["null"] != commitment.seeds["blind"]


def test_a_byte_of_a_case_that_differs_is_reported_with_its_file(places):
    path = sorted(places.cases.rglob("r1.csv"))[0]
    path.write_bytes(path.read_bytes().replace(b"1", b"2", 1))
    with pytest.raises(
        SealError, match=rf"1 files differ, {path.relative_to(places.cases).as_posix()} first"
    ):
        check(places)


def test_a_file_more_or_less_is_reported(places):
    (places.cases / "more.csv").write_text("x")
    with pytest.raises(SealError, match=r"more\.csv first"):
        check(places)


@pytest.mark.parametrize("name", ["truth.json", "details.json", "salt", "follow_up"])
def test_a_byte_of_the_truth_that_differs_is_reported(places, name):
    path = places.sealed / name
    path = sorted(path.rglob("f*.csv"))[0] if path.is_dir() else path
    path.write_text(path.read_text().replace("a", "b", 1))
    with pytest.raises(SealError, match="the truth in .* is not that which was committed"):
        check(places)


def test_without_its_salt_the_truth_is_not_believed(places):
    (places.sealed / "salt").unlink()
    with pytest.raises(SealError, match="holds no salt"):
        check(places)


def test_answers_other_than_those_laid_down_are_not_scored(places):
    for out in (places.first, places.later):
        (out / "c1").mkdir(parents=True)
        (out / "c1" / "answer.json").write_text("{}")
    laid = {
        "first_sha256": trial_run.digest(places.first),
        "later_sha256": trial_run.digest(places.later),
    }
    (places.kept / "answers.json").write_text(json.dumps(laid))
    (places.first / "c1" / "answer.json").write_text('{"verdict": "unknown"}')
    with pytest.raises(SealError, match="not those whose hash was laid down"):
        trial.score(places, 1, say=lambda text: None)


def test_a_tool_has_one_shot(places):
    (places.first / "c1").mkdir(parents=True)
    with pytest.raises(FileExistsError, match="one shot"):
        trial.run(places, 1, say=lambda text: None)


def test_the_tool_sees_recordings_and_machine_alone_and_answers_the_same_anywhere(places, tmp_path):
    case = sorted(
        p for p in places.cases.iterdir() if not (places.sealed / "follow_up" / p.name).exists()
    )[0]
    moved = tmp_path / "elsewhere" / case.name
    shutil.copytree(case, moved)
    for folder, out in ((case, tmp_path / "a"), (moved, tmp_path / "b")):
        done = trial_run.answer(folder, [], out)
        assert done["status"] == 0 and "said" not in done
    assert trial_run.digest(tmp_path / "a") == trial_run.digest(tmp_path / "b")
    answer = json.loads((tmp_path / "a" / case.name / "answer.json").read_text())
    assert {r["file"] for r in answer["recordings"]} == {p.name for p in case.glob("r*.csv")}


def test_the_same_freeze_gives_the_same_cases_and_another_commitment_is_refused(places, tmp_path):
    shutil.rmtree(places.work)
    again = trial.make(FREEZE, TIERS, places, 1, salt="ab" * 32, say=lambda text: None)
    assert again == Commitment.read(places.commitment)
    known = json.loads(places.commitment.read_text())
    places.commitment.write_text(json.dumps(known | {"cases_sha256": "00"}))
    shutil.rmtree(places.work)
    with pytest.raises(SealError, match="made of other cases"):
        trial.make(FREEZE, TIERS, places, 1, say=lambda text: None)


def test_a_case_says_nothing_of_its_tier(made):
    """Folders, names, heads: nothing of what make was asked for is in what the tool gets."""
    for path in made.cases.rglob("*"):
        told = path.relative_to(made.cases).as_posix() + (
            path.read_text() if path.is_file() else ""
        )
        assert not any(word in told for word in ("null", "blind", "truth", "seed", FREEZE[:10]))
    assert not list(made.cases.rglob("f*.csv"))


@pytest.mark.skipif(shutil.which("git") is None, reason="git")
def test_a_tool_that_moved_since_the_freeze_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(trial_seal, "ROOT", tmp_path)

    def git(*words):
        subprocess.run(
            ["git", "-c", "user.name=t", "-c", "user.email=t@t", *words],
            cwd=tmp_path,
            check=True,
            capture_output=True,
        )

    (tmp_path / "postproc").mkdir()
    (tmp_path / "postproc" / "a.py").write_text("a = 1\n")
    git("init")
    git("add", ".")
    git("commit", "-m", "one")
    commit = trial_seal.frozen("HEAD")
    assert len(commit) == 40
    (tmp_path / "README").write_text("what is not the tool may change")
    assert trial_seal.frozen(commit[:10]) == commit
    (tmp_path / "postproc" / "b.py").write_text("b = 1\n")
    with pytest.raises(SealError, match=r"1 files differ, postproc/b\.py first"):
        trial_seal.frozen("HEAD")
    with pytest.raises(SealError, match="git rev-parse"):
        trial_seal.frozen("nowhere")


# -- leaks -----------------------------------------------------------------------------------------


def noise(count, tell):
    import numpy as np

    rng = np.random.default_rng(3)
    rows = rng.normal(size=(2 * count, 12)).tolist()
    return [[*r, 0.0] for r in rows[:count]], [[*r, float(tell)] for r in rows[count:]]


def test_metadata_that_tell_are_found_and_metadata_that_do_not_are_at_chance():
    assert trial_leaks.told(*noise(40, False)).at_chance
    found = trial_leaks.told(*noise(40, True))
    assert not found.at_chance and found.right / found.count > 0.95


def test_sizes_heads_rows_and_decimals_are_all_among_the_metadata(made, tmp_path):
    case = sorted(made.cases.iterdir())[0]
    before = trial_leaks.metadata(case)

    def changed(edit):
        copy = tmp_path / case.name
        shutil.rmtree(copy, ignore_errors=True)
        shutil.copytree(case, copy)
        path = copy / "r1.csv"
        path.write_text(edit(path.read_text()))
        return trial_leaks.metadata(copy)

    assert changed(lambda text: text) == before
    first = (case / "r1.csv").read_text().splitlines()
    assert changed(lambda text: "# u_um = 0.2\n" + text) != before
    assert changed(lambda text: "\n".join(first[:-1]) + "\n") != before
    assert changed(lambda text: text.replace("\n1,", "\n1.0000,")) != before


def test_the_page_is_rewritten_between_its_marks_and_nowhere_else():
    page = f"before\n{trial.BEGIN}\nold\n{trial.END}\nafter\n"
    once = trial_page.rewritten(page, "new\n", trial.BEGIN, trial.END)
    assert once == f"before\n{trial.BEGIN}\nnew\n{trial.END}\nafter\n"
    assert trial_page.rewritten(once, "new\n", trial.BEGIN, trial.END) == once
    with pytest.raises(ValueError, match="once each"):
        trial_page.rewritten("no marks", "new\n", trial.BEGIN, trial.END)
