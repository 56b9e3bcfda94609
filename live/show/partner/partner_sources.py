"""Example motion for the `[[partner]]` tables of a patch: files of recorded pairs, or the show's own steps."""

import hashlib
from pathlib import Path
from typing import Final

from live.base.errors import PersonError, named
from live.graph.step_library import StepLibrary
from live.library.partner_pairs import read_pairs, with_holds
from live.motion.partner.evaluation import Near
from live.motion.partner.partner_synthesis import CONTINUITY, RATE, WALK_CONTINUITY, WALK_RATE
from live.motion.partner.sketched_examples import sketched_pairs, sketched_walks
from live.motion.partner.units import Units, in_beats
from live.motion.partner_live.stage_partner import MADE, WAY_RATE, Lore, frames_of
from live.motion.step_clip import StepClip
from live.show.patch.patch import Patch
from live.show.patch.patch_reader import find_beside
from live.show.patch.score_checks import UNIT
from live.show.patch.section_motion import PartnerSection

SHOWN: Final = 20
WALK: Final = "walk"
"""Step used for a dancer led by a path, where it exists and no other is named."""
FEWEST: Final = 2
"""Minimum number of units, so that there is a choice."""


class AnswerBank:
    """Example motion for each `[[partner]]` of a patch; immutable."""

    def __init__(self, lores: tuple[Lore, ...]) -> None:
        self.lores = lores

    @property
    def labels(self) -> frozenset[str]:
        """Case-folded names of the recordings or steps whose units may be danced."""
        return frozenset(one.name.casefold() for lore in self.lores for one in lore.units.examples)

    def digest(self) -> str:
        """Return a short hash of all motion in it."""
        found = hashlib.blake2b(digest_size=8)
        for lore in self.lores:
            found.update(f"{lore.per_beat} {lore.unit_beats} {lore.stretch:g} {lore.units.count}".encode())
            for one in lore.units.examples:
                found.update(one.name.encode())
                if one.holds:
                    found.update(repr(one.holds).encode())
                for array in (one.cuts, one.control.floor, one.follower.rotation, one.follower.root_position):
                    found.update(array.tobytes())
        return found.hexdigest()


def answer_bank(patch: Patch, path: Path, library: StepLibrary) -> AnswerBank | None:
    """Return the example motion for the partners of a patch, None if it has none; raises PersonError for unusable
    files."""
    if not patch.partner:
        return None
    made: dict[tuple[object, ...], Lore] = {}
    lores = []
    for index, section in enumerate(patch.partner):
        key = section.examples, section.steps, section.unit_beats, section.stretch, section.by_path, section.near
        if key not in made:
            with named(f"partner {section.name!r}", ("partner", index, "examples")):
                made[key] = _lore(section, patch, path, library)
        lores.append(made[key])
    bank = AnswerBank(tuple(lores))
    _check_reactions(patch, bank)
    return bank


def _check_reactions(patch: Patch, bank: AnswerBank) -> None:
    """Raise PersonError for a reaction to a unit that no examples contain."""
    for index, one in enumerate(patch.react):
        name = (one.on or "").casefold()
        if not name.startswith(UNIT):
            continue
        label = name.removeprefix(UNIT)
        if label not in bank.labels and label.rpartition("/")[0] not in bank.labels:
            known = ", ".join(sorted(bank.labels)[:SHOWN])
            raise PersonError(
                f"{one.on!r}: no partner's examples have a {label!r}", f"there are: {known}", ("react", index, "on")
            )


def _lore(section: PartnerSection, patch: Patch, path: Path, library: StepLibrary) -> Lore:
    tempo = patch.clock.bpm
    units, unit_beats = _units(section, path, library)
    if units.count < FEWEST:
        raise PersonError(f"{units.count} unit; there is nothing to choose from with fewer than two", "more examples")
    rate, k = (WALK_RATE, WALK_CONTINUITY) if section.by_path else (RATE, CONTINUITY)
    per_beat = frames_of(tempo, WAY_RATE) if section.by_path else frames_of(tempo)
    timed = in_beats(units, unit_beats=unit_beats, samples=frames_of(tempo, MADE), period=60.0 / tempo)
    k *= per_beat * tempo / 60.0 / rate
    return Lore(timed, unit_beats=unit_beats, per_beat=per_beat, tempo=tempo, stretch=section.stretch, k=k)


def _steps(section: PartnerSection, library: StepLibrary) -> list[StepClip]:
    """Return the show's steps from which examples are made."""
    names = {name.casefold() for name in section.steps} or ({WALK} if section.by_path else set())
    known = {clip.step.casefold() for clip in library.clips}
    for name in section.steps:
        if name.casefold() not in known:
            raise PersonError(f"steps: no step is called {name!r}", f"there are: {', '.join(sorted(known))}")
    clips = [clip for clip in library.clips if clip.step.casefold() in names & known] if names & known else []
    return clips or list(library.clips)


def _units(section: PartnerSection, path: Path, library: StepLibrary) -> tuple[Units, int]:
    """Return the units, and their length in beats."""
    if section.examples is None:
        try:
            clips = _steps(section, library)
            if not section.by_path:
                return sketched_pairs(clips, unit_beats=section.unit_beats, near=_near(section)), section.unit_beats
            return sketched_walks(clips, unit_beats=section.unit_beats), section.unit_beats
        except ValueError as error:
            raise PersonError(str(error), "fewer unit_beats, or other steps") from None
    found = find_beside(section.examples, path)
    if found is None:
        raise PersonError(f"there is no file {section.examples[:200]!r}", "put the file in the patch's folder")
    known = read_pairs(found)
    walks = known.leaders[0] is None
    if walks != section.by_path:
        kind, remedy = ("walks", 'leader = "path"') if walks else ("pairs with a leader", "leader")
        raise PersonError(f"{found} holds {kind}", remedy)
    near = _near(section)
    return known.units if near is None else with_holds(known, near), 1 if walks else known.wanted.unit_beats


def _near(section: PartnerSection) -> Near | None:
    """Return the criterion for a hold where none is written down, None for none."""
    return None if section.near is None else Near(*section.near)
