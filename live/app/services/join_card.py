"""JoinCard: the card with the link that an audience joins by, on the outputs that show it."""

from live.app.session import Session
from live.render.outputs.projection import Projection
from live.render.outputs.test_card import JOIN, join_card


class JoinCard:
    """Makes the card that an audience joins by, while somebody shows it, whenever its link is another one."""

    def __init__(self, session: Session, picture: Projection) -> None:
        self._audience, self._picture = session.audience, picture
        self._link = ""

    def frame(self) -> None:
        """Before each frame."""
        audience = self._audience
        if audience is None or audience.link == self._link or not audience.code:
            return
        if any(screen.card == JOIN for screen in self._picture.all):
            self._link = audience.link
            self._picture.take_sheet(join_card(audience.code, audience.link))
