"""The studio's stage in a browser: selecting, drawing, placing by hand, the preview at the cursor; a real show."""

import json
import math
import re
import time
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
WIDTH, DEPTH, MARGIN = 10.0, 6.0, 1.1
HOSTILE = "<img src=x onerror=document.title='owned'>"
MORE = f"""
[stage]
width = {WIDTH}
depth = {DEPTH}
[[element]]
kind = "attract"
measure = 5
measures = 2
at = [1.0, 1.0]
[[obstacle]]
name = "{HOSTILE}"
at = [-3.0, -2.0]
radius = 0.4
"""


@pytest.fixture
def show(tmp_path: Path) -> Iterator[Studio]:
    made = Studio(write_patch_folder(tmp_path, PATCH + MORE))
    yield made
    made.stop()


@pytest.fixture
def page(show: Studio) -> Iterator[Any]:
    with browser() as (opened, _):
        context = opened.new_context(viewport={"width": 1440, "height": 900}, has_touch=True)
        made = context.new_page()
        made.set_default_timeout(15_000 * BUSY)
        errors: list[str] = []
        made.on("pageerror", lambda error: errors.append(str(error)))
        made.on("console", lambda message: message.type == "error" and errors.append(message.text))
        made.goto(f"http://127.0.0.1:{show.web.port}/studio#key={KEY}")
        until(made, "Boolean(window.studio?.doc.positions.value && studio.doc.structure.value)")
        yield made
        assert not errors
        assert made.title().startswith("Studio")
        context.close()


def until(page: Any, expression: str) -> Any:
    """Wait until an expression is true in the page; return it."""
    deadline = time.monotonic() + 15.0 * BUSY
    while not (found := page.evaluate(expression)):
        assert time.monotonic() < deadline, expression
        page.wait_for_timeout(20)
    return found


def written(show: Studio, wanted: str) -> str:
    """Wait until a pattern is in the show's file; return the file."""
    deadline = time.monotonic() + 15.0 * BUSY
    while not re.search(wanted, text := show.loaded.path.read_text(), re.DOTALL):
        assert time.monotonic() < deadline, text
        time.sleep(0.02)
    return text


def at(page: Any, x: float, z: float) -> tuple[float, float]:
    """Page pixels of a place on the stage [m]."""
    box = page.locator(".dancers canvas").bounding_box()
    scale = min(box["width"] / (WIDTH + 2 * MARGIN), box["height"] / (DEPTH + 2 * MARGIN))
    return box["x"] + box["width"] / 2 + x * scale, box["y"] + box["height"] / 2 + z * scale


def place_of(page: Any, dancer: int) -> tuple[float, float]:
    row = page.evaluate(f"[...studio.doc.positions.value.rows.slice({3 * dancer - 3}, {3 * dancer - 1})]")
    return row[0], row[1]


def stroke(page: Any, *places: tuple[float, float]) -> None:
    page.mouse.move(*at(page, *places[0]))
    page.mouse.down()
    for place in places[1:]:
        page.mouse.move(*at(page, *place), steps=4)
    page.mouse.up()


def chosen(page: Any) -> list[int]:
    return list(page.evaluate("studio.dancers.value"))


def test_dancers_are_chosen_by_clicks_boxes_lassos_groups_and_keys(show: Studio, page: Any) -> None:
    page.mouse.click(*at(page, *place_of(page, 2)))
    until(page, "String(studio.dancers.value) === '2'")
    page.keyboard.down("Shift")
    page.mouse.click(*at(page, *place_of(page, 5)))
    page.keyboard.up("Shift")
    until(page, "String(studio.dancers.value) === '2,5'")
    stroke(page, (-4.9, -2.9), (4.9, 2.9))
    until(page, "studio.dancers.value.length === 6")
    page.get_by_role("radio", name="Lasso").click()
    x, z = place_of(page, 3)
    stroke(page, *[(x + 0.45 * math.cos(a), z + 0.45 * math.sin(a)) for a in (0, 1.2, 2.4, 3.6, 4.8, 6.0)])
    until(page, "studio.dancers.value.includes(3)")
    page.get_by_role("group", name="Select a group").get_by_role("button", name="tide").click()
    assert chosen(page) == [4, 5, 6]
    page.get_by_role("radio", name="Select").click()
    listed = page.get_by_role("listbox", name="Dancers on the stage")
    listed.focus()
    page.keyboard.press("Control+a")
    until(page, "studio.dancers.value.length === 6")
    page.keyboard.press("ArrowRight")
    page.keyboard.press("Enter")
    until(page, "studio.dancers.value.length === 1")
    assert listed.get_attribute("aria-activedescendant") == f"dancer-{chosen(page)[0]}"
    assert listed.get_by_role("option", selected=True).count() == 1


def test_the_cursor_shows_the_preview_and_back_to_now(show: Studio, page: Any) -> None:
    page.evaluate("studio.cursor.value = 7")
    which = page.locator(".moment .which")
    page.get_by_text("Measure 8, preview").wait_for()
    page.locator(".moment .hint").wait_for(state="detached")
    page.get_by_role("button", name="Back to now").click()
    assert which.inner_text() == "Now"
    page.get_by_label("First measure").fill("8")
    page.get_by_label("Last measure").fill("9")
    page.get_by_role("button", name="Play", exact=True).last.click()
    page.get_by_text("Measures 8–9, preview").wait_for()
    page.get_by_role("button", name="Stop").click()
    assert which.inner_text() == "Now"


def test_a_drawn_shape_becomes_a_formation_which_is_undone_as_one(show: Studio, page: Any) -> None:
    before = show.loaded.path.read_text()
    page.evaluate("studio.cursor.value = 11")
    page.get_by_role("radio", name="Closed shape").click()
    stroke(page, *[(2.5 * math.cos(a / 3), 1.8 * math.sin(a / 3)) for a in range(19)])
    form = page.get_by_role("form", name="What becomes of the line")
    form.get_by_label("inside").check()
    form.get_by_label("Pattern").select_option("concentric")
    form.get_by_label("Symmetry").select_option("left-right")
    form.get_by_role("button", name="Put it at measure 12").click()
    text = written(show, r'measure = 12\b.*formation = "drawn 1"|formation = "drawn 1".*measure = 12\b')
    assert re.search(
        r'name = "drawn 1".*shape = "polyline".*dancers = "inside".*pattern = "concentric"', text, re.DOTALL
    )
    assert 'mirror = "left-right"' in text
    until(page, "studio.score.value.formation?.length === 1")
    page.keyboard.press("Control+z")
    until(page, "!(studio.score.value.formation?.length)")
    assert show.loaded.path.read_text() == before


def test_places_are_put_by_hand_with_mouse_and_keyboard(show: Studio, page: Any) -> None:
    page.evaluate("studio.cursor.value = 11; studio.dancers.value = [1, 2, 4]")
    page.get_by_role("button", name="Place by hand").click()
    handle = page.locator(".place").first
    box = handle.bounding_box()
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.mouse.down()
    page.mouse.move(*at(page, -2.0, 1.5), steps=5)
    page.mouse.up()
    second = page.locator(".place").nth(1)
    second.focus()
    for key in ("ArrowRight", "ArrowDown", ">", ">"):
        page.keyboard.press(key)
    turned = page.get_by_role("button", name=re.compile(r"^Dancer 2 at .* facing -?\d+ degrees, .* m from dancer"))
    assert turned.count() == 1
    page.get_by_role("button", name="Keep").click()
    text = written(show, r'match = "number"')
    table = re.search(r'name = "placed 1".*?points = (\[\[.*?\]\])', text, re.DOTALL)
    assert table is not None
    first = json.loads(table[1])[0]
    assert first == pytest.approx([-2.0, 1.5], abs=0.06)
    assert 'group = "1-2 + 4"' in text


def test_elements_are_put_dragged_and_tried(show: Studio, page: Any) -> None:
    page.evaluate("studio.cursor.value = 11")
    page.get_by_role("radio", name="Change sides").click()
    page.get_by_role("listbox", name="Dancers on the stage").focus()
    for key in ("ArrowUp", "Enter", "ArrowDown", "ArrowDown", "ArrowDown", "ArrowDown", "Enter"):
        page.keyboard.press(key)
    written(show, r'kind = "cross"')
    page.get_by_text("Measures 12–15, preview").wait_for()
    page.get_by_role("button", name="Back to now").click()
    page.evaluate("studio.select({ list: 'element', number: 1 })")
    page.get_by_role("button", name="Try", exact=True).click()
    handle = page.get_by_role("button", name=re.compile("^attract at 1.0, 1.0 m"))
    handle.focus()
    page.keyboard.press("Shift+ArrowLeft")
    send = page.get_by_role("button", name="Send 1")
    send.wait_for()
    assert "at = [1.0, 1.0]" in show.loaded.path.read_text()
    send.click()
    written(show, r"at = \[0\.0, 1\.0\]|at = \[0, 1\.0\]|at = \[0, 1\]")


def test_a_browser_without_webgl_keeps_the_stage_from_above(show: Studio, page: Any) -> None:
    page.evaluate(
        "HTMLCanvasElement.prototype.getContext = new Proxy(HTMLCanvasElement.prototype.getContext, "
        "{ apply: (real, self, args) => String(args[0]).startsWith('webgl') ? null : real.apply(self, args) }); 0"
    )
    page.get_by_role("button", name="3D", exact=True).click()
    page.get_by_text("3D needs WebGL").wait_for()
    assert page.locator(".solid").count() == 0


def test_the_other_measure_line_is_shown_and_can_be_pressed(show: Studio, page: Any) -> None:
    alignment = show.show.follower._alignment
    assert page.get_by_role("button", name="later").count() == 0
    alignment.runner_up = (1.0, 0.4)
    page.get_by_role("button", name="or the one 1 beat later 40 %").wait_for()
    alignment.runner_up, alignment._pinned, alignment._likely_since = (2.0, 0.95), True, -1000.0  # for many measures
    asks = page.get_by_role("button", name="Is the one 2 beats later? 95 %")
    asks.wait_for()
    page.evaluate("window.taken = []; studio.values.send = (address) => window.taken.push(address); 0")
    asks.click()
    assert page.evaluate("window.taken") == ["/dance/clock/take"]
