"""The command line: opens, closes, and says what went wrong. Each subcommand is a file in
postproc/commands."""

from __future__ import annotations

import argparse
import contextlib
import errno
import gc
import importlib
import os
import re
import signal
import sys
from types import ModuleType
from typing import NoReturn, TextIO

from postproc import __version__, colour, standing
from postproc.errors import GcompError, UsageError

# numpy's own threads serve nothing here, and cost start-up time.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

DEFAULT = "compensate"
HELPERS = (
    "as_json", "attempts", "calibrate_options", "expansion", "export_files", "export_options",
    "machine_facts", "machine_new", "machine_questions", "machine_shown", "machine_values",
    "option_text", "outcome", "port_options", "reading", "reading_options", "recording_files",
    "residual", "session", "simulate_named", "simulate_options", "values", "warming",
)  # fmt: skip
ALIKE = 0.75  # of difflib's ratio: two letters changed places, or one is missing
# what a new file or folder is called until it is whole
HIDDEN = r"\.(.+)\.[a-z0-9_]{8}(?:\.part)?"
# 130 and 141 are what a shell tells of SIGINT and SIGPIPE: 128 and the signal's number
REFUSED, FAILED, INTERRUPTED, CLOSED_PIPE = 2, 1, 130, 141


class _Parser(argparse.ArgumentParser):
    """Says what is wrong with the options in two lines, not below forty of usage."""

    def error(self, message: str) -> NoReturn:
        command = self.prog if " " in self.prog else f"{self.prog} {DEFAULT}"
        unknown = message.partition("unrecognized arguments: ")[2]
        near = self._near(unknown)
        meant = f"did you mean {near}? " if near else ""
        if unknown and not unknown.startswith("-") and " " not in self.prog:
            message = f"one program at a time, and {unknown} is another"
            meant = "gcomp batch PROGRAM... -o DIR takes many; "
        colour.fault(f"{message}\n    {meant}{command} --help lists the options")
        self.exit(REFUSED)

    def _near(self, unknown: str) -> str:
        """The option that is written almost as the first unknown one; "" where none is."""
        known = [name for action in self._actions for name in action.option_strings]
        word = unknown.split(" ")[0].split("=")[0]
        found = alike(word, known) if word.startswith("--") else []
        return found[0] if found else ""


def alike(word: str, known: list[str]) -> list[str]:
    """The one of `known` that is written almost as `word`, or none."""
    import difflib  # where something is wrong alone: a program is begun without it

    return difflib.get_close_matches(word, known, 1, ALIKE)


def commands() -> list[str]:
    """Names of the subcommands."""
    import pkgutil

    from postproc import commands as package

    return sorted(
        module.name
        for module in pkgutil.iter_modules(package.__path__)
        if module.name not in HELPERS
    )


def main(argv: list[str] | None = None) -> int:
    """Run gcomp; returns the exit status: 0, 1 the surroundings failed, 2 refused, 130 interrupted,
    141 closed pipe."""
    plain = sys.stderr
    if colour.wanted(plain):
        sys.stderr = colour.Painted(plain)
    try:
        return _answered(argv)
    finally:
        sys.stderr = plain if isinstance(sys.stderr, colour.Painted) else sys.stderr
        for stream in (sys.stdout, sys.stderr):
            _let_go(stream)


def _answered(argv: list[str] | None) -> int:
    """The exit status, every error told."""
    argv = sys.argv[1:] if argv is None else argv
    _keep_memory()
    # closed by the caller, or none on a Windows desktop: nothing to say, and nowhere else to say it
    if sys.stderr is None:
        sys.stderr = open(os.devnull, "w")  # noqa: SIM115
    try:
        # only the main thread may set a handler; where gcomp is called from another one, SIGTERM
        # stays as it is
        with contextlib.suppress(ValueError, AttributeError):
            signal.signal(signal.SIGTERM, _interrupt)
        status = _run(argv)
        if sys.stdout is not None:
            sys.stdout.flush()
        return status
    except GcompError as error:
        return _complain(str(error), REFUSED)
    except KeyboardInterrupt:
        return _complain(
            "interrupted: nothing was overwritten, and what was not yet written is dropped",
            INTERRUPTED,
        )
    except BrokenPipeError:
        _forget_output()
        return CLOSED_PIPE
    except OSError as error:
        _forget_output()
        return _complain(_of_surroundings(error), FAILED)
    except MemoryError:
        return _complain("out of memory", FAILED)


def _of_surroundings(error: OSError) -> str:
    """What failed, and what that means for files."""
    path, name = os.path.split(str(error.filename or ""))
    if made := re.fullmatch(HIDDEN, name):
        return (
            f"{os.path.join(path, made[1])} can not be written: {error.strerror}"
            "\n    name a place that you may write to, with room on its disk"
        )
    what = f"{error.filename}: " if error.filename else ""
    # the disk is full or fails: a spool that was begun is dropped, and the old file is untouched
    full = (
        "; the output is not complete, a file that stood there before still does"
        if error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)
        else ""
    )
    return f"{what}{error.strerror or error}{full}"


def _let_go(stream: TextIO | None) -> None:
    """Write what a standard stream still holds, or drop it where nobody reads it any more, as after
    a terminal has gone: it would fail once more when the interpreter ends, with the status 120."""
    try:
        if stream is not None:
            stream.flush()
    except (OSError, ValueError):
        _forget(stream)


def _forget_output() -> None:
    """Drop what standard output still holds."""
    _forget(sys.stdout)


def _forget(stream: TextIO | None) -> None:
    with contextlib.suppress(OSError, ValueError):
        if stream is not None:
            # the descriptor itself: the interpreter flushes at its end whatever sys.stdout is by
            # then
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def _keep_memory() -> None:
    """Let the C library keep freed memory: giving 2 MB arrays back after every step costs a tenth
    of the time."""
    with contextlib.suppress(OSError, AttributeError, ImportError):
        import ctypes

        trim, mmap = -1, -3  # M_TRIM_THRESHOLD, M_MMAP_THRESHOLD of glibc's mallopt
        library = ctypes.CDLL(None)
        library.mallopt(trim, 1 << 26)
        library.mallopt(mmap, 1 << 26)


def _run(argv: list[str]) -> int:
    if "--version" in argv[: argv.index("--") if "--" in argv else None]:
        print(f"gcomp {__version__}")
        return 0
    if not argv or argv[0] in ("-h", "--help"):
        return _overview(argv)
    name, argv = _command(argv)
    module = _loaded(f"postproc.commands.{name}")
    parser = _parser(name, module, argv)
    handed_on: list[str] = []
    if hasattr(module, "HANDS_ON") and "--" in argv:  # what follows is for another command
        # argparse would take "--" as the end of its own options and keep what follows
        at = argv.index("--")
        argv, handed_on = argv[:at], argv[at + 1 :]
    try:
        options = parser.parse_args(argv)
    except SystemExit as end:
        return int(end.code or 0)
    if hasattr(module, "HANDS_ON"):
        options.handed_on = handed_on
    standing.options(options)
    return module.run(options)


def _command(argv: list[str]) -> tuple[str, list[str]]:
    """The subcommand and its arguments. Raises UsageError for a word that is almost one."""
    if not argv[0].startswith("-") and argv[0] in commands():
        return argv[0], argv[1:]
    _no_slip(argv[0])
    return DEFAULT, argv


def _parser(name: str, module: ModuleType, argv: list[str]) -> argparse.ArgumentParser:
    example = getattr(module, "EXAMPLE", "")
    parser = _Parser(
        prog="gcomp" if name == DEFAULT else f"gcomp {name}",
        description=module.HELP,
        epilog=f"example: {example}" if example else None,
        # the help asks how wide the terminal is, which loads shutil: only where help is shown
        formatter_class=(
            colour.formatter(sys.stdout) if {"-h", "--help"} & set(argv) else colour.Unseen
        ),
    )
    module.arguments(parser)
    return parser


def _loaded(name: str) -> ModuleType:
    """The module `name`. What loads with it stays to the end, so that the collector of cycles need
    not go through it, which takes a tenth of the time of a short program, most of it when the
    process ends."""
    if name in sys.modules:
        return sys.modules[name]
    gc.disable()
    try:
        return importlib.import_module(name)
    finally:
        gc.freeze()
        gc.enable()


def _no_slip(word: str) -> None:
    """Raises UsageError for a first word that is no file and almost a command, or like one."""
    if word.startswith("-") or os.path.exists(word):
        return
    # a plain word that is no file is a command mistyped: a program is hardly ever called so
    near = alike(word, commands())
    if near or re.fullmatch("[a-z]+", word):
        raise UsageError(
            f"there is no program and no command {word}",
            f"did you mean gcomp {near[0]}?" if near else "gcomp --help lists the commands",
        )


def _overview(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(
        prog="gcomp",
        description="makes an inaccurate CNC machine cut accurately, by rewriting its programs",
        formatter_class=colour.formatter(sys.stdout if argv else sys.stderr),
    )
    parser.add_argument("--version", action="store_true", help="say which gcomp this is")
    sub = parser.add_subparsers(metavar="COMMAND")
    for name in commands():
        module = importlib.import_module(f"postproc.commands.{name}")
        sub.add_parser(name, help=module.HELP)
        if name == DEFAULT:
            parser.epilog = f"more: gcomp COMMAND --help; example: {module.EXAMPLE}"
    parser.print_help(sys.stdout if argv else sys.stderr)
    return 0 if argv else REFUSED


def _interrupt(number: int, frame: object) -> None:
    raise KeyboardInterrupt


def _complain(message: str, status: int) -> int:
    with contextlib.suppress(OSError, ValueError):
        colour.fault(message)
    return status
