"""An axis that a tool change has taken away and no block names since is brought back by a feed."""

from __future__ import annotations

import pytest

from postproc.filter import Filter, setup_of
from postproc.nc import dialects
from postproc.units import UM
from postproc.verify import Verifier
from tests.corpus.machines import MAIN, Machines, offsets

# A Vectric post for Mach3: the first feed goes nowhere, since a laser goes on in it.
TEXT = (
    "G90G21G17F100\nT1M6\nG0X0Y0\nG0X0.033Y15.914\nG1X0.033Y15.914\nG1X13.855Y13.14\n"
    "G1X8.012Y1.013\nX18.895Y8.132\nM30\n"
)


@pytest.mark.parametrize("cut", range(10))
def test_the_first_feed_brings_it_back_though_it_goes_nowhere(tmp_path, cut):
    """Were it the one behind, Z would go 13.8 um down and back up by 1.4 in one block, and the
    lost motion between (2.4 um) would be left: 3.34 um were off."""
    dialect = dialects.load("mach3")
    machine = Machines(tmp_path).smooth(MAIN).carrying(dialect.carried)
    setup = setup_of(machine, offsets(), dict.fromkeys(machine.letters, 0.0))
    filter_ = Filter(machine, dialect, setup)
    verifier = Verifier(filter_)
    lines = TEXT.encode().splitlines(keepends=True)
    out = filter_.feed(b"".join(lines[:cut])) + filter_.feed(b"".join(lines[cut:]))
    written = (out + filter_.finish()).decode().splitlines()
    rapids = [x for x in written if x.startswith("G0")]
    assert len(rapids) == 2 and not any("Z" in x for x in rapids)
    assert written[5].startswith("G1X0.0235Y15.8960Z-0.01")
    assert verifier.corrected.deviation < UM, verifier.report()
