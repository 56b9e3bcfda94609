"""Steps of the score: `[[sequence]]`, what a group dances over some measures (T009)."""

from typing import Annotated, Literal

from pydantic import Field

from live.show.patch.score import Measure
from live.show.patch.section_base import Name, Section

Step = Annotated[str, Field(min_length=1, max_length=100)]


class SequenceSection(Section):
    """`[[sequence]]`: steps that a group dances over some measures of the score; then its own steps go on."""

    group: Name = "*"
    """The group; * is all."""
    measure: Measure = 1
    """The measure with which it begins, from 1; of its section, if it belongs to one."""
    section: Name | None = None
    """The section it belongs to, whose first measure is its measure 1; left out: measures of the whole score."""
    measures: Measure | None = None
    """How long it is danced, again and again; left out: once. Its steps must end with it."""
    steps: Annotated[tuple[Step, ...], Field(min_length=1, max_length=10000)]
    """Steps in order, as by `/dance/sequence`: "groove x4", "walk left", "*" for anything; with `choose = "random"` the
    set from which they are drawn."""
    choose: Literal["sequence", "random"] = "sequence"
    """In their order, or drawn by seeded chance, never one three times in a row; every pass of a section draws anew."""
