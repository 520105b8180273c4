"""The lines of one job in order: the program leg by leg, between them what a tool change sends; and
their checks before the first byte leaves."""

from __future__ import annotations

from collections.abc import Generator, Iterator
from dataclasses import replace

from postproc.commands.stream.job import Job
from postproc.commands.stream.tools import Answers
from postproc.errors import Notice, Place, ProgramError, UsageError
from postproc.filter import Filter
from postproc.streaming import changes, restart, resumable
from postproc.streaming import live as lives
from postproc.streaming.changes import Longer
from postproc.streaming.lines import Unsendable, WireLine
from postproc.streaming.pace import Pace
from postproc.streaming.precheck import M6, NO_MORE
from postproc.streaming.rates import Load

CAN_NOT = "the job can not go on behind this tool change"


def answers_of(job: Job, letters: tuple[str, ...]) -> Answers | None:
    """Who takes what the controller says behind each change; None: it is not asked."""
    if job.macros is None or job.options.check:
        return None
    return Answers(job.protocol.controller, letters)


def lines(job: Job, answers: Answers | None = None, bare: bool = False) -> Iterator[list[WireLine]]:
    """All of a job, batch by batch. answers: of the controller, None: before the job, with the
    zeros of now. bare: without macros and pauses, as in the controller's check mode. Raises
    ProgramError, UsageError."""
    job.sources.clear()
    if job.macros is None:
        return job.leg(job.fresh(), job.begin, job.preamble)
    return _through_changes(job, answers, bare)


def _through_changes(job: Job, answers: Answers | None, bare: bool) -> Iterator[list[WireLine]]:
    """The program leg by leg, between them what each tool change sends."""
    #     leg: preamble, lines up to M6 | OPENING, park, M0, touch off, $# $G | preamble, lines ...
    # Behind the change the zeros may be others: a fresh filter reads on with what the controller
    # says.
    number, begin, live, start = 1, job.begin, job.live, job.start
    preamble: tuple[bytes, ...] | None = tuple(M6.sub(b"M0", x) for x in job.preamble)
    longer = Longer(job.protocol.controller.unit)
    asks = None if bare else answers
    while preamble is not None:
        legs = job.leg(job.fresh(live), begin, preamble, number)
        change, number = yield from _until_change(legs, job, number)
        if change is None:
            return
        if not bare:
            for line in _changed(job, change, number, answers, longer):
                number = line.number + 1
                yield [line]
        live = asks.wait() if asks is not None else live
        begin = change.source + 1
        preamble, moved = _behind(job, job.as_begun(live, start), begin, live)
        # nothing was gone back to: the program goes on from where the change left the machine
        start = start if moved else live.place
        if asks is not None and preamble is not None:
            _recheck(job, live, begin, preamble)


def _until_change(
    legs: Iterator[list[WireLine]], job: Job, number: int
) -> Generator[list[WireLine], None, tuple[WireLine | None, int]]:
    """What comes before a tool change; returns its line, and the number of the next one."""
    for batch in legs:
        kept, change = _cut(batch, job)
        if kept:
            number = kept[-1].number + 1
            yield kept
        if change is not None:
            return change, number
    return None, number


def _cut(batch: list[WireLine], job: Job) -> tuple[list[WireLine], WireLine | None]:
    """What comes before a tool change, and its line."""
    at = next((i for i, line in enumerate(batch) if line.source and M6.search(line.text)), None)
    if at is None:
        return batch, None
    try:
        text = changes.split(batch[at].text)
    except Unsendable as error:
        place = Place(job.name, batch[at].source, batch[at].text.decode("latin-1"))
        raise ProgramError(error.message, error.advice, place) from None
    return batch[:at], replace(batch[at], text=text)


def _changed(
    job: Job, change: WireLine, number: int, answers: Answers | None, longer: Longer
) -> Iterator[WireLine]:
    """The lines of one tool change."""
    assert job.macros is not None
    for name, row, text in changes.steps(change.text, job.macros.park, job.macros.touch):
        if changes.LONGER in text:
            if answers is not None:
                answers.wait()
            text = longer.put(text, answers.said[changes.ZEROS] if answers is not None else None)
        if text == changes.SYNC and answers is not None:
            answers.expect()
        source = row if name else change.source if text == change.text else 0
        yield WireLine(number, source, 0, text, file=name)
        number += 1


def _behind(
    job: Job, filter_: Filter, begin: int, live: lives.Live
) -> tuple[tuple[bytes, ...] | None, bool]:
    """The blocks that bring back what is in force and where the tool was, at a line behind a tool
    change, and whether it had moved before; None: nothing comes any more."""
    assert job.copy is not None
    with job.copy.opened() as stream:
        if not any(number >= begin for number, _ in enumerate(stream, 1)):
            return None, True
    with job.copy.opened() as stream:
        before, rest = restart.read_before(filter_, stream, begin)
    stays = not before.moved
    if not stays:
        resumable.refuse(filter_, rest, begin, CAN_NOT)
    frame = filter_.modal.frame
    z = (
        frame.length[filter_.setup.axes.index("Z")]
        if frame is not None and "Z" in filter_.setup.axes
        else 0
    )
    if abs(z / lives.TICKS_PER_MM - live.length.get("Z", 0.0)) > lives.SAME_MM:
        raise UsageError(
            f"line {begin - 1} changes the tool, and the program has set a tool length before"
            " (G43.1, G49), which is not the new one's",
            "leave tool lengths to --touch-off, and take them out of the program",
        )
    # it has just been put in: the preamble must not change it once more
    before.loaded = ""
    return tuple(restart.preamble(filter_, before, job.safe(), live.place, stays)), before.moved


def _take_notices(job: Job) -> None:
    """Those of the filters that read the program, each once, and what is not sent of it."""
    known = {notice.message for notice in job.notices}
    for notice in (notice for source in job.sources for notice in source.filter.notices):
        if notice.message not in known:
            job.notices.append(notice)
        known.add(notice.message)
    if dropped := max(source.dropped for source in job.sources):
        behind = (
            f"{dropped} lines behind the end of the program are not sent: the controller would"
            " execute them"
        )
        job.notices.append(Notice("behind", behind))


def precheck(job: Job, rate: float) -> Load:
    """The whole program before its first byte leaves. Raises what is wrong with it."""
    load = Load(rate)
    known = job.known = job.checks()
    planner = Pace(job.protocol.controller, job.order(), load.link)
    pace = planner if planner.knows else None
    for line in (line for batch in lines(job) for line in batch):
        load.add(line)
        if job.macros is None or not line.file:
            known.look(line)
        if pace is not None:
            pace.add(line)
    job.notices += known.notices()
    if pace is not None:
        pace.end()
        job.pace, load.expected = pace, pace.total
    _take_notices(job)
    return load


def _recheck(job: Job, live: lives.Live, begin: int, preamble: tuple[bytes, ...]) -> None:
    """The program from a line on, with zeros that were set in between. Raises what is wrong
    with it then."""
    known = job.checks(NO_MORE)
    batches = job.leg(job.fresh(live), begin, preamble)
    for line in (line for batch in batches for line in batch):
        known.look(line)
