"""Every error and notice that a user can meet: where it is, what with its number, and the way
out."""

from __future__ import annotations

from postproc.records import record


@record
class Place:
    """A place in a file. Lines and columns count from 1; `stop` is the column after the last
    one."""

    file: str
    line: int
    text: str = ""
    start: int = 0
    stop: int = 0

    def __str__(self) -> str:
        return f"{self.file}:{self.line}"

    def picture(self) -> str:
        """The line with the columns marked below it, or nothing where the columns are not known."""
        if not self.text:
            return ""
        shown = "".join(
            c if c.isprintable() else " " if c == "\t" else "?" for c in self.text.rstrip("\r\n")
        )
        # a line may have a million characters: 60 before the place, and 60 from it on, are shown
        lead = max(0, self.start - 60)
        shown = ("..." if lead else "") + shown[lead : lead + 120]
        if not self.stop:
            return f"\n    {shown}"
        # columns count from 1; "..." has taken three places
        at = self.start - 1 - lead + (3 if lead else 0)
        return f"\n    {shown}\n    {' ' * at}{'^' * max(1, min(self.stop - self.start, 120))}"


def _one_line(text: str) -> str:
    """The sentence without line ends: text of a file may stand in it."""
    return " ".join(text.splitlines())


class GcompError(Exception):
    """What stops gcomp. `message` is a fact with its number, `advice` the way out, `place` where it
    is, if anywhere."""

    def __init__(self, message: str, advice: str = "", place: Place | None = None):
        super().__init__(message)
        self.message, self.advice, self.place = message, advice, place

    def __str__(self) -> str:
        """Four lines at most: what and where, the line, the columns, the way out."""
        where = f"{self.place}: " if self.place else ""
        picture = self.place.picture() if self.place else ""
        advice = f"\n    {_one_line(self.advice)}" if self.advice else ""
        return f"{where}{_one_line(self.message)}{picture}{advice}"


class ProgramError(GcompError):
    """The NC program can not be followed or compensated. `delivered`: the corrected text of all
    blocks before."""

    delivered: bytes = b""


class MachineError(GcompError):
    """The machine folder is not one that can be trusted."""


class UsageError(GcompError):
    """The command line asks for something that is not there."""


class BlockFault(Exception):
    """A block that can not go on; raised by layers that know blocks by number, not by file and
    line.

    `block` counts within the batch; `start` and `stop` are offsets into the batch's text (0, 0: the
    whole block).
    """

    def __init__(self, block: int, message: str, advice: str = "", start: int = 0, stop: int = 0):
        super().__init__(message)
        self.block = block
        self.message = message
        self.advice = advice
        self.start = start
        self.stop = stop


class MotionFault(Exception):
    """A motion that the physics refuses; `motion` counts within the batch."""

    def __init__(self, motion: int, message: str, advice: str = ""):
        super().__init__(message)
        self.motion, self.message, self.advice = motion, message, advice


@record
class Notice:
    """Something the user should know that stops nothing."""

    code: str
    message: str
    line: int = 0
    size: float = 0.0  # of several of one code the largest is told
    # message and way out, if it turns out that nothing else could be done
    refusal: tuple[str, str] = ("", "")
    # of several of one code the sums are told, in the message's {0}, {1}...
    counts: tuple[int, ...] = ()

    def counted(self) -> str:
        """The message with its sums; a part between semicolons whose sums are all 0 is not said."""
        every = [f"{{{k}}}" for k in range(len(self.counts))]
        some = {holder for holder, n in zip(every, self.counts, strict=True) if n}
        said = [
            part
            for part in self.message.split("; ")
            # a part without sums is always said
            if not (held := {holder for holder in every if holder in part}) or held & some
        ]
        return "; ".join(said).format(*self.counts)
