"""Where machines are found: ./machines, the user's own, and those that come with gcomp, in that
order."""

from __future__ import annotations

from pathlib import Path

from postproc.errors import UsageError
from postproc.machine.file import read_machine
from postproc.machine.model import Machine


def folders() -> list[Path]:
    """Folders of machines that exist, the first one wins."""
    from platformdirs import user_config_path

    here = Path(__file__).resolve()
    candidates = [
        Path("machines"),
        user_config_path("gcomp", appauthor=False) / "machines",
        here.parents[1] / "machines",
        here.parents[2] / "machines",
    ]
    result: list[Path] = []
    for folder in candidates:
        if folder.is_dir() and folder.resolve() not in [r.resolve() for r in result]:
            result.append(folder)
    return result


def every() -> dict[str, Path]:
    """All machines by name."""
    found: dict[str, Path] = {}
    for folder in folders():
        for path in sorted(folder.iterdir()):
            if (path / "machine.toml").is_file():
                found.setdefault(path.name, path)
    return found


def folder_of(name: str) -> Path:
    """The folder of the machine called `name`, or of that path. Raises UsageError with the names
    that there are."""
    path = Path(name)
    if (len(path.parts) > 1 or path.is_absolute()) or (path / "machine.toml").is_file():
        if not path.is_dir():
            raise UsageError(f"there is no machine folder {name}")
        return path
    found = every()
    if name not in found:
        raise UsageError(
            f"there is no machine {name!r}",
            f"machines: {', '.join(found) or 'none'} (looked in {', '.join(map(str, folders()))});"
            " or give the path of a machine folder",
        )
    return found[name]


def load(name: str) -> Machine:
    """The machine called `name`, or in the folder of that path. Raises UsageError with the names
    that there are."""
    return read_machine(folder_of(name))
