"""`gcomp stream job.nc --machine M --port P`: correct and send in one go."""

from __future__ import annotations

import argparse
import contextlib
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

from postproc import ports
from postproc.commands import reading
from postproc.errors import ProgramError, UsageError

REFUSED, INTERRUPTED = 2, 130
CHECK_SECONDS, CHECK_SHARE = 10.0, 0.05  # that a check pass may take on the wire, s, or of the job

if TYPE_CHECKING:
    from postproc.commands.stream.job import Job
    from postproc.commands.stream.signals import Signals
    from postproc.streaming.greeting import Greeting
    from postproc.streaming.rates import Load

HELP = "correct a program and send it to a controller, with hold, journal and restart"
EXAMPLE = "gcomp stream job.nc --machine my-router --port /dev/ttyUSB0"


def arguments(parser: argparse.ArgumentParser) -> None:
    reading.arguments(parser)
    parser.add_argument(
        "--live-temperatures", action="store_true",
        help="the log of --temperatures goes on while the job runs: its newest row counts when a line is prepared, not the clock",
    )  # fmt: skip
    link = parser.add_argument_group("the link")
    link.add_argument(
        "--port",
        metavar="PORT",
        help="/dev/ttyUSB0, COM3, socket://host:port, rfc2217://host:port; auto: the only one there is",
    )
    link.add_argument(
        "--list-ports",
        action="store_true",
        help="the serial ports of this computer, with what is plugged in",
    )
    link.add_argument(
        "--baud", type=int, help="default 115200; of a DNC link, its control's common speed"
    )
    link.add_argument(
        "--frame",
        metavar="7E2",
        help="data bits, parity (E, O, N), stop bits; default 8N1; of a DNC link, its control's common frame",
    )
    link.add_argument(
        "--rtscts", action="store_true", help="the wires RTS and CTS say when bytes may leave"
    )
    link.add_argument(
        "--protocol",
        default="auto",
        metavar="NAME",
        help="default auto: by what the controller says",
    )
    link.add_argument(
        "--simple",
        action="store_true",
        help="one line at a time: slower, for links that lose bytes",
    )
    link.add_argument(
        "--compact",
        action="store_true",
        help="send no blanks, N words, idle zeros and words in force already",
    )
    link.add_argument(
        "--no-reset-on-open",
        action="store_true",
        help="keep DTR low, so that the board is not restarted",
    )
    job = parser.add_argument_group("the job")
    job.add_argument(
        "--check",
        action="store_true",
        help="dry run in the controller's check mode: list every error, move nothing",
    )
    job.add_argument(
        "--on-error",
        choices=("stop", "continue", "ask"),
        default="stop",
        help="when a line is refused: hold and stop (default), go on without it, or hold and ask on the terminal",
    )
    job.add_argument(
        "--check-first",
        choices=("auto", "always", "never"),
        default="auto",
        help="let the controller read the program in its check mode before it moves (default: where that takes seconds)",
    )
    job.add_argument(
        "--tool-change",
        choices=("pause", "ignore", "refuse"),
        help="what becomes of M6: wait there for a person, leave it out, or refuse the program (default with GRBL, which has no M6; others get it)",
    )
    job.add_argument(
        "--park",
        metavar="FILE",
        help="with --tool-change pause, GRBL and its kin: lines to send before the pause, spindle and coolant off (G53 G0 Z-5)",
    )
    job.add_argument(
        "--touch-off",
        metavar="FILE",
        help="lines to send behind the pause (G38.2 Z-20 F50, G10 L20 P0 Z5); then the zeros are asked for, the map is put there, and the tool "
        "goes back by a safe Z. {longer}: mm by which the tool touched higher than the job's first",
    )
    job.add_argument(
        "--spindle-at-stop",
        choices=("off", "on"),
        default="off",
        help="when a job ends in a hold by a fault: stop the spindle, where the controller can (default), or let it turn",
    )
    job.add_argument("--home", action="store_true", help="home the machine first ($H)")
    job.add_argument(
        "--unlock",
        action="store_true",
        help="clear the alarm lock first ($X): the position must be right",
    )
    job.add_argument(
        "--control-compensates",
        action="store_true",
        help="send even though the control compensates by itself",
    )
    job.add_argument(
        "--no-watch",
        action="store_true",
        help="do not look whether the reports lie on the path of the lines in execution",
    )
    job.add_argument("--record", metavar="FILE", help="write the reported positions as a recording")
    job.add_argument(
        "--report",
        metavar="FILE.html",
        help="write what became of the job as a page: times, lines, holds, how it ended, how it went on",
    )
    job.add_argument("--json", metavar="FILE", help="the same as one JSON object (gcomp-run/1)")
    job.add_argument(
        "--journal",
        metavar="FILE",
        help="default: the program's name with .journal, in this folder",
    )
    job.add_argument("--no-journal", action="store_true", help="keep no journal")
    job.add_argument(
        "--resume-from",
        metavar="LINE|JOURNAL",
        help="begin again with this line, or where a journal ends",
    )
    job.add_argument(
        "--safe-z",
        type=float,
        metavar="MM",
        help="mills and printers: where Z is safe for --resume-from, machine coordinates (default: the highest rapid before the line)",
    )
    job.add_argument(
        "--safe-x",
        type=float,
        metavar="MM",
        help="lathes, with a tool that cuts outside: where X is clear of the part, machine coordinates in radius (default: the "
        "farthest rapid before the line, if the program leaves its cuts that way)",
    )
    job.add_argument(
        "--yes", action="store_true", help="send what --resume-from shows without asking"
    )
    job.add_argument(
        "--zero-is-right",
        action="store_true",
        help="for --resume-from: since the job stopped you have made sure that the controller's zero is where the job had it",
    )
    job.add_argument(
        "--hand-over",
        metavar="FILE",
        help="LinuxCNC: where the corrected program is put for it, a path under which both see it (default: FILE.handed.ngc in this "
        "folder)",
    )
    job.add_argument("--quiet", action="store_true", help="no progress, no notices")
    parser.add_argument(
        "file", nargs="?", metavar="FILE", help="the program; - or nothing: standard input"
    )


def run(options: argparse.Namespace) -> int:
    from postproc.commands.stream import job as jobs
    from postproc.commands.stream import ports_found, told
    from postproc.commands.stream.port import Port
    from postproc.commands.stream.signals import Interrupted, Signals

    if options.list_ports:
        print(ports_found.listed())
        return 0
    told.refuse(options)
    frame = _line(options)
    _refuse(options, jobs.is_file(options.file))
    machine = reading.machine_of(options)
    copy = ports.Copy(options.file) if jobs.is_file(options.file) else None
    line, past = jobs.resumed(options, machine, copy) if options.resume_from and copy else (1, None)
    options.port = ports_found.chosen(options.port)
    job = None
    port = Port(
        options.port,
        options.baud,
        reset=not options.no_reset_on_open,
        frame=frame,
        rtscts=options.rtscts,
    )
    try:
        with Signals().caught() as signals:
            greeting = _greeted(port, options, signals)
            assert greeting.protocol is not None
            from postproc.streaming import live as lives

            live = lives.read(greeting.protocol.controller, greeting.status, machine.letters)
            job = jobs.prepare(options, machine, greeting.protocol, live, copy)
            if options.resume_from:
                line = jobs.zero_is_certain(job, line, past, greeting.restarted)
                jobs.restarted(job, line)
            load = None
            if jobs.is_file(options.file) or options.expand:
                load = job.precheck(0.0 if "://" in options.port else options.baud / 10)
                if load.warning():
                    print(f"gcomp: warning: {load.warning()}", file=sys.stderr)
            if not options.quiet:
                for notice in job.notices:
                    print(f"gcomp: notice: {notice.message}", file=sys.stderr)
            signals.at_once = None  # from here on the job obeys
            if load is not None and _check_first(options, job, load):
                status = _dry_run(options, machine, port, greeting, job, load, signals)
                if status:
                    return status
                greeting = _again(port, options, greeting, machine, job, signals)
            return _stream(options, machine, port, greeting, job, load, signals)
    except Interrupted as why:
        with contextlib.suppress(OSError, ValueError):
            print(f"gcomp: {why}", file=sys.stderr)
        return INTERRUPTED
    except ProgramError as error:
        raise (jobs.with_hint(error, job) if job is not None else error) from None
    finally:
        port.close()


def _line(options: argparse.Namespace) -> tuple[int, str, int]:
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


def _refuse(options: argparse.Namespace, is_file: bool) -> None:
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
    if options.resume_from and not is_file:
        raise UsageError("--resume-from needs the program as a file")
    if options.live_temperatures and (options.resume_from or not options.temperatures):
        raise UsageError(
            "--live-temperatures reads the newest row of --temperatures LOG.csv, and knows no earlier one for --resume-from",
            "--temperatures LOG.csv; for --resume-from without --live-temperatures",
        )
    if options.on_error == "ask" and not _keys(options):
        raise UsageError(
            "--on-error ask asks on a terminal, and standard input is none"
            if is_file
            else "--on-error ask needs the program as a file",
            "--on-error stop, or --on-error continue",
        )
    if options.compact and options.on_error != "stop":
        raise UsageError(
            "--compact leaves out words that hold, and after a refused line it is not known what holds",
            "--on-error stop",
        )
    if not is_file and options.dialect == reading.AUTO:
        raise UsageError("--dialect auto looks at the program before it is read: not with a pipe")
    if options.file not in (None, "-") and not Path(options.file).exists():
        raise UsageError(f"{options.file} can not be read: there is no such file")
    if options.baud <= 0:
        raise UsageError(f"--baud {options.baud} is no speed")


def _refuse_changes(options: argparse.Namespace, is_file: bool) -> None:
    """Options of tool changes, and of safe places, that do not go together."""
    macros = bool(options.park or options.touch_off)
    for name in ("safe_z", "safe_x"):
        if getattr(options, name) is not None and not (options.resume_from or macros):
            raise UsageError(
                f"--{name.replace('_', '-')} is for --resume-from, and for tool changes with --park or --touch-off",
                "leave it out",
            )
    if not macros:
        return
    if options.tool_change not in (None, "pause"):
        raise UsageError(
            f"--park and --touch-off are for --tool-change pause, not for {options.tool_change}",
            "leave them out",
        )
    if options.expand or not is_file:
        raise UsageError(
            "--park and --touch-off need the program as a file in which every line is executed once",
            "write the program out first: gcomp --expand -o plain.nc; then stream that",
        )
    if options.temperatures and not options.live_temperatures:
        raise UsageError(
            "--temperatures follows the clock from the program's start, and how long a person takes to change a tool is not known",
            "--live-temperatures, with a log that goes on while the job runs",
        )
    options.tool_change = "pause"


def _keys(options: argparse.Namespace) -> bool:
    """Whether a person can type while the job runs."""
    from postproc.commands.stream import job as jobs
    from postproc.commands.stream.keys import terminal

    return jobs.is_file(options.file) and terminal()


def _greeted(port, options: argparse.Namespace, signals: Signals) -> Greeting:
    """The controller, known and fit for a job. Raises what is wrong with it."""
    from postproc.commands.stream import loop
    from postproc.streaming import protocols
    from postproc.streaming.greeting import AUTO, Greeting, unfit

    if options.protocol != AUTO:
        protocols.load(options.protocol)
    first = (b"$X",) * options.unlock + (b"$H",) * options.home
    greeting = Greeting(options.protocol, counting=not options.simple, first=first)
    signals.at_once = lambda name: loop.interrupt(port, greeting, name)
    loop.greet(port, greeting)
    assert greeting.protocol is not None
    controller = greeting.protocol.controller
    if options.control_compensates:
        controller.compensates = []
    fault = unfit(greeting.protocol, greeting.status)
    if fault:
        raise fault
    if not options.quiet:
        sent = greeting.protocol.confirms == "idle" and not getattr(
            greeting.protocol, "handed", False
        )
        size = f", receive buffer {controller.window} bytes" if sent else ""
        print(f"gcomp: {controller.name} {controller.version}{size}", file=sys.stderr)
        if controller.homing is False:
            print(
                "gcomp: notice: this controller has no homing: its machine coordinates begin where it was switched on, and the error "
                "map lies right only if that was the machine's zero", file=sys.stderr,
            )  # fmt: skip
    return greeting


def _check_first(options: argparse.Namespace, job: Job, load: Load) -> bool:
    """Whether the controller shall read the program in its check mode before the job."""
    assert job.known is not None
    how = options.check_first
    if how == "never" or options.check or not job.protocol.check_mode():
        return False
    checkable = (
        job.known.checkable() and not any(job.live.length.values()) and "G92" not in job.live.work
    )
    if how == "always" and not checkable:
        raise UsageError(
            "a pass in check mode ends in a reset, which would drop a G92, a tool length or modes that are in force now, and the program's own "
            "settings (G10, G28.1) would be stored in it",
            "--check-first never",
        )
    seconds = load.bytes / load.rate if load.rate else 0.0
    return checkable and (
        how == "always" or seconds <= max(CHECK_SECONDS, CHECK_SHARE * load.expected)
    )


def _dry_run(
    options: argparse.Namespace,
    machine,
    port,
    greeting: Greeting,
    job: Job,
    load: Load,
    signals: Signals,
) -> int:
    """The whole program in the controller's check mode, nothing moving; its exit status."""
    dry = argparse.Namespace(**vars(options))
    dry.check, dry.record, dry.dry = True, None, True
    return _stream(dry, machine, port, greeting, job, load, signals)


def _again(
    port, options: argparse.Namespace, greeting: Greeting, machine, job: Job, signals: Signals
) -> Greeting:
    """The controller behind its check, which ends in a reset: the same zeros and modes as before. Raises UsageError."""
    from postproc.commands.stream import loop
    from postproc.streaming import live as lives
    from postproc.streaming.greeting import Greeting

    greeted = Greeting(greeting.found[0], counting=not options.simple)
    signals.at_once = lambda name: loop.interrupt(port, greeted, name)
    loop.greet(port, greeted)
    assert greeted.protocol is not None
    now = lives.read(greeted.protocol.controller, greeted.status, machine.letters)
    if (now.work, now.length, now.place, set(now.modal)) != (
        job.live.work,
        job.live.length,
        job.live.place,
        set(job.live.modal),
    ):
        raise UsageError(
            "after the check pass, and the reset with which it ends, the controller's zeros, modes or place are not what they were: "
            f"{' '.join(now.modal)} {now.work} {now.place}, before {' '.join(job.live.modal)} {job.live.work} {job.live.place}",
            "start the job again, or --check-first never",
        )
    job.protocol = greeted.protocol
    signals.at_once = None
    return greeted


def _stream(
    options: argparse.Namespace,
    machine,
    port,
    greeting: Greeting,
    job: Job,
    load: Load | None,
    signals: Signals,
) -> int:
    """Send it, and say how it ended."""
    from postproc.commands.stream import handed, kept, loop, told, tools
    from postproc.commands.stream.keys import Keys
    from postproc.commands.stream.prefetch import Prefetch
    from postproc.commands.stream.show import Show
    from postproc.streaming.live import CONTROLLER_AXES
    from postproc.streaming.path import Path as Way
    from postproc.streaming.rates import Clock
    from postproc.streaming.sender import Sender

    assert greeting.protocol is not None
    controller = greeting.protocol.controller
    order = tuple(CONTROLLER_AXES.index(x) for x in machine.letters)
    reported = len(greeting.status.place) if greeting.status and greeting.status.place else 0
    if options.check and not greeting.protocol.check_mode():
        raise UsageError(
            f"{controller.name} has no check mode", "--check is for GRBL, grblHAL and FluidNC"
        )
    path = Way(controller, order) if job.watched() else None
    if handed.wanted(greeting.protocol):
        handed.write(options, job, greeting.protocol)
    sender = Sender(
        greeting.protocol,
        on_error=options.on_error,
        check=options.check,
        order=order,
        path=path,
        spindle_off=options.spindle_at_stop == "off",
    )
    with contextlib.ExitStack() as stack:
        trace, record = kept.recording(options, machine, job, order, reported, stack)
        journal = kept.journal_of(options, machine, job, sender.account.holds)
        clock = Clock(load.expected, time.monotonic(), job.pace) if load else None
        keys = Keys() if _keys(options) else None
        letters = tuple(CONTROLLER_AXES[:reported]) or machine.letters
        quiet = options.quiet or getattr(options, "dry", False)
        show = Show(sender, clock, load.lines if load else 0, letters, quiet, keys is not None)
        stack.callback(show.close)
        answers = (
            None
            if job.macros is None or options.check
            else tools.Answers(controller, machine.letters)
        )
        prefetch = Prefetch(lambda: job.lines(answers, options.check)).start()
        run = loop.Run(port, sender, prefetch, show, signals, journal, trace, record, keys, answers)
        try:
            outcome = run.to_the_end()
        finally:
            prefetch.close()
            if answers is not None:
                answers.close()
        dry = getattr(options, "dry", False)
        if not dry or outcome.exit_status:
            show.tell(
                ("nothing has moved: in the controller's check mode, " if dry else "")
                + outcome.text()
            )
        if prefetch.fault is not None:  # of a pipe: what came before the fault was sent
            show.tell(f"the program ended there, because of: {prefetch.fault}")
        if job.copy and job.copy.changed():
            show.tell(
                f"notice: {options.file} was changed while the job ran; what was sent is the program as it was when the job began"
            )
        if (options.report or options.json) and not dry:
            about = {
                "program": job.name, "sha256": job.copy.digest if job.copy else None, "machine": machine.name, "map": machine.digest,
                "controller": f"{controller.name} {controller.version}", "ended": time.strftime("%Y-%m-%dT%H:%M:%S%z"),
            }  # fmt: skip
            told.write(options, show.report(outcome, time.monotonic(), about), show.history)
        show.end(outcome)
    if prefetch.fault is not None:
        return outcome.exit_status or REFUSED
    return outcome.exit_status
