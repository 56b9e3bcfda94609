"""Test card with the audience's join link."""

from live.app.services.audience_service import AudienceService
from live.render.outputs.projection import Projection
from live.render.outputs.test_card import JOIN_CARD, join_card


class JoinCard:
    """Redraws the card with the join link when the link changes, while an output shows it."""

    def __init__(self, audience: AudienceService | None, picture: Projection) -> None:
        self._audience, self._picture = audience, picture
        self._link = ""

    def frame(self) -> None:
        """Update the card, before each frame."""
        audience = self._audience
        if audience is None or audience.link == self._link or not audience.code:
            return
        if any(screen.card == JOIN_CARD for screen in self._picture.all_screens):
            self._link = audience.link
            self._picture.set_join_card(join_card(audience.code, audience.link))
