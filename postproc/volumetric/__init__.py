"""A map from readings all over the volume: the errors of three axes at once, by least squares, with
what the readings can not tell.

On the way of a recording: observations makes rows of a residual of it (rows; circles and
step_diagonals for those two tests); nodes chooses where the components have their nodes; unknowns
holds components, squareness, lost motion and the location of rotary axes; solve fits them and the
nuisance parameters of the set-ups (scipy.optimize.least_squares); identify says which of them the
readings can not separate; written makes the machine's folder and the report. ISO 230-1
(components), ISO 230-6 (diagonals), ISO 10791-6 (rotary axes); Schwenke et al., CIRP Annals 57
(2008) 660.
"""

from postproc.errors import GcompError


class VolumetricError(GcompError):
    """Readings of the volume can not be used."""
