"""Pages in headless Chromium: drawn on wide and narrow screens, in light and dark, and what a
click, a key, a slider does."""

from __future__ import annotations

from pathlib import Path

import pytest

from postproc.cli import main

ROOT = Path(__file__).resolve().parents[2]
PROGRAMS = {"shaft.nc": "studer-s36", "pocket_mill.ngc": "example-mill"}


@pytest.fixture(scope="module")
def pages(tmp_path_factory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("pages")
    made = {}
    for name, machine in PROGRAMS.items():
        made[name] = folder / f"{name}.html"
        line = [
            "show",
            str(ROOT / "sample_programs" / name),
            "--machine",
            machine,
            "-o",
            str(made[name]),
            "--quiet",
        ]
        assert main(line) == 0
    return made


def drawn(page, figure: str) -> int:
    """How many curves a figure shows."""
    return page.evaluate(f"document.getElementById({figure!r}).data.length")


def test_a_wide_page_in_light_and_what_can_be_done_on_it(pages, opened):
    with opened(pages["shaft.nc"]) as page:
        assert [drawn(page, name) for name in ("path", "along", "histogram")] == [5, 4, 3]
        assert page.locator(".chart svg.main-svg").count() >= 3
        # The worst line by the table, the next place by a key.
        page.locator("button.pick").first.click()
        assert "Line 10" in page.inner_text("#told") and "N60 X36. F60." in page.inner_text("#told")
        assert "0.78 um remain" in page.inner_text("#told")
        at = page.evaluate("document.getElementById('path').data.at(-1).x[0]")
        page.focus("#path")
        page.keyboard.press("ArrowRight")
        assert page.evaluate("document.getElementById('path').data.at(-1).x[0]") >= at
        # The slider magnifies: the actual path moves away from the nominal one, ten times as far in
        # three steps.
        far = "Math.max(...document.getElementById('path').data[1].y) - 50"
        before = page.evaluate(far)
        page.evaluate(
            "document.getElementById('magnify').value = 12;"
            " document.getElementById('magnify').dispatchEvent(new Event('input'))"
        )
        assert page.inner_text("#times") == "10,000" and page.evaluate(far) > before
        # Even steps in place of logarithmic ones.
        kind = "document.getElementById('along').layout.yaxis.type"
        assert page.evaluate(kind) == "log"
        page.locator("button.scale").first.click()
        assert page.evaluate(kind) == "linear"
        # The theme is taken by page and figures alike.
        ink = "document.getElementById('along').layout.font.color"
        light = page.evaluate(ink)
        page.click("#theme")
        page.click("#theme")
        page.wait_for_function(f"{ink} !== {light!r}")
        # On paper it is light, whatever the screen is, as wide as a sheet, and as before after it.
        wide = "document.querySelector('#along svg.main-svg').getBoundingClientRect().width"
        on_screen = page.evaluate(wide)
        page.evaluate("window.dispatchEvent(new Event('beforeprint'))")
        page.wait_for_function(f"{ink} === {light!r}")
        assert page.evaluate(wide) <= 717 < on_screen  # px: A4 between margins of 1 cm
        page.emulate_media(media="print")
        assert page.locator("button.pick").first.is_visible()  # a line's number is a button
        page.emulate_media(media="screen")
        page.evaluate("window.dispatchEvent(new Event('afterprint'))")
        page.wait_for_function(f"{ink} !== {light!r}")
        assert page.evaluate(wide) == on_screen
        assert page.pdf().startswith(b"%PDF")


def test_a_narrow_page_in_dark_and_a_path_in_space(pages, opened):
    with opened(pages["pocket_mill.ngc"], 400, "dark") as page:
        assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(20, 24, 29)"
        assert page.evaluate("document.getElementById('path').getBoundingClientRect().right") <= 400
        page.select_option("#view", "3D")
        page.wait_for_selector("#path canvas", state="attached")
        kinds = page.evaluate("document.getElementById('path').data.map(t => t.type)")
        assert set(kinds) == {"scatter3d"}


def test_a_page_with_nothing_to_draw_opens_in_silence(opened, tmp_path):
    """It told the console of an error: it looked for the path that is not there."""
    out = tmp_path / "nothing.html"
    assert (
        main(
            [
                "show",
                str(ROOT / "sample_programs" / "pocket_mill.ngc"),
                "--machine",
                "perfect",
                "-o",
                str(out),
                "--quiet",
            ]
        )
        == 0
    )
    with opened(out, 400) as page:
        assert "nothing is changed" in page.inner_text("main")
