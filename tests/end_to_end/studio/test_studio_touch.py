"""The studio by fingers: a tablet without mouse and keyboard."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.app.services.test_document_service import PATCH
from tests.app.services.test_studio_pages import KEY, Studio
from tests.end_to_end.browser import browser, needs_browser
from tests.end_to_end.studio.test_studio_stage import DEPTH, WIDTH, at, place_of
from tests.end_to_end.studio.test_studio_timeline import MORE, TIMEOUT, box, middle, show_of, until, written

pytestmark = [needs_browser, pytest.mark.browser, pytest.mark.long]
LONG_PRESS_MS = 600
SELECTED = "studio.selected.value.map((one) => `${one.list} ${one.number}`).sort().join()"


@pytest.fixture
def show(tmp_path: Path) -> Iterator[Studio]:
    stage = f"[stage]\nwidth = {WIDTH}\ndepth = {DEPTH}\n"
    yield from show_of(tmp_path, PATCH.replace("measure = 8", "measure = 28") + MORE + stage)


class Tablet:
    """A page in a context with a touch screen, and one finger."""

    def __init__(self, opened: Any, show: Studio) -> None:
        context = opened.new_context(viewport={"width": 1280, "height": 900}, has_touch=True, reduced_motion="reduce")
        self.page = context.new_page()
        self.page.set_default_timeout(TIMEOUT)
        self.page.goto(f"http://127.0.0.1:{show.web.port}/studio#key={KEY}")
        self.page.get_by_role("region", name="Timeline").get_by_role("group", name="ember").first.wait_for()
        self.page.get_by_label("Follow").uncheck()
        self.page.evaluate("studio.scale.value = 40")
        self._devtools = context.new_cdp_session(self.page)

    def send(self, kind: str, *place: float) -> None:
        points = [{"x": place[0], "y": place[1], "id": 1}] if place else []
        self._devtools.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    def tap(self, place: tuple[float, float]) -> None:
        self.send("touchStart", *place)
        self.send("touchEnd")

    def drag(self, start: tuple[float, float], end: tuple[float, float], *, rest: bool = False) -> None:
        self.send("touchStart", *start)
        if rest:
            self.page.wait_for_timeout(LONG_PRESS_MS)
        for step in range(1, 7):
            self.send("touchMove", *(a + step / 6 * (b - a) for a, b in zip(start, end, strict=True)))
        self.send("touchEnd")


@pytest.fixture
def tablet(show: Studio) -> Iterator[Tablet]:
    with browser() as (opened, _):
        yield Tablet(opened, show)


def test_boxes_are_moved_added_to_the_selection_and_encircled(show: Studio, tablet: Tablet) -> None:
    page = tablet.page
    ember, tide = middle(page, "circle, ember"), middle(page, "star, tide")
    tablet.tap(ember)
    until(page, f"{SELECTED} === 'segment 3'")
    tablet.send("touchStart", *tide)
    until(page, f"{SELECTED} === 'segment 3,segment 4'")  # a finger that rests adds a box
    tablet.send("touchEnd")
    until(page, f"{SELECTED} === 'segment 3,segment 4'")
    tablet.drag(tide, (tide[0] + 80, tide[1]))
    written(show, page, r'measure = 8\nmeasures = 2\ngroup = "ember".*measure = 8\nmeasures = 2\ngroup = "tide"')
    page.evaluate("studio.select(null)")
    begin = box(page, "circle, ember").bounding_box()
    left = (begin["x"] - 30, begin["y"] + begin["height"] / 2)
    scrolled = page.evaluate("document.querySelector('.tracks').scrollLeft")
    tablet.drag(left, (left[0] + 90, middle(page, "star, tide")[1]), rest=True)
    until(page, f"{SELECTED} === 'segment 3,segment 4'")
    assert page.evaluate("document.querySelector('.tracks').scrollLeft") == scrolled
    assert page.evaluate("studio.doc.revision.value") == show.service.revision  # nothing moved by that


def test_a_finger_scrolls_and_a_double_tap_begins_a_box(show: Studio, tablet: Tablet) -> None:
    page = tablet.page
    begin = box(page, "circle, ember").bounding_box()
    free = (begin["x"] + begin["width"] + 130, begin["y"] + begin["height"] / 2)
    tablet.drag(free, (free[0] - 200, free[1]))
    until(page, "document.querySelector('.tracks').scrollLeft > 50")
    assert page.evaluate("studio.selected.value.length") == 0
    page.evaluate("document.querySelector('.tracks').scrollLeft = 0")
    tablet.tap(free)
    tablet.tap(free)
    text = written(show, page, r'measures = 4\nformation = "circle"|formation = "circle"\nmeasures = 4')
    page.wait_for_timeout(1000)
    assert show.loaded.path.read_text() == text  # one box, though the browser tells a double click, too


def test_a_line_is_drawn_by_taps_and_the_lasso_adds_dancers(show: Studio, tablet: Tablet) -> None:
    page = tablet.page
    page.get_by_role("radio", name="Line:").tap()
    for place in ((-3.0, 1.0), (0.0, -1.0), (3.0, 1.0)):
        tablet.tap(at(page, *place))
    line = page.get_by_role("group", name="The line")
    line.get_by_text("3 points").wait_for()
    line.get_by_role("button", name="One point back").tap()
    line.get_by_text("2 points").wait_for()
    tablet.tap(at(page, 2.0, 2.0))
    line.get_by_role("button", name="Finish").tap()
    line.wait_for(state="detached")
    page.get_by_label("What becomes of the line").wait_for()
    page.keyboard.press("Escape")
    page.get_by_role("radio", name="Lasso").tap()
    for dancer in (2, 5, 6):
        tablet.tap(at(page, *place_of(page, dancer)))
    until(page, "String(studio.dancers.value) === '2,5,6'")
    tablet.tap(at(page, *place_of(page, 5)))
    until(page, "String(studio.dancers.value) === '2,6'")
