"""How LinuxCNC's G71 and G72 rough a shape that may have pockets: the way of the tool, cut by cut.

As its interpreter does it (src/emc/rs274ngc/interp_g7x.cc, 2.9), measured on the same programs. The
shape is turned about so that it goes towards -z and dives towards -x first. On each level the tool
dives along the shape, cuts to where the shape is next, escapes, comes back and goes deeper; where
the shape climbs, it follows it, until it dives again: there the next pocket begins, roughed in the
same way. G71.1 leaves the pockets out; G71.2 begins at the first one, along the shape.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from postproc.nc.cycles.profile import Element, Step, TooMany
from postproc.nc.cycles.scene import CLOCKWISE, COUNTER

WHOLE, NO_POCKETS, POCKETS_ONLY = 0, 1, 2
LEVEL, SHORT = 1e-6, 1e-3  # mm or inches: the control's own
TOUCHES = 1e-12  # square of a half chord: a level that touches an arc, but for a rounding
BOTTOM = -1e9
MOST_CUTS = 100_000


@dataclass
class Piece:
    """A line or an arc, z + i x, in the coordinates in which the shape dives towards -x and goes
    towards -z."""

    start: complex
    end: complex
    centre: complex | None = None
    counter: bool = False

    @property
    def goes_on(self) -> bool:
        """Whether it never turns back towards +z."""
        along = (self.end - self.start).real
        if self.centre is None:
            return along <= SHORT
        sign = 1 if self.counter else -1
        sides = ((self.start - self.centre).imag * sign, (self.end - self.centre).imag * sign)
        return min(sides) >= -SHORT and along <= -SHORT

    def at_level(self, x: float) -> list[float]:
        """z where it has this x; of an arc the larger one first."""
        if self.centre is None:
            low, high = sorted((self.start.imag, self.end.imag))
            if low > x + LEVEL or high < x - LEVEL:
                return []
            rise = self.end.imag - self.start.imag
            if abs(rise) < LEVEL:
                return [self.start.real, self.end.real]
            return [
                self.start.real + (x - self.start.imag) / rise * (self.end.real - self.start.real)
            ]
        radius, up = abs(self.start - self.centre), x - self.centre.imag
        square = (radius - up) * (radius + up)
        if square < -LEVEL:
            return []
        half = math.sqrt(square) if square > TOUCHES else 0.0
        found = [self.centre.real + half, self.centre.real - half]
        return [z for z in found if self._within(complex(z, x))]

    def _within(self, p: complex) -> bool:
        assert self.centre is not None
        sign = 1 if self.counter else -1
        first = ((self.start - self.centre).conjugate() * (p - self.centre)).imag * sign
        last = ((self.end - self.centre).conjugate() * (p - self.centre)).imag * sign
        return first >= -LEVEL and last <= LEVEL

    @property
    def top(self) -> complex:
        """Where an arc against the clock stops climbing: its end, or its highest place."""
        assert self.centre is not None
        if self.end.real < self.centre.real:
            return complex(self.centre.real, self.centre.imag + abs(self.start - self.centre))
        return self.end


@dataclass
class Roughing:
    """The way over `pieces` in steps of `depth`, with escapes of `escape`; `out` maps places
    back."""

    pieces: list[Piece]
    depth: float
    escape: float
    out: Callable[[complex], tuple[float, float]]
    mirrored: bool
    at: complex = 0j
    top: float = (
        # from where levels count: the start point; of G71.2 where it begins, and higher pockets at
        # their own
        0.0
    )
    alone: bool = False
    steps: list[Step] = field(default_factory=list)

    def way(self, how: int) -> list[Step]:
        """The motions. Raises TooMany."""
        self.at = self.pieces[0].start
        self._go("G0", self.at)
        self.top = self.at.imag
        self._pocket(how, 0)
        return self.steps

    def _go(self, code: str, to: complex, moves: bool = True) -> None:
        self.steps.append(Step(code, self.out(to)))
        if len(self.steps) > MOST_CUTS:
            raise TooMany
        if moves:
            self.at = to

    def _along(self, p: Piece, to: complex) -> None:
        """Along an arc as far as `to`."""
        assert p.centre is not None
        if abs(self.at - to) > SHORT:
            code = "G3" if p.counter != self.mirrored else "G2"
            self.steps.append(Step(code, self.out(to), self.out(p.centre)))
        self.at = to

    # -- one piece ---------------------------------------------------------------------------------

    def _dives(self, k: int, x: float) -> bool:
        """Down along a piece, to a level at most; False: it climbs here."""
        p = self.pieces[k]
        if p.centre is None:
            if p.start.imag <= p.end.imag:
                return False
            found = p.at_level(x)
            if x >= p.end.imag and not found:
                raise TooMany
            to = p.end if x < p.end.imag else complex(found[0], x)
            self._go("G0" if k == 0 else "G1", to)
            return True
        if abs(self.at - p.end) < SHORT:
            return True
        middle = p.centre.real
        #  ccw  .-o-.    cw  \     /    Going to -z, from right to left: against the clock an arc
        #      /     \        '-o-'     climbs to its middle o and dives behind it, with the clock
        #                               it dives first.
        if (self.at.real > middle) if p.counter else (self.at.real <= middle):
            return False
        found = p.at_level(x)
        reached = found and (found[-1] <= middle if p.counter else found[0] >= middle)
        self._along(p, complex(found[-1 if p.counter else 0], x) if reached else p.end)
        return True

    def _climbs(self, k: int) -> bool:
        """Up along a piece as far as it climbs; False: it dives from here."""
        p = self.pieces[k]
        if p.centre is None:
            if p.end.imag < p.start.imag:
                return False
            self._go("G1", p.end)
            return True
        middle = p.centre.real
        if not p.counter:
            if self.at.real > middle:
                return False
            self._along(p, p.end)
            return True
        if self.at.real >= middle:
            self._along(p, p.top)
        return False

    def _climbs_only(self, k: int) -> None:
        """Over a pocket straight to where the shape climbs beyond this level, and up along it."""
        p = self.pieces[k]
        found = p.at_level(self.at.imag)
        if p.centre is None:
            if p.end.imag >= p.start.imag and found:
                self._go("G1", complex(found[0], self.at.imag))
                self._go("G1", p.end)
            return
        middle = p.centre.real
        if not found or (found[0] < middle if p.counter else found[-1] > middle):
            return
        self._go("G1", complex(found[0 if p.counter else -1], self.at.imag))
        self._along(p, p.top if p.counter else p.end)

    # -- a pocket ----------------------------------------------------------------------------------

    def _pocket(self, how: int, k: int) -> None:
        """Rough from piece k on."""
        # BOTTOM lies below every shape: along the shape as long as it dives.
        if how == POCKETS_ONLY:
            while k < len(self.pieces) and self._dives(k, BOTTOM):
                k += 1
            how, self.alone, self.top = WHOLE, True, self.at.imag
        if self.alone:
            self.top = max(self.top, self.at.imag)
        x = self.top
        for _ in range(MOST_CUTS):
            if k >= len(self.pieces):
                return
            # The next level below the tool: on the way along the shape some may have been passed.
            while x > self.at.imag:
                x -= self.depth
            if not self._dives(k, x):
                self._behind(how, k)
                return
            if self.at.imag > x or abs(self.at.imag - x) > LEVEL:
                k += 1
                continue
            cut, on = self._cut(k)
            x -= self.depth if cut else 0.0
            k += on
        raise TooMany

    def _behind(self, how: int, k: int) -> None:
        """The shape climbs: follow it, up to the next pocket."""
        for n in range(k, len(self.pieces)):
            if how == NO_POCKETS:
                self._climbs_only(n)
            elif not self._climbs(n):
                self._pocket(WHOLE, n)
                return

    def _cut(self, k: int) -> tuple[bool, int]:
        """One cut at this level: whether there was one, and how many pieces to go on. Raises
        TooMany."""
        here = self.at
        for n in range(k, len(self.pieces)):
            found = self.pieces[n].at_level(here.imag)
            if not found:
                continue
            to = found[0] if n != k else found[-1]
            if to - LEVEL > here.real:
                continue
            length = abs(to - here.real)
            if length < LEVEL:
                if n == k:
                    continue
                if abs(here - self.pieces[n].start) < LEVEL:
                    return False, n - k
                return True, 0  # nothing is left to cut on this level
            #    .  .  .  .  .       Cut towards -z, out at 45 degrees by the escape (by half the
            #   /             \      cut where that is shorter), back over the cut, and down again
            #  to <---cut--- here    to where it began.
            share = min(1.0, length / 2 / self.escape) * self.escape
            self._go("G1", complex(to, here.imag))
            self._go("G0", complex(to + share, here.imag + share))
            self._go("G0", complex(here.real - share, here.imag + share))
            self._go("G0" if k == 0 else "G1", here)
            return True, 0
        raise TooMany


def roughing(elements: list[Element], deep: int, depth: float, escape: float) -> Roughing:
    """The shape turned about; elements[0] is the way in. deep: 1 for cuts along z (G71), 0 for cuts
    along x."""
    turned = [_piece(e, deep) for e in elements]
    first, last = turned[0].end, turned[-1].end
    # The picture is an outer shape towards -z; one that goes towards +z, or an inner one, is
    # flipped, and `out` flips the way back. One flip alone turns the sense of arcs round.
    up, back = first.imag > last.imag, first.real < last.real
    pieces = [_flipped(p, up, back) for p in turned]

    def out(p: complex) -> tuple[float, float]:
        z, x = (-p.real if back else p.real), (-p.imag if up else p.imag)
        return (z, x) if deep == 1 else (-x, z)

    # A wall up to the start point's level, or the cuts above the shape's end would find no end.
    if pieces[-1].end.imag < pieces[0].start.imag:
        pieces.append(Piece(pieces[-1].end, complex(pieces[-1].end.real, pieces[0].start.imag)))
    return Roughing(pieces, depth, escape, out, up != back)


def _piece(e: Element, deep: int) -> Piece:
    def place(p: tuple[float, float]) -> complex:
        return complex(*p) if deep == 1 else complex(p[1], -p[0])

    centre = place(e.centre) if e.code in (CLOCKWISE, COUNTER) else None
    return Piece(place(e.start), place(e.end), centre, e.code == COUNTER)


def _flipped(p: Piece, up: bool, back: bool) -> Piece:
    def flip(q: complex) -> complex:
        return complex(-q.real if back else q.real, -q.imag if up else q.imag)

    return Piece(
        flip(p.start),
        flip(p.end),
        None if p.centre is None else flip(p.centre),
        p.counter != (up != back),
    )


def turning_back(pieces: list[Piece]) -> Iterator[int]:
    """Numbers of the pieces, behind the way in, that go back along the cuts: LinuxCNC calls them
    not monotonic, and refuses."""
    return (k for k, p in enumerate(pieces) if k and not p.goes_on)
