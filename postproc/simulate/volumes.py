"""Programs of tests in which several axes move: diagonals, stairs beside them, and places all over
a volume (ISO 230-6)."""

from __future__ import annotations

import math

import numpy as np

from postproc.simulate.asked import GOLDEN, Ask, Test
from postproc.simulate.writer import OUTRUN, Writer, middle, ranges


def diagonal(write: Writer, ask: Ask) -> Test:
    """Targets along a diagonal of two or three axes, there and back (ISO 230-6). number, runs,
    dwell, feed, overrun."""
    overrun = ask.of("overrun", OUTRUN)
    ends, size, along = _ends(write, ask, overrun)
    number, feed, dwell = ask.count("number", 17), ask.of("feed", 2000.0), ask.of("dwell", 3.0)
    share = np.linspace(0.0, 1.0, number)
    # each but the ends moved by up to an eighth of a step: even ones could hide a period (ISO
    # 230-2)
    share[1:-1] += 0.25 * ((np.arange(1, number - 1) * GOLDEN) % 1.0 - 0.5) / (number - 1)

    def place(t: float) -> dict[str, float]:
        return {x: a + (b - a) * t for x, (a, b) in ends.items()}

    beyond = overrun / size
    title = f"diagonal of {' '.join(ask.axes)}"
    write.begin(title)
    write.rest(middle(write.machine, ask.axes), feed)
    for _ in range(ask.count("runs", 5)):
        write.go(place(-beyond), feed)
        for t in share:
            write.stop(place(float(t)), feed, dwell)
        write.go(place(1.0 + beyond), feed)
        for t in share[::-1]:
            write.stop(place(float(t)), feed, dwell)
    write.go(place(-beyond), feed)
    return Test(write.text(), "laser", {"dwell": f"{dwell:g}", "along": along}, title)


def _ends(
    write: Writer, ask: Ask, overrun: float
) -> tuple[dict[str, tuple[float, float]], float, str]:
    """Begin and end of a diagonal by axis, mm; its length, mm; its direction as --set along says
    it."""
    room = ranges(write.machine, overrun)
    ends = {x: room[x][::-1] if ask.given.get(f"down_{x}") else room[x] for x in ask.axes}
    size = math.sqrt(sum((b - a) ** 2 for a, b in ends.values()))
    return ends, size, ",".join(f"{x}{(b - a) / size:.9f}" for x, (a, b) in ends.items())


def steps(write: Writer, ask: Ask) -> Test:
    """The stair beside a diagonal: one axis after the other moves by its share, and each is read
    (step diagonal; C. Wang, Rev. Sci. Instrum. 71 (2000) 3933). Back the same way. number of steps
    (8), runs, dwell, feed, overrun."""
    overrun = ask.of("overrun", OUTRUN)
    ends, _, along = _ends(write, ask, overrun)
    number, feed, dwell = ask.count("number", 8), ask.of("feed", 2000.0), ask.of("dwell", 3.0)
    before = {x: a - math.copysign(overrun, b - a) for x, (a, b) in ends.items()}
    behind = {x: b + math.copysign(overrun, b - a) for x, (a, b) in ends.items()}
    here = {x: a for x, (a, _) in ends.items()}
    stair = [dict(here)]
    for k in range(1, number + 1):
        for x, (a, b) in ends.items():
            # from the whole each time, so that no step inherits the rounding of those before
            here[x] = round(a + (b - a) * k / number, 3)
            stair.append(dict(here))
    title = f"step diagonal of {' '.join(ask.axes)}"
    write.begin(title)
    write.rest(middle(write.machine, ask.axes), feed)
    for _ in range(ask.count("runs", 1)):
        for outside, way in ((before, stair), (behind, stair[::-1])):
            write.go(outside, feed)
            for place in way:
                write.stop(place, feed, dwell)
    write.go(before, feed)
    return Test(write.text(), "mirror", {"dwell": f"{dwell:g}", "along": along}, title)


def volume(write: Writer, ask: Ask) -> Test:
    """Places all over the volume of these axes, spread evenly (Halton), each reached from below.
    number (120), dwell, feed."""
    room = ranges(write.machine, OUTRUN)
    feed, dwell, number = ask.of("feed", 4000.0), ask.of("dwell", 1.0), ask.count("number", 120)
    write.begin(f"places in {ask.axes}")
    write.rest(middle(write.machine, ask.axes), feed)
    for k in range(1, number + 1):
        at = {x: _halton(k, base) for x, base in zip(ask.axes, (2, 3, 5), strict=False)}
        place = {
            x: round(room[x][0] + share * (room[x][1] - room[x][0]), 3) for x, share in at.items()
        }
        write.go({x: v - OUTRUN for x, v in place.items()}, feed)
        write.stop(place, feed, dwell)
    return Test(write.text(), "tracker", {"dwell": f"{dwell:g}"}, f"places in {ask.axes}")


def _halton(k: int, base: int) -> float:
    """The k-th number of the van der Corput sequence of a base, 0 to 1."""
    found, part = 0.0, 1.0
    while k:
        part /= base
        found += part * (k % base)
        k //= base
    return found
