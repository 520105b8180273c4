"""Other people's files as recordings by the contract, and the machines that they are held against.

Every function takes text or a path and gives text. A machine is written from what its authors
state: axes and travel, and the tables only where they are not what is to be found.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterable, Sequence
from pathlib import Path

COUNT_MM = 2 * math.pi * 100 / 4096  # one count of a 12 bit encoder at the tip of a lever of 100 mm
PULL_N = 1.47  # 0.15 kgf at the tip: the paper's example; its table prints 1.5 kgf, meant as kgf cm


def head(kind: str, machine: str, instrument: str, source: str, **more: str) -> list[str]:
    lines = {
        "format": "gcomp-recording/1",
        "kind": kind,
        "machine": machine,
        "instrument": instrument,
        "source": source,
    }
    return [f'# {k} = "{v}"' for k, v in lines.items()] + [f"# {k} = {v}" for k, v in more.items()]


def targets(
    axis: str,
    rows: Iterable[Sequence[float | str]],
    columns: Sequence[str],
    machine: str,
    instrument: str,
    source: str,
    **more: str,
) -> str:
    """Readings at rest of one axis along itself."""
    lines = head(
        "targets",
        machine,
        instrument,
        source,
        quantity='"displacement"',
        sensitive=f"{{ {axis} = 1.0 }}",
        **more,
    )
    lines.append(",".join(columns))
    lines += [",".join(x if isinstance(x, str) else f"{x:.7g}" for x in row) for row in rows]
    return "\n".join(lines) + "\n"


def bare(
    name: str,
    title: str,
    source: str,
    travel: dict[str, tuple[float, float]],
    chain: str,
    control: str,
) -> dict[str, str]:
    """A machine as its drawing has it: no error in any table. File name to text."""
    text = [
        'format  = "gcomp-machine/1"',
        f'name    = "{name}"',
        f'title   = "{title}"',
        f'control = "{control}"',
        f'chain   = "{chain}"',
        f'source  = "{source}"',
        "",
    ]
    files = {}
    for axis, (low, high) in travel.items():
        text += [
            f"[axes.{axis}]",
            f"travel = [{low}, {high}]",
            "least_increment = 0.0001",
            f'table = "{axis}.csv"',
            "",
        ]
        files[f"{axis}.csv"] = f"{axis}_mm,E{axis}{axis}_um\n{low},0\n{high},0\n"
    zeros = ", ".join(f"{axis} = 0.0" for axis in travel)
    return {"machine.toml": "\n".join([*text, "[offsets]", f"G54 = {{ {zeros} }}", ""]), **files}


def merged(table: str) -> str:
    """An axis table in which both directions are their mean: the lost motion is taken out, all else
    stays."""
    comments = [line for line in table.splitlines() if line.startswith("#")]
    rows = list(csv.DictReader(line for line in table.splitlines() if not line.startswith("#")))
    names = []
    for column in rows[0]:
        name = re.sub(r"_(fwd|rev)$", "", column)
        if name not in names:
            names.append(name)
    lines = [
        *comments,
        "# both directions are their mean: lost motion is taken out",
        ",".join(names),
    ]
    for row in rows:
        cells = [
            (
                row[n]
                if n in row
                else f"{(float(row[f'{n}_fwd']) + float(row[f'{n}_rev'])) / 2:.4f}".rstrip(
                    "0"
                ).rstrip(".")
            )
            for n in names
        ]
        lines.append(",".join(cells))
    return "\n".join(lines) + "\n"


def concealed(folder: Path, axis: str) -> dict[str, str]:
    """A machine folder without the lost motion of one axis."""
    files = {
        p.name: p.read_text(encoding="utf-8")
        for p in folder.iterdir()
        if p.suffix in (".toml", ".csv")
    }
    files[f"{axis}.csv"] = merged(files[f"{axis}.csv"])
    return files


def iso_tables(text: str) -> list[tuple[int, float, int, float]]:
    """Run, target mm, approach, reading um of a report of the ecmc test scripts: all cycles
    forward, then all backward."""
    rows, way = [], 0
    for line in text.splitlines():
        if line.startswith("### Data "):
            way = 1 if "forward" in line else -1
        cells = line.strip().split("|")
        if way and cells[0].strip().isdigit():
            target, *read = [float(c) for c in cells[1:] if c.strip()]
            rows += [
                (way, run, target, (value - target) * 1e3) for run, value in enumerate(read, 1)
            ]
    order = sorted(rows, key=lambda r: (-r[0], r[1], r[0] * r[2]))
    return [(run, target, w, reading) for w, run, target, reading in order]


def iso_report(text: str, machine: str, instrument: str, source: str, u_um: float) -> str:
    rows = [
        (str(run), target, str(way), round(reading, 6))
        for run, target, way, reading in iso_tables(text)
    ]
    columns = ("run", "X_mm", "approach_X", "reading_um")
    return targets("X", rows, columns, machine, instrument, source, u_um=str(u_um))


def dial_gauge(text: str, source: str) -> str:
    """A gauge that is pressed as Z falls: actual Z = first Z - gauge. Down, up, down again."""
    table = list(csv.DictReader(line for line in text.splitlines() if not line.startswith("#")))
    first = float(table[0]["z_mm"])
    rows = []
    for run, way in ((1, -1), (2, 1), (3, -1)):
        for row in table if way < 0 else table[::-1]:
            if row[f"run_{run}_mm"]:
                z = float(row["z_mm"])
                rows.append(
                    (
                        str(run),
                        z,
                        str(way),
                        round((first - float(row[f"run_{run}_mm"]) - z) * 1e3, 3),
                    )
                )
    columns = ("run", "Z_mm", "approach_Z", "reading_um")
    return targets(
        "Z", rows, columns, "measurement chamber", "dial gauge, 0.01 mm", source, u_um="2.9"
    )


def servo_rests(text: str, source: str, loaded: bool) -> str:
    """Rests of a servo: a run is a way out, the way back to the middle and the three pulls there;
    with or without the pulls."""
    rows, run = [], 0
    for row in csv.DictReader(line for line in text.splitlines() if not line.startswith("#")):
        target = float(row["target"])
        run += target != 2047
        if row["band"] != "0" and not loaded:
            continue
        reading = (float(row["pos"]) - target) * COUNT_MM * 1e3
        cells = (str(run), float(row["t_s"]), target * COUNT_MM, row["moved"], round(reading, 2))
        rows.append((*cells, float(row["band"]) * PULL_N) if loaded else cells)
    columns = ["run", "t_s", "X_mm", "approach_X", "reading_um"] + (["force_X_N"] if loaded else [])
    instrument = "the servo's own encoder, 4096 counts, as arc at 100 mm"
    return targets(
        "X", rows, columns, "sts3215", instrument, source, u_um=f"{COUNT_MM * 1e3 / 12**0.5:.1f}"
    )


def recording_columns(path: Path) -> dict[str, list[float]]:
    """Numbers of a contract recording, read without the tool."""
    lines = [
        line for line in path.read_text(encoding="utf-8").splitlines() if not line.startswith("# ")
    ]
    rows = list(csv.DictReader(lines))
    return {name: [float(r[name]) for r in rows] for name in rows[0]}
