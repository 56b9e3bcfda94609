"""Lint for scores: unreachable sections, conflicting cues, formations that are too dense.

The results are warnings, not errors: the show starts anyway.
"""

from collections.abc import Iterator
from typing import Final

from live.agents.formations.distances import closest_distance
from live.base.errors import PersonError
from live.graph.search.sequence import parse_sequence
from live.show.group.group_motion import AGENT_RADIUS
from live.show.patch.patch import Patch
from live.show.patch.section_cues import CueSection
from live.show.patch_checks.cue_cycle_check import cue_loops
from live.show.score.playhead import END
from live.show.score.score import section_timings
from live.show.show import Show

SECTION_ADDRESS: Final = "/dance/section"


def section_warnings(patch: Patch) -> list[str]:
    """Return a warning for each section that neither the order of sections nor a cue or call of the patch reaches."""
    if not patch.section:
        return []
    stretches = section_timings(patch)
    names = {section.name.casefold().strip(): index for index, section in enumerate(patch.section)}
    reached, coming = set(), [0, *_jump_targets(patch, names)]
    while coming:
        index = coming.pop()
        if index in reached:
            continue
        reached.add(index)
        if stretches[index].next_section != END:
            coming.append(stretches[index].next_section)
    return [
        f"section {section.name!r} is never reached: only {SECTION_ADDRESS} by hand leads there"
        for index, section in enumerate(patch.section)
        if index not in reached
    ]


def sequence_warnings(show: Show) -> list[str]:
    """Return a warning for each sequence that ends before all of its steps have been danced."""
    library, notes = show.graph.library, []
    for section in show.patch.sequence:
        if section.measures is None or section.choose == "random":
            continue
        last = 0
        for wanted in parse_sequence(", ".join(section.steps), library):
            last += wanted.measures
            if last > section.measures:
                step = "*" if wanted.step is None else library.steps[wanted.step]
                notes.append(
                    f"sequence of {section.group!r} in measure {section.measure}: its {section.measures} measures are "
                    f"over before {step!r} is danced"
                )
                break
    return notes


def _jump_targets(patch: Patch, names: dict[str, int]) -> list[int]:
    """Return the sections that cues and calls of the patch lead to."""
    told = [cue.section for cue in patch.cue if cue.section is not None]
    calls = [call for cue in patch.cue for call in cue.calls]
    calls += [(at.call, *at.values) for at in patch.at if at.call is not None]
    calls += [(react.call, *react.values) for react in patch.react if react.call is not None]
    told += [str(call[1]) for call in calls if call[0] == SECTION_ADDRESS and len(call) > 1]
    return [names[name] for word in told if (name := word.casefold().strip()) in names]


def cue_warnings(patch: Patch) -> list[str]:
    """Return warnings for conflicting cues: an automatic cue with a longer count-in, or two fades of one parameter."""
    notes = list(_looping_cues(patch))
    beats = patch.clock.beats_per_measure
    if patch.cue and patch.cue[-1].then == "auto":
        name = patch.cue[-1].name
        notes.append(f'cue {name!r} is the last one, so then = "auto" has no effect: remove it, or add a cue')
    for cue, following in zip(patch.cue, patch.cue[1:], strict=False):
        if cue.then != "auto":
            continue
        after = cue.after or 1
        if following.count_in > after * beats:
            notes.append(
                f"cue {following.name!r} comes automatically {after} measures after {cue.name!r}, but counts in for "
                f"{following.count_in:g} beats: it comes later than that"
            )
        shared = _faded_parameters(patch, cue) & _faded_parameters(patch, following)
        fade = _fade(patch, cue)
        if shared and fade > after:
            notes.append(
                f"cue {cue.name!r} fades for {fade:g} measures, and {following.name!r} comes after {after} with "
                f"{', '.join(sorted(shared))}: the first fade never ends"
            )
    return notes + _scene_conflicts(patch)


def _looping_cues(patch: Patch) -> Iterator[str]:
    """Yield a warning for each cue that calls itself again through other cues."""
    for loop in cue_loops(patch):
        measures = loop.min_beats / patch.clock.beats_per_measure
        yield (
            f"cue {patch.cue[loop.cue].name!r} calls itself again: it comes again every {measures:g} measures or so, "
            "and sets the standby cue, until /dance/back or /dance/panic"
        )


def _fade(patch: Patch, cue: CueSection) -> float:
    """Return the length of a cue's cross-fade [measures]."""
    if cue.measures is not None:
        return float(cue.measures)
    return _scene_fade(patch, cue.scene)


def _scene_fade(patch: Patch, name: str | None) -> float:
    scene = next((s for s in patch.scene if name is not None and _is_same_name(s.name, name)), None)
    return 0.0 if scene is None else float(scene.measures)


def _faded_parameters(patch: Patch, cue: CueSection) -> set[str]:
    return _scene_parameters(patch, cue.scene)


def _scene_parameters(patch: Patch, name: str | None) -> set[str]:
    scene = next((s for s in patch.scene if name is not None and _is_same_name(s.name, name)), None)
    return set() if scene is None else set(scene.set)


def _is_same_name(a: str, b: str) -> bool:
    return a.casefold().strip() == b.casefold().strip()


def _scene_conflicts(patch: Patch) -> list[str]:
    """Return warnings for scenes that are recalled while another one still fades the same parameters."""
    beats = patch.clock.beats_per_measure
    rows = sorted(
        ((at.section or "", float(at.measure - 1) + (at.beat - 1.0) / beats, at.scene) for at in patch.at if at.scene),
        key=lambda row: (row[0], row[1]),
    )
    notes = []
    for number, (section, begin, scene) in enumerate(rows):
        end = begin + _scene_fade(patch, scene)
        for other_section, other_begin, other in rows[number + 1 :]:
            if other_section != section or other_begin > end or (other_begin == end and end > begin):
                break
            shared = _scene_parameters(patch, scene) & _scene_parameters(patch, other)
            if shared and not _is_same_name(scene, other):
                where = f" of {section!r}" if section else ""
                notes.append(
                    f"measure {int(other_begin) + 1}{where}: scene {other!r} comes while {scene!r} still fades "
                    f"{', '.join(sorted(shared))}"
                )
    return notes


def formation_warnings(show: Show) -> list[str]:
    """Return warnings for formations of segments in which dancers are closer than their bodies are wide."""
    notes = []
    for section in show.patch.segment:
        if section.formation is None:
            continue
        who = show.casting.select(section.group, show.state.position) & show.motion.present
        count = int(who.sum())
        if count < 2:
            continue
        try:
            slots = show.motion.evolutions.formation(section.formation, count).slots
        except PersonError as error:
            notes.append(f"{section.formation}: {error}")
            continue
        near = closest_distance(slots)
        if near < 2.0 * AGENT_RADIUS - 1e-6:
            notes.append(
                f"{section.formation} for {count} dancers: the nearest two stand {near:.2f} m apart, bodies need "
                f"{2.0 * AGENT_RADIUS:.2f} m: make it larger, or use fewer dancers"
            )
    return list(dict.fromkeys(notes))
