"""State of the stage for pages, as frames: structure and clock as text, positions and joints in binary.

A binary frame is u8 kind, u8 flags, u16 count, u32 tick, then int16, all little-endian. Kind 1: x, z [mm], heading
[1/10,000 turn] and state (1: on the stage) of each dancer. Kind 2: the joints of each dancer, x, y, z [mm]. Dancers
come in the order of the last text frame `dancers`. What is too far away for an int16 stands at its border.
"""

import json
import struct
import threading
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.base.element_kinds import ELEMENT_KINDS
from live.base.fault_isolation import run_once
from live.base.stage_snapshot import StageView
from live.clock.ticks import TICK
from live.motion.editing.facing import heading_of
from live.show.patch.patch import Patch
from live.show.patch.table_batches import patch_json
from live.show.show import Show

INTERVAL: Final = 1.0 / 30.0
"""Time between two frames [s]."""
CLOCK_EVERY: Final = 3
"""Every so many frames there is one with clock and elements."""
POSITIONS, JOINTS = 1, 2
"""Kinds of binary frames."""
MAX_JOINT_DANCERS: Final = 450
"""Maximum number of dancers in a frame with joints: a packet has 64 KiB."""
MAX_POSITION_DANCERS: Final = 8000
PART_BYTES: Final = 32_768
"""Maximum length of a part of a text."""
_HEAD: Final = struct.Struct("<BBHI")
_LIMIT: Final = 32767


def _int16(values: npt.NDArray[np.floating]) -> npt.NDArray[np.int16]:
    whole: npt.NDArray[np.int16] = np.clip(np.rint(values), -_LIMIT, _LIMIT).astype("<i2")
    return whole


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
        yield ["frame", POSITIONS, self._positions(tick, count)]
        chosen = wants.get("joints")
        if isinstance(chosen, list | tuple):
            yield ["frame", JOINTS, self._joints(tick, count, chosen)]
        if self._count % CLOCK_EVERY == 0:
            yield from _parts("clock", json.dumps(self._clock()))

    def _positions(self, tick: int, count: int) -> bytes:
        dancers = self._show.dancers
        rows = np.empty((count, 4), np.float64)
        rows[:, :2] = dancers.drawn_hips[:count] * 1e3
        rows[:, 2] = heading_of(dancers.leg_rotation[:count, 0]) * (10_000 / (2.0 * np.pi))
        rows[:, 3] = self._show.motion.present[:count]
        return _HEAD.pack(POSITIONS, 0, count, tick & 0xFFFFFFFF) + _int16(rows).tobytes()

    def _joints(self, tick: int, count: int, chosen: Sequence[Any]) -> bytes:
        joints = self._view().joint_position
        rows = [each - 1 for each in chosen if type(each) is int and 1 <= each <= min(count, len(joints))]
        found = joints[rows] if chosen else joints[:count]
        found = found[:MAX_JOINT_DANCERS]
        flags = 1 if chosen else 0  # 1: only the chosen ones, in the order in which they were asked for
        return _HEAD.pack(JOINTS, flags, len(found), tick & 0xFFFFFFFF) + _int16(found * 1e3).tobytes()

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
