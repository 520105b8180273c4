"""What a command writes with --json against its schema."""

from __future__ import annotations

import json
from typing import Any

import pytest

from postproc.commands.as_json import SCHEMAS


def schema(name: str) -> dict[str, Any]:
    """By the name of its format."""
    return json.loads((SCHEMAS / f"{name.replace('/', '-')}.json").read_text("utf-8"))


def held(data: dict) -> None:
    """Fits its schema, and every field is told of there."""
    jsonschema = pytest.importorskip(
        "jsonschema",
        reason="jsonschema is not installed: schemas are not held against what is written",
    )
    own = schema(data["format"])
    jsonschema.Draft202012Validator(own).validate(data)
    assert undescribed(data, own) == []


def undescribed(data, own: dict, path: str = "") -> list[str]:
    """Fields that a schema says nothing about."""
    if isinstance(data, list):
        return [text for one in data for text in undescribed(one, own.get("items", {}), path)]
    if not isinstance(data, dict) or (
        "properties" not in own and "additionalProperties" not in own
    ):
        return []
    found = []
    for key, value in data.items():
        part = own.get("properties", {}).get(key, own.get("additionalProperties"))
        found += [f"{path}.{key}"] if part is None else undescribed(value, part, f"{path}.{key}")
    return found
