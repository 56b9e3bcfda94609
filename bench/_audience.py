"""Two thousand phones: what the gateway takes, how long a finger's way is to the simulation, whether ticks are late.

And who is heard: a hall behind one address, and a laptop with forty addresses among forty phones.
"""

import contextlib
import gc
import json
import subprocess
import sys
import threading
import time
from dataclasses import dataclass, field
from typing import IO, Any, Final, Literal

import numpy as np
import psutil

from live.app.launch_options import LaunchOptions
from live.app.services.audience_service import AudienceService
from live.base.event_queue import EventQueue
from live.cli.bench import Row
from live.clock.ticks import TICK
from live.clock.time_source import SystemClock
from live.control.events.audience import VoicePlace
from live.control.events.events import AudienceHeard, ControlEvent
from live.render.timing.frame_stats import Pacer
from live.show.engine import Engine
from live.show.loader import load_show
from live.show.patch.patch_search_path import DEFAULT_PATCH
from live.show.venue.venue import Venue
from live.show.venue.venue_audience import VenueAudience
from live.show.view.status import Status

PHONES: Final = 2000
RATE: Final = 10.0
STORM: Final = 10.0
FPS: Final = 60.0


@dataclass(slots=True)
class Found:
    """What was measured while the phones options."""

    told: dict[str, Any] = field(default_factory=dict)
    """What the phones say."""
    ways: list[float] = field(default_factory=list)
    """From the gateway's telling to the simulation [s]."""
    waits: list[list[float]] = field(default_factory=list)
    """How late turns were, p99, and how long voices waited, median and p99 [ms], each half second."""
    behind: list[float] = field(default_factory=list)
    skipped: int = 0
    cpu: float = 0.0
    storm_cpu: float = 0.0
    memory: list[float] = field(default_factory=list)
    seconds: float = 0.0


class Stage:
    """A show with an audience, driven frame by frame."""

    def __init__(self, network: Literal["own wifi", "behind nat"]) -> None:
        self.show, self.clock = load_show(DEFAULT_PATCH).start(), SystemClock()
        inbox: EventQueue[ControlEvent] = EventQueue()
        self.status = Status(self.show, rejected=lambda: self.part.refused(), memory=lambda: 0.0)
        self.engine = Engine(self.show, clock=self.clock, inbox=inbox, status=self.status)
        self.engine.event_listeners.append(self._hear)
        options = LaunchOptions(audience=("127.0.0.1", 0), audience_secret=b"bench" * 7)
        venue = Venue(audience=VenueAudience(network=network))
        self.part = AudienceService(options, self.show, inbox.add_queue(), self.clock, venue)
        self.found = Found()
        self.places: list[tuple[VoicePlace, ...]] = []
        """Where voices gathered, each time that it was told."""
        self.most: dict[str, float] = {}
        """What the status said when there were most voices."""

    def _hear(self, event: ControlEvent) -> None:
        if isinstance(event, AudienceHeard):
            self.found.ways.append(self.clock.now() - event.time)
            if event.places:
                self.places.append(event.places)

    def frame(self) -> None:
        """One frame, without drawing."""
        self.part.before_frame()
        self.engine.frame(lambda view: None)
        self.part.frame()
        gc.collect(0)

    def _open(self) -> Pacer:
        """Let phones in, and frames pass until there is a link."""
        self.part.start()
        pacer = Pacer(FPS, self.clock.now, time.sleep)
        while not self.part.link:
            pacer.wait()
            self.frame()
        return pacer

    def phones(self, *words: object) -> "subprocess.Popen[str]":
        """A process of phones with the code of the moment; `words` as `bench._phones` takes them from COUNT on."""
        key = self.part.link.partition("#")[2]
        said = [str(word) for word in (self.part.port, key, *words)]
        return subprocess.Popen([sys.executable, "-m", "bench._phones", *said], stdout=subprocess.PIPE, text=True)

    def meet(self, *crowds: tuple[object, ...]) -> list[dict[str, Any]]:
        """Let crowds of phones come and play; what each says, and what the status said of all while they options."""
        pacer = self._open()
        running = [self.phones(*words) for words in crowds]
        while any(process.poll() is None for process in running):
            pacer.wait()
            self.frame()
            told = self.part.status()
            if (told["voices"] or 0.0) >= self.most.get("voices", 0.0):
                self.most = {name: float(told[name] or 0) for name in ("voices", "crowded")}
        self.part.stop()
        found = []
        for process in running:
            said, _ = process.communicate()
            found.append(json.loads(said.splitlines()[-1]))
        return found

    def run(self, seconds: float) -> Found:
        """Storm and load."""
        pacer = self._open()
        gateway = psutil.Process(self.part.pid)
        process = self.phones(PHONES, STORM, seconds, RATE, 1, 0, 0.7)
        lines: list[str] = []
        assert process.stdout is not None
        reader = threading.Thread(target=_read, args=(process.stdout, lines))
        reader.start()
        spent, began, noted = _cpu(gateway), self.clock.now(), 0.0
        playing = False
        while process.poll() is None:
            pacer.wait()
            self.frame()
            now = self.clock.now()
            if lines and not playing:
                playing = True
                self.found.storm_cpu = (_cpu(gateway) - spent) / max(now - began, 1e-3)
                self.found.ways.clear()
                skipped, spent, began = self.status.skipped_ticks, _cpu(gateway), now
            if playing and now - began < seconds:
                self.found.behind.append(max(now + TICK - self.engine.ticks.time, 0.0))
                self.found.skipped = self.status.skipped_ticks - skipped
                self.found.seconds, self.found.cpu = now - began, (_cpu(gateway) - spent) / max(now - began, 1e-3)
                if now - noted > 0.5:
                    noted = now
                    self.found.memory.append(gateway.memory_info().rss / 1e6)
                    told = self.part.status()
                    self.found.waits.append([told["late_ms"][1], *told["ways_ms"]])
        reader.join()
        with contextlib.suppress(ValueError, IndexError):
            self.found.told = json.loads(lines[-1])
        self.part.stop()
        return self.found


def _read(stream: IO[str], lines: list[str]) -> None:
    lines.extend(iter(stream.readline, ""))


def _cpu(process: psutil.Process) -> float:
    times = process.cpu_times()
    return float(times.user + times.system)


def audience_rows(full: bool) -> list[Row]:
    """The rows of `live bench control`."""
    return [*_load(full), *_fairness()]


def _fairness() -> list[Row]:
    """Who is in, and who is heard."""
    hall = Stage("behind nat")
    [told] = hall.meet((200, 1.0, 4.0, RATE, 0, 0, 0.5))
    rows = [
        Row("200 phones behind one address: all are in after",
            told["longest_s"] if told["joined"] == 200 else None, "s", 20.0,
            peers={"joined": told["joined"], "voices": hall.most.get("voices", 0.0)}),
    ]  # fmt: skip
    wifi = Stage("own wifi")
    people, laptop = wifi.meet((40, 1.0, 8.0, RATE, 1, 0, 0.2), (640, 1.0, 8.0, RATE, 16, 1000, 0.9))
    said = [told for told in wifi.places[-200:-20] if told]
    weight = sum(place[2] for places in said for place in places)
    own = sum(place[2] for places in said for place in places if place[0] > 0)
    voices = wifi.most.get("voices", 0.0)
    return [
        *rows,
        Row("40 phones and a laptop of 40 addresses with 16 sockets each: the laptop's share of the force",
            100.0 * own / weight if weight else None, "%", 5.0,
            peers={"phones in": people["joined"], "its sockets in": laptop["joined"],
                   "moments at which it has a place": sum(any(place[0] > 0 and place[2] for place in places)
                                                          for places in said),
                   "voices in all": voices, "groups that are a crowd": wifi.most.get("crowded", 0.0)}),
    ]  # fmt: skip


def _load(full: bool) -> list[Row]:
    """Two thousand phones with addresses of their own."""
    found = Stage("own wifi").run(120.0 if full else 6.0)
    told, ways = found.told, np.array(found.ways or [0.0]) * 1e3
    waits = found.waits[len(found.waits) // 2 :]
    late, middle, wait = (float(value) for value in np.median(waits or [[0.0] * 3], axis=0))
    way = float(np.percentile(ways, 99))
    growth = None
    if full and len(found.memory) > 20:
        third = len(found.memory) // 3
        hours = found.seconds * (len(found.memory) - third) / len(found.memory) / 3600.0
        growth = (found.memory[-1] - found.memory[third]) / hours
    return [
        Row("2,000 phones within 10 s: joined", told.get("joined", 0), "", PHONES, "at least",
            peers={"p99 of a join [ms]": told.get("join_p99_ms", 0.0), "gateway [cores]": found.storm_cpu}),
        Row("2,000 phones, 10 messages/s each: the gateway's share of a core", found.cpu, "", 0.6,
            peers={"messages/s": told.get("rate", 0.0), "the phones' share": told.get("cpu", 0.0),
                   "cut off": told.get("lost", 0)}),
        Row("from a phone's socket to the simulation, p99", late + wait + way, "ms", 50.0,
            peers={"unread p99": late, "waits for the turn p99": wait, "median": middle, "to the tick p99": way,
                   "a ping there and back, median": told.get("trip_p50_ms", 0.0),
                   "p99": told.get("trip_p99_ms", 0.0), "load average": psutil.getloadavg()[0]}),
        Row("2,000 phones: the stage comes so often to each", told.get("frames", 0.0), "1/s", 4.0, "at least",
            peers={"bytes of a frame": told.get("frame_bytes", 0.0)}),
        Row("2,000 phones: the gateway's memory", max(found.memory, default=0.0), "MB", 200.0),
        Row("2,000 phones: the gateway's growth in an hour", growth, "MB", 20.0),
        Row("2,000 phones: skipped ticks", found.skipped, "", 0.0,
            peers={"p99 behind [ms]": float(np.percentile(found.behind or [0.0], 99)) * 1e3}),
    ]  # fmt: skip
