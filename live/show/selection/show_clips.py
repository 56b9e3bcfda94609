"""The clips with which a show of a patch begins: its steps, the takes it chooses, and the tempo they must fit."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from live.base.errors import PersonError
from live.library.step_folder import load_folder, varied_steps, with_path_variants
from live.motion.editing.tempo_forms import recorded_name
from live.motion.mirror import unmirrored_name
from live.motion.step_clip import StepClip
from live.show.patch.patch import Patch
from live.show.patch.patch_search_path import PATCHES, find_resource
from live.show.selection.graph_update import clips_by_key

MAX_NAMES: Final = 40
"""Names that an error lists."""


@dataclass(frozen=True, slots=True)
class ShowTempo:
    """What of a show's tempo is given beside its patch."""

    low: float | None = None
    """Least tempo [bpm] of the music that is given; None: the patch's own."""
    high: float | None = None
    """Its most tempo [bpm]; None: `low`."""
    share: float = 1.0
    """Share of the tempo at which the show is practised."""
    own_music: bool = True
    """Whether the patch's own music is played, if it has any."""

    def span(self, patch: Patch) -> tuple[float, float]:
        """Return least and most tempo [bpm] of a show of the patch, as far as it is known before it begins."""
        if self.low is not None:
            low, high = self.low, self.low if self.high is None else self.high
        else:
            known = patch.music.tempo_span if self.own_music else None
            low, high = known or (patch.clock.bpm, patch.clock.bpm)
        return low * self.share, high * self.share


NO_TEMPO: Final = ShowTempo()


def read_clips(patch: Patch, path: Path, recordings: Path | None) -> list[StepClip]:
    """Return the clips of a patch as recorded or sketched, in order, recorded ones with their path variants; then the
    variations that the patch asks for."""
    clips = _read_own_steps(patch, path) if recordings is None else load_folder(recordings)
    chosen = _chosen_takes(patch, clips)
    return with_path_variants(chosen) + varied_steps(chosen, patch.variations, patch.seed)


def _chosen_takes(patch: Patch, clips: list[StepClip]) -> list[StepClip]:
    """Leave out the takes that the patch does not choose, with their mirror images; PersonError for unknown names."""
    there: dict[str, set[str]] = {}
    for clip in clips:
        there.setdefault(clip.step.casefold(), set()).add(unmirrored_name(clip.clip.name))
    wanted = {step.casefold(): set(map(recorded_name, names)) for step, names in patch.takes.items()}
    for step, names in patch.takes.items():
        takes = there.get(step.casefold())
        if takes is None:
            known = ", ".join(sorted({clip.step for clip in clips})[:MAX_NAMES])
            raise PersonError(f"there is no step {step!r}; there are: {known}", "correct the name", ("takes", step))
        if unknown := next((name for name in names if recorded_name(name) not in takes), None):
            message = f"the step {step!r} has no take {unknown!r}; there are: {'; '.join(sorted(takes)[:MAX_NAMES])}"
            raise PersonError(message, "correct the name", ("takes", step))
    return [
        clip
        for clip in clips
        if (chosen := wanted.get(clip.step.casefold())) is None or unmirrored_name(clip.clip.name) in chosen
    ]


def replace_clips(clips: list[StepClip], names: Sequence[str], former: Mapping[str, StepClip]) -> list[StepClip]:
    """Return the clips called `names`, in that order; clips in `former` replace those of the same key."""
    there = clips_by_key(clips) | dict(former)
    return [there[name] for name in names if name in there]


def _read_own_steps(patch: Patch, path: Path) -> list[StepClip]:
    """Return the steps of the patch's own folder, and the project's steps for all other names."""
    folder = find_resource(patch.steps, path)
    if folder is None or not folder.is_dir():
        raise PersonError(f"{path}: there is no folder {patch.steps!r} of steps", "correct 'steps' in the patch")
    clips = load_folder(folder)
    common = PATCHES / "steps"
    if common.is_dir() and not common.samefile(folder):
        own = {clip.step.casefold() for clip in clips}
        clips += [clip for clip in load_folder(common) if clip.step.casefold() not in own]
    return clips
