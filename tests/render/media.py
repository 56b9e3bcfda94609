"""Generated images and videos for tests."""

import json
import struct

import av
import numpy as np
from PIL import Image

FRAMES, RATE = 20, 10


def grey_of(number):
    """Grey level of a video picture, of 255."""
    return 20 + 10 * number


def write_video(path, *, size=(64, 48), codec="libx264", noise=False):
    """A video of FRAMES pictures, each of one grey, at RATE per second; `codec` "png": each picture alone."""
    with av.open(str(path), "w") as out:
        stream = out.add_stream(codec, rate=RATE, options={"crf": "1", "g": "5"} if codec == "libx264" else {})
        stream.width, stream.height, stream.pix_fmt = *size, "yuv420p" if codec == "libx264" else "rgb24"
        for number in range(FRAMES):
            pixels = np.full((size[1], size[0], 3), grey_of(number), np.uint8)
            if noise:  # larger files
                pixels = pixels + np.random.default_rng(number).integers(0, 8, pixels.shape, np.uint8)
            out.mux(stream.encode(av.VideoFrame.from_ndarray(pixels, format="rgb24")))
        out.mux(stream.encode())
    return path


def write_image(path, colour=(250, 40, 10), size=(64, 36)):
    """An image of one colour, whose upper left quarter is white."""
    pixels = np.full((size[1], size[0], 3), colour, np.uint8)
    pixels[: size[1] // 2, : size[0] // 2] = 255
    Image.fromarray(pixels).save(path)
    return path


def write_sequence(folder, *, name="pic_{:03d}.png", numbers=range(1, 11), size=(32, 24)):
    """Numbered images, each of one grey; the first has the grey of picture 0."""
    folder.mkdir(parents=True, exist_ok=True)
    for place, number in enumerate(numbers):
        Image.fromarray(np.full((size[1], size[0], 3), grey_of(place), np.uint8)).save(folder / name.format(number))
    return folder


def write_glb(path, meshes, *, materials=(), images=()):
    """A .glb file. `meshes`: dicts of `position` (V, 3), `triangle` (T, 3) and, if there are, `normal`, `uv`,
    `material`, `translation`, `scale`; `materials`: as in glTF; `images`: files' bytes (PNG)."""
    data, views, accessors = bytearray(), [], []

    def view(content):
        while len(data) % 4:
            data.append(0)
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(content)})
        data.extend(content)
        return len(views) - 1

    def accessor(values, kind, component):
        accessors.append({"bufferView": view(values.tobytes()), "componentType": component, "count": len(values),
                          "type": kind})  # fmt: skip
        if kind == "VEC3":
            accessors[-1] |= {"min": values.min(axis=0).tolist(), "max": values.max(axis=0).tolist()}
        return len(accessors) - 1

    nodes, written = [], []
    for number, mesh in enumerate(meshes):
        attributes = {"POSITION": accessor(np.asarray(mesh["position"], "<f4"), "VEC3", 5126)}
        if "normal" in mesh:
            attributes["NORMAL"] = accessor(np.asarray(mesh["normal"], "<f4"), "VEC3", 5126)
        if "uv" in mesh:
            attributes["TEXCOORD_0"] = accessor(np.asarray(mesh["uv"], "<f4"), "VEC2", 5126)
        index = accessor(np.asarray(mesh["triangle"], "<u4").reshape(-1, 1), "SCALAR", 5125)
        primitive = {"attributes": attributes, "indices": index}
        primitive |= {"material": mesh["material"]} if "material" in mesh else {}
        written.append({"primitives": [primitive]})
        nodes.append({"mesh": number} | {key: list(mesh[key]) for key in ("translation", "scale") if key in mesh})
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(len(nodes)))}], "nodes": nodes,
        "meshes": written, "materials": list(materials), "accessors": accessors,
        "images": [{"bufferView": view(each), "mimeType": "image/png"} for each in images],
        "textures": [{"source": number} for number in range(len(images))], "bufferViews": views,
        "buffers": [{"byteLength": len(data)}],
    }  # fmt: skip
    text = json.dumps({key: value for key, value in document.items() if value != []}).encode()
    text += b" " * (-len(text) % 4)
    data.extend(b"\0" * (-len(data) % 4))
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(data), 0x004E4942) + bytes(data)
    path.write_bytes(struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks)
    return path


def lathe(profile, sides=24):
    """A solid of revolution about the y axis: `profile` (P, 2) of radius and height, from below. A mesh of
    `write_glb` without normals."""
    profile = np.asarray(profile, float)
    angle = np.linspace(0.0, 2.0 * np.pi, sides + 1)
    around = np.stack([np.sin(angle), np.cos(angle)], axis=1)
    position = np.concatenate([np.column_stack([r * around[:, 0], np.full(sides + 1, y), r * around[:, 1]])
                               for r, y in profile])  # fmt: skip
    uv = np.concatenate([np.column_stack([angle / (2.0 * np.pi), np.full(sides + 1, 1.0 - n / (len(profile) - 1))])
                         for n in range(len(profile))])  # fmt: skip
    corners = []
    for row in range(len(profile) - 1):
        for side in range(sides):
            a, b = row * (sides + 1) + side, row * (sides + 1) + side + 1
            c, d = a + sides + 1, b + sides + 1
            corners += [(a, b, d), (a, d, c)]
    return {"position": position, "triangle": np.array(corners), "uv": uv}
