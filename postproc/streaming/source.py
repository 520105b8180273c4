"""Program text through the filter, as lines for the wire that know where they come from.

The filter may be fed in any pieces (tests hold it to that), so batches of whole lines serve speed
only. Which output line belongs to which source line is counted: a source line gives itself, and one
line behind it for every piece put in.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from postproc import marks
from postproc.errors import GcompError, Place, ProgramError
from postproc.filter import Filter
from postproc.motions import FOREIGN, LINES, RAPID, Motions
from postproc.nc import pace
from postproc.nc.lexer import Words, lex
from postproc.pieces import Pieces
from postproc.streaming.lines import Unsendable, WireLine
from postproc.units import TICKS_PER_MM

BATCH = 64  # lines
RAPID_MM_MIN = 3000.0  # where neither machine nor controller says how fast a rapid is
# where it ends is not known
LOST = re.compile(rb"G0*(28|30)(?![0-9.])|G0*38\.|^\$[HJ]", re.IGNORECASE)
DWELL = re.compile(rb"G0*4(?![0-9.])", re.IGNORECASE)
COMMENT = re.compile(rb"\([^()\n]*\)|;[^\n]*")


class Source:
    """feed(bytes) and finish() give wire lines. `prepare` is the protocol's; `shorten` makes a
    line's words shorter.

    rapid: mm/min of rapids. sampled: mm by which chords may miss an arc, 0: arcs come without
    points.
    number: of the next wire line. dropped: source lines with words behind the end of the program,
    which are not sent.
    """

    def __init__(
        self,
        filter_: Filter,
        prepare: Callable[[bytes], bytes],
        shorten: Callable[[bytes], bytes] | None = None,
        rapid: float = RAPID_MM_MIN,
        sampled: float = 0.0,
    ):
        self.filter, self.prepare, self.shorten = filter_, prepare, shorten
        self.rapid, self.sampled = rapid, sampled
        self.number = 1
        self.dropped = 0
        self.ended = False
        self.delivered: list[WireLine] = []
        self._rest = b""
        self._seen: list[tuple[Words, Motions, Pieces, bytes, int]] = []
        known = filter_.modal.known.tolist()
        place = (filter_.modal.position / TICKS_PER_MM).tolist()
        self._end: tuple[float, ...] = tuple(
            v if k else math.nan for k, v in zip(known, place, strict=True)
        )
        ends = "|".join(map(str, filter_.dialect.ends))
        self._ends = (
            re.compile(rf"(?<![A-Z])M0*(?:{ends})(?![0-9.])".encode(), re.IGNORECASE)
            if ends
            else None
        )
        filter_.watchers.append(lambda *seen: self._seen.append(seen))

    def feed(self, data: bytes) -> list[WireLine]:
        """Wire lines of all whole lines so far. Raises ProgramError, Unsendable."""
        # A line that has not ended may go on: what is behind the last line end waits.
        end = data.rfind(b"\n") + 1
        if not end:
            self._rest += data
            return []
        text, self._rest = self._rest + data[:end], data[end:]
        lines: list[WireLine] = []
        try:
            for batch in _batches(text):
                lines += self._batch(batch)
        except ProgramError:
            self.delivered = lines + self.delivered
            raise
        return lines

    def finish(self) -> list[WireLine]:
        """Wire lines of what is left at the end of the input."""
        text, self._rest = self._rest, b""
        return self._batch(text) if text else []

    def _seen_lines(self) -> list[WireLine]:
        """Wire lines of what the filter has passed on since it was asked."""
        seen, self._seen[:] = list(self._seen), []
        return [line for one in seen for line in self._of_pass(*one)]

    def _line_by_line(self, text: bytes) -> list[WireLine]:
        """A batch in which the program may end."""
        single: list[WireLine] = []
        try:
            for row in text.splitlines(keepends=True):
                single += self._batch(row)
        except ProgramError:
            self.delivered = single + self.delivered
            raise
        return single

    def _batch(self, text: bytes) -> list[WireLine]:
        if self.ended:
            self.dropped += sum(map(self._says, text.split(b"\n")))
            self.filter.summary.lines += text.count(b"\n")
            return []
        if text.count(b"\n") > 1 and (b"%" in text or (self._ends and self._ends.search(text))):
            return self._line_by_line(text)
        first = self.filter.summary.lines
        self._seen.clear()
        try:
            out = (
                self.filter.feed(text)
                if text.endswith(b"\n")
                else self.filter.feed(text) + self.filter.finish()
            )
        except ProgramError:
            self.delivered = self._seen_lines()
            raise
        if not self._seen:  # "%": nothing a watcher sees
            return self._lines(out.split(b"\n"), [first + 1] * (out.count(b"\n") + 1))
        return self._seen_lines()

    def _of_pass(
        self, words: Words, motions: Motions, pieces: Pieces, output: bytes, before: int
    ) -> list[WireLine]:
        """Wire lines of one batch of the filter; `before`: lines handled before it."""
        n = words.text.count(b"\n") + (not words.text.endswith(b"\n"))
        texts = output.split(b"\n")
        if output.endswith(b"\n"):
            texts.pop()
        #     source line    12                 13       14
        #     pieces         a  a  a            -        b  b         of motions a and b
        #     first          1  0  0                     1  0
        #     added          2                  0        1            lines put in behind the block
        #     output lines   12 12 12           13       14 14
        first = np.concatenate([[True], pieces.motion[1:] != pieces.motion[:-1]])[: len(pieces)]
        line = words.line[motions.block[pieces.motion]] if len(pieces) else np.zeros(0, np.int64)
        added = np.bincount(line[~first], minlength=n)
        source = np.repeat(np.arange(n), 1 + added)
        own = list(range(len(texts)))
        # gcomp's mark stands before the first block that was changed
        if len(texts) == len(source) + 1:
            mark = next(i for i, text in enumerate(texts) if marks.PROGRAM[0].search(text))
            own.pop(mark)
            texts.pop(mark)
        if len(texts) != len(source):
            raise GcompError(
                f"{len(source)} lines were expected for lines {before + 1} to {before + n}, and the"
                f" filter wrote {len(texts)}: which came from which is not certain",
                "this is an error of gcomp: please report the program; gcomp -o FILE writes it"
                " without streaming",
            )
        slots: dict[tuple[int, int], int] = {}
        count = np.zeros(n, np.int64)
        for i in range(len(pieces)):
            k = int(line[i])
            count[k] += not first[i]
            slots[k + before + 1, int(count[k])] = i
        values = _Values(self, motions, pieces, slots) if slots else None
        return self._lines(texts, (source + before + 1).tolist(), values)

    def _lines(
        self, texts: list[bytes], source: list[int], values: _Values | None = None
    ) -> list[WireLine]:
        result = []
        previous, piece = 0, 0
        for text, k in zip(texts, source, strict=True):
            piece = piece + 1 if k == previous else 0
            previous = k
            if self.ended:
                self.dropped += self._says(text)
            elif wire := self._wire(text, k):
                worth = {"end": self._end} | (values.of(k, piece) if values else {})
                result.append(self._planned(WireLine(self.number, k, piece, wire, **worth)))
                self._end = result[-1].end
                self.number += 1
                self.ended = bool(self._ends and b"M" in wire.upper() and self._ends.search(wire))
        return result

    def _planned(self, line: WireLine) -> WireLine:
        """The line with the time that it waits, and without a place that is not known behind it."""
        wire = line.text.upper()
        if b"G" not in wire and b"$" not in wire:
            return line
        seconds = line.seconds + (self._rest_s(line.text) if DWELL.search(wire) else 0.0)
        return replace(line, end=() if LOST.search(wire) else line.end, seconds=seconds)

    def _rest_s(self, wire: bytes) -> float:
        """How long the dwells of a line rest, in the letters and units of the dialect (Marlin: P in
        ms, S in s); 0 where that is not known."""
        words = lex(wire + b"\n", self.filter.dialect.grammar)
        rests = [pace.seconds(words, block, self.filter.dialect) for block in pace.dwells(words)]
        return sum(rest for rest in rests if not math.isnan(rest))

    def _wire(self, text: bytes, source: int) -> bytes:
        """The line as it is sent. Raises Unsendable with its place."""
        if self.filter.setup.block_delete and text.lstrip().startswith(b"/"):
            return b""
        try:
            wire = self.prepare(text)
            return self.shorten(wire) if wire and self.shorten else wire
        except Unsendable as error:
            place = Place(self.filter.name, source, text.decode("latin-1"))
            raise ProgramError(error.message, error.advice, place) from None

    @staticmethod
    def _says(line: bytes) -> bool:
        return bool(COMMENT.sub(b"", line).strip(b" \t\r\n%"))


class _Values:
    """What pieces are worth, worked out for a whole batch. slots: source line and its piece to the
    index of a piece of motion."""

    def __init__(self, source: Source, motions: Motions, pieces: Pieces, slots: dict[Any, Any]):
        # (A, P) mm by axis and piece; NaN where an end is not known, 0 where nothing was corrected
        known = motions.target_known[:, pieces.motion]
        self.end = np.where(known, pieces.end / TICKS_PER_MM, np.nan)
        self.correction = np.where(known, (pieces.end - pieces.nominal) / TICKS_PER_MM, 0.0)
        delta = np.where(
            known & motions.start_known[:, pieces.motion],
            (pieces.end - pieces.start) / TICKS_PER_MM,
            0.0,
        )
        length = np.linalg.norm(delta, axis=0)
        arc = pieces.arc >= 0
        if arc.any():
            row = pieces.arc[arc]
            along = motions.arcs.radius[row] * np.abs(motions.arcs.sweep[row]) * pieces.share[arc]
            # Of a helix: along the circle in its plane, and across it what all other axes go.
            depth = delta[:, arc].copy()
            at = np.arange(len(row))
            depth[motions.arcs.first[row], at] = depth[motions.arcs.second[row], at] = 0.0
            length[arc] = np.hypot(along, np.linalg.norm(depth, axis=0))
        motion = pieces.motion
        feed = (motions.feed * pace.unit_of_feed(motions))[motion]
        feed = np.where((pieces.code == RAPID) | ~(feed > 0), source.rapid, feed)
        # G93: F is one over minutes for the whole block, of which a piece takes its share
        timed = motions.inverse[motion] & (pieces.code != RAPID) & (motions.feed[motion] > 0)
        seconds = length / feed * 60.0
        seconds = np.where(
            timed,
            np.maximum(pieces.share, 0) * 60.0 / np.where(timed, motions.feed[motion], 1.0),
            seconds,
        )
        known_code = motions.code[motion] != FOREIGN
        self.length, self.seconds = length, np.where(known_code, seconds, 0.0)
        self.end[:, ~known_code] = np.nan
        self.source, self.motions, self.pieces, self.slots = source, motions, pieces, slots
        self.ends, self.corrections = self.end.T.tolist(), self.correction.T.tolist()

    def of(self, line: int, piece: int) -> dict[str, Any]:
        """What a wire line says of its motion; {} where it has none."""
        i = self.slots.get((line, piece))
        if i is None:
            return {}
        arc = self.pieces.arc[i] >= 0
        points = self.points(i) if self.source.sampled and arc else ()
        straight = bool(self.source.sampled) if arc else int(self.pieces.code[i]) in LINES
        return {
            "end": tuple(self.ends[i]), "correction": tuple(self.corrections[i]),
            "length": float(self.length[i]), "seconds": float(self.seconds[i]), "points": points,
            "straight": straight,
        }  # fmt: skip

    def points(self, i: int) -> tuple[tuple[float, ...], ...]:
        """Places on an arc between its ends."""
        p, arcs, row = self.pieces, self.motions.arcs, int(self.pieces.arc[i])
        start = p.start[:, i] / TICKS_PER_MM
        end = p.end[:, i] / TICKS_PER_MM
        first, second = int(arcs.first[row]), int(arcs.second[row])
        centre = start[[first, second]] + p.centre[:, i] / TICKS_PER_MM
        radius = float(np.hypot(*(start[[first, second]] - centre)))
        sweep = float(arcs.sweep[row] * p.share[i])
        if radius <= self.source.sampled:
            return ()
        # A chord over an angle a of radius r misses the arc by r (1 - cos(a / 2)), about r a^2 / 8:
        # by `sampled` where a = 2 sqrt(2 sampled / r).
        n = min(2000, int(np.ceil(abs(sweep) / (2 * np.sqrt(2 * self.source.sampled / radius)))))
        t = np.arange(1, n) / max(n, 1)
        begin = np.arctan2(start[second] - centre[1], start[first] - centre[0])
        places = start[:, None] + (end - start)[:, None] * t
        places[first] = centre[0] + radius * np.cos(begin + sweep * t)
        places[second] = centre[1] + radius * np.sin(begin + sweep * t)
        return tuple(map(tuple, places.T.tolist()))


def _batches(text: bytes) -> Iterator[bytes]:
    """Pieces of so many whole lines."""
    start = 0
    while start < len(text):
        stop = start
        for _ in range(BATCH):
            stop = text.find(b"\n", stop) + 1
            if not stop:
                stop = len(text)
                break
        yield text[start:stop]
        start = stop
