"""Drilling cycles of a Fadal, written out: L repeats them, L0 holds their words without a hole.

What Autodesk's `fadal.cps` writes: I J K of G73 and G83 as on Haas, P of G73 what it backs off a
chip, P of G82 and G89 milliseconds at the bottom. Assumed: P of G83 is how far above the last peck
the next one begins; G83 goes out to R level; without P as on Fanuc (drilling_fanuc.RETRACT); P and
Q of a cycle without a dwell or pecks do nothing there (a real program has them in G81), and are
not held.
"""

from __future__ import annotations

from dataclasses import replace

from postproc.nc.cycles.block import Block, Word
from postproc.nc.cycles.drilling import KIND, WORDS, Job, bore
from postproc.nc.cycles.drilling_fanuc import HAAS_PECKS, MILL, SHIFT, HaasDrilling
from postproc.nc.cycles.scene import Scene
from postproc.nc.cycles.words import Form, named

TAPPING = (740, 741, 840, 841)
FINE_BORE = 760
PLAIN = {code: action for code, action in MILL.items() if code not in (842, 843)}


class FadalDrilling(HaasDrilling):
    actions = PLAIN | dict.fromkeys(TAPPING, bore)
    tapping, refused, whole = TAPPING, {FINE_BORE: SHIFT}, (FINE_BORE,)
    dwells = (820, 890)

    def hole_form(self, code: int) -> Form:
        own = {"P": "distance before the next peck"} if code in self.pecking else {}
        pecks = HAAS_PECKS | named(WORDS, "Q") | own if code in self.pecking else {}
        takes = named(WORDS, "XYZRL" + "P" * (code in self.dwells)) | pecks
        return Form(KIND, takes, idle="".join(x for x in "PQ" if x not in takes), axes=True)

    def _hold(self, scene: Scene, block: Block, axis: str) -> None:
        super()._hold(scene, block, axis)
        # P has three meanings here, by the cycle: it must not pass from one kind to the next.
        code = next((c for c in block.codes if c in self.actions), None)
        if code is None or code in self.pecking:
            return
        self.held.pop("Q", None)
        if code not in self.dwells:
            self.p = ""

    def job(self, scene: Scene, block: Block, code: int) -> Job:
        job = super().job(scene, block, code)
        if code not in self.pecking or not self.p:
            return job
        # A distance here, where it is a time in other cycles.
        before = scene.length(Word("P", float(self.p), self.p, 0, 0), job.hole.axis)
        return replace(job, hole=replace(job.hole, retract=before))
