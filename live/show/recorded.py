"""Recorded: what a patch becomes when a folder of recordings is danced in the place of its steps."""

from live.graph.motion_graph import MotionGraph
from live.motion.step_clip import StepClip
from live.show.patch import Patch


def for_recordings(patch: Patch, clips: list[StepClip]) -> Patch:
    """The patch with the metre that most of the recordings have, and a beat for each blend: they differ more than
    sketches, and hands must not cross faster than they do in the clips."""
    metres = [clip.beats_per_measure for clip in clips]
    clock = patch.clock.model_copy(update={"beats_per_measure": max(metres, key=metres.count)})
    return with_locomotion(patch.model_copy(update={"clock": clock}), transition_beats=1.0)


def with_steps_of(patch: Patch, graph: MotionGraph) -> Patch:
    """The patch with every group drawing from all steps that connect, as `--steps` asks for; echoes go on echoing."""
    library = graph.library
    names = tuple(f"{name} x1" for step, name in enumerate(library.steps) if len(graph.entries(step)))
    groups = tuple(
        group.model_copy(update={"travel_step": None} | ({} if group.like else {"steps": names, "choose": "random"}))
        for group in patch.group
    )
    return patch.model_copy(update={"group": groups})


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
