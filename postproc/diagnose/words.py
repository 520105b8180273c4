"""Sizes, names and places of a diagnosis as a person reads them: what says nothing is left out,
digits as far as they are known.

The document for other programs (report.as_json) holds every number.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from types import ModuleType

UNITLESS = ("1", "number", "")
LONG = 10.0  # times what was recorded: such a time can not be told from any longer one
FINEST = 8  # decimals
# an effect that has one is decided by where the slides stand
PLACES = ("tables", "grids", "by_angle")
USES = {
    "simulate": "no program corrects it, it is only simulated",
    "recording": "correct the recording, never the machine",
}


def use(module: ModuleType) -> str:
    """What may be done with an effect."""
    if module.USE in USES:
        return USES[module.USE]
    if any(hasattr(module, name) for name in PLACES):
        return "programs can be corrected for it"
    return (
        "it goes with time, heat or the tool, which a program does not know: offsets or a warm-up"
        " correct it"
    )


def named(key: str) -> str:
    """ "backlash:Z" as "backlash of Z", "laser_air:" as "laser_air"."""
    name, _, axis = key.partition(":")
    return f"{name} of {axis}" if axis else name


def number(value: float, low: float, high: float) -> tuple[str, str, str]:
    """Value and interval with two digits of half the interval; with four digits where there is
    none."""
    # Two digits of the half width: 12.34 +- 0.56, and no digit beyond what is known.
    half = (high - low) / 2
    if not math.isfinite(half) or half <= 1e-9 * max(abs(value), 1e-12):
        return f"{value:.4g}", "", ""
    decimals = min(max(1 - math.floor(math.log10(half)), 0), FINEST)
    three = [f"{v:.{decimals}f}" for v in (value, low, high)]
    # no "-0.0"
    first, second, third = (text.lstrip("-") if float(text) == 0 else text for text in three)
    return first, second, third


# Whole: a list of exceptions in their order of precedence.
def parameters(
    module: ModuleType,
    value: dict[str, float],
    ci95: dict[str, tuple[float, float]],
    files: Iterable[str] = (),
    span_s: float = 0.0,
) -> list[tuple[str, str, str]]:
    """(size, interval, meaning) of every parameter that says something. files: names of the
    recordings; span_s: how long was recorded. Left out: what is as it is where nobody states it,
    and coefficients that were not fitted."""
    usual = getattr(module, "OPTIONAL", {})
    names = list(files)
    result = []
    for name, v in value.items():
        # no interval: the best of a grid, or what a choice stands for; it was not fitted
        low, high = ci95[name]
        fixed = high - low < 1e-12
        if name == "degree" or (v == usual.get(name) and (fixed or v == 0.0)):
            continue
        unit, meaning = _meaning(module.PARAMETERS[name])
        driven = re.search(
            r"where (?:none|no temperature) is recorded (\S+) (.*)$", module.PARAMETERS[name]
        )
        if driven and value.get("tau_s", 0.0) > 0:  # it came with time
            unit, meaning = driven[1], f"{driven[2]} of the recording"
        if value.get("cycle_s", 0.0) > 0:  # it comes and goes
            if name == "tau_s":
                continue
            if name == "size_um":
                unit, meaning = "um", "its amplitude, zero to peak"
        if name == "file":
            if 0 <= v < len(names):
                result.append(("", "", f"in {names[int(v)]} alone"))
            continue
        if fixed and (said := _choice(module.PARAMETERS[name], v)):
            result.append(("", "", said))
            continue
        if fixed and name.startswith("tau_s") and 0 < span_s * LONG < v:
            result.append(("", "", "evenly with the time"))
            continue
        size, least, most = number(v, low, high)
        if fixed and name.startswith("tau"):  # the best of a grid
            size = f"about {v:.2g}" if v < 100 else f"about {v:.0f}"
        label = _label(name, unit)
        shown = f"{label} {size} {'' if unit in UNITLESS else unit}".strip()
        result.append((shown, f"95 %: {least} to {most}" if least else "", meaning))
    return result


def _meaning(text: str) -> tuple[str, str]:
    """Unit and what it means, of a line of PARAMETERS; without what other values would mean."""
    # PARAMETERS hold "um, what it means; what other values mean"
    unit, _, rest = text.partition(", ")
    if re.match(r"number of|\d+ or", unit):
        unit, rest = "", text
    if other := re.search(r"else (.*)$", rest):
        return unit, other[1]
    return unit, re.split(r"; |, -?\d+: ", rest)[0]


def _choice(text: str, value: float) -> str:
    """What a number that stands for something means: of "0, 1, 2: X, Y, Z, the direction", of "1,
    this; 0, that", of "s, 0: by the recorded temperature; below zero: by that of the air, so many
    seconds late; else ..."; "" where it is a size."""
    if listed := re.match(r"([-\d]+(?:, [-\d]+)+): (.*)$", text):
        codes = [float(c) for c in listed[1].split(", ")]
        first = listed[2].split("; ")[0].split(", ")
        if value in codes:
            return f"{', '.join(first[len(codes) :])}: {first[codes.index(value)]}"
    if value < 0 and (below := re.search(r"below zero: ([^;]*)", text)):
        return below[1].replace("so many seconds", f"{-value:.4g} s")
    for clause in re.finditer(r"(?:^|; |, )(-?\d+)[:,] ([^;]*)", text):
        alone = clause.start() == 0 and not re.search(r"; -?\d+, ", text)
        if float(clause[1]) == value and not alone:
            return re.split(r", else ", clause[2])[0]
    return ""


def _label(name: str, unit: str) -> str:
    """The parameter's name without its unit; "" where it is nothing but a unit."""
    if re.match(r"(um|ppm|urad)(_|$)", name):
        return ""
    return re.sub(
        r"_(um|mm|ms|s|hz|deg|urad|ppm|N|K|um_K|mm_s|ppm_K|um_per_.*)$", "", name
    ).replace("_", " ")


def limits(sizes_mm: dict[str, float], most_mm: float = 1.0) -> str:
    """effect:axis to mm as sizes in um, the smallest first, with the names that share one."""
    groups: dict[str, dict[str, list[str]]] = {}
    # one digit: of a limit of detection no more is meant, and names gather under it
    for key, size in sorted(sizes_mm.items(), key=lambda item: (float(f"{item[1]:.1g}"), item[0])):
        if size < most_mm:
            effect, _, axis = key.partition(":")
            groups.setdefault(f"{size * 1e3:.1g}", {}).setdefault(effect, []).append(axis)
    said = []
    for least, effects in groups.items():
        said.append(
            f"{float(least):g} um: "
            + ", ".join(_of_axes(name, axes) for name, axes in effects.items())
        )
    return "; ".join(said)


def _of_axes(name: str, axes: list[str]) -> str:
    return f"{name} {' '.join(sorted(a for a in axes if a))}".strip()


def by_reason(spots: Iterable[tuple[str, str, str]]) -> list[tuple[str, str]]:
    """(effect, axis, why) as (names, why), names that share a reason together."""
    groups: dict[str, dict[str, list[str]]] = {}
    for name, axis, why in spots:
        groups.setdefault(why, {}).setdefault(name, []).append(axis)
    return [
        (", ".join(_of_axes(name, axes) for name, axes in of.items()), why)
        for why, of in groups.items()
    ]


def blind(spots: Iterable[tuple[str, str, str]]) -> str:
    """The same in one line."""
    return "; ".join(f"{names} ({why})" for names, why in by_reason(spots))


def stretch(axis: str, low: float, high: float) -> str:
    """A place along an axis: "X from 140.0 to 170.0 mm", "X at 400.0 mm"."""
    if f"{low:.1f}" == f"{high:.1f}":
        return f"{axis} at {low:.1f} mm"
    return f"{axis} from {low:.1f} to {high:.1f} mm"


def chance(p: float) -> str:
    """A probability that was counted on draws."""
    return f"{p:.2g} or less"
