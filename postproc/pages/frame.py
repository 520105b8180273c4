"""Blocks in the house's template: one HTML file with everything in it."""

from __future__ import annotations

import base64
import gzip
import importlib.util
import json
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from postproc import __version__, style
from postproc.errors import UsageError

HERE = Path(__file__).resolve().parent / "templates"


@dataclass
class Page:
    """title; headline: the answer in one sentence, with mood good, bad, open or ""; subject: rows
    (name, value) of what this is about; blocks: in order. A block is a dict with a kind that the
    template knows: text, tiles, table, list, figure, row, path."""

    title: str
    headline: str
    mood: str = ""
    subject: list[tuple[str, str]] = field(default_factory=list)
    blocks: list[dict[str, Any]] = field(default_factory=list)
    data: dict[str, Any] = field(default_factory=dict)  # for scripts of the page's own
    scripts: tuple[str, ...] = ()  # of the page's own, in templates/

    def section(self, title: str, *texts: str) -> None:
        """A heading, and sentences."""
        self.blocks.append({"kind": "heading", "title": title, "id": f"s{len(self.blocks)}"})
        self.text(*texts)

    def text(self, *texts: str) -> None:
        self.blocks += [{"kind": "text", "text": text} for text in texts if text]

    def tiles(self, *tiles: tuple[str, str, str]) -> None:
        """Figures that are read first: (value, what it is, role of its colour or "")."""
        self.blocks.append({"kind": "tiles", "tiles": tiles})

    def table(self, head: tuple[str, ...], rows: list[tuple[Any, ...]], **more: Any) -> None:
        """A table; a column whose head ends in a unit or is marked with > stands to the right."""
        self.blocks.append({"kind": "table", "head": head, "rows": rows, **more})

    def listing(self, items: list[str]) -> None:
        if items:
            self.blocks.append({"kind": "list", "items": items})

    def figure(self, figure: dict[str, Any]) -> None:
        self.blocks.append({"kind": "figure", "figure": figure})

    def figures(self, *figures: dict[str, Any]) -> None:
        """Figures side by side, one below the other on a narrow screen."""
        self.blocks.append({"kind": "row", "figures": figures})

    def html(self) -> str:
        """The file's text. Raises UsageError where a library is missing."""
        figures = [
            f
            for b in self.blocks
            for f in b.get("figures", (b["figure"],) if "figure" in b else ())
        ]
        # NaN would be no JSON to a browser, and the whole page would stay empty: rather an error
        # here.
        data = json.dumps({"figures": figures, **self.data}, allow_nan=False, separators=(",", ":"))
        return (
            _environment()
            .get_template("page.html")
            .render(
                page=self,
                version=__version__,
                css=(HERE / "page.css").read_text("utf-8"),
                light=style.variables(style.LIGHT),
                dark=style.variables(style.DARK),
                font=style.FONT,
                data=_packed(data.encode("utf-8")),
                library=_library(),
                sequential=json.dumps(style.SEQUENTIAL),
                scripts=[(HERE / s).read_text("utf-8") for s in ("page.js", *self.scripts)],
            )
        )


def _packed(data: bytes) -> str:
    # mtime=0: the same page twice is the same bytes
    return base64.b64encode(gzip.compress(data, 9, mtime=0)).decode("ascii")


@cache
def _library() -> str:
    """plotly.js, compressed; found beside the Python package, which is not imported."""
    found = importlib.util.find_spec("plotly")
    if found is None or not found.submodule_search_locations:
        raise UsageError("a page needs plotly, which is not installed here", "pip install plotly")
    script = Path(found.submodule_search_locations[0]) / "package_data" / "plotly.min.js"
    return _packed(script.read_bytes())


def _environment() -> Any:
    try:
        import jinja2
    except ImportError:
        raise UsageError(
            "a page needs jinja2, which is not installed here", "pip install jinja2"
        ) from None
    return jinja2.Environment(
        loader=jinja2.FileSystemLoader(HERE), autoescape=True, trim_blocks=True, lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )  # fmt: skip
