"""Dual-quaternion skinning keeps the limb volume at bent joints, in the Python formula and in the shader."""

from dataclasses import replace
from functools import cache
from itertools import pairwise

import moderngl
import numpy as np
import pytest

from live.base.body.catalogue import BODIES, DEFAULT_BODY
from live.motion.skeleton import SKELETON
from live.render.adaptive_quality import SOFTWARE
from live.render.body.body_mesh import DISTANT, FINE, LIGHT, build_body
from live.render.body.body_variants import parts_of
from live.render.body.drawn_joints import ANCHORS
from live.render.body.implicit_surface import Shape
from live.render.dancers.dancer_batch import DancerBatch, attribute_layout, vertex_bytes
from live.render.shader import source
from tests.render.body.detail_motion import drawn_motions
from tests.render.poses import pose, quaternion, stage_view
from tests.render.test_renderer import scene

MOST = 0.049
"""Share of the limb volume, from the middle of one bone to the middle of the next, that may be lost."""
BENT = {"elbow": {"leftLowerArm": (0, -90, 0)}, "knee": {"leftLowerLeg": (120, 0, 0)}}
BOXES = {
    "elbow": ((0.2975, 0.5525), (1.28, 1.48), (-0.11, 0.09)),
    "knee": ((0.0, 0.2), (0.2825, 0.6825), (-0.12, 0.12)),
}


@cache
def limb_volume(name, joint, step=0.01):
    """Volume [l] of the limb around a joint, within a twentieth, sampled from the implicit shape without the mesh."""
    axes = [np.arange(low + step / 2, high, step) for low, high in BOXES[joint]]
    places = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    return 1000.0 * float((Shape(parts_of(name)).distance(places) < 0.0).sum()) * step**3


def litres(mesh, places):
    a, b, c = (places[mesh.triangle[:, corner]].astype(np.float64) for corner in range(3))
    return 1000.0 * float((np.cross(a, b) * c).sum()) / 6.0


def _quaternion(turn):
    w, *v = quaternion(turn)
    return np.array([*v, w])


def skin_mesh(mesh, turns):
    """A pose's vertices in double precision."""
    return skinned_by(mesh, *drawn_motions(*pose(turns)))


def skinned_by(mesh, turns_of, moves):
    """Dual-quaternion skinning (Kavan et al. 2007)."""
    real = np.array([_quaternion(turn) for turn in turns_of])
    u, w = real[:, :3], real[:, 3:]
    dual = 0.5 * np.concatenate([moves * w + np.cross(moves, u), -(moves * u).sum(axis=1, keepdims=True)], axis=1)
    joints = np.stack([real, dual], axis=1)
    real, dual = joints[mesh.joint, 0], joints[mesh.joint, 1]
    weight = np.where((real * real[:, :1]).sum(axis=-1) < 0.0, -1.0, 1.0) * np.rint(mesh.weight * 255.0)
    real, dual = ((part * weight[..., None]).sum(axis=1) for part in (real, dual))
    scale = np.linalg.norm(real, axis=1, keepdims=True)
    real, dual = real / scale, dual / scale
    v, u = mesh.position.astype(np.float64), real[:, :3]
    turn = 2.0 * np.cross(u, v)
    moved = 2.0 * (real[:, 3:] * dual[:, :3] - dual[:, 3:] * u + np.cross(u, dual[:, :3]))
    return v + real[:, 3:] * turn + np.cross(u, turn) + moved


@pytest.mark.parametrize("joint", BENT)
@pytest.mark.parametrize(("level", "name"), [(LIGHT, one) for one in BODIES] + [(FINE, DEFAULT_BODY), (FINE, "strong")])
def test_bent_joint_keeps_volume_for_every_body(level, name, joint):
    mesh = build_body(level, name)
    loss = litres(mesh, skin_mesh(mesh, {})) - litres(mesh, skin_mesh(mesh, BENT[joint]))
    assert abs(loss) < MOST * limb_volume(name, joint)


def test_linear_blend_skinning_loses_more_volume_than_allowed():
    """The limit can fail: linear blend skinning loses more of the fine knee than allowed."""
    mesh = build_body(FINE)
    position, rotation = pose(BENT["knee"])
    rest = SKELETON.rest_positions().astype(np.float64)
    w, u = rotation[:, :1].astype(np.float64), rotation[:, 1:].astype(np.float64)
    skeletal = np.concatenate([np.arange(len(SKELETON.names)), ANCHORS])[mesh.joint]
    v = mesh.position[:, None, :] - rest[skeletal]
    turn = 2.0 * np.cross(u[skeletal], v)
    each = position[skeletal] + v + w[skeletal] * turn + np.cross(u[skeletal], turn)
    places = (each * mesh.weight[..., None]).sum(axis=1)
    assert litres(mesh, skin_mesh(mesh, {})) - litres(mesh, places) > MOST * limb_volume(DEFAULT_BODY, "knee")


@pytest.mark.gl
@pytest.mark.parametrize("joint", BENT)
@pytest.mark.parametrize("level", [LIGHT, DISTANT])
@pytest.mark.parametrize(
    "text",
    [
        source("skin.glsl") + "out vec3 seen;\nvoid main() { seen = skinned(in_position, in_normal).place; }\n",
        source("skinned.glsl") + "out vec3 seen;\nvoid main() { seen = skinned().place; }\n",
    ],
    ids=["while drawn", "once for all passes"],
)
def test_shader_skinning_matches_formula(gl_context, level, joint, text):
    """Transform feedback from the shaders that draw the dancers, against the formula in Python."""
    mesh = build_body(level)
    linked = gl_context.program(vertex_shader=text, varyings=["seen"])
    crowd = DancerBatch(gl_context, scene(2), replace(SOFTWARE, near_level=level), (64, 64))
    crowd.update(
        stage_view([({}, (1.0, 0.0), 0.0, 0), (BENT[joint], (0.0, 0.0), 0.0, 0)]), np.array([0, 1, 0], np.float32)
    )
    crowd.skin()
    form, names = attribute_layout(linked)
    vertices = gl_context.buffer(vertex_bytes(mesh))
    both = [(vertices, form, *names)] if names else []
    array = gl_context.vertex_array(linked, [*both, crowd.instances(linked, "near", 0)])
    out = gl_context.buffer(reserve=2 * 12 * len(mesh.position))
    crowd.bind_program(linked)
    bound = gl_context.simple_framebuffer((4, 4))  # without a screen there is none to begin with
    bound.use()
    array.transform(out, moderngl.POINTS, vertices=len(mesh.position), instances=2)
    seen = np.frombuffer(out.read(), np.float32).reshape(2, -1, 3)[1]
    here = skin_mesh(mesh, BENT[joint])
    here += seen.mean(axis=0) - here.mean(axis=0)  # the view sets her hips in the middle
    np.testing.assert_allclose(seen, here, atol=2e-4)
    if level == LIGHT:
        assert abs(litres(mesh, seen) - litres(mesh, skin_mesh(mesh, {}))) < MOST * limb_volume(DEFAULT_BODY, joint)
    for thing in (array, out, vertices, linked, crowd, bound):
        thing.release()


def test_normals_survive_the_octahedron(gl_context):
    """All directions in one mesh's normals, in the rest pose: within a ten-thousandth of what they were."""
    mesh = build_body(FINE)
    text = source("skinned.glsl") + "out vec3 seen;\nvoid main() { seen = skinned().normal; }\n"
    linked = gl_context.program(vertex_shader=text, varyings=["seen"])
    crowd = DancerBatch(gl_context, scene(1), replace(SOFTWARE, near_level=FINE), (64, 64))
    crowd.update(stage_view([({}, (0.0, 0.0), 0.0, 0)]), np.array([0, 1, 0], np.float32))
    crowd.skin()
    array = gl_context.vertex_array(linked, [crowd.instances(linked, "near", 0)])
    out = gl_context.buffer(reserve=12 * len(mesh.position))
    crowd.bind_program(linked)
    bound = gl_context.simple_framebuffer((4, 4))
    bound.use()
    array.transform(out, moderngl.POINTS, vertices=len(mesh.position), instances=1)
    seen = np.frombuffer(out.read(), np.float32).reshape(-1, 3)
    np.testing.assert_allclose(np.linalg.norm(seen, axis=1), 1.0, atol=1e-5)
    np.testing.assert_allclose(seen, mesh.normal, atol=1e-4)
    for thing in (array, out, linked, crowd, bound):
        thing.release()


@pytest.mark.parametrize(
    ("turns", "root", "along", "end"),
    [
        ({"leftUpperLeg": (0, 80, 0)}, (0.09, 0.890, 0.0), 1, 0.475),
        ({"leftUpperArm": (80, 0, 0)}, (0.165, 1.380, -0.010), 0, 0.430),
        ({"leftHand": (80, 0, 0)}, (0.430, 1.380, -0.010), 0, 0.675),
    ],
    ids=["turned-out thigh", "turned upper arm", "turned hand"],
)
def test_twist_is_spread_along_the_limb_and_keeps_volume(turns, root, along, end):
    """The skin's turn about the bone grows from the near joint to the far one, without a step and without a waist."""
    mesh = build_body(FINE)
    there, rest = skin_mesh(mesh, turns), mesh.position.astype(np.float64)
    part = (rest[:, along] - root[along]) / (end - root[along])
    across = [axis for axis in range(3) if axis != along]
    off = (rest - root)[:, across]
    near = (part > 0.12) & (part < 0.95) & (np.linalg.norm(off, axis=1) < 0.1) & (rest[:, 0] > 0.02)
    angle = np.degrees(
        np.arctan2(*(there - root)[:, across][:, ::-1].T) - np.arctan2(*off[:, ::-1].T)
    )  # about the bone
    angle = np.abs((angle + 180.0) % 360.0 - 180.0)
    mean = [float(angle[near & (part >= low) & (part < low + 0.2)].mean()) for low in (0.12, 0.32, 0.52, 0.72)]
    assert all(a < b + 4.0 for a, b in pairwise(mean)), mean
    assert mean[0] < 40.0 < mean[-1], mean
    assert abs(litres(mesh, rest) - litres(mesh, there)) < 0.012 * litres(mesh, rest)


def test_muscles_swell_where_they_shorten():
    mesh = build_body(FINE)
    rest = mesh.position.astype(np.float64)
    for turns, still, middle, way, least in (
        ({"leftLowerArm": (0, -120, 0)}, {}, (0.300, 1.382, 0.030), (0.0, 0.0, 1.0), 0.004),
        ({"leftFoot": (60, 0, 0)}, {}, (0.090, 0.355, -0.064), (0.0, 0.0, -1.0), 0.004),
    ):
        number = np.linalg.norm(rest - middle, axis=1).argmin()
        moved = (skin_mesh(mesh, turns) - skin_mesh(mesh, still))[number]
        moved -= (pose(turns)[0] - pose(still)[0])[SKELETON.index("hips")]  # the pose stands on the floor
        assert moved @ way > least
