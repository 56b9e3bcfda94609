"""Group motion as material and the storyboard's pages, in a browser with a real show and a real preview."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.app.services.test_document_service import PATCH
from tests.app.services.test_studio_pages import KEY, Studio
from tests.control.waiting import BUSY
from tests.end_to_end.browser import browser, needs_browser
from tests.end_to_end.studio.test_studio_stage import DEPTH, WIDTH, at, stroke, until, written
from tests.show.patch.edited_night import write_patch_folder

pytestmark = [needs_browser, pytest.mark.browser, pytest.mark.long]
MORE = f"""
[stage]
width = {WIDTH}
depth = {DEPTH}
[[formation]]
name = "yard"
shape = "rectangle"
size = [2.6, 3.6]
centre = [3.0, 0.0]
[[formation]]
name = "spot"
shape = "circle"
size = [0.8, 0.8]
centre = [-4.2, -2.2]
[[segment]]
measure = 5
measures = 2
group = "ember"
formation = "line"
[[segment]]
measure = 5
measures = 2
group = "tide"
formation = "grid"
"""
EMBER = 3
"""Number of ember's segment."""
BENT = "JSON.stringify(studio.score.value.formation).includes('in a region')"


@pytest.fixture
def show(tmp_path: Path) -> Iterator[Studio]:
    made = Studio(write_patch_folder(tmp_path, PATCH + MORE))
    yield made
    made.stop()


@pytest.fixture
def page(show: Studio) -> Iterator[Any]:
    with browser() as (opened, _):
        made = opened.new_context(viewport={"width": 1440, "height": 900}, locale="en-GB").new_page()
        made.set_default_timeout(30_000 * BUSY)
        errors: list[str] = []
        made.on("pageerror", lambda error: errors.append(str(error)))
        made.on("console", lambda message: message.type == "error" and errors.append(message.text))
        made.goto(f"http://127.0.0.1:{show.web.port}/studio#key={KEY}")
        until(made, "Boolean(window.studio?.doc.positions.value && studio.doc.structure.value)")
        yield made
        assert not errors


def take(page: Any) -> Any:
    """Select ember's segment; return the handle of its motion."""
    page.evaluate(f"studio.cursor.value = 4; studio.select({{list: 'segment', number: {EMBER}}})")
    handle = page.get_by_role("button", name=re.compile("^Bend "))
    handle.wait_for()
    return handle


def test_a_groups_motion_is_dragged_onto_a_region_and_bends(show: Studio, page: Any) -> None:
    before = show.loaded.path.read_text()
    box = take(page).bounding_box()
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.mouse.down()
    page.mouse.move(*at(page, -4.2, -2.2), steps=3)
    page.get_by_text("the region has room for 1 dancers; 2 have no place").wait_for()
    page.mouse.move(*at(page, 3.0, 0.2), steps=3)
    until(page, "studio.dragAnswer.value?.texts.ways")
    ends = page.evaluate("studio.dragAnswer.value.texts.ways.ways.slice(0, 3).map((way) => way.at(-1))")
    assert all(1.6 <= x <= 4.4 and abs(z) <= 1.9 for x, z in ends)
    assert show.loaded.path.read_text() == before
    page.mouse.up()
    written(show, r'name = "line in a region"\nlike = "line"\ninto = "yard".*formation = "line in a region"')
    until(page, BENT)
    page.keyboard.press("Control+z")
    until(page, f"!{BENT}")
    assert show.loaded.path.read_text() == before

    handle = take(page)  # by keyboard: the first is yard, the second spot, which is too small
    handle.focus()
    handle.press("ArrowRight")
    said = page.locator(".handles [role=status]")
    said.filter(has_text="into yard").wait_for(state="attached")
    handle.press("ArrowRight")
    said.filter(has_text="into spot").wait_for(state="attached")
    handle.press("Enter")
    page.get_by_text("has room for 1 of 3 dancers").wait_for()
    assert show.loaded.path.read_text() == before


def test_a_way_is_planned_together_with_the_others_while_it_is_drawn(show: Studio, page: Any) -> None:
    page.evaluate("studio.cursor.value = 4; studio.select(null); studio.dancers.value = [1, 2, 3]")
    page.get_by_role("radio", name="Curve").click()
    page.get_by_label("becomes").select_option("way")
    page.mouse.move(*at(page, -3.0, 1.0))
    page.mouse.down()
    page.mouse.move(*at(page, 2.0, -1.0), steps=5)
    page.get_by_text("planned together with tide").wait_for()
    assert page.evaluate("studio.dragAnswer.value.texts.ways.dancers.slice(0, 6)") == [1, 2, 3, 4, 5, 6]
    page.mouse.up()
    page.get_by_role("form", name="What becomes of the line").get_by_role("button", name="Cancel").click()
    page.get_by_role("radio", name="Closed shape").click()
    page.evaluate(f"studio.select({{list: 'segment', number: {EMBER}}})")
    page.get_by_label("becomes").select_option("bend")
    stroke(page, (0.5, -2.0), (4.0, -2.0), (4.0, 2.0), (0.5, 2.0), (0.5, -1.9))
    until(page, "studio.dragAnswer.value?.texts.ways")
    page.get_by_role("button", name="Bend it").click()
    written(show, r'name = "line in a region"\nlike = "line"\ninto = \[\[')


def test_the_storyboard_is_that_of_the_sheets_and_prints(show: Studio, page: Any, tmp_path: Path) -> None:
    page.get_by_role("button", name="Storyboard").click()
    page.get_by_text(re.compile(r"^\d+ scenes on \d+ pages?$")).wait_for()
    sheets = page.get_by_role("article")
    for paper, width in (("a4", 594.9), ("letter", 612)):
        page.get_by_label("Paper").select_option(paper)
        page.locator(f".paper-{paper} article").first.wait_for()
        printed = page.pdf(prefer_css_page_size=True)
        widths = [float(one) for one in re.findall(rb"/MediaBox \[0 0 ([\d.]+)", printed)]
        assert len(widths) == sheets.count()
        assert all(abs(one - width) < 1.0 for one in widths)
    with page.expect_download() as download:
        page.get_by_role("button", name="PDF of all sheets").click()
    assert download.value.suggested_filename == "edited-sheets.pdf"
    download.value.save_as(tmp_path / "all.pdf")
    assert (tmp_path / "all.pdf").read_bytes().startswith(b"%PDF-")
    page.get_by_label("Pages").select_option("2")
    page.get_by_role("article", name="Dancer 2, page 1").wait_for()
    assert page.get_by_role("article").first.locator("text", has_text="Dancer 2 · ember").count() == 1
    page.get_by_label("Pages").select_option("")
    page.get_by_role("button", name=re.compile(r"measures? 8.* circle: look at it in Make")).first.click()
    page.get_by_role("region", name="Timeline").wait_for()
    assert page.evaluate("studio.score.value.segment[studio.selected.value[0].number - 1].formation") == "circle"
    assert page.evaluate("studio.cursor.value") == 7
