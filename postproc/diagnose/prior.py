"""What is believed of an effect before the readings are looked at: how seldom its name is, which
signs and sizes machines have."""

from __future__ import annotations

import math

import numpy as np

from postproc.diagnose.block import Block

ODDS = 8.0  # twice ln(55): of some 60 effects and axes a machine shows one or two
APART = 7.0  # of two axes, where each shows by itself: one of them leads, or both lag
AGAIN = 4.0  # of a further jump of the same axis
# Further cost, twice the logarithm of how much seldomer it is than its kin (unverified but for the
# order: an error of the scale, the squareness and lost motion are what ISO 230-2 and 230-4 list
# first; what differs along the travel or with the direction is lost motion or friction, and more).
RARE = {
    "servo_mismatch": -3.0, "squareness": -2.0, "bow": 2.0, "viscous_friction": 6.0,
    "coulomb_friction": 2.0, "step_loss": 8.0, "clock_skew": 2.0, "sag": 4.0, "stick_slip": 8.0,
    "scale": -1.0, "tool_size": -1.0, "backlash_position": 1.0, "friction_asymmetry": 3.0,
    "windup": 1.0, "delay": 2.0,
}  # fmt: skip


def cost_of(block: Block) -> float:
    """What a block pays for its name and for the shapes that it was chosen from, twice the
    logarithm."""
    again = AGAIN * (len(block.shape) - 1) if block.name == "step_loss" else 0.0
    usual = min(_further(block), 0.0)
    return rarity(block) + usual + 2 * math.log(block.siblings) + again


def rarity(block: Block) -> float:
    """Of its name, and of a shape that is seldomer than the others of that, twice the logarithm."""
    apart = APART if block.apart else 0.0
    return ODDS + RARE.get(block.name, 0.0) + max(_further(block), 0.0) + apart


def _further(block: Block) -> float:
    further = getattr(block.module, "further_cost", None)
    return float(further(block.axis, dict(block.shape))) if further else 0.0


def unusual(block: Block, coefficients: np.ndarray) -> int:
    """How many of the named parameters have another sign than they usually have."""
    expected = getattr(block.module, "EXPECTED", None)
    if not expected:
        return 0
    named = block.module.parameters(coefficients, dict(block.shape))
    return sum(named[name] * sign < 0 for name, sign in expected.items())


def plausible(block: Block, coefficients: np.ndarray) -> bool:
    """Whether the named parameters are such as machines have, and such as the name says."""
    limits, sensible = (
        getattr(block.module, "PLAUSIBLE", {}),
        getattr(block.module, "sensible", None),
    )
    if not limits and sensible is None:
        return True
    named = block.module.parameters(coefficients, dict(block.shape))
    if sensible is not None and not sensible(**named):
        return False
    return all(low <= named[name] <= high for name, (low, high) in limits.items())
