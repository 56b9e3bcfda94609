"""Captured performers: what they cost the frame, the thread that hears them, and the journal.

Shows of 24 dancers without drawing, one of nobody captured, others with performers, go tick by tick in turns, so that
what else the machine does falls on all of them alike.
"""

import time
from typing import Final

import numpy as np
import numpy.typing as npt

from live.bridges.vmc.vmc_input import Seat, VmcStream
from live.bridges.vmc.vmc_protocol import vmc_packets
from live.cli.bench import Row
from live.clock.ticks import TICK
from live.control.events.events import MocapFrame
from live.control.registry.rejections import Tally
from live.motion import quaternion
from live.motion.skeleton import JOINT_COUNT
from live.show.assembly import assemble
from live.show.journal.journal import event_line
from live.show.loader import LoadedShow
from live.show.patch.section_io import MocapSection
from live.show.show import Show

PERFORMERS: Final = 4
WARM: Final = 200
"""Ticks until everybody is wholly captured."""
TICKS: Final = 400
RATE: Final = 60.0


def mocap_rows(loaded: LoadedShow) -> list[Row]:
    """All of it."""
    frames, each = _heard()
    alone, one, four, canon = _frames(loaded, frames)
    written = np.mean([len(event_line(100_000, frame)) + 1 for frame in frames])
    without = {"without [ms]": 1e3 * float(np.median(alone))}
    return [
        Row(
            "a captured performer: a frame's CPU time, median, over without", _over(one, alone), "", 1.5, peers=without
        ),
        Row(f"{PERFORMERS} captured performers: the same", _over(four, alone), "", 3.5),
        Row("one whom 7 dancers repeat in canon: the same", _over(canon, alone), "", 2.25),
        Row("from a performer's packets to her packed pose", 1e6 * each, "µs"),
        Row("60 poses a second: the hearing thread's share of a core", RATE * each, "", 0.1),
        Row("60 poses a second: the journal in an hour", 3600.0 * RATE * float(written) / 1e6, "MB", 64.0),
    ]


def _over(with_it: npt.NDArray[np.float64], without: npt.NDArray[np.float64]) -> float:
    return float(np.median(with_it) / np.median(without))


def _heard() -> tuple[list[MocapFrame], float]:
    """Poses of somebody who goes round, as a stream gives them, and what each took [s]."""
    chance = np.random.default_rng(3)
    given: list[MocapFrame] = []
    stream = VmcStream(lambda _: Seat("anna"), Tally(), given.append)
    lean = chance.normal(scale=0.3, size=(JOINT_COUNT, 3))
    taken = []
    for number in range(300):
        at = number / RATE
        rotation = quaternion.from_rotation_vector(lean * np.sin(3.0 * at))
        packets = list(vmc_packets(np.array([np.sin(at), 0.93, np.cos(at)]), rotation, at))
        begin = time.process_time()
        for packet in packets:
            stream.handle(packet, at)
        taken.append(time.process_time() - begin)
    return given, float(np.median(taken))


def _frames(loaded: LoadedShow, frames: list[MocapFrame]) -> list[npt.NDArray[np.float64]]:
    """CPU time of frames [s] with nobody, one, PERFORMERS, and one with a canon."""
    casts = (0, "none"), (1, "none"), (PERFORMERS, "none"), (1, "tide")
    shows = [(count, _show(loaded, count, canon)) for count, canon in casts]
    views = [show.view() for _, show in shows]
    took = np.zeros((len(shows), WARM + TICKS))
    for tick in range(WARM + TICKS):
        now = (tick + 1) * TICK
        pose = frames[tick % len(frames)].pose
        for index, ((count, show), view) in enumerate(zip(shows, views, strict=True)):
            begin = time.process_time()
            for number in range(count):
                show.apply(MocapFrame(time=now - 0.004, source="vmc", performer=f"p{number}", pose=pose))
            show.tick(now)
            show.fill(view, now)
            took[index, tick] = time.process_time() - begin
    return list(took[:, WARM:])


def _show(loaded: LoadedShow, count: int, canon: str) -> Show:
    """A show with so many performers, a few metres apart."""
    mocap = tuple(MocapSection(name=f"p{n}", at=(3.0 * n - 4.5, 0.0), canon=canon) for n in range(count))
    return assemble(loaded.patch.model_copy(update={"mocap": mocap}), loaded.graph)
