"""Drip feed to a Siemens 810/840 over V.24: XON/XOFF, 8N1, CR LF (general knowledge, unverified on
hardware).

Its start, stop and end characters are settings of the control; these are the common ones. `%` opens
an ISO program.
"""

from postproc.streaming.protocols.dnc import Dnc, Link
from postproc.streaming.protocols.dnc import recognises as recognises

TITLE = "DNC, Siemens"
POKE = b""
SIEMENS = Link(bits=8, parity="N", stop=1, baud=9600, end=b"\r\n", waits=False)


class DncSiemens(Dnc):
    title = TITLE
    link = SIEMENS


PROTOCOL = DncSiemens
