"""Lookup of library folders and steps named on the command line."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import platformdirs

from live.base.errors import PersonError
from live.graph.step_library import plain_name as plain
from live.library.step_folder import load_folder
from live.motion.step_clip import StepClip
from live.show.patch.patch_search_path import PATCHES

SKETCH_THRESHOLD_M = 0.16
RECORDING_THRESHOLD_M = 0.35
"""Maximum pose distance of joins [m]: for sketches as in a patch, for recordings as with `live play --steps`."""


def user_library() -> Path:
    """Return the default folder of `live steps add`."""
    return Path(platformdirs.user_data_dir("choreographics-live")) / "steps"


def library_folders(library: Path | None) -> list[Path]:
    """Return the given folder, else the user's (if it exists) and the built-in one."""
    if library is not None:
        return [library]
    own = user_library()
    return [*([own] if own.is_dir() and any(own.glob("*.toml")) else []), PATCHES / "steps"]


@dataclass(frozen=True, slots=True, eq=False)
class NamedStep:
    """A step with all its variations."""

    name: str
    clips: tuple[StepClip, ...]
    folder: Path
    examples: int = 0
    """Number of further clips that are examples of moods: they are not danced."""

    @property
    def directions(self) -> list[str]:
        """The directions of its variations."""
        return list(dict.fromkeys(clip.direction for clip in self.clips))

    def values_of(self, field: str) -> list[str]:
        """Return the different non-empty values of a field in its variations."""
        return list(dict.fromkeys(str(getattr(c, field)) for c in self.clips if getattr(c, field) not in ("", None)))

    @property
    def tags(self) -> list[str]:
        """All tags of its variations."""
        return list(dict.fromkeys(tag for clip in self.clips for tag in clip.tags))


def named_steps(library: Path | None) -> list[NamedStep]:
    """Return all steps, folder by folder; an earlier step hides later ones of the same name."""
    found: dict[str, NamedStep] = {}
    for folder in library_folders(library):
        clips = load_folder(folder)
        for name in dict.fromkeys(clip.step for clip in clips):
            own = tuple(clip for clip in clips if clip.step == name)
            danced = tuple(clip for clip in own if not clip.mood)
            if danced:
                found.setdefault(plain(name), NamedStep(name, danced, folder, len(own) - len(danced)))
    return list(found.values())


def find_step(steps: Sequence[NamedStep], name: str) -> NamedStep:
    """Return the step of that name, ignoring case, blanks and underscores; PersonError lists the nearest names."""
    for step in steps:
        if plain(step.name) == plain(name):
            return step
    import difflib

    near = difflib.get_close_matches(plain(name), [plain(step.name) for step in steps], n=3)
    there = [step.name for step in steps if plain(step.name) in near] or [step.name for step in steps]
    raise PersonError(f"there is no step {name[:80]!r}", f"{', '.join(there[:20])} (see `live steps list`)")


def threshold_for(steps: Sequence[NamedStep]) -> float:
    """Return the maximum pose distance of joins between these steps [m]."""
    sketched = all(step.folder == PATCHES / "steps" for step in steps)
    return SKETCH_THRESHOLD_M if sketched else RECORDING_THRESHOLD_M
