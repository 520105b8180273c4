"""Where machines are found: ./machines, the user's own, and those that come with gcomp, in that
order."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from postproc.errors import UsageError
from postproc.expressions import expression
from postproc.machine.file import read_machine
from postproc.machine.model import Machine

KEPT = expression(r".+\.bak\d*")  # what --force leaves of a machine's folder
ALIKE = 0.75  # of difflib's ratio: two letters changed places, or one is missing


def folders() -> Iterator[Path]:
    """Folders of machines that exist, the first one wins."""
    # Resolved, since ./machines may be the repository's own folder: it would be listed twice, and
    # with its copies twice.
    before: list[Path] = []
    for folder in _candidates():
        if folder.is_dir() and (place := folder.resolve()) not in before:
            before.append(place)
            yield folder


def _candidates() -> Iterator[Path]:
    """Where machines may be, in order."""
    yield Path("machines")
    # loaded where a machine is not in the folder above: it takes 3 ms
    from platformdirs import user_config_path

    here = Path(__file__).resolve()
    yield user_config_path("gcomp", appauthor=False) / "machines"
    yield here.parents[1] / "machines"
    yield here.parents[2] / "machines"


def _within(folder: Path) -> dict[str, Path]:
    """The machines of a folder by name."""
    return {x.name: x for x in sorted(folder.iterdir()) if (x / "machine.toml").is_file()}


def shown() -> list[str]:
    """Names for a message: not those of copies that --force has left."""
    return [name for name in every() if not KEPT.fullmatch(name)]


def every() -> dict[str, Path]:
    """All machines by name."""
    found: dict[str, Path] = {}
    for folder in folders():
        for name, path in _within(folder).items():
            found.setdefault(name, path)
    return found


def folder_of(name: str) -> Path:
    """The folder of the machine called `name`, or of that path. Raises UsageError with the names
    that there are."""
    path = Path(name)
    # A word without a slash is a name first, unless a folder of that name here is a machine:
    # `studer-s36` in ./machines must not hide behind a folder `studer-s36` of programs.
    if (len(path.parts) > 1 or path.is_absolute()) or (path / "machine.toml").is_file():
        if not path.is_dir():
            raise UsageError(
                f"there is no machine folder {name}",
                "gcomp machines lists those that are found by their name alone",
            )
        return path
    for folder in folders():
        if name in (found := _within(folder)):
            return found[name]
    from difflib import get_close_matches  # where something is wrong alone

    known = shown()
    near = "".join(f"did you mean {x}? " for x in get_close_matches(name, known, 1, ALIKE))
    raise UsageError(
        f"there is no machine {name!r}",
        f"{near}machines: {', '.join(known) or 'none'}"
        f" (looked in {', '.join(map(str, folders()))}); or give the path of a machine folder",
    )


def load(name: str) -> Machine:
    """The machine called `name`, or in the folder of that path. Raises UsageError with the names
    that there are."""
    return read_machine(folder_of(name))
