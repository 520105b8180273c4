"""Every effect of the library, on every axis that can show it, at every value of what does not
enter linearly: blocks of columns as the readings would show them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields
from functools import partial
from itertools import combinations
from types import ModuleType

import numpy as np

from postproc import effects
from postproc.diagnose import jumps, spectra
from postproc.diagnose.block import NOTHING, Block
from postproc.diagnose.rows import Rows, second_place
from postproc.machine.chain import XYZ

SIGNALS = {  # what an effect must be able to show in -> kinds of signals
    "tool": ("laser", "tool"),
    "scale": ("scale",),
    "part": ("part",),
    "laser": ("laser",),
    "trace": ("tool",),
    "gauge": (),
    "angle": ("angle",),
}
MOST_STEPS, MOST_JUMPS, MOST_ABRUPT = 200, 60, 24
PAUSE = 4.0  # times the usual wait between two readings: between two runs or recordings
NEVER = 1e5  # s: an axis that has not turned back
FEWEST_BETWEEN = 6  # readings before, between and behind jumps: fewer are readings that are off
SMOOTH, WAVE = 4, 0.2  # degree of a curve; share of a wave's squares that it must leave
# (also) from the spectrum of what is left
FOUND = ("cyclic", "encoder_cyclic", "stick_slip", "vibration")
# what an effect may need beside channels that were recorded and changed
OWN = {field.name for field in fields(effects.State)} | {"force", "material"}


def visible(rows: Rows, module: ModuleType) -> np.ndarray:
    """(N,) bool: rows in which the effect can show."""
    kinds = [kind for sees in module.SEES for kind in SIGNALS[sees]]
    seen = rows.seen(kinds)
    if getattr(module, "LIGHT", False):
        seen = seen & (rows.state.channels["lit"] > 0)
    # the edge's own wear is on the workpiece, not on what a mandrel or a mirror shows
    if "gauge" in module.SEES:
        seen = seen | (rows.seen(SIGNALS["tool"]) & (rows.state.channels["gauged"] > 0))
    if "trace" in module.SEES or ("laser" in module.SEES and module.USE == "recording"):
        files = np.array(
            [k in (("trace",) if "trace" in module.SEES else ("targets",)) for k in rows.kinds]
        )
        seen &= files[rows.file]
    return seen


# Whole: a list of drivers, a condition to each.
def needed(rows: Rows, module: ModuleType, axis: str) -> bool:
    """Whether the rows tell what the effect depends on."""
    state = rows.state
    for need in module.NEEDS:
        letters = axis or "".join(state.position)
        if need == "time" and np.ptp(state.time) == 0:
            return False
        if need == "velocity" and not any(np.any(state.velocity[x]) for x in letters):
            return False
        # Two axes are compared where both move at once: a circle in another plane says nothing of
        # the pair.
        if (
            need == "velocity"
            and module.PER == "pair"
            and not np.any(state.velocity[axis[0]] * state.velocity[axis[1]])
            and not apart(rows, axis)
        ):
            return False
        if need == "acceleration" and not any(np.any(state.acceleration[x]) for x in letters):
            return False
        if need == "since" and not any(np.any(state.since[x] < NEVER) for x in letters):
            return False
        if need == "approach" and not any(np.ptp(state.approach[x]) > 0 for x in letters):
            return False
        if need == "force" and not effects.loads(state, axis):
            return False
        if need == "part" and "gauge" in module.SEES and np.any(state.channels.get("gauged", 0.0)):
            continue
        if need not in OWN and np.ptp(state.channels.get(need, np.zeros(1))) == 0:
            return False
        if need == "angles" and axis not in state.angles:
            return False
    return True


def apart(rows: Rows, pair: str) -> bool:
    """Whether the lag of each of two axes shows by itself, in signals along that axis alone."""
    size = np.abs(rows.direction)
    along = [size[:, XYZ.index(x)] == size.sum(axis=1) for x in pair]
    return all(
        bool(np.any(rows.state.velocity[x][own])) for x, own in zip(pair, along, strict=True)
    )


def read(rows: Rows, module: ModuleType, axis: str, shape: dict[str, float]) -> np.ndarray:
    """(N, K) mm: the columns of an effect as the readings show them."""
    if getattr(module, "ALONG", False) and not rows.other:
        return _read_along(rows, module, axis, shape)
    # (K, 3, N) mm, the tool's deviation along X, Y, Z, of which a reading takes what lies along its
    # direction; of an instrument's own effects (K, N), the reading itself.
    value = module.columns(rows.state, axis, **shape)
    seen = visible(rows, module)
    if value.ndim == 2:
        return np.where(seen, value, 0.0).T
    # The difference of two places; what comes with time or with the tool is in one of its walls.
    both = not {"part", "material", "time"} & set(module.NEEDS) or getattr(module, "WALLS", False)
    if rows.other and "part" in module.SEES and module.PER != "all" and both:
        part = (rows.sees == "part") & np.all([np.isfinite(v) for v in rows.other.values()], axis=0)
        if part.any():
            value = value.copy()
            #     size = (wall + its deviation) - (other + its deviation)
            value[:, :, part] -= module.columns(second_place(rows, part), axis, **shape)
    result = np.zeros((len(value), len(rows)))  # a column in one piece of the memory
    for along, own in enumerate(rows.direction.T):
        if own.any() and value[:, along].any():
            result += value[:, along] * own
    if not seen.all():
        result[:, ~seen] = 0.0
    return result.T


def _read_along(rows: Rows, module: ModuleType, axis: str, shape: dict[str, float]) -> np.ndarray:
    """(N, K) mm: of an effect that is along its axis and of each signal by itself, from the rows
    that see that axis."""
    own, state = rows.along(axis)
    number = XYZ.index(axis)
    value = module.columns(state, axis, **shape)[:, number] * rows.direction[own, number]
    result = np.zeros((len(value), len(rows)))
    result[:, own] = np.where(visible(rows, module)[own], value, 0.0)
    return result.T


def axes_of(rows: Rows, module: ModuleType) -> list[str]:
    group = np.where(
        rows.sees == "part", -1 - rows.file, rows.signal
    )  # features of a part stand at several places together
    # what goes with the side alone shows at one place that is reached from both
    sided = rows.state.approach if tuple(module.NEEDS) == ("approach",) else {}
    moving = [
        x
        for x, p in rows.state.position.items()
        if any(
            np.ptp(v[group == g]) > 1e-3
            for g in np.unique(group)
            for v in (p, sided.get(x, np.zeros(len(p))))
        )
    ]
    if module.PER == "all":
        return [""]
    resting = getattr(module, "RESTING", False)
    if module.PER == "pair":
        pairs = combinations(sorted(rows.state.position if resting else moving), 2)
        return ["".join(pair) for pair in pairs if set(pair) & set(moving)]
    if resting:
        seen = visible(rows, module)
        return [x for x in rows.state.position if np.any(rows.direction[seen, XYZ.index(x)])]
    if getattr(module, "LINE", False):
        # "" beside the axes: of none alone, as a line along which several move
        return [*moving, ""]
    return moving


# Whole: the filters that every block of the dictionary passes, in order.
def blocks(rows: Rows) -> Iterator[Block]:
    """The dictionary, effect by effect. Blocks that show nothing in these readings are left out."""
    for name in effects.names():
        module, result = effects.load(name), list[Block]()
        if not visible(rows, module).any():
            continue
        for axis in axes_of(rows, module):
            if not needed(rows, module, axis):
                continue
            shapes = list(_shapes(rows, name, module, axis))
            found = []
            for shape in shapes:
                columns = read(rows, module, axis, shape)
                # mm, for a coefficient of one: what no reading shows has no usual size (SLAB over
                # its largest reading, evidence.py)
                keep = np.abs(columns).max(axis=0) > 1e-9
                if not keep.all() or not np.isfinite(columns).all():
                    continue
                if "period_mm" not in shape or not looks_smooth(rows, axis, columns):
                    found.append((shape, columns))
            # Of a jump all moments count as tried, not only those of the grid: shapes.py looks at
            # the others.
            number = max(len(found), len(np.unique(rows.state.time)) if name == "step_loss" else 0)
            alone = module.PER == "pair" and "velocity" in module.NEEDS and apart(rows, axis)
            made = [
                Block(module, axis, named(s), partial(read, rows, module, axis, s), number, alone)
                for s, _ in found
            ]
            for block, (_, columns) in zip(made, found, strict=True):
                block.having(columns)
            result += made if axis else [b for b in made if not _of_one_axis(b, result)]
        yield from result


def named(shape: dict[str, float]) -> tuple[tuple[str, float], ...]:
    """A shape as a block has it."""
    return tuple(sorted(shape.items()))


def looks_smooth(rows: Rows, axis: str, columns: np.ndarray) -> bool:
    """Whether a wave in place is, at the targets of every signal, nearly a polynomial: the targets
    stand farther apart than half its period, in step with it (aliasing; ISO 230-2 asks for targets
    at uneven distances for that reason)."""
    share = rows.state.share(axis)
    seen = np.abs(columns).max(axis=1) > NOTHING
    for signal in np.unique(rows.signal[seen]):
        own = seen & (rows.signal == signal)
        curve = np.polynomial.legendre.legvander(share[own], SMOOTH)
        left = columns[own] - curve @ np.linalg.lstsq(curve, columns[own], rcond=None)[0]
        whole = columns[own] - columns[own].mean(axis=0)
        if np.sum(left**2) > WAVE * np.sum(whole**2):
            return False
    return True


def _of_one_axis(block: Block, others: list[Block]) -> bool:
    """Whether what is of no axis shows no more than the same of one axis."""
    return any(
        b.module is block.module
        and b.shape == block.shape
        and np.array_equal(b.columns, block.columns)
        for b in others
    )


def _shapes(rows: Rows, name: str, module: ModuleType, axis: str) -> Iterator[dict[str, float]]:
    if name == "step_loss":
        yield from ({"t_s": t} for t in _steps(rows))
    else:
        yield from module.shapes(rows.state, axis)


def _steps(rows: Rows) -> list[float]:
    """s: between two readings at rest, and at some moments of motions that were sampled. Of many
    the pauses, where most of the time is, those over which readings differ most, and some of the
    others."""
    rest = (rows.state.passage < 0) & (rows.sees != "part")
    t = np.unique(rows.state.time[rest])
    middle, wait = (t[1:] + t[:-1]) / 2, np.diff(t)
    gaps = list(middle)
    # A block to each moment: a day of readings would have thousands.
    if len(gaps) > MOST_STEPS:
        largest = np.zeros(len(middle))
        for signal in np.unique(rows.signal[rest]):
            own = np.flatnonzero(rest & (rows.signal == signal))
            own = own[np.argsort(rows.state.time[own], kind="stable")]
            y = np.abs(np.diff(rows.residual[own]))
            at = np.clip(np.searchsorted(t, rows.state.time[own][1:]) - 1, 0, len(middle) - 1)
            np.maximum.at(largest, at, y / max(float(np.median(y)), 1e-9))
        pause = wait > PAUSE * np.median(wait)
        jumps = np.argsort(-np.where(pause, 0.0, largest))[:MOST_JUMPS]
        some = np.linspace(0, len(middle) - 1, MOST_STEPS // 4).astype(int)
        gaps = list(
            middle[np.unique(np.concatenate([np.flatnonzero(pause)[:MOST_STEPS], jumps, some]))]
        )
    return [float(g) for g in [*gaps, *_steps_moving(rows)] if between_readings(rows, g)]


def between_readings(rows: Rows, t: float) -> bool:
    """Whether some signal has readings enough before and behind a moment t (s) to show a jump: at
    its ends, and between two recordings, a jump is no more than another zero."""
    seen = rows.sees != "part"
    number, later = rows.signal[seen], rows.state.time[seen] > t
    most = int(number.max(initial=0)) + 1
    # enough on both sides in one signal: eight before in one and eight behind in another show two
    # zeros
    behind = np.bincount(number[later], minlength=most)
    before = np.bincount(number[~later], minlength=most)
    return bool(np.any(np.minimum(behind, before) >= FEWEST_BETWEEN))


def _steps_moving(rows: Rows) -> list[float]:
    """s: moments of motions that were sampled: where a signal changes most abruptly, and some of
    the others."""
    moments, abrupt = [], []
    for passage in np.unique(rows.state.passage[rows.state.passage >= 0]):
        here = np.flatnonzero(rows.state.passage == passage)
        time = rows.state.time[here]
        moments += list(np.linspace(time.min(), time.max(), 12)[1:-1])
        for signal in np.unique(rows.signal[here]):
            own = here[rows.signal[here] == signal]
            own = own[np.argsort(rows.state.time[own], kind="stable")]
            at, size = jumps.changes(rows.residual[own])
            scale = max(float(np.median(size)), 1e-9) if len(size) else 1.0
            t = rows.state.time[own]
            abrupt += [(-s / scale, (t[k - 1] + t[k]) / 2) for k, s in zip(at, size, strict=True)]
    return moments + [t for _, t in sorted(abrupt)[:MOST_ABRUPT]]


def harmonic_pairs(columns: np.ndarray) -> np.ndarray:
    """(K,) bool: columns (N, K) of the waves that show, a cosine and its sine together: one of them
    alone has no phase."""
    shows = (np.abs(columns).max(axis=0, initial=0.0) > 1e-9).reshape(-1, 2).all(axis=1)
    return np.repeat(shows, 2)


def _harmonics(rows: Rows, module: ModuleType, axis: str, shape: dict[str, float]) -> np.ndarray:
    """(N, K) mm: the columns of waves, as far as they show."""
    columns = read(rows, module, axis, shape)
    return columns.T[harmonic_pairs(columns)].T if columns.shape[1] > 1 else columns


def found(rows: Rows, weighted: np.ndarray, sigma: np.ndarray) -> list[Block]:
    """Blocks of what is periodic in what is left. weighted (N,): P y, what is left over the square
    of the noise."""
    result = []
    for name in FOUND:
        module = effects.load(name)
        seen = visible(rows, module)
        if not seen.any():
            continue
        for axis in axes_of(rows, module):
            seen_to_slip = name == "stick_slip" and axis in rows.slips
            if not seen_to_slip and not needed(rows, module, axis):
                continue
            along = rows.direction[:, XYZ.index(axis)] * seen
            for shape in _periodic(rows, module, axis, weighted * along, along**2 / sigma**2):
                make = partial(_harmonics, rows, module, axis, shape)
                tried = rows.slips[axis].chosen_from if shape.get("scatter") else spectra.TRIED
                block = Block(module, axis, named(shape), make, tried)
                if block.width:
                    result.append(block)
    return result


def sawtooth_shape(rows: Rows, axis: str) -> dict[str, float]:
    """The shape of stick-slip whose slips were seen."""
    slips, limits = rows.slips[axis], effects.load("stick_slip").limits(rows.state, axis)
    return {
        "period_mm": float(np.mean(slips.ways)),
        "fastest_mm_s": min((v for v in limits if v > slips.fastest), default=0.0),
        "slip_ms": 0.0,
        "scatter": slips.scatter,
    }


def sawtooths(rows: Rows) -> Iterator[np.ndarray]:
    """(N,) of each axis whose slips were seen: the sawtooth of a lag, as readings show it."""
    module = effects.load("stick_slip")
    for axis in rows.slips:
        yield read(rows, module, axis, sawtooth_shape(rows, axis))[:, 0]


def _periodic(
    rows: Rows, module: ModuleType, axis: str, weighted: np.ndarray, power: np.ndarray
) -> list[dict[str, float]]:
    """The likeliest shapes of an effect that is periodic. weighted, power (N,): what is left along
    the axis, and the power of a wave, over the square of the noise."""
    name = module.__name__.rsplit(".", 1)[1]
    if name == "vibration":
        peaks = [*spectra.in_time(rows, weighted, power), *rows.fast_hz]
        return [{"frequency_hz": f, "passages": 1.0} for f in peaks]
    if name != "stick_slip":
        return [
            {"period_mm": p} | module.PLAIN for p in spectra.in_place(rows, axis, weighted, power)
        ]
    state, result = rows.state, list[dict[str, float]]()
    if axis in rows.slips:
        result.append(sawtooth_shape(rows, axis))
    ways = module.ways(state, axis)
    for limit in module.limits(state, axis):
        use = (power > 0) & (state.passage >= 0) & module.creeps(state, axis, limit)
        use &= ways[0] < NEVER
        lag = -weighted[use] * state.approach[axis][use]
        peaks = spectra.since_turn(ways[:, use], lag, power[use])
        shape = {"fastest_mm_s": limit} | module.PLAIN
        result += [{"period_mm": p} | shape for p in peaks]
    return result
