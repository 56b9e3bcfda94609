"""Where the score is and goes, and musical signals."""

from typing import Final

from live.control.events import events
from live.control.events.events import ControlEvent
from live.control.registry.control import GROUP, Argument, Control

MOST_MEASURES: Final = 100_000


def _when(default: str) -> Argument:
    return Argument("when", "name", "`measure`: at the next measure line; `section`: when its pass is over",
                    default=default)  # fmt: skip


def _jump(*, time: float, source: str, section: str, when: str, measure: float) -> ControlEvent:
    return events.JumpTo(time=time, source=source, section=section, when=when, measure=round(measure))


def _practise(*, time: float, source: str, first: float, last: float) -> ControlEvent:
    return events.Practice(time=time, source=source, first=round(first), last=round(last))


SCORE_CONTROLS: Final = (
    Control(
        "/dance/section", _jump,
        (
            Argument("section", "name", "its name in the patch"),
            _when("measure"),
            Argument("measure", "float", "the measure of the section to go on with", "", 1, MOST_MEASURES, 1.0),
        ),
        "The score goes to a section. What is decided already, up to a beat before the line, is danced first.",
        "operator",
    ),
    Control(
        "/dance/advance", events.Advance, (_when("section"),),
        "The score leaves a section that waits or repeats for what follows it.", "operator",
    ),
    Control(
        "/dance/hold/score", events.HoldScore,
        (Argument("on", "bool", "1: the score stays in its measure, 0: it goes on"),),
        "Holds the score, or lets it go on; the dance goes on with what it has.", "operator", "continuous", 1, (False,),
    ),
    Control(
        "/dance/practice", _practise,
        (
            Argument("first", "float", "the first measure of the written score; 0: no more practice", "", 0,
                     MOST_MEASURES, 0.0),
            Argument("last", "float", "the last one", "", 0, MOST_MEASURES, 0.0),
        ),
        "Measures of the score, all its sections written once one after the other, come again and again.", "operator",
    ),
    Control(
        "/dance/improvise", events.Improvise,
        (Argument("on", "bool", "1: dancers choose their steps, 0: they dance what the score has"), GROUP),
        "Groups improvise from their next free measure on, or come back to the score.", "musician",
    ),
    Control(
        "/dance/signal", events.Signal,
        (
            Argument("name", "name", "the signal's name"),
            Argument("value", "float", "how strong it is", "", 0, 1, 1.0),
        ),
        "Something has happened in the music: what the patch has for it in `[[react]]` happens.", "musician",
    ),
)  # fmt: skip
"""Sections, practice and signals."""
