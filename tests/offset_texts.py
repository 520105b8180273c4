"""Offset files as controls write them, and how they are read: what the tests of offset
files share."""

from __future__ import annotations

import pytest

from postproc import offsets
from postproc.errors import UsageError
from postproc.offsets import read


def of(text: str | bytes, **how) -> offsets.Offsets:
    return read(text if isinstance(text, bytes) else text.encode(), "file", **how)


def refused(text: str | bytes, *says: str, **how) -> None:
    with pytest.raises(UsageError) as error:
        of(text, **how)
    for part in says:
        assert part in str(error.value)
    assert error.value.advice


def told(found: offsets.Offsets, part: str) -> bool:
    return any(part in notice for notice in found.notices)


VAR = "".join(
    f"{n}\t{v:.6f}\n"
    for n, v in sorted(
        {
            5161: 9,
            5210: 0,
            5211: 0.5,
            5213: -2,
            5220: 2,
            5221: 1,
            5222: 2,
            5223: -3.5,
            5224: 90,
            5227: 4,
            5230: 30,
        }.items()
        | {5241: 7, 5381: -1, 5389: 5, 5390: 0}.items()
    )
)

UFR = """%_N_UFR_INI
;$PATH=/_N_NC_ACT_DIR/_N_UFR_DIR
CHANDATA(1)
N10 $P_UIFR[0]=CTRANS(X,0,Y,0)
$P_UIFR[1]=CTRANS(X,10,Y,-20.5,Z,.5,C,90):CFINE(X,0.01,Y,0):CROT(X,0,Y,0,Z,30):CSCALE(X,1,Y,1):CMIRROR(X,0,Y,0)
$p_uifr[2,x,tr]=7 ; second
$P_UIFR[2,X,FI]=-0.5
$P_UIFR[2,Z,RT] = -15
$P_UIFR[5]=CTRANS(Z,1.5EX-3,SP1,4)
$P_UIFR[99]=CTRANS()
$P_CHBFR[0]=CTRANS(X,1):CFINE(X,0.25)
$P_NCBFR[0]=CTRANS(X,2,Z,3)
$MN_MM_NUM=5
M17
"""

HASH = (
    "$#\r\n[G54:-100.000,10.500,0.000]\r\n[G59:1.000,2.000,3.000]\r\n[G28:0.000,0.000,0.000]\r\n[G30:1.000,0.000,0.000]\r\n"
    "[G92:0.000,0.000,5.000]\r\n[TLO:12.250]\r\n[PRB:1.000,2.000,3.000:1]\r\nok\r\n"
)
