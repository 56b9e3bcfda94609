"""Tests of broken and hostile glTF files: a motion or a one-line error with its place; bounded memory and time."""

import copy
import json
import random
import time
import tracemalloc
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from live.motion.formats.file_error import MotionFileError
from live.motion.formats.gltf_reader import parse_gltf
from live.motion.retarget.retarget import retarget
from tests.fixtures.mostly_long import mostly_long
from tests.motion.formats.made_gltf import MadeGltf, made_avatar, pack_glb, random_rotations
from tests.motion.formats.test_bvh_fuzz import attempt


def small_gltf() -> MadeGltf:
    result = MadeGltf()
    result.node("arm")
    result.node("hand", 0, translation=[0.0, 1.0, 0.0])
    result.json["skins"] = [{"joints": [0, 1]}]
    turns = random_rotations(4, np.random.default_rng(0))
    result.animate({(0, "rotation"): turns, (1, "rotation"): turns}, np.arange(4) / 30.0)
    return result


Change = Callable[[dict[str, Any]], object]
REFUSED: dict[str, tuple[Change, str]] = {
    "avatar": (lambda j: j.pop("animations"), "an avatar .* without an animation"),
    "model": (lambda j: (j.pop("animations"), j.pop("skins")), "a model without an animation"),
    "circle": (lambda j: j["nodes"][1].update(children=[0]), "form a cycle"),
    "own child": (lambda j: j["nodes"][0].update(children=[0, 1]), "form a cycle"),
    "two parents": (lambda j: (j["nodes"].append({"children": [1]})), "already has a parent"),
    "no such child": (lambda j: j["nodes"][1].update(children=[99]), r"nodes\[1\].children\[0\] is 99"),
    "negative": (lambda j: j["nodes"][1].update(children=[-1]), r"children\[0\] is -1"),
    "a true child": (lambda j: j["nodes"][1].update(children=[True]), "a whole number expected"),
    "nodes no array": (lambda j: j.update(nodes={}), "nodes is an object; an array expected"),
    "a node no object": (lambda j: j["nodes"].append(7), r"nodes\[2\] is a number; an object expected"),
    "a billion keys": (lambda j: j["accessors"][0].update(count=10**9), "exceed its bufferView"),
    "a billion zeros": (
        lambda j: (j["accessors"][0].update(count=10**9), j["accessors"][0].pop("bufferView")),
        "asks for 1000000000 numbers",
    ),
    "beyond": (lambda j: j["accessors"][1].update(byteOffset=40), "exceed its bufferView"),
    "no such view": (lambda j: j["accessors"][1].update(bufferView=50), r"accessors\[1\].bufferView is 50"),
    "view beyond": (lambda j: j["bufferViews"][1].update(byteLength=10**6), "bufferViews.1. ends at byte"),
    "no such accessor": (lambda j: j["animations"][0]["samplers"][0].update(input=9), "no number 9"),
    "kind": (lambda j: j["accessors"][1].update(type="VEC3"), "is 'VEC3'; VEC4 expected"),
    "component": (lambda j: j["accessors"][1].update(componentType=5124), "5124; 5120 to 5126"),
    "stride": (lambda j: j["bufferViews"][1].update(byteStride=4), "byteStride is 4; at least 16"),
    "counts differ": (lambda j: j["accessors"][1].update(count=3), "3 values for 4 keys; 4 expected"),
    "interpolation": (lambda j: j["animations"][0]["samplers"][0].update(interpolation="BEZIER"), "'BEZIER'"),
    "no sampler": (lambda j: j["animations"][0]["channels"][0].update(sampler=5), "sampler is 5"),
    "no target node": (lambda j: j["animations"][0]["channels"][0]["target"].update(node=5), "target.node is 5"),
    "flat": (lambda j: j["nodes"][0].update(scale=[1, 0, 1]), r"nodes\[0\].scale is .* above zero"),
    "mirrored": (lambda j: j["nodes"][0].update(scale=[-1, -1, -1]), "above zero"),
    "sheared": (lambda j: j["nodes"][0].update(matrix=[1, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]), "shears"),
    "zero turn": (lambda j: j["nodes"][1].update(rotation=[0, 0, 0, 0]), r"nodes\[1\].rotation is zero"),
    "far": (lambda j: j["nodes"][1].update(translation=[1e30, 0, 0]), "out of range"),
    "huge": (lambda j: [n.update(scale=[1e7] * 3) for n in j["nodes"]], "too far"),
    "text": (lambda j: j["nodes"][1].update(translation=["x", 0, 0]), "holds the text 'x'; 3 numbers expected"),
    "version 1": (lambda j: j.update(asset={"version": "1.0"}), "glTF version '1.0'"),
    "no version": (lambda j: j.pop("asset"), "no asset.version"),
    "outside": (lambda j: j.update(buffers=[{"byteLength": 9, "uri": "a.bin"}]), "another file, 'a.bin'; .* as .glb"),
    "above": (lambda j: j.update(buffers=[{"byteLength": 9, "uri": "../a.bin"}]), "in the same folder expected"),
    "absolute": (lambda j: j.update(buffers=[{"byteLength": 9, "uri": "/etc/passwd"}]), "in the same folder expected"),
    "escaped": (lambda j: j.update(buffers=[{"byteLength": 9, "uri": "..%2Fa"}]), "in the same folder expected"),
    "web": (lambda j: j.update(buffers=[{"byteLength": 9, "uri": "http://a/b"}]), "in the same folder expected"),
    "data": (lambda j: j.update(buffers=[{"byteLength": 9, "uri": "data:;base64,?"}]), "no base64 data"),
    "cut off": (lambda j: j.update(buffers=[{"byteLength": 10**6}]), "1000000: it is cut off"),
    "compressed": (
        lambda j: j["bufferViews"][0].update(extensions={"EXT_meshopt_compression": {}}),
        "compressed .meshopt.; export without",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_broken_document_error_names_place(case: str) -> None:
    change, message = REFUSED[case]
    broken = small_gltf()
    change(broken.json)
    with pytest.raises(MotionFileError, match=message) as raised:
        parse_gltf(broken.glb(), "broken.glb")
    assert str(raised.value).startswith("broken.glb: ")
    assert len(str(raised.value).splitlines()) == 1


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "a glTF file begins with"),
        (b"HIERARCHY\n", "a glTF file begins with"),
        (b"glTF\2\0", "ends after 6 bytes"),
        (b"glTF\1\0\0\0" + bytes(20), "GLB version 1"),
        (small_gltf().glb()[:-9], "it is cut off"),
        (b"glTF" + bytes((2, 0, 0, 0, 28, 0, 0, 0, 8, 0, 0, 0)) + b"BIN\0" + bytes(8), "no JSON chunk"),
        (b"{", "line 1: column 2: no valid JSON"),
        (b'{"asset": NaN}', "NaN in the JSON"),
        (b'{"asset":{"version":"2.0"},"nodes":[{"translation":[1e999,0,0]}],"skins":[]}', "without an animation"),
        (b"{\xff}", "is not UTF-8"),
        (b'{"a":' + b"[" * 100_000 + b"]" * 100_000 + b"}", "nested too deep"),
        (b'{"a":' + b"1" * 5000 + b"}", "too long"),
        (b'{"a":[' + b"{}," * 1_000_000 + b"{}]}", "more than 1000000 values"),
        (b"{}", "no asset.version"),
    ],
)
def test_invalid_gltf_is_refused(data: bytes, message: str) -> None:
    with pytest.raises(MotionFileError, match=message):
        parse_gltf(data, "broken.glb")


@pytest.mark.parametrize(("value", "where"), [(np.nan, "element 2"), (np.inf, "element 2"), (1e30, "element 2")])
def test_non_finite_and_huge_numbers_are_refused(value: float, where: str) -> None:
    broken = small_gltf()
    turns = np.tile(np.float32((0, 0, 0, 1)), (4, 1))
    turns[2, 1] = value
    broken.json["animations"][0]["samplers"][1]["output"] = broken.accessor(turns)
    with pytest.raises(MotionFileError, match=where):
        parse_gltf(broken.glb(), "broken.glb")


def test_descending_or_overlong_times_are_refused() -> None:
    for times, message in (((0, 2, 1, 3), "backwards at key 2"), ((0, 1, 2, 1e6), "lasts 1000000 s")):
        broken = small_gltf()
        broken.json["animations"][0]["samplers"][0]["input"] = broken.accessor(np.array(times, "<f4"))
        with pytest.raises(MotionFileError, match=message):
            parse_gltf(broken.glb(), "broken.glb")


def test_unreadable_external_file_is_named() -> None:
    def resolve(name: str) -> bytes:
        raise FileNotFoundError(2, "No such file", name)

    with pytest.raises(MotionFileError, match=r"'a\.bin' cannot be read: No such file; put it next to"):
        parse_gltf(small_gltf().text("a.bin"), "broken.gltf", resolve)


def many_channels(nodes: int, keys: int) -> bytes:
    """A small file that expands: many nodes animated by the same bytes."""
    result = MadeGltf()
    result.node("0")
    for n in range(1, nodes):
        result.node(str(n), n - 1)
    turns = np.tile((1.0, 0.0, 0.0, 0.0), (keys, 1))
    result.animate({(n, "rotation"): turns[:1] for n in range(nodes)}, np.zeros(1))
    result.json["accessors"], result.json["bufferViews"], result.binary = [], [], bytearray()
    times = result.accessor(np.arange(keys, dtype="<f4") / 30.0)
    output = result.accessor(turns.astype("<f4"))
    for sampler in result.json["animations"][0]["samplers"]:
        sampler.update(input=times, output=output)
    return result.glb()


def aliased_times() -> bytes:
    """A file in which every channel has its own accessor of the same times."""
    document = json.loads(json.dumps(small_gltf().json))
    result = small_gltf()
    keys = 200_000
    view = result.view((np.arange(keys, dtype="<f4") / 1000.0).tobytes())
    row = {"bufferView": view, "componentType": 5126, "count": keys, "type": "SCALAR"}
    first = len(document["accessors"])
    result.json["accessors"] += [dict(row) for _ in range(2000)]
    result.json["nodes"] += [{"name": str(n)} for n in range(2000)]
    result.json["nodes"][1]["children"] = list(range(2, 2002))
    sampler = result.json["animations"][0]["samplers"][0]
    result.json["animations"][0]["samplers"] = [{**sampler, "input": first + n} for n in range(2000)]
    result.json["animations"][0]["channels"] = [
        {"sampler": n, "target": {"node": n + 2, "path": "rotation"}} for n in range(2000)
    ]
    result.json["skins"] = [{"joints": list(range(2, 1002))}]
    return result.glb()


def deep_json() -> bytes:
    return b'{"asset":{"version":"2.0"},"x":[' + b'{"abcd":{}},' * 400_000 + b"{}]}"


HOSTILE: dict[str, Callable[[], bytes]] = {
    "many channels": lambda: many_channels(900, 5000),
    "aliased times": aliased_times,
    "much JSON": deep_json,
    "one node twice a thousand times": lambda: repeated_channels(20_000),
    "ten hours between two keys": lambda: long_gap(),
    "long chain": lambda: many_channels(8_000, 2),
}


def repeated_channels(count: int) -> bytes:
    result = small_gltf()
    channel = result.json["animations"][0]["channels"][0]
    result.json["animations"][0]["channels"] = [copy.deepcopy(channel) for _ in range(count)]
    return result.glb()


def long_gap() -> bytes:
    result = small_gltf()
    times = np.array((0.0, 0.001, 0.0021, 35_000.0), "<f4")
    result.json["animations"][0]["samplers"][0]["input"] = result.accessor(times)
    return result.glb()


@pytest.mark.long
@pytest.mark.parametrize("case", HOSTILE)
def test_hostile_file_takes_bounded_memory_and_time(case: str) -> None:
    data = HOSTILE[case]()
    tracemalloc.start()
    start = time.process_time()
    motion, problem = attempt(lambda: parse_gltf(data, "hostile.glb"))
    assert motion is not None or isinstance(problem, MotionFileError)
    seconds = time.process_time() - start
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 64e6 + 20 * len(data), f"{peak / 1e6:.0f} MB for {len(data)} bytes"
    assert seconds < 20.0


VALUES: tuple[Any, ...] = (
    None, True, -1, 0, 1, 2, 10**9, 10**30, 0.5, 1e300, "", "x", [], {}, [0], [[]], [1, 2, 3], {"a": 1}, 5126, 5121,
    "VEC3", "SCALAR", "CUBICSPLINE", "STEP", "scale", "translation",
)  # fmt: skip


def mutate_json(value: Any, rng: random.Random) -> Any:
    """The JSON with one value replaced, removed or duplicated."""
    value = copy.deepcopy(value)
    place = value
    while True:
        keys = list(place) if isinstance(place, dict) else list(range(len(place)))
        if not keys:
            return value
        key = rng.choice(keys)
        if isinstance(place[key], dict | list) and place[key] and rng.random() < 0.85:
            place = place[key]
            continue
        kind = rng.randrange(4)
        if kind == 0:
            del place[key]
        elif kind == 1 and isinstance(place, list):
            place.append(copy.deepcopy(place[key]))
        elif kind == 2 and isinstance(place[key], int):
            place[key] += rng.choice((-1, 1, 2, 100))
        else:
            place[key] = rng.choice(VALUES)
        return value


@mostly_long("seed", range(4), quick=[2])
def test_mutated_file_gives_motion_or_error(seed: int) -> None:
    rng = random.Random(seed)
    avatar, bones = made_avatar(frames=3)
    avatar.json["skins"] = [{"joints": list(bones.values())}]
    if seed % 2:
        humanoid = {"humanBones": {bone: {"node": node} for bone, node in bones.items()}}
        avatar.json["extensions"] = {"VRMC_vrm": {"humanoid": humanoid}}
    whole = {"buffers": [{"byteLength": len(avatar.binary)}], **avatar.json}
    outcomes = {"motion": 0, "error": 0, "clip": 0}
    for _ in range(150):
        document, binary = whole, bytearray(avatar.binary)
        for _ in range(rng.randint(1, 2)):
            document = mutate_json(document, rng)
        for _ in range(rng.choice((0, 0, 0, 1, 4))):
            binary[rng.randrange(len(binary))] = rng.randrange(256)
        data = bytearray(pack_glb(json.dumps(document).encode(), bytes(binary)))
        for _ in range(rng.choice((0, 0, 0, 0, 1, 3))):
            data[rng.randrange(min(len(data), 4000))] = rng.randrange(256)
        if rng.random() < 0.1:
            del data[rng.randrange(len(data)) :]
        motion, problem = attempt(lambda data=data: parse_gltf(bytes(data), "fuzz.glb"))
        if motion is None:
            outcomes["error"] += 1
            assert isinstance(problem, MotionFileError)
            assert len(str(problem).splitlines()) == 1
            assert len(str(problem)) < 500
            continue
        outcomes["motion"] += 1
        assert np.isfinite(motion.translation).all()
        np.testing.assert_allclose(np.linalg.norm(motion.rotation, axis=-1), 1.0, atol=1e-9)
        assert (motion.parents[1:] < np.arange(1, motion.joint_count)).all()
        assert (motion.parents[1:] >= 0).all()
        clip, problem = attempt(lambda motion=motion: retarget(motion, name="fuzz"))
        assert clip is not None or "\n" not in str(problem)
        outcomes["clip"] += clip is not None
    assert outcomes["motion"] > 4
    assert outcomes["error"] > 4
    assert outcomes["clip"] > 0 or not seed % 2
