"""The uncertainty of the parameters, ISO/TR 230-9: every influence listed, combined by JCGM 100
(GUM), U with k = 2.

Nothing is corrected here. A reading normalised to 20 degrees by the instrument would be corrected
twice, and the cosine error of a beam is one-sided; both stay in U.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from postproc.iso import Parameter, Stated, Term
from postproc.iso.chance import student
from postproc.iso.positioning import MEANS, Positioning
from postproc.iso.sampling import largest_uncertainty, noise_of, range_uncertainty
from postproc.units import UM, URAD

REVERSALS = frozenset({"B", "Bm"})
SCATTERS = frozenset({"R", "R+", "R-"})


def rectangular(width: float) -> float:
    """Standard uncertainty of what lies anywhere within a range of this width."""
    return width / (2 * math.sqrt(3))


def terms_of(
    stated: Stated,
    u_reading: float | None,
    length: float | None,
    of: frozenset[str],
    alone: bool,
    angle: bool = False,
) -> tuple[Term, ...]:
    """The stated influences on ranges over `length` mm (None: lengths play no part, as in
    straightness).

    u_reading: mm or rad, what the recording says; alone: one run only, so that the scatter does not
    hold the reading's own; of: the parameters that there are.
    """
    # A range is the difference of two readings, hence the root of 2. B is a difference at one and
    # the same target: what the device reads wrong there drops out of it, and what it adds by chance
    # is in the scatter of the runs, unless there is one run alone. R is that scatter.
    terms: list[Term] = []
    unit, name = (URAD, "urad") if angle else (UM, "um")
    own = stated.device_angle if angle else stated.device
    device = own if own is not None else u_reading
    ranges = of - REVERSALS - SCATTERS
    if device is not None:
        whose = "stated" if own is not None else "the recording's head"
        acts = of - SCATTERS if alone else ranges
        terms.append(
            Term(
                "device",
                math.sqrt(2) * device,
                acts,
                f"{device / unit:.3g} {name} a reading ({whose}), times the root of 2 for a"
                " difference",
            )
        )
    if stated.drift is not None and not angle:
        terms.append(Term(
            "drift", rectangular(stated.drift), of,
            f"EVE range {stated.drift / UM:.3g} um, rectangular",
        ))  # fmt: skip
    if length is not None:
        terms += _of_length(stated, length, ranges)
    return tuple(terms)


def _of_length(stated: Stated, length: float, of: frozenset[str]) -> Iterator[Term]:
    """Cosine error, temperature and expansion over a length in mm."""
    if stated.misalignment is not None:
        # a beam beside the axis by this angle reads L cos(angle)
        short = length * (1 - math.cos(stated.misalignment))
        yield Term(
            "misalignment",
            rectangular(short),
            of,
            f"up to {stated.misalignment * 1e3:.3g} mrad: reads up to {short / UM:.3g} um"
            " short, one-sided, rectangular",
        )
    if stated.alpha is not None and stated.u_temperature is not None:
        u = stated.alpha * length * stated.u_temperature
        yield Term(
            "temperature",
            u,
            of,
            f"{stated.alpha * 1e6:.3g} um/m/K, {length:.4g} mm, u(T) ="
            f" {stated.u_temperature:.3g} K",
        )
    if stated.u_alpha is not None and stated.temperature is not None:
        away = abs(stated.temperature - 20.0)
        yield Term(
            "expansion",
            length * away * stated.u_alpha,
            of,
            f"{away:.3g} K from 20 degrees C, u(alpha) = {stated.u_alpha * 1e6:.3g} um/m/K",
        )


def missing(stated: Stated, has_device: bool, length: bool, angle: bool = False) -> str:
    """A sentence that names the influences that are not stated, empty where all are."""
    own = stated.device_angle if angle else stated.device
    needed: dict[str, tuple[float | None, ...]] = {
        "the device": () if has_device else (own,),
        "drift": () if angle else (stated.drift,),
    }
    if length:
        needed["misalignment"] = (stated.misalignment,)
        needed["temperature"] = (stated.alpha, stated.u_temperature)
        needed["expansion"] = (stated.u_alpha, stated.temperature)
    absent = [name for name, values in needed.items() if None in values]
    return f"not in U, since not stated: {', '.join(absent)}" if absent else ""


def combined(parameter: Parameter, terms: tuple[Term, ...], runs: float | None) -> Parameter:
    """The parameter with its U: 2 times the root of the sum of squares; `runs` is already expanded.
    None where nothing is known, or the parameter is not defined."""
    if parameter.value is None:
        return parameter
    # `runs` holds Student's t or a drawn quantile already: it is no standard uncertainty that could
    # be doubled, so expanded parts are summed (at many runs both are the same).
    parts = [2 * t.u for t in terms if parameter.name in t.of] + ([] if runs is None else [runs])
    return replace(parameter, U=math.sqrt(sum(p * p for p in parts)) if parts else None, runs=runs)


def of_positioning(test: Positioning) -> dict[str, float]:
    """The expanded part of U that comes from the scatter of the runs, by parameter; empty for
    single runs.

    E, M and B by sampling; Bm by its standard error. A and R also by the uncertainty of the s at
    the targets that make them, u(s) = s / sqrt(2 (n - 1)) (JCGM 100, E.4.3): no account is taken of
    how many s they are the largest of.
    """
    noise = noise_of(test.s, test.n)
    if noise is None:
        return {}
    out = {}
    for row, sign in enumerate("+-"):
        if np.isfinite(test.mean[row]).any():
            own = slice(row, row + 1)
            out[f"E{sign}"] = range_uncertainty(test.mean[own], noise.part(own))
    if test.two_way:
        out["E"] = range_uncertainty(test.mean, noise)
        if test.both.any():
            # B is a difference of two means, M their mean: u of both by one root, times 1 or a half
            mixed = noise.of_two(1.0)
            out["B"] = largest_uncertainty(test.reversal, mixed)
            u = float(np.sqrt(np.nansum(mixed.u[0] ** 2))) / int(test.both.sum())
            out["Bm"] = (
                student(float(mixed.dof.flat[0] if mixed.pooled else np.nansum(mixed.dof))) * u
            )
            out["M"] = range_uncertainty(test.middle[None], noise.of_two(0.5))
    for name, value in test.values.items():
        if value is not None and name[0] in "RA":
            out[name] = _of_s(test, name)
    return out


def _of_s(test: Positioning, name: str) -> float:
    """U of R or A at the targets where it is found. Per cell: variance s^2/n of a mean,
    s^2/(2(n-1)) of an s."""
    rows = {"+": [0], "-": [1]}.get(name[1:], [0, 1])
    mean, s, n = test.mean[rows], test.s[rows], test.n[rows]
    # A = (mean + 2 s) at one target less (mean - 2 s) at another: each end has the variance of a
    # mean and 4 times that of an s. R_i of one direction is 4 s, two-way 2 s+ + 2 s- + |B|.
    of_s = s**2 / (2 * np.maximum(n - 1, 1))
    of_mean = s**2 / np.maximum(n, 1)
    if name[0] == "A":
        high, low = np.nanargmax(mean + 2 * s), np.nanargmin(mean - 2 * s)
        return 2 * math.sqrt(sum(of_mean.flat[i] + 4 * of_s.flat[i] for i in (high, low)))
    if len(rows) == 1:
        return 2 * 4 * math.sqrt(of_s.flat[np.nanargmax(s)])
    which, i = np.unravel_index(np.nanargmax(test.repeatability), test.repeatability.shape)
    if which < 2:
        return 2 * 4 * math.sqrt(of_s[which, i])
    # R is either 4 s of one cloud or the span of both; each has the variance of what it is made of:
    #     4 s                      16 var(s)
    #     2 s+ + 2 s- + |B|        4 var(s+) + 4 var(s-) + var(mean+) + var(mean-)
    if 4 * s[:, i].max() >= test.repeatability[2, i]:
        return 2 * 4 * math.sqrt(of_s[np.argmax(s[:, i]), i])
    return 2 * math.sqrt(float((of_mean[:, i] + 4 * of_s[:, i]).sum()))


def positioning_parameters(test: Positioning, terms: tuple[Term, ...]) -> tuple[Parameter, ...]:
    """All parameters of ISO 230-2 with U and where they were found."""
    runs = of_positioning(test)
    return tuple(
        combined(Parameter(name, value, MEANS[name], _where(test, name)), terms, runs.get(name))
        for name, value in test.values.items()
    )


def _where(test: Positioning, name: str) -> str:
    """The target of the largest reversal or repeatability."""
    if test.values[name] is None or name[0] not in "BR" or name == "Bm":
        return ""
    if name == "B":
        at = int(np.nanargmax(np.abs(test.reversal)))
    elif name == "R":
        at = int(np.unravel_index(np.nanargmax(test.repeatability), test.repeatability.shape)[1])
    else:
        at = int(np.nanargmax(test.repeatability["+-".index(name[1])]))
    return f"at {test.target[at]:g}"
