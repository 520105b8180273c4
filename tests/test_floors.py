"""Imports go down: text knows no physics, physics knows no text, and only the outermost layer opens
anything."""

from __future__ import annotations

import ast
import gc
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests import slow_tests

PACKAGE = Path(__file__).resolve().parents[1] / "postproc"
FLOOR = {
    "accept": 3,
    "units": 0,
    "style": 0,
    "spaces": 0,
    "toml_text": 0,
    "errors": 0,
    "marks": 0,
    "intake": 0,
    "motions": 0,
    "pieces": 0,
    "records": 0,
    "nc": 1,
    "kernel": 0,
    "machine": 1,
    "effects": 1,
    "compensate": 3,
    "filter": 4,
    "heat": 3,
    "volumetric": 3,
    "offsets": 1,
    "recordings": 1,
    "control_tables": 2,
    "iso": 2,
    "calibrate": 3,
    "streaming": 4,
    "diagnose": 3,
    "simulate": 4,
    "slides": 4,
    "verify": 4,
    "trace": 4,
    "pages": 4,
    "commands": 5,
    "api": 5,
    "batch": 5,
    "hooks": 2,
    "cli": 5,
    "entry": 5,
    "ports": 5,
    "standing": 5,
    "__main__": 5,
    "__init__": 0,
}
STRANGERS = {
    ("nc", "machine"),
    ("nc", "effects"),
    ("nc", "compensate"),
    ("machine", "nc"),
    ("effects", "nc"),
    ("compensate", "nc"),
    ("recordings", "nc"),
    ("recordings", "machine"),
    ("iso", "machine"),
    ("iso", "nc"),
    ("calibrate", "nc"),
    ("control_tables", "nc"),
    ("streaming", "machine"),
    ("streaming", "compensate"),
    ("diagnose", "nc"),
    ("diagnose", "compensate"),
}
OPENERS = {
    "ports",
    "intake",
    "commands",
    "cli",
    "standing",
    "batch",
    "kernel",
    "machine/file",
}  # file.py reads a machine's folder: that is what a machine is; kernel.py builds itself


def modules():
    return sorted(PACKAGE.rglob("*.py"))


@pytest.fixture(scope="module")
def trees() -> Iterator[dict[Path, ast.Module]]:
    """Every module, parsed once; looking for garbage among so many nodes would take three times as
    long as parsing them."""
    gc.disable()
    found = {path: ast.parse(path.read_text("utf-8")) for path in modules()}
    gc.freeze()
    gc.enable()
    yield found
    gc.unfreeze()


def part(path: Path) -> str:
    relative = path.relative_to(PACKAGE)
    return relative.parts[0] if len(relative.parts) > 1 else relative.stem


def imports(tree: ast.Module) -> set[str]:
    """Parts of the package that a module imports, those under TYPE_CHECKING left out."""
    found: set[str] = set()
    typing_only = [
        n
        for n in ast.walk(tree)
        if isinstance(n, ast.If) and getattr(n.test, "id", "") == "TYPE_CHECKING"
    ]
    skip = {id(child) for n in typing_only for child in ast.walk(n)}
    for node in ast.walk(tree):
        if id(node) in skip:
            continue
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("postproc"):
            names = (
                [node.module.split(".")[1]] if "." in node.module else [a.name for a in node.names]
            )
            found.update(n for n in names if n in FLOOR)
        elif isinstance(node, ast.Import):
            found.update(a.name.split(".")[1] for a in node.names if a.name.startswith("postproc."))
    return found


def test_imports_go_down(trees):
    for path, tree in trees.items():
        own = part(path)
        for other in imports(tree) - {own}:
            assert FLOOR[other] <= FLOOR[own], (
                f"{path.name} (floor {FLOOR[own]}) imports {other} (floor {FLOOR[other]}): imports"
                " go down"
            )
            assert (own, other) not in STRANGERS, (
                f"{path.name}: {own} and {other} are strangers; they meet in filter.py"
            )


def test_only_the_outermost_layer_opens_prints_or_looks_at_clocks(trees):
    for path, tree in trees.items():
        where = str(path.relative_to(PACKAGE))[:-3]
        if part(path) in OPENERS or where in OPENERS:
            continue
        for node in ast.walk(tree):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
                assert node.func.id not in ("open", "print", "input"), (
                    f"{where} calls {node.func.id}"
                )
            if isinstance(node, ast.Import):
                assert not {a.name for a in node.names} & {
                    "time",
                    "threading",
                    "socket",
                    "subprocess",
                }, f"{where} imports a clock or a port"


LONGEST = 400  # lines of a module
LONGER = {  # lines that it may have, and why it is one thing
    "nc/expand/fanuc.py": (450, "one language: macro B runs as one interpreter"),
    "nc/expand/resolve.py": (505, "one stage: a line passes cycles, then frames, then the tracker"),
    "nc/expand/siemens.py": (460, "one language: a Sinumerik program runs as one interpreter"),
    "streaming/protocols/_numbered.py": (430, "one exchange: number, answer and request of a line"),
    "streaming/sender.py": (530, "one state machine: every event meets the same state of a job"),
}


def test_a_module_stays_in_one_head():
    """A guide made a law at its upper end: what grows beyond this is two things in one file, or
    says here why it is one."""
    lines = {str(p.relative_to(PACKAGE)): len(p.read_text("utf-8").splitlines()) for p in modules()}
    most = {name: n for name, (n, _) in LONGER.items()}
    assert not {name: n for name, n in lines.items() if n > most.get(name, LONGEST)}
    assert not {name for name in LONGER if lines.get(name, 0) <= LONGEST}, "no exception any more"


MOST_COMPLEX = 15  # ways through a function, as McCabe and radon count them


def branches(node: ast.AST) -> int:
    """What a statement adds to the ways through its function; a function within it counts alone."""
    if isinstance(node, ast.FunctionDef):
        return 0
    if isinstance(node, ast.Assert):
        return 1
    own = isinstance(node, ast.If | ast.IfExp | ast.For | ast.While | ast.ExceptHandler)
    if isinstance(node, ast.For | ast.While | ast.Try):
        own += bool(node.orelse)
    if isinstance(node, ast.BoolOp):
        own += len(node.values) - 1
    if isinstance(node, ast.comprehension):
        own += 1 + len(node.ifs)
    return own + sum(map(branches, ast.iter_child_nodes(node)))


def test_a_long_list_of_branches_says_why_it_is_whole(trees):
    """A function of many branches is split, or the line above it says why it reads better whole:
    "# Whole: ..."."""
    for path, tree in trees.items():
        lines = path.read_text("utf-8").splitlines()
        for node in ast.walk(tree):
            if isinstance(node, ast.FunctionDef):
                ways = 1 + sum(map(branches, node.body))
                first = min([node.lineno, *(d.lineno for d in node.decorator_list)])
                said = lines[first - 2].lstrip().startswith("# Whole: ")
                assert said == (ways > MOST_COMPLEX), (path.name, node.name, ways)


def test_the_slow_tests_are_named_as_they_are():
    """A test that was renamed would be a fast one by mistake."""
    root = Path(__file__).resolve().parents[1]
    for name in slow_tests.listed():
        file, _, function = name.partition("::")
        assert re.search(rf"^def {function}\(", (root / file).read_text(), re.MULTILINE), name


def test_files_begin_by_their_time(request):
    """The longest first, so that no processor is left with one at the end; those that wait lie
    among the others by their share. pytest-xdist keeps this order."""
    seconds: dict[str, float] = {}
    for name, took in slow_tests.listed().items():
        file = slow_tests.file_of(name)
        seconds[file] = seconds.get(file, 0.0) + took
    order = slow_tests.in_order(sorted(seconds))
    waiting = [f for f in order if f.startswith(slow_tests.WAITING)]
    others = [f for f in order if f not in waiting]
    for row in (waiting, others):
        took = [round(seconds[f], 1) for f in row]
        assert took == sorted(took, reverse=True)
    half = order[: order.index(waiting[len(waiting) // 2])]
    assert 0.3 < sum(seconds[f] for f in half) / sum(seconds.values()) < 0.9
    assert not getattr(request.config.option, "loadscopereorder", False)


def needed(tree: ast.Module, known: dict[str, Path]) -> set[str]:
    """Modules of the package that a module imports, in its functions and for annotations too."""
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            above = (node.module or "").partition("postproc")[2].lstrip(".")
            names = {f"{above}.{alias.name}".lstrip(".") for alias in node.names}
            found |= {name if name in known else above for name in names}
    return found & known.keys()


def test_no_module_needs_itself(trees):
    """A data type lies below what works on it, so that every module is read after those it
    needs."""
    known = {
        ".".join(p.relative_to(PACKAGE).with_suffix("").parts).removesuffix(".__init__"): p
        for p in modules()
    }
    needs = {name: needed(trees[path], known) - {name} for name, path in known.items()}
    reach = {}

    def all_of(name):
        """What a module needs at any remove."""
        if name not in reach:
            reach[name], waiting = set(), [name]
            while waiting:
                new = needs[waiting.pop()] - reach[name]
                reach[name] |= new
                waiting += new
        return reach[name]

    circles = {
        tuple(sorted({name} | {other for other in all_of(name) if name in all_of(other)}))
        for name in known
        if name in all_of(name)
    }
    assert not circles
