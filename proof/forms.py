"""What of the physics of another world the library can say at all: `python -m proof.forms [--kinds
held] [--count N]`.

Cases with one effect of `proof/strangers` are made without noise and without an error of the map.
What is left of the readings beside zeros and set-ups is the effect itself; by least squares every
block of the tool's dictionary is asked how much of it it says. A form of which no shape of its own
name says most is a gap of the library, however good the statistics are; a form that another name
says as well can not be told by that test.
"""

from __future__ import annotations

import argparse
import copy
from collections import Counter, defaultdict
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from typing import Any
from unittest.mock import patch

import numpy as np

from postproc.diagnose import library, noise, nuisances, rows
from proof import laid
from proof.score import same
from proof.strangers import tiers
from proof.strangers.registry import FAMILIES

PER_MM = 1e3  # urad that count as much as a um
OPEN = 5e-3  # mm: a zero or a set-up that is larger is taken out
SURE = 1e-4  # mm
NEAR = 0.003  # of the squares: a name that says so much less says it as well


def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(
        prog="python -m proof.forms", description=__doc__.splitlines()[0]
    )
    parser.add_argument("--kinds", choices=FAMILIES, default="open")
    parser.add_argument("--seed", default="forms")
    parser.add_argument("--count", type=int, default=100)
    options = parser.parse_args(argv)
    said: dict[tuple[str, str], list[tuple[float, str]]] = defaultdict(list)
    with ProcessPoolExecutor() as pool:
        for found in pool.map(
            partial(one, options.seed, kinds=options.kinds), range(options.count), chunksize=4
        ):
            if found:
                said[found[0]].append(found[1:])
    print(
        "| effect | form | cases | share of its squares that its own name says | names that say as"
        " much |"
    )
    print("|---|---|---:|---|---|")
    for (effect, form), cases in sorted(said.items()):
        shares = " ".join(f"{share:.2f}" for share, _ in sorted(cases))
        rivals = ", ".join(
            f"{name} {n}" for name, n in Counter(name for _, name in cases if name).most_common(4)
        )
        print(f"| {effect} | {form} | {len(cases)} | {shares} | {rivals} |")
    return 0


def one(seed: str, number: int, kinds: str) -> tuple[tuple[str, str], float, str] | None:
    """(effect, form), the share of its squares that the library says, and another name that says as
    much or ""; None for a case without a truth, or one that can not be read."""
    with (
        patch.object(tiers, "put", _still(tiers.put)),
        patch.object(tiers, "map_error", _true(tiers.map_error)),
    ):
        case = tiers.make(seed, "single", number, kinds)
    if not case.truth:
        return None
    truth = case.truth[0]
    with laid.folder(case) as place:
        table = laid.table(place)
    if table is None:
        return None
    own, other, rival = _said(table, f"{truth['effect']}:{truth['axis'] or ''}")
    return (
        (truth["effect"], truth["form"]),
        own,
        rival.partition(":")[0] if other > own - NEAR else "",
    )


def _still(put: Any) -> Any:
    def without(world: Any, recording: Any, number: int, noises: list, *rest: Any) -> Any:
        quiet = []
        for one in noises:
            still = copy.copy(one)
            still.values, still.quant = np.zeros_like(one.values), 0
            quiet.append(still)
        return put(world, recording, number, quiet, *rest)

    return without


def _true(map_error: Any) -> Any:
    return lambda machine, place: tuple(0.0 * part for part in map_error(machine, place))


def _said(table: rows.Rows, key: str) -> tuple[float, float, str]:
    """Shares of the squares that the best block of a name says, and of any other name, and that
    name."""
    weight = np.where(table.sees == "angle", PER_MM, 1.0)
    free = []
    for unit in noise.units(table):
        for group in nuisances.of_unit(table, unit):
            if group.kind in ("zero", "set-up") and group.sd > OPEN:
                wide = np.zeros((len(table), group.columns.shape[1]))
                wide[unit.rows] = group.columns
                free.append(wide)
    q, r = (
        np.linalg.qr(np.concatenate(free, axis=1) * weight[:, None])
        if free
        else (np.zeros((len(table), 0)),) * 2
    )
    size = np.abs(np.diag(r))
    q = q[:, size > 1e-9 * size.max(initial=1e-30)]
    y = table.residual * weight
    y = y - q @ (q.T @ y)
    blocks = list(library.blocks(table)) + library.found(
        table, y / weight / SURE**2, np.full(len(table), SURE)
    )
    best: dict[str, float] = defaultdict(lambda: 0.0)
    for block in blocks:
        x = block.columns * weight[:, None]
        x = x - q @ (q.T @ x)
        left = y - x @ np.linalg.lstsq(x, y, rcond=1e-9)[0]
        name = key if same(key, block.key) else block.key
        best[name] = max(best[name], 1.0 - float(left @ left) / max(float(y @ y), 1e-30))
    own = best.pop(key, 0.0)
    rival = max(best, key=lambda name: best[name], default="")
    return own, best.get(rival, 0.0), rival


if __name__ == "__main__":
    raise SystemExit(main())
