"""Controls of the score's position, practice, improvisation, and musical signals."""

from typing import Final

from live.control.events import events
from live.control.events.events import ControlEvent
from live.control.registry.control import GROUP, Argument, Control

MAX_MEASURES: Final = 100_000


def _when(default: str) -> Argument:
    return Argument("when", "name", "`measure`: at the next measure line; `section`: at the end of its current pass",
                    default=default)  # fmt: skip


def _jump(*, time: float, source: str, section: str, when: str, measure: float) -> ControlEvent:
    return events.JumpTo(time=time, source=source, section=section, when=when, measure=round(measure))


def _practise(*, time: float, source: str, first: float, last: float) -> ControlEvent:
    return events.Practice(time=time, source=source, first=round(first), last=round(last))


SCORE_CONTROLS: Final = (
    Control(
        "/dance/section", _jump,
        (
            Argument("section", "name", "the section's name in the patch"),
            _when("measure"),
            Argument("measure", "float", "the measure of the section to continue with", "", 1, MAX_MEASURES, 1.0),
        ),
        "The score goes to a section. Steps already decided, up to a beat before the line, are danced first.",
        "operator",
    ),
    Control(
        "/dance/advance", events.Advance, (_when("section"),),
        "The score leaves a waiting or repeating section for the following one.", "operator",
    ),
    Control(
        "/dance/hold/score", events.HoldScore,
        (Argument("on", "bool", "1: the score stays in its measure, 0: it continues"),),
        "Holds or continues the score; the dance continues with its current steps.", "operator", "continuous", 1,
        (False,),
    ),
    Control(
        "/dance/practice", _practise,
        (
            Argument("first", "float", "the first measure of the written score; 0: end of practice", "", 0,
                     MAX_MEASURES, 0.0),
            Argument("last", "float", "the last measure", "", 0, MAX_MEASURES, 0.0),
        ),
        "Repeats measures of the score, counted with each section written once, in order.", "operator",
    ),
    Control(
        "/dance/improvise", events.Improvise,
        (Argument("on", "bool", "1: dancers choose their steps, 0: they dance the score"), GROUP),
        "Groups improvise from their next free measure on, or return to the score.", "musician",
    ),
    Control(
        "/dance/signal", events.Signal,
        (
            Argument("name", "name", "the signal's name"),
            Argument("value", "float", "its strength", "", 0, 1, 1.0),
        ),
        "A musical signal; triggers the patch's `[[react]]` entries for it.", "musician",
    ),
)  # fmt: skip
"""The controls of sections, practice and signals."""
