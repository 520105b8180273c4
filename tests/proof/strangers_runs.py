"""One recording of each kind on one mill, for the tests of the families of strangers."""

from __future__ import annotations

from proof.strangers.base import stream
from proof.strangers.designs import ballbar, features, targets
from proof.strangers.machines import draw_machine
from proof.strangers.motion import trace

MILL = draw_machine(stream("mill"), kind="mill")


def run(**force):
    return targets(
        stream("t"), MILL, 0, 0.0, "r1", force={"n": 20, "runs": 2, "pattern": "iso", **force}
    )


def jog(sees="tool", **force):
    force = {"path": "jog", "rows": 2000, "rate": 20, **force}
    return trace(stream("c"), MILL, 0.0, "r3", sees, force=force)


def files():
    return [
        run(),
        ballbar(stream("b"), MILL, 0.0, "r2"),
        jog(),
        features(stream("p"), MILL, 0.0, "r4"),
    ]
