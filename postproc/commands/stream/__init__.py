"""`gcomp stream job.nc --machine M --port P`: correct and send in one go."""

from __future__ import annotations

import argparse
import contextlib
import sys
import time
from typing import TYPE_CHECKING, NamedTuple

from postproc import ports
from postproc.commands import reading
from postproc.commands.stream.options import arguments as arguments
from postproc.commands.stream.options import can_type, frame, refuse
from postproc.errors import ProgramError, UsageError

REFUSED, INTERRUPTED = 2, 130

if TYPE_CHECKING:
    from postproc.commands.stream.job import Job
    from postproc.commands.stream.port import Port
    from postproc.commands.stream.show import Show
    from postproc.commands.stream.signals import Signals
    from postproc.machine.model import Machine
    from postproc.streaming.events import Status
    from postproc.streaming.greeting import Greeting
    from postproc.streaming.outcome import Outcome
    from postproc.streaming.rates import Load
    from postproc.streaming.sender import Sender

HELP = "correct a program and send it to a controller, with hold, journal and restart"
EXAMPLE = "gcomp stream job.nc --machine my-router --port /dev/ttyUSB0"


def run(options: argparse.Namespace) -> int:
    from postproc.commands.stream import job as jobs
    from postproc.commands.stream import ports_found, report
    from postproc.commands.stream.port import Port
    from postproc.commands.stream.signals import Interrupted, Signals

    if options.list_ports:
        print(ports_found.listed())
        return 0
    report.refuse(options)
    bits = frame(options)
    refuse(options, jobs.is_file(options.file))
    machine = reading.machine_of(options)
    copy = ports.Copy(options.file) if jobs.is_file(options.file) else None
    line, past = jobs.resumed(options, machine, copy) if options.resume_from and copy else (1, None)
    options.port = ports_found.chosen(options.port)
    job = None
    port = Port(
        options.port, options.baud, reset=not options.no_reset_on_open, frame=bits,
        rtscts=options.rtscts,
    )  # fmt: skip
    try:
        with Signals().caught() as signals:
            port.wakes = signals.wakes
            greeting = _greeted(port, options, signals)
            assert greeting.protocol is not None
            from postproc.streaming import live as lives

            live = lives.read(greeting.protocol.controller, greeting.status, machine.letters)
            job = jobs.prepare(options, machine, greeting.protocol, live, copy)
            if options.resume_from:
                line = jobs.zero_is_certain(job, line, past, greeting.restarted)
                jobs.restarted(job, line, past)
            load = _precheck(options, job)
            signals.at_once = None  # from here on the job obeys
            return _passed_and_streamed(options, machine, Link(port, greeting, signals), job, load)
    except Interrupted as why:
        with contextlib.suppress(OSError, ValueError):
            print(f"gcomp: {why}", file=sys.stderr)
        return INTERRUPTED
    except ProgramError as error:
        raise (jobs.with_hint(error, job) if job is not None else error) from None
    finally:
        port.close()


def _passed_and_streamed(
    options: argparse.Namespace, machine: Machine, link: Link, job: Job, load: Load | None
) -> int:
    """First through the controller's check mode where that is wanted, then in earnest."""
    from postproc.commands.stream import first_pass

    if load is not None and first_pass.wanted(options, job, load):
        if status := _dry_run(options, machine, link, job, load):
            return status
        if not options.quiet:
            print(f"gcomp: {first_pass.PASSED}", file=sys.stderr)
        port, greeting, signals = link
        greeted = first_pass.reconnected(port, options, greeting, machine, job, signals)
        link = link._replace(greeting=greeted)
    return _stream(options, machine, link, job, load)


def _greeted(port, options: argparse.Namespace, signals: Signals) -> Greeting:
    """The controller, known and fit for a job. Raises what is wrong with it."""
    from postproc.commands.stream import loop
    from postproc.streaming import protocols
    from postproc.streaming.greeting import AUTO, Greeting, unfit

    if options.protocol != AUTO:
        protocols.load(options.protocol)
    first = (b"$X",) * options.unlock + (b"$H",) * options.home
    greeting = Greeting(
        options.protocol, counting=not options.simple, first=first, port=options.port
    )
    signals.at_once = lambda name: loop.interrupt(port, greeting, name)
    loop.greet(port, greeting)
    assert greeting.protocol is not None
    controller = greeting.protocol.controller
    if options.control_compensates:
        controller.compensates = []
    if fault := unfit(greeting.protocol, greeting.status, options.port):
        raise fault
    if not options.quiet:
        sent = greeting.protocol.confirms == "idle" and not getattr(
            greeting.protocol, "handed", False
        )
        size = f", receive buffer {controller.window} bytes" if sent else ""
        name = f"{controller.name} {controller.version}".rstrip()
        print(f"gcomp: {name}{size}", file=sys.stderr)
        if controller.homing is False:
            print(
                "gcomp: notice: this controller has no homing: its machine coordinates begin where"
                " it was switched on, and the error map lies right only if that was the machine's"
                " zero",
                file=sys.stderr,
            )
    return greeting


class Link(NamedTuple):
    """What a job is sent by: the port, the controller behind it, and the user's signals."""

    port: Port
    greeting: Greeting
    signals: Signals


def _precheck(options: argparse.Namespace, job: Job) -> Load | None:
    """What a job that can be read before will load the wire with; tells what is odd about it. None:
    it comes from a pipe."""
    from postproc.commands.stream import legs
    from postproc.commands.stream.job import is_file

    load = None
    if is_file(options.file) or options.expand:
        # 10 bits a byte on most serial wires, 11 of 7E2; a socket has no rate that is known
        wired = "://" not in options.port or job.protocol.confirms == "nothing"
        bits, parity, stop = frame(options)
        load = legs.precheck(job, options.baud / (1 + bits + (parity != "N") + stop) * wired)
        if load.warning():
            print(f"gcomp: warning: {load.warning()}", file=sys.stderr)
    if not options.quiet:
        for notice in job.notices:
            print(f"gcomp: notice: {notice.message}", file=sys.stderr)
    return load


def _dry_run(
    options: argparse.Namespace, machine: Machine, link: Link, job: Job, load: Load
) -> int:
    """The whole program in the controller's check mode, nothing moving; its exit status."""
    dry = argparse.Namespace(**vars(options))
    dry.check, dry.record, dry.dry = True, None, True
    return _stream(dry, machine, link, job, load)


def _stream(
    options: argparse.Namespace, machine: Machine, link: Link, job: Job, load: Load | None
) -> int:
    """Send it, and say how it ended."""
    from postproc.commands.stream import kept, legs, loop
    from postproc.commands.stream.keys import Keys
    from postproc.commands.stream.prefetch import Prefetch
    from postproc.commands.stream.show import Show
    from postproc.streaming.live import CONTROLLER_AXES
    from postproc.streaming.rates import Clock

    port, greeting, signals = link
    order = tuple(CONTROLLER_AXES.index(x) for x in machine.letters)
    reported = _places(greeting.status)
    sender = _sender(options, job, order)
    with contextlib.ExitStack() as stack:
        trace, record = kept.recording(options, machine, job, order, reported, stack)
        journal = kept.journal_of(options, machine, job, sender.account.holds)
        clock = Clock(load.expected, time.monotonic(), job.pace) if load else None
        keys = Keys() if can_type(options) else None
        letters = tuple(CONTROLLER_AXES[:reported]) or machine.letters
        quiet = options.quiet or _is_dry(options)
        show = Show(sender, clock, load.lines if load else 0, letters, quiet, keys is not None)
        stack.callback(show.close)
        answers = legs.answers_of(job, machine.letters)
        prefetch = Prefetch(lambda: legs.lines(job, answers, options.check)).start()
        run = loop.Run(port, sender, prefetch, show, signals, journal, trace, record, keys, answers)
        try:
            outcome = run.to_the_end()
        finally:
            prefetch.close()
            if answers is not None:
                answers.close()
        _tell(options, machine, job, show, outcome, prefetch.fault)
    return outcome.exit_status or (REFUSED if prefetch.fault is not None else 0)


def _is_dry(options: argparse.Namespace) -> bool:
    """Whether this is the pass before the job."""
    return getattr(options, "dry", False)


def _sender(options: argparse.Namespace, job: Job, order: tuple[int, ...]) -> Sender:
    """What sends the job to a controller that can do what is asked of it. Raises UsageError."""
    from postproc.commands.stream import handed
    from postproc.streaming.path import Path
    from postproc.streaming.sender import Sender

    protocol = job.protocol
    if options.check and not protocol.check_mode():
        raise UsageError(
            f"{protocol.controller.name} has no check mode",
            "--check is for GRBL, grblHAL and FluidNC",
        )
    path = Path(protocol.controller, order) if job.watched() else None
    if handed.wanted(protocol):
        handed.write(options, job, protocol)
    return Sender(
        protocol, on_error=options.on_error, check=options.check, order=order, path=path,
        spindle_off=options.spindle_at_stop == "off",
    )  # fmt: skip


def _places(status: Status | None) -> int:
    """Of how many axes the controller reports the place."""
    return len(status.place) if status is not None and status.place is not None else 0


def _tell(
    options: argparse.Namespace,
    machine: Machine,
    job: Job,
    show: Show,
    outcome: Outcome,
    fault: Exception | None,
) -> None:
    """How it ended, on the terminal and in the report. fault: of reading the program."""
    from postproc.commands.stream import report

    dry = _is_dry(options)
    ends = not dry or outcome.exit_status != 0  # behind a pass that finds nothing the job runs
    before = "nothing has moved: in the controller's check mode, " * dry
    if ends:
        show.tell(before + outcome.text())
    # of a pipe: what came before the fault was sent
    if fault is not None and str(fault) not in outcome.text():
        show.tell(f"the program ended there, because of: {fault}")
    if job.copy and job.copy.changed():
        show.tell(
            f"notice: {options.file} was changed while the job ran; what was sent is the"
            " program as it was when the job began"
        )
    show.end(outcome)
    if (options.report or options.json) and ends:
        fields = show.report(outcome, time.monotonic(), _about(machine, job))
        fields["message"] = before + fields["message"]
        report.write(options, fields, show.history, before + outcome.text())


def _about(machine: Machine, job: Job) -> dict[str, str | None]:
    """What was sent to what, for the report."""
    controller = job.protocol.controller
    return {
        "program": job.name,
        "sha256": job.copy.digest if job.copy else None,
        "machine": machine.name,
        "map": machine.digest,
        "controller": f"{controller.name} {controller.version}",
        "ended": time.strftime("%Y-%m-%dT%H:%M:%S%z"),
    }
