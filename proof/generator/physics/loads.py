"""Loads, tools and lost steps."""

from __future__ import annotations

import numpy as np

from proof.generator.machines import XYZ
from proof.generator.physics import Effect, Scene, Shift, own
from proof.generator.tracks import Track


def force_compliance(scene: Scene, axis: str, rng: np.random.Generator) -> Effect | None:
    """Rolling contacts give way by Hertz: less for every newton more. size: um/N at the load that
    is met most."""
    i = XYZ.index(axis)
    met = [np.abs(t.force[:, i]) for t in scene.design.tracks if len(t.force)]
    met = [f[f > 50] for f in met]
    met = [f for f in met if len(f)]
    if not met:
        return None
    usual = float(np.median(np.concatenate(met)))
    power = rng.uniform(0.67, 0.9)

    def value(track: Track) -> np.ndarray | None:
        if not len(track.force):
            return None
        force = track.force[:, i]
        return np.sign(force) * usual * (np.abs(force) / usual) ** power

    return Effect(
        "force_compliance",
        axis,
        own(axis, value),
        lambda size: {"um_per_N": size},
        largest=1.0,
        signed=False,
    )


def tool_wear(scene: Scene, axis: str, rng: np.random.Generator) -> Effect | None:
    """The edge breaks in, wears evenly, then faster; a new tool begins again."""
    world = scene.world
    kinds = {"targets"} if scene.machine.form == "mill" else {"targets", "features"}
    if not any(t.changes and t.kind in kinds for t in scene.design.tracks):
        return None
    cut = world.cut
    life = max(float(cut.max()), 1e-3)
    early, late = rng.uniform(0.1, 0.35), rng.uniform(0.0, 0.5)
    worn = (
        early * (1 - np.exp(-cut / (0.08 * life)))
        + (1 - early) * cut / life
        + late * np.maximum(cut / life - 0.7, 0) ** 2 * 6
    )

    def value(track: Track) -> np.ndarray | None:
        if track.kind not in kinds or not track.changes:
            return None  # other tests are made with a mandrel, not with the edge
        return world.steps_at(worn, track.time)

    return Effect("tool_wear", axis, own(axis, value), signed=False)


def tool_size(scene: Scene, axis: str, rng: np.random.Generator) -> Effect | None:
    """A tool thicker than assumed: pockets and bores too large, bosses too small, distances right.
    size: um of diameter."""
    if not any(t.kind == "features" for t in scene.design.tracks):
        return None

    def on(track: Track) -> Shift | None:
        if track.kind != "features":
            return None
        return Shift(reading=np.array([float(f["size"]) for f in track.features]))

    return Effect("tool_size", None, on, lambda size: {"diameter_um": size})


def step_loss(scene: Scene, axis: str, rng: np.random.Generator) -> Effect | None:
    """A coupling slips once. size: um of the jump."""
    i = XYZ.index(axis)
    seen = [
        t for t in scene.design.tracks
        if (t.kind == "targets" and t.quantity != "angle" and abs(t.sensitive[i]) > 0.3)
        or (t.kind == "trace" and t.head["sees"] == "tool" and axis in t.moving)
    ]  # fmt: skip
    if not seen:
        return None
    track = seen[int(rng.integers(len(seen)))]
    when = float(
        rng.uniform(
            track.time[0] + 0.2 * np.ptp(track.time), track.time[0] + 0.8 * np.ptp(track.time)
        )
    )
    return Effect(
        "step_loss",
        axis,
        own(axis, lambda t: (t.time > when).astype(float)),
        lambda size: {"jump_um": size, "t_s": when},
    )


DRAW = {f.__name__: f for f in (force_compliance, tool_wear, tool_size, step_loss)}
