"""A newcomer makes a piece of 64 measures for 12 dancers to a song: by mouse alone, then by keyboard alone.

Nothing but the page is used: its controls, and what it shows. `STUDIO_PICTURES=docs/pictures/first-piece` writes the
pictures of docs/tutorials/choreographer.md anew.
"""

import json
import os
import re
import subprocess
import sys
import time
import tomllib
from pathlib import Path
from typing import Any, Final

import pytest

from tests.control.waiting import BUSY
from tests.end_to_end.browser import needs_browser
from tests.end_to_end.studio.begun_studio import Begun, Keys, Mouse, around, begun_studio, pairs_apart
from tests.places import SHARED

SONG: Final = SHARED / "beats" / "open" / "o04_band_125_live.ogg"
needs_song = pytest.mark.skipif(not SONG.is_file(), reason="the shared songs are not beside the repository")
pytestmark = [needs_browser, needs_song, pytest.mark.browser, pytest.mark.long, pytest.mark.shared]

MEASURES: Final = 64
MOST_ACTIONS: Final = 150
STAGE: Final = (8.5, 5.7)
"""Of a new show for twelve, as the inspector tells it [m]."""
FAR_M: Final = 0.35
SCRUB_PX: Final = 4
PICTURES: Final = os.environ.get("STUDIO_PICTURES")

WAVE: Final = [(-3.4 + 0.34 * at, 1.5 * (-1) ** (at // 5) * (1 - abs(at % 5 - 2) / 3)) for at in range(21)]
"""A freehand line from one side to the other [m]."""
HEART: Final = [(0.0, -0.9), (1.4, -2.1), (2.9, -1.2), (2.4, 0.4), (0.0, 2.2), (-2.4, 0.4), (-2.9, -1.2), (-1.4, -2.1)]
ARROW: Final = [(-3.2, 1.6), (0.0, -1.8), (3.2, 1.6)]
CORNERS: Final = [
    [(-3.4, 1.8), (-1.6, 1.8)], [(1.6, 1.8), (3.4, 1.8)], [(-3.4, -1.9), (-1.6, -1.9)], [(1.6, -1.9), (3.4, -1.9)],
]  # fmt: skip
"""Lines for the parts of two groups [m]."""


def picture(page: Any, name: str) -> None:
    """Write a picture of the tutorial, if it was asked for."""
    if PICTURES:
        for words in ("working", "simulated up to", "Simulating", "come in a moment"):
            page.get_by_text(words).first.wait_for(state="hidden")
        page.wait_for_timeout(1500)  # figures and small pictures are drawn
        page.screenshot(path=Path(PICTURES) / f"{name}.jpg", type="jpeg", quality=55)


def draw(mouse: Mouse, tool: str, measure: int, points: list[tuple[float, float]], *, closed: bool = False) -> None:
    """Choose a measure and a tool, draw, and put what is drawn into the score as a formation."""
    mouse.click(mouse.measure(measure))
    mouse.click(mouse.page.get_by_role("radio", name=re.compile(f"^{tool}")))
    pixels = [mouse.floor(x, z, STAGE) for x, z in ((*points, points[0]) if closed else points)]
    if tool == "Line":
        for place in pixels[:-1]:
            mouse.click(place)
        mouse.click(pixels[-1], count=2)
    else:
        mouse.drag(pixels[0], *pixels[1:])
    form = mouse.page.get_by_role("form", name="What becomes of the line")
    form.wait_for()


def put(mouse: Mouse, measure: int) -> None:
    form = mouse.page.get_by_role("form", name="What becomes of the line")
    mouse.click(form.get_by_role("button", name=f"Put it at measure {measure}"))
    form.wait_for(state="detached")


def choose_two(mouse: Mouse, pair: tuple[int, int], places: dict[int, tuple[float, float]]) -> None:
    mouse.click(mouse.page.get_by_role("radio", name=re.compile("^Lasso")))
    line = [mouse.floor(x, z, STAGE) for x, z in around(places[pair[0]], places[pair[1]], FAR_M)]
    mouse.drag(line[0], *line[1:], line[0])
    mouse.page.get_by_text("2 selected").first.wait_for()


def from_library(mouse: Mouse, panel: str, item: str, measure: int, row: str) -> None:
    """Drag something of the library to a measure of a row."""
    library = mouse.region("Library")
    if library.get_by_role("button", name=panel, exact=True).get_attribute("aria-pressed") == "false":
        mouse.click(library.get_by_role("button", name=panel, exact=True))
    entry = library.get_by_role("button", name=item, exact=True)
    lane = mouse.timeline.get_by_role("group", name=row, exact=True).first.bounding_box()
    mouse.drag(entry, (mouse.measure(measure)[0], lane["y"] + 14), (mouse.measure(measure)[0] + 2, lane["y"] + 14))
    mouse.box(rf"{item}.*measure {measure}\b").wait_for()


def test_by_mouse_alone(tmp_path: Path) -> None:
    begun_at = time.monotonic()
    with begun_studio(tmp_path, SONG) as begun:
        page, mouse = begun.page, Mouse(begun.page)
        picture(page, "begin")
        mouse.click(page.get_by_role("button", name="Begin"))
        page.get_by_role("region", name="Timeline").wait_for(timeout=120_000 * BUSY)
        inspector = mouse.region("Inspector")
        songs_length = int(inspector.get_by_label("length", exact=True).input_value())
        mouse.drag_by(inspector.get_by_text("length", exact=True), SCRUB_PX * (MEASURES - songs_length) + 1)
        mouse.see(lambda: inspector.get_by_label("length", exact=True).input_value() == str(MEASURES))
        mouse.click(page.get_by_role("button", name="Whole show"))
        page.locator("i.measure", has_text="57").wait_for()

        draw(mouse, "Line", 8, ARROW)
        picture(page, "draw")
        put(mouse, 8)
        from_library(mouse, "Formations", "star", 14, "Everybody")
        picture(page, "library")
        draw(mouse, "Curve", 20, WAVE)
        put(mouse, 20)
        wave = mouse.box("drawn 2")
        mouse.click(wave)
        mouse.drag_by(page.get_by_role("slider", name=re.compile("begins later")), 19.0)
        picture(page, "canon")

        # ember and tide split into pairs, each on a line of its own, and come together again
        mouse.click(mouse.measure(26))
        places = mouse.places()
        pairs = [pair for group in ([1, 2, 3, 4], [5, 6, 7, 8]) for pair in pairs_apart(places, group, FAR_M)]
        for pair, line in zip(pairs, CORNERS, strict=True):
            choose_two(mouse, pair, places)
            mouse.click(page.get_by_role("radio", name=re.compile("^Line")))
            mouse.drag(mouse.floor(*line[0], STAGE), mouse.floor(*line[1], STAGE))
            put(mouse, 26)
        picture(page, "split")
        mouse.click(page.get_by_role("radio", name=re.compile("^Select")))
        mouse.click(mouse.floor(0.0, -2.6, STAGE))  # nobody
        from_library(mouse, "Formations", "line", 31, "ember")
        from_library(mouse, "Formations", "circle", 31, "tide")
        from_library(mouse, "Formations", "triangle", 36, "Everybody")
        draw(mouse, "Closed shape", 42, HEART, closed=True)
        mouse.click(page.get_by_role("form", name="What becomes of the line").get_by_label("inside"))
        put(mouse, 42)

        # for eight counts they gather in the middle
        mouse.click(mouse.measure(48))
        mouse.click(page.get_by_role("radio", name=re.compile("^Gather")))
        mouse.click(mouse.floor(0.0, 0.0, STAGE))
        gather = mouse.box("attract")
        edge = gather.bounding_box()
        mouse.drag_by((edge["x"] + edge["width"] - 3, edge["y"] + 10), -edge["width"] / 2)
        picture(page, "gather")
        mouse.click(page.get_by_role("radio", name=re.compile("^Select")))

        # one dances alone
        mouse.click(mouse.measure(52))
        mouse.click(mouse.floor(*mouse.places()[6], STAGE))
        mouse.click(mouse.region("Library").get_by_role("button", name="Steps", exact=True))
        mouse.click(page.get_by_role("button", name="Put turn at the cursor"))
        mouse.box("turn, dancer 6").wait_for()
        picture(page, "alone")

        # at measure 36 all light goes down
        signals = mouse.timeline.get_by_role("group", name="Signals", exact=True).bounding_box()
        mouse.click((mouse.measure(36)[0], signals["y"] + 14), count=2)
        mouse.click(inspector.get_by_role("button", name="Add what happens"))
        happens = inspector.get_by_role("group", name="What happens, 1")
        mouse.click(happens.locator("summary"))
        mouse.click(
            happens.get_by_role("group", name="light", exact=True).get_by_role("button", name="level", exact=True)
        )
        mouse.drag_by(happens.get_by_role("slider"), -25.0)
        picture(page, "signal")
        from_library(mouse, "Formations", "spiral", 58, "Everybody")
        mouse.click(page.get_by_role("button", name="Storyboard"))
        if PICTURES:
            page.get_by_text(re.compile(r"^\d+ scenes on \d+ pages?$")).wait_for()
        picture(page, "storyboard")
        page.wait_for_timeout(500)
    print(f"{mouse.actions} actions, {time.monotonic() - begun_at:.0f} s")
    assert mouse.actions <= MOST_ACTIONS
    check_piece(begun)


def at_measure(keys: Keys, measure: int) -> None:
    """Put the cursor at a measure, from the timeline."""
    keys.go_to(keys.timeline.get_by_role("button", name="Everybody", exact=True))
    keys.press("Escape", "Home")
    keys.press("PageDown", times=(measure - 1) // 8)
    keys.press("ArrowRight", times=(measure - 1) % 8)
    keys.page.get_by_text(f"Measure {measure}, preview").wait_for()


def draw_by_keys(
    keys: Keys, tool: str, measure: int, points: list[tuple[int, int]], who: str = "", *, inside: bool = False
) -> None:
    """Draw with the pen, in steps of a quarter of a metre from the middle, and put it into the score."""
    at_measure(keys, measure)
    keys.push(keys.page.get_by_role("radio", name=re.compile(f"^{tool}")))
    keys.go_to(keys.page.get_by_role("listbox", name="Dancers on the stage"))
    keys.press("ArrowUp")  # the pen comes to the middle
    pen_at(keys, (0, 0), points)
    keys.press("Enter")
    form = keys.page.get_by_role("form", name="What becomes of the line")
    form.wait_for()
    if inside:
        keys.go_to(form.get_by_label("on the line"))
        keys.press("ArrowRight")
    if who:
        keys.go_to(form.get_by_label("Who"))
        keys.write(who)
    keys.push(form.get_by_role("button", name=f"Put it at measure {measure}"))
    form.wait_for(state="detached")
    before = keys.timeline.get_by_role("button", name=re.compile(rf"^formation drawn \d+.*, measure {measure}\b"))
    keys.see(lambda: before.count() > 0)


def pen_at(keys: Keys, place: tuple[int, int], points: list[tuple[int, int]]) -> None:
    """Move the pen from a place to points, and put each."""
    for point in points:
        for by, names in (
            (point[0] - place[0], ("ArrowLeft", "ArrowRight")),
            (point[1] - place[1], ("ArrowUp", "ArrowDown")),
        ):
            keys.press(f"Shift+{names[by > 0]}", times=abs(by) // 4)
            keys.press(names[by > 0], times=abs(by) % 4)
        place = point
        keys.press("Enter")


def put_by_keys(keys: Keys, panel: str, item: str, measure: int, row: str) -> None:
    """Put something of the library at a measure of a row."""
    at_measure(keys, measure)
    keys.push(keys.timeline.get_by_role("button", name=row, exact=True))
    library = keys.region("Library")
    keys.push(library.get_by_role("button", name=panel, exact=True))
    keys.push(library.get_by_role("button", name=item, exact=True))
    keys.box(rf"{item}.*measure {measure}\b").wait_for()
    keys.push(keys.timeline.get_by_role("button", name=row, exact=True))  # no row is chosen any more


def test_by_keyboard_alone(tmp_path: Path) -> None:
    begun_at = time.monotonic()
    with begun_studio(tmp_path, SONG) as begun:
        page, keys = begun.page, Keys(begun.page)
        keys.push(page.get_by_role("button", name="Begin"))
        page.get_by_role("region", name="Timeline").wait_for(timeout=120_000 * BUSY)
        inspector = keys.region("Inspector")
        length = inspector.get_by_label("length", exact=True)
        keys.go_to(length)
        keys.write(str(MEASURES))
        keys.press("Tab")
        keys.see(lambda: length.input_value() == str(MEASURES))
        keys.go_to(keys.timeline.get_by_role("button", name="Everybody", exact=True))
        keys.press("0")
        page.locator("i.measure", has_text="57").wait_for()

        draw_by_keys(keys, "Line", 8, [(-12, 6), (0, -7), (12, 6)])
        put_by_keys(keys, "Formations", "star", 14, "Everybody")
        draw_by_keys(keys, "Curve", 20, [(-13, 4), (-8, -4), (-3, 4), (3, -4), (8, 4), (13, -4)])
        keys.press("Escape", "ArrowDown")  # a box: the nearest to the cursor, or from there by arrows
        keys.see(lambda: page.locator(".box[aria-pressed=true]").count() == 1)
        drawn = keys.box("formation drawn 2")
        for _ in range(8):
            if drawn.get_attribute("aria-pressed") == "true":
                break
            keys.press("ArrowRight")
            page.wait_for_timeout(50)
        keys.go_to(page.get_by_role("slider", name=re.compile("begins later")))
        keys.press("ArrowRight", times=2)
        for who, line in zip(("1-2", "3-4", "5-6", "7-8"), CORNERS, strict=True):
            draw_by_keys(keys, "Line", 26, [(round(4 * x), round(4 * z)) for x, z in line], who)
        put_by_keys(keys, "Formations", "line", 31, "ember")
        put_by_keys(keys, "Formations", "circle", 31, "tide")
        put_by_keys(keys, "Formations", "triangle", 36, "Everybody")
        draw_by_keys(keys, "Closed shape", 42, [(0, -4), (8, -7), (10, 0), (0, 8), (-10, 0), (-8, -7)], inside=True)

        at_measure(keys, 48)
        keys.push(page.get_by_role("radio", name=re.compile("^Gather")))
        keys.go_to(page.get_by_role("listbox", name="Dancers on the stage"))
        keys.press("Enter")
        keys.box("attract").wait_for()
        keys.press("Escape")
        keys.push(page.get_by_role("radio", name=re.compile("^Select")))
        keys.go_to(keys.timeline.get_by_role("button", name="Everybody", exact=True))
        keys.press("Escape")
        at_measure(keys, 48)
        keys.press("ArrowDown")
        keys.see(lambda: keys.box("attract").get_attribute("aria-pressed") == "true")
        keys.press("Shift+ArrowLeft")
        keys.box("attract.* 3 long").wait_for()
        keys.press("Shift+ArrowLeft")
        keys.box("attract.* 2 long").wait_for()

        at_measure(keys, 52)
        keys.go_to(page.get_by_role("listbox", name="Dancers on the stage"))
        keys.places()
        keys.press("ArrowRight", "Space")
        page.get_by_text("1 selected").first.wait_for()
        keys.push(keys.region("Library").get_by_role("button", name="Steps", exact=True))
        keys.push(page.get_by_role("button", name="Put turn at the cursor"))
        keys.box(r"turn, dancer \d+").wait_for()

        at_measure(keys, 36)
        keys.push(keys.timeline.get_by_role("button", name="Signals", exact=True))
        keys.press("n")
        keys.box("signal 36").wait_for()
        keys.push(inspector.get_by_role("button", name="Add what happens"))
        happens = inspector.get_by_role("group", name="What happens, 1")
        keys.push(happens.locator("summary"))
        keys.go_to(happens.get_by_label("Find a control"))
        keys.write("level of all light")
        keys.push(
            happens.get_by_role("group", name="light", exact=True).get_by_role("button", name="level", exact=True)
        )
        slider = happens.get_by_role("slider")
        keys.go_to(slider)
        keys.press("PageDown", times=4)
        keys.see(lambda: float(slider.input_value()) < 0.9)
        keys.push(keys.timeline.get_by_role("button", name="Signals", exact=True))
        put_by_keys(keys, "Formations", "spiral", 58, "Everybody")
        keys.press("?")
        page.get_by_role("heading", name="Keys").wait_for()
        keys.press("Escape")
        page.wait_for_timeout(500)
    print(f"{keys.actions} keys, {time.monotonic() - begun_at:.0f} s")
    check_piece(begun)


def check_piece(begun: Begun) -> None:
    """The piece has all that it was to have; it is checked, filmed and replayed."""
    show = begun.folder / "my show"
    score = tomllib.loads((show / "show.toml").read_text())
    assert score["loop_measures"] == MEASURES
    assert sum(group["dancers"] for group in score["group"]) == 12
    used = {one["formation"] for one in score["segment"] if "formation" in one}
    drawn = {one["name"] for one in score["formation"] if one["shape"] == "polyline"}
    assert len(used) >= 8, used
    assert len(used & drawn) >= 4, drawn
    parts = [one for one in score["segment"] if re.fullmatch(r"[\d +-]+", one.get("group", ""))]
    assert len(parts) == 4
    assert len({one["measure"] for one in parts}) == 1
    assert {one.get("group") for one in score["segment"]} >= {"ember", "tide"}
    assert any(one.get("beats_later", 0) > 0 for one in score["segment"])
    assert any(re.fullmatch(r"\d+", one.get("group", "")) for one in score["sequence"])
    (attract,) = score["element"]
    assert (attract["kind"], attract["measures"]) == ("attract", 2)  # eight counts
    (signal,), (reaction,) = score["signal"], score["react"]
    assert reaction["on"] == signal["name"]
    assert reaction["call"] == "/dance/light/level"
    assert reaction["values"][0] < 1.0

    def live(*words: str) -> str:
        done = subprocess.run(
            [sys.executable, "-m", "live", *words],
            capture_output=True, text=True, cwd=begun.folder, timeout=600 * BUSY,
            env={**os.environ, "LIVE_CONFIG_DIR": str(begun.folder / "settings")},
        )  # fmt: skip
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    live("check", str(show))
    film = begun.folder / "film.mp4"
    live("render", str(show), "--out", str(film), "--size", "320x180", "--fps", "12", "--seconds", "8")
    assert film.stat().st_size > 10_000
    told = json.loads(live("replay", str(begun.journal), "--verify", "--json"))
    assert told["measures"] > 8
    assert not told["measures_different"]
