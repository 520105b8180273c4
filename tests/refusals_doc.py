"""Every sentence with which gcomp refuses something, read out of the source: `python -m
tests.refusals_doc` writes docs/REFUSALS.md, and a test compares them."""

from __future__ import annotations

import ast
import re
from functools import lru_cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "postproc"
DOC = ROOT / "docs" / "REFUSALS.md"
CALLS = {
    "fault": None,
    "blame": None,
    "because": None,
    "bare": None,
    "BlockFault": None,
    "MotionFault": None,
    "ProgramError": None,
    "MachineError": None,
    "UsageError": None,
    "GcompError": None,
    "ArgumentTypeError": None,
    "_error": None,
    "error": None,
    "refuse": None,
    "ExpressionError": None,
    "Refused": None,
    "Unknown": None,
    "AcceptError": None,
    "LogError": None,
    "VolumetricError": None,
    "Refusal": None,
    "wrong": None,
}
PAIRS = (
    "nc/faults",
    "nc/frames",
    "nc/planes",
    "nc/presets",
    "nc/zeros",
    "nc/lengths",
    "filter",
)  # modules that hand on (message, way out) as a pair
CHAPTERS = (
    ("The text of a program", ("nc/lexer", "nc/faults", "nc/spellings", "nc/checksums", "filter")),
    (
        "Words, codes and motions",
        (
            "nc/batch",
            "nc/refusals",
            "nc/interpreter",
            "nc/control",
            "nc/positions",
            "nc/arcs",
            "nc/codes",
            "nc/rows",
            "nc/recognise",
            "nc/feeds",
        ),
    ),
    ("Shifts of the coordinates", ("nc/frames", "nc/zeros", "nc/lengths")),
    ("Holes in place", ("nc/holes", "compensate/holes")),
    ("What the error map can not answer", ("compensate",)),
    ("Written out: cycles, turned and scaled coordinates", ("nc/cycles", "nc/expand/resolve")),
    ("Written out: LinuxCNC's O-words and expressions", ("nc/expand/linuxcnc",)),
    ("Written out: Fanuc's macros", ("nc/expand/fanuc",)),
    ("Written out: Sinumerik's control structures", ("nc/expand/siemens",)),
    ("Written out: Heidenhain Klartext", ("nc/expand/klartext",)),
    ("Written out: Fadal's subroutines", ("nc/expand/fadal",)),
    ("Written out: Okuma's user tasks", ("nc/expand/okuma",)),
    ("Written out: all languages", ("nc/expand",)),
    ("Machine folders", ("machine", "effects")),
    ("Heat over time", ("heat", "commands/warming")),
    ("Offset files", ("offsets",)),
    ("Recordings", ("recordings",)),
    ("Tables of the control", ("control_tables",)),
    (
        "Calibration, ISO 230 and diagnosis",
        ("calibrate", "iso", "accept", "diagnose", "simulate", "volumetric"),
    ),
    ("Streaming", ("streaming", "commands/stream")),
    ("The command line", ("commands", "cli", "ports", "nc/dialects", "verify")),
)
HEAD = """# What gcomp refuses, in its own words

Every sentence that stops a program, with its way out: look here for one that you have met. A word
in *italics* stands for what is put in there. An error names file and line, and where it can the
columns. Codes that a dialect knows and can not follow are listed, with their reason, in
[DIALECTS.md](DIALECTS.md); they stop a program only where a correction depends on them. Generated
from the source by `python -m tests.refusals_doc`.
"""


@lru_cache
def sentences() -> dict[str, list[tuple[str, str]]]:
    """Chapter to (message, way out), sorted; every message once."""
    result: dict[str, dict[str, str]] = {title: {} for title, _ in CHAPTERS}
    for path in sorted(PACKAGE.rglob("*.py")):
        where = path.relative_to(PACKAGE).with_suffix("").as_posix()
        title, text = _chapter(where), path.read_text()
        if where not in PAIRS and not any(f"{name}(" in text for name in CALLS):
            continue  # nothing to be found: need not be parsed
        nodes = list(ast.walk(ast.parse(text)))
        constants = {
            target.id: node.value
            for node in nodes
            if isinstance(node, ast.Assign)
            for target in node.targets
            if isinstance(target, ast.Name)
        }
        constants |= {  # a function that does nothing but choose between sentences
            node.name: node.body[0].value
            for node in nodes
            if isinstance(node, ast.FunctionDef)
            and isinstance(node.body[0], ast.Return)
            and node.body[0].value
        }
        for node in nodes:
            if isinstance(node, ast.Tuple) and len(node.elts) == 2 and where in PAIRS:
                pair = [_text(e, constants) for e in node.elts]
                if all(" " in t for t in pair):
                    result[title].setdefault(*pair)
            if not isinstance(node, ast.Call):
                continue
            name = (
                node.func.attr
                if isinstance(node.func, ast.Attribute)
                else getattr(node.func, "id", "")
            )
            if name not in CALLS:
                continue
            texts = [t for t in (_text(a, constants) for a in node.args) if t and " " in t]
            if texts:
                result[title].setdefault(texts[0], texts[1] if len(texts) > 1 else "")
    return {title: sorted(found.items()) for title, found in result.items() if found}


def _chapter(where: str) -> str:
    best = max(
        (
            (len(prefix), title)
            for title, prefixes in CHAPTERS
            for prefix in prefixes
            if where.startswith(prefix)
        ),
        default=(0, ""),
    )
    return best[1] or CHAPTERS[-1][0]


def _text(node: ast.expr, constants: dict[str, ast.expr], depth: int = 0) -> str:
    """The text of a constant or a formatted string, placeholders in italics; "" for anything
    else."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    if isinstance(node, ast.JoinedStr):
        return "".join(_piece(v, constants) for v in node.values)
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
        node = node.func
    if isinstance(node, ast.Name) and node.id in constants and depth < 3:
        return _text(constants[node.id], constants, depth + 1)
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add):
        return _text(node.left, constants, depth) + _text(node.right, constants, depth)
    if isinstance(node, ast.IfExp):
        return _text(node.body, constants, depth) or _text(node.orelse, constants, depth)
    return ""


def _piece(node: ast.expr, constants: dict[str, ast.expr]) -> str:
    if isinstance(node, ast.Constant):
        return str(node.value)
    assert isinstance(node, ast.FormattedValue)
    named = constants.get(node.value.id) if isinstance(node.value, ast.Name) else None
    if isinstance(named, ast.Constant) and isinstance(named.value, str) and " " in named.value:
        return named.value
    names = [
        n
        for n in re.findall(r"[A-Za-z_]+", ast.unparse(node.value))
        if n not in ("self", "b", "int", "float", "str", "len")
    ]
    return f"*{names[-1].strip('_')}*" if names else "*...*"


def text() -> str:
    """The whole page."""
    parts = [HEAD]
    for title, found in sentences().items():
        parts.append(f"\n## {title}\n\n| what it says | the way out |\n|---|---|\n")
        parts += [f"| {_cell(message)} | {_cell(advice)} |\n" for message, advice in found]
    return "".join(parts)


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("\n", " ").replace("<", "&lt;").strip()


if __name__ == "__main__":
    DOC.write_text(text())
