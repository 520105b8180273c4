"""Whose a lag is that two effects say alike, where the drive's own force tells.

A lag in proportion to the speed is that of a position loop, or the viscous friction over the static
stiffness of the drive. The force tells the friction; both together tell the stiffness that the
drive would have to have. In a cascade without integral action that is the mass times the gains of
its position and its velocity loop (Gross, Hamann, Wiegaertner, Electrical Feed Drives in
Automation, 2001).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

from postproc import effects
from postproc.diagnose import library
from postproc.diagnose.drive import Drive
from postproc.diagnose.search import Search
from postproc.diagnose.sets import Found

LAG, FRICTION = "servo_lag", "viscous_friction"
# N/um: of 100 kg with gains of 10 and 100 1/s, to a drive as stiff as its screw
STIFF = 0.1, 1000.0


def attributed(search: Search, state: Found, drives: Sequence[Drive]) -> Found:
    """The set in which a lag that the drive's force shows to be viscous friction has that name."""
    of_axis = {d.axis: d for d in drives if d.unit == "N"}
    members = [search.sets.blocks[k] for k in state.members]
    for k, block in zip(state.members, members, strict=True):
        both = any(b.name == FRICTION and b.axis == block.axis for b in members)
        if block.name != LAG or block.axis not in of_axis or both:
            continue
        value = search.sets.value(state.fit, k)
        tau_ms = block.module.parameters(value, dict(block.shape))["tau_ms"]
        stiff = 1e-3 * _friction(of_axis[block.axis]) / max(tau_ms, 1e-9)  # N/um
        if not STIFF[0] < stiff < STIFF[1]:
            continue
        module, shape = effects.load(FRICTION), {"power": 1.0} | dict(block.shape)
        make = partial(library.read, search.sets.rows, module, block.axis, shape)
        same = replace(block, module=module, shape=library.named(shape), make=make)
        others = tuple(m for m in state.members if m != k)
        state = search.sets.of((*others, search.sets.let_in(same)), state.fit.on, state)
    return state


def _friction(drive: Drive) -> float:
    """N s/m of viscous friction in a force; 0 where it shows none."""
    return sum(f.value["N_per_m_s"] for f in drive.fitted if f.term.name == FRICTION)
