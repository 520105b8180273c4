"""The two recordings of a ballbar beside a turning table in sample_recordings, as the model of
example-five-axis gives them (ISO 10791-6): `python -m tests.volumetric.table_ballbar` writes them.

One ball sits on the table, the other in the spindle, which follows it while C or A turns; the bar
of 100 mm turns with the table. In one mode it lies radially, from the axis to the ball, in the
other along the axis. 0.3 um of noise; the ball's place is stated to half a millimetre."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from postproc.machine.file import read_machine
from postproc.machine.poses import slides_at, tips
from postproc.recordings import Recording, contract

ROOT = Path(__file__).resolve().parents[2]
BAR, NOISE = 100.0, 3e-4  # mm
# A ball for each axis, in the part, and the bar's way from it: along the radius, along the axis.
BALLS = {"C": ((120.0, 30.0, -330.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
         "A": ((-40.0, 90.0, -300.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0))}  # fmt: skip
TURNS = {"C": np.arange(0.0, 360.0, 10.0), "A": np.arange(-90.0, 91.0, 5.0)}
TITLE = "written by tests/volumetric/table_ballbar.py from the model of example-five-axis"


def texts() -> dict[str, str]:
    """File name to text."""
    rng = np.random.default_rng(10791)
    return {
        f"table_ballbar_{mode}.csv": _text(mode, k, rng)
        for k, mode in ((1, "radial"), (2, "axial"))
    }


def _text(mode: str, k: int, rng: np.random.Generator) -> str:
    machine = read_machine(ROOT / "machines" / "example-five-axis")
    parts: list[dict[str, np.ndarray]] = []
    for station, (axis, ways) in enumerate(BALLS.items(), 1):
        ball, angle = np.array(ways[0]), TURNS[axis]
        n = len(angle)
        q = np.zeros((5, n))
        q[machine.letters.index(axis)] = angle
        q = slides_at(machine, np.repeat((ball + BAR * np.array(ways[k]))[:, None], n, axis=1), q)
        tip = tips(machine, q) + machine.carried(q, 0 * q)[0]
        length = np.linalg.norm(tip - ball[:, None], axis=0) + NOISE * rng.normal(size=n)
        columns = {
            f"{x}_{'mm' if x in 'XYZ' else 'deg'}": q[i] for i, x in enumerate(machine.letters)
        }
        columns |= {"length_mm": np.round(length, 5), "station": np.full(n, float(station))}
        said = np.round(ball + 0.5 * rng.normal(size=3), 1)
        columns |= {f"station_{x}_mm": np.full(n, v) for x, v in zip("XYZ", said, strict=True)}
        parts.append({name: np.round(v, 5) for name, v in columns.items()})
    columns = {name: np.concatenate([p[name] for p in parts]) for name in parts[0]}
    head = {"instrument": f"ballbar, {mode}", "u_um": NOISE * 1e3, "simulated": True, "how": TITLE}
    return contract.write(Recording("lengths", head, columns))


if __name__ == "__main__":
    for name, text in texts().items():
        (ROOT / "sample_recordings" / name).write_text(text)
