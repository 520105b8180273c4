"""The tables with which controls correct themselves: written from a machine's map, and read back.

A control is a module here, found by its name. It holds TITLE; VERIFIED, whether its format is known
from a manual or code (a source is named in its docstring) or only from general knowledge;
write(tables, options) -> Export; and read(source, options) -> list of ErrorTable. UNVERIFIED says
what of it no source gives, "" where all is known: then every file that is written comes with a
notice that says so too. Inside there is one sign: deviation = actual - commanded. Each module turns
it into its control's own, says so in its docstring, and in SIGN in a few words. A notice that
begins with "unverified: " is shown loudly. A module whose name begins with an underscore is no
control.
"""

from __future__ import annotations

import importlib
import pkgutil
from dataclasses import dataclass, field
from types import ModuleType

import numpy as np

from postproc.errors import GcompError, UsageError


class TableError(GcompError):
    """A control's table can not be written from this map, or can not be read."""


@dataclass(frozen=True)
class ErrorTable:
    """One deviation over the position of one axis, as the control would have to take it out.

    moving: the axis that moves (Z); along: the axis along which the tool is off (X for EXZ; Z for
    EZZ). nodes (K,) mm, ascending; forward, reverse (K,) mm: deviation for targets approached in +
    and in -; equal for one-way tables. Linear between nodes, held beyond.
    """

    moving: str
    along: str
    nodes: np.ndarray
    forward: np.ndarray
    reverse: np.ndarray

    @property
    def two_way(self) -> bool:
        return not np.array_equal(self.forward, self.reverse)

    @property
    def name(self) -> str:
        return f"E{self.along}{self.moving}"

    def at(self, position: np.ndarray, approach: np.ndarray | float = 0.0) -> np.ndarray:
        """(N,) mm at positions (N,) mm; approach -1 to +1, 0 is the mean."""
        # np.interp holds the first and the last value beyond the nodes
        up, down = (np.interp(position, self.nodes, v) for v in (self.forward, self.reverse))
        return (up + down) / 2 + approach * (up - down) / 2


@dataclass(frozen=True)
class ExportOptions:
    """What a control must be told. unit: "mm" or "inch", of the control's basic system; spacing: mm
    between points where they must be even, 0: as dense as the map's nodes ask for; reference: axis
    to mm, the reference (home) position; first: axis to the number of the first or the reference
    point; step: mm of one detection unit; two_way: whether the table of both directions is written
    where the control knows one; program: name for files and comments; rest: whether programs are
    corrected for what the control leaves; extra: what one control alone wants, by its name."""

    unit: str = "mm"
    spacing: float = 0.0
    reference: dict[str, float] = field(default_factory=dict)
    first: dict[str, int] = field(default_factory=dict)
    step: float = 0.001
    two_way: bool = True
    program: str = "gcomp"
    rest: bool = False
    extra: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Export:
    """files: name to bytes; notices: what the control can not hold, by how much it rounds, what to
    set beside it;
    remainder: name of component to mm, the largest deviation that the written table leaves between
    and beyond its points."""

    files: dict[str, bytes]
    notices: tuple[str, ...] = ()
    remainder: dict[str, float] = field(default_factory=dict)


def names() -> list[str]:
    """The controls that there are, as a user writes them."""
    return sorted(
        m.name.replace("_", "-")
        for m in pkgutil.iter_modules(__path__)
        if not m.name.startswith("_")
    )


def label(module: ModuleType) -> str:
    """What is known of a control's table, in the words of every list: verified, or what of it is
    not."""
    if not module.UNVERIFIED:
        return "verified"
    return f"{'format verified, ' if module.VERIFIED else ''}UNVERIFIED: {module.UNVERIFIED}"


def load(name: str) -> ModuleType:
    """The control's module. Raises UsageError with those that there are."""
    if name not in names():
        raise UsageError(
            f"there are no tables of a control {name!r}", f"controls: {', '.join(names())}"
        )
    return importlib.import_module(f"{__name__}.{name.replace('-', '_')}")
