"""One component: the means of its runs, without its set-up zero and its reference line, and the
uncertainty of each value.

Everything done to the means is linear (filling a gap, taking a line off, shifting to the datum), so
it is one matrix, and the uncertainty goes through the same matrix (JCGM 100, 5.1 and G.4).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from postproc.calibrate import CalibrationError, Options
from postproc.calibrate.assign import Series
from postproc.calibrate.statistics import Cells, cells_of, chi_squared, step_of, t_factor
from postproc.errors import Place
from postproc.units import UM

PLAIN = 3.0  # times the scatter of a reading: a deviation so large shows in every file of it
SAME_PLACE = 0.1  # mm: no angle that a slide has makes this visible


@dataclass(frozen=True)
class Component:
    """value, u (2, K): mm or rad at the nodes, approached in + and in -, and the standard
    uncertainty with the factor of the few runs in it, so that 2 u covers 95 % (NaN where nothing
    says it). slope: rad (rad/mm), of the reference line, and its u; lined: whether the line was
    taken off. datum: where the mean of both directions is zero, None for as recorded. filled: (way,
    node) of cells that no reading stands behind. noise: chi-squared of the means about their zero
    and line, and its 95 % limit."""

    name: str
    letter: str
    series: tuple[Series, ...]
    cells: Cells
    value: np.ndarray
    u: np.ndarray
    slope: float = 0.0
    u_slope: float = np.nan
    lined: bool = False
    datum: float | None = None
    filled: tuple[tuple[int, int], ...] = ()
    noise: tuple[float, float] | None = None
    dof: float = np.nan
    shifts: tuple[str, ...] = field(default=())

    @property
    def nodes(self) -> np.ndarray:
        return self.cells.nodes

    @property
    def two_way(self) -> bool:
        return self.cells.two_way

    @property
    def angle(self) -> bool:
        return self.series[0].angle

    @property
    def straight(self) -> bool:
        return self.series[0].straight

    @property
    def rest(self) -> dict[str, float]:
        """Axis to mm where the others stood, in the first file."""
        return self.series[0].rest

    @property
    def file(self) -> str:
        return self.series[0].file

    @property
    def mean(self) -> np.ndarray:
        """(K,) of both directions."""
        return self.value.mean(axis=0)

    @property
    def reversal(self) -> np.ndarray:
        """(K,) B: approached in + less approached in -; NaN where one direction was not read (ISO
        230-2)."""
        b = self.value[0] - self.value[1]
        for _, k in self.filled:
            b[k] = np.nan
        return b if self.two_way else np.full(len(b), np.nan)

    @property
    def span(self) -> float:
        """Range over both directions."""
        return float(np.ptp(self.value))

    @cached_property
    def largest_u(self) -> float:
        """mm or rad, NaN where none is known."""
        return float(np.nanmax(self.u)) if np.isfinite(self.u).any() else np.nan

    @property
    def small(self) -> str:
        """Why the component is not worth correcting; empty where it is."""
        if not np.isfinite(self.largest_u):
            return ""
        # U of a typical value: a range below it may be nothing but what the values are not known by
        typical = 2.0 * float(np.nanmedian(self.u))
        if self.span < typical:
            return "range"
        if self.noise is not None and self.noise[0] < self.noise[1]:
            return "noise"
        return ""

    def moved(self, extra: np.ndarray, u_extra: np.ndarray, remark: str) -> Component:
        """The same with (2, K) added, and its uncertainty."""
        return replace(
            self,
            value=self.value + extra,
            u=np.hypot(self.u, u_extra),
            shifts=(*self.shifts, remark),
        )


def elsewhere(first: Series, other: Series) -> CalibrationError | None:
    """Why a further file of a component is of another line of the axis; angles are the same on all
    of them."""
    moved = [x for x, at in other.rest.items() if abs(at - first.rest.get(x, at)) > SAME_PLACE]
    if not moved or first.angle:
        return None
    where, before = (", ".join(f"{x} = {s.rest[x]:g}" for x in moved) for s in (other, first))
    return CalibrationError(
        f"{first.component} is measured at {where} here, and at {before} in {first.file}, which was"
        " named first",
        "a table holds one line of the axis: name the other first, or leave one out",
        Place(other.file, 1),
    )


def join(series: list[Series], keep_lines: bool) -> Series:
    """Several files of one component to one: each has its own zero (a straightness its own line),
    taken from the targets that it shares with the first. Raises CalibrationError where it shares
    none."""
    first = series[0]
    if len(series) == 1:
        return first
    cells = cells_of(first.position, first.approach, first.reading)
    parts = [first]
    for other in series[1:]:
        place = Place(other.file, 1)
        shared, ours, difference = _shared(cells, other)
        if not len(shared):
            raise CalibrationError(
                f"{first.component} shares no target and direction with {first.file}: nothing"
                " connects their zeros",
                "measure both directions in one set-up",
                place,
            )
        _one_state(first, other, shared, ours, difference, cells)
        shift = np.full(len(other.reading), difference.mean())
        # Two set-ups of one straightness differ by a zero and by how the straightedge lay: a line
        # through three shared targets takes both off. Of two targets the line would also take what
        # the machine does.
        if first.straight and not keep_lines and len(np.unique(shared)) > 2:
            shift = np.polyval(np.polyfit(shared, difference, 1), other.position)
        parts.append(replace(other, reading=other.reading - shift))
    known = [s.u for s in parts if s.u is not None]

    def all_of(name: str) -> np.ndarray:
        return np.concatenate([getattr(s, name) for s in parts])

    return replace(
        first, u=max(known) if known else None, position=all_of("position"),
        approach=all_of("approach"), run=all_of("run"), reading=all_of("reading"),
        lines=all_of("lines"),
    )  # fmt: skip


def _one_state(
    first: Series,
    other: Series,
    shared: np.ndarray,
    ours: np.ndarray,
    difference: np.ndarray,
    cells: Cells,
) -> None:
    """Raises CalibrationError where the other file shows less than half of what the first shows, or
    over one and a half times that: 0 is after compensation, 2 with its sign turned (accept/signs.py
    has the same limits)."""
    terms = np.vander(shared, 2 if first.straight else 1)
    free = len(shared) - terms.shape[1]
    if free < 3 or first.angle:
        return
    shape, less = (y - terms @ np.linalg.lstsq(terms, y, rcond=None)[0] for y in (ours, difference))
    noise = float(np.sqrt(np.nanmean(cells.scatter.s**2))) if cells.scatter.known else 0.0
    if np.sqrt(shape @ shape / free) < max(PLAIN * noise, UM):
        return
    # less = theirs - ours, so theirs is ratio * ours along the shape of ours, in the least squares
    ratio = 1 + float(less @ shape / (shape @ shape))
    if not 0.5 < ratio < 1.5:
        raise CalibrationError(
            f"{first.component} is {ratio:.2f} times here what it is in {first.file}: the one was"
            " measured before compensation and the other after it, or read with the other sign",
            "a map is of one state: leave one out; gcomp accept compares them",
            Place(other.file, 1),
        )


def _shared(cells: Cells, other: Series) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Position of every cell that both have, the first's mean there, and the other's less it."""
    theirs = cells_of(other.position, other.approach, other.reading)
    # of a file in one direction both rows are alike: it is compared in its own direction
    single = cells.one_way if theirs.two_way else theirs.one_way
    ways = [0, 1] if cells.two_way and theirs.two_way else [int(single < 0)]
    if not cells.two_way and not theirs.two_way and cells.one_way != theirs.one_way:
        return np.zeros(0), np.zeros(0), np.zeros(0)
    position, ours, difference = [], [], []
    for way in ways:
        for k, q in enumerate(theirs.nodes):
            # 0.01 mm: as targets_of makes one target of places
            near = np.flatnonzero(np.abs(cells.nodes - q) < 0.01)
            if len(near) and np.isfinite(theirs.mean[way, k] - cells.mean[way, near[0]]):
                position.append(q)
                ours.append(cells.mean[way, near[0]])
                difference.append(theirs.mean[way, k] - cells.mean[way, near[0]])
    return np.array(position), np.array(ours), np.array(difference)


def build(series: list[Series], options: Options) -> Component:
    """Means, line, datum and uncertainty of one component. Raises CalibrationError."""
    one = join(series, options.keep_lines)
    cells = cells_of(one.position, one.approach, one.reading)
    if len(cells.nodes) < 2:
        raise CalibrationError(
            f"{one.component} has {len(cells.nodes)} target", "two at least", Place(one.file, 1)
        )
    # All that is done to the means is linear, so one matrix leads from the means as read to the
    # values as written, and their variances follow by it: a value that the datum fixes has none.
    k = len(cells.nodes)
    ways = 2 if cells.two_way else 1
    mean = cells.mean[:ways].ravel()
    fill, filled = _fill(cells)
    both = np.hstack([np.eye(k)] * 2) / 2 if ways == 2 else np.eye(k)  # (K, 2K): their mean
    zero, datum = _datum(cells.nodes, one.letter, options)
    line = _line(cells.nodes, options.line)
    lined = one.straight and not options.keep_lines
    #    means as read (K or 2K) --fill--> no gaps --line--> no slope --zero--> values as written
    #              matrix = (1 - 1 zero both) (1 - line both) fill,   u**2 = matrix**2 variance
    matrix = fill
    if lined:
        terms = np.vander(cells.nodes, 2)
        matrix = matrix - np.vstack([terms @ line] * ways) @ both @ fill
    if datum is not None:
        matrix = matrix - np.outer(np.ones(k * ways), zero @ both @ matrix)
    y = np.nan_to_num(mean)
    value = (matrix @ y).reshape(ways, k)
    u, dof = _uncertainty(matrix, one, cells, ways)
    u = np.hypot(u, _outside(one, cells, options, datum, ways))
    slope_row = line[0] @ both @ fill
    u_slope, _ = _uncertainty(slope_row[None], one, cells, ways)
    two = (lambda a: a) if ways == 2 else (lambda a: np.repeat(a, 2, axis=0))
    return Component(
        one.component, one.letter, tuple(series), cells, two(value), two(u.reshape(ways, k)),
        slope=float(slope_row @ y), u_slope=float(u_slope[0]), lined=lined, datum=datum,
        filled=tuple(filled), noise=_noise(one, cells, ways, lined), dof=float(np.median(dof)),
    )  # fmt: skip


def _fill(cells: Cells) -> tuple[np.ndarray, list[tuple[int, int]]]:
    """(2K, 2K) or (K, K): gaps between two targets of a direction by a straight line, at an end by
    the other direction with the reversal of the nearest target. Raises CalibrationError where a
    direction has fewer than two targets."""
    k = len(cells.nodes)
    ways = 2 if cells.two_way else 1
    matrix = np.eye(k * ways)
    filled = []
    for way in range(ways):
        there = np.flatnonzero(cells.n[way] > 0)
        for gap in np.flatnonzero(cells.n[way] == 0):
            row = np.zeros(k * ways)
            at = int(np.searchsorted(there, gap))
            #    + o----x----o     between two targets of its direction: on the line through them
            #    + o----o----x     at an end: what the other direction has there, and the reversal
            #    - o----o----o     of the nearest target that both have
            if 0 < at < len(there):
                a, b = there[at - 1], there[at]
                share = (cells.nodes[gap] - cells.nodes[a]) / (cells.nodes[b] - cells.nodes[a])
                row[way * k + a], row[way * k + b] = 1 - share, share
            else:
                near = [n for n in there if cells.n[1 - way, n] > 0]
                if not near or cells.n[1 - way, gap] == 0:
                    raise CalibrationError(
                        f"no reading approached in {'+-'[way]} stands near {cells.nodes[gap]:g}",
                        "two targets at least need both directions",
                    )
                nearest = min(near, key=lambda n: abs(cells.nodes[n] - cells.nodes[gap]))
                row[(1 - way) * k + gap] = 1.0
                row[way * k + nearest] += 1.0
                row[(1 - way) * k + nearest] -= 1.0
            matrix[way * k + gap] = row
            filled.append((way, int(gap)))
    return matrix, filled


def _line(nodes: np.ndarray, kind: str) -> np.ndarray:
    """(2, K): what gives slope and height at 0 of the reference line from K means."""
    if kind == "end-points":
        result = np.zeros((2, len(nodes)))
        length = nodes[-1] - nodes[0]
        # rows: slope, height at 0, as np.vander and polyfit order them
        result[0, 0], result[0, -1] = -1 / length, 1 / length
        result[1, 0], result[1, -1] = nodes[-1] / length, -nodes[0] / length
        return result
    return np.linalg.pinv(np.vander(nodes, 2))


def _datum(nodes: np.ndarray, letter: str, options: Options) -> tuple[np.ndarray, float | None]:
    """(K,) weights of the means that give the value at the datum, and the datum: position 0 where
    it was measured."""
    row = np.zeros(len(nodes))
    if options.keep_zero and letter not in options.datum:
        return row, None
    datum = options.datum.get(letter, 0.0 if nodes[0] <= 0.0 <= nodes[-1] else float(nodes[0]))
    if not nodes[0] <= datum <= nodes[-1]:
        raise CalibrationError(
            f"the datum {letter} = {datum:g} lies outside the targets {nodes[0]:g} to"
            f" {nodes[-1]:g}",
            "choose one within",
        )
    at = min(int(np.searchsorted(nodes, datum, side="right")) - 1, len(nodes) - 2)
    share = (datum - nodes[at]) / (nodes[at + 1] - nodes[at])
    row[at], row[at + 1] = 1 - share, share
    return row, float(datum)


def _variance(one: Series, cells: Cells, ways: int) -> tuple[np.ndarray, np.ndarray]:
    """Variance of the mean of each cell by the scatter of its runs, not below that of the reading's
    step; degrees of freedom. One run alone has no scatter: then the instrument's, and NaN where
    that is not stated either."""
    scatter = cells.scatter
    n = np.maximum(cells.n[:ways], 1).ravel()
    if not scatter.known:
        return np.full(n.shape, np.nan if one.u is None else one.u**2) / n, np.full(n.shape, np.inf)
    least = step_of(one.reading) ** 2 / 12.0  # of a value that was rounded to the step
    return np.maximum(scatter.s[:ways].ravel() ** 2, least) / n, scatter.dof[:ways].ravel()


def _uncertainty(
    matrix: np.ndarray, one: Series, cells: Cells, ways: int
) -> tuple[np.ndarray, np.ndarray]:
    """(R,) u of rows of a matrix times the means by scatter alone, with the factor t / 2 of the
    effective degrees of freedom (Welch and Satterthwaite, JCGM 100 G.4), and those degrees; NaN
    where the scatter is not known."""
    variance, dof = _variance(one, cells, ways)
    if not np.isfinite(variance).any():
        return np.full(len(matrix), np.nan), np.full(len(matrix), np.nan)
    # a mean that was filled in has no variance of its own: those that it was filled from are in its
    # row
    parts = matrix**2 * np.where(cells.n[:ways].ravel() > 0, variance, 0.0)
    total = parts.sum(axis=1)
    if cells.scatter.pooled:
        free = np.full(len(matrix), float(dof.max()))
    else:
        with np.errstate(invalid="ignore", divide="ignore"):
            free = np.where(total > 0, total**2 / (parts**2 / dof).sum(axis=1), np.inf)
    return np.sqrt(total) * t_factor(free) / 2.0, free


def _outside(
    one: Series, cells: Cells, options: Options, datum: float | None, ways: int
) -> np.ndarray:
    """(2K,) u that more runs do not lessen: the instrument's, and of a length the temperature's
    (ISO/TR 230-9).

    An instrument's u that is noise shows in the scatter already; of one run alone it is counted
    there.
    """
    k = len(cells.nodes)
    u = np.zeros(k * ways)
    if one.u is not None and not options.u_random and cells.scatter.known:
        # not through the matrix: what the instrument does wrong everywhere alike does not lessen by
        # a difference
        u = np.full(k * ways, one.u)
    if options.u_temperature and one.component == f"E{one.letter}{one.letter}" and not one.angle:
        length = np.abs(cells.nodes - (cells.nodes[0] if datum is None else datum))
        u = np.hypot(u, np.tile(options.expansion * options.u_temperature * length, ways))
    return u


def _noise(one: Series, cells: Cells, ways: int, lined: bool) -> tuple[float, float] | None:
    """Chi-squared of the means about one constant (and line), and what pure scatter stays below 19
    times of 20."""
    variance, dof = _variance(one, cells, ways)
    used = cells.n[:ways].ravel() > 0
    if not np.isfinite(variance).any() or not (variance[used] > 0).all():
        return None
    nodes = np.tile(cells.nodes, ways)[used]
    # few runs: scatter as it would be of many, so that chi-squared asks the same at every n
    sigma = np.sqrt(variance[used]) * t_factor(dof[used]) / 2.0
    terms = np.vander(nodes, 2 if lined else 1) / sigma[:, None]
    y = cells.mean[:ways].ravel()[used] / sigma
    left = y - terms @ (np.linalg.pinv(terms) @ y)
    free = len(y) - terms.shape[1]
    return (float(left @ left), float(chi_squared(free))) if free >= 1 else None
