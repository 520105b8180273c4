"""How other programs run gcomp on what they write: one file here for each of them, found by its
name.

A hook has TITLE, TRIED (with what it was tried, or that it was not) and `install(call) ->
Installed`: files to be written, and what a person enters where. Modules that begin with _ are
shared. A program with windows has no shell's PATH and another working directory, and may bring a
Python of its own: so everything is named by its whole path, and the machine by its folder.
"""

from __future__ import annotations

import importlib
import pkgutil
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType

from postproc.errors import UsageError


@dataclass(frozen=True)
class Call:
    """What is to be run. python: of this gcomp; root: the folder that its package lies in; machine:
    its folder; name: its name; options: further ones of gcomp; keep: whether the nominal program
    stays beside the corrected one as .bak; folder: where files are written; post: the CAM program's
    own post-processor, where it has several."""

    python: str
    root: str
    machine: str
    name: str
    folder: Path
    options: tuple[str, ...] = ()
    keep: bool = False
    post: str = ""
    windows: bool = False


@dataclass(frozen=True)
class Installed:
    """files: path to (text, whether it is run); setting: what a person enters, and where."""

    files: dict[Path, tuple[str, bool]] = field(default_factory=dict)
    setting: str = ""


def names() -> list[str]:
    """The programs that there are hooks for."""
    return sorted(m.name for m in pkgutil.iter_modules(__path__) if not m.name.startswith("_"))


def load(name: str) -> ModuleType:
    """The hook of a program, by its name or the begin of it. Raises UsageError with those that
    there are."""
    started = [known for known in names() if name and known.startswith(name)]
    name = started[0] if len(started) == 1 else name
    if name not in names():
        raise UsageError(
            f"there is no hook for {name!r}",
            f"hooks: {', '.join(names())}; gcomp hook list says more",
        )
    return importlib.import_module(f"{__name__}.{name}")
