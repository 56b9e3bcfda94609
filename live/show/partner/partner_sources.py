"""Example motion for the `[[partner]]` tables of a patch: files of recorded pairs, or the show's own steps."""

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Final

from live.base.errors import PersonError, error_context
from live.graph.step_library import StepLibrary
from live.library.partner_pairs import add_found_holds, pairs_text, read_pairs
from live.motion.partner.evaluation import HoldCriterion
from live.motion.partner.sketched_examples import sketched_pairs, sketched_walks
from live.motion.partner.units import Units, retime_to_beats
from live.motion.partner_live.stage_partner import PATH_RATE, RECORDING_RATE, PartnerExamples, frames_per_beat
from live.motion.step_clip import StepClip
from live.show.partner.example_bank import ExampleBank, check_styles
from live.show.partner.partner_pairs import partner_settings
from live.show.patch.patch import Patch
from live.show.patch.patch_search_path import find_resource
from live.show.patch.section_motion import PartnerSection
from live.show.patch.section_music import UNIT_PREFIX

MAX_LISTED: Final = 20
DEFAULT_WALK_STEP: Final = "walk"
"""Step used for a dancer led by a path, where it exists and no other is named."""
MIN_UNITS: Final = 2
"""Minimum number of units, so that there is a choice."""


def load_example_bank(
    patch: Patch,
    path: Path,
    library: StepLibrary,
    *,
    texts: Mapping[str, str] = MappingProxyType({}),
    former: ExampleBank | None = None,
) -> ExampleBank | None:
    """Return the example motion for the partners of a patch, None if it has none; raises PersonError for unusable
    files.

    `texts`: what files of pairs held, by their names in the patch, if not what they hold now. `former`: a bank of the
    same partners; what it has learnt from files with the same text is used again, and whether the patch fits the new
    one is not checked. Slow: it learns.
    """
    if not patch.partner:
        return None
    read = dict(texts)
    made: dict[tuple[object, ...], PartnerExamples] = {}
    lores = []
    for index, section in enumerate(patch.partner):
        key = (
            section.examples,
            section.steps,
            section.unit_beats,
            section.stretch,
            section.led_by_path,
            section.hold_limits,
        )
        if key not in made:
            with error_context(f"partner {section.name!r}", ("partner", index, "examples")):
                name = section.examples
                if name is not None and name not in read:
                    read[name] = pairs_text(pairs_path(name, path))
                same = former is not None and (name is None or former.texts.get(name) == read[name])
                made[key] = (
                    former.example_sets[index]
                    if former is not None and same
                    else _load_examples(section, patch, path, library, None if name is None else read[name])
                )
        lores.append(made[key])
    bank = ExampleBank(tuple(lores), {name: text for name, text in read.items() if name in _named(patch)})
    if former is None:
        check_styles(partner_settings(patch), bank)
        check_reactions(patch, bank)
    return bank


def check_reactions(patch: Patch, bank: ExampleBank) -> None:
    """Raise PersonError for a reaction to a unit that no examples contain."""
    for index, one in enumerate(patch.react):
        name = (one.on or "").casefold()
        if not name.startswith(UNIT_PREFIX):
            continue
        label = name.removeprefix(UNIT_PREFIX)
        if label not in bank.labels and label.rpartition("/")[0] not in bank.labels:
            known = ", ".join(sorted(bank.labels)[:MAX_LISTED])
            raise PersonError(
                f"{one.on!r}: no partner's examples have a {label!r}", f"there are: {known}", ("react", index, "on")
            )


def pairs_path(name: str, path: Path) -> Path:
    """Return the file of pairs that is called so in the patch at `path`; PersonError if there is none."""
    found = find_resource(name, path)
    if found is None:
        raise PersonError(f"there is no file {name[:200]!r}", "put the file in the patch's folder")
    return found


def _named(patch: Patch) -> set[str]:
    """Return the names of the files of pairs of a patch."""
    return {section.examples for section in patch.partner if section.examples is not None}


def _load_examples(
    section: PartnerSection, patch: Patch, path: Path, library: StepLibrary, text: str | None
) -> PartnerExamples:
    tempo = patch.clock.bpm
    units, unit_beats, styles = _units(section, path, library, text)
    if units.count < MIN_UNITS:
        raise PersonError(f"{units.count} unit; there is nothing to choose from with fewer than two", "more examples")
    per_beat = frames_per_beat(tempo, PATH_RATE) if section.led_by_path else frames_per_beat(tempo)
    timed = retime_to_beats(
        units, unit_beats=unit_beats, samples=frames_per_beat(tempo, RECORDING_RATE), period=60.0 / tempo
    )
    try:
        return PartnerExamples(
            timed, unit_beats=unit_beats, per_beat=per_beat, tempo=tempo, stretch=section.stretch, styles=styles
        )
    except ValueError as error:
        raise PersonError(str(error), "more examples of it") from None


def _steps(section: PartnerSection, library: StepLibrary) -> list[StepClip]:
    """Return the show's steps from which examples are made."""
    names = {name.casefold() for name in section.steps} or ({DEFAULT_WALK_STEP} if section.led_by_path else set())
    known = {clip.step.casefold() for clip in library.clips}
    for name in section.steps:
        if name.casefold() not in known:
            raise PersonError(f"steps: no step is called {name!r}", f"there are: {', '.join(sorted(known))}")
    clips = [clip for clip in library.joined_clips if clip.step.casefold() in names & known]
    return clips or list(library.joined_clips)


def _units(
    section: PartnerSection, path: Path, library: StepLibrary, text: str | None
) -> tuple[Units, int, tuple[str, ...]]:
    """Return the units, their length in beats, and the style of each recording, () if there are none.

    `text`: what the file of pairs holds.
    """
    if section.examples is None:
        try:
            clips = _steps(section, library)
            if not section.led_by_path:
                return (
                    sketched_pairs(clips, unit_beats=section.unit_beats, hold_criterion=_hold_criterion(section)),
                    section.unit_beats,
                    (),
                )
            return sketched_walks(clips, unit_beats=section.unit_beats), section.unit_beats, ()
        except ValueError as error:
            raise PersonError(str(error), "fewer unit_beats, or other steps") from None
    found = pairs_path(section.examples, path)
    known = read_pairs(found, text=text)
    walks = known.leaders[0] is None
    if walks != section.led_by_path:
        kind, remedy = ("walks", 'leader = "path"') if walks else ("pairs with a leader", "leader")
        raise PersonError(f"{found} holds {kind}", remedy)
    near = _hold_criterion(section)
    styles = tuple(pair.style or "" for pair in known.pairs_file.pair)
    units = known.units if near is None else add_found_holds(known, near)
    return units, 1 if walks else known.pairs_file.unit_beats, styles


def _hold_criterion(section: PartnerSection) -> HoldCriterion | None:
    """Return the criterion for a hold where none is written down, None for none."""
    return None if section.hold_limits is None else HoldCriterion(*section.hold_limits)
