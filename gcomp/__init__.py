"""gcomp from Python: what the command line does, as functions that return results.

>>> import gcomp
>>> machine = gcomp.load_machine("studer-s36")
>>> done = gcomp.compensate("G90 G21 G18 G0 X20. Z0.\\nG1 X40. Z80. F100\\n", machine, verify=True)
>>> print(done.text.splitlines()[-1])
X39.9827 Z79.9996
>>> done.verified.passed
True

Names that stand in `__all__` are the public interface and follow semantic versioning: within one
major version they keep their meaning, and fields are added, never taken away. Everything in the
package `postproc` may change in any version. All of it is described, with examples that the tests
run, in docs/PYTHON.md.
"""

from postproc import __version__, api
from postproc.api import *  # noqa: F403

__all__ = ["__version__"]
__all__ += api.__all__
