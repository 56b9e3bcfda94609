"""Broadcast of the current rules and the beat to all phones. Each text is built once and sent in batches."""

import asyncio
import contextlib
import json
from typing import Final

from live.control.audience.phone_registry import Phone
from live.control.audience.rate_limit import RefusalReason
from live.control.audience.session_state import BeatClock, Rules, SessionState

MAX_UNSENT_BYTES: Final = 1 << 14
"""Maximum unsent bytes of a phone; one that is further behind is disconnected and reconnects."""
BATCH_SIZE: Final = 50
"""Phones in a batch; incoming messages are handled between batches."""
BATCH_PAUSE: Final = 0.002
CLOCK_INTERVAL: Final = 4.0
"""Maximum interval between clock messages [s]."""
TOUCHES_EVERY: Final = 0.1
"""Interval of a phone's touch messages [s]; it grows with the number of phones, to limit the total message rate."""
MOST_MESSAGES: Final = 20_000.0
MIN_INTERVAL: Final = 0.1


class Broadcaster:
    """Broadcaster to all phones. Thread: the gateway's loop."""

    def __init__(self, hall: SessionState) -> None:
        self._hall = hall
        self._state = ""
        self._sent_beat = BeatClock(tempo=1.0)
        self._changed, self._highlights_changed = asyncio.Event(), asyncio.Event()
        self._changed_highlights: list[tuple[Phone, bool]] = []

    def update_rules(self, rules: Rules) -> None:
        """Schedule a broadcast if the rules changed."""
        state = rules_message(rules)
        if state != self._state:
            self._state = state
            self._changed.set()

    def update_beat(self, beat: BeatClock) -> None:
        """Schedule a broadcast if the beat differs from the one sent."""
        if self._sent_beat.differs(beat, self._hall.now()):
            self._changed.set()

    def current_messages(self) -> list[str]:
        """Return the messages for a phone that has just joined."""
        return [self._state, self._clock_message()] if self._state else []

    def touch_interval(self) -> int:
        """Return the interval of touch messages [ms], in steps of 20."""
        return 20 * round(50.0 * max(TOUCHES_EVERY, len(self._hall.phones) / MOST_MESSAGES))

    def _clock_message(self) -> str:
        beat = self._hall.beat
        row = [round(beat.time, 6), round(beat.beat, 6), round(beat.tempo, 4), beat.beats_per_measure, beat.line]
        return json.dumps({"c": row})

    async def run(self) -> None:
        """Send all changes to all phones, forever."""
        state, every = "", self.touch_interval()
        while True:
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(self._changed.wait(), CLOCK_INTERVAL)
            self._changed.clear()
            words = [self._clock_message()]
            self._sent_beat = self._hall.beat
            if state != self._state:
                state = self._state
                words.append(state)
            if every != self.touch_interval():
                every = self.touch_interval()
                words.append(json.dumps({"e": every}))
            for index, phone in enumerate(list(self._hall.phones.by_number.values())):
                for each in words:
                    await self.send(phone, each)
                if index % BATCH_SIZE == BATCH_SIZE - 1:
                    await asyncio.sleep(BATCH_PAUSE)
            await asyncio.sleep(MIN_INTERVAL)

    def update_highlights(self) -> None:
        """Check for highlights that appeared or ended."""
        self._changed_highlights += list(self._hall.aggregator.changed_highlights(self._hall.phones.by_number))
        if self._changed_highlights:
            self._highlights_changed.set()

    async def run_highlights(self) -> None:
        """Inform phones whose highlight appeared or ended, forever."""
        while True:
            await self._highlights_changed.wait()
            self._highlights_changed.clear()
            turned, self._changed_highlights = self._changed_highlights, []
            for phone, lit in turned:
                phone.highlighted = lit
                await self.send(phone, '{"l":1}' if lit else '{"l":0}')

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


def rules_message(rules: Rules) -> str:
    """Return the rules as JSON. Pages show the names of patch and operator as text, never as markup."""
    said = {
        "open": rules.open, "muted": rules.muted, "shake": rules.shake, "regions": rules.regions, "turn": rules.turn,
        "vote": rules.vote, "won": rules.won,
    }  # fmt: skip
    return json.dumps({"s": said}, separators=(",", ":"), ensure_ascii=False)
