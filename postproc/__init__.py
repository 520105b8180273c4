"""gcomp: makes an inaccurate CNC machine cut accurately, by rewriting the program it is given."""

__version__ = "0.1.0"
