"""Strangers: simulated machine-tool recordings with hidden physics, for blind tests of a tool.

Assumptions (all um, mm, urad; deviation = actual - commanded, tool relative to workpiece):
geometry, play, wind-up, screw and heat errors are seen by outside instruments, circles and parts,
not by a trace with sees = "scale"; servo, friction, vibration of a slide, stick-slip and lost
steps are seen by both; laser, delay and clock errors are put into the reading only.  A reading
of an angle is the rotation vector along `sensitive` (keys X, Y, Z).  Parts are cut where the
map is zero; they have no free zero.  See the module docstrings for sources.

Families of kinds: open, held (drawn in sealed trials, known by name from one), fresh (numbered;
opened by a trial), sealed, unseen, later and apart (numbered; opened by trials) and distant
(numbered; its trials show figures alone).  Cases of the last three draw forms, noises, aliens and
plans from their own family alone.  Who works on the tool that is judged runs no case of the last
one, and reads neither the modules distant_*.py nor their tests.
"""

from .base import Case
from .tiers import TIERS, make

__all__ = ["TIERS", "Case", "make"]
