"""A browser for the studio's bench, in a process of its own: it opens the page, does what a person does, and measures.

Each line of the standard input is an order, {"do": name, …}; the answer is a line with its figures. Times are the
page's own, from the event to the frame after the one that shows its result.
"""

import json
import os
import shutil
import statistics
import sys
from typing import Any

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
ARGUMENTS = ("--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking")
DEADLINE_S = 60.0
OPENINGS = 5
TRIES = 9
PAN_FRAMES = 120
IDLE_S = 4.0

WATCH = """
window.bench = {};
for (const kind of ["pointerdown", "pointermove"]) {
  addEventListener(kind, (event) => { bench[kind] = performance.now(); }, { capture: true });
}
const usable = () => {
  const shown = window.studio?.doc.positions.value?.count && document.querySelector(".timeline .box, .timeline .dense");
  if (!shown) requestAnimationFrame(usable);
  else requestAnimationFrame(() => { bench.usable = performance.now(); });
};
requestAnimationFrame(usable);
bench.until = (seen, since) => new Promise((done, failed) => {
  const begun = performance.now();
  const look = () => {
    if (performance.now() - begun > 15000) failed(new Error(`waited in vain: ${seen}`));
    else if (!seen()) requestAnimationFrame(look);
    else requestAnimationFrame(() => requestAnimationFrame(() => done(performance.now() - bench[since])));
  };
  look();
});
bench.answers = (topic) => {
  const { preview } = window.studio;
  const ask = Object.getPrototypeOf(preview).ask;
  bench.answered = 0;
  preview.ask = (question, about, urgent) => {
    const answer = ask.call(preview, question, about, urgent);
    if (about === topic) void answer.then((got) => { if (!got.replaced) bench.answered = performance.now(); });
    return answer;
  };
};
bench.frames = (seconds, turn) => new Promise((done) => {
  const begun = performance.now();
  let count = 0;
  const look = () => {
    if (turn) turn(count);
    count++;
    if (performance.now() - begun < 1000 * seconds) requestAnimationFrame(look);
    else done(count);
  };
  requestAnimationFrame(look);
});
bench.tracks = () => document.querySelector(".tracks");
bench.pan = () => { bench.tracks().scrollLeft += 37; };
bench.zoom = (count) => {
  const deltaY = count % 40 < 20 ? -40 : 40;
  const wheel = { deltaY, ctrlKey: true, clientX: 700, clientY: 900, bubbles: true, cancelable: true };
  bench.tracks().dispatchEvent(new WheelEvent("wheel", wheel));
};
"""
"""In the page before its own script."""


class Person:
    """Somebody at the page."""

    def __init__(self, browser: Any, url: str) -> None:
        self._browser, self._url, self._pages = browser, url, list[Any]()
        self.page: Any = None

    def open(self, width: int = 1440, height: int = 1000) -> dict[str, float]:
        """Open the page as somebody who never did; return when it could be used [s], and its size on the wire [kB]."""
        page = self._browser.new_context(viewport={"width": width, "height": height}).new_page()
        page.add_init_script(WATCH)
        page.goto(self._url)
        self._pages.append(page)
        self.page = page
        self._until("bench.usable !== undefined")
        size = page.evaluate(
            "performance.getEntriesByType('navigation').concat(performance.getEntriesByType('resource'))"
            ".reduce((sum, one) => sum + (one.encodedBodySize || 0), 0)"
        )
        return {"usable": page.evaluate("bench.usable") / 1e3, "kB": size / 1e3}

    def close(self) -> dict[str, float]:
        """Close all pages."""
        for page in self._pages:
            page.context.close()
        self._pages.clear()
        return {}

    def first_openings(self) -> dict[str, float]:
        """Open the page some times; the last one stays."""
        seen = []
        for _ in range(OPENINGS):
            self.close()
            seen.append(self.open())
        return {name: statistics.median(one[name] for one in seen) for name in seen[0]}

    def click_boxes(self) -> dict[str, float]:
        """Click on formations of the timeline; until the stage shows the ways into each [ms]."""
        self.page.evaluate("studio.scale.value = 40")
        self.page.get_by_label("Follow").uncheck()
        self.page.evaluate("bench.answers('segment')")
        boxes = self.page.locator(".timeline button.box[data-key^='segment']")
        times = []
        for index in range(TRIES + 1):
            box = boxes.nth(index % 5).bounding_box()
            self.page.evaluate("bench.answered = 0")
            self.page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
            times.append(self.page.evaluate("bench.until(() => bench.answered > bench.pointerdown, 'pointerdown')"))
        return _times(times[1:])

    def drag_box(self) -> dict[str, float]:
        """Drag a formation of everybody along the timeline; from a move to its planned ways on the stage [ms]."""
        box = self._whole_box()
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        return self._drag("timeline", (x, y), lambda index: (x + (80, 40)[index % 2], y))

    def drag_path(self) -> dict[str, float]:
        """Drag a point of everybody's way on the stage; from a move to the planned ways [ms]."""
        box = self._whole_box()
        self.page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
        handle = self.page.locator(".handle.segment").first.bounding_box()
        x, y = handle["x"] + handle["width"] / 2, handle["y"] + handle["height"] / 2
        return self._drag("drag", (x, y), lambda index: (x + 6 * (index + 1), y + 20 * (index % 2)))

    def _whole_box(self) -> Any:
        self.page.evaluate("studio.scale.value = 40")
        self.page.evaluate("bench.tracks().scrollLeft = 0")
        number = self.page.evaluate("studio.score.value.segment.findIndex((one) => (one.group ?? '*') === '*') + 1")
        return self.page.locator(f".timeline [data-key='segment {number}']").bounding_box()

    def _drag(self, topic: str, start: tuple[float, float], place: Any) -> dict[str, float]:
        self.page.evaluate("(topic) => bench.answers(topic)", topic)
        self.page.mouse.move(*start)
        self.page.mouse.down()
        times = []
        for index in range(TRIES + 1):
            self.page.evaluate("bench.answered = 0")
            self.page.mouse.move(*place(index))
            times.append(self.page.evaluate("bench.until(() => bench.answered > bench.pointermove, 'pointermove')"))
        self.page.keyboard.press("Escape")
        self.page.mouse.up()
        return _times(times[1:])

    def scrub(self) -> dict[str, float]:
        """Click on measures of the ruler; until everybody stands where they do then [ms]."""
        self.page.evaluate("bench.answers('moment')")
        ruler = self.page.locator(".ruler .lane").first.bounding_box()
        times = []
        for index in range(TRIES + 1):
            self.page.evaluate("bench.answered = 0")
            self.page.mouse.click(ruler["x"] + 20 + 40 * ((index * 5) % 12), ruler["y"] + 6)
            times.append(self.page.evaluate("bench.until(() => bench.answered > bench.pointerdown, 'pointerdown')"))
        return _times(times[1:])

    def frames(self, seconds: float = IDLE_S, turn: str = "null") -> dict[str, float]:
        """Script of the page for each frame, with the show's 50 dancers on the stage [ms]."""
        devtools = self.page.context.new_cdp_session(self.page)
        devtools.send("Performance.enable", {"timeDomain": "threadTicks"})  # of this thread, also on a busy machine
        before = _script_seconds(devtools)
        frames = self.page.evaluate(f"bench.frames({seconds}, {turn})")
        return {"script": 1e3 * (_script_seconds(devtools) - before) / frames, "frames": frames / seconds}

    def show(self, solid: bool) -> dict[str, float]:
        """Look at what is danced now, from above or in 3D."""
        if (back := self.page.get_by_role("button", name="Back to now")).count():
            back.click()
        if solid:
            self.page.get_by_role("button", name="3D", exact=True).click()
        self.page.wait_for_timeout(1000)
        return {}

    def whole(self) -> dict[str, float]:
        """Show the timeline from side to side."""
        self.page.get_by_role("button", name="Whole show").click()
        self.page.wait_for_timeout(500)
        return {"entries": self.page.evaluate("studio.boxes.value.length")}

    def _until(self, expression: str) -> None:
        for _ in range(int(DEADLINE_S * 50)):
            if self.page.evaluate(expression):
                return
            self.page.wait_for_timeout(20)
        raise TimeoutError(expression)


def _script_seconds(devtools: Any) -> float:
    told = devtools.send("Performance.getMetrics")["metrics"]
    return next(float(one["value"]) for one in told if one["name"] == "ScriptDuration")


def _times(values: list[float]) -> dict[str, float]:
    return {"median": statistics.median(values), "longest": max(values)}


def main() -> None:
    """Obey the orders until the input ends."""
    from playwright.sync_api import sync_playwright

    os.nice(10)  # pages are on other machines
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        person = Person(browser, sys.argv[1])
        for line in sys.stdin:
            order = json.loads(line)
            try:
                answer = getattr(person, order.pop("do"))(**order)
            except Exception as error:  # told to the bench, whose row stays empty
                answer = {"error": str(error)}
            print(json.dumps(answer), flush=True)
        browser.close()


if __name__ == "__main__":
    main()
