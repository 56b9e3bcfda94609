"""Loader for shows: reads patch and steps and builds the motion graph, for live, offline and replay.

It also adapts a patch when a folder of recordings replaces its steps (`--steps`).
"""

import contextlib
import gc
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final

from live.base.errors import PersonError, error_context
from live.base.jit import KERNEL_SET
from live.base.stage_snapshot import Scene
from live.control.events.events import ExamplesChanged
from live.graph.build.metric import Metric
from live.graph.motion_graph import MotionGraph, build_graph
from live.graph.search.sequence import parse_sequence
from live.graph.step_library import StepLibrary, build_library
from live.library.capture_material import NO_BEAT_TAG, read_material
from live.motion.cloth.spring_rig import SpringRig
from live.motion.editing.tempo_forms import TempoForms, all_forms, tempo_forms
from live.motion.step_clip import StepClip
from live.motion.texture.live_bank import TextureBank
from live.render.custom_pass import try_passes
from live.show.assembly import assemble
from live.show.dancers.character_casting import (
    bodies_of,
    character_files,
    character_springs,
    check_characters,
    drawable_characters,
)
from live.show.dancers.character_springs import SpringCast
from live.show.partner.example_bank import ExampleBank
from live.show.partner.example_updates import former_texts, later_banks
from live.show.partner.partner_sources import load_example_bank
from live.show.patch.patch import Patch
from live.show.patch.patch_reader import read_sources
from live.show.patch.patch_search_path import PATCHES, find_resource
from live.show.patch.section_motion import parse_entry
from live.show.patch.toml_model import BridgeTables, TomlSources, key_text
from live.show.patch_checks.score_conflicts import check_step_call, step_calls
from live.show.score.step_names import UnknownStep, check_connected
from live.show.selection.graph_update import clip_key, clips_by_key, library_hash
from live.show.selection.show_clips import NO_TEMPO, ShowTempo, read_clips, replace_clips
from live.show.show import Show
from live.show.venue.venue_output import VenueProjector, with_venue_projector
from live.show.view.render_scene import make_scene as make_scene

RECORDING_LIMITS: Final = {"correction_m": 1.2, "turn_deg": 90.0}
"""Limits of `[locomotion]` with recordings, unless the patch sets them."""


def adapt_to_recordings(patch: Patch, clips: list[StepClip]) -> Patch:
    """Return the patch with the most frequent metre of the recordings, blends of one beat, and larger corrections
    unless the patch limits them. Recordings differ more than sketches, and a short blend would move hands faster than
    they move in the clips; they go where they were recorded, so more is left to the footstep plans."""
    metres = [clip.beats_per_measure for clip in clips]
    clock = patch.clock.model_copy(update={"beats_per_measure": max(metres, key=metres.count)})
    given = patch.locomotion.model_fields_set
    limits = {name: value for name, value in RECORDING_LIMITS.items() if name not in given}
    return with_locomotion(patch.model_copy(update={"clock": clock}), transition_beats=1.0, **limits)


def with_connected_steps(patch: Patch, graph: MotionGraph) -> Patch:
    """Return the patch with every group choosing at random from all connected steps (`--steps`); echoes stay echoes.

    So do phrases (`[[sequence]]`) with a missing step. Reactions and MIDI mappings that call one are removed.
    """
    library = graph.library
    names = tuple(f"{name} x1" for step, name in enumerate(library.steps) if len(graph.entries(step)))
    groups = tuple(
        group.model_copy(update={"travel_step": None} | ({} if group.like else {"steps": names, "choose": "random"}))
        for group in patch.group
    )
    react, keys = _unknown_calls(patch, graph)
    kept = tuple(reaction for index, reaction in enumerate(patch.react) if index not in react)
    midi = patch.midi.model_copy(update={"map": tuple(k for i, k in enumerate(patch.midi.map) if i not in keys)})
    phrases = tuple(
        phrase if _is_danced(phrase.steps, graph) else phrase.model_copy(update={"steps": names, "choose": "random"})
        for phrase in patch.sequence
    )
    return patch.model_copy(update={"group": groups, "sequence": phrases, "react": kept, "midi": midi})


def _is_danced(steps: Sequence[str], graph: MotionGraph) -> bool:
    """Whether all steps of a phrase are in the library and connected."""
    try:
        check_connected(graph, parse_sequence(", ".join(steps), graph.library))
    except (PersonError, ValueError):
        return False
    return True


def _unknown_calls(patch: Patch, graph: MotionGraph) -> tuple[set[int], set[int]]:
    """Return the indices of reactions and of `[[midi.map]]` entries that call steps missing in the recordings."""
    react, keys = set(), set()
    for called in step_calls(patch):
        place = called[2]
        try:
            check_step_call(graph, called)
        except PersonError:
            if place[0] == "react":
                react.add(int(place[1]))
            elif place[0] == "midi":
                keys.add(int(place[2]))
    return react, keys


def adapt_edited_patch(patch: Patch, graph: MotionGraph, running: Patch, *, recordings: bool) -> Patch:
    """Return a patch edited during the show, adapted like at the start if `recordings` replaced its steps."""
    if not recordings:
        return patch
    limits, clock = running.locomotion, running.clock.beats_per_measure
    kept = ("threshold_m", "transition_beats", *RECORDING_LIMITS)
    patch = with_locomotion(patch, **{name: getattr(limits, name) for name in kept})
    patch = patch.model_copy(update={"clock": patch.clock.model_copy(update={"beats_per_measure": clock})})
    return with_connected_steps(patch, graph)


def with_locomotion(patch: Patch, **changes: float) -> Patch:
    """Return the patch with some values of `[locomotion]` changed."""
    return patch.model_copy(update={"locomotion": patch.locomotion.model_copy(update=changes)})


RECORDING_THRESHOLDS_M: Final = (0.25, 0.35)
"""Thresholds on the pose distance for transitions between recordings [m]: preferred, and used if the preferred one
leaves a step without transitions."""


@dataclass(frozen=True, slots=True, eq=False)
class LoadedShow:
    """A patch with its motion graph; `recordings`: the folder that replaces the patch's steps, if any."""

    path: Path
    patch: Patch
    graph: MotionGraph
    recordings: Path | None = None
    reserve: Mapping[str, StepClip] = field(default_factory=dict)
    """Clips not in the graph at the start, for events that add them, by `clip_key`."""
    bank: TextureBank | None = None
    """Motion for texturing upper bodies, if the patch names recordings."""
    answers: ExampleBank | None = None
    """Examples for partner responses, if the patch has any."""
    later_answers: Mapping[str, ExampleBank] = field(default_factory=dict)
    """Examples that events of a replay have taken over, by digest."""
    springs: Mapping[str, SpringRig] = field(default_factory=dict)
    """Springs of the patch's characters that can be drawn, by name."""
    sources: TomlSources | None = None
    """File and line of each key of the patch; None if it was not read from files."""
    projector: VenueProjector | None = None
    """The venue's projector, if the patch is adapted to it; see `with_projector`."""
    in_venue: bool = False
    """Whether the patch is adapted to a venue."""
    tables: BridgeTables = ()
    """The tables of bridges that the patch was read with."""
    tempo: ShowTempo = NO_TEMPO
    """What of its tempo was given beside the patch."""
    notes: tuple[str, ...] = ()
    """Recorded steps that are danced at half or double time, or left out, because of the show's tempo; and whether
    characters have more bones that swing than can."""

    def with_projector(self, projector: VenueProjector | None) -> "LoadedShow":
        """Return the show adapted to a venue and its projector, if it has one; PersonError if the projector's picture
        cannot match this stage."""
        return replace(self, patch=with_venue_projector(self.patch, projector), projector=projector, in_venue=True)

    def start(self, *, seed: int | None = None, tempo: float | None = None, begin: bool = True) -> Show:
        """Return a fresh show at time 0; PersonError for a missing step. `begin`: see `assemble`."""
        try:
            return assemble(
                self.patch, self.graph, seed=seed, tempo=tempo, reserve=self.reserve, bank=self.bank,
                answers=self.answers, later_answers=self.later_answers, springs=self.springs, begin=begin,
            )  # fmt: skip
        except UnknownStep as error:
            raise PersonError(f"{self.place_text(error.place)}: {error}") from None
        except PersonError as error:
            raise PersonError(
                f"{self.place_text(error.key_path)}: {error.message}", error.remedy, error.key_path
            ) from None

    def scene(self, *, whole: bool = True) -> Scene:
        """Return the renderer's initial scene; PersonError for a file that cannot be shown. Unless `whole`, a character
        that cannot be drawn is replaced by the default body, and a background that cannot be shown is left out."""
        try:
            found = character_files(self.patch, self.path) if whole else drawable_characters(self.patch, self.path)
            return make_scene(self.patch, self.path, found, whole=whole)
        except PersonError as error:
            raise PersonError(
                f"{self.place_text(error.key_path)}: {error.message}", error.remedy, error.key_path
            ) from None

    def place_text(self, place: tuple[str | int, ...]) -> str:
        """Return file, line (if known) and key of an entry of the patch."""
        if self.sources is None or not place:
            return str(self.path)
        return f"{self.sources.location_text(place)}: {key_text(place)}"

    def read_steps(self) -> TempoForms:
        """Read all clips again, as at a start, in the forms that fit the show's tempo."""
        return tempo_forms(read_clips(self.patch, self.path, self.recordings), self.tempo.span(self.patch))

    def check_takes(self, patch: Patch) -> None:
        """Raise PersonError if a patch chooses takes that are not among its steps."""
        read_clips(patch, self.path, self.recordings)

    @property
    def steps_folder(self) -> Path | None:
        """The folder of this show's own steps; None if it uses the project's."""
        folder = self.recordings or find_resource(self.patch.steps, self.path)
        common = PATCHES / "steps"
        own = folder is not None and folder.is_dir() and not (common.is_dir() and common.samefile(folder))
        return folder if own else None

    @property
    def music_path(self) -> Path | None:
        """The patch's own music file, if it names one; PersonError if it does not exist."""
        name = self.patch.music.file
        if name is None:
            return None
        found = find_resource(name, self.path)
        if found is None:
            raise PersonError(f"{self.path}: the music {name!r} is not there", "correct music.file in the patch")
        return found

    def header(self, show: Show, *, tempo: float | None, music: Path | None = None) -> dict[str, Any]:
        """Return the journal header with all that a replay needs; `music`: the file that is played."""
        return {
            "patch_path": str(self.path.resolve()),
            "patch": self.patch.to_json_values(),
            "recordings": None if self.recordings is None else str(self.recordings.resolve()),
            "seed": show.seed,
            "tempo": tempo,
            "kernels": KERNEL_SET,
            "music": None if music is None else str(music.resolve()),
            "steps_hash": library_hash(self.graph.library),
            "steps": [clip_key(clip) for clip in self.graph.library.clips],
            "texture": None if self.bank is None else self.bank.digest(),
            "partner": None if self.answers is None else self.answers.digest(),
        }


@contextlib.contextmanager
def _gc_disabled() -> Iterator[None]:
    """Disable automatic garbage collection, which takes a third of the load time of a score of 20,000 entries.

    Thread: the main one, before the show runs.
    """
    was = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was:
            gc.enable()


def load_show(
    path: Path,
    *,
    recordings: Path | None = None,
    whole: bool = True,
    tables: BridgeTables = (),
    tempo: ShowTempo = NO_TEMPO,
) -> LoadedShow:
    """Read the patch at `path` with the bridges' `tables`, and its steps or a folder of recordings in their place.

    `tempo`: what of the show's tempo is given beside the patch. Unless `whole`, custom passes and characters are not
    tested: for processes that continue a show in which they were.
    """
    with _gc_disabled():
        patch, sources = read_sources(path, tables)
    if whole:
        try_passes(patch.picture.own_passes)
        with locate_errors(sources):
            check_characters(patch, path)
    try:
        loaded = load_from_patch(patch, path, recordings=recordings, tempo=tempo)
        return replace(loaded, sources=sources, tables=tables)
    except PersonError as error:
        if not error.key_path:
            raise
        with locate_errors(sources):
            raise


@contextlib.contextmanager
def locate_errors(sources: TomlSources) -> Iterator[None]:
    """Prefix every PersonError raised in the block with file, line and keys of its place."""
    try:
        yield
    except PersonError as error:
        where = f"{sources.location_text(error.key_path)}: {key_text(error.key_path)}"
        raise PersonError(f"{where}: {error.message}", error.remedy, error.key_path) from None


def load_from_patch(
    patch: Patch,
    path: Path,
    *,
    recordings: Path | None = None,
    reserved: frozenset[str] = frozenset(),
    names: Sequence[str] = (),
    former: Mapping[str, StepClip] | None = None,
    tempo: ShowTempo = NO_TEMPO,
    changed_pairs: Sequence[ExamplesChanged] = (),
) -> LoadedShow:
    """Load the show of a patch that was read already; file names are resolved relative to `path`.

    Recorded steps get the forms that fit the show's tempo (`motion/editing/tempo_forms.py`). Clips whose `clip_key` is
    in `reserved` are kept in reserve. For a replay: `names` lists the initial clips (later files are ignored), and
    `former` holds the former content of changed files, and `changed_pairs` are the events that changed files of pairs:
    the show begins with what these held before, and has learnt from what they held later.
    """
    read = read_clips(patch, path, recordings)
    formed = tempo_forms(read, tempo.span(patch))
    found = list(all_forms(read)) if names or reserved else formed.clips
    there = clips_by_key(found) | dict(former or {})
    reserve = {key: there[key] for key in sorted(reserved) if key in there}
    clips = formed.clips
    if names:
        clips = replace_clips(found, names, former or {})
    elif reserve:
        clips = [clip for clip in clips if clip_key(clip) not in reserve]
    if not clips:
        raise PersonError(f"{path}: no step can be danced: {'; '.join(formed.refused.values())}")
    if recordings is not None:
        patch = adapt_to_recordings(patch, clips)
    fitting = [clip for clip in clips if clip.beats_per_measure == patch.clock.beats_per_measure]
    if not fitting:
        metres = ", ".join(str(beats) for beats in sorted({clip.beats_per_measure for clip in clips}))
        raise PersonError(
            f"{path}: no step has {patch.clock.beats_per_measure} beats per measure; the steps found have {metres}",
            "change clock.beats_per_measure, or add such steps",
        )
    try:
        library = build_library(fitting, {} if names else formed.refused)
        if recordings is not None:
            patch = _choose_threshold(library, patch)
        graph = _graph_of(library, patch)
    except ValueError as error:
        remedy = "[locomotion] in the patch" if recordings is None else "fps, drop_frames and bpm in the TOML"
        raise PersonError(f"{path}: {error}", f"look at {remedy}") from None
    if recordings is not None:
        patch = with_connected_steps(patch, graph)
    _refuse_other_metres(patch, path, clips)
    bank = load_texture_bank(patch, path)
    answers = load_example_bank(patch, path, library, texts=former_texts(changed_pairs))
    later = {} if answers is None else later_banks(changed_pairs, answers, patch, path, library)
    springs = character_springs(patch, path)
    notes = formed.notes + SpringCast.of(springs, bodies_of(patch), patch.dancer_count).notes()
    return LoadedShow(path, patch, graph, recordings, reserve, bank, answers, later, springs, tempo=tempo, notes=notes)


def _graph_of(library: StepLibrary, patch: Patch) -> MotionGraph:
    limits = patch.locomotion
    window = min(1.0, limits.transition_beats / patch.clock.beats_per_measure)
    metric = Metric.of(limits.weights, limits.emphasis)
    return build_graph(library, window=window, threshold=limits.threshold_m, metric=metric)


def _choose_threshold(library: StepLibrary, patch: Patch) -> Patch:
    """Return the patch with the smaller threshold for recordings if it connects all steps, else with the larger."""
    least, most = (max(patch.locomotion.threshold_m, threshold) for threshold in RECORDING_THRESHOLDS_M)
    for threshold in (least, most):
        patch = with_locomotion(patch, threshold_m=threshold)
        with contextlib.suppress(ValueError):  # raised by the caller if the larger threshold fails, too
            if not _graph_of(library, patch).missing:
                break
    return patch


def _refuse_other_metres(patch: Patch, path: Path, clips: list[StepClip]) -> None:
    """Raise PersonError if a group names a step that exists only in another metre."""
    beats = patch.clock.beats_per_measure
    others = {clip.step.casefold(): clip.beats_per_measure for clip in clips if clip.beats_per_measure != beats}
    for group in patch.group:
        for entry in group.steps:
            name = parse_entry(entry)[0]
            if name.casefold() in others:
                raise PersonError(
                    f"{path}: step {name!r} of group {group.name!r} has {others[name.casefold()]} beats per measure, "
                    f"this show has {beats}"
                )


def load_texture_bank(patch: Patch, path: Path) -> TextureBank | None:
    """Return the patch's texture recordings, cut at their beats; None if it names none.

    Raises PersonError for recordings that are missing, unreadable or without beats, and for a patch that uses texture
    without naming recordings.
    """
    section = patch.texture
    if not section.recordings:
        groups = [index for index, group in enumerate(patch.group) if patch.motion_of(group).texture > 0.0]
        if groups:
            raise PersonError(
                f"{path}: motion.texture is {patch.motion_of(patch.group[groups[0]]).texture:g}, but the patch names "
                "no recordings",
                'add [texture] with recordings = ["mocap"], a folder of motion files',
            )
        return None
    places = []
    with error_context(f"{path}: texture.recordings"):
        for name in section.recordings:
            found = find_resource(name, path)
            if found is None:
                raise PersonError(
                    f"there is no file and no folder {name[:200]!r}", "give its path relative to the patch"
                )
            places.append(found)
        clips = [clip for clip in read_material(places, fps=section.fps).clips if NO_BEAT_TAG not in clip.tags]
        try:
            return TextureBank.of(clips)
        except ValueError as error:
            raise PersonError(
                str(error), "use longer recordings, or set their bpm and first_beat_s in a TOML file next to them"
            ) from None
