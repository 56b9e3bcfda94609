"""Loading a show: patch, steps and graph, ready to run; the same for live, offline and replay.

Recorded: what a patch becomes when a folder of recordings is danced in the place of its steps.
"""

import contextlib
import gc
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final

from live.base.errors import PersonError
from live.base.stage_snapshot import Scene
from live.graph.build.metric import Metric
from live.graph.motion_graph import MotionGraph, build_graph
from live.graph.step_library import StepLibrary, build_library
from live.library.step_folder import load_folder
from live.motion.step_clip import StepClip
from live.motion.texture.live_bank import TextureBank
from live.render.custom_pass import try_passes
from live.show.dancers.character_casting import check_characters, drawable, files_of
from live.show.dancers.live_texture import bank_of
from live.show.partner.partner_sources import AnswerBank, answer_bank
from live.show.patch.patch import Patch
from live.show.patch.patch_reader import TomlSources, field_words, find_beside, read_sources
from live.show.patch.patch_search_path import PATCHES
from live.show.patch.score_conflicts import refuse_unknown, steps_called
from live.show.patch.section_motion import parse_entry
from live.show.score.step_names import UnknownStep
from live.show.selection.graph_update import clip_key, library_hash
from live.show.show import Show
from live.show.venue.venue_output import VenueProjector, in_hall
from live.show.view.render_scene import scene_of as scene_of


def for_recordings(patch: Patch, clips: list[StepClip]) -> Patch:
    """The patch with the metre that most of the recordings have, and a beat for each blend: they differ more than
    sketches, and hands must not cross faster than they do in the clips."""
    metres = [clip.beats_per_measure for clip in clips]
    clock = patch.clock.model_copy(update={"beats_per_measure": max(metres, key=metres.count)})
    return with_locomotion(patch.model_copy(update={"clock": clock}), transition_beats=1.0)


def with_steps_of(patch: Patch, graph: MotionGraph) -> Patch:
    """The patch with every group drawing from all steps that connect, as `--steps` asks for; echoes go on echoing.

    Reactions and keys of MIDI that call a step which is not among them are left out.
    """
    library = graph.library
    names = tuple(f"{name} x1" for step, name in enumerate(library.steps) if len(graph.entries(step)))
    groups = tuple(
        group.model_copy(update={"travel_step": None} | ({} if group.like else {"steps": names, "choose": "random"}))
        for group in patch.group
    )
    react, keys = _unknown(patch, graph)
    kept = tuple(reaction for index, reaction in enumerate(patch.react) if index not in react)
    midi = patch.midi.model_copy(update={"map": tuple(k for i, k in enumerate(patch.midi.map) if i not in keys)})
    return patch.model_copy(update={"group": groups, "react": kept, "midi": midi})


def _unknown(patch: Patch, graph: MotionGraph) -> tuple[set[int], set[int]]:
    """Reactions and lines of `[[midi.map]]` that call sketched steps which the recordings do not have."""
    react, keys = set(), set()
    for called in steps_called(patch):
        place = called[2]
        try:
            refuse_unknown(graph, called)
        except PersonError:
            if place[0] == "react":
                react.add(int(place[1]))
            elif place[0] == "midi":
                keys.add(int(place[2]))
    return react, keys


def patch_for(patch: Patch, graph: MotionGraph, running: Patch, *, recordings: bool) -> Patch:
    """A patch that was edited while it runs, changed as it was at the start where `recordings` replaced its steps."""
    if not recordings:
        return patch
    limits, clock = running.locomotion, running.clock.beats_per_measure
    patch = with_locomotion(patch, threshold_m=limits.threshold_m, transition_beats=limits.transition_beats)
    patch = patch.model_copy(update={"clock": patch.clock.model_copy(update={"beats_per_measure": clock})})
    return with_steps_of(patch, graph)


def with_locomotion(patch: Patch, **changes: float) -> Patch:
    """The patch with some values of `[locomotion]` changed."""
    return patch.model_copy(update={"locomotion": patch.locomotion.model_copy(update=changes)})


RECORDED_M: Final = (0.25, 0.35)
"""How far apart poses of recordings may be to be joined [m]: if possible, and if some step is left alone else."""


@dataclass(frozen=True, slots=True, eq=False)
class LoadedShow:
    """A patch with its motion graph; `recordings` is the folder that replaced the patch's steps, if one did."""

    path: Path
    patch: Patch
    graph: MotionGraph
    recordings: Path | None = None
    reserve: Mapping[str, StepClip] = field(default_factory=dict)
    """Clips left out at the start, for events that add them, by `clip_key`."""
    bank: TextureBank | None = None
    """What upper bodies may be textured with, if the patch names recordings."""
    answers: AnswerBank | None = None
    """What partners answer from, if the patch has any."""
    sources: TomlSources | None = None
    """Where each key of the patch stands; None if it was not read from files."""
    projector: VenueProjector | None = None
    """The hall's, which the patch is played with; see `played_in`."""

    def played_in(self, projector: VenueProjector | None) -> "LoadedShow":
        """The same where a hall has that projector; PersonError if it cannot see this show's stage so."""
        return replace(self, patch=in_hall(self.patch, projector), projector=projector)

    def start(self, *, seed: int | None = None, tempo: float | None = None, begin: bool = True) -> Show:
        """A fresh show at its first moment; PersonError for a step that is not there. `begin`: see `Assembly`."""
        try:
            return Show(
                self.patch, self.graph, seed=seed, tempo=tempo, reserve=self.reserve, bank=self.bank,
                answers=self.answers, begin=begin,
            )  # fmt: skip
        except UnknownStep as error:
            raise PersonError(f"{self._where(error.place)}: {error}") from None
        except PersonError as error:
            raise PersonError(f"{self._where(error.place)}: {error.message}", error.remedy, error.place) from None

    def scene(self, *, whole: bool = True) -> Scene:
        """What the renderer begins with; PersonError for a file that it cannot show. If it need not be `whole`, whoever
        wears a character that cannot be drawn now has the usual body, and backgrounds that cannot be are not seen."""
        try:
            found = files_of(self.patch, self.path) if whole else drawable(self.patch, self.path)
            return scene_of(self.patch, self.path, found, whole=whole)
        except PersonError as error:
            raise PersonError(f"{self._where(error.place)}: {error.message}", error.remedy, error.place) from None

    def _where(self, place: tuple[str | int, ...]) -> str:
        """File and, if it is known, line of a key of the patch, with the key."""
        if self.sources is None or not place:
            return str(self.path)
        return f"{self.sources.told(place)}: {field_words(place)}"

    def clips(self) -> list[StepClip]:
        """All clips as a start would find them now."""
        return clips_of(self.patch, self.path, self.recordings)

    @property
    def steps_folder(self) -> Path | None:
        """The folder of this show's own steps, None if it dances the project's."""
        folder = self.recordings or find_beside(self.patch.steps, self.path)
        common = PATCHES / "steps"
        own = folder is not None and folder.is_dir() and not (common.is_dir() and common.samefile(folder))
        return folder if own else None

    @property
    def music_path(self) -> Path | None:
        """The patch's own music, if it names one; PersonError if that is not there."""
        name = self.patch.music.file
        if name is None:
            return None
        found = find_beside(name, self.path)
        if found is None:
            raise PersonError(f"{self.path}: the music {name!r} is not there", "correct music.file in the patch")
        return found

    def header(self, show: Show, *, tempo: float | None, music: Path | None = None) -> dict[str, Any]:
        """What a journal must hold so that the show can be run again; `music`: the file that is played to it."""
        return {
            "patch_path": str(self.path.resolve()),
            "patch": self.patch.written(),
            "recordings": None if self.recordings is None else str(self.recordings.resolve()),
            "seed": show.seed,
            "tempo": tempo,
            "music": None if music is None else str(music.resolve()),
            "steps_hash": library_hash(self.graph.library),
            "steps": [clip_key(clip) for clip in self.graph.library.clips],
            "texture": None if self.bank is None else self.bank.digest(),
            "partner": None if self.answers is None else self.answers.digest(),
        }


@contextlib.contextmanager
def _no_collection() -> Iterator[None]:
    """No automatic garbage collection meanwhile: in a score of 20,000 entries it takes a third of the time.

    Thread: the main one, before the show runs.
    """
    was = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was:
            gc.enable()


def load_show(path: Path, *, recordings: Path | None = None, whole: bool = True) -> LoadedShow:
    """Read the patch at `path` and its steps, or the recordings of a folder in their place. If it need not be `whole`,
    own passes and characters are not tried: for who goes on with a show in which they were."""
    with _no_collection():
        patch, sources = read_sources(path)
    if whole:
        try_passes(patch.picture.own_passes)
        with told_with_place(sources):
            check_characters(patch, path)
    try:
        return replace(show_of(patch, path, recordings=recordings), sources=sources)
    except PersonError as error:
        if not error.place:
            raise
        with told_with_place(sources):
            raise


@contextlib.contextmanager
def told_with_place(sources: TomlSources) -> Iterator[None]:
    """Whatever a person is told from within with the keys that lead to it begins with file, line and these keys."""
    try:
        yield
    except PersonError as error:
        where = f"{sources.told(error.place)}: {field_words(error.place)}"
        raise PersonError(f"{where}: {error.message}", error.remedy, error.place) from None


def clips_of(patch: Patch, path: Path, recordings: Path | None) -> list[StepClip]:
    """The clips that a show of the patch begins with, in their order."""
    return _sketched(patch, path) if recordings is None else load_folder(recordings)


def as_they_were(clips: list[StepClip], names: Sequence[str], was: Mapping[str, StepClip]) -> list[StepClip]:
    """The clips called `names`, in that order, those in `was` as they were."""
    there = {clip_key(clip): clip for clip in clips} | dict(was)
    return [there[name] for name in names if name in there]


def show_of(
    patch: Patch,
    path: Path,
    *,
    recordings: Path | None = None,
    later: frozenset[str] = frozenset(),
    names: Sequence[str] = (),
    was: Mapping[str, StepClip] | None = None,
) -> LoadedShow:
    """The show of a patch that was read already; `path` is where its names are looked up.

    Clips whose `clip_key` is in `later` are left out, and kept in reserve. For a replay: `names` of the clips that it
    began with (whatever has come since is left out), and what files held that have changed since (`was`).
    """
    found = clips_of(patch, path, recordings)
    there = {clip_key(clip): clip for clip in found} | dict(was or {})
    reserve = {key: there[key] for key in sorted(later) if key in there}
    clips = as_they_were(found, names, was or {}) if names else [c for c in found if clip_key(c) not in reserve]
    if recordings is not None:
        patch = for_recordings(patch, clips)
    fitting = [clip for clip in clips if clip.beats_per_measure == patch.clock.beats_per_measure]
    if not fitting:
        metres = ", ".join(str(beats) for beats in sorted({clip.beats_per_measure for clip in clips}))
        raise PersonError(
            f"{path}: no step has {patch.clock.beats_per_measure} beats a measure; those there are have {metres}",
            "change clock.beats_per_measure, or add such steps",
        )
    try:
        library = build_library(fitting)
        if recordings is not None:
            patch = _nearest_joins(library, patch)
        graph = _graph_of(library, patch)
    except ValueError as error:
        remedy = "[locomotion] in the patch" if recordings is None else "fps, drop_frames and bpm in the TOML"
        raise PersonError(f"{path}: {error}", f"look at {remedy}") from None
    if recordings is not None:
        patch = with_steps_of(patch, graph)
    _refuse_other_metres(patch, path, clips)
    bank, answers = bank_of(patch, path), answer_bank(patch, path, library)
    return LoadedShow(path, patch, graph, recordings, reserve, bank, answers)


def _graph_of(library: StepLibrary, patch: Patch) -> MotionGraph:
    limits = patch.locomotion
    window = min(1.0, limits.transition_beats / patch.clock.beats_per_measure)
    metric = Metric.of(limits.weights, limits.emphasis)
    return build_graph(library, window=window, threshold=limits.threshold_m, metric=metric)


def _nearest_joins(library: StepLibrary, patch: Patch) -> Patch:
    """The patch with the smaller threshold for recordings, if that leaves no step alone; else with the larger one."""
    least, most = (max(patch.locomotion.threshold_m, threshold) for threshold in RECORDED_M)
    for threshold in (least, most):
        patch = with_locomotion(patch, threshold_m=threshold)
        with contextlib.suppress(ValueError):  # the larger one is tried, and told, below
            if not _graph_of(library, patch).missing:
                break
    return patch


def _refuse_other_metres(patch: Patch, path: Path, clips: list[StepClip]) -> None:
    """PersonError if a group names a step that is there, but of another metre."""
    beats = patch.clock.beats_per_measure
    others = {clip.step.casefold(): clip.beats_per_measure for clip in clips if clip.beats_per_measure != beats}
    for group in patch.group:
        for entry in group.steps:
            name = parse_entry(entry)[0]
            if name.casefold() in others:
                raise PersonError(
                    f"{path}: step {name!r} of group {group.name!r} has {others[name.casefold()]} beats a measure, "
                    f"this show has {beats}"
                )


def _sketched(patch: Patch, path: Path) -> list[StepClip]:
    """The steps of the patch's own folder, and the project's for every name that it does not have."""
    folder = find_beside(patch.steps, path)
    if folder is None or not folder.is_dir():
        raise PersonError(f"{path}: there is no folder {patch.steps!r} of steps", "correct 'steps' in the patch")
    clips = load_folder(folder)
    common = PATCHES / "steps"
    if common.is_dir() and not common.samefile(folder):
        own = {clip.step.casefold() for clip in clips}
        clips += [clip for clip in load_folder(common) if clip.step.casefold() not in own]
    return clips
