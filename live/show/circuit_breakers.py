"""Breakers: which stages of a tick are in service (circuit breakers, after Nygard, *Release It!*, 2007).

A tick is a row of stages. Where one ends in an error again and again, however the events before it are left out, its
breaker is tripped: the show goes on without it until a person resets it. Each stage has something simpler to do then
(`Show.tick` says what), and nothing at all if that fails, too.
"""

from enum import IntEnum
from typing import Final

from live.control.events.events import EVENT_TYPES


class Stage(IntEnum):
    """What a tick consists of. The numbers are what another process reads, see `Breakers.publish`."""

    OUTSIDE = 0
    """No tick runs."""
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
    """The tick as a whole: tripped last, when nothing else has helped. The show stands still, its clock runs."""
    DRAWING = 32
    """No tick runs, but a picture is drawn: what is done about that is the supervisor's business."""


WORDS: Final = {
    Stage.CLOCK: "the clock runs on at its tempo and follows nothing",
    Stage.MEASURE: "measures are as long as the last one",
    Stage.SCORE: "the score calls nothing",
    Stage.DESK: "fades, cues and moving cameras stand still",
    Stage.AUDIENCE: "the audience moves nothing",
    Stage.EDITS: "edits of patch and steps wait",
    Stage.SELECTION: "steps are the nearest that follow, whatever is wanted",
    Stage.INTERRUPTS: "nobody leaves her step within a measure",
    Stage.STEERING: "the group stays where it is",
    Stage.CORRECTION: "steps are danced as they are, and not made to reach anything",
    Stage.DANCERS: "feet are held no more",
    Stage.CAPTURE: "captured performers are not followed",
    Stage.PARTNERS: "partners neither answer nor hold hands",
    Stage.VARIATION: "all dance a step alike",
    Stage.REACTIONS: "nothing reacts to the music",
    Stage.LIGHT: "the blackout does not fade",
    Stage.TICK: "the dance stands still",
}
"""What a person sees while a stage is out of service."""

CALL: Final = "call "
"""Before the kind of an event that the score, a cue or a reaction gives: each kind has a breaker of its own."""
PASS: Final = "pass "
"""Before the name of a pass of the picture, which breaks by itself (`live/render/pass_faults.py`)."""
FIRST_CALL: Final = 64
KINDS: Final = tuple(sorted(EVENT_TYPES))
NAMES: Final = {stage.name.lower(): int(stage) for stage in WORDS} | {
    CALL + kind: FIRST_CALL + index for index, kind in enumerate(KINDS)
}
"""Every breaker by its name."""
_NUMBERS: Final = {number: name for name, number in NAMES.items()}
_CALLS: Final = {kind: FIRST_CALL + index for index, kind in enumerate(KINDS)}
SIMPLER: Final = 1
NOTHING: Final = 2


def name_of(number: int) -> str:
    """The name of a breaker by the number that was published; empty outside of a tick."""
    return _NUMBERS.get(number, "")


def escalation(stage: int) -> tuple[str, ...]:
    """The breakers that help where `stage` ends in an error, one after the other: its own, and that of all."""
    name = name_of(stage)
    own = () if not name else (name,) if stage >= FIRST_CALL else (name, name)
    return (*own, Stage.TICK.name.lower())


class Breakers:
    """The breakers of one show: part of its state, changed by events alone. Thread: the show's."""

    def __init__(self) -> None:
        self.why: dict[str, str] = {}
        """Why each breaker that is tripped was, by its name."""
        self.running = int(Stage.OUTSIDE)
        """The stage that runs now, or ran when a tick ended in an error."""
        self._level: dict[int, int] = {}
        self._page: memoryview | None = None

    def publish(self, page: memoryview) -> None:
        """Write the number of the stage that runs into `page`, one word of 64 bits that another process reads."""
        self._page = page

    def level(self, stage: int) -> int:
        """The stage begins: 0 if it is in service, SIMPLER or NOTHING if it is not."""
        self.running = stage
        if self._page is not None:
            self._page[0] = stage
        return self._level.get(stage, 0) if self._level else 0

    def closed(self, stage: int) -> bool:
        """The same for a stage that has nothing simpler to do: whether it is in service."""
        return not self.level(stage)

    def calls(self, kind: str) -> bool:
        """Something of the show gives an event of this kind: whether it may."""
        return not self.level(_CALLS.get(kind, int(Stage.TICK)))

    def leave(self) -> None:
        """The tick is over."""
        self.level(Stage.OUTSIDE)

    # -- what trips them -----------------------------------------------------------------------------------------

    def tripped(self, stage: int) -> int:
        """How often a stage was tripped: 0 if it is in service."""
        return self._level.get(stage, 0)

    def trip(self, name: str, why: str) -> None:
        """Put a stage out of service; one that is out already does nothing at all from now on. ValueError for a name
        that is none."""
        stage = _number(name)
        self._level[stage] = min(self._level.get(stage, 0) + 1, NOTHING)
        self.why[name] = why

    def reset(self, name: str) -> None:
        """Put a stage into service again; empty: all. ValueError for a name that is none."""
        if not name:
            self._level.clear()
            self.why.clear()
            return
        if name.startswith(PASS):  # a pass of the picture: whoever draws it hears of it as well
            return
        self._level.pop(_number(name), None)
        self.why.pop(name, None)

    def words(self) -> tuple[str, ...]:
        """What is out of service, for the operator."""
        return tuple(out_of_service(name, why) for name, why in self.why.items())


def _number(name: str) -> int:
    if name not in NAMES:
        raise ValueError(f"there is no breaker {name!r}; there are {', '.join(stage.name.lower() for stage in WORDS)}")
    return NAMES[name]


def out_of_service(name: str, why: str) -> str:
    """A breaker that is tripped, in a person's words."""
    number = NAMES.get(name, 0)
    effect = WORDS[Stage(number)] if number in WORDS else f"no {name.removeprefix(CALL)} is given by the show itself"
    return f'{name} is out of service: {effect} ({why}); /dance/breaker/reset "{name}" puts it back'
