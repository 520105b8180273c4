"""Every effect of the library, on every axis that can show it, at every value of what does not enter linearly: blocks of
columns as the readings would show them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations
from types import ModuleType

import numpy as np

from postproc import effects
from postproc.diagnose.rows import Rows, pick_state

SIGNALS = {  # what an effect must be able to show in -> kinds of signals
    "tool": ("laser", "tool"), "scale": ("scale",), "part": ("part",), "laser": ("laser",), "trace": ("tool",),
}  # fmt: skip
MOST_STEPS = 400
PERIODS, FREQUENCIES = 240, 300
LOWEST_HZ = 2.0  # slower, it is drift


@dataclass(frozen=True)
class Block:
    """One way to explain: an effect, its axis, its shape, and the (N, K) mm that it would add to the readings."""

    module: ModuleType
    axis: str
    shape: tuple[tuple[str, float], ...]
    columns: np.ndarray
    siblings: int = 1

    @property
    def name(self) -> str:
        return self.module.__name__.rsplit(".", 1)[1]

    @property
    def key(self) -> str:
        """effect:axis, as the contract writes it."""
        return f"{self.name}:{self.axis}"


def visible(rows: Rows, module: ModuleType) -> np.ndarray:
    """(N,) bool: rows in which the effect can show."""
    kinds = [kind for sees in module.SEES for kind in SIGNALS[sees]]
    seen = np.isin(rows.sees, kinds)
    if "trace" in module.SEES or ("laser" in module.SEES and module.KIND == "instrument"):
        files = np.array([k in (("trace",) if "trace" in module.SEES else ("targets",)) for k in rows.kinds])
        seen &= files[rows.file]
    return seen


def needed(rows: Rows, module: ModuleType, axis: str) -> bool:
    """Whether the rows tell what the effect depends on."""
    state = rows.state
    for need in module.NEEDS:
        letters = axis or "".join(state.position)
        if need == "velocity" and not any(np.any(state.velocity[x]) for x in letters):
            return False
        if need == "acceleration" and not any(np.any(state.acceleration[x]) for x in letters):
            return False
        if need == "since" and not any(np.any(state.since[x] < 1e5) for x in letters):
            return False
        if need == "approach" and not any(np.ptp(state.approach[x]) > 0 for x in letters):
            return False
        if need == "force" and np.ptp(state.channels.get(f"force_{axis}_N", np.zeros(1))) == 0:
            return False
        if need in ("part", "T_air_C", "spindle_rpm") and np.ptp(state.channels.get(need, np.zeros(1))) == 0:
            return False
        if need == "angles" and axis not in state.angles:
            return False
    return True


def read(rows: Rows, module: ModuleType, axis: str, shape: dict[str, float]) -> np.ndarray:
    """(N, K) mm: the columns of an effect as the readings show them."""
    value = module.columns(rows.state, axis, **shape)
    seen = visible(rows, module)
    if value.ndim == 2:
        return np.where(seen, value, 0.0).T
    if rows.other and "part" in module.SEES and module.PER != "all" and "part" not in module.NEEDS:
        part = (rows.sees == "part") & np.all([np.isfinite(v) for v in rows.other.values()], axis=0)
        there = pick_state(rows.state, part)
        for x in there.position:
            there.position[x] = rows.other[x][part]
        value = value.copy()
        value[:, :, part] -= module.columns(there, axis, **shape)
    return np.where(seen[:, None], np.einsum("kin,ni->nk", value, rows.direction), 0.0)


def axes_of(rows: Rows, module: ModuleType) -> list[str]:
    moving = [
        x
        for x in rows.state.position
        if any(np.ptp(rows.state.position[x][rows.signal == s]) > 1e-3 for s in np.unique(rows.signal))
    ]
    if module.PER == "all":
        return [""]
    if module.PER == "pair":
        return ["".join(pair) for pair in combinations(sorted(moving), 2)]
    return moving


def blocks(rows: Rows) -> list[Block]:
    """The dictionary. Blocks that show nothing in these readings are left out."""
    result: list[Block] = []
    for name in effects.names():
        module = effects.load(name)
        if not visible(rows, module).any():
            continue
        for axis in axes_of(rows, module):
            if not needed(rows, module, axis):
                continue
            shapes = list(_shapes(rows, name, module, axis))
            found = []
            for shape in shapes:
                columns = read(rows, module, axis, shape)
                keep = np.abs(columns).max(axis=0) > 1e-9
                if keep.all() and np.isfinite(columns).all():
                    found.append((shape, columns))
            result += [Block(module, axis, tuple(sorted(s.items())), c, len(found)) for s, c in found]
    return result


def _shapes(rows: Rows, name: str, module: ModuleType, axis: str) -> Iterator[dict[str, float]]:
    if name in ("cyclic", "encoder_cyclic"):
        yield from ({"period_mm": p} for p in _periods(rows, module, axis))
    elif name == "vibration":
        yield from ({"frequency_hz": f} for f in _frequencies(rows))
    elif name == "step_loss":
        yield from ({"t_s": t} for t in _steps(rows))
    else:
        yield from module.shapes(rows.state, axis)


def _periods(rows: Rows, module: ModuleType, axis: str) -> list[float]:
    """mm: periods that the targets or samples resolve, at even steps of the frequency."""
    seen = visible(rows, module)
    best: tuple[float, float] = (0.0, 0.0)
    for signal in np.unique(rows.signal[seen]):
        which = seen & (rows.signal == signal)
        p = np.unique(np.round(rows.state.position[axis][which], 4))
        if len(p) > 6 and np.ptp(p) > 0:
            span, step = float(np.ptp(p)), float(np.median(np.diff(p)))
            finest = max(2.5 * step, 0.5)
            if 1 / finest > best[1]:
                best = (max(best[0], span), 1 / finest)
    if best[1] == 0.0:
        return []
    lowest = 3.0 / best[0]
    if best[1] <= lowest:
        return []
    number = int(min(PERIODS, (best[1] - lowest) * best[0] * 2.5) + 2)
    return [float(1 / f) for f in np.linspace(lowest, best[1], number)]


def _frequencies(rows: Rows) -> list[float]:
    """Hz: what sampled signals resolve."""
    highest, span = 0.0, 0.0
    for signal in np.unique(rows.signal):
        which = np.flatnonzero(rows.signal == signal)
        if rows.kinds[rows.file[which[0]]] not in ("ballbar", "trace"):
            continue
        t = rows.state.time[which]
        step = np.diff(t)
        step = step[(step > 0) & (step < 5)]
        if len(step):
            highest, span = (
                max(highest, 0.4 / float(np.median(step))),
                max(span, float(np.sum(step)) / max(len(np.unique(rows.run[which])), 1)),
            )
    if highest <= LOWEST_HZ:
        return []
    return [float(f) for f in np.geomspace(LOWEST_HZ, highest, FREQUENCIES)]


def _steps(rows: Rows) -> list[float]:
    """s: between two readings at rest."""
    targets = np.isin(rows.file, [i for i, k in enumerate(rows.kinds) if k == "targets"])
    t = np.unique(rows.state.time[targets])
    gaps = (t[1:] + t[:-1]) / 2
    if len(gaps) > MOST_STEPS:
        gaps = gaps[np.linspace(0, len(gaps) - 1, MOST_STEPS).astype(int)]
    return [float(g) for g in gaps]
