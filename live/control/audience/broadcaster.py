"""Teller: tells phones the rules of the moment and where the beat is; one text for all, made once, some at a time."""

import asyncio
import contextlib
import json
from typing import Final

from live.control.audience.phone_registry import Phone
from live.control.audience.rate_limit import Why
from live.control.audience.session_state import Beat, Hall, Rules

BEHIND: Final = 1 << 14
"""Bytes that a phone may not have taken yet: one that is further behind is cut off, and comes again."""
SLICE: Final = 50
"""Phones that are told something at once; then those are heard who speak."""
PAUSE: Final = 0.002
EVERY: Final = 4.0
"""The clock is told so often [s] at least."""
TOUCHES_EVERY: Final = 0.1
"""A phone says where its finger is so often [s], less often the more there are: so many messages a second in all."""
MOST_MESSAGES: Final = 20_000.0
SOONEST: Final = 0.1


class Teller:
    """Thread: the gateway's loop."""

    def __init__(self, hall: Hall) -> None:
        self._hall = hall
        self._state = ""
        self._told = Beat(tempo=1.0)
        self._news, self._lights = asyncio.Event(), asyncio.Event()
        self._turned: list[tuple[Phone, bool]] = []

    def take(self, rules: Rules) -> None:
        """The rules may be others."""
        state = told_of(rules)
        if state != self._state:
            self._state = state
            self._news.set()

    def look(self, beat: Beat) -> None:
        """The beat may be elsewhere than phones believe."""
        if self._told.slipped(beat, self._hall.now()):
            self._news.set()

    def present(self) -> list[str]:
        """What a phone is told that has just come."""
        return [self._state, self._clock()] if self._state else []

    def every(self) -> int:
        """How often a phone says where its finger is [ms], in steps of 20."""
        return 20 * round(50.0 * max(TOUCHES_EVERY, len(self._hall.phones) / MOST_MESSAGES))

    def _clock(self) -> str:
        beat = self._hall.beat
        row = [round(beat.time, 6), round(beat.beat, 6), round(beat.tempo, 4), beat.beats_per_measure, beat.line]
        return json.dumps({"c": row})

    async def run(self) -> None:
        """Tell all phones what has changed, for ever."""
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
        """Lights may have come or gone."""
        self._turned += list(self._hall.together.changed(self._hall.phones.by_number))
        if self._turned:
            self._lights.set()

    async def lights(self) -> None:
        """Tell those whose light has come or gone, for ever."""
        while True:
            await self._lights.wait()
            self._lights.clear()
            turned, self._turned = self._turned, []
            for phone, lit in turned:
                phone.lit = lit
                await self.say(phone, '{"l":1}' if lit else '{"l":0}')

    async def say(self, phone: Phone, words: str) -> None:
        """Tell one phone something, without waiting for it."""
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
    """The rules as JSON. Names come from the patch and the operator; pages show them as text, never as markup."""
    said = {
        "open": rules.open, "muted": rules.muted, "shake": rules.shake, "regions": rules.regions, "turn": rules.turn,
        "vote": rules.vote, "won": rules.won,
    }  # fmt: skip
    return json.dumps({"s": said}, separators=(",", ":"), ensure_ascii=False)
