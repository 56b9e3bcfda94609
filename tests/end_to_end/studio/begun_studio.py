"""A studio as a newcomer meets it: the command, its start page, a browser; and hands that count what they do."""

import contextlib
import math
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from tests.control.waiting import BUSY
from tests.end_to_end.browser import browser
from tests.end_to_end.studio.test_studio_start import KEY, free_ports

FLOOR_MARGIN_M: Final = 1.1
"""Around the stage in the picture from above."""


@dataclass
class Begun:
    """A running `live studio` and its page."""

    page: Any
    folder: Path
    """Where it was started; its shows are below."""
    link: str
    errors: list[str]

    @property
    def journal(self) -> Path:
        return self.folder / "night.jsonl"


@contextlib.contextmanager
def begun_studio(folder: Path, *songs: Path, **context: Any) -> Iterator[Begun]:
    """Start `live studio` in a folder with songs, and open its page; `context`: of the browser. It ends as by Ctrl-C,
    and its page has had no error."""
    settings = folder / "settings"
    settings.mkdir()
    (settings / "web-key").write_text(KEY)
    (settings / "web-key").chmod(0o600)
    for song in songs:
        shutil.copy(song, folder / song.name)
    web, osc = free_ports(2)
    command = [
        sys.executable, "-m", "live", "studio", "--no-browser", "--web", str(web), "--osc", str(osc),
        "--journal", str(folder / "night.jsonl"),
    ]  # fmt: skip
    environment = {**os.environ, "LIVE_CONFIG_DIR": str(settings)}
    with (folder / "said.txt").open("w") as said:
        process = subprocess.Popen(command, cwd=folder, env=environment, stderr=said)
    try:
        link = f"http://127.0.0.1:{web}/studio#key={KEY}"
        with browser() as (opened, _):
            page = opened.new_context(**{"viewport": {"width": 1440, "height": 900}, **context}).new_page()
            page.set_default_timeout(8_000 * BUSY)
            errors: list[str] = []
            page.on("pageerror", lambda error: errors.append(str(error)))
            deadline = time.monotonic() + 400.0 * BUSY  # the first time kernels are compiled
            while True:  # it listens a moment after it has told so
                try:
                    page.goto(link)
                    break
                except Exception:
                    assert process.poll() is None, (folder / "said.txt").read_text()
                    assert time.monotonic() < deadline
                    page.wait_for_timeout(50)
            page.get_by_role("heading", name="A new show").wait_for()
            try:
                yield Begun(page, folder, link, errors)
            except BaseException:
                page.screenshot(path=folder / "failed.png")
                raise
            assert not errors
    finally:
        process.send_signal(signal.SIGINT)
        process.wait(timeout=60 * BUSY)


class Hand:
    """What both hands share: they see the page, and count what they do."""

    def __init__(self, page: Any) -> None:
        self.page = page
        self.actions = 0

    def region(self, name: str) -> Any:
        return self.page.get_by_role("region", name=name)

    @property
    def timeline(self) -> Any:
        return self.region("Timeline")

    def box(self, words: str) -> Any:
        """A box of the timeline whose name matches."""
        return self.timeline.get_by_role("button", name=re.compile(words))

    def see(self, shown: Callable[[], Any]) -> None:
        """Look until the page shows something."""
        deadline = time.monotonic() + 8.0 * BUSY
        while not shown():
            assert time.monotonic() < deadline
            self.page.wait_for_timeout(30)

    def places(self) -> dict[int, tuple[float, float]]:
        """Where everybody stands in the measure that is looked at [m], as the list of the stage tells it."""
        listed = self.page.get_by_role("listbox", name="Dancers on the stage")
        listed.get_by_role("option", name=re.compile(r" m$")).first.wait_for(state="attached")
        told = re.findall(
            r"(\d+), at (-?[\d.]+), (-?[\d.]+) m", " ".join(listed.get_by_role("option").all_inner_texts())
        )
        return {int(dancer): (float(x), float(z)) for dancer, x, z in told}


class Mouse(Hand):
    """A hand on the mouse: each click, double click, drag, turn of the wheel and typed word is an action."""

    def _middle(self, target: Any) -> tuple[float, float]:
        """Where a control is; those that lie out of sight are scrolled to, by the wheel."""
        if isinstance(target, tuple):
            return target
        target.wait_for()
        found = target.evaluate(SEEN)
        if found["away"]:
            self.page.mouse.move(*found["over"])
            self.page.mouse.wheel(0, found["away"])
            self.actions += 1
            self.see(lambda: not target.evaluate(SEEN)["away"])
            found = target.evaluate(SEEN)
        return found["at"][0], found["at"][1]

    def click(self, target: Any, count: int = 1) -> None:
        self.page.mouse.click(*self._middle(target), click_count=count)
        self.actions += 1

    def drag(self, start: Any, *places: tuple[float, float]) -> None:
        """Press at a place, or on a control, go through places and let go."""
        self.page.mouse.move(*self._middle(start))
        self.page.mouse.down()
        for place in places:
            self.page.mouse.move(*place, steps=4)
        self.page.mouse.up()
        self.actions += 1

    def drag_by(self, start: Any, x: float, y: float = 0.0) -> None:
        place = self._middle(start)
        self.drag(place, (place[0] + x / 2, place[1] + y / 2), (place[0] + x, place[1] + y))

    def choose(self, target: Any, option: str) -> None:
        """Choose from a native list. Its popup is no part of the page: it counts as two clicks."""
        self._middle(target)
        target.select_option(option)
        self.actions += 2

    def floor(self, x: float, z: float, size: tuple[float, float]) -> tuple[float, float]:
        """Page pixels of a place on the floor [m]; `size`: of the stage."""
        box = self.page.locator(".dancers canvas").bounding_box()
        scale = min(box["width"] / (size[0] + 2 * FLOOR_MARGIN_M), box["height"] / (size[1] + 2 * FLOOR_MARGIN_M))
        return box["x"] + box["width"] / 2 + x * scale, box["y"] + box["height"] / 2 + z * scale

    def measure(self, measure: float) -> tuple[float, float]:
        """Page pixels of the number of a measure (from 1) in the ruler, half a measure behind its line."""
        first, second = (self._mark(number) for number in self._marks())
        pixels = (second[1] - first[1]) / (second[0] - first[0])
        return first[1] + (measure - first[0] + 0.5) * pixels, first[2]

    def _marks(self) -> tuple[Any, Any]:
        marks = self.timeline.locator("i.measure")
        return marks.nth(0), marks.last

    def _mark(self, mark: Any) -> tuple[int, float, float]:
        box = mark.bounding_box()
        return int(mark.inner_text()), box["x"], box["y"] + box["height"] / 2


MOST_TABS: Final = 250
MOST_PARTS: Final = 8
IS_IN_PART = """(element) => {
  const part = element.closest("#app > header, main > section");
  return part === null || part.contains(document.activeElement);
}"""


class Keys(Hand):
    """Hands on the keyboard: each key is an action, also each of those that are typed."""

    def press(self, *keys: str, times: int = 1) -> None:
        for _ in range(times):
            for key in keys:
                self.page.keyboard.press(key)
                self.actions += 1

    def write(self, words: str) -> None:
        """Type into the field that has the focus, instead of what is there."""
        self.press("Control+a")
        self.page.keyboard.type(words)
        self.actions += len(words)

    def go_to(self, target: Any) -> None:
        """Go to the part of the page with a control, then Tab until the control has the focus."""
        target.wait_for(state="attached")
        for _ in range(MOST_PARTS):
            if target.evaluate(IS_IN_PART):
                break
            self.press("F6")
        for _ in range(MOST_TABS):
            if target.evaluate("(element) => element === document.activeElement"):
                return
            self.press("Tab")
        raise AssertionError(f"no Tab leads to {target}")

    def push(self, target: Any) -> None:
        """Press a button."""
        self.go_to(target)
        self.press("Enter")


SEEN = """(element) => {
  const box = element.getBoundingClientRect();
  const at = [box.x + box.width / 2, box.y + box.height / 2];
  const scrolls = (one) =>
    one.scrollHeight > one.clientHeight + 1 && /auto|scroll/.test(getComputedStyle(one).overflowY);
  let frame = element.parentElement;
  while (frame && !scrolls(frame)) frame = frame.parentElement;
  if (!frame) return { at, over: at, away: 0 };
  const room = frame.getBoundingClientRect();
  const away = at[1] < room.top + 12 ? at[1] - room.top - 60 : at[1] > room.bottom - 12 ? at[1] - room.bottom + 60 : 0;
  return { at, over: [room.x + room.width / 2, room.y + room.height / 2], away };
}"""
"""Where an element is, and how far it lies outside of what scrolls it [px]."""


def around(a: tuple[float, float], b: tuple[float, float], far: float) -> list[tuple[float, float]]:
    """A closed line around two places [m], so far from them."""
    angle = math.atan2(b[1] - a[1], b[0] - a[0])
    ends = [(b, angle + turn) for turn in (-1.57, -0.8, 0.0, 0.8, 1.57)]
    ends += [(a, angle + math.pi + turn) for turn in (-1.57, -0.8, 0.0, 0.8, 1.57)]
    return [(x + far * math.cos(turn), z + far * math.sin(turn)) for (x, z), turn in ends]


def pairs_apart(
    places: dict[int, tuple[float, float]], dancers: list[int], far: float
) -> tuple[tuple[int, int], tuple[int, int]]:
    """The division of four dancers into two pairs that lines can be drawn around, with nobody else inside."""
    one, *others = dancers
    for other in sorted(others, key=lambda each: math.dist(places[one], places[each])):
        rest = tuple(each for each in others if each != other)
        if all(_is_alone(places, pair, far) for pair in ((one, other), rest)):
            return (one, other), (rest[0], rest[1])
    raise AssertionError(f"nobody can be told apart: {places}")


def _is_alone(places: dict[int, tuple[float, float]], pair: tuple[int, ...], far: float) -> bool:
    a, b = (places[each] for each in pair)
    length = math.dist(a, b) or 1e-9
    for dancer, place in places.items():
        along = ((place[0] - a[0]) * (b[0] - a[0]) + (place[1] - a[1]) * (b[1] - a[1])) / length**2
        share = min(1.0, max(0.0, along))
        nearest = (a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]))
        if dancer not in pair and math.dist(place, nearest) < far + 0.1:
            return False
    return True
