"""The thesis' tables (6.1, 6.2, 7.3) as recordings by the contract, and the machines that they are
held against.

The tables print the mean of three runs each way, no times, no temperatures: so do the recordings.
Positions of X are radii. The yaw of Z is printed under "all values in mm"; mm/m is taken, 1 of it
1000 urad (machines/studer-s36/README.md). The recordings leave the averages out: they say nothing
that the two directions do not.
"""

from __future__ import annotations

import csv
from pathlib import Path

TABLES = Path(__file__).parent / "tables"
MACHINES = {
    "grinder": Path(__file__).parent / "bare-studer",
    "mill": Path(__file__).parent / "bare-mv1060",
}
Z, X = "table_6_1_studer_s36_z_axis.csv", "table_6_2_studer_s36_x_axis.csv"
PARTS = "table_7_3_parts_cmm.csv"
SOURCE = "M. Asad Ullah, MS thesis, NUST Islamabad 2013"
# file: table, column, moving axis, direction of the reading, quantity, unit of the table in that of
# the reading
READINGS = {
    "z_positioning": (Z, "dzz_{}_mm", "Z", "Z", "displacement", 1e3),
    "z_straightness": (Z, "dxz_{}_mm", "Z", "X", "straightness", 1e3),
    "z_yaw": (Z, "eyz_{}", "Z", "B", "angle", 1e3),
    "x_positioning": (X, "dxx_{}_mm", "X", "X", "displacement", 1e3),
    "x_straightness": (X, "dzx_{}_mm", "X", "Z", "straightness", 1e3),
}


def table(name: str) -> list[dict[str, str]]:
    """Rows of one printed table."""
    with open(TABLES / name, newline="", encoding="utf-8") as lines:
        return list(csv.DictReader(lines))


def targets(name: str) -> str:
    """One measurement of one axis, there and back, as a recording."""
    file, column, axis, along, quantity, unit = READINGS[name]
    head = [
        '# format = "gcomp-recording/1"',
        '# kind = "targets"',
        '# machine = "studer-s36"',
        '# instrument = "laser interferometer"',
        f'# quantity = "{quantity}"',
        f"# sensitive = {{ {along} = 1.0 }}",
        (
            f'# source = "{SOURCE}, {file.split("_studer")[0].replace("_", " ")}; mean of three'
            ' runs each way, times not printed"'
        ),
    ]
    reading = "reading_urad" if quantity == "angle" else "reading_um"
    rows = table(file)
    other = "X" if axis == "Z" else "Z"
    lines = [*head, f"run,{axis}_mm,{other}_mm,approach_{axis},approach_{other},{reading}"]
    for word, sign, order in (("forward", 1, rows), ("reverse", -1, rows[::-1])):
        for row in order:
            value = float(row[column.format(word)]) * unit
            lines.append(f"1,{float(row[axis.lower() + '_mm']):g},0,{sign},0,{value:.4g}")
    return "\n".join(lines) + "\n"


def features() -> str:
    """Table 7.3: two parts, three readings of each feature."""
    head = [
        '# format = "gcomp-recording/1"',
        '# kind = "features"',
        '# machine = "mv-1060"',
        '# instrument = "coordinate measuring machine, (3 + 4 L / 1000) um"',
        "# u_um = 1.9",
        (
            f'# source = "{SOURCE}, Table 7.3; u: (3 + 4 x 0.08) um as the limits of a uniform'
            ' distribution"'
        ),
    ]
    lines = [*head, "feature,kind,axis,nominal_mm,measured_mm,part,reading"]
    for row in table(PARTS):
        for k in (1, 2, 3):
            lines.append(
                f"{row['feature']},{row['kind']},{row['axis']},{row['nominal_mm']},{row[f'reading_{k}_mm']},{row['part']},{k}"
            )
    return "\n".join(lines) + "\n"


def write(folder: Path) -> dict[str, Path]:
    """All recordings into a folder: name to path."""
    folder.mkdir(parents=True, exist_ok=True)
    texts = {name: targets(name) for name in READINGS} | {"parts": features()}
    paths = {name: folder / f"{name}.csv" for name in texts}
    for name, text in texts.items():
        paths[name].write_text(text, encoding="utf-8")
    return paths
