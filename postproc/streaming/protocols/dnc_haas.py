"""Drip feed to a Haas: XON/XOFF, 7E1, CR LF; it starts to read at once.

Haas, mill operator's manual (1999), RS-232: 9600 or as set, 7 bits, even parity, one stop bit;
Setting 14 is XON/XOFF or DC CODES; the program stands between two `%`; `;` is not sent.
"""

from postproc.streaming.protocols.dnc import Dnc, Link
from postproc.streaming.protocols.dnc import recognises as recognises

TITLE = "DNC, Haas"
POKE = b""
HAAS = Link(bits=7, parity="E", stop=1, baud=9600, end=b"\r\n", waits=False)


class DncHaas(Dnc):
    title = TITLE
    link = HAAS


PROTOCOL = DncHaas
