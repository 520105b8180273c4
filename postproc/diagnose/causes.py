"""Whose a lag is that two effects say alike, where the drive's own force tells.

A lag in proportion to the speed is that of a position loop, or the viscous friction over the static
stiffness of the drive. The force tells the friction; both together tell the stiffness that the
drive would have to have. In a cascade without integral action that is the mass times the gains of
its position and its velocity loop (Gross, Hamann, Wiegaertner, Electrical Feed Drives in
Automation, 2001). A current tells the friction over the mass, as it accelerates the mass too.
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

LAG, FRICTION, INERTIA = "servo_lag", "viscous_friction", "inertia"
# 1/s2, stiffness over mass: gains of 10 and 100 1/s, to a drive as stiff as its screw
STIFF = 1e3, 1e7
# N and A per m/s2, where the signal does not show it: of 100 kg, moved over a screw of 10 mm by a
# motor of 1 N m/A (unverified: usual ones)
MASS = {"N": 100.0, "A": 0.16}


def attributed(search: Search, state: Found, drives: Sequence[Drive]) -> Found:
    """The set in which a lag that the drive's force shows to be viscous friction has that name."""
    of_axis = {d.axis: _damping(d) for d in drives}
    members = [search.sets.blocks[k] for k in state.members]
    for k, block in zip(state.members, members, strict=True):
        both = any(b.name == FRICTION and b.axis == block.axis for b in members)
        if block.name != LAG or both:
            continue
        value = search.sets.value(state.fit, k)
        tau_ms = block.module.parameters(value, dict(block.shape))["tau_ms"]
        if not STIFF[0] < of_axis.get(block.axis, 0.0) / max(tau_ms * 1e-3, 1e-9) < STIFF[1]:
            continue
        module, shape = effects.load(FRICTION), {"power": 1.0} | dict(block.shape)
        make = partial(library.read, search.sets.rows, module, block.axis, shape)
        same = replace(block, module=module, shape=library.named(shape), make=make)
        others = tuple(m for m in state.members if m != k)
        state = search.sets.of((*others, search.sets.let_in(same)), state.fit.on, state)
    return state


def _damping(drive: Drive) -> float:
    """1/s, viscous friction over the mass, in a force or a current; 0 where it shows none."""
    of = {f.term.name: f.value for f in drive.fitted if not f.delayed}
    rubs = of.get(FRICTION, {}).get(f"{drive.unit}_per_m_s", 0.0)
    return rubs / of.get(INERTIA, {}).get(f"{drive.unit}_per_m_s2", MASS[drive.unit])
