"""Picture of a character in three moments of a step, side by side, rendered as in a show."""

from pathlib import Path

import numpy as np

from live.app.offline.step_listing import named_steps
from live.base.arrays import Float32, Int64
from live.base.body.catalogue import CharacterFile
from live.base.body.expression import CURL, SMILE
from live.base.errors import PersonError
from live.base.stage_snapshot import Camera, Scene, StageView
from live.clock.ticks import TICK
from live.library.whole_file import write_atomically
from live.motion import quaternion
from live.motion.cloth.spring_kernels import swing
from live.motion.cloth.spring_rig import SpringRig
from live.motion.forward_kinematics import forward_kinematics
from live.motion.skeleton import JOINT_COUNT, SKELETON
from live.motion.step_clip import StepClip
from live.render.adaptive_quality import HARDWARE
from live.render.characters.character import load_character
from live.render.headless import NoOpenGL, OffscreenTarget, create_headless_context, release_headless_context
from live.render.renderer import Renderer

MOMENTS = 3
_HANDS = np.array([0.15, 0.4, 0.25])[:, None, None]
"""Curl of the fingers in each moment."""
_BEAT = 0.5
"""Length of a beat [s] for what swings."""
_SMILES = (0.2, 0.6, 0.0)
_REST = np.ascontiguousarray(SKELETON.rest_positions(), np.float32)
_APART = 1.6
_TURNS = (18.0, -28.0, 150.0)
"""Heading in each moment [degrees]; the last one shows the back."""


def draw_character(character: CharacterFile, out: Path, step: str | None, size: tuple[int, int]) -> None:
    """Draw the character in `step` (None: the first step) to a PNG file; raise PersonError if that fails."""
    from io import BytesIO

    from PIL import Image

    view = _view_of_step(_step(step), load_character(character).springs.rig)
    camera = Camera(eye=(0.0, 1.5, 7.4), target=(0.0, 0.92, 0.0), field_of_view_deg=22.0)
    scene = Scene(
        (10.0, 7.0), camera, MOMENTS, JOINT_COUNT, bodies=(character.name,) * MOMENTS, characters=(character,)
    )
    try:
        ctx = create_headless_context()
    except NoOpenGL as error:
        raise PersonError(str(error)) from None
    try:
        target = OffscreenTarget(ctx, size)
        renderer = Renderer(ctx, scene, size=size, quality=HARDWARE)
    except ValueError as error:
        raise PersonError(str(error)) from None
    renderer.draw(view, target.framebuffer)
    png = BytesIO()
    Image.fromarray(target.read()).save(png, "PNG")
    for thing in (renderer, target):
        thing.release()
    release_headless_context(ctx)
    write_atomically(png.getvalue(), out, "--out")


def _step(name: str | None) -> StepClip:
    steps = named_steps(None)
    wanted = [step for step in steps if name is None or step.name.casefold() == name.strip().casefold()]
    if not wanted:
        known = ", ".join(sorted(step.name for step in steps)[:12])
        raise PersonError(f"--step {name!r}: there is no such step", f"there are: {known}")
    return wanted[0].clips[0]


def _view_of_step(step: StepClip, rig: SpringRig) -> StageView:
    view = StageView.allocate(MOMENTS, JOINT_COUNT)
    view.hand[..., CURL], view.face[:, SMILE] = _HANDS, _SMILES
    samples = step.first + step.samples_per_measure * (np.arange(MOMENTS) + 0.5) / MOMENTS
    rows = np.clip(np.rint(samples).astype(int), 0, step.clip.sample_count - 1)
    places, turns = forward_kinematics(
        step.clip.root_position[rows].astype(np.float64), step.clip.rotation[rows].astype(np.float64)
    )
    for moment, degrees in enumerate(_TURNS):
        turn = quaternion.from_axis_angle(np.array([0.0, 1.0, 0.0]), np.radians(degrees))
        own = places[moment] - places[moment, 0] * (1.0, 0.0, 1.0)
        own = quaternion.rotate(turn, own)
        own[:, 0] += (moment - 0.5 * (MOMENTS - 1)) * _APART
        view.joint_position[moment] = own
        view.joint_rotation[moment] = quaternion.mul(turn, turns[moment])
        view.group[moment] = moment % 3
    view.spring, view.spring_slot = _springs(step, rig, rows), np.arange(MOMENTS, dtype=np.int32)
    return view


def _springs(step: StepClip, rig: SpringRig, rows: Int64) -> Float32:
    """Return the rotations of swinging bones at samples `rows` (n,) of the step, which is danced from its beginning."""
    found = np.zeros((len(rows), rig.count, 4), np.float32)
    tips, tips_before = (np.zeros((1, rig.count, 3), np.float32) for _ in range(2))
    turn, start = np.zeros((1, rig.count, 4), np.float32), np.ones(1, np.uint8)
    rate = step.samples_per_measure / (step.beats_per_measure * _BEAT)
    samples = np.arange(0.0, rows.max() + 1.0, rate * TICK)
    for sample in samples.tolist() if rig.count else ():
        row = min(int(sample + 0.5), step.clip.sample_count - 1)
        places, turns = forward_kinematics(
            step.clip.root_position[row : row + 1].astype(np.float64),
            step.clip.rotation[row : row + 1].astype(np.float64),
        )
        swing(
            np.ascontiguousarray(places, np.float32), np.ascontiguousarray(turns, np.float32), _REST, rig.parent,
            rig.joint, rig.centre, rig.head, rig.tail, rig.setting, rig.hits, rig.collider_joint, rig.collider, start,
            TICK, tips, tips_before, turn,
        )  # fmt: skip
        start[:] = 0
        found[rows >= sample - 1e-9] = turn[0]
    return found
