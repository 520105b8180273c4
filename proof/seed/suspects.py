"""What each suspect could make on the thesis' diagonal, from the tables, and what the parts say
without any tool of ours."""

from __future__ import annotations

import numpy as np

from postproc.diagnose.answer import Diagnosis
from proof.seed.experiment import PARTS, X, Z, table

LEFT = 29.5  # um, thesis 6.5: left on the diagonal after its compensation
# X (radius), Z: the diagonal of Table 6.3
ALONG = np.array([340.0 / 2, 510.0]) / np.hypot(340.0 / 2, 510.0)
PITCH = "table_7_2_mv1060_fanuc_pitch.csv"
STEEL = 11.5  # um/m/K, of a steel screw; unverified: general knowledge, nothing in the thesis


def column(name: str, key: str) -> np.ndarray:
    """One column of a table, um."""
    return np.array([float(row[key]) for row in table(name)]) * 1e3


def lines(d: Diagnosis) -> list[str]:
    """The suspects, the largest first, with what they could make along the diagonal."""
    jump = next((f for f in d.findings if f.block.name == "shared_jump"), None)
    place = np.array([float(row["x_mm"]) for row in table(X)])
    straight = column(X, "dzx_avg_mm")
    line = abs(float(np.polyfit(place, straight, 1)[0])) * float(np.ptp(place)) * ALONG[1]
    gap_x = column(X, "dxx_forward_mm") - column(X, "dxx_reverse_mm")
    gap_z = column(Z, "dzz_forward_mm") - column(Z, "dzz_reverse_mm")
    growth = STEEL * 1e-3 * np.hypot(170.0, 510.0)
    result = []
    if jump is not None:
        size = abs(jump.value["largest_um"])
        whole = size * ALONG[1] + size * abs(jump.value["ratio"]) * ALONG[0]
        result.append(
            f"1. The jump of X from {jump.value['from_mm']:g} mm makes up to {whole:.0f} um along"
            " the diagonal. If it is a turn it depends on where the optics stood, and they stood"
            f" elsewhere on the diagonal: {100 * LEFT / whole:.0f} % more or less of it is the"
            f" whole {LEFT} um. The yaw of X was never measured. First suspect."
        )
    result += [
        (
            f"2. The line of the X straightness, {line:.1f} um along the diagonal: it is the"
            " alignment of the optics, and the thesis added the squareness to it. If it should not"
            " have been in, that much was compensated wrongly."
        ),
        (
            f"3. Reversal: X loses {gap_x.max():.1f} um at most and {gap_x.min():.1f} um at least,"
            f" by where it stands, Z {gap_z.max():.1f} to {gap_z.min():.1f} um: along the diagonal"
            f" a range of {np.ptp(gap_x) * ALONG[0]:.1f} and {np.ptp(gap_z) * ALONG[1]:.1f} um. The"
            " thesis compensated each direction by itself, so this is left only as far as it does"
            " not repeat (over-travel, load, time)."
        ),
        (
            f"4. Temperature: {growth:.1f} um along the diagonal for every kelvin between the runs"
            f" (steel, {STEEL} um/m/K). No temperature was recorded."
        ),
        "5. The slip at X = 90, reverse: 3 um in Z at one target of one direction.",
        (
            "The measured diagonals exist only as figures: none of this can be fitted to them, and"
            f" nothing here claims to have explained the {LEFT} um. What would decide: the yaw of X"
            " by angular optics at the 18 targets, one afternoon."
        ),
    ]
    return result


def sizes() -> dict[str, list[float]]:
    """um by part: by how much the tool is larger as pockets, and as the boss, say it."""
    rows = table(PARTS)

    def deviations(kind: str, part: int) -> list[float]:
        own = [r for r in rows if r["kind"] == kind and int(r["part"]) == part]
        return [
            float(
                np.mean([float(r[f"reading_{k}_mm"]) for k in (1, 2, 3)]) - float(r["nominal_mm"])
            )
            * 1e3
            for r in own
        ]

    return {
        "pockets": [float(np.mean(deviations("pocket_size", p))) for p in (1, 2)],
        "boss": [-float(np.mean(deviations("boss_diameter", p))) for p in (1, 2)],
        "holes": [float(np.mean(deviations("centre_distance", p))) for p in (1, 2)],
    }


def pitch(axis: str, length: float) -> float:
    """um: the most that the new pitch table (7.2: increments of 1 um every 20 mm) changes over a
    length of an axis."""
    step = [int(r["value"]) for r in table(PITCH) if r["axis"] == axis]
    n = round(length / 20.0)
    return float(max(abs(sum(step[k : k + n])) for k in range(len(step) - n + 1)))


def of_parts() -> list[str]:
    """The same by hand: each kind of feature for itself."""
    s = sizes()
    return [
        (
            f"Pockets alone say {s['pockets'][0]:.0f} and {s['pockets'][1]:.0f} um (part 1, part"
            f" 2), the boss alone {s['boss'][0]:.0f} and {s['boss'][1]:.0f} um: two witnesses that"
            " would disagree in sign if the axes, and not the tool, were wrong. The hole distances"
            f" are off by {s['holes'][0]:.0f} and {s['holes'][1]:.0f} um in the mean: a tool's size"
            " can not move them."
        ),
        (
            f"Part 2 is {s['pockets'][0] - s['pockets'][1]:.0f} um (pockets) and"
            f" {s['boss'][0] - s['boss'][1]:.0f} um (boss) nearer: a worn tool, another one, or the"
            f" new pitch table, which changes at most {pitch('X', 140.0):.0f} um on any 140 mm of X"
            f" and {pitch('Y', 120.0):.0f} um on any 120 mm of Y. Two parts and no tool measured"
            " can not decide between wear and change."
        ),
    ]
