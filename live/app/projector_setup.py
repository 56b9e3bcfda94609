"""Setup of projectors during a show: test cards, warp points moved by mouse and keys, and saving to the venue."""

import contextlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final, Protocol

from live.app.output_config import FloorKeeping, OutputKeeping, outputs_of
from live.app.session import Session
from live.base.errors import PersonError
from live.control.events.event import ControlEvent
from live.control.events.events import ShowCard
from live.render.outputs.output import Output, Point
from live.render.outputs.projection import Projection
from live.render.outputs.screen import Screen
from live.render.outputs.test_card import CARDS, JOIN, next_card
from live.render.outputs.warp_editor import FloorEditing
from live.render.window.window_input import KeyPressed, PointerMoved, PointerPressed, PointerReleased, WindowInput

CARD_KEY: Final = "f8"
EDIT_KEY: Final = "f9"
STEP: Final = 1.0
LARGE_STEP: Final = 10.0
"""Pixels by which an arrow key moves a point; the larger one with shift."""
_ARROWS: Final = {"left": (-1.0, 0.0), "right": (1.0, 0.0), "up": (0.0, -1.0), "down": (0.0, 1.0)}
_HELP: Final = (
    "drag a point, or Tab and arrows (shift: 10 px)",
    "M corners or mesh   + - its points   R straighten   U undo   F8 test card",
    "P the real floor's corners   Enter save   F9 done",
)
_FLOOR_HELP: Final = (
    "place this point on that corner of the real floor: drag it, or Tab and arrows (shift: 10 px)",
    "R reset   U undo   Enter save   P back to warping   F9 done",
)


class Floor(Protocol):
    """Source and store of the real floor's corners in the picture."""

    def corners(self) -> tuple[Point, ...]:
        """Return the corners as shares of the whole picture."""

    def keep(self, corners: Sequence[Point]) -> str:
        """Save the corners; return the reason in words if that fails, else an empty text."""


class OutputSetup:
    """Test cards and warp editing by the operator while the show runs. Thread: main thread only."""

    def __init__(
        self,
        projection: Projection,
        keep: Callable[[Output], None],
        refuse: Callable[[str], None],
        ask: Callable[[str, str], None],
        floor: Floor | None = None,
        *,
        joins: bool = False,
    ) -> None:
        """`keep` saves an output; `refuse` receives refusals in words; `floor`: corners of the real floor.

        `ask` receives the output and the test card chosen by a key. It sends an event, so that the show stores the
        card; the event then comes back to `hear`. `joins`: an audience may join, so there is a card with the link.
        """
        self._projection, self._keep, self._refuse, self._ask = projection, keep, refuse, ask
        self._floor = floor
        self._edited: Screen | None = None
        self._joins = joins
        self.kept = ""
        """Result of the last save, in words; empty before the first."""

    # -- events ------------------------------------------------------------------------------------------------

    def hear(self, event: ControlEvent) -> None:
        """Handle the event that shows a test card."""
        if not isinstance(event, ShowCard):
            return
        name, card = event.output.strip().casefold(), event.card.strip().casefold()
        screens = self._named(name)
        known = next((each for each in CARDS if each == card), None)
        if known is None:
            self._refuse(f"{event.source}: there is no test card {event.card!r}; test cards: {', '.join(CARDS)}")
        elif known == JOIN and not self._joins:
            self._refuse(f"{event.source}: no audience can join: start the show with --audience")
        elif not screens:
            names = ", ".join(one.output.name for one in self._projection.screens)
            self._refuse(f"{event.source}: there is no output {event.output!r}; outputs: {names}")
        else:
            for screen in screens:
                screen.card = known

    def recall(self, cards: Mapping[str, str]) -> None:
        """Show the cards that the engine before showed; ignore unknown ones, which that engine has reported."""
        for name, wanted in cards.items():
            card = next((each for each in CARDS if each == wanted), None)
            for screen in self._named(name) if card is not None else ():
                screen.card = card or "off"

    def _named(self, name: str) -> list[Screen]:
        return [one for one in self._projection.screens if name in ("*", one.output.name.casefold())]

    def facts(self) -> list[dict[str, Any]]:
        """Return name, monitor, size and state of every output for the status."""
        return [
            {
                "name": screen.output.name,
                "monitor": screen.window.monitor.name,
                "size": list(screen.window.size),
                "there": screen.window.is_home,
                "card": screen.card,
                "edited": screen is self._edited,
            }
            for screen in self._projection.screens
        ]

    # -- window input ------------------------------------------------------------------------------------------

    def act(self, screen: Screen, value: WindowInput) -> bool:
        """Handle an input at a window; return whether it was for the setup and not for the show."""
        if isinstance(value, KeyPressed):
            taken = self._key(screen, value)
        else:
            taken = self._edited is screen and self._pointer(screen, value)
        if self._edited is not None:
            self._tell(self._edited)
        return taken

    def _key(self, screen: Screen, key: KeyPressed) -> bool:
        if key.name == CARD_KEY:
            for one in [screen] if screen in self._projection.screens else self._projection.screens:
                one.card = next_card(one.card)
                self._ask(one.output.name, one.card)
            return True
        if key.name == EDIT_KEY:
            self._choose(screen)
            return True
        return self._edited is not None and self._edit(self._edited, key)

    def _choose(self, screen: Screen) -> None:
        """Edit the output in whose window the key was pressed; in the operator's window, each output in turn."""
        screens, before = self._projection.screens, self._edited
        self.done()
        if screen in screens:
            after = None if screen is before else screen
        else:
            place = 0 if before is None else screens.index(before) + 1
            after = screens[place] if place < len(screens) else None
        if after is not None:
            self._edited = after
            after.edit(True)

    def done(self) -> None:
        """End editing and save the changes."""
        if self._edited is not None:
            self._save(self._edited)
            self._edited.edit(False)
            self._edited = None

    def _edit(self, screen: Screen, key: KeyPressed) -> bool:
        editing, name = screen.editing, key.name
        assert editing is not None
        if name in _ARROWS:
            (x, y), (width, height) = _ARROWS[name], screen.window.size
            step = LARGE_STEP if key.shift else STEP
            editing.nudge(x * step / width, y * step / height)
        elif name == "tab":
            editing.next(-1 if key.shift else 1)
        elif name == "p" and self._floor is not None:
            self._point_at_floor(screen, self._floor)
            return True
        elif name == "m":
            editing.switch()
        elif name in ("+", "=", "-"):
            editing.refine(-1 if name == "-" else 1)
        elif name == "r":
            editing.straighten()
        elif name == "u":
            editing.undo()
        elif name == "enter":
            self._save(screen)
        elif name == "escape":
            self.done()
            return True
        else:
            return False
        screen.set(editing.output)
        return True

    def _point_at_floor(self, screen: Screen, floor: Floor) -> None:
        """Switch between warping and the real floor's corners; save changes before."""
        self._save(screen)
        if isinstance(screen.editing, FloorEditing):
            screen.edit(True)
        else:
            screen.edit_floor(floor.corners())

    def _pointer(self, screen: Screen, value: WindowInput) -> bool:
        editing, (width, height) = screen.editing, screen.window.size
        assert editing is not None
        match value:
            case PointerPressed():
                editing.take_hold((value.x / width, value.y / height), width / height)
            case PointerMoved():
                editing.pull((value.x / width, value.y / height))
                if editing.output is not screen.output:
                    screen.set(editing.output)
            case PointerReleased():
                editing.let_go()
            case _:
                return False
        return True

    def _save(self, screen: Screen) -> None:
        editing = screen.editing
        if editing is None or not editing.is_changed:
            return
        if isinstance(editing, FloorEditing):
            self.kept = self._floor.keep(editing.corners) if self._floor is not None else ""
            editing.is_changed = bool(self.kept)
        else:
            self._keep(screen.output)
            editing.is_changed = False

    def _tell(self, screen: Screen) -> None:
        """Update the help text over the edited output."""
        editing = screen.editing
        if editing is None:
            return
        if isinstance(editing, FloorEditing):
            words = (f"{screen.output.name}: the {editing.what}", *_FLOOR_HELP, editing.problem, self.kept)
            screen.lines = tuple(word for word in words if word)
            return
        what = "point" if editing.on_mesh else "corner"
        where = f"{screen.output.name}: {what} {editing.chosen + 1} of {len(editing.points)}"
        screen.lines = (where, *_HELP, *(words for words in (editing.problem, self.kept) if words))


def set_up(session: Session, picture: Projection, anew: bool) -> OutputSetup:
    """Make the projector setup of a session; `anew`: read warps again, as they may have changed since opening."""
    if anew:
        with contextlib.suppress(PersonError):
            for screen, output in zip(
                picture.screens, outputs_of(session.options.read_venue(), session.options.venue), strict=False
            ):
                screen.set(replace(screen.output, corners=output.corners, mesh=output.mesh))

    def told(words: str) -> None:
        setup.kept = words

    keeping = OutputKeeping(session.options.venue, told)

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
