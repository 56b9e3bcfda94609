"""Interrupts: are cuts within the measure smooth, do feet stay, and do dancers go out of the way of somebody real?"""

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
import numpy.typing as npt

from bench._locomotion_scenes import BPM, stage
from live.cli.bench import Row
from live.clock.ticks import TICK
from live.control.events.events import Performer, StepNow
from live.graph.dance_metrics import RawClips
from live.motion.editing.foot_correction import ANKLES, BALLS
from live.motion.foot_contact import TOES_OVER_SOLE
from live.motion.pose.inertialization_kernels import MAX_FADE_TIME
from live.motion.quality.metrics import contact_slide_speeds, largest_at_samples
from live.motion.skeleton import SOLE_BELOW_ANKLE
from live.show.assembly import assemble

Float64 = npt.NDArray[np.float64]
Bool = npt.NDArray[np.bool_]

RATE: Final = 1.0 / TICK
STEPS: Final = ("samba", "side step", "walk", "kick", "reach")
BEFORE, AFTER = 3, int(MAX_FADE_TIME * RATE) + 3
"""Ticks before and after a cut that are looked at."""
NEAR_FLOOR: Final = 0.03
RUN: Final = 3.0
"""How fast somebody real runs through the group [m/s]."""


@dataclass(frozen=True, slots=True, eq=False)
class Danced:
    """T ticks of A dancers; cuts as ticks and dancers (n, 2)."""

    position: npt.NDArray[np.float32]
    contact: Bool
    held: Bool
    cuts: npt.NDArray[np.int64]
    waits: Float64
    """From each cue to the cut [beats]."""
    spent: Float64
    """CPU time of the ticks with cuts [ms]."""


def run(full: bool, shared: Path | None) -> list[Row]:
    """Cues for all 24 dancers at random moments, 30 s, with `full` three seeds of 90 s; 16 s of somebody running."""
    seeds, seconds = ((1, 2, 3), 90.0) if full else ((1,), 30.0)
    found = [danced(seed, seconds) for seed in seeds]
    hard = [danced(seed, seconds, hard=True) for seed in seeds]
    raw = RawClips(stage().graph.library.clips, 240.0 / BPM, RATE).p99(0.5 * (BEFORE + AFTER) / RATE)
    rows = []
    for n, name in enumerate(("velocity change", "acceleration")):
        own, without, jump = (_p99(part) for part in (_at_cuts(found, n), _elsewhere(found, n), _at_cuts(hard, n)))
        peers = {"without cuts": without / raw[n], "cuts without inertia": jump / raw[n]}
        rows.append(Row(f"{name} at cuts, p99, to the raw clips'", own / raw[n], "", 1.0, peers=peers))
    slide, planted = _slide(found), _planted(found)
    rows += [
        Row("foot slide in contact on the floor while cuts settle, mean", float(slide.mean()), "m/s", 0.03),
        Row("... p99", _p99(slide), "m/s", 0.10),
        Row("feet that stand before and after a cut: moved, p95", float(np.percentile(planted, 95)), "m", 0.01),
        Row("from a cue to the cut, longest", float(np.concatenate([f.waits for f in found]).max()), "beats", 0.55),
        Row("tick with a cut of 24 dancers, median", float(np.median(found[0].spent)), "ms"),
    ]
    with_care, without_care = run_through(careful=True), run_through(careful=False)
    return [
        *rows,
        Row("dancers within 0.5 m of somebody real", with_care[0], "s", None, peers={"never cut": without_care[0]}),
        Row("nearest to her", with_care[1], "m", None, peers={"never cut": without_care[1]}),
    ]


def danced(seed: int, seconds: float, *, hard: bool = False) -> Danced:
    """A dance with cues at random; `hard`: nothing of the old motion is kept."""
    show, chance = assemble(stage().patch, stage().graph, seed=seed), np.random.default_rng(seed)
    view = show.view()
    position, contact, held, cuts, waits, spent = [], [], [], [], [], []
    next_cue, waiting = 3.0, 0.0
    for number in range(1, int(seconds * RATE)):
        now = number * TICK
        if now >= next_cue:
            name, measures = STEPS[int(chance.integers(len(STEPS)))], float(chance.integers(0, 3))
            show.apply(StepNow(time=now, source="bench", name=name, measures=measures))
            waiting, next_cue = show.timeline.beat_at(now), now + chance.uniform(1.5, 4.0)
        cues, begun = show.interrupts.cue_count, time.process_time()
        show.tick(now)
        rows = np.flatnonzero(show.dancers.inertia.cut_time == now)
        if len(rows):
            spent.append(1e3 * (time.process_time() - begun))
            cuts += [(number - 1, int(row)) for row in rows]
            waits += [show.timeline.beat_at(now) - waiting] if show.interrupts.cue_count > cues else []
            if hard:
                show.dancers.inertia.clear(rows)
        show.fill(view, now)
        position.append(view.joint_position.copy())
        contact.append(show.dancers.contact(show.span.fraction(show.timeline.beat_at(now))).copy())
        held.append(show.dancers.lock.state[:, :, 5] > 0.0)
    arrays = np.array(position), np.array(contact), np.array(held)
    return Danced(*arrays, np.array(cuts).reshape(-1, 2), np.array(waits), np.array(spent))


def run_through(*, careful: bool) -> tuple[float, float]:
    """How long dancers are within 0.5 m of somebody who runs to and fro among them [s], and how near [m]."""
    show = assemble(stage().patch, stage().graph, seed=1)
    if not careful:
        show.interrupts._collision_avoidance.tick = lambda *arguments: None  # type: ignore[method-assign]
    within, nearest = 0.0, np.inf
    for number in range(1, int(16.0 * RATE)):
        now = number * TICK
        turn, way = divmod(max(now - 3.0, 0.0) * RUN, 10.0)
        place = np.array([way - 5.0 if turn % 2 == 0 else 5.0 - way, (0.0, 1.2, -1.2)[int(turn) % 3]])
        if now >= 3.0 and number % 3 == 0:
            show.apply(Performer(time=now, source="bench", name="ann", x=float(place[0]), z=float(place[1])))
        show.tick(now)
        if now >= 3.1:
            away = np.hypot(*(show.dancers.drawn_hips - place).T)
            within, nearest = within + float((away < 0.5).sum()) * TICK, min(nearest, float(away.min()))
    return within, nearest


def _p99(values: Float64) -> float:
    return float(np.percentile(values, 99))


def _windows(dance: Danced) -> Bool:
    """Which ticks of which dancers lie around a cut, (T, A)."""
    found = np.zeros(dance.position.shape[:2], np.bool_)
    for at, row in dance.cuts:
        found[max(at - BEFORE, 0) : at + AFTER, row] = True
    return found


def _at_cuts(dances: list[Danced], which: int) -> Float64:
    """The largest value around each cut."""
    found = []
    for dance in dances:
        trace = largest_at_samples(dance.position, RATE)[which]
        found += [trace[max(at - BEFORE, 0) : at + AFTER, row].max() for at, row in dance.cuts]
    return np.array(found)


def _elsewhere(dances: list[Danced], which: int) -> Float64:
    """The same of as long windows without a cut."""
    found = []
    for dance in dances:
        trace, cut = largest_at_samples(dance.position, RATE)[which], _windows(dance)
        for at in range(64, len(trace) - AFTER, 16):
            free = ~cut[at - BEFORE : at + AFTER].any(axis=0)
            found.append(trace[at - BEFORE : at + AFTER, free].max(axis=0))
    return np.concatenate(found)


def _slide(dances: list[Danced]) -> Float64:
    """Speeds [m/s] of feet that the clips have in contact and that are on the floor, around cuts."""
    found = []
    for dance in dances:
        ankle, ball = dance.position[:, :, list(ANKLES), 1], dance.position[:, :, list(BALLS), 1]
        low = np.minimum(ankle - SOLE_BELOW_ANKLE, ball - TOES_OVER_SOLE) < NEAR_FLOOR
        stands = dance.contact & low & _windows(dance)[:, :, None]
        for at in np.flatnonzero(stands.any(axis=(1, 2))):
            found.append(contact_slide_speeds(dance.position[at - 1 : at + 1], stands[at - 1 : at + 1], RATE))
    return np.concatenate(found)


def _planted(dances: list[Danced]) -> Float64:
    """How far [m] the ball of each foot moves that is held before a cut and stands in the new clip till it settled."""
    found = []
    for dance in dances:
        for at, row in dance.cuts:
            for side in range(2):
                until = at + int(MAX_FADE_TIME * RATE)
                if dance.held[at - 1, row, side] and dance.contact[at:until, row, side].all():
                    way = dance.position[at - 1 : until, row, BALLS[side]][:, (0, 2)]
                    found.append(float(np.hypot(*(way - way[0]).T).max()))
    return np.array(found)
