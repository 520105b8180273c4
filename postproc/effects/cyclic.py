"""Cyclic error: periodic in the position, of a screw's turn or a scale's grating.

What turns gives a second wave per turn besides (a bent shaft's bearing, a coupling's joints), an
amplitude that grows with the distance of the nut from the bearing that wobbles, and one that is
another from the other side, where flanks do not run alike.
"""

import numpy as np

from postproc.effects import (
    State,
    Table,
    along,
    amplitude_and_phase,
    harmonic_coefficients,
    waves_of,
)

PARAMETERS = {
    "period_mm": "mm, its period",
    "amplitude_um": "um, zero to peak, at the middle of the travel",
    "phase_deg": "degrees, of a cosine at zero",
    "second_um": "um, zero to peak, of a second wave of half the period",
    "second_deg": "degrees, its phase",
    "grows_um": "um, by how much the amplitude differs at the upper end of the travel",
    "grows_deg": "degrees, the phase of that difference",
    "sided_um": "um, by how much the amplitude of either side of approach differs from their mean",
    "sided_deg": "degrees, the phase of that difference, coming from -",
}
MORE = ("second", "grows", "sided")
OPTIONAL = {f"{name}_{unit}": 0.0 for name in MORE for unit in ("um", "deg")}
PLAIN = dict.fromkeys(MORE, 0.0)
LEADS = (
    1.0,
    2.0,
    2.5,
    3.0,
    4.0,
    5.0,
    6.0,
    8.0,
    10.0,
    12.0,
    16.0,
    20.0,
    25.0,
    32.0,
    40.0,
)  # mm: ISO 3408-2, nominal leads
# A bent screw's end or a coupling swings by no more than its run-out, a few 0.1 mm (unverified);
# what comes with it is smaller, see sensible.
PLAUSIBLE = {"amplitude_um": (0.0, 500.0)}  # beyond, it is something else
# of the amplitude: what vanishes at one end or from one side; beyond, it is another wave
MOST = 1.0
# fewer go through any wave: a mean, two waves of one period and what comes with them have seven
# values
PLACES = 8
TURNS = 1.99  # of the screw: fewer are a curve; travels of whole turns are rounded
CONTINUOUS = {"period_mm": (0.0, 1e4)}
COARSEST = 4  # nodes a period: lines between them leave a third of the wave
KIND, USE, PER = "machine", "compensate", "axis"
ALONG = True
NEEDS, SEES = ("position",), ("tool", "part")
TEXT = (
    "The position error repeats once per turn of the screw or per period of the scale. "
    "Compare the period with the lead; the table must be several nodes a period."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    """What screws are made with; others are found from the spectrum of what is left, see
    diagnose."""
    span = float(np.ptp(state.position[axis]))
    if len(np.unique(np.round(state.position[axis], 2))) < PLACES:
        return []
    return [{"period_mm": lead} | PLAIN for lead in LEADS if TURNS * lead < span]


def fuller(shape: dict[str, float], state: State, axis: str) -> list[dict[str, float]]:
    """The same wave with what may come with it."""
    plain = {"period_mm": shape["period_mm"]} | PLAIN
    sets = (("second",), ("grows",), ("sided",), ("second", "grows"), ("second", "sided"))
    return [plain | dict.fromkeys(names, 1.0) for names in sets]


def sensible(
    amplitude_um: float, second_um: float, grows_um: float, sided_um: float = 0.0, **named: float
) -> bool:
    """Whether the rest is small beside the wave itself."""
    return max(second_um, grows_um, sided_um) <= MOST * amplitude_um


def columns(
    state: State,
    axis: str,
    period_mm: float,
    second: float = 0.0,
    grows: float = 0.0,
    sided: float = 0.0,
) -> np.ndarray:
    waves = waves_of(state, axis, 1 / period_mm)
    found = list(waves)
    if second:
        found += waves_of(state, axis, 2 / period_mm)
    if grows:
        # share: -1 at the low end, +1 at the high one, so that amplitude_um is that of the middle
        found += [state.share(axis) * wave for wave in waves]
    if sided:
        found += [state.approach[axis] * wave for wave in waves]
    return along(axis, *found)


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    rest = list(np.asarray(coefficients)[2:].reshape(-1, 2))
    named = {"period_mm": shape["period_mm"]} | amplitude_and_phase(coefficients[:2])
    for name in MORE:
        value = (
            amplitude_and_phase(rest.pop(0))
            if shape.get(name)
            else {"amplitude_um": 0.0, "phase_deg": 0.0}
        )
        named |= {f"{name}_um": value["amplitude_um"], f"{name}_deg": value["phase_deg"]}
    return named


def coefficients(
    period_mm: float,
    amplitude_um: float,
    phase_deg: float,
    second_um: float = 0.0,
    second_deg: float = 0.0,
    grows_um: float = 0.0,
    grows_deg: float = 0.0,
    sided_um: float = 0.0,
    sided_deg: float = 0.0,
) -> tuple[np.ndarray, dict[str, float]]:
    shape, value = {"period_mm": period_mm}, [harmonic_coefficients(amplitude_um, phase_deg)]
    sizes = ((second_um, second_deg), (grows_um, grows_deg), (sided_um, sided_deg))
    for name, (size, phase) in zip(MORE, sizes, strict=True):
        if size:
            value.append(harmonic_coefficients(size, phase))
        shape[name] = float(bool(size))
    return np.concatenate(value), shape


def tables(axis: str, travel: tuple[float, float], **named: float) -> list[Table]:
    """24 nodes a period, of the second wave where there is one: what is left between them is below
    1 % of the amplitude; none where a table would be too coarse for the wave."""
    value, shape = coefficients(**named)
    finest = shape["period_mm"] / (2 if shape.get("second") else 1)
    # A chord of 1 / 24 of a period misses a cosine by 1 - cos(pi / 24) = 0.9 % of its amplitude.
    # 200,000 nodes: 8 m of travel at the finest lead of 1 mm.
    turns = (travel[1] - travel[0]) / finest
    number = min(int(np.ceil(turns * 24)) + 1, 200_000)
    if number < COARSEST * turns:
        return []  # lines between so few nodes are another wave, and add to it
    nodes = np.linspace(*travel, number)
    errors = []
    for side in (1.0, -1.0):
        state = State(
            position={axis: nodes}, approach={axis: np.full(number, side)}, travel={axis: travel}
        )
        errors.append(np.tensordot(value, columns(state, axis, **shape), axes=1)["XYZ".index(axis)])
    return [(f"E{axis}", axis, nodes, *errors)]
