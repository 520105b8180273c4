"""Which motions can be corrected where positions are not known: only what a correction depends on
must be.

An axis matters in a motion if its correction may change there, since it moves or one that it
depends on does. A motion is known if all that the corrections of those axes depend on is; the other
axes stay where they are.
"""

from __future__ import annotations

import numpy as np

from postproc.flags import all_of
from postproc.machine.model import Machine
from postproc.motions import HOLE, Motions
from postproc.records import columns


@columns
class Known:
    """end, start (N,): whether all that matters is known at a motion's end, at its start. rows (A,
    N): whether an axis' correction can be told at the end. idle (N,): whether nothing can change,
    so that unknown places do not matter. wanting (A, N): axes whose place is not known at the end,
    and needed. every: whether all places are known."""

    end: np.ndarray
    start: np.ndarray
    rows: np.ndarray
    idle: np.ndarray
    wanting: np.ndarray
    every: bool = False


def known(machine: Machine, m: Motions) -> Known:
    """What is known of a batch of motions."""
    chained = list(machine.chained)
    shape = m.target_known.shape
    both = m.target_known & m.start_known
    every = all_of(both)
    if every or both[chained].all():
        no = np.zeros(shape, bool)
        yes = ~no
        return Known(end=yes[0], start=yes[0], rows=yes, idle=no[0], wanting=no, every=every)
    needs = machine.depends.astype(np.int64)
    moved = (m.word >= 0) | (m.target != m.start) | (m.sent & m.start_known)
    for axes in (m.arcs.first, m.arcs.second):
        moved[axes, m.arcs.motion] = True
    moved[:, m.code == HOLE] = True
    matters = needs @ moved.astype(np.int64) > 0
    lacks = needs @ (~m.target_known).astype(np.int64) > 0
    lacked = needs @ (~m.start_known).astype(np.int64) > 0
    return Known(
        end=~(matters & lacks).any(axis=0), start=~(matters & lacked).any(axis=0), rows=~lacks,
        idle=~matters.any(axis=0) & lacks.any(axis=0),
        wanting=(needs.T @ (matters & lacks).astype(np.int64) > 0) & ~m.target_known,
    )  # fmt: skip
