"""Setup of projectors during a show: test cards, warp points moved by mouse and keys, and saving to the venue."""

import contextlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final, Protocol

from live.app.output_config import FloorCorners, VenueWriter, outputs_of
from live.base.errors import PersonError
from live.control.events.event import ControlEvent
from live.control.events.events import ShowCard, ShowJoinCard
from live.render.outputs.output import Output, Point
from live.render.outputs.projection import Projection
from live.render.outputs.screen import Screen
from live.render.outputs.test_card import CARDS, JOIN_CARD, next_card
from live.render.outputs.warp_editor import FloorEditor
from live.render.window.window_input import KeyPressed, PointerMoved, PointerPressed, PointerReleased, WindowInput

if TYPE_CHECKING:
    from live.app.session import Session

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


class FloorStore(Protocol):
    """Source and store of the real floor's corners in the picture."""

    def corners(self) -> tuple[Point, ...]:
        """Return the corners as shares of the whole picture."""

    def save(self, corners: Sequence[Point]) -> str:
        """Save the corners; return the reason in words if that fails, else an empty text."""


class OutputSetup:
    """Test cards and warp editing by the operator while the show runs. Thread: main thread only."""

    def __init__(
        self,
        projection: Projection,
        save_output: Callable[[Output], None],
        report_refusal: Callable[[str], None],
        request_card: Callable[[str, str], None],
        floor: FloorStore | None = None,
        *,
        has_audience: bool = False,
        elsewhere: Sequence[str] = (),
    ) -> None:
        """`save_output` saves an output; `report_refusal` gets refusals in words; `floor`: corners of the real floor.

        `request_card` receives the output and the test card chosen by a key. It sends an event, so that the show stores
        the card; the event then comes back to `handle`. `has_audience`: an audience may join, so there is a card with
        the link. `elsewhere`: outputs that render nodes draw; they get the event with the show's lines.
        """
        self._projection, self._save_output, self._refuse, self._ask = (
            projection,
            save_output,
            report_refusal,
            request_card,
        )
        self._floor = floor
        self._edited: Screen | None = None
        self._joins = has_audience
        self._elsewhere = [name.casefold() for name in elsewhere]
        self.save_result = ""
        """Result of the last save, in words; empty before the first."""

    # -- events ------------------------------------------------------------------------------------------------

    def handle(self, event: ControlEvent) -> None:
        """Handle the event that shows a test card."""
        if not isinstance(event, ShowCard | ShowJoinCard):
            return
        name, card = event.output.strip().casefold(), event.card.strip().casefold()
        screens = self._named(name)
        known = next((each for each in CARDS if each == card), None)
        if known is None:
            self._refuse(f"{event.source}: there is no test card {event.card!r}; test cards: {', '.join(CARDS)}")
        elif known == JOIN_CARD and not self._joins:
            self._refuse(f"{event.source}: no audience can join: start the show with --audience")
        elif not screens and name not in (*self._elsewhere, "*"):
            names = ", ".join(one.output.name for one in self._projection.screens)
            self._refuse(f"{event.source}: there is no output {event.output!r}; outputs: {names}")
        else:
            for screen in screens:
                screen.card = known

    def restore_cards(self, cards: Mapping[str, str]) -> None:
        """Show the cards that the engine before showed; ignore unknown ones, which that engine has reported."""
        for name, wanted in cards.items():
            card = next((each for each in CARDS if each == wanted), None)
            for screen in self._named(name) if card is not None else ():
                screen.card = card or "off"

    def replace_cards(self, cards: Mapping[str, str]) -> None:
        """Show exactly these cards."""
        for screen in self._projection.screens:
            screen.card = "off"
        self.restore_cards(cards)

    def _named(self, name: str) -> list[Screen]:
        return [one for one in self._projection.screens if name in ("*", one.output.name.casefold())]

    def facts(self) -> list[dict[str, Any]]:
        """Return name, monitor, size and state of every output for the status."""
        return [
            {
                "name": screen.output.name,
                "monitor": screen.window.monitor.name,
                "size": list(screen.window.size),
                "there": screen.window.on_monitor,
                "card": screen.card,
                "edited": screen is self._edited,
            }
            for screen in self._projection.screens
        ]

    # -- window input ------------------------------------------------------------------------------------------

    def handle_input(self, screen: Screen, value: WindowInput) -> bool:
        """Handle an input at a window; return whether it was for the setup and not for the show."""
        if isinstance(value, KeyPressed):
            taken = self._key(screen, value)
        else:
            taken = self._edited is screen and self._pointer(screen, value)
        if self._edited is not None:
            self._update_help(self._edited)
        return taken

    def _key(self, screen: Screen, key: KeyPressed) -> bool:
        if key.name == CARD_KEY:
            for one in [screen] if screen in self._projection.screens else self._projection.screens:
                one.card = next_card(one.card)
                self._ask(one.output.name, one.card)
            return True
        if key.name == EDIT_KEY:
            self._toggle_editing(screen)
            return True
        return self._edited is not None and self._edit(self._edited, key)

    def _toggle_editing(self, screen: Screen) -> None:
        """Edit the output in whose window the key was pressed; in the operator's window, each output in turn."""
        screens, before = self._projection.screens, self._edited
        self.stop_editing()
        if screen in screens:
            after = None if screen is before else screen
        else:
            place = 0 if before is None else screens.index(before) + 1
            after = screens[place] if place < len(screens) else None
        if after is not None:
            self._edited = after
            after.edit(True)

    def stop_editing(self) -> None:
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
            editing.toggle_mesh()
        elif name in ("+", "=", "-"):
            editing.refine(-1 if name == "-" else 1)
        elif name == "r":
            editing.reset()
        elif name == "u":
            editing.undo()
        elif name == "enter":
            self._save(screen)
        elif name == "escape":
            self.stop_editing()
            return True
        else:
            return False
        screen.set(editing.output)
        return True

    def _point_at_floor(self, screen: Screen, floor: FloorStore) -> None:
        """Switch between warping and the real floor's corners; save changes before."""
        self._save(screen)
        if isinstance(screen.editing, FloorEditor):
            screen.edit(True)
        else:
            screen.edit_floor(floor.corners())

    def _pointer(self, screen: Screen, value: WindowInput) -> bool:
        editing, (width, height) = screen.editing, screen.window.size
        assert editing is not None
        match value:
            case PointerPressed():
                editing.grab((value.x / width, value.y / height), width / height)
            case PointerMoved():
                editing.drag((value.x / width, value.y / height))
                if editing.output is not screen.output:
                    screen.set(editing.output)
            case PointerReleased():
                editing.release()
            case _:
                return False
        return True

    def _save(self, screen: Screen) -> None:
        editing = screen.editing
        if editing is None or not editing.is_changed:
            return
        if isinstance(editing, FloorEditor):
            self.save_result = self._floor.save(editing.corners) if self._floor is not None else ""
            editing.is_changed = bool(self.save_result)
        else:
            self._save_output(screen.output)
            editing.is_changed = False

    def _update_help(self, screen: Screen) -> None:
        """Update the help text over the edited output."""
        editing = screen.editing
        if editing is None:
            return
        if isinstance(editing, FloorEditor):
            words = (
                f"{screen.output.name}: the {editing.corner_name}",
                *_FLOOR_HELP,
                editing.problem,
                self.save_result,
            )
            screen.lines = tuple(word for word in words if word)
            return
        what = "point" if editing.on_mesh else "corner"
        where = f"{screen.output.name}: {what} {editing.chosen + 1} of {len(editing.points)}"
        screen.lines = (where, *_HELP, *(words for words in (editing.problem, self.save_result) if words))


def make_output_setup(session: "Session", picture: Projection, reread: bool) -> OutputSetup:
    """Make the projector setup of a session; `reread`: read warps again, as they may have changed since opening."""
    if reread:
        with contextlib.suppress(PersonError):
            for screen, output in zip(
                picture.screens, outputs_of(session.options.read_venue(), session.options.venue), strict=False
            ):
                screen.set(replace(screen.output, corners=output.corners, mesh=output.mesh))

    def told(words: str) -> None:
        setup.save_result = words

    keeping = VenueWriter(session.options.venue, told)

    def ask(output: str, card: str) -> None:
        session.inbox.put(ShowCard(time=session.clock.now(), source="key", output=output, card=card))

    floor = FloorCorners(session, keeping, lambda: picture.size)
    setup = OutputSetup(
        picture, keeping.save_output, session.show.refusals.add, ask, floor, has_audience=session.audience is not None,
        elsewhere=() if session.venue is None else [one.name for one in session.venue.output if one.node],
    )  # fmt: skip
    setup.restore_cards(session.show.desk.master.cards)
    session.engine.event_listeners.append(setup.handle)
    session.status.extra_figures["outputs"] = setup.facts
    session.status.extra_figures["picture"] = picture.describe_part
    session.status.extra_figures["flashes_held"] = lambda: picture.flash_limiter.dimmed_count
    session.status.notices.append(lambda: setup.save_result if setup.save_result.startswith("NOT") else "")
    return setup
