"""`python -m postproc` is `gcomp`."""

import sys

from postproc.entry import begin

sys.exit(begin())
