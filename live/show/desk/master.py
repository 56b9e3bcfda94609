"""Master: how much of the picture's light there is, whether the picture stands still, and whether it may flash."""

from typing import Final

from live.control.events import events

MASTER_EVENTS: Final = (events.FadePicture, events.FreezePicture, events.AllowFlashes, events.ShowCard)
"""The events that `act` takes."""
QUICKEST: Final = 0.125
"""A fade takes so many beats at least: quick, but no flash."""
EVERYBODY: Final = "*"
MOST_CARDS: Final = 64
"""Outputs whose cards are remembered: names come over the network."""


class Master:
    """The last hand on the picture, over all scenes, cues and looks. Thread: the show's."""

    def __init__(self) -> None:
        self.level = 1.0
        """Share of the light now."""
        self.frozen = False
        """Whether the picture stands still."""
        self.flashes = False
        """Whether the limit on flashes is lifted."""
        self.goal = 1.0
        """Share of the light where the fade ends."""
        self.cards: dict[str, str] = {}
        """Test cards that were asked for, by the output's name in small letters, in turn; `*`: all. Whoever has the
        windows knows which names and cards there are; here they are kept for who goes on with the show."""
        self._from = 1.0
        self._length, self._passed = 1.0, 1.0

    def act(self, event: events.ControlEvent) -> None:
        """Let one of `MASTER_EVENTS` act."""
        match event:
            case events.FadePicture():
                self._from, self.goal = self.level, event.level
                self._length, self._passed = max(event.beats, QUICKEST), 0.0
            case events.FreezePicture():
                self.frozen = event.on
            case events.AllowFlashes():
                self.flashes = event.on
            case events.ShowCard():
                self._show_card(event.output.strip().casefold(), event.card.strip().casefold())

    def _show_card(self, output: str, card: str) -> None:
        if output == EVERYBODY:
            self.cards.clear()
        self.cards.pop(output, None)
        if card != "off" or EVERYBODY in self.cards:
            self.cards[output] = card
        while len(self.cards) > MOST_CARDS:
            self.cards.pop(next(iter(self.cards)))

    def tick(self, beats: float) -> None:
        """So many beats have passed."""
        if self._passed >= self._length:
            return
        self._passed += beats
        share = min(self._passed / self._length, 1.0)
        eased = share * share * (3.0 - 2.0 * share)
        self.level = self.goal if share >= 1.0 else self._from + (self.goal - self._from) * eased

    def words(self) -> tuple[str, ...]:
        """The overlay's lines; none while all is as usual."""
        lines = ["FROZEN: the picture stands still"] if self.frozen else []
        if self.level < 1.0:
            lines.append(f"faded to {self.level:.0%}")
        if self.flashes:
            lines.append("flashes are not limited")
        return tuple(lines)

    def facts(self) -> dict[str, float | bool]:
        """For the status."""
        return {"level": round(self.level, 3), "frozen": self.frozen, "flashes": self.flashes}
