"""Check of an edited patch by the show that would be danced: steps, transitions, formations, files."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

from live.base.errors import PersonError
from live.graph.motion_graph import MotionGraph
from live.show.assembly import assemble
from live.show.dancers.character_casting import check_characters
from live.show.group.stage_check import stage_faults
from live.show.loader import LoadedShow, load_from_patch
from live.show.patch.patch import Patch
from live.show.patch.patch_search_path import find_resource
from live.show.score.step_names import UnknownStep
from live.show.selection.show_clips import NO_TEMPO, ShowTempo
from live.show.show import Show
from live.show.view.render_scene import make_backgrounds, make_scenery

MAX_FAULTS: Final = 8
"""Maximum number of faults that are looked for."""
LEAVES: Final = (
    "segment", "sequence", "at", "element", "regroup", "react", "improvise", "cue", "scene", "signal", "partner",
)  # fmt: skip
"""Entries that nothing else needs: without a faulty one, the others can still be checked."""
GRAPH_KEYS: Final = ("steps", "locomotion", "texture", "partner")
"""Keys of a patch that the motion graph, or what is loaded with it, depends on."""


def show_faults(make_show: Callable[[Patch], Any], patch: Patch) -> list[PersonError]:
    """Return why a show of a patch does not start, as `make_show` finds it: all faults in entries that nothing else
    needs, else the first."""
    faults: list[PersonError] = []
    numbers = {name: list(range(len(getattr(patch, name)))) for name in LEAVES}
    while len(faults) < MAX_FAULTS:
        try:
            make_show(patch)
            return faults
        except UnknownStep as error:
            fault = PersonError(str(error), key_path=error.place)
        except PersonError as error:
            fault = error
        except ValueError as error:  # of the graph
            fault = PersonError(str(error))
        match fault.key_path:
            case (str(name), int(index), *rest) if name in LEAVES:
                original = numbers[name].pop(index)
                faults.append(PersonError(fault.message, fault.remedy, (name, original, *rest)))
                rows = getattr(patch, name)
                patch = patch.model_copy(update={name: (*rows[:index], *rows[index + 1 :])})
            case _:
                return [*faults, fault]
    return faults


class ShowCheck:
    """Checks patches by starting a show of them, which never runs. What the shows have in common is loaded once."""

    def __init__(self, path: Path, recordings: Path | None = None, tempo: ShowTempo = NO_TEMPO) -> None:
        """`path` is where the patch lies; `recordings`: the folder that replaces its steps, if any; `tempo`: what of
        its tempo is given beside the patch."""
        self._path, self._recordings, self._tempo = path, recordings, tempo
        self._loaded: LoadedShow | None = None
        self._show: Show | None = None
        self._made: Any = None  # the last show that started
        self._files: Patch | None = None  # the patch whose files were found

    def __call__(self, patch: Patch, former: Patch | None) -> list[PersonError]:
        """Return why a show of a patch would not start, or whom its stage strands that `former` did not; empty if all
        is well."""
        try:
            self._check_files(patch)
        except PersonError as error:
            return [error]
        self._files = patch
        faults = show_faults(self._make, patch)
        return faults or ([] if former is None else stage_faults(self._made, former))

    def _make(self, patch: Patch) -> None:
        loaded = self._loaded
        if loaded is None or self._show is None or needs_loading(loaded.patch, patch):
            loaded = load_from_patch(patch, self._path, recordings=self._recordings, tempo=self._tempo)
            _refuse_gaps(loaded.graph)
            self._show = assemble(loaded.patch, loaded.graph, bank=loaded.bank, answers=loaded.answers)
            self._loaded, self._made = loaded, self._show
            return
        self._made = self._show.hot_swap.make_show(patch, loaded.graph)

    def _check_files(self, patch: Patch) -> None:
        """Raise PersonError for a file that the patch names and that is missing or damaged."""
        former = self._files
        if former is None or patch.character != former.character:
            check_characters(patch, self._path)
        if former is None or patch.background != former.background:
            make_backgrounds(patch, self._path)
        if former is None or patch.scenery != former.scenery:
            make_scenery(patch, self._path)
        file = patch.music.file
        if file is not None and find_resource(file, self._path) is None:
            raise PersonError(f"there is no file {file!r}", "put it next to the patch", ("music", "file"))


def needs_loading(former: Patch, patch: Patch) -> bool:
    """Return whether another patch needs another motion graph, or more that is loaded with it."""
    same_metre = former.clock.beats_per_measure == patch.clock.beats_per_measure
    return not same_metre or any(getattr(former, key) != getattr(patch, key) for key in GRAPH_KEYS)


def _refuse_gaps(graph: MotionGraph) -> None:
    if graph.missing:
        raise PersonError("; ".join(graph.missing), "raise locomotion.threshold_m, or change those steps' ends")
