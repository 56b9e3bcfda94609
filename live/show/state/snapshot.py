"""Snapshots: the whole state of a show after a tick, as bytes, for a bit-identical continuation (T148, T150).

A snapshot is taken when no planning is in progress. Objects determined by patch and steps (graph, tables) are stored by
name and looked up in a fresh show; values recomputed in every tick are left out; everything else is written field by
field (`live/show/state`). A snapshot is pure data: reading it calls nothing that it names.
"""

import hashlib
import json
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live import __version__
from live.agents.entrances.entrances import LEAVING
from live.base.picture_parameters import PART_COUNT
from live.clock.ticks import TICK
from live.graph.motion_graph import MotionGraph
from live.motion.skeleton import JOINT_COUNT
from live.show.loader import LoadedShow
from live.show.partner.example_bank import ExampleBank
from live.show.patch.patch import Patch
from live.show.score.subgroups import MAX_SUBGROUPS
from live.show.selection.graph_update import steps_hash
from live.show.show import Show
from live.show.state.byte_format import MAX_STATE_BYTES, StateDecodeError
from live.show.state.constants import Constants, attribute_at
from live.show.state.decoder import read_state
from live.show.state.encoder import CapturedState
from live.show.state.state_writer import StateCapture
from live.show.state.type_check import check_state

Array = npt.NDArray[Any]

FORMAT: Final = 9
"""Format 1 was a pickle; formats 2 to 8 had other fields. These are refused."""
CONSTANT_PATHS: Final = {
    "graph": "graph",
    "patch": "patch",
    "choosing": "scheduler.choosing",
    "foresight": "scheduler.targets.step_costs",
    "score": "score_runner.score.written",
    "texture": "dancers.texture.bank",
    "skeleton": "dancers._pipeline.skeleton",
    "legs": "dancers._legs.skeleton",
    "answers": "hot_swap.answers",
    "parameters": "desk.parameters.table",
    "views": "desk.scenes._views",
    "looks": "desk.scenes._looks",
    "worlds": "desk.scenes._worlds",
    "scenes": "desk.scenes._scenes",
    "cues": "desk.cues._cues",
    "own-passes": "desk.scenes._custom_passes",
    "springs": "springs.cast",
}
"""Constants, determined by patch, steps and seed: paths by their names in snapshots. A fresh show provides them."""
VARIABLE_PATHS: Final = ("scheduler.choosing.max_turns", "scheduler.choosing.facts")
"""Tables inside constants that change in the course of a show."""
SCRATCH_PATHS: Final = (
    "dancers._pipeline.position", "dancers._pipeline.rotation", "dancers._pipeline.feet",
    "dancers._legs.position", "dancers._legs.rotation", "dancers._legs.feet", "dancers._bare_legs",
    "dancers._mood.bend", "dancers._mood.size", "dancers._mood.drop", "dancers._mood.gaze", "dancers._mood.late",
    "dancers._mood._still",
    "motion.elements._field._mesh", "motion.elements._field._start", "motion.elements._field._sums",
    "motion.elements._field._nearest", "motion._advance._advance._rows", "motion._advance._advance._numbers",
)  # fmt: skip
"""Scratch arrays, which are computed before they are read."""


class SnapshotError(Exception):
    """A snapshot that cannot be taken or used; the message gives the reason."""


class _Origin:
    """Graph, patch and examples of snapshots, with their hashes."""

    def __init__(self, graph: MotionGraph, patch: Patch, answers: ExampleBank) -> None:
        self.graph, self.patch, self.answers = graph, patch, answers
        self._hashes: dict[str, str] = {}

    @property
    def constants(self) -> tuple[MotionGraph, Patch, ExampleBank]:
        """Graph, patch and examples: whether they are still those of a show."""
        return self.graph, self.patch, self.answers

    def hashes(self) -> dict[str, str]:
        """Return the hashes, computed at the first call. Thread: any one."""
        if not self._hashes:
            self._hashes = {
                "steps_hash": steps_hash(self.graph),
                "patch_hash": patch_hash(self.patch),
                "examples_hash": self.answers.digest(),
            }
        return self._hashes


@dataclass(frozen=True, slots=True, eq=False)
class CapturedSnapshot:
    """A state captured within the frame; `seal` does the slow part later."""

    written: CapturedState
    tick: int
    measure: int
    """The current measure, from 1."""
    seed: int
    origin: _Origin

    def seal(self) -> bytes:
        """Return the snapshot: a line of JSON, and the compressed state. Thread: any one.

        SnapshotError if the show held an object of an unknown kind, or an unlisted field.
        """
        try:
            payload = self.written.encode()
        except Exception as error:
            raise _unwritable(error) from error
        packed = zlib.compress(payload, 1)
        header = {
            "snapshot": FORMAT,
            "version": __version__,
            "tick": self.tick,
            "measure": self.measure,
            "seed": self.seed,
            **self.origin.hashes(),
            "size": len(payload),
        }
        return _line(header | {"check": _checksum(header, packed)}) + b"\n" + packed


class Snapshotter:
    """Takes snapshots of one show. Thread: the show's."""

    def __init__(self, show: Show) -> None:
        """Walks through all constants; this takes some milliseconds, so not within a frame."""
        self.show = show
        self._constants: Constants | None = None
        self._begin()

    def _begin(self) -> None:
        show = self.show
        self._origin = _Origin(show.graph, show.patch, show.hot_swap.answers)
        self._constants = Constants(show, CONSTANT_PATHS, SCRATCH_PATHS, self._constants)
        self._writer = StateCapture(self._constants)
        self._variable = [attribute_at(show, path) for path in VARIABLE_PATHS]

    def capture(self, tick: int) -> CapturedSnapshot | None:
        """Capture the state after `tick`; None while planning is in progress: try again at the next tick.

        SnapshotError if the show holds an object of an unknown kind.
        """
        show = self.show
        if not at_rest(show):
            return None
        now = show.graph, show.patch, show.hot_swap.answers
        if any(one is not other for one, other in zip(now, self._origin.constants, strict=True)):
            self._begin()
        try:
            written = self._writer.capture((show, tuple(array.copy() for array in self._variable)))
        except Exception as error:
            raise _unwritable(error) from error
        return CapturedSnapshot(written, tick, show.span.number + 1, show.seed, self._origin)


def at_rest(show: Show) -> bool:
    """Whether no planning is in progress, so that the state is plain values."""
    return show.scheduler.at_rest and show.motion.evolutions.at_rest and show.hot_swap.at_rest


def snapshot(show: Show, tick: int | None = None) -> bytes:
    """Return the show's state after `tick` (None: the one at `show.time`); SnapshotError while planning is in
    progress."""
    taken = Snapshotter(show).capture(round(show.time / TICK) if tick is None else tick)
    if taken is None:
        raise SnapshotError("planning is in progress: take the snapshot some ticks later")
    return taken.seal()


def snapshot_header(data: bytes) -> dict[str, Any]:
    """Return a snapshot's header (tick, measure, seed …) after verifying its checksum; SnapshotError for damage."""
    line, _, packed = data.partition(b"\n")
    try:
        facts = json.loads(line)
        kind, version, check = facts["snapshot"], facts["version"], facts.pop("check")
        whole = all(isinstance(facts[key], int) for key in ("tick", "measure", "seed", "size"))
    except (ValueError, KeyError, TypeError, RecursionError):
        raise SnapshotError("not a snapshot, or its first line is damaged") from None
    if kind != FORMAT or version != __version__:
        raise SnapshotError(f"the snapshot is of version {version} (format {kind}), this is {__version__} ({FORMAT})")
    if not whole or not 0 <= facts["size"] <= MAX_STATE_BYTES or _checksum(facts, packed) != check:
        raise SnapshotError("the snapshot is damaged: its checksum is wrong")
    known: dict[str, Any] = facts
    return known


def restore(loaded: LoadedShow, data: bytes, *, fresh: Show | None = None) -> Show:
    """Return the show in the state of the snapshot; SnapshotError for damage, another patch or other steps.

    `fresh`: an unused show that `loaded` has started; it must not be used afterwards. Default: start one. Listeners of
    the old show (`seed_tracker`) must be registered again.
    """
    facts = snapshot_header(data)
    for key, found, words in origin_hashes(loaded):
        if facts.get(key) != found:
            raise SnapshotError(f"the snapshot is of other {words} ({facts.get(key)}) than those loaded ({found})")
    root = loaded.start(seed=facts["seed"], begin=False) if fresh is None else fresh
    try:
        show, variable = _read(_unpacked(data, facts["size"]), root)
    except StateDecodeError as error:
        raise SnapshotError(f"the snapshot cannot be read: {error}") from None
    for path, values in zip(VARIABLE_PATHS, variable, strict=True):
        attribute_at(root, path)[...] = values
    show.hot_swap.resume(root.hot_swap, loaded.reserve, loaded.later_answers)
    return show


def origin_hashes(loaded: LoadedShow) -> tuple[tuple[str, str, str], ...]:
    """Return the hashes that a snapshot of a loaded show has in its header: key, value, and what it is of."""
    return (
        ("steps_hash", steps_hash(loaded.graph), "steps"),
        ("patch_hash", patch_hash(loaded.patch), "patch"),
        ("examples_hash", (loaded.answers or ExampleBank(())).digest(), "examples of partners"),
    )


def _unpacked(data: bytes, size: int) -> bytes:
    unpacker = zlib.decompressobj()
    try:
        payload = unpacker.decompress(data.partition(b"\n")[2], size + 1)
    except zlib.error as error:
        raise StateDecodeError(str(error)) from None
    if len(payload) != size:
        raise StateDecodeError(f"{size} bytes expected, found {'more' if len(payload) > size else len(payload)}")
    return payload


def _read(payload: bytes, fresh: Show) -> tuple[Show, tuple[Array, ...]]:
    found = read_state(payload, Constants(fresh, CONSTANT_PATHS, SCRATCH_PATHS))
    if not isinstance(found, tuple) or len(found) != 2 or not isinstance(found[1], tuple):
        raise StateDecodeError("it holds no show")
    show, variable = found
    check_state(show, "show", fresh, index_limits(fresh))
    like = [attribute_at(fresh, path) for path in VARIABLE_PATHS]
    if [_array_form(each) for each in variable] != [_array_form(each) for each in like]:
        raise StateDecodeError("its tables have other shapes")
    return show, variable


def index_limits(show: Show) -> dict[str, int]:
    """Return the number of items that each index type of the kinds can refer to."""
    graph, bank, choosing = show.graph, show.dancers.texture.bank, show.scheduler.choosing
    return {
        "node": graph.library.node_count,
        "edge": len(graph.edge_target),
        "candidate": len(choosing.candidates.node),
        "step": len(graph.library.steps),
        "dancer": len(show.group),
        "group": len(show.patch.group),
        "aim": len(show.scheduler.targets.ahead),
        "subgroup": MAX_SUBGROUPS,
        "part": PART_COUNT,
        "joint": JOINT_COUNT,
        "side": 2,
        "presence": 1 + LEAVING,
        "gate": len(show.motion.gates),
        "fragment": 0 if bank is None else bank.leg_features.shape[1],
    }


def _array_form(found: object) -> tuple[Any, ...]:
    return (found.dtype, found.shape) if isinstance(found, np.ndarray) else ()


def patch_hash(patch: Patch) -> str:
    """Return a short hash of a patch's content."""
    return hashlib.blake2b(patch.model_dump_json().encode(), digest_size=8).hexdigest()


def _unwritable(error: Exception) -> SnapshotError:
    return SnapshotError(f"the state cannot be written: {error}")


def _line(facts: dict[str, Any]) -> bytes:
    return json.dumps(facts, separators=(",", ":")).encode()


def _checksum(facts: dict[str, Any], packed: bytes) -> str:
    return hashlib.blake2b(_line(facts) + packed, digest_size=16).hexdigest()


AFTER_LINE: Final = 6
"""Ticks between a measure line and its snapshot, because the frame of the line is busy."""
MAX_FAILURES: Final = 8
"""Failures in a row after which no more snapshots are tried, because each costs time in the frame."""


class SnapshotPolicy:
    """Snapshot policy: one per measure, at the first tick without planning in progress (T148). Thread: the show's."""

    def __init__(self, put: Callable[[CapturedSnapshot], None]) -> None:
        self._put = put
        self._source: Snapshotter | None = None
        self._due: int | None = None
        self._in_a_row = 0
        self.failed = 0
        """Snapshots that could not be taken."""
        self.problem = ""
        """Reason of the last failure."""

    def prepare(self, show: Show) -> None:
        """Prepare for snapshots of this show, which takes some milliseconds; otherwise the first snapshot does it."""
        self._source = Snapshotter(show)

    def after_tick(self, show: Show, tick: int, *, begins: bool) -> None:
        """Take a snapshot if one is due. Call it after each tick; `begins`: a measure began with `tick`."""
        if begins:
            self._due = tick + AFTER_LINE
        if self._due is None or tick < self._due or self._in_a_row >= MAX_FAILURES:
            return
        if self._source is None or self._source.show is not show:
            self.prepare(show)
        assert self._source is not None
        try:
            taken = self._source.capture(tick)
        except SnapshotError as error:
            self.failed += 1
            self._in_a_row += 1
            self.problem, self._due = str(error), None
            return
        if taken is not None:
            self._in_a_row, self._due = 0, None
            self._put(taken)
