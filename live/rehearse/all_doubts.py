"""All that is doubtful about the score of a show, by what it is about: what `live check` tells."""

from dataclasses import dataclass

from live.rehearse.camera_doubts import camera_doubts
from live.rehearse.score_lint import cue_doubts, formation_doubts, section_doubts, sequence_doubts
from live.rehearse.span_doubts import span_doubts
from live.show.core import Show
from live.show.group.dry_run import rehearsal_notes
from live.show.patch.call_response_check import answer_doubts


@dataclass(frozen=True, slots=True)
class Doubts:
    """What is doubtful about things of one kind."""

    name: str
    """The kind, as in the table of `live check`."""
    counted: str
    """How many of them there are, in words."""
    words: list[str]
    """A line each; none if all is well."""
    remedy: str
    """What to do, in general."""


def all_doubts(show: Show) -> list[Doubts]:
    """Everything about a fresh show; none of it is an error: it starts with all of them. The show is used up."""
    patch = show.patch
    rows = (
        ("sections", len(patch.section) or 1, section_doubts(patch),
         "then = its name, a cue with section = its name, or leave it out"),
        ("sequences", len(patch.sequence), sequence_doubts(show), "give it more measures, or fewer steps"),
        ("improvisations", len(patch.improvise), answer_doubts(patch), "see docs/score.md"),
        ("cues", len(patch.cue), cue_doubts(patch),
         "make the fade or the count-in shorter, or let them come later"),
        ("cameras", 1 + len(patch.view), camera_doubts(patch), "let it stand higher"),
        ("formations", len(patch.formation), formation_doubts(show), "see `live formation`"),
        ("ends", len(patch.segment) + len(patch.element), span_doubts(patch), "fewer measures, or begin earlier"),
        ("ways", len(patch.segment), rehearsal_notes(show), "see docs/evolutions.md"),
    )  # fmt: skip
    things = {"ways": "segments", "ends": "segments and elements"}
    return [Doubts(name, f"{count} {things.get(name, name)}", words, remedy) for name, count, words, remedy in rows]
