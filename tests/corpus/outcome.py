"""What became of a real program: status, paths, the class of its refusal, and laws that do not
hold."""

from __future__ import annotations

from dataclasses import dataclass, field

NEEDS = "--expand is needed"
REASONS = (  # what a refusal is about, by what its message or advice says; the first that fits
    ("an offset that nobody stated", ("is not stated",)),
    (
        "an axis that the machine has not",
        ("the machine has no axis", "the letter E has no meaning", "ELX is not defined"),
    ),
    (
        "outside of the map or the travel",
        ("outside its table", "beyond the travel", "outside the travel"),
    ),
    (
        "an error in the program itself",
        (
            "the arc misses its own end point",
            "is not text",
            "a comment is opened",
            "words in one block",
            "without its centre words",
            "is not defined in this program",
        ),
    ),
    (NEEDS, ("--expand",)),
)
OTHER = "a construct that is not followed"
FRAGMENT = "not a program for a control"
BROKEN = "an error of gcomp"


@dataclass
class Outcome:
    """What became of a program. um: largest deviation; paths in mm; faults: laws that do not
    hold."""

    status: str = ""  # identical, verified, written (zero map, --expand), refused, broken
    line: int = 0
    message: str = ""
    advice: str = ""
    blocks: int = 0
    motions_in: int = 0
    motions_out: int = 0
    path_in: float = 0.0
    path_out: float = 0.0
    uncorrected: float = 0.0
    corrected: float = 0.0
    notices: list[str] = field(default_factory=list)
    faults: list[str] = field(default_factory=list)
    output: bytes = b""

    @property
    def good(self) -> bool:
        return self.status in ("identical", "verified", "written")

    @property
    def reason(self) -> str:
        """The class of a refusal."""
        if self.status == "broken":
            return BROKEN
        said = f"{self.message}\n{self.advice}"
        return next((name for name, signs in REASONS if any(sign in said for sign in signs)), OTHER)
