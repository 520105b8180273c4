"""Heat in machine.toml: how an axis and the work grow, and the thermometers beside them."""

from __future__ import annotations

from typing import Any

from postproc import intake
from postproc.machine.axis import Expansion
from postproc.machine.toml_file import Section

KEYS = {"scale_um_m_K", "scale_C", "work_um_m_K", "work_C", "fixed_mm", "sensors", "work_sensors"}
PPM = 1e-6  # um/m is mm/mm by a million


def heat(section: Section) -> Expansion | None:
    """`heat = { scale_um_m_K = 11.5, scale_C = 24.0, work_um_m_K = 11.5, work_C = 21.0, fixed_mm =
    0.0 }`."""
    if "heat" not in section:
        return None
    heat = section["heat"]
    if not isinstance(heat, dict):
        raise section.fault(
            "heat", f"heat = {heat!r}", "like heat = { scale_um_m_K = 11.5, scale_C = 24.0 }"
        )
    known = ", ".join(sorted(KEYS))
    for key in heat:
        if key not in KEYS:
            raise section.fault("heat", f"{key!r} is not a key of heat", f"keys: {known}")
    rate, at, work, work_at, fixed = (
        section.number(key, default, at="heat")
        for key, default in (
            ("scale_um_m_K", 0.0),
            ("scale_C", 20.0),
            ("work_um_m_K", 0.0),
            ("work_C", 20.0),
            ("fixed_mm", 0.0),
        )
    )
    # metals have 1 to 30, plastics up to 100 or so: beyond, it is another unit
    if max(abs(rate), abs(work)) > 100:
        raise section.fault(
            "heat",
            f"an expansion of {max(abs(rate), abs(work)):g} um/(m K)",
            "steel has 11.5: check the unit",
        )
    return Expansion(rate * PPM, at, work * PPM, work_at, fixed, *sensors(section, heat))


def _are_names(value: object) -> bool:
    """Whether it is a list of names."""
    return isinstance(value, list) and all(isinstance(name, str) for name in value)


def sensors(
    section: Section, heat: dict[str, Any]
) -> tuple[tuple[tuple[str, float | None], ...], tuple[str, ...]]:
    """`sensors = { T_front_C = 0.0, T_rear_C = 500.0 }`, thermometers of the scale by the slide
    position at which they sit, or `["T_1_C", "T_2_C"]`, whose mean counts; `work_sensors`, a
    list."""
    scale, work = heat.get("sensors", []), heat.get("work_sensors", [])
    if not _are_names(work):
        raise section.fault(
            "heat", f"work_sensors = {work!r}", 'columns of a log, like work_sensors = ["T_work_C"]'
        )
    if _are_names(scale):
        return tuple((c, None) for c in scale), tuple(work)
    if not isinstance(scale, dict) or not all(map(intake.finite, scale.values())):
        raise section.fault(
            "heat",
            f"sensors = {scale!r}",
            'columns of a log, like ["T_1_C", "T_2_C"], or with the mm at which each sits: { T_1_C'
            " = 0.0, T_2_C = 500.0 }",
        )
    # in the order of their places, as np.interp wants them (growth._grown_by)
    placed = sorted((float(at), c) for c, at in scale.items())
    if len({at for at, _ in placed}) < len(placed):
        raise section.fault(
            "heat", "two sensors sit at one place", "sensors = [...] takes their mean"
        )
    return tuple((c, at) for at, c in placed), tuple(work)
