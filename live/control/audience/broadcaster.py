"""Broadcast of rules, beat, tally and stage to all phones. Each message is built once and sent in batches."""

import asyncio
import contextlib
import json
import math
from collections.abc import AsyncIterator
from typing import Final

from live.control.audience.phone_registry import Phone
from live.control.audience.rate_limit import RefusalReason
from live.control.audience.session_state import BeatClock, Rules, SessionState
from live.control.audience.stage_lights import STAGE_EVERY, with_interval
from live.control.audience.websocket_reader import binary_frame

MAX_UNSENT_BYTES: Final = 1 << 14
"""Maximum unsent bytes of a phone; one that is further behind is disconnected and reconnects."""
BATCH_SIZE: Final = 50
"""Phones in a batch; incoming messages are handled between batches."""
BATCH_PAUSE: Final = 0.002
CLOCK_INTERVAL: Final = 4.0
"""Maximum interval between clock messages [s]."""
TOUCHES_EVERY: Final = 0.1
"""Interval of a phone's touch messages [s], up to `FEW_PHONES` phones of all gateways together ..."""
FEW_PHONES: Final = 2000
MANY_PHONES: Final = 100_000
TOUCHES_OF_MANY: Final = 0.5
"""... and with `MANY_PHONES`; in between, and beyond, it grows by a power of their number."""
MAX_TOUCH_INTERVAL: Final = 0.7
"""With still more phones it stays so [s], or voices would fade between two messages."""
MOST_MESSAGES: Final = 20_000.0
"""Messages per second of the phones of one gateway, which asks for fewer if it has many."""
MOST_FRAMES: Final = 10_000.0
"""Frames of the stage per second to all phones together."""
MAX_UNSENT_FRAMES: Final = 1 << 10
"""A phone with more unsent bytes gets no frame of the stage: the next one is newer."""
HEARING_EVERY: Final = 0.2
"""Interval at which phones are told whether they are heard [s], if that changes."""
TALLY_EVERY: Final = 0.5
"""Interval of a vote's tally [s]."""
MIN_INTERVAL: Final = 0.1


class Broadcaster:
    """Broadcaster to all phones. Thread: the gateway's loop."""

    def __init__(self, hall: SessionState) -> None:
        self._hall = hall
        self._state = ""
        self._sent_beat, self._clock_due = BeatClock(tempo=1.0), 0.0
        self._sent_tally: tuple[int, ...] = ()
        self._stage, self._colours = b"", ""
        self._changed, self._hearing_changed, self._stage_changed = asyncio.Event(), asyncio.Event(), asyncio.Event()
        self._changed_hearing: list[tuple[Phone, int]] = []
        self._hearing_due = self._tally_due = 0.0
        self.missed_frames = 0
        """Frames of the stage left out for phones that are behind."""

    def update_rules(self, rules: Rules) -> None:
        """Schedule a broadcast if the rules changed."""
        state = rules_message(rules)
        if state != self._state:
            self._state = state
            self._changed.set()

    def update_beat(self, beat: BeatClock) -> None:
        """Schedule a broadcast if the beat differs from the one sent."""
        if self._sent_beat.differs(beat, self._hall.now()):
            self._clock_due = 0.0
            self._changed.set()

    def update_stage(self, frame: bytes, colours: tuple[str, ...]) -> None:
        """Take the latest frame of the stage (`stage_lights`), and the colours of the groups."""
        said = json.dumps({"g": colours})
        if said != self._colours:
            self._colours = said
            self._changed.set()
        self._stage = frame
        self._stage_changed.set()

    def update(self, now: float) -> None:
        """Look which phones are heard, and at the tally; called once per tick."""
        if now >= self._hearing_due:
            self._hearing_due = now + HEARING_EVERY
            self._changed_hearing += self._hall.changed_hearing(now)
            if self._changed_hearing:
                self._hearing_changed.set()
        if now >= self._tally_due and self._hall.tally != self._sent_tally:
            self._changed.set()

    def current_messages(self) -> list[str]:
        """Return the messages for a phone that has just joined."""
        tally = [self._tally_message()] if self._hall.tally else []
        colours = [self._colours] if self._colours else []
        return [self._state, self._clock_message(), *colours, *tally] if self._state else []

    def touch_interval(self) -> int:
        """Return the interval of touch messages [ms], in steps of 20."""
        here = len(self._hall.phones)
        every = max(touch_seconds(here + self._hall.phones.total_elsewhere), here / MOST_MESSAGES)
        return 20 * round(50.0 * every)

    def stage_interval(self) -> float:
        """Return the interval of frames of the stage [s]; it grows with the number of phones."""
        return max(STAGE_EVERY, len(self._hall.phones) / MOST_FRAMES)

    def _clock_message(self) -> str:
        beat = self._hall.beat
        row = [round(beat.time, 6), round(beat.beat, 6), round(beat.tempo, 4), beat.beats_per_measure, beat.line]
        return json.dumps({"c": row})

    def _tally_message(self) -> str:
        return json.dumps({"n": self._hall.tally})

    def _news(self, now: float) -> list[str]:
        """Return the clock and the tally, each if it is due."""
        words = []
        if now >= self._clock_due:
            self._clock_due, self._sent_beat = now + CLOCK_INTERVAL, self._hall.beat
            words.append(self._clock_message())
        if now >= self._tally_due and self._hall.tally != self._sent_tally:
            self._tally_due, self._sent_tally = now + TALLY_EVERY, self._hall.tally
            if self._sent_tally:
                words.append(self._tally_message())
        return words

    async def run(self) -> None:
        """Send all changes to all phones, forever."""
        state, colours, every = "", "", self.touch_interval()
        while True:
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(self._changed.wait(), CLOCK_INTERVAL)
            self._changed.clear()
            words = self._news(self._hall.now())
            if state != self._state:
                state = self._state
                words.append(state)
            if colours != self._colours:
                colours = self._colours
                words.append(colours)
            if every != self.touch_interval():
                every = self.touch_interval()
                words.append(json.dumps({"e": every}))
            if words:
                async for phone in self._everybody():
                    for each in words:
                        await self.send(phone, each)
            await asyncio.sleep(MIN_INTERVAL)

    async def run_hearing(self) -> None:
        """Tell phones whether they are heard when that changes, forever."""
        while True:
            await self._hearing_changed.wait()
            self._hearing_changed.clear()
            changed, self._changed_hearing = self._changed_hearing, []
            for index, (phone, hearing) in enumerate(changed):
                await self.send(phone, f'{{"h":{hearing}}}')
                if index % BATCH_SIZE == BATCH_SIZE - 1:
                    await asyncio.sleep(BATCH_PAUSE)

    async def run_stage(self) -> None:
        """Send the stage to all phones, forever: the latest frame, and none to a phone that is behind."""
        while True:
            await self._stage_changed.wait()
            self._stage_changed.clear()
            began, interval = self._hall.now(), self.stage_interval()
            frame = binary_frame(with_interval(self._stage, interval))
            async for phone in self._everybody():
                self._put(phone, frame)
            await asyncio.sleep(max(began + interval - self._hall.now(), 0.0))

    async def _everybody(self) -> AsyncIterator[Phone]:
        """Yield all phones, in batches: incoming messages are handled between them."""
        for index, phone in enumerate(list(self._hall.phones.by_number.values())):
            yield phone
            if index % BATCH_SIZE == BATCH_SIZE - 1:
                await asyncio.sleep(BATCH_PAUSE)

    def _put(self, phone: Phone, frame: bytes) -> None:
        """Send a frame of the stage to one phone, unless earlier ones still wait there."""
        transport = phone.transport
        if transport is None or transport.is_closing():
            return
        if transport.get_write_buffer_size() > MAX_UNSENT_FRAMES:
            self.missed_frames += 1
            return
        with contextlib.suppress(ConnectionError, RuntimeError):
            transport.write(frame)

    async def send(self, phone: Phone, words: str) -> None:
        """Send a message to one phone without waiting for it."""
        transport = phone.transport
        if transport is None or transport.is_closing():
            return
        if transport.get_write_buffer_size() > MAX_UNSENT_BYTES:
            self._hall.refused[RefusalReason.SLOW] += 1
            transport.abort()
            return
        with contextlib.suppress(ConnectionError, RuntimeError):
            await phone.ws.send_str(words)


def touch_seconds(phones: int) -> float:
    """Return the interval of touch messages of each of so many phones [s]."""
    exponent = math.log(TOUCHES_OF_MANY / TOUCHES_EVERY) / math.log(MANY_PHONES / FEW_PHONES)
    return min(TOUCHES_EVERY * math.pow(max(phones / FEW_PHONES, 1.0), exponent), MAX_TOUCH_INTERVAL)


def rules_message(rules: Rules) -> str:
    """Return the rules as JSON. Pages show the names of patch and operator as text, never as markup."""
    said = {
        "open": rules.open, "muted": rules.muted, "shake": rules.shake, "regions": rules.regions, "turn": rules.turn,
        "vote": rules.vote, "won": rules.won,
    }  # fmt: skip
    return json.dumps({"s": said}, separators=(",", ":"), ensure_ascii=False)
