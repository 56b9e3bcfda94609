"""Broadcast of the current rules and the beat to all phones. Each text is built once and sent in batches."""

import asyncio
import contextlib
import json
from typing import Final

from live.control.audience.phone_registry import Phone
from live.control.audience.rate_limit import Why
from live.control.audience.session_state import Beat, Hall, Rules

BEHIND: Final = 1 << 14
"""Maximum unsent bytes of a phone; one that is further behind is disconnected and reconnects."""
SLICE: Final = 50
"""Phones in a batch; incoming messages are handled between batches."""
PAUSE: Final = 0.002
EVERY: Final = 4.0
"""Maximum interval between clock messages [s]."""
TOUCHES_EVERY: Final = 0.1
"""Interval of a phone's touch messages [s]; it grows with the number of phones, to limit the total message rate."""
MOST_MESSAGES: Final = 20_000.0
SOONEST: Final = 0.1


class Teller:
    """Broadcaster to all phones. Thread: the gateway's loop."""

    def __init__(self, hall: Hall) -> None:
        self._hall = hall
        self._state = ""
        self._told = Beat(tempo=1.0)
        self._news, self._lights = asyncio.Event(), asyncio.Event()
        self._turned: list[tuple[Phone, bool]] = []

    def take(self, rules: Rules) -> None:
        """Schedule a broadcast if the rules changed."""
        state = told_of(rules)
        if state != self._state:
            self._state = state
            self._news.set()

    def look(self, beat: Beat) -> None:
        """Schedule a broadcast if the beat differs from the one sent."""
        if self._told.slipped(beat, self._hall.now()):
            self._news.set()

    def present(self) -> list[str]:
        """Return the messages for a phone that has just joined."""
        return [self._state, self._clock()] if self._state else []

    def every(self) -> int:
        """Return the interval of touch messages [ms], in steps of 20."""
        return 20 * round(50.0 * max(TOUCHES_EVERY, len(self._hall.phones) / MOST_MESSAGES))

    def _clock(self) -> str:
        beat = self._hall.beat
        row = [round(beat.time, 6), round(beat.beat, 6), round(beat.tempo, 4), beat.beats_per_measure, beat.line]
        return json.dumps({"c": row})

    async def run(self) -> None:
        """Send all changes to all phones, forever."""
        state, every = "", self.every()
        while True:
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(self._news.wait(), EVERY)
            self._news.clear()
            words = [self._clock()]
            self._told = self._hall.beat
            if state != self._state:
                state = self._state
                words.append(state)
            if every != self.every():
                every = self.every()
                words.append(json.dumps({"e": every}))
            for index, phone in enumerate(list(self._hall.phones.by_number.values())):
                for each in words:
                    await self.say(phone, each)
                if index % SLICE == SLICE - 1:
                    await asyncio.sleep(PAUSE)
            await asyncio.sleep(SOONEST)

    def look_at_lights(self) -> None:
        """Check for highlights that appeared or ended."""
        self._turned += list(self._hall.together.changed(self._hall.phones.by_number))
        if self._turned:
            self._lights.set()

    async def lights(self) -> None:
        """Inform phones whose highlight appeared or ended, forever."""
        while True:
            await self._lights.wait()
            self._lights.clear()
            turned, self._turned = self._turned, []
            for phone, lit in turned:
                phone.lit = lit
                await self.say(phone, '{"l":1}' if lit else '{"l":0}')

    async def say(self, phone: Phone, words: str) -> None:
        """Send a message to one phone without waiting for it."""
        transport = phone.transport
        if transport is None or transport.is_closing():
            return
        if transport.get_write_buffer_size() > BEHIND:
            self._hall.refused[Why.SLOW] += 1
            transport.abort()
            return
        with contextlib.suppress(ConnectionError, RuntimeError):
            await phone.ws.send_str(words)


def told_of(rules: Rules) -> str:
    """Return the rules as JSON. Pages show the names of patch and operator as text, never as markup."""
    said = {
        "open": rules.open, "muted": rules.muted, "shake": rules.shake, "regions": rules.regions, "turn": rules.turn,
        "vote": rules.vote, "won": rules.won,
    }  # fmt: skip
    return json.dumps({"s": said}, separators=(",", ":"), ensure_ascii=False)
