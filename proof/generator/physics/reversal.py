"""Lost motion: dead travel, dead travel that varies, and sliders that give way one after the
other."""

from __future__ import annotations

import numpy as np

from proof.generator.mechanics import iwan, play
from proof.generator.physics import Effect, Scene, history, own, share
from proof.generator.streams import log_uniform
from proof.generator.tracks import Track


def backlash(scene: Scene, axis: str, rng: np.random.Generator) -> Effect:
    """A gap in the drive. size: the whole gap in um; the truth's size_um is that."""

    def value(track: Track) -> np.ndarray:
        way, rows = history(track, axis)
        return play(way, 0.006)[rows] / 0.006

    return Effect(
        "backlash", axis, own(axis, value), lambda size: {"size_um": size}, gap=np.ones_like
    )


def backlash_position(scene: Scene, axis: str, rng: np.random.Generator) -> Effect:
    """Wear of the screw where it works most: the gap is a bump, or two, or opens towards an end."""
    form = rng.choice(["bump", "two", "end"])
    centre, width = rng.uniform(0.2, 0.8), rng.uniform(0.1, 0.25)
    other = float(np.clip(centre + rng.choice([-1, 1]) * rng.uniform(0.35, 0.5), 0, 1))
    base = rng.uniform(-0.3, 0.3)

    def gap(u: np.ndarray) -> np.ndarray:
        bump = np.exp(-((u - centre) ** 2) / (2 * width**2))
        if form == "two":
            bump = bump - 0.8 * np.exp(-((u - other) ** 2) / (2 * width**2))
        if form == "end":
            bump = 1 / (1 + np.exp(-(u - centre) / (0.4 * width)))
        return base + bump

    def value(track: Track) -> np.ndarray:
        way, rows = history(track, axis)
        return play(way, 0.006)[rows] / 0.006 * gap(share(scene, track, axis))

    def at(x: np.ndarray) -> np.ndarray:
        span = scene.machine.axes[axis]
        return gap((x - span.low) / span.length)

    return Effect("backlash_position", axis, own(axis, value), gap=at)


def windup(scene: Scene, axis: str, rng: np.random.Generator) -> Effect:
    """Fourteen sliders between drive and table whose limits spread over a distance after the
    reversal."""
    far = log_uniform(rng, 0.8, 8.0)
    yields = far * np.geomspace(0.05, 1.0, 14) / 2
    shares = rng.dirichlet(np.full(14, 6.0)) * np.linspace(1.3, 0.7, 14)
    shares /= shares.sum()

    def value(track: Track) -> np.ndarray:
        way, rows = history(track, axis)
        return -0.5 * iwan(way, yields, shares)[rows]

    return Effect("windup", axis, own(axis, value), signed=False)


DRAW = {"backlash": backlash, "backlash_position": backlash_position, "windup": windup}
