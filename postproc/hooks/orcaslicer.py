"""OrcaSlicer, Bambu Studio: runs a script on the file before it is saved or sent, and shows its
message where it fails."""

from postproc.hooks import _script

TITLE = "OrcaSlicer, Bambu Studio"
TRIED = "not tried; its setting is PrusaSlicer's, from which it comes"
WHERE = "Process > Others > Post-processing Scripts (advanced mode)"
install = _script.at_a_setting("orcaslicer", WHERE)
