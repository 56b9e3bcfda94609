"""Recorded: what a patch becomes when a folder of recordings is danced in the place of its steps."""

from live.base.errors import PersonError
from live.graph.motion_graph import MotionGraph
from live.motion.step_clip import StepClip
from live.show.patch.patch import Patch
from live.show.patch.score_conflicts import refuse_unknown, steps_called


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
