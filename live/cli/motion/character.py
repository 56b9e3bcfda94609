"""Command `live character`: prints facts of a character model and the bones found, and can draw it dancing."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from live.render.characters.character import Character


def character(
    file: Annotated[Path, typer.Argument(help="A .glb, .gltf or .vrm file.", metavar="FILE")],
    out: Annotated[Path | None, typer.Option(help="Draw it dancing and write the picture.", metavar="FILE.png")] = None,
    step: Annotated[str | None, typer.Option(help="The step to draw. Default: the first.")] = None,
    joint: Annotated[
        list[str] | None,
        typer.Option(help="Map a joint to a bone that is not found by name; may be repeated.", metavar="JOINT=BONE"),
    ] = None,
    size: Annotated[str, typer.Option(help="Width and height of the picture.", metavar="WxH")] = "1280x720",
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object instead.")] = False,
) -> None:
    """Inspect a character file: bones, fingers, face, springs, triangles, images, size, licence.

    In a patch, add a [[character]] with this file and, if needed, joints = { JOINT = "BONE" }.
    """
    import json

    from rich.console import Console

    from live.app.machine.kernel_warmup import warm_kernels
    from live.app.option_values import check_writable, parse_size
    from live.base.body.catalogue import CharacterFile
    from live.base.errors import PersonError
    from live.motion.skeleton import SKELETON

    check_writable(out, "--out")
    if out is not None and out.suffix.lower() != ".png":
        raise PersonError(f"--out {out}: a name that ends in .png expected", f"--out {out.stem}.png")
    console = Console(highlight=False)
    warm_kernels(Console(stderr=True, highlight=False))
    from live.render.characters.character import load_character

    said = CharacterFile(file.stem, str(file), tuple(_parse_joint(each, SKELETON.names) for each in joint or ()))
    loaded = load_character(said)
    if as_json:
        print(json.dumps(character_facts(loaded)))
    else:
        for line in _describe(loaded):
            console.print(line, soft_wrap=True, markup=False)
    if out is not None:
        from live.app.pictures.character_picture import draw_character

        draw_character(said, out, step, parse_size(size))
        if not as_json:
            console.print(f"picture written: {out.resolve()}", soft_wrap=True, markup=False)


def _parse_joint(text: str, names: tuple[str, ...]) -> tuple[str, str]:
    from live.base.errors import PersonError

    joint, _, bone = text.partition("=")
    if joint.strip() not in names or not bone.strip():
        raise PersonError(f"--joint {text!r}: JOINT=BONE expected", f"JOINT is one of {', '.join(names)}")
    return joint.strip(), bone.strip()


def character_facts(loaded: "Character") -> dict[str, Any]:
    """Return the facts of a character as plain values."""
    from live.render.body.body_mesh import CLOSE, COARSE, FINE, LIGHT

    model = loaded.model
    return {
        "file": model.file,
        "kind": model.kind,
        "bytes": model.size,
        "height_m": round(loaded.fitted.height, 3),
        "farthest_joint_m": round(loaded.fitted.max_joint_offset, 3),
        "triangles": [len(loaded.levels[level].body.triangle) for level in (FINE, CLOSE, LIGHT, COARSE)],
        "triangles_in_file": model.triangle_count,
        "images": sum(image is not None for image in model.images),
        "image_pixels": int(loaded.layers.shape[1]),
        "materials": [material.name for material in model.materials],
        "joints": {name: None if node is None else model.names[node] for name, node in loaded.joints.items()},
        "fingers": {name: [model.names[node] for node in chain] for name, chain in loaded.details.fingers.items()},
        "face_bones": {name: model.names[node] for name, node in loaded.details.face.items()},
        "expressions": list(loaded.channels),
        "springs": {
            "source": loaded.springs.source,
            "bones": [model.names[node] for node in loaded.springs.nodes],
            "colliders": len(loaded.springs.rig.collider),
        },
        "missing": _missing(loaded),
        "licence": model.licence,
        "notes": list(model.notes),
    }


def _missing(loaded: "Character") -> list[str]:
    """Return what a character lacks for its hands and face, in words."""
    from live.render.characters.expressions import CHANNEL_NAMES

    shaped = {"leftEye": "lookLeft", "rightEye": "lookRight", "jaw": "mouthOpen"}
    lost = [name for name in loaded.details.missing if shaped.get(name, name) not in loaded.channels]
    lid = any(name.endswith("Lid") for name in loaded.details.face)
    wanted = [name for name in CHANNEL_NAMES if not name.startswith("look") and name not in ("mouthOpen", "effort")]
    return lost + [name for name in wanted if name not in loaded.channels and not (lid and name.startswith("blink"))]


def _counted(names: list[str], shown: int = 4) -> str:
    more = f" and {len(names) - shown} more" if len(names) > shown else ""
    return ", ".join(names[:shown]) + more


def _describe_details(told: dict[str, Any]) -> list[str]:
    """Return lines about fingers, face and springs."""
    fingers, springs = told["fingers"], told["springs"]
    lines = [
        f"  fingers: {len(fingers)} of 10"
        + (": " + _counted([f"{name} = {' '.join(chain)}" for name, chain in fingers.items()], 2) if fingers else ""),
        "  face: "
        + (", ".join(f"{name} = {bone}" for name, bone in told["face_bones"].items()) or "no bones")
        + ("; blend shapes: " + ", ".join(told["expressions"]) if told["expressions"] else "; no blend shapes"),
        "  springs: "
        + (
            f"{len(springs['bones'])} bones ({_counted(springs['bones'])}), from {springs['source']}, "
            f"{springs['colliders']} colliders"
            if springs["bones"]
            else "none; hair and skirts move with the body"
        ),
    ]
    return lines + ([f"  missing: {', '.join(told['missing'])}; these do not move"] if told["missing"] else [])


def _describe(loaded: "Character") -> list[str]:
    told, model = character_facts(loaded), loaded.model
    found = {name: bone for name, bone in told["joints"].items() if bone is not None}
    missing = [name for name in told["joints"] if name not in found]
    unit = " (taken for centimetres)" if loaded.fitted.height > 20 else ""
    lines = [
        f"{model.file}: {model.kind}, {model.size / 1e6:.1f} MB, {loaded.fitted.height:.2f} high{unit}",
        f"  triangles: {told['triangles_in_file']}, drawn with {', '.join(map(str, told['triangles']))} "
        "(near, close by, light, shadows)",
        f"  images: {told['images']}, drawn at {told['image_pixels']} x {told['image_pixels']} pixels",
        f"  materials: {', '.join(told['materials']) or 'none'}",
        f"  bones: {len(found)} of {len(told['joints'])} joints found"
        + (f"; without {', '.join(missing)}, which are synthesised" if missing else ""),
        "    " + ", ".join(f"{name} = {bone}" for name, bone in found.items()),
        *_describe_details(told),
        f"  proportions: joints are at most {told['farthest_joint_m'] * 100:.0f} cm from the dancer's",
    ]
    lines += [f"  {words}: {said}" for words, said in model.licence.items()] or ["  licence: none in the file"]
    return lines + [f"  note: {note}" for note in model.notes]
