"""The studio when something goes wrong: lost connections, an engine's heir, two tabs of one person, narrow windows."""

import os
import re
import signal
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.app.services.test_document_service import PATCH
from tests.app.services.test_studio_pages import Studio
from tests.control.waiting import BUSY
from tests.end_to_end.browser import browser, needs_browser
from tests.end_to_end.conftest import Running, children
from tests.end_to_end.studio.test_studio_timeline import MORE, box, drag, middle, opened_page, show_of, until, written
from tests.show.patch.edited_night import write_patch_folder

pytestmark = [needs_browser, pytest.mark.browser, pytest.mark.long]
KEY = "a-key-of-the-tests-4711"
WEB, OSC = 19_043, 19_044
HOSTILE = "<img src=x onerror=document.title='owned'>"
WIDEST_OVERFLOW = "document.documentElement.scrollWidth - document.documentElement.clientWidth"


@pytest.fixture
def show(tmp_path: Path) -> Iterator[Studio]:
    yield from show_of(tmp_path, PATCH.replace("measure = 8", "measure = 28") + MORE)


def lose_connection(show: Studio) -> None:
    """Kill the web process; the show starts another one two seconds later."""
    assert show.web.pid is not None
    os.kill(show.web.pid, signal.SIGKILL)


def test_a_drag_whose_connection_is_lost_is_sent_once(show: Studio) -> None:
    with opened_page(show, errors_allowed=True) as page:
        revision = show.service.revision
        drag(page, middle(page, "circle, ember"), (85, 0), let_go=False)
        lose_connection(show)
        until(page, "studio.doc.link.state.value === 'lost'")
        page.mouse.up()
        page.get_by_text("No connection").first.wait_for()
        written(show, page, r'measure = 8\nmeasures = 2\ngroup = "ember"')
        assert show.service.revision == revision + 1
        until(page, "studio.doc.waiting.value.length === 0")
        page.keyboard.press("Control+z")
        written(show, page, r'measure = 6\nmeasures = 2\ngroup = "ember"')


def test_a_formation_that_is_saved_while_the_connection_is_lost_comes_later(show: Studio) -> None:
    with opened_page(show, errors_allowed=True) as page:
        page.get_by_role("button", name="Formations").click()
        page.get_by_role("button", name="New …").click()
        page.get_by_label("Name", exact=True).fill("late one")
        lose_connection(show)
        until(page, "studio.doc.link.state.value === 'lost'")
        page.get_by_role("button", name=re.compile("^Save")).click()
        written(show, page, r'name = "late one"')
        assert show.loaded.path.read_text().count('"late one"') == 1


def test_two_tabs_of_one_person_edit_and_undo_as_one(show: Studio) -> None:
    with opened_page(show) as one:
        other = one.context.new_page()
        other.goto(one.url)
        other.get_by_role("region", name="Timeline").get_by_role("group", name="ember").first.wait_for()
        assert other.evaluate("studio.by") == one.evaluate("studio.by")
        box(one, "circle, ember").click()
        one.keyboard.press("Alt+ArrowRight")
        written(show, one, r'measure = 7\nmeasures = 2\ngroup = "ember"')
        until(other, f"studio.doc.revision.value === {show.service.revision}")
        other.get_by_role("region", name="Timeline").get_by_role("heading", name="Timeline").click()
        other.keyboard.press("Control+z")  # the edits are the person's, not the tab's
        written(show, other, r'measure = 6\nmeasures = 2\ngroup = "ember"')
        until(one, f"studio.doc.revision.value === {show.service.revision}")
        other.close()


@pytest.mark.parametrize("width", [320, 390, 820])
def test_a_narrow_window_reaches_every_view(show: Studio, width: int) -> None:
    with opened_page(show) as page:
        page.set_viewport_size({"width": width, "height": 640})
        for view in ("Play", "Show", "Storyboard", "Make"):
            page.get_by_role("navigation", name="Views").get_by_role("button", name=view).click()
            page.wait_for_timeout(100)
            assert page.evaluate(WIDEST_OVERFLOW) <= 0, view
        page.get_by_role("navigation", name="Views").get_by_role("button", name="Show").click()
        for role in ("Stage", "Light", "Clock", "Everything", "Go"):
            page.get_by_role("navigation", name="Roles").get_by_role("button", name=role).click()
            page.wait_for_timeout(100)
            assert page.evaluate(WIDEST_OVERFLOW) <= 0, role


def test_hostile_names_are_text_in_every_view(tmp_path: Path) -> None:
    text = PATCH.replace('"edited"', f'"{HOSTILE}"').replace('"ember"', f'"{HOSTILE}"') + (
        f'[[cue]]\nname = "{HOSTILE} cue"\ntext = "{HOSTILE}"\n'
        f'[[formation]]\nname = "{HOSTILE} formation"\nshape = "line"\n'
        f'[[scene]]\nname = "{HOSTILE} scene"\nset = {{ "/dance/light/key" = 1.0 }}\n'
    )
    made = Studio(write_patch_folder(tmp_path, text))
    try:
        with browser() as (opened, _):
            page = opened.new_page()
            page.goto(f"http://127.0.0.1:{made.web.port}/studio#key={KEY}")
            page.get_by_role("region", name="Timeline").wait_for()
            for view in ("Play", "Show", "Storyboard", "Make"):
                page.get_by_role("navigation", name="Views").get_by_role("button", name=view).click()
                page.wait_for_timeout(150)
            for panel in ("Formations", "Elements", "Steps"):
                page.get_by_role("button", name=panel, exact=True).first.click()
                page.wait_for_timeout(150)
            assert page.locator("img").count() == 0
            assert page.title() != "owned"
    finally:
        made.stop()


def test_an_engine_is_replaced_by_its_heir_while_somebody_edits(play: Callable[..., Running], tmp_path: Path) -> None:
    patch = write_patch_folder(tmp_path, PATCH.replace("measure = 8", "measure = 28") + MORE)
    running = play(
        str(patch), "--headless", "--web", str(WEB), "--web-key", KEY, "--osc", f"127.0.0.1:{OSC}",
    )  # fmt: skip
    running.wait_for(lambda line: line["alive"].get("spare", False) and line["measure"] > 1, 90)
    with browser() as (opened, _):
        page = opened.new_context(viewport={"width": 1440, "height": 1000}, reduced_motion="reduce").new_page()
        page.goto(f"http://127.0.0.1:{WEB}/studio#key={KEY}")
        page.get_by_role("region", name="Timeline").get_by_role("group", name="ember").first.wait_for()
        page.get_by_label("Follow").uncheck()
        page.evaluate("studio.scale.value = 40")
        box(page, "circle, ember").click()
        page.keyboard.press("Alt+ArrowRight")
        in_file(patch, r'measure = 7\nmeasures = 2\ngroup = "ember"')
        os.kill(children(running, "engine_main")[0], signal.SIGKILL)
        for _ in range(3):  # at once: nothing that is pressed meanwhile is lost
            page.keyboard.press("Alt+ArrowRight")
            page.wait_for_timeout(150)
        in_file(patch, r'measure = 10\nmeasures = 2\ngroup = "ember"')
        until(page, "studio.doc.waiting.value.length === 0")
        told = page.evaluate("studio.doc.notices.value.filter((one) => one.tone === 'refused')")
        # the engine may have died between taking an edit and answering it: that is told, and nothing is done twice
        assert all("connection was lost while" in fault["what"] for one in told for fault in one["faults"]), told
        assert len(told) <= 1
        page.keyboard.press("Control+z")
        in_file(patch, r'measure = 9\nmeasures = 2\ngroup = "ember"')
    assert running.lines()[-1]["alive"]["restarts"] == 1


def in_file(path: Path, wanted: str) -> None:
    deadline = time.monotonic() + 20.0 * BUSY
    while not re.search(wanted, path.read_text(), re.DOTALL):
        assert time.monotonic() < deadline, path.read_text()
        time.sleep(0.05)
