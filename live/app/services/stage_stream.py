"""State of the stage for pages, as frames: structure and clock as text, positions and joints in binary.

Binary frames have the form of `live/show/view/stage_frames.py`, with dancers in the order of the last text frame
`dancers`.
"""

import json
import threading
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, Final

from live.base.element_kinds import ELEMENT_KINDS
from live.base.fault_isolation import run_once
from live.base.stage_snapshot import StageView
from live.clock.ticks import TICK
from live.motion.editing.facing import heading_of
from live.show.patch.patch import Patch
from live.show.patch.table_batches import patch_json
from live.show.show import Show
from live.show.view.stage_frames import JOINTS, MAX_POSITION_DANCERS, POSITIONS, joints_frame, positions_frame

INTERVAL: Final = 1.0 / 30.0
"""Time between two frames [s]."""
CLOCK_EVERY: Final = 3
"""Every so many frames there is one with clock and elements."""
PART_BYTES: Final = 32_768
"""Maximum length of a part of a text."""


class StageStream:
    """Frames of one show for its pages. Thread: the show's; the structure is written in a thread of its own."""

    def __init__(self, show: Show, view: Callable[[], StageView], revision: Callable[[], int | None]) -> None:
        """`view` is the picture's snapshot; `revision`: that of the show's files, None before their first edit."""
        self._show, self._view, self._revision = show, view, revision
        self._next, self._count = 0.0, 0
        self._structure: str | None = None
        self._dancers = -1

    def update_patch(self, patch: Patch) -> None:
        """Write the structure of an edited patch, in another thread, if anybody looks."""
        if self._dancers >= 0:
            self._start_writing(patch)

    def _start_writing(self, patch: Patch) -> None:
        writing = "the structure of the score", partial(self._write_structure, patch)
        threading.Thread(target=run_once, args=writing, name="structure", daemon=True).start()

    def _write_structure(self, patch: Patch) -> None:
        library = self._show.graph.library
        steps = [
            {"name": name, "measures": int(library.node_measures[library.node_step == step].max(initial=1))}
            for step, name in enumerate(library.steps)
        ]
        groups = [{"name": group.name, "dancers": group.dancers, "colour": group.colour} for group in patch.group]
        head = json.dumps({"kind": "structure", "revision": self._revision() or 0, "groups": groups, "library": steps})
        self._structure = f'{head[:-1]}, "score": {patch_json(patch)}}}'

    def packets(self, now: float, wants: Any) -> Iterator[list[Any]]:
        """Yield the packets that are due at `now` [s]: ["text", name, part, parts, text] or ["frame", kind, bytes].

        `wants` are the facts of the pages: whether anybody looks, and the dancers whose joints they want (from 1; None:
        nobody's, empty: all).
        """
        if not isinstance(wants, dict) or not wants.get("pages"):
            self._structure = None
            self._dancers = -1
            return
        if self._dancers < 0:
            self._start_writing(self._show.patch)
            self._dancers = 0
        if now < self._next:
            return
        self._next = max(self._next + INTERVAL, now - INTERVAL)  # frames of the show come a little late
        self._count += 1
        structure, self._structure = self._structure, None
        if structure is not None:
            yield from _parts("structure", structure)
        count = min(len(self._show.dancers.drawn_hips), MAX_POSITION_DANCERS)
        if count != self._dancers:
            self._dancers = count
            yield from _parts(
                "dancers", json.dumps({"kind": "dancers", "revision": count, "ids": list(range(1, count + 1))})
            )
        tick = round(self._show.time / TICK)
        yield ["frame", POSITIONS, self._positions(tick)]
        chosen = wants.get("joints")
        if isinstance(chosen, list | tuple):
            yield ["frame", JOINTS, joints_frame(tick, self._view().joint_position[:count], list(chosen))]
        if self._count % CLOCK_EVERY == 0:
            yield from _parts("clock", json.dumps(self._clock()))

    def _positions(self, tick: int) -> bytes:
        dancers = self._show.dancers
        return positions_frame(
            tick, dancers.drawn_hips, heading_of(dancers.leg_rotation[:, 0]), self._show.motion.present
        )

    def _clock(self) -> dict[str, Any]:
        show, view = self._show, self._view()
        playhead = show.playhead
        place = playhead.place(max(show.span.number, 0))
        elements = [
            {
                "kind": ELEMENT_KINDS[int(view.element_kind[row])].text,
                "at": [round(float(value), 2) for value in view.element_position[row]],
                "radius": round(float(view.element_radius[row]), 2), "level": round(float(view.element_level[row]), 2),
            }
            for row in range(view.element_count)
        ]  # fmt: skip
        return {
            "kind": "clock", "time": round(show.time, 3), "measure": show.span.number + 1,
            "beat": round(show.span.fraction(show.timeline.beat_at(show.time)) * show.desk.beats + 1.0, 3),
            "bpm": round(show.follower.tempo, 2), "section": playhead.section_name(place),
            "score_measure": playhead.written_measure(place) + 1, "source": show.follower.source,
            "revision": self._revision(), "elements": elements,
        }  # fmt: skip


def _parts(name: str, text: str) -> Iterator[list[Any]]:
    data = text.encode()
    parts = range(0, len(data), PART_BYTES)
    for part, start in enumerate(parts):
        yield ["text", name, part, len(parts), data[start : start + PART_BYTES]]
