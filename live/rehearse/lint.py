"""Lint for shows: all warnings of `live check`, by kind.

Contains the checks for cameras below the floor, and for segments and elements that last longer than their section.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Final

from live.rehearse.music_lint import music_warnings
from live.rehearse.score_lint import cue_warnings, formation_warnings, section_warnings, sequence_warnings
from live.show.group.dry_run import dry_run_warnings
from live.show.patch.patch import Patch
from live.show.patch_checks.call_response_check import call_response_warnings
from live.show.patch_checks.score_checks import calls_of
from live.show.score.section_span import SectionSpan, span_of
from live.show.show import Show

EYE_ADDRESS: Final = "/dance/camera/eye"


def camera_warnings(patch: Patch) -> list[str]:
    """Return a warning for each camera of the patch, its scenes and its calls that is below the floor."""
    return [
        f"{where}: the camera's eye is {-height:g} m below the floor (y = {height:g}); the floor is at y = 0"
        for where, height in dict(_heights(patch)).items()
        if height < 0.0
    ]


def _heights(patch: Patch) -> Iterator[tuple[str, float]]:
    yield "[camera]", patch.camera.eye[1]
    for view in patch.view:
        yield f"view {view.name!r}", view.eye[1]
    for scene in patch.scene:
        eye = scene.set.get(EYE_ADDRESS)
        if isinstance(eye, tuple):
            yield f"scene {scene.name!r}", float(eye[1])
    for call, values, place in calls_of(patch):
        if call == EYE_ADDRESS and len(values) > 1 and isinstance(values[1], int | float):
            yield f"{place[0]} {int(place[1]) + 1}, call {call}", float(values[1])


MAX_WARNINGS: Final = 6
"""Maximum number of warnings of this kind."""


def span_warnings(patch: Patch) -> list[str]:
    """Return warnings for segments and elements that last longer than the rest of their section.

    They continue into the following section. There is no warning for an entry in measures of the whole score if the
    sections that it covers follow one another in the written order.
    """
    notes = [*_overlong_entries(patch, "segment"), *_overlong_entries(patch, "element")]
    more = len(notes) - MAX_WARNINGS
    return notes if more <= 0 else [*notes[:MAX_WARNINGS], f"... and {more} more that are longer than their sections"]


def _overlong_entries(patch: Patch, kind: str) -> Iterator[str]:
    for index, entry in enumerate(getattr(patch, kind)):
        stay = span_of(patch, entry.section, entry.measure, entry.measures)
        if stay.size is None or stay.begin + int(entry.measures) <= stay.size or _is_intended(patch, entry, stay):
            continue
        before = 0 if entry.section is not None else stay.first
        end = f"section {patch.section[stay.section].name!r}" if patch.section else "the score"
        default = "" if "measures" in entry.model_fields_set else " (measures is left out)"
        yield (
            f"{kind} {index + 1} begins in measure {entry.measure:g}"
            + ("" if entry.section is None else f" of {entry.section!r}")
            + f" and lasts {entry.measures:g} measures{default}, but {end} ends with measure {before + stay.size}: "
            f"it continues after that; measures = {stay.size - stay.begin} ends it there"
        )


def _is_intended(patch: Patch, entry: Any, stay: SectionSpan) -> bool:
    """Whether the entry is in measures of the whole score and its sections follow one another as written."""
    if entry.section is not None or not patch.section:
        return False
    last, measure = stay.section, stay.begin + int(entry.measures)
    while last < len(patch.section):
        section = patch.section[last]
        measure -= section.measures
        if measure <= 0:
            return True
        if section.repeat != 1 or section.wait or section.then is not None:
            return False
        last += 1
    return False


@dataclass(frozen=True, slots=True)
class LintSection:
    """The warnings of one kind."""

    name: str
    """The kind, as in the table of `live check`."""
    count_text: str
    """Number of checked things, in words."""
    warnings: list[str]
    """The warnings, one line each; empty if there are none."""
    remedy: str
    """The general remedy."""


def lint_show(show: Show) -> list[LintSection]:
    """Return all warnings for a fresh show. None is an error: the show starts anyway. The show cannot be used again."""
    patch = show.patch
    rows = (
        ("sections", len(patch.section) or 1, section_warnings(patch),
         "then = its name, a cue with section = its name, or leave it out"),
        ("sequences", len(patch.sequence), sequence_warnings(show), "give it more measures, or fewer steps"),
        ("improvisations", len(patch.improvise), call_response_warnings(patch), "see `live docs score`"),
        ("cues", len(patch.cue), cue_warnings(patch),
         "make the fade or the count-in shorter, or place them later"),
        ("music", len(patch.music.line), music_warnings(patch), "see `live docs measures`"),
        ("cameras", 1 + len(patch.view), camera_warnings(patch), "place it higher"),
        ("formations", len(patch.formation), formation_warnings(show), "see `live formation`"),
        ("ends", len(patch.segment) + len(patch.element), span_warnings(patch), "fewer measures, or begin earlier"),
        ("ways", len(patch.segment), dry_run_warnings(show), "see `live docs evolutions`"),
    )  # fmt: skip
    things = {"music": "measure lines", "ways": "segments", "ends": "segments and elements"}
    return [
        LintSection(name, f"{count} {things.get(name, name)}", words, remedy) for name, count, words, remedy in rows
    ]
