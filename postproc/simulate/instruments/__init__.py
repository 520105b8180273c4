"""Instruments: what each would have read while a program ran. One file an instrument, found by its
name.

A module holds TITLE, what it is; SETTINGS, name to meaning, with the unit; and measure(reality,
settings) -> Signal: the reading without noise. Noise, set-up zero and resolution are the same for
all and come here.
"""

from __future__ import annotations

import importlib
import pkgutil
import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np

from postproc.effects import State
from postproc.errors import GcompError, UsageError
from postproc.recordings import Recording

MOST = 5_000_000  # samples
LARGEST = 1e12  # of a setting


@dataclass(frozen=True)
class Signal:
    """A recording without noise. kind, head, columns as in the contract of recordings; noisy:
    column to the micrometres (or urad) of one of its units; state: of the rows; channels: which of
    its channels are recorded."""

    kind: str
    head: dict[str, Any]
    columns: dict[str, np.ndarray]
    noisy: dict[str, float]
    state: State
    channels: tuple[str, ...] = ()


@dataclass(frozen=True)
class Noise:
    """What a reading suffers from. size: um or urad, standard deviation; tails: degrees of freedom
    of Student's t, 0: Gaussian;
    resolution: um or urad, 0: none; zero: um or urad of the set-up, "first" (the first reading is
    zero) or "random" (Gaussian, `spread` um); seed; sensors: K, standard deviation of recorded
    temperatures."""

    size: float = 0.0
    tails: float = 0.0
    resolution: float = 0.0
    zero: float | str = 0.0
    seed: int = 0
    sensors: float = 0.0
    spread: float = 3.0

    def draw(self, rng: np.random.Generator, n: int) -> np.ndarray:
        """(n,) values with the stated standard deviation."""
        if not self.tails:
            return self.size * rng.standard_normal(n)
        # Student's t has the variance nu / (nu - 2): scaled to the stated standard deviation
        return self.size * rng.standard_t(self.tails, n) * np.sqrt((self.tails - 2.0) / self.tails)


class Settings:
    """What --set says, read by name; what is left unread at the end is an error."""

    def __init__(self, instrument: str, known: Mapping[str, str], given: Mapping[str, str]):
        self.instrument, self.known, self.given = instrument, known, dict(given)
        for name in self.given:
            if name not in known:
                settings = "; ".join(f"{k} ({v})" for k, v in known.items())
                raise UsageError(f"{instrument} has no setting {name!r}", f"settings: {settings}")

    def _fault(self, name: str, wanted: str) -> UsageError:
        return UsageError(
            f"--set {name}={self.given[name]} is not {wanted}", f"{name}: {self.known[name]}"
        )

    def text(self, name: str, default: str = "") -> str:
        """As it was given, or `default`."""
        return self.given.get(name, default)

    def number(self, name: str, default: float) -> float:
        """A finite number."""
        if name not in self.given:
            return default
        try:
            value = float(self.given[name])
        except ValueError:
            raise self._fault(name, "a number") from None
        if not abs(value) <= LARGEST:
            raise self._fault(name, "a number")
        return value

    def above_zero(self, name: str, default: float) -> float:
        """A number. Raises UsageError where it is not above zero."""
        value = self.number(name, default)
        if value <= 0:
            raise self._fault(name, "above zero")
        return value

    def whole(self, name: str, default: int) -> int:
        """A whole number, one or more."""
        value = self.number(name, default)
        if value < 1 or value != int(value):
            raise self._fault(name, "a whole number of one or more")
        return int(value)

    def direction(self, name: str, letters: Collection[str] = "XYZ") -> np.ndarray | None:
        """(3,) of length 1; None where it is not given. letters: axes that it may name."""
        given = self.place(name)
        if not given:
            return None
        vector = np.array([given.get(x, 0.0) for x in "XYZ"])
        if not vector.any():
            raise self._fault(name, "a direction")
        if strange := [x for x in given if given[x] and x not in letters]:
            raise self._fault(name, f"for this machine, which has no axis {strange[0]}")
        vector /= np.abs(vector).max()
        return vector / np.linalg.norm(vector)

    def place(self, name: str) -> dict[str, float]:
        """Axis to number, of "X1,Z-2.5"; empty where it is not given. A letter alone counts 1."""
        result: dict[str, float] = {}
        for part in filter(None, self.given.get(name, "").replace(" ", "").split(",")):
            # "X1,Z-2.5", "X=1" or "Z": a letter alone is a direction
            found = re.fullmatch(r"([XYZ])=?([-+]?(?:\d+\.?\d*|\.\d+)?)", part)
            if not found or (found[2] in ("+", "-") and len(part) > 2):
                raise self._fault(name, "like X1,Z-2.5")
            value = found[2]
            result[found[1]] = 1.0 if value in ("", "+") else -1.0 if value == "-" else float(value)
            if not abs(result[found[1]]) <= LARGEST:
                raise self._fault(name, "like X1,Z-2.5")
        return result


def names() -> list[str]:
    """The instruments that there are."""
    return sorted(m.name for m in pkgutil.iter_modules(__path__) if not m.name.startswith("_"))


def load(name: str) -> ModuleType:
    """An instrument. Raises UsageError with those that there are."""
    if name not in names():
        raise UsageError(f"there is no instrument {name!r}", f"instruments: {', '.join(names())}")
    return importlib.import_module(f"{__name__}.{name}")


def refuse_more(samples: float, advice: str = "a lower rate: --set rate=100") -> None:
    """Raises UsageError where so many can not be held, before they are made."""
    if samples > MOST:
        raise UsageError(f"{samples:,.0f} samples are more than {MOST:,}", advice)


def recorded(
    signal: Signal, noise: Noise, head: Mapping[str, Any], without: tuple[str, ...] = ()
) -> Recording:
    """The recording that the instrument would have written. head: further keys; without: channels
    that nobody recorded.

    One seed gives one recording, whatever else is asked for: noise first, then the zero, then the
    sensors.
    """
    # noise, zero, sensors, always in this order: a further setting may not change the numbers that
    # are drawn before it
    rng = np.random.default_rng(noise.seed)
    n = len(next(iter(signal.columns.values()), np.zeros(0)))
    if not n:
        raise GcompError("there is nothing in this program that the instrument would have recorded")
    refuse_more(n)
    columns = dict(signal.columns)
    for name, unit in signal.noisy.items():
        columns[name] = columns[name] + noise.draw(rng, n) / unit
    zeros = {} if signal.kind == "features" else _zeros(signal, noise, rng)
    for name, zero in zeros.items():
        columns[name] = columns[name] + zero
    if noise.resolution:
        for name, unit in signal.noisy.items():
            columns[name] = (
                np.round(columns[name] * unit / noise.resolution) * noise.resolution / unit
            )
    # thermometers are not rounded: they have a noise of their own
    columns |= _sensed(signal, noise, rng, without)
    return Recording(signal.kind, _stated(signal, noise, head, zeros), columns)


def _sensed(
    signal: Signal, noise: Noise, rng: np.random.Generator, without: tuple[str, ...]
) -> dict[str, np.ndarray]:
    """The channels that were recorded; thermometers have their own noise."""
    found = {}
    for channel in signal.channels:
        if channel not in without and channel in signal.state.channels:
            found[channel] = signal.state.channels[channel]
            if channel.startswith("T_"):
                drawn = rng.standard_normal(len(found[channel]))
                found[channel] = found[channel] + noise.sensors * drawn
    return found


def commands(state: State) -> dict[str, np.ndarray]:
    """Columns of the commanded positions of all slides, mm."""
    return {f"{x}_cmd_mm": p for x, p in state.position.items() if x in "XYZ"}


def _stated(
    signal: Signal, noise: Noise, head: Mapping[str, Any], zeros: dict[str, float]
) -> dict[str, Any]:
    """What the recording's head says: of the signal, of the run, and of what was added."""
    um = "urad" if signal.head.get("quantity") == "angle" else "um"
    stated: dict[str, Any] = {
        **signal.head,
        **head,
        "simulated": True,
        f"noise_{um}": noise.size,
        "seed": noise.seed,
    }
    if noise.size > 0:
        # noise and what rounding to the resolution adds, step / sqrt(12)
        stated["u_um"] = float(np.hypot(noise.size, noise.resolution / np.sqrt(12.0)))
    if noise.tails:
        stated["noise_t_degrees"] = noise.tails
    if noise.resolution:
        stated[f"resolution_{um}"] = noise.resolution
    stated[f"zero_{um}"] = {name: value * signal.noisy[name] for name, value in zeros.items()}
    return stated


def _zeros(signal: Signal, noise: Noise, rng: np.random.Generator) -> dict[str, float]:
    """What is added to each column by the instrument's zero: its first reading, at random, or a
    number."""
    zeros = {}
    for name, unit in signal.noisy.items():
        if noise.zero == "first":
            zeros[name] = -float(signal.columns[name][0])
            if signal.kind == "trace":
                # of a log the actual place begins on the commanded one, not on zero
                zeros[name] += float(signal.columns[name.replace("_act_", "_cmd_")][0])
        elif noise.zero == "random":
            zeros[name] = noise.spread * rng.standard_normal() / unit
        else:
            zeros[name] = float(noise.zero) / unit
    return zeros


def channel_names(state: State) -> tuple[str, ...]:
    """Temperatures, the spindle and the forces that are not zero throughout."""
    forces = [
        f"force_{x}_N"
        for x in state.position
        if np.any(state.channels.get(f"force_{x}_N", np.zeros(1)))
    ]
    return (*forces, *(c for c in state.channels if c.startswith("T_")), "spindle_rpm")
