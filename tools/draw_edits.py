"""Draw the pictures of docs/explanation/editing.md: ``python tools/draw_edits.py`` writes docs/pictures/editing/*.png.

Each shows one editing tool before and after, on the project's own sketches, with chance from fixed seeds.
"""

import io
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Final
from unittest.mock import patch

import numpy as np
from matplotlib.figure import Figure
from PIL import Image

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from live.motion import quaternion
from live.motion.editing import momentum_variation
from live.motion.editing.body_mass import centre_of_mass, rotation_row
from live.motion.editing.facing import (
    HEAD_LIMIT,
    average_orientation,
    face_audience,
    face_head,
    fill_gaps,
    head_turn,
    heading_of,
    wrap,
)
from live.motion.editing.foot_correction import correct_floor, find_feet
from live.motion.editing.interpolate import interpolate
from live.motion.editing.momentum_variation import vary_step
from live.motion.editing.time_warp import draw_measure_warps, draw_sequence_warp, warp_step
from live.motion.editing.turn_insertion import (
    BLEND_WINDOW,
    LIFT_THRESHOLD,
    height_difference,
    insert_rotation,
    support_turns,
)
from live.motion.editing.variation import combine, draw_sequence_factors, factor_at, scale_step
from live.motion.forward_kinematics import forward_kinematics
from live.motion.mirror import mirror_step
from live.motion.pose.foot_lock import lock_feet
from live.motion.skeleton import SKELETON
from live.motion.step_clip import StepClip
from tools.edit_panels import (
    HEAD,
    Float,
    beats,
    figure_of,
    footprints,
    headings,
    label,
    panels,
    places,
    sketch,
    stage,
    within,
)

ROOT: Final = Path(__file__).resolve().parent.parent
BEFORE: Final = "#8a8f98"
AFTER: Final = "#d9480f"
THIRD: Final = "#1c6fb8"
SHADE: Final = "#fff0d6"
WINDOW: Final = "#e9ecef"
HAND, CHEST = SKELETON.index("leftHand"), SKELETON.index("upperChest")
MAX_BYTES: Final = 60_000


def draw_interpolation() -> Figure:
    a, b = sketch("walk", "long forward"), sketch("walk", "long left")
    held, plain = (interpolate(a, b, 0.5, hold_feet=hold) for hold in (True, False))
    figure, (plan, slide) = panels(
        2, "interpolate: a walk forward and a walk to the left make a diagonal walk", [1, 1.6]
    )
    for step, colour, name in ((a, BEFORE, "forward"), (b, THIRD, "to the left"), (held, AFTER, "half of each")):
        footprints(plan, step, colour, name)
    label(plan, "footprints from above", "x [m]", "z [m]", legend="upper left")
    for step, colour, name in ((plain, BEFORE, "SLERP alone"), (held, AFTER, "feet held")):
        part = within(step)
        ball = find_feet(step.clip).ball[part]
        speed = np.hypot(*np.diff(ball, axis=0)[..., (0, 2)].transpose(2, 0, 1)) * step.clip.sample_rate * 100
        contact = step.clip.contact[part]
        speed[~(contact[1:] & contact[:-1])] = np.nan
        slide.plot(beats(step)[part][1:], speed, color=colour, lw=2, label=[name, "_"])
    label(slide, "how fast standing feet slide", "beat", "cm/s")
    return figure


def draw_combination() -> Figure:
    legs = sketch("samba")
    arms = replace(sketch("arm_wave"), step=legs.step)
    both = combine(legs, arms)
    figure, axes = panels(3, "combine: the legs of one take, all from the spine upwards of another", height=2.3)
    colours = ((BEFORE, BEFORE), (THIRD, THIRD), (BEFORE, THIRD))
    for axis, beat in zip(axes, (1.5, 2.5, 3.5), strict=True):
        sample = int(np.argmin(np.abs(beats(legs) - beat)))
        for n, (step, (lower, upper)) in enumerate(zip((legs, arms, both), colours, strict=True)):
            figure_of(axis, places(step)[sample], 1.5 * n, lower, upper)
        stage(axis, f"beat {beat:g}", ("legs", "arms", "both"), 1.5)
    return figure


def draw_variations() -> Figure:
    step = sketch("reach")
    varied = vary_step(step, 2, 1)
    with patch.object(momentum_variation, "projected", lambda body, drawn, rate: drawn):
        noise = vary_step(step, 2, 1)
    figure, axes = panels(
        3, "vary_step: another carriage of trunk, arms and head; balance and momentum stay", [1, 1, 1], 2.6
    )
    for axis, beat in zip(axes, (2.0, 4.5), strict=False):
        sample = int(np.argmin(np.abs(beats(step) - beat)))
        for n, (each, colour) in enumerate(((step, BEFORE), (varied[0], AFTER), (varied[1], THIRD))):
            figure_of(axis, places(each)[sample], 1.7 * n, "#495057", colour)
        stage(axis, f"beat {beat:g}", ("the step", "variation 1", "variation 2"), 1.7)
    part = within(step)
    for each, colour, name in ((noise[0], BEFORE, "the same angles, uncorrected"), (varied[0], AFTER, "variation 1")):
        strays = 1000.0 * np.linalg.norm(_centre(each) - _centre(step), axis=-1)
        axes[2].plot(beats(step)[part], strays[part], color=colour, lw=2, label=name)
    axes[2].set_ylim(0.0, 14.0)
    label(axes[2], "how far the centre of mass strays", "beat", "mm", legend="upper right")
    return figure


def _centre(step: StepClip) -> Float:
    root = step.clip.root_position.astype(np.float64)
    world = forward_kinematics(root, step.clip.rotation.astype(np.float64))[1]
    return centre_of_mass(root, rotation_row(quaternion.to_matrix(world)))


def draw_rotation() -> Figure:
    step = sketch("walk", "long forward")
    turned = insert_rotation(step, np.pi / 2)
    turns = support_turns(step, 0)
    figure, (lift, yaw, plan) = panels(
        3, "insert_rotation: 90 degrees, turned only while one foot carries", [1.3, 1.3, 1]
    )
    part, time = within(step), beats(step)
    difference = 100 * height_difference(find_feet(step.clip))[part]
    lift.plot(time[part], difference, color=BEFORE, lw=2)
    lift.axhline(LIFT_THRESHOLD * difference.max(), color=THIRD, lw=1, label="20 % of the largest")
    for axis in (lift, yaw):
        for start, stop, weight in zip(turns.start, turns.stop, turns.weight, strict=True):
            if weight > 0:
                axis.axvspan(1 + 4 * start, 1 + 4 * stop, color=SHADE, lw=0)
        axis.axvspan(1 + 4 * (1 - BLEND_WINDOW), 5, color=WINDOW, lw=0)
    label(lift, "difference of the feet's heights", "beat (grey: blend window)", "cm", legend="upper right")
    yaw.plot(time[part], headings(step, 0)[part], color=BEFORE, lw=2, label="before")
    yaw.plot(time[part], headings(turned, 0)[part], color=AFTER, lw=2, label="after")
    label(yaw, "heading of the hips", "beat", "degrees", legend="upper left")
    footprints(plan, step, BEFORE, "before")
    footprints(plan, turned, AFTER, "after")
    label(plan, "footprints from above", "x [m]", "z [m]", legend="upper right")
    return figure


def draw_measure_warp() -> Figure:
    step = sketch("arm_wave")
    warps = draw_measure_warps(np.random.default_rng(14), 5)
    x = np.linspace(0.0, 1.0, 400)
    figure, (error, curve, hand) = panels(
        3, "warp_step: a half wave of haste or delay in each measure; its end is never moved"
    )
    warped = warps.phase(x[:, None])
    error.plot(1 + 4 * x, 4 * (warped - x[:, None]), lw=1.6)
    label(error, "ahead (+) or behind (-), five dancers", "beat", "beats", legend=None)
    curve.plot(1 + 4 * x, 1 + 4 * x, color=BEFORE, lw=1)
    curve.plot(1 + 4 * x, 1 + 4 * warped, lw=1.4)
    label(curve, "beat of the clip that is seen", "beat", "beat", legend=None)
    part = within(step)
    hand.plot(beats(step)[part], places(step)[part, HAND, 1], color="black", lw=2.4, label="as sketched")
    for n in range(5):
        dancer = warp_step(step, warps.select(np.array((n,))))
        hand.plot(beats(step)[part], places(dancer)[part, HAND, 1], lw=1.2)
    for axis in (error, curve, hand):
        axis.axvspan(1 + 4 * (1 - BLEND_WINDOW), 5, color=WINDOW, lw=0)
    label(hand, "height of the left hand", "beat (grey: blend window)", "m")
    return figure


def draw_wander() -> Figure:
    warp = draw_sequence_warp(np.random.default_rng(4), 16)
    x = np.linspace(0.0, 16.0, 1600)
    size, pace = warp._splines()
    figure, axes = panels(3, "warp_sequence: slow swings about the beat over sixteen measures, never backwards")
    axes[0].plot(1 + x, 4 * size(x), color=AFTER, label="A(x) [beats]")
    axes[0].plot(1 + x, pace(x), color=THIRD, label="f(x) [waves a measure]")
    axes[0].plot(1 + warp.knots, 4 * warp.amplitudes, "o", ms=3, color=AFTER)
    axes[0].plot(1 + warp.knots, warp.frequencies, "o", ms=3, color=THIRD)
    label(axes[0], "random points, cubic splines", "measure", "")
    axes[1].plot(1 + x, 4 * (warp.phase(x) - x), color=AFTER)
    label(axes[1], "ahead (+) or behind (-)", "measure", "beats", legend=None)
    axes[2].plot(1 + x[1:], np.diff(warp.phase(x)) / np.diff(x), color=AFTER, label="after")
    axes[2].axhline(1.0, color=BEFORE, lw=1, label="before")
    axes[2].set_ylim(0.0, 2.0)
    label(axes[2], "speed of the clip: always above 0", "measure", "", legend="lower right")
    return figure


def draw_amplitude() -> Figure:
    step = sketch("reach")
    figure, (hand, factors, pose) = panels(3, "scale_step: gestures 20 % smaller or larger, the legs as they were")
    part = within(step)
    steps = [(0.8, THIRD), (1.0, BEFORE), (1.2, AFTER)]
    for r, colour in steps:
        hand.plot(beats(step)[part], places(scale_step(step, r))[part, HAND, 1], color=colour, lw=2, label=f"r = {r:g}")
    label(hand, "height of the left hand", "beat", "m")
    where, values = draw_sequence_factors(np.random.default_rng(49), 12)
    x = np.linspace(0.0, 12.0, 600)
    factors.plot(1 + x, factor_at(where, values, x), color=AFTER)
    factors.plot(1 + where[where <= 12], values[where <= 12], "o", ms=3, color="black")
    label(factors, "r(x) of a sequence: two by two, PCHIP", "measure", "r", legend=None)
    sample = int(np.argmax(places(step)[part, HAND, 1])) + part.start
    for n, (r, colour) in enumerate(steps):
        figure_of(pose, places(scale_step(step, r))[sample], 1.4 * n, "#495057", colour)
    stage(pose, "the highest reach", ("r = 0.8", "r = 1", "r = 1.2"), 1.4)
    return figure


def draw_orientation() -> Figure:
    step = sketch("samba", "long forward")
    before = insert_rotation(step, 1.4)
    after = replace(before, clip=face_audience(before.clip))
    figure, (yaw, plan) = panels(
        2, "face_public: the whole result turned until its average orientation is zero", [1.6, 1]
    )
    for each, colour, name in ((before, BEFORE, "before"), (after, AFTER, "after")):
        degrees = headings(each, 0)
        yaw.plot(beats(each), degrees, color=colour, lw=2, label=name)
        mean = np.degrees(average_orientation(each.clip))
        yaw.axhline(mean, color=colour, lw=1, ls="--", label=f"mean {abs(mean):.0f}°")
        footprints(plan, each, colour, name)
    label(yaw, "heading of the hips (0 = the public)", "beat", "degrees")
    label(plan, "footprints from above; the public is at the top", "x [m]", "z [m]")
    return figure


def draw_head() -> Figure:
    step = insert_rotation(sketch("grapevine"), 2.0 * np.pi)
    after = replace(step, clip=face_head(step.clip))
    time = beats(step)
    world = forward_kinematics(step.clip.root_position.astype(np.float64), step.clip.rotation.astype(np.float64))[1]
    wanted = wrap(-heading_of(world[:, HEAD]))
    turned = wrap(heading_of(world[:, HEAD]) - heading_of(world[:, CHEST]))
    kept = (np.abs(wanted) <= HEAD_LIMIT) & (np.abs(turned + wanted) <= HEAD_LIMIT)
    figure, (theta, head) = panels(2, "face_head: the head looks at the public while the body turns")
    theta.plot(
        time, np.degrees(np.where(kept, np.nan, wanted)), color=BEFORE, lw=1, label="wanted, beyond a neck: left out"
    )
    theta.plot(time, np.degrees(np.where(kept, wanted, np.nan)), color="black", lw=2, label="wanted")
    theta.plot(time, np.degrees(fill_gaps(wanted, kept)), color=THIRD, lw=1, ls="--", label="gaps filled")
    theta.plot(time, np.degrees(head_turn(step.clip)), color=AFTER, lw=2, label="smoothed: what is added")
    for sign in (-1.0, 1.0):
        theta.axhline(sign * 60.0, color=BEFORE, lw=0.7, ls=":")
    label(theta, "turn of the head θ", "beat", "degrees")
    for each, colour, name in ((step, BEFORE, "before"), (after, AFTER, "after")):
        head.plot(time, np.degrees(wrap(np.radians(headings(each, HEAD)))), ".", ms=3, color=colour, label=name)
    label(head, "where the head looks (0 = the public)", "beat", "degrees")
    return figure


def draw_floor() -> Figure:
    step = sketch("samba")
    root = step.clip.root_position.copy()
    root[:, 1] -= np.float32(0.02) * (1 + np.sin(beats(step) * 1.9)).astype(np.float32)
    sunk = replace(step, clip=replace(step.clip, root_position=root))
    corrected = correct_floor(sunk.clip)
    figure, (soles, lift) = panels(2, "correct_floor: feet below the floor are lifted, softly; the body stays")
    part, time = within(step), beats(step)
    for clip, colour, name in ((sunk.clip, BEFORE, "before"), (corrected.clip, AFTER, "after")):
        soles.plot(time[part], 100 * find_feet(clip).height[part], color=colour, lw=1.6, label=[name, "_"])
    soles.axhline(0.0, color="black", lw=0.8)
    label(soles, "height of both soles over the floor", "beat", "cm")
    lift.plot(time[part], 100 * corrected.lift[part, 0], color=AFTER, label="left foot")
    lift.plot(time[part], 100 * corrected.lift[part, 1], color=THIRD, label="right foot")
    label(lift, "how much they were lifted", "beat", "cm")
    return figure


def draw_mirror() -> Figure:
    step = sketch("kick", "long left")
    other = mirror_step(step)
    figure, axes = panels(
        3, f"mirror_step: {step.direction} becomes {other.direction}; left and right change places", [1, 1, 1]
    )
    for axis, beat in zip(axes[:2], (2.0, 4.0), strict=True):
        sample = int(np.argmin(np.abs(beats(step) - beat)))
        figure_of(axis, places(step)[sample], 0.0, BEFORE)
        figure_of(axis, places(other)[sample], 1.6, AFTER)
        stage(axis, f"beat {beat:g}", ("before", "after"), 1.6)
    footprints(axes[2], step, BEFORE, "before")
    footprints(axes[2], other, AFTER, "after")
    label(axes[2], "footprints from above", "x [m]", "z [m]")
    return figure


def draw_foot_lock() -> Figure:
    step = sketch("walk", "long forward")
    root = step.clip.root_position.copy()
    root[:, 0] += 0.25 * np.sin(np.pi * np.arange(len(root)) / step.samples_per_measure).astype(np.float32)
    dragged = replace(step, clip=replace(step.clip, root_position=root))
    locked = replace(dragged, clip=lock_feet(dragged.clip))
    figure, (plan, side, contacts) = panels(
        3, "lock_feet: a walk that is carried sideways, its feet held", [1, 1.4, 1.4]
    )
    part = within(step)
    for one, colour, name in ((dragged, BEFORE, "before"), (locked, AFTER, "after")):
        footprints(plan, one, colour, name)
        ball = find_feet(one.clip).ball[part, :, 0] * 100
        side.plot(beats(one)[part], ball, color=colour, lw=2, label=[name, "_"])
    label(plan, "footprints from above", "x [m]", "z [m]")
    label(side, "where both feet are, sideways", "beat", "cm")
    feet = find_feet(step.clip)
    for foot, (colour, name) in enumerate(((BEFORE, "left"), (THIRD, "right"))):
        contacts.plot(beats(step)[part], feet.height[part, foot] * 100, color=colour, lw=2, label=f"{name} sole")
        on = step.clip.contact[part, foot]
        contacts.fill_between(beats(step)[part], -1.6 + 0.8 * foot, -1.0 + 0.8 * foot, where=on, color=colour, lw=0)
    label(contacts, "soles, and contact as it was found (bars)", "beat", "cm")
    return figure


PICTURES: Final[dict[str, Callable[[], Figure]]] = {
    "interpolation": draw_interpolation,
    "combination": draw_combination,
    "variations": draw_variations,
    "rotation": draw_rotation,
    "measure-warp": draw_measure_warp,
    "sequence-warp": draw_wander,
    "amplitude": draw_amplitude,
    "orientation": draw_orientation,
    "head": draw_head,
    "floor": draw_floor,
    "foot-lock": draw_foot_lock,
    "mirror": draw_mirror,
}


def main() -> int:
    """Write all pictures and say how large they are."""
    folder = ROOT / "docs" / "pictures" / "editing"
    folder.mkdir(parents=True, exist_ok=True)
    for name, draw in PICTURES.items():
        data = io.BytesIO()
        draw().savefig(data, format="png", metadata={"Software": None})
        path = folder / f"{name}.png"
        Image.open(data).convert("RGB").quantize(64).save(path, optimize=True)
        print(f"{path.relative_to(ROOT)}: {path.stat().st_size} bytes")
        if path.stat().st_size > MAX_BYTES:
            print(f"larger than {MAX_BYTES} bytes", file=sys.stderr)
            return 1
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
