"""One axis as the folder states it: travel, tables, where it was measured, growth with
temperature."""

from __future__ import annotations

from dataclasses import field, replace

import numpy as np

from postproc.machine.tables import AxisTable, AxisUncertainty, GridTable
from postproc.records import columns, record


@record
class Expansion:
    """Growth with temperature, linear from the point that does not move. scale, work: 1/K,
    expansion of the axis' scale (or screw) and of the workpiece; their temperatures, degrees
    Celsius; fixed: mm, slide position that stays. sensors: columns of a log for the scale, with mm,
    the slide position at which each thermometer sits, None: they are averaged; work_sensors: for
    the work."""

    scale: float = 0.0
    scale_at: float = 20.0
    work: float = 0.0
    work_at: float = 20.0
    fixed: float = 0.0
    sensors: tuple[tuple[str, float | None], ...] = ()
    work_sensors: tuple[str, ...] = ()

    @property
    def rate(self) -> float:
        """mm/mm that the axis goes too far, seen by a part that is measured at 20 degrees
        Celsius."""
        # The marks of a warm scale lie too far apart: the slide goes too far, +. Warm work is cut
        # to size and shrinks when it cools to 20 degrees (ISO 1): seen by the cold part the slide
        # had not gone far enough, -. Where scale and work grow alike nothing is left.
        return self.scale * (self.scale_at - 20.0) - self.work * (self.work_at - 20.0)


@record
class Axis:
    """travel: mm that the slide can reach, degrees of a rotary axis; least_increment: mm or degrees
    of the programmed word; measured_at (3,): mm, where the other axes stood, as stated
    (`Machine.measured`: what counts); optic: what the measured point was fixed to, "" for the side
    that the axis carries; centre (3,): mm, a point on a rotary axis' line while all slides stand at
    zero; location (6,): mm and rad, how that line lies beside the nominal one; grids: what depends
    on a second axis too; uncertainty: of the table, None where the folder states none; left_out:
    components that were measured and are within their uncertainty, so that no table holds them;
    centre_stated: the directions in which the folder states the centre; velocity: mm/s, its
    fastest, 0: not stated."""

    letter: str
    travel: tuple[float, float]
    least_increment: float
    measured_at: np.ndarray
    table: AxisTable | None = None
    optic: str = ""
    centre: np.ndarray = field(default_factory=lambda: np.zeros(3))
    location: np.ndarray = field(default_factory=lambda: np.zeros(6))
    grids: tuple[GridTable, ...] = ()
    expansion: Expansion | None = None
    uncertainty: AxisUncertainty | None = None
    left_out: tuple[str, ...] = ()
    centre_stated: tuple[str, ...] = ()
    velocity: float = 0.0

    @property
    def bare(self) -> Axis:
        """The same axis without errors."""
        # optic, centre and measured_at stay: they are geometry, by which errors of other axes reach
        # the tip.
        return replace(self, table=None, grids=(), expansion=None, location=np.zeros(6))

    @property
    def tables(self) -> list[AxisTable | GridTable]:
        """Its measured errors: over its own position, and over a second axis' too."""
        own: list[AxisTable | GridTable] = [self.table] if self.table is not None else []
        return own + list(self.grids)


@columns
class Driver:
    """name: for a person; letter: the axis that it moves along itself; column: of the log, "" for a
    spindle's own turns; zero: degrees Celsius at which it does nothing, nan: what it was when the
    program began; nodes (K,) mm and unit (K,) mm per K, or mm per um of a spindle's growth;
    spindle: parameters of spindle_growth."""

    name: str
    letter: str
    column: str
    zero: float
    nodes: np.ndarray
    unit: np.ndarray
    spindle: tuple[tuple[str, float], ...] = ()

    @property
    def most(self) -> float:
        """mm per unit, where it moves the axis most."""
        return float(np.abs(self.unit).max())
