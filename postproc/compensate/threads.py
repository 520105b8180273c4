"""Threads: what of a correction a motion tied to the spindle can take, and what it can not, with
its numbers.

Across the lead a thread is corrected along the way where its control goes through several blocks in
step; elsewhere at its ends. Along the lead the axis follows the spindle, lead times turns, whatever
the words say: only where it begins and ends is corrected, and the map's slope stays in the lead: a
map that rises by 20 um over 100 mm of Z makes every turn of 2 mm longer by 0.4 um.
"""

from __future__ import annotations

import numpy as np

from postproc.compensate import nodes
from postproc.compensate.batch import Batch
from postproc.compensate.inverse import command
from postproc.errors import Notice
from postproc.motions import THREAD
from postproc.units import TICKS_PER_MM, UM

# what is said of a thread, and what can be done
UNLED = (
    "a thread begins where no motion was corrected before it",
    "lead to its start by a motion of its own",
)
TURNED = (
    "an axis turns back where a thread begins, before which nothing can be put in",
    "let each axis go on in its direction there, or begin the thread anew behind a rapid",
)


def say(b: Batch) -> None:
    """One notice of what bends between the ends of a thread that stays one block, one of what its
    lead is off by."""
    stroke = ((b.m.code[b.motion] == THREAD) & b.free[b.motion] & b.known_before).nonzero()[0]
    if not len(stroke):
        return
    owner, t, correction = _along(b, stroke)
    #   start o---------------> end     The correction c(t) is split: what of it lies across the way
    #          \ c(t)                   bends the thread (`aside`), and a cut would take it out;
    #           v                       what lies along it (`ahead`) the spindle's turns decide.
    way = (b.end_nominal - b.begin_nominal)[b.rows][:, stroke]
    length = np.linalg.norm(way, axis=0)
    ahead = (correction * (way / np.where(length > 0, length, 1.0))[:, owner]).sum(axis=0)
    bend, slope, drift = np.zeros(len(stroke)), np.zeros(len(stroke)), np.zeros(len(stroke))
    for k in range(len(stroke)):
        mine = owner == k
        at, own, along = t[mine], correction[:, mine], ahead[mine]
        # Off the chord between the corrected ends, and across the way alone: where on the way the
        # tool stands the spindle decides, which turns evenly.
        aside = own - own[:, :1] - (own[:, -1:] - own[:, :1]) * at
        aside -= way[:, [k]] * (way[:, [k]] * aside).sum(axis=0) / max(length[k] ** 2, 1e-30)
        bend[k] = np.linalg.norm(aside, axis=0).max()
        slope[k] = np.abs(np.diff(along) / np.diff(at)).max() / max(length[k], 1e-9)
        drift[k] = np.ptp(along)
    _say_begin(b, stroke)
    lead = b.m.lead[b.motion[stroke]]
    for worst in np.argsort(-np.where(b.m.whole[b.motion[stroke]], bend, 0.0))[:1]:
        if b.m.whole[b.motion[stroke[worst]]] and bend[worst] > b.c.tolerance:
            b.notices.append(
                Notice(
                    "thread",
                    "a thread that stays one block is corrected at its ends only: between them "
                    f"it stays off by up to {bend[worst] / UM:.1f} um",
                    int(b.motion[stroke[worst]]),
                    float(bend[worst]),
                )
            )
    worst = int(np.argmax(drift))
    if drift[worst] > b.c.tolerance:
        turn = (
            f", {slope[worst] * lead[worst] / UM:.3f} um a turn of {lead[worst]:g} mm"
            if lead[worst]
            else ""
        )
        b.notices.append(
            Notice(
                "lead",
                "along a thread the axis follows the spindle: its lead stays off by up to"
                f" {slope[worst] * 1e6:.0f} um/m{turn}, which adds up to {drift[worst] / UM:.1f} um"
                " over its length",
                int(b.motion[stroke[worst]]),
                float(drift[worst]),
            )
        )


def _say_begin(b: Batch, stroke: np.ndarray) -> None:
    """One notice of threads that begin where nothing was corrected before, and one of those that
    begin beside their way since an axis turns back, where nothing is put in: between threads that
    go on in step, under G93, and where a block does not name its code."""
    nominal = b.begin_nominal[:, stroke]
    wanted = command(b.machine, nominal, b.weight_begin[:, stroke], b.motion[stroke])
    off = (wanted - b.begin[:, stroke] / TICKS_PER_MM)[b.rows]
    way = (b.end_nominal[:, stroke] - nominal)[b.rows]
    aside = off - way * ((off * way).sum(axis=0) / np.maximum((way**2).sum(axis=0), 1e-30))
    grid = b.m.grid[:, b.motion[stroke]].max(axis=0) / TICKS_PER_MM
    sure = b.sure[stroke]
    unled = np.where(sure, 0.0, np.linalg.norm(off, axis=0))
    turned = np.where(sure & ~b.cutting[stroke], np.linalg.norm(aside, axis=0), 0.0)
    for code, beside, allowed, said, advice in (
        ("unled", unled, b.c.tolerance + 0 * grid, *UNLED),
        ("turned", turned, b.c.allowed(grid), *TURNED),
    ):
        worst = int(np.argmax(beside))
        if beside[worst] > allowed[worst]:
            number = f"it begins {beside[worst] / UM:.1f} um off"
            motion = int(b.motion[stroke[worst]])
            b.notices.append(
                Notice(code, f"{said}: {number}; {advice}", motion, float(beside[worst]))
            )


def _along(b: Batch, stroke: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(K,) index into stroke, (K,) t from 0 to 1 with every place where the map bends, (rows, K) mm
    correction there."""
    start, target = b.begin_nominal[:, stroke], b.end_nominal[:, stroke]
    owner, t, _ = nodes.candidates(b.machine, start, target, b.c.slack)
    every = np.arange(len(stroke))
    owner = np.concatenate([owner, every, every])
    t = np.concatenate([t, np.zeros(len(stroke)), np.ones(len(stroke))])
    order = nodes.tidy(owner, t)
    owner, t = owner[order], t[order]
    place = start[:, owner] + (target - start)[:, owner] * t
    exact = command(b.machine, place, b.weight(stroke[owner], place), b.motion[stroke[owner]])
    return owner, t, (exact - place)[b.rows]
