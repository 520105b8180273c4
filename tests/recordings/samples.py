"""Files as the descriptions of their formats have them, made here: no original file is in the
project.

Every maker takes readings as a table (runs, targets) and writes them; what a test expects is that
table.
"""

from __future__ import annotations

import numpy as np

from postproc.recordings import ReadingOptions, Recording, Source, read

# 10: five divide it
TARGETS = np.array([0.0, 50.0, 100.0, 150.0, 200.0, 250.0, 300.0, 350.0, 400.0, 450.0])


def readings(
    runs: int = 4, targets: np.ndarray = TARGETS, reversal: float = 4.0, seed: int = 1
) -> np.ndarray:
    """(runs, targets) um to 0.01: a screw that is long by 10 um/m, odd runs towards +, even runs
    back, less the reversal."""
    rng = np.random.default_rng(seed)
    shape = targets * 0.01 + 0.7
    back = (np.arange(runs) % 2)[:, None] * reversal
    return np.round(shape - back + rng.normal(0, 0.15, (runs, len(targets))), 2)


def renishaw(
    table: np.ndarray,
    targets: np.ndarray = TARGETS,
    axis: str = "Z",
    machine: str = "mill-7",
    comma: bool = False,
    skip: tuple[tuple[int, int], ...] = (),
    shuffle: int | None = None,
    end: str = "\r\n",
    flags: str = "0 0 2 0",
    environment: tuple[str, ...] = (),
) -> str:
    """A .rtl text: five targets a line, reverse runs listed from the far end."""
    lines = [
        "HEADER::",
        "File type  : laser",
        "Owner      : Renishaw",
        "Version no : 20",
        "",
        "TARGET DATA::",
    ]
    lines += ["Filetype  : ISO", f"Target-count: {len(targets)}", "Targets :"]
    lines += ["  ".join(f"{t:.4f}" for t in targets[i : i + 5]) for i in range(0, len(targets), 5)]
    lines += [
        f"Flags: {flags}",
        "",
        "USER-TEXT::",
        f"Machine: {machine}",
        "Serial No: 4711",
        "Date: 2024-05-17",
    ]
    lines += [
        "By: somebody",
        f"Axis: {axis}",
        "Location: hall 3",
        "",
        "RUNS::",
        f"Run-count: {len(table)}",
        "",
    ]
    lines += ["DEVIATIONS::", "Run Target Data:"]
    rows = []
    for run, row in enumerate(table, 1):
        order = range(1, len(targets) + 1) if run % 2 else range(len(targets), 0, -1)
        rows += [f"{run}   {k}      {row[k - 1]:.2f}" for k in order if (run, k) not in skip]
    if shuffle is not None:
        np.random.default_rng(shuffle).shuffle(rows)
    lines += [*rows, ""]
    if environment:
        lines += ["ENVIRONMENT::", *environment, ""]
    text = "\n".join([*lines, "EQUIPMENT::", "Laser : XL", "", "EOF::", ""])
    return (text.replace(".", ",") if comma else text).replace("\n", end)


def dynamic(
    samples: np.ndarray, rate: float = 1000.0, axis: str = "X", end: bytes = b"EOF::\r\n"
) -> bytes:
    """A .rtx file."""
    head = [
        "HEADER::",
        "File Type: rtx",
        "Owner: somebody",
        "Version no: 4",
        "Velocity: 0.0",
        f"Sample rate: {rate}",
    ]
    head += [
        f"Sample no: {len(samples)}",
        "Trigger point: 0",
        f"Trigger interval: {1 / rate}",
        f"Actual sample rate: {rate}",
    ]
    head += [
        "Flags: 0 1 2 0 2",
        "Machine: mill-7",
        "Serial No: ",
        "Date: 10/02/2025 12:58:22",
        "By: User",
        f"Axis: {axis}",
        "Location: ",
    ]
    return "\r\n".join([*head, "Data:", ""]).encode() + samples.astype("<f8").tobytes() + end


def interleaved(
    table: np.ndarray,
    targets: np.ndarray = TARGETS,
    sign: str = ";",
    comma: bool = True,
    unit: str = "µm",
) -> str:
    """Targets down, up 1, down 1, up 2 ... across, a mean behind, and a summary below."""
    names = [f"{'Up' if r % 2 == 0 else 'Down'} {r // 2 + 1} ({unit})" for r in range(len(table))]
    lines = [
        f"Machine{sign}mill-7",
        f"Axis{sign}Z",
        "",
        sign.join(["Target (mm)", *names, f"Mean ({unit})"]),
    ]
    for k, target in enumerate(targets):
        cells = [f"{target:.1f}", *(f"{v:.2f}" for v in table[:, k]), f"{table[:, k].mean():.3f}"]
        lines.append(sign.join(c.replace(".", ",") if comma else c for c in cells))
    return "\n".join([*lines, "", f"Reversal B{sign}4", ""])


def blocks(table: np.ndarray, targets: np.ndarray = TARGETS, headed: bool = True) -> str:
    """All runs up, then all runs down."""
    order = [*range(0, len(table), 2), *range(1, len(table), 2)]
    words = [f"Forward {r // 2 + 1}" if r % 2 == 0 else f"Reverse {r // 2 + 1}" for r in order]
    names = words if headed else [f"Run {i}" for i in range(1, len(order) + 1)]
    lines = ["\t".join(["Target [mm]", *names])]
    lines += [
        "\t".join([f"{t:g}", *(f"{table[r, k]:.2f}" for r in order)]) for k, t in enumerate(targets)
    ]
    return "\n".join(lines) + "\n"


def long(table: np.ndarray, targets: np.ndarray = TARGETS) -> str:
    """One reading a row."""
    lines = ["Target position (mm),Run,Direction,Deviation (um)"]
    for r, row in enumerate(table):
        order = range(len(targets)) if r % 2 == 0 else range(len(targets) - 1, -1, -1)
        lines += [
            f"{targets[k]:g},{r + 1},{'up' if r % 2 == 0 else 'down'},{row[k]:.2f}" for k in order
        ]
    return "\n".join(lines) + "\n"


def laser_table(
    table: np.ndarray,
    targets: np.ndarray = TARGETS,
    unit: str = "µm",
    average: np.ndarray | None = None,
) -> str:
    """The tab table with its environment."""
    mean = table.mean(axis=0) if average is None else average
    lines = [
        "Comments: [Z Axis Accuracy]",
        "Serial Number: 4711",
        "",
        "Statistical Analysis:",
        "Accuracy: 9.9",
        "Raw Data:",
    ]
    lines += [
        "\t".join(
            ["Target Position", *(f"RUN {r + 1} ({unit})" for r in range(len(table))), "Average"]
        )
    ]
    lines += [
        "\t".join([f"{t:g}", *(f"{v:.2f}" for v in table[:, k]), f"{mean[k]:.4f}"])
        for k, t in enumerate(targets)
    ]
    lines += [
        "",
        "Environmental Data:",
        "Air Temp: 20.12 C",
        "Material Temp 1: 68.0 F",
        "Expansion Coefficient: 11.70",
        "",
    ]
    return "\n".join(lines)


def canonical(tables: dict[str, tuple[np.ndarray, str]], targets: np.ndarray = TARGETS) -> str:
    """component -> (readings, unit) as the long table; X stood at 10 mm, Y at 20 mm."""
    lines = ["component,axis,target,run,dir,value,unit,x,y,z,t_machine,t_air,time"]
    clock = 0
    for name, (table, unit) in tables.items():
        for r, row in enumerate(table):
            order = range(len(targets)) if r % 2 == 0 else range(len(targets) - 1, -1, -1)
            for k in order:
                at = f"10,20,{targets[k]:g}" if name[2] == "Z" else "10,20,30"
                lines.append(
                    f"{name},{name[2]},{targets[k]:g},{r + 1},{'+' if r % 2 == 0 else '-'},{row[k]:.2f},{unit},{at},20.5,20.1,{clock}"  # noqa: E501
                )
                clock += 7
    return "\n".join(lines) + "\n"


def compensation(nominal: np.ndarray, forward: np.ndarray, reverse: np.ndarray, kind: int) -> str:
    """LinuxCNC's COMP_FILE of deviations in mm."""
    base, sign = (nominal, 1.0) if kind == 0 else (0 * nominal, -1.0)
    rows = zip(nominal, base + sign * forward, base + sign * reverse, strict=True)
    return "\n".join(f"{n:.4f} {f:.6f} {r:.6f}" for n, f, r in rows) + "\n"


def source(name: str, data: str | bytes) -> Source:
    return Source(name, data if isinstance(data, bytes) else data.encode())


def taken(name: str, data: str | bytes, format: str = "", **options) -> Recording:
    return read(source(name, data), format, ReadingOptions(**options))


def as_table(recording: Recording, letter: str = "Z") -> tuple[np.ndarray, np.ndarray]:
    """Targets (K,) and readings (R, K) in um or urad; nan where a reading is missing."""
    run, place = recording.columns["run"].astype(int), recording.position(letter)
    targets = np.unique(place)
    table = np.full((run.max(), len(targets)), np.nan)
    table[run - 1, np.searchsorted(targets, place)] = recording.reading / recording.unit
    return targets, table
