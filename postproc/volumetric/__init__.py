"""A map from readings all over the volume: the errors of three axes at once, by least squares, with
what the readings can not tell.

rows: what was read, as rows of a residual; observations: recordings to such rows; unknowns:
components on nodes, squareness, lost motion, location of rotary axes;
solve: scipy.optimize.least_squares over them and over what belongs to the set-up alone; identify:
which of them the readings can not part. ISO 230-1 (components), ISO 230-6 (diagonals), ISO 10791-6
(rotary axes); Schwenke et al., CIRP Annals 57 (2008) 660.
"""

from postproc.errors import GcompError


class VolumetricError(GcompError):
    """Readings of the volume can not be used."""
