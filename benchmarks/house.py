"""Figures of a package's code, to lay those of gcomp beside others': `python benchmarks/house.py
DIR ...`, needs radon.

DIR is a package (`postproc`, `h11`). One row each of a Markdown table: modules; lines; functions of
which complexity, as radon counts it, is above 10 and above 15, % of all; lines beyond 100 columns,
%; comments per 100 lines, docstrings apart; circles of imports, those in functions and for
annotations too, and the modules in them.
"""

from __future__ import annotations

import ast
import io
import sys
import tokenize
from collections.abc import Iterator
from pathlib import Path

COLUMNS = 100


def modules(package: Path) -> dict[str, Path]:
    """Dotted name to file, of what is no test."""
    found = {}
    for path in sorted(package.rglob("*.py")):
        parts = path.relative_to(package.parent).with_suffix("").parts
        if "tests" not in parts:
            found[".".join(parts).removesuffix(".__init__")] = path
    return found


def complexities(text: str) -> list[int]:
    """Of every function and method, those in functions too."""
    from radon.complexity import cc_visit
    from radon.visitors import Function

    def all_of(block: Function) -> Iterator[int]:
        yield block.complexity
        for inner in block.closures:
            yield from all_of(inner)

    blocks = (b for b in cc_visit(text) if isinstance(b, Function))
    return [n for block in blocks for n in all_of(block)]


def comments(text: str) -> int:
    tokens = tokenize.generate_tokens(io.StringIO(text).readline)
    return sum(token.type == tokenize.COMMENT for token in tokens)


def needs(name: str, path: Path, known: dict[str, Path]) -> set[str]:
    """Modules of the package that one imports."""
    here = name.split(".") if path.name == "__init__.py" else name.split(".")[:-1]
    found = set()
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        if isinstance(node, ast.ImportFrom):
            base = here[: len(here) + 1 - node.level] if node.level else []
            above = ".".join([*base, *filter(None, [node.module])])
            inner = {f"{above}.{alias.name}" for alias in node.names}
            found |= {one if one in known else above for one in inner}
    return (found & known.keys()) - {name}


def circles(known: dict[str, Path]) -> list[set[str]]:
    """Sets of modules each of which needs all others of its set."""
    direct = {name: needs(name, path, known) for name, path in known.items()}
    reach = {}
    for name in known:
        reach[name], waiting = set(), [name]
        while waiting:
            new = direct[waiting.pop()] - reach[name]
            reach[name] |= new
            waiting += new
    rounds = [{o for o in reach[name] if name in reach[o]} for name in known if name in reach[name]]
    return [r for i, r in enumerate(rounds) if r not in rounds[:i]]


def row(package: Path) -> list[str]:
    known = modules(package)
    texts = [path.read_text("utf-8") for path in known.values()]
    lines = [line for text in texts for line in text.splitlines()]
    ways = [n for text in texts for n in complexities(text)]
    above = [100 * sum(n > most for n in ways) / len(ways) for most in (10, 15)]
    wide = 100 * sum(len(line) > COLUMNS for line in lines) / len(lines)
    found = circles(known)
    return [
        package.name, f"{len(known):,}", f"{len(lines):,}", f"{len(ways):,}",
        *(f"{share:.2f}" for share in above), f"{wide:.2f}",
        f"{100 * sum(map(comments, texts)) / len(lines):.1f}",
        f"{len(found)} ({sum(map(len, found))})",
    ]  # fmt: skip


def main(folders: list[str]) -> None:
    head = (
        "package", "modules", "lines", "functions", "above 10, %", "above 15, %",
        f"beyond {COLUMNS} columns, %", "comments per 100 lines", "circles (modules)",
    )  # fmt: skip
    for cells in (head, ["---"] * len(head), *(row(Path(f).resolve()) for f in folders)):
        print(f"| {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
