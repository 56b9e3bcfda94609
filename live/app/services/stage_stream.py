"""State of the stage for pages, as frames: score and clock as text, positions and joints in binary.

Binary frames have the form of `live/show/view/stage_frames.py`, with dancers in the order of the last text frame
`dancers`.
"""

import json
import math
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, Final

from live.base.element_kinds import ELEMENT_KINDS
from live.base.stage_snapshot import StageView
from live.clock.ticks import TICK
from live.motion.editing.facing import heading_of
from live.show.desk.launch_report import launch_facts, pad_facts
from live.show.show import Show
from live.show.view.stage_frames import JOINTS, MAX_POSITION_DANCERS, POSITIONS, joints_frame, positions_frame

if TYPE_CHECKING:
    from live.app.services.score_stream import ScoreStream

INTERVAL: Final = 1.0 / 30.0
"""Time between two frames [s]."""
CLOCK_EVERY: Final = 3
"""Every so many frames there is one with clock and elements."""
MAX_ELEMENTS: Final = 64
"""Maximum number of elements in a frame."""
KIND_TEXTS: Final = {kind.number: kind.text for kind in ELEMENT_KINDS}
PART_BYTES: Final = 32_768
"""Maximum length of a part of a text."""


class StageStream:
    """Frames of one show for its pages. Thread: the show's."""

    def __init__(
        self,
        show: Show,
        view: Callable[[], StageView],
        score: "ScoreStream",
        late_frames: Callable[[], int],
        what_next: Callable[[], Any] = lambda: None,
    ) -> None:
        """`view` is the picture's snapshot; `score` has the texts about the show's files; `late_frames`: number of
        frames of the picture that came late so far; `what_next`: what could follow an element that has ended."""
        self._show, self._view, self._score, self._late_frames = show, view, score, late_frames
        self._what_next = what_next
        self._next, self._count = 0.0, 0
        self._previous, self._period = math.inf, 0.0  # time of the frame before, longest interval since the last clock
        self._dancers = -1
        self._wish: Any = None
        self._pads_measure: int | None = None  # the measure in which the pads were told last
        self._told: dict[str, str] = {}  # the last texts about pads

    def update_patch(self) -> None:
        """Tell pages of a patch that the show has taken."""
        self._score.update_patch()
        self._pads_measure = None

    def packets(self, now: float, wants: Any) -> Iterator[list[Any]]:
        """Yield the packets that are due at `now` [s]: ["text", name, number, part, parts, text] or ["frame", kind,
        bytes]. Call it each frame.

        `wants` are the facts of the pages: whether anybody looks, the dancers whose joints they want (from 1; None:
        nobody's, empty: all), and a number that is another one when they want the whole structure.
        """
        self._period, self._previous = max(self._period, now - self._previous), now
        if not isinstance(wants, dict) or not wants.get("pages"):
            if self._dancers >= 0:
                self._dancers, self._wish = -1, None
                self._pads_measure = None
                self._told.clear()
                self._score.rest()
            return
        if self._dancers < 0 or wants.get("structure") != self._wish:
            self._wish = wants.get("structure")
            self._told.clear()
            self._dancers = max(self._dancers, 0)
            self._score.want_structure()
        for one in self._score.take():
            yield from text_parts(one.name, one.number, one.text)
        if now < self._next:
            return
        self._next = max(self._next + INTERVAL, now - INTERVAL)  # frames of the show come a little late
        self._count += 1
        count = min(len(self._show.dancers.drawn_hips), MAX_POSITION_DANCERS)
        if count != self._dancers:
            self._dancers = count
            ids = list(range(1, count + 1))
            yield from text_parts("dancers", count, json.dumps({"kind": "dancers", "revision": count, "ids": ids}))
        tick = round(self._show.time / TICK)
        yield ["frame", POSITIONS, self._positions(tick)]
        chosen = wants.get("joints")
        if isinstance(chosen, list | tuple):
            view = self._view()
            view.detailed = True  # from now on: a page has a camera of its own
            yield ["frame", JOINTS, joints_frame(tick, view.joint_position[:count], list(chosen))]
        if self._count % CLOCK_EVERY == 0:
            yield from text_parts("clock", 0, json.dumps(self._clock()))
            yield from self._pads()

    def _pads(self) -> Iterator[list[Any]]:
        """Yield what has changed about pads: their lists, looked at once a measure, and what waits and runs."""
        texts = {"launches": json.dumps({"kind": "launches", **launch_facts(self._show), "next": self._what_next()})}
        if self._show.span.number != self._pads_measure:
            self._pads_measure = self._show.span.number
            texts["pads"] = json.dumps({"kind": "pads", "pads": pad_facts(self._show)})
        for name, text in texts.items():
            if self._told.get(name) != text:
                self._told[name] = text
                yield from text_parts(name, 0, text)

    def _positions(self, tick: int) -> bytes:
        dancers = self._show.dancers
        return positions_frame(
            tick, dancers.drawn_hips, heading_of(dancers.leg_rotation[:, 0]), self._show.motion.group_states()
        )

    def _clock(self) -> dict[str, Any]:
        show, size = self._show, self._show.timeline.beats_per_measure
        playhead, elements = show.playhead, show.motion.elements
        place = playhead.place(max(show.span.number, 0))
        first = show.span.number + 2.0  # the measure that begins at the end of this one

        def measure(beat: float) -> float | None:
            return round(first + (beat - show.span.end) / size, 3) if math.isfinite(beat) else None

        rows = [
            {
                "kind": KIND_TEXTS.get(element.kind, ""),
                "at": [round(float(value), 2) for value in element.points[0]],
                "radius": round(element.radius, 2), "strength": round(element.strength, 2), "level": round(level, 2),
                "from": measure(element.start_beat), "to": measure(element.end_beat),
            }
            for element, level in zip(elements.in_force, elements.levels.tolist(), strict=True)
            if not element.fair
        ]  # fmt: skip
        period, self._period = self._period, 0.0
        return {
            "kind": "clock", "time": round(show.time, 3), "measure": show.span.number + 1,
            "beat": round(show.span.fraction(show.timeline.beat_at(show.time)) * show.desk.beats + 1.0, 3),
            "bpm": round(show.follower.tempo, 2), "section": playhead.section_name(place),
            "score_measure": playhead.written_measure(place) + 1, "source": show.follower.source,
            "runner_up": list(show.follower.runner_up), "asks": show.follower.asks,
            "elements": rows[:MAX_ELEMENTS], "late_frames": self._late_frames(), "frame_ms": round(period * 1e3, 1),
        }  # fmt: skip


def text_parts(name: str, number: int, text: str) -> Iterator[list[Any]]:
    """Yield the packets of a text."""
    yield from byte_parts(name, number, text.encode())


def byte_parts(name: str, number: int, data: bytes) -> Iterator[list[Any]]:
    """Yield the packets of a text, or of other data with a name."""
    parts = range(0, len(data), PART_BYTES)
    for part, start in enumerate(parts):
        yield ["text", name, number, part, len(parts), data[start : start + PART_BYTES]]
