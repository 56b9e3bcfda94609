"""The studio by axe: no finding on any of its views, in light and dark, on a phone, a tablet and a large screen."""

import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Final

import pytest

from tests.app.services.test_document_service import PATCH
from tests.app.services.test_studio_pages import KEY, Studio
from tests.control.waiting import BUSY
from tests.end_to_end.browser import browser, needs_browser
from tests.end_to_end.studio.begun_studio import begun_studio
from tests.places import ROOT
from tests.show.patch.edited_night import write_patch_folder

AXE: Final = ROOT / "studio" / "node_modules" / "axe-core" / "axe.min.js"
needs_axe = pytest.mark.skipif(
    not AXE.is_file(), reason="needs the packages of studio/ (make test installs them where npm is)"
)
pytestmark = [needs_browser, needs_axe, pytest.mark.browser, pytest.mark.long]

WIDTHS: Final = ((390, 844), (820, 1180), (1920, 1080))
MORE: Final = """
[[formation]]
name = "gate"
shape = "arc"
size = [5.0, 3.0]
[[segment]]
measure = 14
measures = 2
formation = "gate"
[[element]]
kind = "attract"
measure = 17
measures = 2
at = [1.0, 1.0]
[[sequence]]
group = "1"
measure = 18
steps = ["groove"]
[[signal]]
name = "bang"
measure = 4
[[react]]
on = "bang"
call = "/dance/light/level"
values = [0.5]
[[curve]]
name = "rise"
points = [[0, 0], [4, 1]]
[[at]]
measure = 6
call = "/dance/light/rim/colour"
values = [1, 0.5, 0]
[[scene]]
name = "dusk"
[[cue]]
name = "blackout"
text = "when she stands"
"""
State = Callable[[Any], Any]


def press(name: str, region: str | None = None, *, exact: bool = True) -> State:
    def act(page: Any) -> None:
        where = page if region is None else page.get_by_role("region", name=region)
        where.get_by_role("button", name=name, exact=exact).first.click()

    return act


def both(*acts: State) -> State:
    def act(page: Any) -> None:
        for one in acts:
            one(page)

    return act


def box(words: str) -> State:
    def act(page: Any) -> None:
        found = page.get_by_role("region", name="Timeline").get_by_role("button", name=re.compile(words)).first
        found.click(position={"x": 4, "y": 8})

    return act


def close(page: Any) -> None:
    page.keyboard.press("Escape")
    page.locator("dialog[open]").wait_for(state="detached")


def place_by_hand(page: Any) -> None:
    page.evaluate("studio.cursor.value = 11")
    page.get_by_role("button", name="Place by hand").click()
    page.locator(".place").first.wait_for()


def draw(page: Any) -> None:
    page.get_by_role("radio", name=re.compile("^Closed shape")).click()
    canvas = page.locator(".dancers canvas")
    canvas.evaluate("(element) => element.scrollIntoView({ block: 'center' })")
    page.wait_for_timeout(100)
    border = canvas.bounding_box()
    x, y = border["x"] + border["width"] / 2, border["y"] + border["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    for across, down in ((40, 0), (40, 40), (-40, 40)):
        page.mouse.move(x + across, y + down, steps=3)
    page.mouse.up()
    page.get_by_role("form", name="What becomes of the line").wait_for()


def choose_call(page: Any) -> None:
    page.get_by_role("group", name="What happens, 1").locator("summary").click()


def step_card(page: Any) -> None:
    page.get_by_role("region", name="Library").get_by_role("button", name=re.compile("^groove")).first.click()


def tool(name: str) -> State:
    return lambda page: page.get_by_role("radio", name=re.compile(f"^{name}")).click()


def steps_mode(page: Any) -> None:
    page.get_by_role("region", name="Timeline").get_by_role("button", name="Steps", exact=True).click()


STATES: Final[dict[str, tuple[State, State]]] = {
    "make": (press("Make"), lambda page: None),
    "formations": (press("Formations", "Library"), lambda page: None),
    "formation editor": (press("New …"), close),
    "elements": (press("Elements", "Library"), lambda page: None),
    "steps": (press("Steps", "Library"), lambda page: None),
    "step card": (step_card, close),
    "formation box": (box("formation gate"), lambda page: None),
    "ways": (press("Choose …"), close),
    "signal": (box("signal bang"), lambda page: None),
    "controls": (choose_call, lambda page: page.keyboard.press("Escape")),
    "call": (box("call light rim colour"), lambda page: None),
    "steps mode": (both(steps_mode, box("steps groove, dancer 1")), press("Group motion")),
    "element tool": (tool("Gather"), tool("Select")),
    "drawn": (draw, press("Cancel")),
    "placed by hand": (place_by_hand, press("Cancel")),
    "play": (press("Play", exact=True), lambda page: None),
    "looks": (press("Looks and cues"), lambda page: None),
    "storyboard": (press("Storyboard"), lambda page: None),
    "go": (both(press("Show"), press("Go")), lambda page: None),
    "stage": (both(press("Show"), press("Stage")), lambda page: None),
    "light": (press("Light"), lambda page: None),
    "clock": (press("Clock"), lambda page: None),
    "everything": (press("Everything"), lambda page: None),
    "keys": (press("Keys"), close),
}  # fmt: skip
"""Each state of the page: how it is reached from the one before, and how it is left."""


def findings(page: Any) -> list[str]:
    """What axe finds on the page as it stands."""
    if not page.evaluate("Boolean(window.axe)"):
        page.evaluate(AXE.read_text("utf-8"))
    told = page.evaluate("axe.run(document, { resultTypes: ['violations'] })")["violations"]
    return [
        f"{one['id']}: {node['target'][0]} {node['html'][:160]} {node['failureSummary'].splitlines()[-1]}"
        for one in told for node in one["nodes"]
    ]  # fmt: skip


@pytest.fixture
def show(tmp_path: Path) -> Iterator[Studio]:
    made = Studio(write_patch_folder(tmp_path, PATCH + MORE))
    yield made
    made.stop()


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize(("width", "height"), WIDTHS)
def test_views(show: Studio, tmp_path: Path, scheme: Any, width: int, height: int) -> None:
    found: list[str] = []
    with browser() as (opened, _):
        context = opened.new_context(
            viewport={"width": width, "height": height}, color_scheme=scheme, reduced_motion="reduce"
        )
        page = context.new_page()
        page.set_default_timeout(8_000 * BUSY)
        page.goto(f"http://127.0.0.1:{show.web.port}/studio#key={KEY}")
        page.get_by_role("region", name="Timeline").get_by_role("button", name=re.compile("gate")).first.wait_for()
        for name, (reach, leave) in STATES.items():
            reach(page)
            page.wait_for_timeout(250)  # what glides in has arrived
            page.screenshot(path=tmp_path / f"{name} {width} {scheme}.png")
            found += [f"{name}: {one}" for one in findings(page)]
            leave(page)
    assert not found, "\n".join(found)


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_start_page_and_door(tmp_path: Path, scheme: Any) -> None:
    found: list[str] = []
    with begun_studio(tmp_path, color_scheme=scheme) as begun:
        page = begun.page
        for width, height in WIDTHS:
            page.set_viewport_size({"width": width, "height": height})
            for way in ("From a song", "From an example"):
                page.get_by_role("button", name=way).click()
                page.screenshot(path=tmp_path / f"start {way} {width} {scheme}.png")
                found += findings(page)
        page.evaluate("localStorage.clear()")
        page.goto(begun.link.partition("#")[0])
        page.get_by_role("heading", name="Open the studio").wait_for()
        page.screenshot(path=tmp_path / f"door {scheme}.png")
        found += findings(page)
    assert not found, "\n".join(found)
