"""The studio's library in a browser: steps, formations, and ways to choose from; a real show and a real preview."""

import re
import time
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.app.services.test_document_service import PATCH
from tests.app.services.test_studio_pages import KEY, Studio
from tests.control.waiting import BUSY
from tests.end_to_end.browser import browser, needs_browser
from tests.show.patch.edited_night import write_patch_folder

pytestmark = [needs_browser, pytest.mark.browser, pytest.mark.long]
HOSTILE = "<img src=x onerror=document.title='owned'>"
MORE = f"""
[[segment]]
measure = 14
measures = 2
formation = "gate"
[[formation]]
name = "gate"
shape = "arc"
size = [5.0, 3.0]
[[formation]]
name = "{HOSTILE}"
shape = "circle"
size = [3.0, 3.0]
"""
FILLED = r'measure = 10\nmeasures = 4\nformation = "gate"\nmatch = "equal"\nfacing = "tangent"'
TIMEOUT = 60_000 * BUSY


@pytest.fixture
def show(tmp_path: Path) -> Iterator[Studio]:
    made = Studio(write_patch_folder(tmp_path, PATCH + MORE))
    yield made
    made.stop()


@pytest.fixture
def page(show: Studio) -> Iterator[Any]:
    with browser() as (opened, _):
        context = opened.new_context(viewport={"width": 1440, "height": 900}, reduced_motion="reduce")
        made = context.new_page()
        made.set_default_timeout(TIMEOUT)
        errors: list[str] = []
        made.on("pageerror", lambda error: errors.append(str(error)))
        made.on("console", lambda message: message.type == "error" and errors.append(message.text))
        made.goto(f"http://127.0.0.1:{show.web.port}/studio#key={KEY}")
        made.get_by_role("region", name="Timeline").get_by_role("button", name=re.compile("gate")).first.wait_for()
        yield made
        assert not errors
        context.close()


def written(show: Studio, wanted: str) -> str:
    """Wait until a pattern is in the show's file; return the file."""
    deadline = time.monotonic() + 60.0 * BUSY
    while not re.search(wanted, text := show.loaded.path.read_text(), re.DOTALL):
        assert time.monotonic() < deadline, text
        time.sleep(0.02)
    return text


def test_steps_are_danced_chained_and_put_at_the_cursor(show: Studio, page: Any) -> None:
    library = page.get_by_role("region", name="Library")
    row = library.get_by_role("button", name=re.compile("^groove"))
    row.locator("canvas").wait_for()
    assert "1 measure" in row.inner_text()
    library.get_by_label("Search the library").fill("side")
    assert library.get_by_role("list", name="Steps").get_by_role("listitem").count() == 1
    library.get_by_label("Search the library").fill("")
    row.click()
    card = page.get_by_role("dialog", name="groove")
    card.get_by_role("img", name="groove from above").wait_for()
    chain = card.get_by_role("region", name="Sequence")
    chain.locator(".chips").first.get_by_role("button", name="side step").click()
    assert chain.get_by_role("listitem").count() == 2
    chain.get_by_role("button", name="Put at the cursor").click()
    assert re.search(
        r'\[\[sequence\]\].*steps = \["groove", "side step"\]', written(show, r"\[\[sequence\]\]"), re.DOTALL
    )
    page.get_by_role("dialog").wait_for(state="detached")
    row.drag_to(page.locator(".track[aria-label=tide] .lane"), target_position={"x": 100, "y": 10})
    written(show, r'steps = \["groove"\]\nmeasure = 2\ngroup = "tide"')
    row.focus()
    page.evaluate("studio.cursor.value = 20")
    page.keyboard.press("Enter")
    written(show, r'steps = \["groove"\]\nmeasure = 21')


def test_a_formation_is_drawn_saved_edited_and_its_uses_are_selected(show: Studio, page: Any) -> None:
    library = page.get_by_role("region", name="Library")
    library.get_by_role("button", name="Formations").click()
    own = library.get_by_role("list", name="Formations of this show")
    own.get_by_text("gate", exact=True).wait_for()
    assert HOSTILE in own.inner_text()
    library.get_by_role("button", name="New …").click()
    editor = page.get_by_role("dialog", name="New formation")
    editor.get_by_label("Name").fill("my wave")
    editor.get_by_role("button", name="Draw").click()
    board = editor.get_by_role("group", name=re.compile("Drawing board"))
    box = board.bounding_box()
    page.mouse.move(box["x"] + 0.3 * box["width"], box["y"] + 0.4 * box["height"])
    page.mouse.down()
    page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 0.6 * box["height"], steps=4)
    page.mouse.move(box["x"] + 0.7 * box["width"], box["y"] + 0.4 * box["height"], steps=4)
    page.mouse.up()
    editor.get_by_text(re.compile("6 places")).wait_for()
    first = editor.get_by_role("button", name=re.compile("Point 1 of line 1"))
    first.focus()
    page.keyboard.press("ArrowUp")
    editor.get_by_role("button", name="Save", exact=True).click()
    text = written(show, "my wave")
    assert re.search(r'name = "my wave".*shape = "polyline".*points = ', text, re.DOTALL)
    page.get_by_role("dialog").wait_for(state="detached")

    own.get_by_role("button", name="gate", exact=True).click()
    editor = page.get_by_role("dialog", name="Formation gate")
    editor.get_by_label("Angle °").fill("90")
    editor.get_by_role("button", name="Save", exact=True).click()
    written(show, r"arc_deg = 90")
    page.get_by_role("dialog").wait_for(state="detached")
    own.get_by_role("button", name="1 use").click()
    assert page.evaluate("studio.selected.value.length") == 1
    own.get_by_role("button", name="Duplicate gate").click()
    written(show, r'name = "gate 2"')
    assert page.title() != "owned"


def test_a_gap_is_filled_with_the_ways_that_were_chosen(show: Studio, page: Any) -> None:
    page.evaluate("studio.selected.value = [2, 3].map(number => ({ list: 'segment', number }))")
    page.get_by_role("button", name="Fill …").click()
    window = page.get_by_role("dialog", name="Fill the gap before gate")
    options = window.get_by_role("radiogroup")
    options.get_by_role("radio").first.wait_for()
    assert options.get_by_role("radio").count() == 6
    assert options.get_by_text(re.compile(r"in all \d")).count() == 6
    options.get_by_role("radio", name=re.compile("Equal")).check()
    window.get_by_label("They turn").select_option("tangent")
    options.get_by_role("radio").first.wait_for()
    window.get_by_role("button", name="Fill the gap").click()
    written(show, FILLED)
    page.get_by_role("dialog").wait_for(state="detached")
    page.keyboard.press("Control+z")
    deadline = time.monotonic() + 60.0 * BUSY
    while 'match = "equal"' in show.loaded.path.read_text():
        assert time.monotonic() < deadline
        page.wait_for_timeout(20)


def test_dancers_are_linked_by_hand(show: Studio, page: Any) -> None:
    page.evaluate(f"studio.select({{ list: 'segment', number: {len(show.loaded.patch.segment)} }})")
    page.keyboard.press("w")
    window = page.get_by_role("dialog", name="Ways into gate")
    window.get_by_role("radio").first.wait_for()
    window.get_by_role("button", name="Link by hand …").click()
    before = window.get_by_label("Place of dancer 1", exact=True).input_value()
    window.get_by_label("Place of dancer 1", exact=True).select_option("5")
    assert window.get_by_label("Place of dancer 6", exact=True).input_value() == before
    window.get_by_role("button", name="Save these links").click()
    text = written(show, "gate linked")
    assert re.search(r'name = "gate linked"|shape = "places"', text)
    assert re.search(r'formation = "gate linked"', text)
    assert 'match = "number"' in text


def test_on_a_phone_the_library_and_the_ways_are_reached(show: Studio, page: Any) -> None:
    page.set_viewport_size({"width": 390, "height": 844})
    library = page.get_by_role("region", name="Library")
    library.get_by_role("button", name="Formations").click()
    page.evaluate("studio.cursor.value = 20")
    library.get_by_role("button", name="Put gate at the cursor").click()
    written(show, r'formation = "gate"\nmeasures = 4\nmeasure = 21')
    page.get_by_role("button", name="Choose …").click()
    window = page.get_by_role("dialog", name="Ways into gate")
    window.get_by_role("radio").first.wait_for()
    box = window.bounding_box()
    assert box["x"] >= 0
    assert box["x"] + box["width"] <= 390
    page.keyboard.press("Escape")
    window.wait_for(state="detached")


def test_takes_dance_side_by_side_and_are_chosen(show: Studio, page: Any) -> None:
    page.get_by_role("button", name="Steps", exact=True).first.click()
    page.get_by_role("button", name=re.compile("^side step")).first.click()
    takes = page.get_by_role("region", name="Takes").get_by_role("checkbox")
    takes.nth(1).wait_for()
    page.get_by_role("region", name="Takes").locator("canvas.figure").nth(1).wait_for()
    assert takes.first.is_checked()
    takes.first.uncheck()
    text = written(show, r'"?side step"? = \["')
    assert tomllib.loads(text)["takes"].keys() == {"side step"}
    page.get_by_text("From the next start on: takes").wait_for()
    takes.first.check()
    deadline = time.monotonic() + 8.0 * BUSY
    while tomllib.loads(show.loaded.path.read_text()).get("takes"):
        assert time.monotonic() < deadline
        time.sleep(0.02)
