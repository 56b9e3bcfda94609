"""The projectors of a running show are set up: joined to its keys, its cards, and the venue that keeps them."""

import contextlib
from dataclasses import replace

from live.app.floor_keeping import FloorKeeping
from live.app.output_keeping import OutputKeeping
from live.app.output_places import outputs_of
from live.app.output_setup import OutputSetup
from live.app.session import Session
from live.base.errors import PersonError
from live.control.events.events import ShowCard
from live.render.outputs.projection import Projection


def set_up(session: Session, picture: Projection, anew: bool) -> OutputSetup:
    """How projectors are set up; `anew`: they may be bent otherwise by now than when the windows were opened."""
    if anew:
        with contextlib.suppress(PersonError):
            for screen, output in zip(
                picture.screens, outputs_of(session.wish.read_venue(), session.wish.venue), strict=False
            ):
                screen.set(replace(screen.output, corners=output.corners, mesh=output.mesh))

    def told(words: str) -> None:
        setup.kept = words

    keeping = OutputKeeping(session.wish.venue, told)

    def ask(output: str, card: str) -> None:
        session.inbox.put(ShowCard(time=session.clock.now(), source="key", output=output, card=card))

    floor = FloorKeeping(session, keeping, lambda: picture.size)
    setup = OutputSetup(
        picture, keeping.keep, session.show.refusals.add, ask, floor, joins=session.audience is not None
    )
    setup.recall(session.show.desk.master.cards)
    session.engine.outward.append(setup.hear)
    session.status.more["outputs"] = setup.facts
    session.status.more["flashes_held"] = lambda: picture.flashes.held
    session.status.notes.append(lambda: setup.kept if setup.kept.startswith("NOT") else "")
    return setup
