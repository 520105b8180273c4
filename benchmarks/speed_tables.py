"""What benchmarks/speed.py measured, as tables in Markdown."""

from __future__ import annotations

from watched import Row

STARTS = 10


def table(heads: list[str], lines: list[list[str]]) -> str:
    rule = ["---" if at < 2 else "---:" for at in range(len(heads))]
    return "\n".join("| " + " | ".join(cells) + " |" for cells in (heads, rule, *lines)) + "\n"


def ratio(row: Row, rows: list[Row]) -> str:
    """The rate of gcomp on the same file as a multiple of this row's."""
    own = next(other for other in rows if other.file == row.file and other.tool == "gcomp")
    return f"{own.rate / row.rate:.2f}" if own.rate and row.rate else "-"


def speed_table(rows: list[Row]) -> str:
    heads = [
        "file",
        "tool",
        "lines",
        "CPU s",
        "lines per CPU s",
        "wall s",
        "peak MB",
        "gcomp is x times as fast",
    ]
    lines = []
    for row in rows:
        if row.usage is None:
            lines.append([row.file, f"{row.tool}: {row.problem.replace('|', '/')}", *["-"] * 6])
            continue
        used = row.usage
        figures = f"{row.lines:,} {used.cpu_s:.2f} {row.rate:,.0f} {used.wall_s:.2f} {used.peak_mb:.0f}".split()  # noqa: E501
        lines.append([row.file, row.tool, *figures, ratio(row, rows)])
    return table(heads, lines)


def start_table(rows: list[Row]) -> str:
    lines = []
    for row in rows:
        what = f"{row.tool}, {row.lines} lines" if row.lines else row.tool
        if row.usage is None:
            lines.append([what, row.problem.replace("|", "/"), "-", "-"])
        else:
            used = row.usage
            lines.append([what, "", f"{used.wall_s * 1000:.0f}", f"{used.peak_mb:.0f}"])
    return table(["start-up", f"best of {STARTS}", "wall ms", "peak MB"], lines)


def memory_table(rows: list[Row]) -> str:
    lines = []
    for row in rows:
        peak = f"{row.usage.peak_mb:.1f}" if row.usage else "-"
        tool = row.tool if row.usage else f"{row.tool}: {row.problem.replace('|', '/')}"
        lines.append([row.file, tool, f"{row.lines:,}", peak])
    return table(["file", "tool", "lines", "peak MB"], lines)
