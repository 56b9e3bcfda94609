"""Commands of the score: jumps, hold, practice, improvisation, and signals that trigger reactions (T016)."""

from dataclasses import dataclass
from typing import Annotated, Final

from live.control.events.event import ControlEvent
from live.control.registry.command import Dancers, command
from live.control.registry.control import Argument

MAX_MEASURES: Final = 100_000
"""Largest measure number that can be called."""
When = Annotated[str, Argument.label("`measure`: at the next measure line; `section`: at the end of its current pass")]


@command("/dance/section", "operator")
class JumpTo(ControlEvent):
    """The score goes to a section. Steps already decided, up to a beat before the line, are danced first."""

    section: Annotated[str, Argument.label("the section's name in the patch", "section")]
    when: When = "measure"
    measure: Annotated[int, Argument.number("the measure of the section to continue with", 1, MAX_MEASURES)] = 1


@command("/dance/advance", "operator")
class Advance(ControlEvent):
    """The score leaves a waiting or repeating section for the following one."""

    when: When = "section"


@command("/dance/hold/score", "operator", value=1, start=(False,))
class HoldScore(ControlEvent):
    """Holds or continues the score; the dance continues with its current steps."""

    on: Annotated[bool, Argument.switch("1: the score stays in its measure, 0: it continues")]


@command("/dance/practice", "operator")
class Practice(ControlEvent):
    """Repeats measures of the score, counted with each section written once, in order."""

    first: Annotated[
        int, Argument.number("the first measure of the written score; 0: end of practice", 0, MAX_MEASURES)
    ] = 0
    last: Annotated[int, Argument.number("the last measure", 0, MAX_MEASURES)] = 0


@command("/dance/improvise", "musician")
class Improvise(ControlEvent):
    """Dancers improvise from their next free measure on, or return to the score."""

    on: Annotated[bool, Argument.switch("1: dancers choose their steps, 0: they dance the score")]
    group: Dancers = "*"


@command("/dance/signal", "musician")
class Signal(ControlEvent):
    """A musical signal; triggers the patch's `[[react]]` entries for it."""

    name: Annotated[str, Argument.label("the signal's name", "signal")]
    value: Annotated[float, Argument.number("its strength", 0, 1)] = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class CurveMoved(ControlEvent):
    """A curve of the score has a value now; it is told four times a beat."""

    name: str
    value: float
    """0 to 1."""
