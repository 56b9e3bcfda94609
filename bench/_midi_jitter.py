"""MIDI clock with 5 ms of jitter, from the bytes of a wire to the beat that is danced, in virtual time.

Each pulse falls within a note of a stream with running status, as a keyboard that is played sends it. What is measured
is the Timeline that dancers follow, and the tempo that is shown, from the 16th beat on; phase after the mean delay, for
jitter is always late.
"""

from collections.abc import Callable
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.event_queue import EventQueue
from live.cli.bench import Row
from live.clock.follower.timeline_follower import TimelineFollower
from live.clock.ticks import TICK
from live.control.events.events import BeatHeard, ControlEvent, SourceChanged
from live.control.midi.midi_decoder import MidiEventDecoder
from live.control.midi.midi_streams import MidiTokenizer
from live.show.sound.clock_commands import apply_clock_event

PULSES: Final = 24
JITTER: Final = 0.005
BEATS: Final = 80
SETTLED: Final = 16
TEMPO_BAR_BPM: Final = 0.05
PHASE_BAR_MS: Final = 3.0
TEMPOS: Final = (61.3, 90.0, 120.0, 128.0, 174.7)

Rows = npt.NDArray[np.float64]

KINDS: Final[dict[str, Callable[[np.random.Generator, Rows], Rows]]] = {
    "0 to 5 ms late": lambda rng, sent: sent + rng.uniform(0.0, JITTER, len(sent)),
    "5 ms early to 5 ms late": lambda rng, sent: sent + JITTER + rng.uniform(-JITTER, JITTER, len(sent)),
    "blocks of 5 ms": lambda rng, sent: np.ceil(sent / JITTER) * JITTER,
    "standard deviation 5 ms": lambda rng, sent: sent + np.abs(rng.normal(0.0, JITTER / 0.6028, len(sent))),
}
"""How late pulses come; the deviation of half a normal distribution is 0.6028 of the whole one's."""
HARDER: Final = "standard deviation 5 ms"
"""More than is asked for."""


def rows(full: bool) -> list[Row]:
    """The worst of all tempos, for each kind of jitter."""
    found = []
    for name, delayed in KINDS.items():
        errors = np.array([_run(bpm, delayed, seed) for bpm in TEMPOS for seed in range(4 if full else 1)])
        tempo, p95, most = errors.max(axis=0)
        bar = None if name == HARDER else TEMPO_BAR_BPM
        found += [
            Row(f"MIDI clock, {name}: tempo that is shown, worst from the 16th beat on", float(tempo), "bpm", bar),
            Row(
                f"MIDI clock, {name}: phase that is danced, p95",
                float(p95),
                "ms",
                PHASE_BAR_MS,
                peers={"worst": float(most)},
            ),
        ]
    return found


def _run(bpm: float, delayed: Callable[[np.random.Generator, Rows], Rows], seed: int) -> tuple[float, float, float]:
    """(worst error of the tempo [bpm], p95 and worst of the phase [ms]) of one stream."""
    rng = np.random.default_rng(seed)
    period = 60.0 / (bpm * PULSES)
    sent: Rows = 1.0 + period * np.arange(BEATS * PULSES, dtype=np.float64)
    arrived = np.maximum.accumulate(delayed(rng, sent))
    inbox: EventQueue[ControlEvent] = EventQueue()
    listens, tokens = MidiEventDecoder(inbox), MidiTokenizer()
    follower = TimelineFollower()
    begin = sent[0] + SETTLED * 60.0 / bpm
    at, tempo, offsets = 0, 0.0, []
    for tick in range(1, int(sent[-1] / TICK)):
        now = tick * TICK
        while at < len(arrived) and arrived[at] <= now:
            data = b"\xfa\xf8\x90\x3c" if at == 0 else b"\x3c\xf8\x40"  # a note whose pulse lies between its bytes
            for message in tokens.feed(data):
                listens.decode(message, float(arrived[at]))
            at += 1
        listens.advance(now)
        for event in inbox.drain():
            if isinstance(event, BeatHeard | SourceChanged):
                apply_clock_event(follower, event)
        timeline = follower.advance(now)
        if now < begin:
            continue
        tempo = max(tempo, abs(follower.tempo - bpm))
        offsets.append((timeline.phase_at(now) - (now - sent[0]) / 60.0 * bpm + 2.0) % 4.0 - 2.0)
    late = np.array(offsets) * 60e3 / bpm
    error = np.abs(late - late.mean())
    return tempo, float(np.percentile(error, 95)), float(error.max())
