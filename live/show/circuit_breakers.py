"""Circuit breakers for the stages of a tick (after Nygard, *Release It!*, 2007).

A tick is a sequence of stages. If a stage fails repeatedly even without the last events, its breaker is tripped and
the show continues without the stage until a person resets it. A tripped stage first uses a simpler fallback (see
`live/show/stages`), and is skipped if that fails, too.
"""

from enum import IntEnum
from typing import Final

from live.control.events.events import EVENT_TYPES


class Stage(IntEnum):
    """The stages of a tick. Another process reads these numbers, see `CircuitBreakers.publish`."""

    OUTSIDE = 0
    """No tick is running."""
    CLOCK = 1
    MEASURE = 2
    SCORE = 3
    DESK = 4
    AUDIENCE = 5
    EDITS = 6
    SELECTION = 7
    INTERRUPTS = 8
    STEERING = 9
    CORRECTION = 10
    DANCERS = 11
    CAPTURE = 12
    PARTNERS = 13
    VARIATION = 14
    REACTIONS = 15
    LIGHT = 16
    TICK = 17
    """The whole tick. Its breaker is tripped last; then the show stands still and only its clock runs."""
    EXPRESSION = 18
    CLOTH = 19
    SPRINGS = 20
    DRAWING = 32
    """A frame is drawn and no tick is running. The supervisor handles failures here."""


EFFECTS: Final = {
    Stage.CLOCK: "the clock runs on at its tempo and follows nothing",
    Stage.MEASURE: "measures are as long as the last one",
    Stage.SCORE: "the score triggers nothing",
    Stage.DESK: "fades, cues, launches and moving cameras stand still",
    Stage.AUDIENCE: "the audience has no effect",
    Stage.EDITS: "edits of patch and steps wait",
    Stage.SELECTION: "dancers take the nearest next step, whatever the score asks for",
    Stage.INTERRUPTS: "no dancer leaves a step within a measure",
    Stage.STEERING: "the group stays where it is",
    Stage.CORRECTION: "steps are danced as recorded, without correction towards their targets",
    Stage.DANCERS: "planted feet are not locked",
    Stage.CAPTURE: "captured performers are not followed",
    Stage.PARTNERS: "partners neither respond nor hold hands",
    Stage.VARIATION: "all dancers dance a step alike",
    Stage.REACTIONS: "nothing reacts to the music",
    Stage.LIGHT: "the blackout does not fade",
    Stage.EXPRESSION: "faces and hands keep still",
    Stage.CLOTH: "skirts, sleeves, ribbons and long hair are fixed to the body",
    Stage.SPRINGS: "hair and skirts of characters do not swing",
    Stage.TICK: "the dance stands still",
}
"""The visible effect while a stage is out of service."""

CALL_PREFIX: Final = "call "
"""Name prefix for events issued by the score, a cue or a reaction; each event type has its own breaker."""
PASS_PREFIX: Final = "pass "
"""Name prefix for render passes, which have breakers of their own (`live/render/pass_faults.py`)."""
FIRST_CALL_NUMBER: Final = 64
KINDS: Final = tuple(sorted(EVENT_TYPES))
NAMES: Final = {stage.name.lower(): int(stage) for stage in EFFECTS} | {
    CALL_PREFIX + kind: FIRST_CALL_NUMBER + index for index, kind in enumerate(KINDS)
}
"""The number of every breaker, by name."""
_NUMBERS: Final = {number: name for name, number in NAMES.items()}
_CALLS: Final = {kind: FIRST_CALL_NUMBER + index for index, kind in enumerate(KINDS)}
FALLBACK: Final = 1
SKIPPED: Final = 2


def breaker_name(number: int) -> str:
    """Return the name of a breaker by its published number; empty outside of a tick."""
    return _NUMBERS.get(number, "")


def escalation(stage: int) -> tuple[str, ...]:
    """Return the breakers to trip, in order, if `stage` fails: its own, then the one of the whole tick."""
    name = breaker_name(stage)
    own = () if not name else (name,) if stage >= FIRST_CALL_NUMBER else (name, name)
    return (*own, Stage.TICK.name.lower())


class CircuitBreakers:
    """The breakers of one show. They are part of its state; only events change them. Thread: the show's."""

    def __init__(self) -> None:
        self.reasons: dict[str, str] = {}
        """Reason of each tripped breaker, by name."""
        self.running = int(Stage.OUTSIDE)
        """The running stage, or the stage in which a tick failed."""
        self._level: dict[int, int] = {}
        self._page: memoryview | None = None

    def publish(self, page: memoryview) -> None:
        """Write the number of the running stage into `page` from now on, a 64-bit word that another process reads."""
        self._page = page

    def enter(self, stage: int) -> int:
        """Begin a stage. Returns 0 if it is in service, else FALLBACK or SKIPPED."""
        self.running = stage
        if self._page is not None:
            self._page[0] = stage
        return self._level.get(stage, 0) if self._level else 0

    def closed(self, stage: int) -> bool:
        """Begin a stage that has no fallback. Returns whether it is in service."""
        return not self.enter(stage)

    def may_issue(self, kind: str) -> bool:
        """Whether the show itself may issue an event of this type."""
        return not self.enter(_CALLS.get(kind, int(Stage.TICK)))

    def leave(self) -> None:
        """End the tick."""
        self.enter(Stage.OUTSIDE)

    # -- tripping and resetting ----------------------------------------------------------------------------------

    def trip_count(self, stage: int) -> int:
        """Return how often a stage was tripped; 0 if it is in service."""
        return self._level.get(stage, 0)

    def trip(self, name: str, why: str) -> None:
        """Take a stage out of service; a stage tripped before loses its fallback, too. ValueError for an unknown
        name."""
        stage = _number(name)
        self._level[stage] = min(self._level.get(stage, 0) + 1, SKIPPED)
        self.reasons[name] = why

    def reset(self, name: str) -> None:
        """Put a stage back into service; an empty name resets all. ValueError for an unknown name."""
        if not name:
            self._level.clear()
            self.reasons.clear()
            return
        if name.startswith(PASS_PREFIX):  # the renderer handles the same event for its passes
            return
        self._level.pop(_number(name), None)
        self.reasons.pop(name, None)

    def status_lines(self) -> tuple[str, ...]:
        """Return a line for the operator about each stage out of service."""
        return tuple(describe_tripped(name, why) for name, why in self.reasons.items())


def _number(name: str) -> int:
    if name not in NAMES:
        raise ValueError(
            f"there is no breaker {name!r}; there are {', '.join(stage.name.lower() for stage in EFFECTS)}"
        )
    return NAMES[name]


def describe_tripped(name: str, why: str) -> str:
    """Return a line for the operator about a tripped breaker."""
    number = NAMES.get(name, 0)
    effect = (
        EFFECTS[Stage(number)] if number in EFFECTS else f"the show itself issues no {name.removeprefix(CALL_PREFIX)}"
    )
    return f'{name} is out of service: {effect} ({why}); /dance/breaker/reset "{name}" puts it back'
