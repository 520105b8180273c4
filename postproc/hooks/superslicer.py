"""SuperSlicer: runs a script on the file before it is saved or sent, and shows its message where it
fails."""

from postproc.hooks import _script

TITLE = "SuperSlicer"
TRIED = "not tried; its setting is PrusaSlicer's, from which it comes"
WHERE = "Print Settings > Output options > Post-processing scripts (expert mode)"
install = _script.at_a_setting("superslicer", WHERE)
