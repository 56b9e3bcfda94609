"""Journal and replay: how fast, how large, what a snapshot costs the frame; the same hashes at every frame rate."""

import json
import math
import tempfile
import time
from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np

from bench._show import crowd_patch
from live.base.event_queue import EventQueue
from live.base.motion_parameters import AMPLITUDE, MIX
from live.cli.bench import Row
from live.clock.ticks import TICK
from live.clock.time_source import ManualClock
from live.control.events.audio import MusicHeard
from live.control.events.events import BeatHeard, ControlEvent, PlaceElement, SetParameter, StepNow
from live.show.engine import Engine
from live.show.journal.journal import Journal, JournalWriter, read_journal
from live.show.journal.journal_writer import read_snapshots
from live.show.journal.replay import Replayer, first_start
from live.show.loader import LoadedShow, load_show
from live.show.patch.patch_search_path import DEFAULT_PATCH
from live.show.show import Show
from live.show.state.snapshot import Snapshotter, restore
from live.show.view.status import Status

DANCERS: Final = 50
FPS: Final = 60
BEAT: Final = 60.0 / 128.0
RATES: Final = (25, 60, 144)
PART_S: Final = 10.0
"""Length of the parts of a replay that are timed [s]."""


@dataclass(frozen=True, slots=True, eq=False)
class Night:
    """A journal on disk, and the show that it is of."""

    loaded: LoadedShow
    path: Path
    seconds: float

    @property
    def journal(self) -> Journal:
        """The journal, read from its beginning."""
        return read_journal(self.path)


def rows(full: bool) -> list[Row]:
    """All figures of journal, snapshots and replay."""
    loaded = load_show(DEFAULT_PATCH)
    with tempfile.TemporaryDirectory() as folder:
        large = replace(loaded, patch=crowd_patch(loaded.patch, DANCERS))
        night = _recorded(large, Path(folder) / "large.jsonl", 180.0 if full else 40.0)
        usual = _recorded(loaded, Path(folder) / "usual.jsonl", 180.0 if full else 40.0)
        return [*_speed(night), *_hashes(usual), *_sizes(usual), *_snapshot(loaded), *_snapshot(large)]


def _events(frame: int) -> list[ControlEvent]:
    """What a busy show hears and is told: two statements a beat, a control each second."""
    now = frame / FPS
    found: list[ControlEvent] = []
    beat = math.floor(now / BEAT)
    if math.floor((frame - 1) / FPS / BEAT) != beat:
        chance = np.random.default_rng(beat).uniform(size=8).tolist()
        at = beat * BEAT + 0.003 * chance[0]
        found.append(
            BeatHeard(
                time=now, source="audio", beat_time=at, period=BEAT + 1e-3 * chance[1], confidence=chance[2],
                beat=beat % 4, beats_per_measure=4,
            )
        )  # fmt: skip
        found.append(
            MusicHeard(
                time=now, source="audio", beat_time=at - BEAT, loudness=chance[3], density=2.0, brightness=chance[4],
                low=chance[5], build=chance[6], loudness_db=-30.0 * chance[7],
            )
        )  # fmt: skip
    if frame % FPS == 0:
        second = frame // FPS
        kinds: list[ControlEvent] = [
            PlaceElement(time=now, source="osc", kind="attract", points=((3.0 * math.sin(second), 1.0),), measures=2.0),
            SetParameter(time=now, source="midi", address=AMPLITUDE.address, value=(0.2 + 0.1 * math.sin(second),)),
            StepNow(time=now, source="osc", name="jump", group="*") if second % 15 == 14 else
            SetParameter(time=now, source="osc", address=MIX.address, value=(0.3,)),
        ]  # fmt: skip
        found.append(kinds[second % len(kinds)])
    return found


def _recorded(loaded: LoadedShow, path: Path, seconds: float) -> Night:
    show, clock, inbox = loaded.start(), ManualClock(), EventQueue[ControlEvent]()
    journal = JournalWriter(path, loaded.header(show, tempo=None))
    engine = Engine(
        show, clock=clock, inbox=inbox, status=Status(show, rejected=Counter, memory=lambda: 0.0), journal=journal,
        stall=math.inf,
    )  # fmt: skip
    for frame in range(1, round(seconds * FPS) + 1):
        clock.set(frame / FPS)
        for event in _events(frame):
            inbox.put(event)
        engine.frame(lambda view: None)
        while journal.facts()["behind"] > 1000:  # this goes faster than life, and nothing may be left out
            time.sleep(0.01)
    journal.close(engine.ticks.index)
    return Night(loaded, path, seconds)


def _speed(night: Night) -> list[Row]:
    """How many times as fast as life a replay is, with hashes compared, on one processor."""
    show = first_start(night.journal, night.loaded).show
    running, speeds = Replayer(show, night.journal.lines_with_damage()), []
    while not running.ended:
        before, begin = running.tick, time.thread_time()
        running.advance(running.tick + PART_S / TICK)
        spent = time.thread_time() - begin
        if running.tick - before >= 0.5 * PART_S / TICK:
            speeds.append((running.tick - before) * TICK / spent)
    peers = {"slowest part": min(speeds), "measures": float(running.result.measures)}
    name = f"replay without drawing, {DANCERS} dancers"
    return [
        Row(name, float(np.median(speeds)), "x real time", 20.0, "at least", peers),
        Row(f"{name}: measures whose state differs", float(running.result.different), "", 0.0),
    ]


def _hashes(night: Night) -> list[Row]:
    """Measures that differ when the pictures between are drawn at other rates."""
    different, last = 0, set()
    for fps in RATES:
        show = first_start(night.journal, night.loaded).show
        running, view, frame = Replayer(show, night.journal.lines_with_damage()), show.view(), 0
        while not running.ended:
            frame += 1
            running.advance(math.floor(frame / fps / TICK))
            show.fill(view, max(frame / fps, running.tick * TICK))
        different += running.result.different
        last.add(show.state_hash())
    return [
        Row("measures whose state differs at 25, 60 or 144 frames/s", float(different), "", 0.0),
        Row("states at the end of these three", float(len(last)), "", 1.0),
    ]


def _sizes(night: Night) -> list[Row]:
    """Bytes an hour, of a busy show of the usual size."""
    hours = night.seconds / 3600.0
    text = night.path.read_text(encoding="utf-8").split("\n")
    beside = night.path.with_name(night.path.name + ".snap")
    lines = sum(len(row) + 1 for row in text[1:]) / 1e6 / hours
    kinds = Counter(json.loads(row).get("event", ["hash"])[0] if '"event":[' in row else "other" for row in text[1:-1])
    kept = [len(data) for data in read_snapshots(beside, [])]
    measures = kinds["BeatHeard"] / 4.0
    each = float(np.mean(kept)) / 1e6
    with_them = lines + measures / hours / 8.0 * each
    return [
        Row("journal of a busy show", lines, "MB/h", 3.0, peers={"first line [kB]": len(text[0]) / 1e3}),
        Row("journal and snapshots", with_them, "MB/h", 30.0, peers={"a snapshot [kB]": each * 1e3}),
    ]


def _snapshot(loaded: LoadedShow) -> list[Row]:
    show = loaded.start()
    source, spent, last = Snapshotter(show), [], None
    tick = 0
    for tick in range(1, round(30.0 / TICK)):
        show.tick(tick * TICK)
        begin = time.thread_time()
        taken = source.capture(tick) if tick % 16 == 0 else None
        if taken is not None:
            spent.append((time.thread_time() - begin) * 1e3)
            last = taken  # a show keeps none: they are sealed at once
    assert last is not None
    data = last.seal()
    begin = time.thread_time()
    restored: Show = restore(loaded, data)
    back = time.thread_time() - begin
    name = f"snapshot, {len(restored.group)} dancers"
    return [
        Row(f"{name}: in the frame, median", float(np.median(spent)), "ms", 1.0, peers={"fastest": min(spent)}),
        Row(f"{name}: compressed", len(data) / 1e3, "kB", 2.5 * len(restored.group)),
        Row(f"{name}: restored", back * 1e3, "ms"),
    ]
