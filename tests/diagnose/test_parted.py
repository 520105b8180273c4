"""One cause of all axes gives way to two of one axis that say the same readings clearly better, and to none that do not."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from postproc.diagnose.fit import Projector
from postproc.diagnose.parted import parted

RNG = np.random.default_rng(11)
N = 60
HEAT, SCALE = RNG.normal(size=(2, N))
OTHER = RNG.normal(size=N)


class Readings:
    """What a search knows, of three blocks: 0 with two sizes and of no axis, 1 and 2 with one size each."""

    least, penalty = 28.0, np.array([10.0, 5.0, 5.0])

    def __init__(self, y: np.ndarray, per: str = "all"):
        self.y = y
        columns = [np.stack([HEAT + 0.3 * OTHER, SCALE], axis=1), HEAT[:, None], SCALE[:, None]]
        keys = ["laser_air:", "screw_heat:Z", "scale:Z"]
        pers = [per, "axis", "axis"]
        self.blocks = [
            SimpleNamespace(columns=c, key=k, module=SimpleNamespace(PER=p))
            for c, k, p in zip(columns, keys, pers, strict=True)
        ]

    def projector(self, chosen: list[int], sigma: np.ndarray) -> Projector:
        u = np.concatenate([np.ones((N, 1)), *(self.blocks[k].columns for k in chosen)], axis=1)
        return Projector.of(sigma, u, np.full(u.shape[1], 1e3))

    def worth(self, rest: list[int], k: int, sigma: np.ndarray) -> float:
        fall = self.projector(rest, sigma).chi2(self.y) - self.projector([*rest, k], sigma).chi2(self.y)
        return fall - self.penalty[k]

    def scores(self, chosen: list[int], sigma: np.ndarray) -> np.ndarray:
        return np.array([self.worth(chosen, k, sigma) for k in range(len(self.blocks))])

    def fits(self, chosen: list[int], k: int, sigma: np.ndarray) -> bool:
        return k not in chosen


@pytest.mark.parametrize(
    "share, per, chosen",
    [(0.0, "all", [1, 2]), (0.3, "all", [0]), (0.0, "axis", [0])],
    ids=["two say it better", "one says it", "it is of one axis itself"],
)
def test_one_or_two(share, per, chosen):
    y = 10 * (HEAT + share * OTHER) + 8 * SCALE + 0.5 * RNG.normal(size=N)
    assert sorted(parted(Readings(y, per), [0], np.full(N, 0.5), 6)) == chosen
