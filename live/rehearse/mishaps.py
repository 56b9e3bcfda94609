"""Mishaps: what each kind of fault does to a show that runs in virtual time."""

from collections.abc import Callable, Iterator
from typing import Any, Final

import numpy as np

from live.control.events.events import BeatHeard, ControlEvent, RestartAudio, SourceChanged
from live.control.osc.osc_decode import OscRejected, decode
from live.rehearse.band import FakeBand
from live.rehearse.edits import Edits
from live.rehearse.faults import Fault
from live.rehearse.players import Call
from live.rehearse.words import HOSTILE

FLOOD: Final = 6000
"""Events of the largest flood: more than the inbox holds."""


class Mishaps:
    """Everything that may go wrong in one soak; `stands_for` and `deaf_until` are what the others have to heed."""

    def __init__(
        self,
        *,
        put: Callable[[ControlEvent], Any],
        call: Callable[[Call], None],
        refuse: Callable[[str], None],
        calls: Iterator[Call],
        edits: Edits,
        band: FakeBand,
        beats_per_measure: int,
        chance: np.random.Generator,
    ) -> None:
        """`put` takes events, `call` what a player sends, `refuse` counts what is none; `calls`: what players do."""
        self._put, self._call, self._refuse, self._calls = put, call, refuse, calls
        self._edits, self._band, self._beats, self._chance = edits, band, beats_per_measure, chance
        self.done: dict[str, int] = {}
        """What has happened, by kind."""
        self.stands_for = 0.0
        """The machine stands still for so long [s] before the next frame; whoever heeds it sets it back."""
        self.deaf_until = 0.0
        """Until then [s of the show] nothing is heard."""

    def do(self, fault: Fault) -> None:
        """Let a fault happen."""
        self.done[fault.kind] = self.done.get(fault.kind, 0) + 1
        FAULTS[fault.kind](self, fault)

    def lose_source(self, fault: Fault) -> None:
        """The sound is gone, for up to a minute."""
        self.deaf_until = fault.time + 2.0 + 60.0 * fault.size
        for time, state in ((fault.time, "lost"), (self.deaf_until, "found")):
            self._put(SourceChanged(time=time, source="audio", state=state))

    def stall(self, fault: Fault) -> None:
        """The machine stands still: for a moment mostly, seldom for half a minute."""
        self.stands_for = 0.3 + 3.0 * fault.size + (30.0 if fault.size > 0.97 else 0.0)

    def flood(self, fault: Fault) -> None:
        """Thousands of messages at once."""
        for number in range(int(FLOOD * fault.size)):
            x = -4.0 + 8.0 * (number % 97) / 97.0
            self._call(Call(fault.time, "/dance/attract", [x, fault.size, 1.0, 1.0], "osc"))

    def crowd_of_calls(self, fault: Fault) -> None:
        """What all players do in five minutes, within a frame."""
        for call, _ in zip(self._calls, range(int(200 * fault.size)), strict=False):
            self._call(Call(fault.time, call.address, call.values, call.source))
        # the calls' own times have gone on: nothing is played until they are reached, as after a rush

    def garbage(self, fault: Fault) -> None:
        """Packets that are none."""
        for _ in range(20):
            packet = self._chance.bytes(int(self._chance.integers(1, 400)))
            try:
                for message in decode(b"/dance/" + packet if fault.size > 0.5 else packet):
                    self._call(Call(fault.time, message.address, list(message.arguments), "osc"))
            except OscRejected:
                self._refuse("garbage")

    def jump_tempo(self, fault: Fault) -> None:
        """Somebody says another tempo, or the music leaps."""
        bpm = 60.0 + 120.0 * fault.size
        if fault.size < 0.5:
            self._call(Call(fault.time, "/dance/clock/tempo", [bpm], "osc"))
        else:
            self._call(Call(fault.time, "/dance/clock/half" if fault.size < 0.75 else "/dance/clock/double", [], "osc"))
        self._band.bpm = bpm

    def impossible(self, fault: Fault) -> None:
        """A source that says what no source can."""
        for value in HOSTILE:
            if isinstance(value, float | int):
                number = float(value)
                self._put(
                    BeatHeard(time=fault.time, source="midi", beat_time=number, period=fault.size, confidence=1.0)
                )
                self._put(
                    BeatHeard(time=fault.time, source="midi", beat_time=fault.time, period=number, confidence=number)
                )

    def other_source(self, fault: Fault) -> None:
        """Another clock speaks for a while, with a grid of its own; and is chosen, or not."""
        period, source = 0.35 + 0.5 * fault.size, "midi"
        self._put(SourceChanged(time=fault.time, source=source, state="started"))
        for beat in range(16):
            time = fault.time + 0.001 * beat
            self._put(
                BeatHeard(
                    time=time,
                    source=source,
                    beat_time=fault.time + beat * period,
                    period=period,
                    confidence=0.9,
                    beat=beat % 4,
                    beats_per_measure=4,
                    measure=beat // 4,
                    jump=beat == 0,
                )
            )
        choice = ("midi", "auto", "internal", "audio")[int(fault.size * 4.0) % 4]
        self._call(Call(fault.time, "/dance/clock/source", [choice], "osc"))

    def restart_device(self, fault: Fault) -> None:
        """Sound is opened again."""
        self._put(RestartAudio(time=fault.time, source="key"))

    def rest(self, fault: Fault) -> None:
        """Everything is set back: what players of an hour have done does not pile up for ever."""
        for address, values in (
            ("/dance/clear", []), ("/dance/blackout", [0]), ("/dance/hold", [0]), ("/dance/hold/score", [0]),
            ("/dance/practice", []), ("/dance/clock/hold", [0]), ("/dance/clock/source", ["auto"]),
            ("/dance/clock/metre", [self._beats]), ("/dance/clock/tempo", [self._band.bpm]),
        ):  # fmt: skip
            self._call(Call(fault.time, address, list(values), "osc"))


FAULTS: Final[dict[str, Callable[[Mishaps, Fault], None]]] = {
    "source lost": Mishaps.lose_source,
    "stall": Mishaps.stall,
    "flood": Mishaps.flood,
    "garbage": Mishaps.garbage,
    "good edit": lambda mishaps, fault: mishaps._edits.good(),
    "bad edit": lambda mishaps, fault: mishaps._edits.bad(),
    "edit back": lambda mishaps, fault: mishaps._edits.back(),
    "tempo jump": Mishaps.jump_tempo,
    "impossible beats": Mishaps.impossible,
    "device again": Mishaps.restart_device,
    "other source": Mishaps.other_source,
    "crowd of calls": Mishaps.crowd_of_calls,
    "rest": Mishaps.rest,
}
"""What each kind of fault does."""
