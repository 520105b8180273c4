"""The recogniser: over programs written here, over the shared corpus where there is one, and over
any bytes."""

from __future__ import annotations

import re
import time
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from postproc.nc import dialects
from postproc.nc.recognise import HEAD, Text, against, between, recognise

CORPUS = Path(__file__).resolve().parents[2] / "shared" / "corpus"
ROOT = Path(__file__).parents[1]

PROGRAMS = {
    "linuxcnc": "o<hole> sub\n  g0 x#1 y#<top>\no<hole> endsub\no<hole> call [1]\nm2\n",
    "fanuc-mill": (
        "%\nO1234 (PLATE)\nT1 M6\nG0 G90 G54.1 P12 X0 Y0\nG43 H1 Z50.\n#101=5.\nG65 P9810"
        " Z1.\nM30\n%\n"
    ),
    "fanuc-lathe-a": (
        "O0007\nG50 S2000\nT0101\nG96 S180 M3\nG0 X52. Z2.\nG71 U2. R1.\nG71 P10 Q20 U.5 W.1"
        " F.25\nG99 F.2\nM30\n"
    ),
    "fanuc-lathe": (
        "O0007\nG92 S2000\nT0101\nG95 G96 S180 M3\nG0 G90 X52. Z2.\nG77 X40. Z-20. F.2\nM30\n"
    ),
    "fanuc-lathe-c": (
        "O0007\nG71\nG92 S2000\nT0101\nG95 G96 S180 M3\nG0 G90 X52. Z2.\nG24 X40. Z-20. F.2\nG73"
        " P10 Q20\nM30\n"
    ),
    "haas": (
        "%\nO00010 (PLATE)\nT1 M06\nG00 G90 G154 P3 X0. Y0.\nG43 H01 Z1.\nG187 P2\nG12 I0.5 D01"
        " F10.\nM97 P1000\nM30\nN1000\nM99\n%\n"
    ),
    "haas-lathe": (
        "%\nO00011\nT101\nG50 S1500\nG96 S400 M3\nG154 P2\nM154\nG98 G0 X2. Z0.1\nM135\nM30\n%\n"
    ),
    "siemens": (
        "N10 G500 DIAMON\nN20 T5 D1 M6\nN30 TRANS X10\nN40 G2 X20 Y0 CR=15\nN50 MCALL"
        " CYCLE81(10,0,2,-20)\nN60 R1=R1+1\nM30\n"
    ),
    "marlin": (
        ";FLAVOR:Marlin\n;Generated with Cura\nM104 S200\nG28 X Y\nG92 E0\nG1 X10 Y10 E1.5"
        " F1500\nM84\n"
    ),
    "reprap": (
        'M98 P"start.g"\nM453\nM950 H0\nG10 P0 S200 R150\nvar a = 5\nG1 X10 Y10 E1.5 F1500\nM116\n'
    ),
    "heidenhain-iso": (
        "%PART G71 *\nN10 G30 G17 X+0 Y+0 Z-40*\nN20 G99 T1 L+0 R+3*\nN30 T1 G17 S5000*\nN40 G01"
        " G41 X+5 F100*\nN50 G98 L1*\nN99999999 %PART G71 *\n"
    ),
    "heidenhain": (
        "0 BEGIN PGM PART MM\n1 BLK FORM 0.1 Z X+0 Y+0 Z-40\n2 TOOL CALL 1 Z S5000\n3 L X+10 Y+5 R0"
        " FMAX M3\n4 CYCL DEF 32.0 TOLERANCE\n5 L Z-5 F200\n6 END PGM PART MM\n"
    ),
    "grbl": "; for GRBL 1.1\n$H\nG21 G90\nG0 X0 Y0\nM3 S1000\nG1 X10 F500\n",
    "grblhal": "(grblHAL)\n$H\nG21 G90\nG81 X1 Y1 Z-2 R1 F100\nG65 P3\n",
    "mach3": (
        "(Mach3Mill)\nG00G21G17G90G40G49G80\nG71G91.1\nT1M06\nS12000M03\nG94\nG0X0.000Y0.000\nG1X5.F500.M10P1\nM30\n"
    ),
    "klipper": (
        "; klipper\nEXCLUDE_OBJECT_DEFINE NAME=a\nSTART_PRINT BED=60\nSET_PRESSURE_ADVANCE"
        " ADVANCE=0.05\nG92 E0\nG1 X10 Y10 E1.5 F1500\n"
    ),
    "smoothie": "; Smoothieware\nG28.2\nG21 G90\nG0 X0 Y0\nM3 S1000\nG1 X10 F500\n",
    "centroid": "; Centroid\nG90 G80 G40 G49\nG81 X1 Y1 Z-2 R1 F100\nM5\nM25\nG49 H0\nM99\n",
    "fagor": (
        "%PART1,MX--,\n; PART\nN10 #KIN ID [1]\nN15 G90 G94 G17\nN20 G71\nN25 G51 A45 E0.002\nN30"
        " #MCS G0 Z0\nT1 D1 M6\nG54\nG98 G81 X10 Y10 Z2 I-10 F300\nG80\nM30\n"
    ),
    "okuma": (
        "%\nOPART1\n(T1 D=10.)\nN10 G40 G80 G90 G94 G17\nN11 G21\nN13 T1 M06\nN15 G15 H01\nN18 G00"
        " X10. Y10.\nN19 G00 G56 Z15. H01\nN20 G71 Z15.\nN21 G81 X10. Y10. Z-10. R2. F300. M53\nN24"
        " G94\nM02\n"
    ),
    "okuma-lathe": (
        "$SHAFT.MIN%\nO1001\nG50 S2500\nG00 X600 Z400\nT010101\nG96 S180 M03\nNAT01 G81\n"
        "G00 X20 Z2\nG01 Z-20 F0.15\nG80\nG85 NAT01 D4 F0.3 U0.4 W0.1\nM02\n"
    ),
    "linuxcnc-pathpilot": (
        "(PART)\nG90 G54 G64 G50 G17 G40 G80 G94 G91.1 G49\nG20 (INCH)\nG30\nT1 G43 H1 M6\n"
        "S5000 M3 M8\nG0 X1. Y1.\nG0 Z.6\nG1 Z-.1 F10.\nM5 M9\nG30\nM30\n"
    ),
    "fluidnc": "; FluidNC\n$SD/Run=part.nc\nG21 G90\nG38.6 Z-10 F50\nG0 X0 Y0\n",
}


def test_every_program_is_of_a_dialect():
    assert set(PROGRAMS) <= set(dialects.names())


@pytest.mark.parametrize("name", sorted(PROGRAMS))
def test_a_program_with_signs_is_distinguished_from_all_others(name):
    text = PROGRAMS[name].encode()
    assert between(text) == [name]
    assert dict(recognise(text))[name]


@pytest.mark.parametrize("name", sorted(PROGRAMS))
def test_it_looks_at_no_more_than_the_head(name):
    text = PROGRAMS[name].encode()
    assert recognise(
        text + b"\n" * (HEAD - len(text)) + b"o<x> sub\nCR=5 G187\nM104 S5\n"
    ) == recognise(text)


def test_a_plain_program_can_not_be_told():
    text = b"G21 G90 G17\nG0 X0 Y0\nG1 X10. F100.\nX20. Y5.\nM30\n"
    names = between(text)
    assert {"linuxcnc", "fanuc-mill"} <= set(names)
    assert "marlin" not in names, "a block without its code is no motion there"
    assert all(evidence == [] for _, evidence in recognise(text))


@pytest.mark.parametrize(
    "text", [b"", b"\n", b"\0\1\2\3" * 50, b"%\n", "\u00e4\u00f6\u00fc".encode()]
)
def test_what_is_no_program_is_of_none(text):
    assert recognise(text) == [] or between(text) != []


def test_evidence_says_the_line():
    found = dict(recognise(b"G90\nG0 X0 Y0\nG2 X5 Y5 CR=3.5\n"))
    assert found["siemens"] == ["CR=3.5 in line 3"]


def test_what_speaks_against_a_dialect_says_the_line():
    said = list(against(Text(b"G0 X1\nG33.1 Z5 K1\nG1 X5 E2\n"), dialects.load("grbl")))
    assert said == ["it has no G33.1 (line 2)", "E in a motion (line 3)"]


def test_codes_are_found_without_blanks_between_words():
    text = "N1T006M06F800S1800\nN2G55X0.000Y0.00Z3.G00\nSET_A=1G2 TOOL1M44 #1G3\n"
    codes = Text(text.encode()).codes
    assert [word for _, _, word in codes["G"]] == ["G55", "G00"]
    assert [word for _, _, word in codes["M"]] == ["M06"]


def test_the_kind_of_a_path_in_a_remark_is_no_slicers():
    """jscut writes `; Type:         Inside`, slicers `;TYPE:Perimeter`."""
    text = b"G21\nG90\n;{}\nG1 X1 Y2 F500\n".replace(b"{}", b" Type:         Inside")
    assert "grbl" in between(text)
    assert "marlin" in between(text.replace(b" Type:         Inside", b"TYPE:Perimeter"))
    assert "grbl" not in between(text.replace(b" Type:         Inside", b"TYPE:Perimeter"))


def test_comments_are_looked_at_apart():
    """A code named in a remark is none of the program's, and a name written as a code is no
    remark."""
    assert "siemens" not in between(b"( TRANS X5 CR=5 )\nG0 X1 Y1\nG1 X5 F100\n")
    assert between(b"; made for FluidNC\nG0 X1 Y1\nX5\n") == ["fluidnc"]


@settings(max_examples=200, deadline=None)
@given(
    st.one_of(
        st.binary(max_size=400),
        st.text(alphabet="GMTXYZO<>[]()=;%*#$.0123456789 \n-", max_size=400).map(str.encode),
    )
)
def test_any_bytes_are_answered(text):
    found = recognise(text)
    names = [name for name, _ in found]
    assert len(names) == len(set(names))
    assert set(names) <= set(dialects.names())
    assert found == sorted(found, key=lambda row: -len(row[1])) or found[0][1] == max(
        (e for _, e in found), key=len
    )


def test_it_does_not_take_long():
    """64 kB of long lines, in well under a second: no pattern goes back and forth."""
    for line in (
        b"G1 X10.5Y20.25Z-3.125\n",
        b"E" * 5000 + b"\n",
        b"O" + b"1" * 5000 + b"\n",
        b"(" * 5000 + b"\n",
        b"G1 " + b"X=" * 2500 + b"\n",
    ):
        text = line * (HEAD // len(line) + 1)
        start = time.process_time()
        recognise(text)
        assert time.process_time() - start < 2.0, line[:20]


def test_all_dialects_are_loaded_in_no_time():
    """In a fresh process: what is loaded beside the package itself."""
    import subprocess
    import sys

    code = (
        "import time; from postproc.nc import dialects, rows; start = time.process_time()\n"
        "[dialects.load(n) for n in dialects.names()]\nprint(time.process_time() - start)"
    )
    ran = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=True
    )
    assert float(ran.stdout) < 0.3, "seconds; about 0.02 where modules are compiled"


# -- the shared corpus -----------------------------------------------------------------------------

corpus = pytest.mark.skipif(not CORPUS.is_dir(), reason="no corpus here")
UNSAID = ("multiple_m_codes.mpf",)  # G1 and M codes alone
PRINTERS = ("_ffcp_end", "arc_end", "bondtech_estep", "makerblock_tinycnc", "plotter_owl")
SUBS = ("_gcodeLexer_samples", "_libgcode_slot", "_linuxcnc_dot", "_samples", "_slot")


def programs(folder: str) -> list[Path]:
    files = sorted((CORPUS / folder).glob("*")) if CORPUS.is_dir() else []
    return [p for p in files if p.suffix != ".csv" and p.name != "LICENSE"]


@corpus
@pytest.mark.parametrize("path", programs("sinumerik"), ids=lambda p: p.name)
def test_sinumerik(path):
    names = between(path.read_bytes())
    assert names == ["siemens"] or (path.name in UNSAID and "siemens" in names)


@corpus
@pytest.mark.parametrize("path", programs("fanuc"), ids=lambda p: p.name)
def test_fanuc(path):
    names = between(path.read_bytes())
    assert "fanuc-lathe" in names if "TURN" in path.name else "fanuc-mill" in names
    if re.search(rb"^O\d{4}", path.read_bytes(), re.MULTILINE):
        assert names == ["fanuc-mill"]


@corpus
@pytest.mark.parametrize(
    "path", [p for p in programs("mixed") if p.stem in PRINTERS], ids=lambda p: p.name
)
def test_printers(path):
    names = between(path.read_bytes())
    assert names and set(names) <= {"marlin", "reprap", "klipper"}


@corpus
@pytest.mark.parametrize(
    "path", [p for p in programs("mixed") if p.stem in SUBS], ids=lambda p: p.name
)
def test_linuxcnc(path):
    assert between(path.read_bytes()) == ["linuxcnc"]


@corpus
def test_there_were_such_files():
    assert len(programs("sinumerik")) > 30
    assert sum(p.stem in PRINTERS + SUBS for p in programs("mixed")) == len(PRINTERS + SUBS)
