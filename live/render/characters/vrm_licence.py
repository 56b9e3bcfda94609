"""VRM metadata: author and permissions, first-person meshes, humanoid bones."""

from typing import Final

from live.motion.formats.gltf_document import JsonObject
from live.motion.formats.gltf_skeleton import NodeTree

_META_0: Final = {
    "title": "title", "version": "version", "author": "author", "contact": "contactInformation",
    "who may perform": "allowedUserName", "commercial use": "commercialUssageName",
    "violent performances": "violentUssageName", "sexual performances": "sexualUssageName",
    "licence": "licenseName", "licence text": "otherLicenseUrl", "other conditions": "otherPermissionUrl",
}  # fmt: skip
_META_1: Final = {
    "title": "name", "version": "version", "copyright": "copyrightInformation", "contact": "contactInformation",
    "who may perform": "avatarPermission", "commercial use": "commercialUsage", "credit": "creditNotation",
    "redistribution": "allowRedistribution", "changes": "modification", "licence": "licenseUrl",
    "other conditions": "otherLicenseUrl",
}  # fmt: skip


def kind_of(root: JsonObject) -> str:
    """Return `VRM 1.0`, `VRM 0.x` or `glTF`."""
    extensions = root.object("extensions") if root.has("extensions") else None
    if extensions is not None and extensions.has("VRMC_vrm"):
        return "VRM 1.0"
    return "VRM 0.x" if extensions is not None and extensions.has("VRM") else "glTF"


def _vrm(root: JsonObject) -> JsonObject | None:
    kind = kind_of(root)
    return None if kind == "glTF" else root.object("extensions").object("VRMC_vrm" if kind == "VRM 1.0" else "VRM")


def bones_of(root: JsonObject, nodes: NodeTree) -> dict[str, int]:
    """Return the nodes of humanoid bones by name; empty if the file is not a VRM."""
    vrm = _vrm(root)
    if vrm is None or not vrm.has("humanoid"):
        return {}
    humanoid = vrm.object("humanoid")
    if kind_of(root) == "VRM 1.0":
        bones = humanoid.object("humanBones")
        return {bone: bones.object(bone).integer("node", below=nodes.count) for bone in bones.names()}
    rows = [row for row in humanoid.elements("humanBones") if row.text("bone")]
    return {row.text("bone"): row.integer("node", below=nodes.count) for row in rows}


def first_person(root: JsonObject, nodes: NodeTree) -> tuple[frozenset[int], frozenset[int]]:
    """Return meshes and nodes that are only for the first-person view."""
    vrm = _vrm(root)
    if vrm is None or not vrm.has("firstPerson"):
        return frozenset(), frozenset()
    rows = list(vrm.object("firstPerson").elements("meshAnnotations"))
    count = root.length("meshes")
    meshes = {
        row.integer("mesh", below=count)
        for row in rows
        if row.text("firstPersonFlag") == "FirstPersonOnly" and row.has("mesh")
    }
    own = {row.integer("node", below=nodes.count) for row in rows if row.text("type") == "firstPersonOnly"}
    return frozenset(meshes), frozenset(own)


def licence_of(root: JsonObject) -> dict[str, str]:
    """Return the file's metadata about author and permissions, in its own words."""
    found: dict[str, str] = {}
    vrm = _vrm(root)
    if vrm is not None and vrm.has("meta"):
        meta = vrm.object("meta")
        rows = _META_1 if kind_of(root) == "VRM 1.0" else _META_0
        for words, key in rows.items():
            said = meta.text(key) or ("yes" if meta.flag(key) else "")
            if said:
                found[words] = said
        authors = meta.texts("authors")
        if authors:
            found["author"] = ", ".join(authors)
    asset = root.object("asset")
    for words, key in (("copyright", "copyright"), ("made with", "generator")):
        if asset.text(key) and words not in found:
            found[words] = asset.text(key)
    return {words: " ".join(said.split())[:300] for words, said in found.items()}
