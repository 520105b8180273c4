"""Register of textbook forms: effect name -> list of (form, family, function).

Eight families of kinds: "open" to development; "held" back from it, until a trial has shown them;
"fresh", "sealed", "unseen", "later" and "apart", whose cases were looked at after trials;
"distant", of which trials show figures alone. A case draws from its own family and from the open
one; one of the last three draws its forms, noises, aliens and plans from its own alone (what rounds
a reading, a gross error and the tests of the tier "blind" are the frame's). Forms, noises and
aliens of the last six bear numbers for names, so that the page of a trial does not give away what
they are.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .base import Array, Part, Rec, Rng, Shape
from .world import World

Form = Callable[[World, Rng, int], "Shape | None"]
FORMS: dict[str, list[tuple[str, str, Form]]] = {}
FAMILIES = ("open", "held", "fresh", "sealed", "unseen", "later", "apart", "distant")
NUMBERED = FAMILIES[2:]  # families whose kinds bear numbers
ALONE = ("later", "apart", "distant")  # families whose cases draw nothing from the open one


def form(effect: str, name: str, family: str = "open") -> Callable[[Form], Form]:
    """Decorator that files a form under its effect."""

    def add(f: Form) -> Form:
        FORMS.setdefault(effect, []).append((name, family, f))
        return f

    return add


def fresh(effect: str) -> Callable[[Form], Form]:
    """Decorator that files a form of the fresh family under its effect, numbered."""
    return numbered(effect, "fresh")


def sealed(effect: str) -> Callable[[Form], Form]:
    """Decorator that files a form of the sealed family under its effect, numbered."""
    return numbered(effect, "sealed")


def unseen(effect: str) -> Callable[[Form], Form]:
    """Decorator that files a form of the unseen family under its effect, numbered."""
    return numbered(effect, "unseen")


def later(effect: str) -> Callable[[Form], Form]:
    """Decorator that files a form of the later family under its effect, numbered."""
    return numbered(effect, "later")


def apart(effect: str) -> Callable[[Form], Form]:
    """Decorator that files a form of the apart family under its effect, numbered."""
    return numbered(effect, "apart")


def distant(effect: str) -> Callable[[Form], Form]:
    """Decorator that files a form of the distant family under its effect, numbered."""
    return numbered(effect, "distant")


def numbered(effect: str, family: str) -> Callable[[Form], Form]:
    """Decorator that files a form under its effect by the next number of its family."""
    mine = sum(f == family for _, f, _ in FORMS.get(effect, []))
    return form(effect, f"{family}-{mine + 1}", family)


def allowed(effect: str, family: str) -> list[tuple[str, str, Form]]:
    """Forms of an effect that a family may draw: its own and, unless it is ALONE, the open ones."""
    mine = (family,) if family in ALONE else ("open", family)
    return [f for f in FORMS[effect] if f[1] in mine]


def along(rec: Rec, ax: int, value: Array) -> Array:
    """A scalar (n,) as a vector field (n,3) along an axis."""
    out = np.zeros((len(rec.t), 3))
    out[:, ax] = value
    return out


def tool_only(ax: int, f: Callable[[Rec], Array], **kw: object) -> Shape:
    """Linear shape that moves the tool along `ax` by amp * f(rec), unseen by the scale."""
    from .base import AX

    return Shape(
        lambda rec, a: Part(tool=along(rec, ax, a * f(rec))), str(kw.pop("axis", AX[ax])), **kw
    )  # type: ignore[arg-type]


def both(ax: int, f: Callable[[Rec], Array], **kw: object) -> Shape:
    """Linear shape that tool and scale both see (the slide itself is elsewhere)."""
    from .base import AX

    def field(rec: Rec, a: float) -> Part:
        v = along(rec, ax, a * f(rec))
        return Part(tool=v, scale=v)

    return Shape(field, str(kw.pop("axis", AX[ax])), **kw)  # type: ignore[arg-type]


def unit_place(w: World, ax: int, rec: Rec) -> Array:
    """Slide position as 0..1 of the travel."""
    lo, hi = w.machine.travel[ax]
    return (rec.pos[:, ax] - lo) / (hi - lo)


def moving(rec: Rec, ax: int) -> Array:
    """Sign of the axis's speed, 0 below 1e-3 mm/s."""
    v = rec.vel[:, ax]
    return np.where(np.abs(v) > 1e-3, np.sign(v), 0.0)
