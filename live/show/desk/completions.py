"""Completions for the first argument of controls that name parts of a patch: steps, cues, scenes and others."""

from collections.abc import Sequence
from typing import Final

from live.control.registry.capture_controls import MOCAP_CONTROLS
from live.show.patch.patch import Patch
from live.show.patch.section_score import formation_names
from live.show.show import Show

FORMATIONS: Final = ("circle", "line", "grid", "wedge", "two lines", "spiral", "heart")
"""Used where a patch names no formation of its own."""


def completion_names(patch: Patch, steps: Sequence[str]) -> dict[str, list[str]]:
    """Return the known names by address of the control."""
    cues, performers = [cue.name for cue in patch.cue], [performer.name for performer in patch.mocap]
    return {
        "/dance/step": list(steps),
        "/dance/now": list(steps),
        "/dance/formation": formation_names(patch.formation) or list(FORMATIONS),
        "/dance/cue": cues,
        "/dance/standby": cues,
        "/dance/scene": ["start", *(scene.name for scene in patch.scene)],
        "/dance/camera": ["start", *(view.name for view in patch.view)],
        "/dance/look": ["start", *(look.name for look in patch.looks)],
        "/dance/section": [section.name for section in patch.section],
        "/dance/signal": sorted({signal.name for signal in patch.signal}),
        "/dance/background": [background.name for background in patch.background],
        **{control.address: performers for control in MOCAP_CONTROLS},
    }


def show_completions(show: Show) -> dict[str, list[str]]:
    """Return the known names of a running show."""
    return completion_names(show.patch, show.graph.library.steps)
