"""What is written of a job when it is over: one JSON object, and a page."""

from __future__ import annotations

import argparse
import os
from pathlib import Path
from typing import Any

from postproc import ports
from postproc.commands import as_json
from postproc.errors import UsageError

EVERY = 0.5  # s between two samples of a job, at first
MOST = 1200  # samples that are kept: then every second one goes, and they come half as often


class History:
    """How a job went on: state() of `Show` in even steps, of a long job farther apart."""

    def __init__(self) -> None:
        self.samples: list[dict[str, Any]] = []
        self._step, self._next = EVERY, 0.0

    def due(self, now: float) -> bool:
        return now >= self._next

    def add(self, now: float, state: dict[str, Any]) -> None:
        self._next = now + self._step
        self.samples.append(state)
        if len(self.samples) >= MOST:
            self.samples = self.samples[::2]
            self._step *= 2


def refuse(options: argparse.Namespace) -> None:
    """Raises UsageError for a place that is none: a good job must not end in what could be said
    before its first byte."""
    for path in (options.report, options.json):
        if path in (None, "-"):
            continue
        if Path(path).is_dir():
            raise UsageError(f"{path} is a folder", "name a file in it")
        folder = Path(path).absolute().parent
        if not os.access(folder, os.W_OK | os.X_OK):
            why = "can not be written to" if folder.is_dir() else "is not there"
            raise UsageError(
                f"{path} could not be written when the job is over: {folder} {why}",
                "make the folder, or name another one",
            )


def write(
    options: argparse.Namespace, fields: dict[str, Any], history: History, ended: str = ""
) -> None:
    """To the files that were asked for. A report whose name ends in .json is the JSON object.
    ended: how the job ended, as a person is told."""
    plain = bool(options.report) and Path(options.report).suffix.lower() == ".json"
    as_json.put(options.json, fields)
    as_json.put(options.report if plain else None, fields)
    if options.report and not plain:
        from postproc.pages import run

        ports.write_whole(
            options.report, run.page(fields, history.samples, ended).html().encode("utf-8")
        )
