"""The options of `gcomp stream`, and which of them do not go together."""

from __future__ import annotations

import argparse
from pathlib import Path

from postproc import standing
from postproc.commands import option_text, port_options, reading, reading_options
from postproc.errors import UsageError

OPTIONS = f"""
--live-temperatures  the log of --temperatures goes on while the job runs: its newest row counts
    when a line is prepared, not the clock
file? FILE  the program; - or nothing: standard input
[the link]
{port_options.PORT}
{port_options.BOARDS}
--baud BAUD  default 115200; of a DNC link, its control's common speed
--frame 7E2  data bits, parity (E, O, N), stop bits; default 8N1; of a DNC link, its control's
    common frame
--rtscts  the wires RTS and CTS say when bytes may leave
--simple  one line at a time: slower, for links that lose bytes
--compact  send no blanks, N words, idle zeros and words in force already
[the job]
--check  dry run in the controller's check mode: list every error, move nothing
--on-error (stop|continue|ask)  when a line is refused: hold and stop (default), go on without it,
    or hold and ask on the terminal
--check-first (auto|always|never)  let the controller read the program in its check mode before it
    moves (default: where that takes seconds)
--tool-change (pause|ignore|refuse)  what becomes of M6: wait there for a person, leave it out, or
    refuse the program (default with GRBL, which has no M6; others get it)
--park FILE  with --tool-change pause, GRBL and its kin: lines to send before the pause, spindle
    and coolant off (G53 G0 Z-5)
--touch-off FILE  lines to send behind the pause (G38.2 Z-20 F50, G10 L20 P0 Z5); then the zeros
    are asked for, the map is put there, and the tool goes back by a safe Z. {{longer}}: mm by which
    the tool touched higher than the job's first
--spindle-at-stop (off|on)  when a job ends in a hold by a fault: stop the spindle, where the
    controller can (default), or let it turn
--home  home the machine first ($H)
--unlock  clear the alarm lock first ($X): the position must be right
--control-compensates  send even though the control compensates by itself
--no-watch  do not look whether the reports lie on the path of the lines in execution
--record FILE  write the reported positions as a recording
--report FILE.html  write what became of the job as a page: times, lines, holds, how it ended, how
    it went on
--json FILE  the same as one JSON object (gcomp-run/1)
--journal FILE  default: the program's name with .journal, in this folder
--no-journal  keep no journal
--resume-from LINE|JOURNAL  begin again with this line, or where a journal ends
--safe-z MM  mills and printers: where Z is safe for --resume-from, machine coordinates (default:
    the highest rapid before the line)
--safe-x MM  lathes, with a tool that cuts outside: where X is clear of the part, machine
    coordinates in radius (default: the farthest rapid before the line, if the program leaves its
    cuts that way)
--yes  send what --resume-from shows without asking
--zero-is-right  for --resume-from: since the job stopped you have made sure that the controller's
    zero is where the job had it
--hand-over FILE  LinuxCNC: where the corrected program is put for it, a path under which both see
    it (default: FILE.handed.ngc in this folder)
--quiet  no progress, no notices
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    reading_options.arguments(parser)
    option_text.add(
        parser, OPTIONS, protocol="auto", baud=int, on_error="stop", check_first="auto",
        spindle_at_stop="off", safe_z=float, safe_x=float,
    )  # fmt: skip


def frame(options: argparse.Namespace) -> tuple[int, str, int]:
    """The frame of a byte on the line; --baud where it was left out. Raises UsageError."""
    from postproc.streaming import protocols
    from postproc.streaming.greeting import AUTO

    link = (
        None
        if options.protocol == AUTO
        else getattr(protocols.load(options.protocol).PROTOCOL, "link", None)
    )
    if options.baud is None:
        options.baud = link.baud if link else 115200
    if options.frame is None:
        return (link.bits, link.parity, link.stop) if link else (8, "N", 1)
    text = options.frame.upper()
    if len(text) != 3 or text[0] not in "78" or text[1] not in "EON" or text[2] not in "12":
        raise UsageError(
            f"--frame {options.frame} is no frame", "data bits, parity, stop bits: 7E2, 7E1, 8N1"
        )
    return int(text[0]), text[1], int(text[2])


def refuse(options: argparse.Namespace, is_file: bool) -> None:
    """Options that do not go together."""
    if options.expand and options.resume_from:
        raise UsageError(
            "--resume-from names a line, and with --expand a line may be executed more than once",
            "write the program out first: gcomp --expand -o plain.nc; then stream that",
        )
    _refuse_changes(options, is_file)
    if options.protocol == "linuxcnc" and not (is_file or options.expand):
        raise UsageError(
            "LinuxCNC takes its program as a whole, and a pipe has no end yet", "name a file"
        )
    if options.record:  # of an earlier job: nothing else holds it
        standing.kept(options.record, False, "another name")
    _refuse_resumed(options, is_file)
    _refuse_errors(options, is_file)
    _refuse_source(options, is_file)
    if options.baud <= 0:
        raise UsageError(f"--baud {options.baud} is no speed")


def _refuse_source(options: argparse.Namespace, is_file: bool) -> None:
    """A program that is not there, or of a language that a pipe can not show."""
    if not is_file and options.dialect == reading.AUTO:
        raise UsageError("--dialect auto looks at the program before it is read: not with a pipe")
    if options.file not in (None, "-") and not Path(options.file).exists():
        raise UsageError(f"{options.file} can not be read: there is no such file")


def _refuse_resumed(options: argparse.Namespace, is_file: bool) -> None:
    """What --resume-from does not go with, and --live-temperatures without its log."""
    if options.resume_from and not is_file:
        raise UsageError("--resume-from needs the program as a file")
    if options.live_temperatures and (options.resume_from or not options.temperatures):
        raise UsageError(
            "--live-temperatures reads the newest row of --temperatures LOG.csv, and knows no"
            " earlier one for --resume-from",
            "--temperatures LOG.csv; for --resume-from without --live-temperatures",
        )


def _refuse_errors(options: argparse.Namespace, is_file: bool) -> None:
    """What --on-error does not go with."""
    if options.on_error == "ask" and not can_type(options):
        raise UsageError(
            (
                "--on-error ask asks on a terminal, and standard input is none"
                if is_file
                else "--on-error ask needs the program as a file"
            ),
            "--on-error stop, or --on-error continue",
        )
    if options.compact and options.on_error != "stop":
        raise UsageError(
            "--compact leaves out words that hold, and after a refused line it is not known what"
            " holds",
            "--on-error stop",
        )


def _refuse_changes(options: argparse.Namespace, is_file: bool) -> None:
    """Options of tool changes, and of safe places, that do not go together."""
    macros = bool(options.park or options.touch_off)
    safe = [x for x in "zx" if getattr(options, f"safe_{x}") is not None]
    if safe and not (options.resume_from or macros):
        raise UsageError(
            f"--safe-{safe[0]} is for --resume-from, and for tool changes with --park or"
            " --touch-off",
            "leave it out",
        )
    if macros:
        _refuse_macros(options, is_file)
        options.tool_change = "pause"


def _refuse_macros(options: argparse.Namespace, is_file: bool) -> None:
    """What does not go with --park and --touch-off."""
    if options.tool_change not in (None, "pause"):
        raise UsageError(
            f"--park and --touch-off are for --tool-change pause, not for {options.tool_change}",
            "leave them out",
        )
    if options.expand or not is_file:
        raise UsageError(
            "--park and --touch-off need the program as a file in which every line is executed"
            " once",
            "write the program out first: gcomp --expand -o plain.nc; then stream that",
        )
    if options.temperatures and not options.live_temperatures:
        raise UsageError(
            "--temperatures follows the clock from the program's start, and how long a person takes"
            " to change a tool is not known",
            "--live-temperatures, with a log that goes on while the job runs",
        )


def can_type(options: argparse.Namespace) -> bool:
    """Whether a person can type while the job runs."""
    from postproc.commands.stream import job as jobs
    from postproc.commands.stream.keys import terminal

    return jobs.is_file(options.file) and terminal()
