"""The studio's timeline and inspector in a browser: a real show, a real preview, a mouse and a keyboard."""

import contextlib
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
HOSTILE = "<img src=x onerror=document.title='owned'>"
MORE = f"""
[[segment]]
measure = 6
measures = 2
group = "ember"
formation = "circle"
[[segment]]
measure = 6
measures = 2
group = "tide"
formation = "star"
[[sequence]]
measure = 3
group = "tide"
steps = ["groove x2", "side step x2"]
[[curve]]
name = "{HOSTILE}"
points = [[0.0, 0.0], [4.0, 1.0], [8.0, 0.5]]
"""
SECTIONS = """
[[section]]
name = "verse"
measures = 8
[[section]]
name = "chorus"
measures = 4
repeat = 2
"""
TIMEOUT = 20_000 * BUSY


def show_of(tmp_path: Path, text: str) -> Iterator[Studio]:
    made = Studio(write_patch_folder(tmp_path, text))
    yield made
    made.stop()


@pytest.fixture
def show(tmp_path: Path) -> Iterator[Studio]:
    yield from show_of(tmp_path, PATCH.replace("measure = 8", "measure = 28") + MORE)


@pytest.fixture
def page(show: Studio) -> Iterator[Any]:
    with opened_page(show) as made:
        yield made


@contextlib.contextmanager
def opened_page(show: Studio, more: int = 0, *, errors_allowed: bool = False) -> Iterator[Any]:
    """Yield a page that shows the timeline, `more`: a list with further ones; none may have an error in the end, unless
    `errors_allowed`: a browser tells of lost connections as errors."""
    with browser() as (opened, _):
        errors: list[str] = []

        def made() -> Any:
            context = opened.new_context(viewport={"width": 1440, "height": 1000}, reduced_motion="reduce")
            page = context.new_page()
            page.set_default_timeout(TIMEOUT)
            page.on("pageerror", lambda error: errors.append(str(error)))
            page.on("console", lambda message: message.type == "error" and errors.append(message.text))
            page.goto(f"http://127.0.0.1:{show.web.port}/studio#key={KEY}")
            page.get_by_role("region", name="Timeline").get_by_role("group", name="ember").first.wait_for()
            page.get_by_label("Follow").uncheck()
            page.evaluate("studio.scale.value = 40")
            return page

        pages = [made() for _ in range(1 + more)]
        yield pages[0] if not more else pages
        assert errors_allowed or not errors


def written(show: Studio, page: Any, wanted: str) -> str:
    """Wait until a pattern is in the show's file, and the page knows of it; return the file."""
    deadline = time.monotonic() + 8.0 * BUSY
    while not re.search(wanted, text := show.loaded.path.read_text(), re.DOTALL):
        assert time.monotonic() < deadline, text
        time.sleep(0.02)
    until(page, f"studio.doc.revision.value === {show.service.revision}")
    page.evaluate("new Promise((drawn) => requestAnimationFrame(() => requestAnimationFrame(drawn)))")
    return text


def until(page: Any, expression: str) -> None:
    """Poll until an expression is true in the page, whose security policy forbids long evaluation."""
    deadline = time.monotonic() + 8.0 * BUSY
    while not page.evaluate(expression):
        assert time.monotonic() < deadline, f"waited in vain for {expression}"
        page.wait_for_timeout(20)


def box(page: Any, words: str) -> Any:
    return page.get_by_role("region", name="Timeline").get_by_role("button", name=re.compile(words))


def drag(page: Any, start: tuple[float, float], by: tuple[float, float], *, let_go: bool = True) -> None:
    page.mouse.move(*start)
    page.mouse.down()
    page.mouse.move(start[0] + by[0] / 2, start[1] + by[1] / 2, steps=3)
    page.mouse.move(start[0] + by[0], start[1] + by[1], steps=3)
    if let_go:
        page.mouse.up()


def middle(page: Any, words: str) -> tuple[float, float]:
    found = box(page, words).bounding_box()
    return found["x"] + found["width"] / 2, found["y"] + found["height"] / 2


def test_boxes_are_moved_resized_copied_and_given_to_others(show: Studio, page: Any) -> None:
    drag(page, middle(page, "circle, ember"), (85, 0))
    written(show, page, r'measure = 8\nmeasures = 2\ngroup = "ember"')
    edge = box(page, "circle, ember").bounding_box()
    drag(page, (edge["x"] + edge["width"] - 3, edge["y"] + 10), (40, 0))
    written(show, page, r'measure = 8\nmeasures = 3\ngroup = "ember"')
    rows = [page.get_by_role("group", name=name, exact=True).first.bounding_box()["y"] for name in ("ember", "tide")]
    drag(page, middle(page, "circle, ember"), (0, rows[1] - rows[0]))
    written(show, page, r'measure = 8\nmeasures = 3\ngroup = "tide"\nformation = "circle"')
    page.keyboard.press("Control+z")
    written(show, page, r'measure = 8\nmeasures = 3\ngroup = "ember"\nformation = "circle"')
    page.keyboard.down("Alt")
    drag(page, middle(page, "circle, ember"), (160, 0))
    page.keyboard.up("Alt")
    written(show, page, r'measure = 12\nmeasures = 3\ngroup = "ember"')
    until(page, "studio.score.value.segment.length === 5")
    before = show.loaded.path.read_text()
    drag(page, middle(page, "star, tide"), (80, 0), let_go=False)
    assert page.locator(".ghost").count() == 1
    page.keyboard.press("Escape")
    page.mouse.up()
    assert page.locator(".ghost").count() == 0
    assert show.loaded.path.read_text() == before


def test_many_boxes_are_one_edit(show: Studio, page: Any) -> None:
    ember = page.get_by_role("group", name="ember", exact=True).first.bounding_box()
    tide = page.get_by_role("group", name="tide", exact=True).first.bounding_box()
    start = box(page, "circle, ember").bounding_box()["x"] - 30
    drag(page, (start, ember["y"] + 4), (170, tide["y"] + tide["height"] - 6 - ember["y"]))
    assert page.get_by_text("2 selected").first.is_visible()
    revision = page.evaluate("studio.doc.revision.value")
    drag(page, middle(page, "star, tide"), (40, 0))
    written(show, page, r'measure = 7\nmeasures = 2\ngroup = "ember".*measure = 7\nmeasures = 2\ngroup = "tide"')
    until(page, f"studio.doc.revision.value === {revision + 1}")
    page.keyboard.press("Control+z")
    written(show, page, r'measure = 6\nmeasures = 2\ngroup = "ember".*measure = 6\nmeasures = 2\ngroup = "tide"')


def test_refused_drags_say_why_before_they_are_let_go(show: Studio, page: Any) -> None:
    drag(page, middle(page, "star, tide"), (-120, 0), let_go=False)  # where everybody goes into a line
    page.locator(".ghost-words.refused").wait_for()
    page.keyboard.press("Escape")
    page.mouse.up()
    page.evaluate("studio.clipboard.value = [{list: 'segment', entry: {formation: 'nobody knows it'}, after: 0}]")
    page.keyboard.press("Control+v")
    page.get_by_role("log", name="Messages").get_by_text(re.compile("unknown formation")).first.wait_for()


def test_keys_do_all_that_the_mouse_does(show: Studio, page: Any) -> None:
    page.get_by_role("button", name="Steps", exact=True).last.click()
    page.evaluate("studio.mode.value = 'steps'")
    box(page, "groove x2, side step x2").wait_for()
    page.get_by_role("region", name="Timeline").get_by_role("button", name="tide", exact=True).focus()
    page.keyboard.press("Enter")
    page.keyboard.press("Escape")
    for _ in range(6):  # the first box of a row below
        if page.evaluate("studio.selected.value.length && studio.selected.value[0].list === 'sequence'"):
            break
        page.keyboard.press("ArrowDown")
    assert page.evaluate("document.activeElement.dataset.key") == "sequence 1"
    page.keyboard.press("Alt+ArrowRight")
    written(show, page, r"\[\[sequence\]\]\nmeasure = 4")
    until(page, "studio.score.value.sequence[0].measure === 4")
    page.evaluate("studio.cursor.value = 5")
    page.keyboard.press("s")
    written(
        show, page, r'measure = 4\ngroup = "tide"\nsteps = \["groove x2"\].*measure = 6.*steps = \["side step x2"\]'
    )
    until(page, "studio.score.value.sequence.length === 2")
    page.keyboard.press("Control+a")
    page.keyboard.press("j")
    written(show, page, r'measure = 4\ngroup = "tide"\nsteps = \["groove x2", "side step x2"\]')
    until(page, "studio.score.value.sequence.length === 1")
    page.evaluate("studio.selected.value = [{list: 'sequence', number: 1}]")
    page.keyboard.press("Control+c")
    page.evaluate("studio.cursor.value = 19")
    page.keyboard.press("Control+v")
    written(show, page, r'steps = \["groove x2", "side step x2"\].*measure = 20')
    until(page, "studio.selected.value[0]?.number === 2")
    page.keyboard.press("Delete")
    until(page, "studio.score.value.sequence.length === 1")


def test_a_double_click_begins_a_box(show: Studio, page: Any) -> None:
    lane = page.get_by_role("group", name="tide", exact=True).first.locator(".lane").bounding_box()
    page.mouse.dblclick(lane["x"] + 15 * 40 + 5, lane["y"] + 15)
    written(show, page, r'measure = 16\ngroup = "tide"\nmeasures = 4|measure = 16\nmeasures = 4\n.*group = "tide"')


def test_a_canon_a_curve_and_a_range(show: Studio, page: Any) -> None:
    page.evaluate("studio.snap.value = 'beat'")
    box(page, "circle, ember").click()
    handle = page.locator(".canon").first.bounding_box()
    drag(page, (handle["x"] + 6, handle["y"] + 6), (20, 0))
    written(show, page, r"formation = \"circle\"\nbeats_later = 2")
    assert HOSTILE in page.get_by_role("region", name="Timeline").inner_text()
    assert page.title() != "owned"
    knot = page.locator(".knot").nth(1).bounding_box()
    drag(page, (knot["x"] + 5, knot["y"] + 5), (40, 20))
    written(show, page, r"\[5(\.0)?, 0\.[3-7]")
    page.locator(".knot").nth(1).focus()
    page.keyboard.press("Delete")
    until(page, "studio.score.value.curve[0].points.length === 2")
    lane = page.locator(".track.curve .lane").bounding_box()
    page.mouse.dblclick(lane["x"] + 12 * 40, lane["y"] + 12)
    until(page, "studio.score.value.curve[0].points.length === 3")
    ruler = page.locator(".ruler .lane").bounding_box()
    drag(page, (ruler["x"] + 82, ruler["y"] + 50), (156, 0))
    assert page.evaluate("studio.range.value") == [2, 6]
    page.get_by_role("button", name="As danced").click()
    page.locator(".track.danced").first.wait_for()


def test_sections_are_blocks(tmp_path: Path) -> None:
    for show in show_of(tmp_path, PATCH.split("[[segment]]")[0] + SECTIONS):
        with opened_page(show) as page:
            verse = page.get_by_role("button", name=re.compile("^Section verse"))
            verse.dblclick()
            page.get_by_label("New name of verse").fill("opening")
            page.keyboard.press("Enter")
            written(show, page, 'name = "opening"')
            opening = page.get_by_role("button", name=re.compile("^Section opening"))
            opening.wait_for()
            place = opening.bounding_box()
            drag(page, (place["x"] + place["width"] - 3, place["y"] + 8), (80, 0))
            written(show, page, r'name = "opening"\nmeasures = 10')
            page.get_by_role("button", name="Add section").click()
            written(show, page, r'name = "part"')
            page.get_by_label("repeat").fill("3")
            page.keyboard.press("Enter")
            written(show, page, r'name = "part"\nmeasures = 8\nrepeat = 3')


def test_phrases_are_named_by_a_double_click_and_by_a_key(show: Studio, page: Any) -> None:
    ruler = page.locator(".ruler .lane").first.bounding_box()
    page.mouse.dblclick(ruler["x"] + 4 * 40 + 12, ruler["y"] + 33)
    page.get_by_label("Name of the phrase that begins in measure 5").fill("verse")
    page.keyboard.press("Enter")
    written(show, page, r'\[\[music\.phrase\]\]\nmeasure = 5\nname = "verse"')
    page.mouse.dblclick(ruler["x"] + 4 * 40 + 12, ruler["y"] + 33)
    page.get_by_label("Name of the phrase that begins in measure 5").fill("couplet")
    page.keyboard.press("Enter")
    written(show, page, r'measure = 5\nname = "couplet"')
    page.mouse.click(ruler["x"] + 8 * 40 + 12, ruler["y"] + 52)
    page.keyboard.press("p")
    page.get_by_label("Name of the phrase that begins in measure 9").fill("bridge")
    page.keyboard.press("Enter")
    written(show, page, r'name = "couplet".*measure = 9\nname = "bridge"')
    page.keyboard.press("p")
    page.get_by_label("Name of the phrase that begins in measure 9").fill("")
    page.keyboard.press("Escape")  # nothing changes
    page.keyboard.press("p")
    assert page.get_by_label("Name of the phrase that begins in measure 9").input_value() == "bridge"
    page.get_by_label("Name of the phrase that begins in measure 9").fill("")
    page.keyboard.press("Enter")
    deadline = time.monotonic() + 8.0 * BUSY
    while "bridge" in show.loaded.path.read_text():
        assert time.monotonic() < deadline
        page.wait_for_timeout(20)


def test_measures_behind_a_section_that_waits_are_looked_at_and_have_pictures(tmp_path: Path) -> None:
    sections = SECTIONS.replace('name = "verse"', 'name = "verse"\nwait = true')
    text = PATCH.replace("measure = 8", 'section = "chorus"\nmeasure = 2') + sections
    for made in show_of(tmp_path, text):
        with opened_page(made) as page:
            ruler = page.locator(".ruler .lane").first.bounding_box()
            page.mouse.click(ruler["x"] + 11 * 40 + 12, ruler["y"] + 52)
            page.get_by_text("Measure 12, preview").wait_for()
            page.get_by_text("if somebody leads there").wait_for()
            page.locator(".moment .hint", has_text="working").wait_for(state="detached")
            page.get_by_role("navigation", name="Views").get_by_role("button", name="Storyboard").click()
            page.get_by_role(
                "button", name=re.compile("chorus, measures 2.* circle: look at it in Make")
            ).first.wait_for()


def test_the_inspector_changes_one_several_and_the_show(show: Studio, page: Any) -> None:
    inspector = page.get_by_role("region", name="Inspector")
    box(page, "circle, ember").click()
    inspector.get_by_label("measures", exact=True).fill("3")
    page.keyboard.press("Enter")
    written(show, page, r'measures = 3\ngroup = "ember"')
    box(page, "star, tide").click(modifiers=["Shift"])
    inspector.get_by_role("heading", name="2 formations or ways").wait_for()
    inspector.get_by_label("heading", exact=True).select_option("tangent")
    text = written(show, page, r'facing = "tangent".*facing = "tangent"')
    assert text.count("tangent") == 2
    inspector.get_by_role("button", name="heading: as if it were not given").click()
    until(page, "!studio.score.value.segment.some((one) => one.facing)")
    page.evaluate("studio.select(null)")
    inspector.get_by_label("width", exact=True).fill("14")
    page.keyboard.press("Enter")
    written(show, page, r"\[stage\]\nwidth = 14")
    inspector.get_by_role("button", name=re.compile("^ember")).click()
    inspector.get_by_role("button", name="colour #58b368").click()
    written(show, page, r'name = "ember".*colour = \[0\.096')
    inspector.get_by_role("button", name="Rename ember").click()
    inspector.get_by_label("name", exact=True).fill("flame")
    page.keyboard.press("Enter")
    written(show, page, r'name = "flame".*group = "flame"')


def test_each_sees_what_the_other_selects_and_changes(show: Studio) -> None:
    with opened_page(show, more=1) as (one, other):
        box(one, "circle, ember").click()
        box(one, "star, tide").click(modifiers=["Shift"])
        other.locator(".box.other").nth(1).wait_for()
        one.keyboard.press("Alt+ArrowRight")
        other.locator(".box.changed").first.wait_for()
        assert other.locator(".box.changed em").first.inner_text() == one.evaluate("studio.by")


BIG = """() => {
  const score = structuredClone(studio.doc.structure.value);
  studio.doc.link.close();
  const who = ["ember", "tide", "*", "ember & left", "ember & right", "tide & left"];
  score.score.loop_measures = 500;
  score.score.segment = Array.from({ length: 1800 }, (_, at) => (
    { measure: 1 + ((at * 7) % 496), measures: 2, formation: "line", group: who[at % 6] }));
  score.score.at = Array.from({ length: 200 }, (_, at) => (
    { measure: 1 + ((at * 11) % 498), beat: 1 + (at % 4), call: "/dance/go", values: [] }));
  studio.doc.structure.value = score;
}"""
TURN = """(zooms) => new Promise((done) => {
  const element = document.querySelector(".tracks");
  let count = 0;
  const turn = () => {
    if (zooms) {
      const sign = count % 40 < 20 ? -1 : 1;
      const at = { deltaY: 40 * sign, ctrlKey: true, clientX: 700, clientY: 900, bubbles: true, cancelable: true };
      element.dispatchEvent(new WheelEvent("wheel", at));
    } else element.scrollLeft += 37;
    if (++count < 80) requestAnimationFrame(turn);
    else done(count);
  };
  requestAnimationFrame(turn);
})"""
MOST_SCRIPT_MS = 8.0


def test_500_measures_with_2000_entries_pan_and_zoom(page: Any) -> None:
    page.evaluate(BIG)
    devtools = page.context.new_cdp_session(page)
    devtools.send("Performance.enable", {"timeDomain": "threadTicks"})  # of this thread, also on a busy machine

    def script() -> float:
        told = devtools.send("Performance.getMetrics")["metrics"]
        return next(float(one["value"]) for one in told if one["name"] == "ScriptDuration")

    page.get_by_role("button", name="Whole show").click()
    until(page, "document.querySelector('.dense') !== null && studio.scale.value < 4")
    for zooms in (False, True):
        before = script()
        frames = page.evaluate(TURN, zooms)
        assert 1000.0 * (script() - before) / frames < MOST_SCRIPT_MS, zooms
    lane = page.get_by_role("group", name="Everybody", exact=True).first.locator(".lane").bounding_box()
    for across in range(0, 200, 3):  # what is painted can be pressed, and goes on by arrows
        page.mouse.click(lane["x"] + across, lane["y"] + 14)
        if page.evaluate("studio.selected.value.length"):
            break
    first = page.evaluate("studio.selected.value[0].number")
    page.keyboard.press("ArrowRight")
    assert page.evaluate("studio.selected.value[0].number") != first
    until(page, "document.activeElement.dataset.key === `segment ${studio.selected.value[0].number}`")
