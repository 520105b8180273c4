"""Cyclic error: periodic in the position, of a screw's turn or a scale's grating.

What turns gives a second wave per turn besides (a bent shaft's bearing, a coupling's joints), and a swing that grows with the
distance of the nut from the bearing that wobbles.
"""

import numpy as np

from postproc.effects import State, along, swing, swing_coefficients, waves_of

PARAMETERS = {
    "period_mm": "mm, its period",
    "amplitude_um": "um, half of the swing, at the middle of the travel",
    "phase_deg": "degrees, of a cosine at zero",
    "second_um": "um, half of the swing of a second wave of half the period",
    "second_deg": "degrees, its phase",
    "grows_um": "um, by how much the swing differs at the upper end of the travel",
    "grows_deg": "degrees, the phase of that difference",
}
OPTIONAL = {"second_um": 0.0, "second_deg": 0.0, "grows_um": 0.0, "grows_deg": 0.0}
# A bent screw's end or a coupling swings by no more than its run-out, a few 0.1 mm (unverified); what comes with it is smaller, see sensible.
PLAUSIBLE = {"amplitude_um": (0.0, 500.0)}  # beyond, it is something else
SECOND, GROWS = 0.5, 0.5  # of the amplitude: beyond, it is another wave
CONTINUOUS = {"period_mm": (0.0, 1e4)}
KIND, USE, PER = "machine", "compensate", "axis"
NEEDS, SEES = ("position",), ("tool", "part")
TEXT = (
    "The position swings once per turn of the screw or per period of the scale. "
    "Compare the period with the lead; the table must be several nodes a period."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return []  # found from the spectrum of what is left, see diagnose


def fuller(shape: dict[str, float]) -> list[dict[str, float]]:
    """The same wave with what may come with it."""
    plain = {"period_mm": shape["period_mm"]}
    return [plain | {"second": s, "grows": g} for s, g in ((1.0, 0.0), (0.0, 1.0), (1.0, 1.0))]


def sensible(amplitude_um: float, second_um: float, grows_um: float, **named: float) -> bool:
    """Whether the rest is small beside the wave itself."""
    return second_um <= SECOND * amplitude_um and grows_um <= GROWS * amplitude_um


def columns(state: State, axis: str, period_mm: float, second: float = 0.0, grows: float = 0.0) -> np.ndarray:
    waves = []
    for number in (1, 2) if second else (1,):
        waves += waves_of(state, axis, number / period_mm)
    if grows:
        u = state.share(axis)
        waves += [u * waves[0], u * waves[1]]
    return along(axis, *waves)


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    rest = list(np.asarray(coefficients)[2:].reshape(-1, 2))
    named = {"period_mm": shape["period_mm"]} | swing(coefficients[:2])
    for name in ("second", "grows"):
        value = swing(rest.pop(0)) if shape.get(name) else {"amplitude_um": 0.0, "phase_deg": 0.0}
        named |= {f"{name}_um": value["amplitude_um"], f"{name}_deg": value["phase_deg"]}
    return named


def coefficients(
    period_mm: float, amplitude_um: float, phase_deg: float, second_um: float = 0.0, second_deg: float = 0.0,
    grows_um: float = 0.0, grows_deg: float = 0.0,
) -> tuple[np.ndarray, dict[str, float]]:  # fmt: skip
    shape, value = {"period_mm": period_mm}, [swing_coefficients(amplitude_um, phase_deg)]
    for name, size, phase in (("second", second_um, second_deg), ("grows", grows_um, grows_deg)):
        if size:
            value.append(swing_coefficients(size, phase))
        if second_um or grows_um:
            shape[name] = float(bool(size))
    return np.concatenate(value), shape


def tables(axis: str, travel: tuple[float, float], **named: float):
    """24 nodes a period, of the second wave where there is one: what is left between them is below 1 % of the amplitude."""
    value, shape = coefficients(**named)
    finest = shape["period_mm"] / (2 if shape.get("second") else 1)
    number = min(int(np.ceil((travel[1] - travel[0]) / finest * 24)) + 1, 200_000)
    nodes = np.linspace(*travel, number)
    state = State(position={axis: nodes}, approach={axis: np.ones(number)}, travel={axis: travel})
    error = np.tensordot(value, columns(state, axis, **shape), axes=1)["XYZ".index(axis)]
    return [(f"E{axis}", axis, nodes, error, error)]
