"""What no statistics can part: `python -m proof.ceiling [--kinds later] [--count N]`.

Cases with one effect of `proof/strangers` are read by the tool, and its dictionary is judged beside
the covariance that the readings really have (noise, wander, the map's error; zeros free), as the
generator's oracle knows it, in the place of one that is learned from them. The name of the block
that is worth most is compared with the truth. Where it is another one, the forms of the library are
what is missing, or two names say the same: no better account of the noise finds the truth there.
For development: a family that is held back is not for it. Left out are long traces whose
samples the tool averages.
"""

from __future__ import annotations

import argparse
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from types import SimpleNamespace
from typing import Any
from unittest.mock import patch

import numpy as np

from postproc.diagnose import library, rows, shapes
from postproc.diagnose.prior import cost_of
from proof import laid
from proof.score import same
from proof.strangers import tiers
from proof.strangers.oracle import Oracle
from proof.strangers.registry import FAMILIES

UM, URAD = 1e3, 1e6  # of a mm, of a rad
SURE = 1e-3  # mm: beside it periodic blocks are looked for
POLISHED = 6  # names whose shapes are refined
MOST_ORDER = 8  # of an autoregression
UNREAD = 1e12  # um^2: the variance of a reading that the tool does not use


@dataclass(frozen=True)
class Answer:
    """The truth, the names in the order of their worth (twice the logarithm of the Bayes factor,
    less their cost)."""

    truth: str
    peak_um: float
    form: str
    names: list[tuple[str, float]]

    @property
    def right(self) -> bool:
        return bool(self.names) and same(self.truth, self.names[0][0])


class Covariance:
    """The true covariance of the readings in a table of the tool, as products of columns: stands
    where the tool asks its evidence."""

    def __init__(self, oracle: Oracle, noises: list, table: rows.Rows, heads: list[int]):
        self.oracle, self.table = oracle, table
        self.unit = np.where(table.sees == "angle", URAD, UM)
        self.channel, self.reading = np.zeros(len(table), int), np.zeros(len(table), int)
        for number, recording in enumerate(oracle.recs):
            own = table.file == number
            gone = noises[number][0].gone
            kept = np.arange(recording.n_obs) if gone is None else np.flatnonzero(~gone)
            self.reading[own] = kept[table.line[own] - heads[number]]
            if recording.kind == "trace":
                self.channel[own] = [
                    recording.channels.index(int(k))
                    for k in np.abs(table.direction[own]).argmax(axis=1)
                ]
        for k, (recording, channel, *_) in enumerate(oracle.ready):
            read = np.zeros(recording.n_obs, bool)
            number = next(i for i, r in enumerate(oracle.recs) if r is recording)
            read[self.reading[(table.file == number) & (self.channel == channel)]] = True
            # what is predicted from an unread one
            behind = np.convolve(~read, np.ones(1 + MOST_ORDER))[: len(read)] > 0
            oracle.parts[k][4][behind] = UNREAD
        oracle.ready = [oracle.prepare(*part) for part in oracle.parts]

    def beside(self, fit: Any, columns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(K, K) and (K,): products of columns (N, K) mm with one another and with the readings."""
        both = np.column_stack([columns, self.table.residual])
        spread = [
            [np.zeros((len(r.channels), r.n_obs)) for r in self.oracle.recs]
            for _ in range(both.shape[1])
        ]
        for number in range(len(self.oracle.recs)):
            own = np.flatnonzero(self.table.file == number)
            for k in range(both.shape[1]):
                spread[k][number][self.channel[own], self.reading[own]] = (
                    both[own, k] * self.unit[own]
                )
        products = self.oracle.gram(spread)
        return products[:-1, :-1], products[:-1, -1]


def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(
        prog="python -m proof.ceiling", description=__doc__.splitlines()[0]
    )
    parser.add_argument("--kinds", choices=FAMILIES, default="open")
    parser.add_argument("--seed", default="ceiling")
    parser.add_argument("--count", type=int, default=60)
    options = parser.parse_args(argv)
    with ProcessPoolExecutor() as pool:
        found = list(
            pool.map(
                partial(one, options.seed, kinds=options.kinds), range(options.count), chunksize=2
            )
        )
    answers = [a for a in found if isinstance(a, Answer)]
    print("| truth | form | um | names by the true covariance |")
    print("|---|---|---:|---|")
    for a in sorted(answers, key=lambda a: (a.right, a.truth)):
        print(
            f"| {a.truth} | {a.form} | {a.peak_um:.1f} |"
            f" {', '.join(f'{n} {w:.0f}' for n, w in a.names[:4])} |"
        )
    left_out = Counter(a for a in found if isinstance(a, str))
    print(
        f"\nfirst name right: {sum(a.right for a in answers)} of {len(answers)}; left out:"
        f" {dict(left_out)}"
    )
    return 0


def one(seed: str, number: int, kinds: str) -> Answer | str:
    """The answer to one case, or why there is none."""
    known: list[tuple[Oracle, list]] = []

    def kept(machine: Any, recs: list, noises: list, factor: float) -> Oracle:
        oracle = Oracle(machine, recs, noises, factor)
        known.append((oracle, noises))
        return oracle

    with patch.object(tiers, "Oracle", kept):
        case = tiers.make(seed, "single", number, kinds)
    seen = [t for t in case.truth if t.get("visible", True)]
    if not seen:
        return "nothing shows"
    with laid.folder(case) as place:
        files, table = laid.files(place), laid.table(place)
        heads = [
            1 + next(k for k, line in enumerate(f.read_text().splitlines(), 1) if line[0] != "#")
            for f in files
        ]
    if table is None:
        return "not read"
    if len(table.files) != len(files) or table.grain.any():
        return "averaged or left out"
    truth = f"{seen[0]['effect']}:{seen[0]['axis'] or ''}"
    return Answer(
        truth,
        seen[0]["peak_um"],
        seen[0]["form"],
        _names(Covariance(*known[0], table, heads), table),
    )


def _names(covariance: Covariance, table: rows.Rows) -> list[tuple[str, float]]:
    """Names and what the best block of each is worth, the best first."""
    sigma = np.full(len(table), SURE)
    blocks = list(library.blocks(table)) + library.found(table, table.residual / sigma**2, sigma)
    sets: Any = SimpleNamespace(rows=table, blocks=blocks, evidence=covariance, tried={})
    beside: Any = None  # the covariance asks for no fit
    sets.let_in = lambda block: sets.blocks.append(block) or len(sets.blocks) - 1

    def worth(k: int) -> float:
        return shapes.worths(sets, beside, [sets.blocks[k]])[0] - cost_of(sets.blocks[k])

    best: dict[str, tuple[float, int]] = {}
    for k in range(len(blocks)):
        key, value = blocks[k].key, worth(k)
        if np.isfinite(value) and value > best.get(key, (-np.inf, 0))[0]:
            best[key] = (value, k)
    for key in sorted(best, key=lambda key: -best[key][0])[:POLISHED]:
        k = shapes.polished(sets, beside, best[key][1])
        best[key] = (worth(k), k)
    return sorted(((key, value) for key, (value, _) in best.items()), key=lambda one: -one[1])


if __name__ == "__main__":
    raise SystemExit(main())
