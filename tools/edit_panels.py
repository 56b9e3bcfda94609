"""Panels, footprints and stick figures for the pictures of the editing tools."""

from pathlib import Path
from typing import Final, Literal

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from live.motion.editing.facing import heading_of
from live.motion.editing.foot_correction import find_feet
from live.motion.forward_kinematics import forward_kinematics
from live.motion.skeleton import SKELETON
from live.motion.sketch.sketch_clips import step_clip
from live.motion.sketch.sketch_file import parse_sketch
from live.motion.step_clip import StepClip

Float = npt.NDArray[np.floating]
Corner = Literal["best", "upper left", "upper right", "lower left", "lower right"]

STEPS: Final = Path(__file__).resolve().parent.parent / "patches" / "steps"
HEAD: Final = SKELETON.index("head")


def sketch(name: str, direction: str = "in place") -> StepClip:
    """One of the project's steps."""
    path = STEPS / f"{name}.toml"
    return step_clip(parse_sketch(path.read_text(encoding="utf-8"), path.name), direction)


def beats(step: StepClip) -> Float:
    """Time of each sample in beats from 1, the first downbeat."""
    return 1.0 + (np.arange(step.clip.sample_count) - step.first) * (step.beats_per_measure / step.samples_per_measure)


def within(step: StepClip) -> slice:
    """The samples of the step's measures."""
    first = round(step.first)
    return slice(first, first + round(step.measures * step.samples_per_measure) + 1)


def places(step: StepClip) -> Float:
    """World positions of all joints, (T, J, 3)."""
    return forward_kinematics(step.clip.root_position.astype(np.float64), step.clip.rotation.astype(np.float64))[0]


def headings(step: StepClip, joint: int) -> Float:
    """Heading of a joint [degrees], unwrapped."""
    world = forward_kinematics(step.clip.root_position.astype(np.float64), step.clip.rotation.astype(np.float64))[1]
    return np.degrees(np.unwrap(heading_of(world[:, joint])))


def panels(count: int, title: str, widths: list[float] | None = None, height: float = 3.1) -> tuple[Figure, list[Axes]]:
    """A figure with `count` panels side by side."""
    figure = Figure(figsize=(9.0, height), dpi=100, layout="constrained")
    figure.suptitle(title, fontsize=11, x=0.01, ha="left")
    axes = figure.subplots(1, count, width_ratios=widths, squeeze=False)[0]
    for axis in axes:
        axis.spines[["top", "right"]].set_visible(False)
    return figure, list(axes)


def label(axis: Axes, title: str, x: str, y: str, *, legend: Corner | None = "best") -> None:
    """Words of a panel."""
    axis.set_title(title, fontsize=9, loc="left")
    axis.set_xlabel(x, fontsize=8)
    axis.set_ylabel(y, fontsize=8)
    axis.tick_params(labelsize=7)
    if legend:
        axis.legend(fontsize=7, framealpha=0.85, edgecolor="none", loc=legend)


def footprints(axis: Axes, step: StepClip, colour: str, name: str) -> None:
    """Where the feet stand from above: a line from heel to ball for each stand, and the way of the hips."""
    feet, part = find_feet(step.clip), within(step)
    hips = step.clip.root_position[part]
    axis.plot(hips[:, 0], hips[:, 2], color=colour, lw=1.0, ls=":")
    for foot in (0, 1):
        contact = np.concatenate(([False], step.clip.contact[part, foot], [False])).astype(int)
        edges = np.flatnonzero(np.diff(contact))
        for start, stop in zip(edges[::2], edges[1::2], strict=True):
            middle = part.start + (start + stop) // 2
            heel, ball = feet.ankle[middle, foot], feet.ball[middle, foot]
            axis.plot((heel[0], ball[0]), (heel[2], ball[2]), color=colour, lw=4, solid_capstyle="round", label=name)
            name = "_"
    axis.set_aspect("equal", adjustable="datalim")


def stage(axis: Axes, title: str, names: tuple[str, ...], shift: float) -> None:
    """A panel of stick figures that stand `shift` metres apart, seen from the audience."""
    axis.set_aspect("equal")
    axis.set_xlim(-0.6 * shift, (len(names) - 0.4) * shift)
    axis.set_ylim(0.0, 2.0)
    axis.set_yticks(())
    axis.set_xticks([n * shift for n in range(len(names))], names, fontsize=8)
    axis.spines["left"].set_visible(False)
    axis.set_title(title, fontsize=9, loc="left")


def figure_of(axis: Axes, position: Float, shift: float, colour: str, upper: str | None = None) -> None:
    """A stick figure (J, 3) seen from the audience, `shift` metres to the right; `upper` colours the upper body."""
    for joint, parent in enumerate(SKELETON.parents):
        if parent < 0:
            continue
        legs = SKELETON.names[joint].endswith(("Leg", "Foot", "Toes"))
        ends = position[[parent, joint]]
        axis.plot(ends[:, 0] - position[0, 0] + shift, ends[:, 1], color=colour if legs else (upper or colour), lw=2.2)
    head = position[HEAD] + (0.0, 0.1, 0.0)
    axis.plot(head[0] - position[0, 0] + shift, head[1], "o", ms=9, color=upper or colour)
