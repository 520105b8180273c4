"""What the documentation site needs beside docs/: the README as its first page, the machines'
README and the changelog, and links between them as they are there. mkdocs calls on_files and
on_page_markdown; `mkdocs build --strict` builds the site."""

from __future__ import annotations

import re
from pathlib import Path

from mkdocs.structure.files import File

ROOT = Path(__file__).resolve().parents[1]
PAGES = {
    "index.md": "README.md",
    "machines.md": "machines/README.md",
    "changelog.md": "CHANGELOG.md",
}
LINK = re.compile(r"(?<!!)\[([^\]]+)\]\(([^)#:]+)(#[^)]*)?\)")
PICTURE = re.compile(r"!\[([^\]]*)\]\(docs/([^)]+)\)")


def on_files(files, config):
    for name, source in PAGES.items():
        files.append(File.generated(config, name, content=(ROOT / source).read_text("utf-8")))
    known = {uri for uri in ("/".join(Path(n).parts) for n in nav_names(config["nav"]))}
    for path in sorted((ROOT / "docs").glob("*.md")):
        # a page that is written later is found by the search, and is no fault of the nav
        if path.name not in known:
            config["nav"].append({path.stem.replace("_", " ").capitalize(): path.name})
    return files


def nav_names(nav) -> list[str]:
    """Every page that the nav names."""
    if isinstance(nav, str):
        return [nav]
    values = nav.values() if isinstance(nav, dict) else nav
    return [name for value in values for name in nav_names(value)]


def on_page_markdown(markdown, page, config, files):
    source = PAGES.get(page.file.src_uri, f"docs/{page.file.src_uri}")
    there = {v: k for k, v in PAGES.items()}

    def link(found: re.Match) -> str:
        target = (ROOT / source).parent.joinpath(found[2]).resolve()
        name = target.relative_to(ROOT).as_posix() if target.is_relative_to(ROOT) else ""
        if name in there:
            return f"[{found[1]}]({there[name]}{found[3] or ''})"
        if name.startswith("docs/"):
            return f"[{found[1]}]({name[5:]}{found[3] or ''})"
        return f"{found[1]} (`{name}`)"  # in the repository alone

    return LINK.sub(link, PICTURE.sub(r"![\1](\2)", markdown))
