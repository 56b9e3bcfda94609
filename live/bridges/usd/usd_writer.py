"""Writer for USD: each dancer is a UsdSkel skeleton with an animation and a skinned mesh."""

import re
import tempfile
from pathlib import Path
from typing import Any, Final

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, UsdSkel, Vt

from live.motion.formats.bone_mesh import bone_mesh
from live.motion.formats.gltf_writer import GENERATOR
from live.motion.formats.stage_motion import DancerMotion, FigureMesh, StageMotion
from live.motion.skeleton import JOINT_COUNT, SKELETON

_NOT_IN_NAMES: Final = re.compile(r"[^A-Za-z0-9_]")
_ONES: Final = Vt.Vec3hArray(JOINT_COUNT, Gf.Vec3h(1.0))


def write_usd(motion: StageMotion, suffix: str) -> bytes:
    """Return the dancers of a show as a USD file, text for ".usda", else binary.

    Metres, Y up; a time code for each frame, from 0 on, at the motion's rate. /show has a SkelRoot for each dancer, who
    is invisible while not on the stage; the group stands in its custom data. The joints have VRM names; they rest in
    the T-pose.
    """
    layer = Sdf.Layer.CreateAnonymous(".usda" if suffix == ".usda" else ".usdc")
    stage: Any = Usd.Stage.Open(layer)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    stage.SetTimeCodesPerSecond(motion.sample_rate)
    stage.SetFramesPerSecond(motion.sample_rate)
    stage.SetStartTimeCode(0)
    stage.SetEndTimeCode(motion.sample_count - 1)
    stage.SetMetadata("comment", f"{motion.name}, by {GENERATOR}")
    show = UsdGeom.Xform.Define(stage, "/show")
    stage.SetDefaultPrim(show.GetPrim())
    bones = bone_mesh()
    materials = {colour: _add_material(stage, n, colour) for n, colour in enumerate(_colours(motion), start=1)}
    for dancer in motion.dancers:
        _add_dancer(stage, dancer, dancer.figure or bones, materials[dancer.colour])
    if suffix == ".usda":
        return str(layer.ExportToString()).encode()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "show.usdc")
        layer.Export(str(path))
        return path.read_bytes()


def _colours(motion: StageMotion) -> list[tuple[float, float, float]]:
    return list(dict.fromkeys(dancer.colour for dancer in motion.dancers))


def _add_material(stage: Any, number: int, colour: tuple[float, float, float]) -> Any:
    """Return a new material with this colour."""
    material = UsdShade.Material.Define(stage, f"/show/materials/clothes_{number}")
    shader = UsdShade.Shader.Define(stage, f"/show/materials/clothes_{number}/surface")
    shader.CreateIdAttr("UsdPreviewSurface")
    shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(*colour))
    shader.CreateInput("roughness", Sdf.ValueTypeNames.Float).Set(0.8)
    material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    return material


def _add_dancer(stage: Any, dancer: DancerMotion, figure: FigureMesh, material: Any) -> None:
    place = f"/show/{_NOT_IN_NAMES.sub('_', dancer.name)}"
    root = UsdSkel.Root.Define(stage, place)
    root.GetPrim().SetCustomDataByKey("group", dancer.group)
    if not dancer.present.all():
        visibility = root.CreateVisibilityAttr()
        for sample in dancer.presence_changes().tolist():
            seen = UsdGeom.Tokens.inherited if dancer.present[sample] else UsdGeom.Tokens.invisible
            visibility.Set(seen, sample)
    skeleton = UsdSkel.Skeleton.Define(stage, f"{place}/skeleton")
    joints = _joint_paths()
    skeleton.CreateJointsAttr(joints)
    skeleton.CreateBindTransformsAttr(_translations(SKELETON.rest_positions()))
    skeleton.CreateRestTransformsAttr(_translations(SKELETON.offsets))
    animation = UsdSkel.Animation.Define(stage, f"{place}/skeleton/motion")
    animation.CreateJointsAttr(joints)
    _write_poses(animation, dancer)
    UsdSkel.BindingAPI.Apply(skeleton.GetPrim()).CreateAnimationSourceRel().SetTargets([animation.GetPath()])
    _add_figure(stage, f"{place}/figure", figure, dancer, skeleton, material)


def _joint_paths() -> Any:
    """Return the joints' paths from the hips on, as UsdSkel names them."""
    paths: list[str] = []
    for joint, name in enumerate(SKELETON.names):
        parent = int(SKELETON.parents[joint])
        paths.append(name if parent < 0 else f"{paths[parent]}/{name}")
    return Vt.TokenArray(paths)


def _translations(places: Any) -> Any:
    """Return matrices that move to `places` (J, 3) [m]."""
    return Vt.Matrix4dArray([Gf.Matrix4d(1.0).SetTranslate(Gf.Vec3d(*map(float, place))) for place in places])


def _write_poses(animation: Any, dancer: DancerMotion) -> None:
    """Write translations, rotations and scales of all joints: what does not change has one value, the rest one for each
    frame."""
    clip = dancer.clip
    rotation = dancer.rotation_xyzw()  # as GfQuatf lies in memory
    place = np.tile(SKELETON.offsets.astype(np.float32), (clip.sample_count, 1, 1))
    place[:, 0] = clip.root_position
    translations, rotations = animation.CreateTranslationsAttr(), animation.CreateRotationsAttr()
    animation.CreateScalesAttr(_ONES)
    for sample in range(clip.sample_count):
        translations.Set(Vt.Vec3fArray.FromNumpy(place[sample]), sample)
        rotations.Set(Vt.QuatfArray.FromNumpy(rotation[sample]), sample)


def _add_figure(stage: Any, path: str, figure: FigureMesh, dancer: DancerMotion, skeleton: Any, material: Any) -> None:
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(figure.positions)))
    mesh.CreateNormalsAttr(Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(figure.normals)))
    mesh.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray(len(figure.indices) // 3, 3))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(figure.indices.astype(np.int32)))
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    mesh.CreateDisplayColorAttr([Gf.Vec3f(*dancer.colour)])
    binding = UsdSkel.BindingAPI.Apply(mesh.GetPrim())
    binding.CreateSkeletonRel().SetTargets([skeleton.GetPath()])
    count = figure.joints.shape[1]
    binding.CreateJointIndicesPrimvar(False, count).Set(Vt.IntArray.FromNumpy(figure.joints.ravel().astype(np.int32)))
    binding.CreateJointWeightsPrimvar(False, count).Set(Vt.FloatArray.FromNumpy(figure.weights.ravel()))
    UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(material)
