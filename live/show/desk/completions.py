"""Completions for the first argument of controls that name parts of a patch: steps, cues, scenes and others."""

from collections.abc import Sequence

from live.base.parameter import WORLD_NAMES
from live.control.registry.registry import FIRST_NAMES
from live.show.desk.pad import SHAPES
from live.show.desk.parameter_table import NAME_CHOICES
from live.show.patch.patch import Patch
from live.show.patch.section_score import formation_names
from live.show.show import Show


def completion_names(patch: Patch, steps: Sequence[str]) -> dict[str, list[str]]:
    """Return the known names by address of the control whose first argument is such a name."""
    names = {
        "step": list(steps),
        "formation": formation_names(patch.formation) or list(SHAPES),
        "cue": [cue.name for cue in patch.cue],
        "scene": ["start", *(scene.name for scene in patch.scene)],
        "view": ["start", *(view.name for view in patch.view)],
        "world": list(WORLD_NAMES),
        "look": ["start", *(look.name for look in patch.looks)],
        "section": [section.name for section in patch.section],
        "signal": sorted({signal.name for signal in patch.signal}),
        "title": [title.name for title in patch.title],
        "background": [background.name for background in patch.background],
        **{kind: list(names) for kind, names in NAME_CHOICES.items()},
        "performer": [performer.name for performer in patch.mocap],
        "answer": [answer.name for answer in patch.answer],
    }
    return {address: names[kind] for address, kind in FIRST_NAMES.items() if kind in names}


def show_completions(show: Show) -> dict[str, list[str]]:
    """Return the known names of a running show."""
    return completion_names(show.patch, show.graph.library.steps)
