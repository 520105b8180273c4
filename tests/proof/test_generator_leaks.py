"""Names, sizes, rows and heads of a case tell nothing of what is hidden in it."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest

from proof.generator import cases, make

SEED = "leak"
made = lru_cache(None)(make)  # a case that several tests ask for


@pytest.fixture(autouse=True)
def untold(monkeypatch):
    """Files alone are looked at here; what is hidden in them, and what else would explain it, is
    worked out behind them."""
    monkeypatch.setattr(cases, "_truth", lambda *_: [])


def parts(text: str) -> tuple[list[str], list[str], int]:
    """Head lines, column names, number of rows of a recording."""
    lines = text.splitlines()
    head = [line for line in lines if line.startswith("#")]
    return head, lines[len(head)].split(","), len(lines) - len(head) - 1


@pytest.mark.parametrize("kind", ["single", "pair", "triple", "alien", "adversarial", "withheld"])
def test_only_readings_change_when_the_effect_is_taken_out(kind, monkeypatch):
    """The same case with nothing hidden: the same names, machine, heads, columns, rows, times,
    positions and channels."""
    for number in range(3):
        case = made(SEED, kind, number)
        with monkeypatch.context() as patch:
            patch.setattr(cases, "_hide", lambda *args: [])
            bare = make(SEED, kind, number)
        assert case.name == bare.name and list(case.files) == list(bare.files)
        for name, text in case.files.items():
            if name.startswith("machine"):
                assert text == bare.files[name]
                continue
            assert parts(text) == parts(bare.files[name])
            assert len(text) == pytest.approx(len(bare.files[name]), rel=0.015)
            names = parts(text)[1]
            kept = [
                i
                for i, n in enumerate(names)
                if not n.startswith(("reading_u", "radial_", "measured_")) and "_act_" not in n
            ]
            kept = [i for i in kept if not names[i].endswith("_A")]
            rows, others = text.splitlines()[-50:], bare.files[name].splitlines()[-50:]
            for row, other in zip(rows, others, strict=True):
                a, b = row.split(","), other.split(",")
                assert [a[i] for i in kept] == [b[i] for i in kept]


def metadata(case) -> list[float]:
    """What a cheat would look at: everything of a case but its numbers."""
    recordings = [case.files[n] for n in case.files if n.startswith("r")]
    described = [parts(text) for text in recordings]
    rows = np.array([count for _, _, count in described], float)
    size = np.array([len(text) for text in recordings], float)
    kinds = [
        sum(f'kind = "{k}"' in "".join(head) for head, _, _ in described)
        for k in ("targets", "ballbar", "trace", "features")
    ]
    columns = [len(names) for _, names, _ in described]
    present = [
        any(n.startswith(p) for _, names, _ in described for n in names)
        for p in ("T_", "force_", "spindle", "feed_")
    ]
    return [
        len(recordings),
        rows.sum(),
        rows.max(),
        rows.min(),
        *kinds,
        sum(columns),
        max(columns),
        *present,
        *np.log([size.sum(), size.max(), size.min()]),
        (size / rows).max(),
        (size / rows).min(),
        size.sum() / rows.sum(),
        float(np.mean([len(head) for head, _, _ in described])),
        len(case.files["machine/machine.toml"]),
        *(int(c, 16) for c in case.name[1:]),
    ]


def guessed(first: list[list[float]], second: list[list[float]]) -> float:
    """Share of cases that a ridge classifier tells right, each judged by one that was trained on
    the other folds."""
    values = np.array(first + second)
    sign = np.r_[-np.ones(len(first)), np.ones(len(second))]
    values = np.c_[
        (values - values.mean(axis=0)) / (values.std(axis=0) + 1e-9), np.ones(len(values))
    ]
    order = np.random.default_rng(0).permutation(len(values))
    right = 0
    for fold in range(5):
        test = order[fold::5]
        train = np.setdiff1d(order, test)
        normal = values[train].T @ values[train] + 10 * np.eye(values.shape[1])
        weights = np.linalg.solve(normal, values[train].T @ sign[train])
        right += int((np.sign(values[test] @ weights) == sign[test]).sum())
    return right / len(values)


def test_a_classifier_on_metadata_is_at_chance():
    """Within three standard deviations of one half; a classifier that is given the effect's
    presence outright is not."""
    count = 50
    null = [metadata(made(SEED, "null", k)) for k in range(count)]
    single = [metadata(made(SEED, "single", k)) for k in range(count)]
    limit = 3 * 0.5 / np.sqrt(2 * count)
    assert abs(guessed(null, single) - 0.5) < limit
    assert guessed([[*m, 0.0] for m in null], [[*m, 1.0] for m in single]) - 0.5 > limit


def test_names_are_opaque_and_differ():
    names = [made(SEED, kind, k).name for kind in ("null", "adversarial") for k in range(20)]
    assert len(set(names)) == 40
    assert all(len(n) == 9 and n[0] == "c" and set(n[1:]) <= set("0123456789abcdef") for n in names)
