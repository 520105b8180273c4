"""Whether anything of a case but its readings tells what is hidden: a classifier on metadata must
be at chance.

It sees names, number of files, sizes, head keys, columns, rows, decimals of every column, order of
files; it is a ridge classifier, judged on folds that it was not trained on. Chance is inside the 95
% interval of its share of right answers.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from proof.score_table import wilson

FOLDS = 5
KINDS = ("targets", "ballbar", "trace", "features")
CHANNELS = ("T_", "force_", "spindle", "feed_", "sense", "reading_", "radial_")


@dataclass
class Leak:
    """right of count cases told; interval: Wilson, 95 %; at_chance: one half lies in it."""

    right: int
    count: int
    interval: tuple[float, float]
    at_chance: bool


def metadata(case: Path) -> list[float]:
    """What a cheat would look at."""
    texts = [p.read_text() for p in sorted(case.glob("r*.csv"))]
    found: list[float] = []
    rows, sizes, widths, heads, decimals = [], [], [], [], []
    for text in texts:
        lines = text.splitlines()
        head = [line for line in lines if line.startswith("#")]
        body = lines[len(head) + 1 :]
        heads.append(len(head))
        rows.append(len(body))
        sizes.append(len(text))
        widths.append(len(lines[len(head)].split(",")))
        step = max(1, len(body) // 20)
        cells = [c for line in body[::step] for c in line.split(",")]
        decimals.append(np.mean([len(c.partition(".")[2]) for c in cells]))
    whole = "".join(texts)
    for values in (rows, sizes, widths, heads, decimals):
        found += [
            float(np.sum(values)),
            float(np.max(values)),
            float(np.min(values)),
            float(values[0]),
            float(values[-1]),
        ]
    found += [float(len(texts)), float(np.sum(sizes)) / float(np.sum(rows)), float(len(set(whole)))]
    found += [float(whole.count(f'kind = "{k}"')) for k in KINDS] + [
        float(any(c in t for t in texts)) for c in CHANNELS
    ]
    machine = sorted((case / "machine").iterdir())
    found += [float(len(machine)), float(sum(p.stat().st_size for p in machine))]
    return found + [
        float(int(c, 16)) if c in "0123456789abcdef" else -1.0 for c in case.name[1:9].ljust(8, "0")
    ]


def leak(first: list[Path], second: list[Path]) -> Leak:
    """Two kinds of cases, as many of each: can their metadata be told apart?"""
    n = min(len(first), len(second))
    return told([metadata(c) for c in first[:n]], [metadata(c) for c in second[:n]])


def told(first: list[list[float]], second: list[list[float]]) -> Leak:
    """The classifier on rows of numbers, as many of one kind as of the other."""
    if min(len(first), len(second)) < FOLDS:
        return Leak(0, 0, (0.0, 1.0), True)
    n = min(len(first), len(second))
    values = np.array(first[:n] + second[:n])
    sign = np.r_[-np.ones(n), np.ones(n)]
    values = np.c_[(values - values.mean(axis=0)) / (values.std(axis=0) + 1e-9), np.ones(2 * n)]
    order = np.argsort(
        np.r_[np.random.default_rng(0).permutation(n), np.random.default_rng(1).permutation(n)],
        kind="stable",
    )
    right = 0
    for fold in range(FOLDS):
        test = order[fold::FOLDS]
        train = np.setdiff1d(order, test)
        normal = values[train].T @ values[train] + 10 * np.eye(values.shape[1])
        weights = np.linalg.solve(normal, values[train].T @ sign[train])
        right += int((np.sign(values[test] @ weights) == sign[test]).sum())
    low, high = wilson(right, 2 * n)
    return Leak(right, 2 * n, (low, high), low <= 0.5 <= high)
