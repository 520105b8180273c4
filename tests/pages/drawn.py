"""Pages read back: what the packed data hold, without a browser."""

from __future__ import annotations

import base64
import gzip
import json
import re
from typing import Any

# words of figures that stand out at the side of theirs
CUT = """[...document.querySelectorAll('.js-plotly-plot')].flatMap(plot => {
    const frame = plot.getBoundingClientRect();
    return [...plot.querySelectorAll('.main-svg text')].filter(text => {
        const at = text.getBoundingClientRect();
        return at.width && (at.left < frame.left - 1 || at.right > frame.right + 1);
    }).map(text => plot.id + ': ' + text.textContent);
})"""


def packed(html: str, name: str) -> bytes:
    """What a page carries under an identifier."""
    found = re.search(
        rf'<script type="application/octet-stream" id="{name}">([^<]*)</script>', html
    )
    assert found, name
    return gzip.decompress(base64.b64decode(found[1]))


def data(html: str) -> dict[str, Any]:
    """Figures and what else a page's scripts draw."""
    return json.loads(packed(html, "data"))


def curves(html: str, figure: str) -> dict[str, dict[str, Any]]:
    """Name to curve of one figure."""
    found = next(f for f in data(html)["figures"] if f["id"] == figure)
    return {curve["name"]: curve for curve in found["data"]}


def outside(html: str) -> list[str]:
    """Every address that the page itself would ask for; the library's own text is left out."""
    text = re.sub(r'<script type="application/octet-stream"[^<]*</script>', "", html)
    return re.findall(
        r"""(?:src|href|url|import)\s*[=(]\s*["']?\s*((?:https?:)?//[^\s"')]+)""", text
    )
