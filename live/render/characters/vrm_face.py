"""Expressions of VRM files (VRM 0.x blend shape groups, VRM 1.0 expressions), and names of blend shapes."""

import contextlib
from collections.abc import Mapping
from itertools import islice
from typing import Final

from live.motion.formats.file_error import MotionFileError
from live.motion.formats.gltf_document import JsonObject
from live.motion.formats.gltf_skeleton import NodeTree
from live.render.characters.expressions import VRM_0_PRESETS, Bind, Expressions, find_expressions

TARGET_LIMIT: Final = 1000
"""Maximum number of blend shapes of one mesh, and of one expression, that are looked at."""


def expressions_of(root: JsonObject, nodes: NodeTree) -> Expressions:
    """Return the blend shapes that faces move; MotionFileError for references that lead nowhere."""
    names = {number: _target_names(mesh) for number, mesh in enumerate(root.elements("meshes"))}
    counts = {number: len(targets) for number, targets in names.items()}
    return find_expressions(names, _presets(root, nodes, counts))


def _target_names(mesh: JsonObject) -> list[str]:
    """Return the names of a mesh's blend shapes: from its extras, else from those of its first primitive."""
    primitives = list(mesh.elements("primitives"))
    count = max((primitive.length("targets") for primitive in primitives), default=0)
    for place in (mesh, *primitives[:1]):
        if place.has("extras"):
            names = []
            with contextlib.suppress(MotionFileError):  # extras may be anything
                names = place.object("extras").texts("targetNames")
            if names:
                return (names + [""] * count)[: min(count, TARGET_LIMIT)]
    return [""] * min(count, TARGET_LIMIT)


def _presets(root: JsonObject, nodes: NodeTree, counts: Mapping[int, int]) -> dict[str, tuple[Bind, ...]]:
    extensions = root.object("extensions") if root.has("extensions") else None
    if extensions is None:
        return {}
    if extensions.has("VRMC_vrm"):
        return _presets_1(extensions.object("VRMC_vrm"), nodes, counts)
    if extensions.has("VRM"):
        return _presets_0(extensions.object("VRM"), counts)
    return {}


def _presets_1(vrm: JsonObject, nodes: NodeTree, counts: Mapping[int, int]) -> dict[str, tuple[Bind, ...]]:
    if not vrm.has("expressions") or not vrm.object("expressions").has("preset"):
        return {}
    presets, found = vrm.object("expressions").object("preset"), {}
    for name in presets.names():
        binds = []
        for row in islice(presets.object(name).elements("morphTargetBinds"), TARGET_LIMIT):
            place = nodes.json_object(row.integer("node", below=nodes.count))
            if not place.has("mesh"):
                continue
            mesh = place.integer("mesh", below=len(counts))
            index = row.integer("index", below=max(counts[mesh], 1))
            binds.append(((mesh, index), min(max(row.number("weight", 1.0), 0.0), 1.0)))
        found[name] = tuple(binds)
    return found


def _presets_0(vrm: JsonObject, counts: Mapping[int, int]) -> dict[str, tuple[Bind, ...]]:
    if not vrm.has("blendShapeMaster"):
        return {}
    found: dict[str, tuple[Bind, ...]] = {}
    for group in vrm.object("blendShapeMaster").elements("blendShapeGroups"):
        preset = group.text("presetName").lower()
        name = preset if preset not in ("", "unknown") else group.text("name").lower()
        binds = []
        for row in islice(group.elements("binds"), TARGET_LIMIT):
            mesh = row.integer("mesh", below=len(counts))
            index = row.integer("index", below=max(counts[mesh], 1))
            binds.append(((mesh, index), min(max(row.number("weight", 100.0) / 100.0, 0.0), 1.0)))
        if binds:
            found.setdefault(VRM_0_PRESETS.get(name, name), tuple(binds))
    return found
