"""Sinumerik words: which names are addresses or commands of the language, and how values are
written behind them.

Source: Siemens "SINUMERIK 840D sl / 828D", lists of instructions, of addresses and of G functions.
"""

from __future__ import annotations

import re

from postproc.nc.expand import Refusal
from postproc.nc.expand.siemens_values import Axis, Scope, Value, numeric
from postproc.nc.expand.tracker import number

_ADDRESSES = """
    ACC ACCLIMA ADIS ADISPOS ANG AP AR ATOL CHF CHR CPROT CR CTOL DIAMONA DISCL DISR DISRP DITE
    DITS DL FA FAD FB FD FGREF FL FMA FP FRC FRCM FZ ISD JERKLIM JERKLIMA LEAD LIMS MEAS MEAW NUT
    OMA OTOL OVR OVRA OVRRAP PHI PL PM PO POS POSA POSP PR PSI PW RND RNDM RP RPL SD SF SPOS SPOSA
    SR SRA ST STA STOLF THETA TILT TOFF TOFFL TOFFLR TOFFR TU TURN VELOLIM VELOLIMA
"""
_COMMANDS = """
    ALF AMIRROR AROT AROTS ASCALE ASPLINE ATRANS BAUTO BNAT BRISK BRISKA BSPLINE BTAN CDOF CDOF2
    CDON CFC CFIN CFTCP CIP CLEARM COMPCAD COMPCURV COMPOF COMPON COMPSURF CPRECOF CPRECON CROTS
    CSPLINE CT CUT2D CUT2DF CUT3DC CUT3DCC CUT3DF CUT3DFF CUT3DFS CUTCONOF CUTCONON CYCLE800
    CYCLE832 DIAM90 DIAM90A DIAMCHAN DIAMCHANA DIAMCYCOF DIAMOF DIAMOFA DIAMON DIAMONA DISPLOF
    DISPLON DRFOF DRIVE DRIVEA DYNFINISH DYNNORM DYNPOS DYNPREC DYNROUGH DYNSEMIFIN EAUTO ENAT
    ETAN FCUB FENDNORM FFWOF FFWON FGROUP FIFOCTRL FLIN FNORM GROUP_ADDEND GROUP_BEGIN GROUP_END
    INVCCW INVCW KONT KONTC KONTT LFOF LFON LFPOS LFTXT LFWP MIRROR MMC MSG NEWCONF NORM ORIAXES
    ORIC ORICONCCW ORICONCW ORICONIO ORICONTO ORICURVE ORID ORIEULER ORIMKS ORIPATH ORIPATHS
    ORIPLANE ORIROTA ORIROTC ORIROTR ORIROTT ORIRPY ORIRPY2 ORISOF ORISON ORIVECT ORIVIRT1
    ORIVIRT2 ORIWKS OSC OSD OSOF OSS OSSE OST PAROT PAROTOF PDELAYOF PDELAYON POLY RMB RME RMI RMN
    ROT ROTS RTLIOF RTLION SBLOF SBLON SCALE SETAL SETM SETMS SETPIECE SOFT SOFTA SPATH SPCOF
    SPCON SPIF1 SPIF2 SPOF STARTFIFO STOPFIFO STOPRE SUPA TCOABS TCOFR TOFRAME TOROT TOROTOF
    TRAANG TRACYL TRAFOOF TRANS TRANSMIT TRAORI UPATH WAITE WAITM WAITMC WAITP WAITS WALIMOF
    WALIMON WORKPIECE
"""
ADDRESSES = frozenset(_ADDRESSES.split())  # of several letters, written with "="
# they call no program; which can be followed is for the dialect to say
COMMANDS = frozenset(_COMMANDS.split())
CODE = re.compile(r'(?:[^;"]++|"[^"]*+(?:"|$))*+')
# X=IC(5), M=QU(7)
WRAPPERS = ("IC", "AC", "DC", "ACP", "ACN", "CAC", "CIC", "CDC", "CACP", "CACN", "QU")
# addresses whose values are whole numbers
WHOLE = ("G", "M", "T", "D", "L", "N", "P", "TURN", "SD", "DL")
# written with as many decimals as radii
VECTORS, VECTOR_DECIMALS = ("A3", "B3", "C3"), 9  # of the tool's direction
LENGTHS = ("CR", "RP", "RND", "RNDM", "CHR", "CHF", "POS", "POSA", "PL")


def word(scope: Scope, address: str, value: Value) -> str:
    """A value as it is written behind an address."""
    if isinstance(value, str):
        if address != "T" and address != "D":
            raise Refusal(f"a string can not be the value of {address}", "assign a number")
        return f'"{value}"'
    # C2 is written as C, CR as itself
    base = address[0] if len(address) == 1 or address[1:].isdigit() else address
    if base in WHOLE:
        value = numeric(value)
        if value != int(value):
            raise Refusal(
                f"{address} takes a whole number, this is {value:.12g}", "correct the expression"
            )
        return str(int(value))
    if address in VECTORS:
        return number(float(numeric(value)), VECTOR_DECIMALS)
    decimals = scope.decimals.get(base)
    if decimals is None:
        letter = "R" if base in LENGTHS else base if len(base) == 1 else "?"
        decimals = scope.decimals[base] = scope.tracker.decimals(letter)
    return number(float(numeric(value)), decimals)


def argument(value: Value) -> str:
    """A value as it is written in parentheses or brackets."""
    if isinstance(value, Axis):
        return value.name
    if isinstance(value, str):
        return f'"{value}"'
    return str(int(value)) if value == int(value) and abs(value) < 1e15 else number(float(value), 6)


def end_of_code(text: str) -> int:
    """The offset of the comment, or of the end; a semicolon within a string is none."""
    code = CODE.match(text)
    return code.end() if code else 0
