"""Events about the score: where it goes, what is practised, and signals that trigger anything (T016)."""

from dataclasses import dataclass

from live.control.events.event import ControlEvent


@dataclass(frozen=True, slots=True, kw_only=True)
class JumpTo(ControlEvent):
    """The score goes to a section at the next measure line, or when the present section is over."""

    section: str
    when: str = "measure"
    """`measure` or `section`."""
    measure: int = 1
    """The measure of the section with which it goes on, from 1."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Advance(ControlEvent):
    """The score leaves a section that waits or repeats: when its pass is over, or at the next measure line."""

    when: str = "section"
    """`measure` or `section`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class HoldScore(ControlEvent):
    """The score stays in its present measure, or goes on; the dance goes on with what it has."""

    on: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Practice(ControlEvent):
    """Measures of the written score come again and again; 0 to 0: no more."""

    first: int
    """From 1."""
    last: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Improvise(ControlEvent):
    """Groups choose their steps themselves, whatever the score has; or dance what the score has again."""

    on: bool
    group: str = "*"


@dataclass(frozen=True, slots=True, kw_only=True)
class Signal(ControlEvent):
    """Something has happened in the music, as the score, a hand or an instrument says."""

    name: str
    value: float = 1.0
