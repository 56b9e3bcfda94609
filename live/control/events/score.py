"""Events of the score: jumps, hold, practice, improvisation, and signals that trigger reactions (T016)."""

from dataclasses import dataclass

from live.control.events.event import ControlEvent


@dataclass(frozen=True, slots=True, kw_only=True)
class JumpTo(ControlEvent):
    """The score goes to a section at the next measure line, or at the end of the current section."""

    section: str
    when: str = "measure"
    """`measure` or `section`."""
    measure: int = 1
    """The measure of the section to continue with, from 1."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Advance(ControlEvent):
    """The score leaves a waiting or repeating section: at the end of its pass, or at the next measure line."""

    when: str = "section"
    """`measure` or `section`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class HoldScore(ControlEvent):
    """The score stays in its current measure, or continues; the dance continues with its current steps."""

    on: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Practice(ControlEvent):
    """Repeats measures of the written score; 0 to 0: ends practice."""

    first: int
    """From 1."""
    last: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Improvise(ControlEvent):
    """Groups choose their own steps instead of the score's, or return to the score."""

    on: bool
    group: str = "*"


@dataclass(frozen=True, slots=True, kw_only=True)
class Signal(ControlEvent):
    """A musical signal from the score, the operator or an instrument."""

    name: str
    value: float = 1.0
