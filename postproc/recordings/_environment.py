"""The air and the material as laser software notes them: temperatures become columns, the rest goes
into the head."""

from __future__ import annotations

import re
from collections.abc import Iterable

# degrees Celsius in which a machine is measured; 68 is a room in degrees Fahrenheit
ROOM = (0.0, 45.0)
TEMPERATURE = re.compile(
    r"^(air|mat|material)\s*temp(?:erature)?\.?\s*([0-9]*)$|^(?:temp(?:erature)?)\s*(air|material)?\s*([0-9]*)$",
    re.I,
)
VALUE = re.compile(r"([-+]?[0-9]+(?:[.,][0-9]+)?)\s*(?:°|deg)?\s*([CF]?)")
EXPANSION = re.compile(r"exp(?:ansion)?\s*coeff(?:icient)?", re.I)


def taken(pairs: Iterable[tuple[str, str]]) -> tuple[dict[str, float], dict[str, str], list[str]]:
    """Columns (T_air_C, T_material_1_C) with their one value, degrees Celsius; what was written,
    for the head; notices.

    A temperature without a unit is taken as Celsius where a room can have it, and is left out
    otherwise.
    """
    columns: dict[str, float] = {}
    head: dict[str, str] = {}
    notices: list[str] = []
    for key, text in pairs:
        name, text = " ".join(key.split()), text.strip()
        if not text:
            continue
        head[name] = text
        if EXPANSION.search(name) and re.search(r"[1-9]", text):
            notices.append(
                f"{name} is {text}: the readings may be brought to 20 C already, do not take it out"
                " twice"
            )
        place = TEMPERATURE.match(name)
        value = VALUE.fullmatch(text)
        if not place or not value:
            continue
        celsius = float(value[1].replace(",", "."))
        if value[2] == "F":
            celsius = (celsius - 32.0) / 1.8
        elif not value[2]:
            if not ROOM[0] <= celsius <= ROOM[1]:
                notices.append(
                    f"{name} = {text} has no unit and is no room in degrees Celsius: left out"
                )
                continue
            notices.append(f"{name} = {text} has no unit: taken as degrees Celsius")
        columns[_column(place)] = celsius
    return columns, head, notices


def _column(place: re.Match[str]) -> str:
    """T_air_C, T_material_1_C: of a match of TEMPERATURE."""
    where = (
        (place[1] or place[3] or "air")
        .lower()
        .replace("mat", "material")
        .replace("materialerial", "material")
    )
    number = place[2] or place[4]
    return f"T_{where}{'_' + number if number else ''}_C"
