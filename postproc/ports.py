"""Files and pipes: the only place that opens anything. Nothing is overwritten before its successor
is whole."""

from __future__ import annotations

import contextlib
import hashlib
import io
import os
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, BinaryIO

from postproc import intake, standing
from postproc.errors import UsageError

CHUNK = 3 << 17  # bytes worked on at once: the columns of more leave the processor's cache
IN_MEMORY = 1 << 22
# looked at to tell whose program it is, before any of it is read
HEAD = 1 << 16


def chunks(source: BinaryIO | Kept, live: bool) -> Iterator[bytes]:
    """Pieces of a file or pipe: large ones, or, when `live`, whatever has come so far."""
    while True:
        data = (
            os.read(source.fileno(), CHUNK)
            if live and not isinstance(source, Kept)
            # read() would wait for a whole chunk; a wire and a person at a terminal give what they
            # have
            else source.read(CHUNK)
        )
        if not data:
            return
        yield data


@contextlib.contextmanager
def opened(path: str | None) -> Iterator[tuple[BinaryIO, str, int]]:
    """The program to read: the stream, its name in messages, and its size (0: not known). None and
    "-": standard input."""
    if path in (None, "-"):
        if sys.stdin is None or sys.stdin.isatty():
            raise UsageError(
                "no program: nothing is piped in and no file is named",
                "gcomp --machine NAME FILE, or ... | gcomp --machine NAME",
            )
        yield sys.stdin.buffer, "<stdin>", 0
        return
    assert path is not None
    try:
        source = open(path, "rb", buffering=HEAD)  # noqa: SIM115
    except IsADirectoryError:
        raise UsageError(f"{path} is a folder, not a program") from None
    except OSError as error:
        raise UsageError(f"{path} can not be read: {error.strerror}") from None
    with source:
        yield source, path, os.fstat(source.fileno()).st_size


class Kept:
    """A program that can be read again: a file from its beginning, a pipe from what was kept of it
    beside."""

    def __init__(self, source: BinaryIO, most: int):
        """most: bytes that are kept of a pipe; of a longer one nothing is."""
        self.source, self.most = source, most
        self.begin = source.tell() if source.seekable() else None
        self.beside = spool() if self.begin is None else None
        self.size = self.at = 0  # bytes kept, and which is read next

    def read(self, size: int) -> bytes:
        """At most so many bytes; none: the end."""
        if self.beside is None:
            return self.source.read(size)
        if self.at < self.size:
            self.beside.seek(self.at)
            data = self.beside.read(min(size, self.size - self.at))
            self.at += len(data)
            return data
        data = self.source.read(size)
        # too long to be kept: `again` will say no, and reading goes on without a copy
        if self.size + len(data) > self.most:
            self.beside.close()
            self.beside = None
        else:
            self.beside.seek(self.size)
            self.beside.write(data)
            self.at = self.size = self.size + len(data)
        return data

    def again(self) -> bool:
        """Go back to the beginning; False where that can not be."""
        if self.begin is not None:
            self.source.seek(self.begin)
            return True
        self.at = 0
        return self.beside is not None


class Copy:
    """A program as it was when a job began: whatever becomes of the file, every reading gives the
    same bytes. digest: SHA-256."""

    def __init__(self, path: str):
        """Raises UsageError where it can not be read or kept, or changes while it is read."""
        self.path, self._beside = path, spool()
        sha = hashlib.sha256()
        with opened(path) as (source, _, _):
            self._stamp = _stamp(os.fstat(source.fileno()))
            for data in chunks(source, live=False):
                sha.update(data)
                try:
                    self._beside.write(data)
                except OSError as error:
                    import tempfile

                    raise UsageError(
                        f"{path} can not be copied for the job: {error.strerror}",
                        f"make room in {tempfile.gettempdir()}, or name another folder in TMPDIR",
                    ) from None
            # Another program may write while we read: then the copy is of no state of the file. The
            # stamp before and behind tell it, and once more by name, since the file may have been
            # replaced.
            written = self._stamp != _stamp(os.fstat(source.fileno()))
        if written or self.changed():
            raise UsageError(
                f"{path} is being written", "wait until the program that writes it has finished"
            )
        self.digest = sha.hexdigest()

    @contextlib.contextmanager
    def opened(self) -> Iterator[BinaryIO]:
        """The copy from its beginning; one reader at a time."""
        self._beside.seek(0)
        yield self._beside

    def head(self) -> bytes:
        """How it begins."""
        with self.opened() as stream:
            return stream.read(HEAD)

    def changed(self) -> bool:
        """Whether the file is another one by now, or is gone."""
        try:
            return _stamp(os.stat(self.path)) != self._stamp
        except OSError:
            return True


def _stamp(status: os.stat_result) -> tuple[int, ...]:
    """What changes when a file does."""
    return status.st_ino, status.st_size, status.st_mtime_ns


def head(source: BinaryIO) -> bytes:
    """How the program begins, without taking it from the stream."""
    peek = getattr(source, "peek", None)
    return peek(HEAD)[:HEAD] if peek else b""


def read_whole(path: Path, largest: int) -> bytes:
    """All of a file. Raises UsageError where it can not be read or is larger than `largest`
    bytes."""
    return intake.whole(path, largest)


def spool() -> BinaryIO:
    """A place for output that may yet be refused; in memory while it is small, nameless on disk
    beyond."""
    return Spool()  # type: ignore[return-value]


class Spool:
    """As tempfile.SpooledTemporaryFile, but that a small one need not load that module."""

    def __init__(self) -> None:
        self._file: BinaryIO = io.BytesIO()

    def write(self, data: bytes) -> int:
        """Data behind what is held, on disk from IN_MEMORY bytes on."""
        held = self._file
        # a program of a few megabytes never touches the disk; a longer one costs no memory
        if isinstance(held, io.BytesIO) and held.tell() + len(data) > IN_MEMORY:
            import tempfile

            self._file = tempfile.TemporaryFile()  # noqa: SIM115
            self._file.write(held.getvalue())
            self._file.seek(held.tell())
        return self._file.write(data)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._file, name)

    def __iter__(self) -> Iterator[bytes]:
        return iter(self._file)

    def __enter__(self) -> Spool:
        return self

    def __exit__(self, *error: object) -> None:
        self._file.close()


def copy_out(source: BinaryIO, write: Callable[[bytes], object]) -> None:
    """The whole spool to its destination."""
    source.seek(0)
    while data := source.read(CHUNK):
        write(data)


def place_of(path: Path) -> Path:
    """The file that `path` means, behind its links. Raises UsageError where it can be none."""
    path = Path(os.path.realpath(path))
    if path.is_dir():
        raise UsageError(f"{path} is a folder: name a file in it")
    if not path.parent.is_dir():
        raise UsageError(f"{path} can not be written: there is no folder {path.parent}")
    return path


def writable(path: Path) -> None:
    """Raises UsageError where no file can be put in place of `path`, before hours of work end
    there."""
    path = place_of(path)
    if path.exists() and not path.is_file():
        return  # a device is written as it is
    import tempfile

    try:
        with tempfile.TemporaryFile(dir=path.parent):
            pass
    except OSError as error:
        raise UsageError(f"{path} can not be written: {error.strerror}") from None


def write_new(path: str | Path, data: bytes, overwrite: bool) -> Path:
    """Put data in a file, whole or not at all. Raises UsageError where one stands and `overwrite`
    is not set."""
    target = Path(path)
    if target.exists() and not overwrite:
        raise UsageError(f"{target} exists", "overwrite=True replaces it")
    write_whole(target, data)
    return target


def write_whole(path: str | Path, data: bytes) -> None:
    """Put data in a file, whole or not at all, in place of what stood there."""
    replace_file(Path(path), io.BytesIO(data), backup=False)


def replace_file(path: Path, source: BinaryIO, backup: bool) -> Path | None:
    """Put the spool in place of `path` in one step; with `backup` its old content stays beside it.
    Returns the backup.

    The new file is whole and on the disk before the old name points to it; mode and links are kept.
    """
    path = place_of(path)
    # /dev/stdout, a named pipe: replacing it would put a plain file in its place
    if path.exists() and not path.is_file():
        with open(path, "wb") as special:  # a device or a pipe has no successor
            copy_out(source, special.write)
        return None
    import shutil
    import tempfile

    # beside the target, since a rename is one step within a file system only
    handle, temporary = tempfile.mkstemp(prefix=f".{path.name}.", suffix=".part", dir=path.parent)
    try:
        with os.fdopen(handle, "wb") as new:
            copy_out(source, new.write)
            new.flush()
            # On the disk before it has the name: after a failure of power there stands the old file
            # or the new one, never an empty one of the new name.
            os.fsync(new.fileno())
        if path.exists():
            shutil.copymode(path, temporary)
        else:
            # the only way to ask for it is to set it: a new file gets the rights that open() would
            # give
            mask = os.umask(0)
            os.umask(mask)
            os.chmod(temporary, 0o666 & ~mask)
        kept = _backup(path) if backup else None
        os.replace(temporary, path)
        return kept
    except BaseException:
        with contextlib.suppress(OSError):
            os.unlink(temporary)
        raise


def _backup(path: Path) -> Path:
    """A copy of `path` under a name that was free: part.nc.bak, part.nc.bak2, ..."""
    import shutil

    for n in range(1, 1000):
        name = path.with_name(f"{path.name}.bak{n if n > 1 else ''}")
        try:
            # x: of two processes one gets the name, the other goes on to the next
            copy = open(name, "xb")  # noqa: SIM115
        except FileExistsError:
            continue
        try:
            with copy, open(path, "rb") as old:
                shutil.copyfileobj(old, copy)
                copy.flush()
                os.fsync(copy.fileno())
            shutil.copystat(path, name)
            return name
        except BaseException:
            with contextlib.suppress(OSError):
                os.unlink(name)
            raise
    raise UsageError(f"{path}: 999 backups stand beside it", "remove the old ones")


def write_standard(data: bytes) -> None:
    """To standard output, at once."""
    if sys.stdout is None:
        raise UsageError("standard output is closed", "write to a file with -o FILE")
    view = memoryview(data)
    while view:
        view = view[os.write(sys.stdout.fileno(), view) :]


def copy_folder(
    source: Path,
    target: Path,
    force: bool,
    change: Callable[[str], str],
    more: dict[str, bytes] | None = None,
) -> None:
    """A copy of a machine's folder with its machine.toml changed and more files in it; whole or not
    at all. Raises UsageError where there is one already."""
    import shutil
    import tempfile

    standing.kept(target, force)
    target.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=target.parent, prefix=f".{target.name}.") as scratch:
        copy = Path(scratch) / target.name
        copy.mkdir()
        for file in source.iterdir():
            if file.is_file():
                shutil.copyfile(file, copy / file.name)
        for name, data in (more or {}).items():
            (copy / name).write_bytes(data)
        toml = copy / "machine.toml"
        toml.write_bytes(change(toml.read_bytes().decode("utf-8")).encode("utf-8"))
        if target.exists():
            # the old folder stays under another name: a machine is what somebody measured
            os.rename(target, beside(target))
        os.replace(copy, target)


def beside(path: Path) -> Path:
    """A name for what stood at `path` that is free: mine.bak, mine.bak2, ..."""
    names = (path.with_name(f"{path.name}.bak{n if n > 1 else ''}") for n in range(1, 1000))
    return next(name for name in names if not os.path.lexists(name))
