"""What is verified and what is not is said alike wherever it is said: in the list, in the sign, and
beside every file."""

from __future__ import annotations

import pytest

from postproc import cli, control_tables

MORE = {
    "siemens-cec": ("--component", "EXY", "--component", "EYX", "--set", "cec_sign=-"),
    "fanuc": ("--reference", "X=0,Y=0,Z=0"),
}


@pytest.mark.parametrize("name", control_tables.names())
def test_labels_agree(name, tmp_path, capsys):
    module = control_tables.load(name)
    open_ = bool(module.UNVERIFIED)
    assert module.VERIFIED or open_  # a format that no source gives is named
    assert ("unverified" in module.SIGN) == (
        "sign" in module.UNVERIFIED or "list" in module.UNVERIFIED
    ), module.SIGN
    assert cli.main(["export", "--list", "--control", name]) == 0
    listed = capsys.readouterr().out
    assert ("UNVERIFIED" in listed) == open_ and ("\nverified" in listed) == (not open_)
    words = ["export", "--machine", "example-mill", "--control", name, "-o", str(tmp_path / "o")]
    assert cli.main([*words, *MORE.get(name, ())]) == 0, capsys.readouterr().err
    said = capsys.readouterr().out
    assert ("UNVERIFIED: " in said) == open_, said


def test_the_list_and_the_docstrings_agree():
    for name in control_tables.names():
        module = control_tables.load(name)
        assert ("unverified" in (module.__doc__ or "").lower()) <= bool(module.UNVERIFIED), name
