"""Sensor drift: a thermometer walks away, jumps or hangs; a laser that is told its air temperature
reads a length as wrong.

0.93 ppm of the beam's length for each K: Edlen's equation at 20 degrees Celsius, as in laser_air.
"""

import numpy as np

from postproc.effects import State
from postproc.effects._named import by_name
from postproc.effects.laser_air import light

PARAMETERS = {"K_per_h": "K/h, by how much more the thermometer reads with every hour"}
KIND, USE, PER = "data", "recording", "all"
NEEDS, SEES = ("time",), ("laser",)
LIGHT = True
LISTED = True
PPM_K = 0.93
TEXT = (
    "A thermometer does not read the temperature of what it lies on. What goes with temperature can"
    " not be trusted: change two sensors over, and correct the recording, not the machine."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    # the channel itself shows it, see diagnose.thermometers: from readings alone it is warm air
    return []


def columns(state: State, axis: str) -> np.ndarray:
    # the laser believes the thermometer: 0.93 ppm of its beam for each K that it reads too much
    hours = (state.time - state.time.min()) / 3600.0
    return (PPM_K * 1e-6 * hours * light(state))[None]


parameters, coefficients = by_name(PARAMETERS, {}, "K_per_h")
