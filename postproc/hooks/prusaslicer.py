"""PrusaSlicer: runs a script on the file before it is saved or sent, and shows its message where it
fails."""

from postproc.hooks import _script

TITLE = "PrusaSlicer"
TRIED = "tests/hooks run Debian's PrusaSlicer 2.5 with it"
WHERE = "Print Settings > Output options > Post-processing scripts (expert mode)"
install = _script.at_a_setting("prusaslicer", WHERE)
