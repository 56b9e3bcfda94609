"""The dancers' motion in files for other programs, against the poses that the show draws."""

import csv
import json
import math
import re

import numpy as np
import pybvh
import pygltflib
import pytest
from rich.console import Console

from live.app.film.film_output import MAX_MOTION_BYTES, MotionOutput
from live.app.film.show_film import film_show
from live.app.launch_options import LaunchOptions
from live.app.session_audio import AudioChoice
from live.base.errors import PersonError
from live.motion.formats.ways import COLUMNS
from live.motion.skeleton import JOINT_COUNT, SKELETON
from live.show.dancers.character_casting import bodies_of
from live.show.patch.patch_reader import read_patch
from live.show.patch.patch_search_path import PATCHES
from tests.cli.command import run_live
from tests.fixtures.mostly_long import mostly_long

FPS, FRAMES = 20.0, 31
HIDDEN = {4: slice(0, 11), 7: slice(20, 25)}
"""Frames in which dancers (from 0) are taken from the stage."""


@pytest.fixture(scope="module")
def show_files(tmp_path_factory):
    """Files of the first 1.5 s of the first show in all formats, and what the show drew: joints [m], (T, A, J, 3)."""
    folder, joints = tmp_path_factory.mktemp("motion"), []

    class Watched(MotionOutput):
        """Keeps what is drawn, and hides two dancers for a while."""

        def draw(self, view):
            for dancer, frames in HIDDEN.items():
                view.present[dancer] = not frames.start <= len(joints) < frames.stop
            joints.append(view.joint_position.copy())
            super().draw(view)

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr("live.app.film.show_film.MotionOutput", Watched)
        options = LaunchOptions(fps=FPS)
        loaded, said = options.load(), {}
        for name in ("show.glb", "show.bvh", "show.csv", "show.json"):
            joints.clear()
            said[name] = film_show(
                options, loaded, AudioChoice(), path=folder / name, seconds=FRAMES / FPS, console=Console(quiet=True)
            )
    return folder, np.array(joints), said


def glb_joints(document, blob, root):
    """Joints [m] below the node `root` at each key, (T, J, 3), with matrices, and the root's scale steps."""

    def values(accessor, width):
        view = document.bufferViews[document.accessors[accessor].bufferView]
        data = np.frombuffer(blob, np.float32, document.accessors[accessor].count * width, view.byteOffset)
        return data.reshape(-1, width).astype(np.float64)

    (animation,) = document.animations
    channels = {
        (channel.target.node, channel.target.path): (
            values(animation.samplers[channel.sampler].input, 1)[:, 0],
            values(animation.samplers[channel.sampler].output, {"rotation": 4}.get(channel.target.path, 3)),
        )
        for channel in animation.channels
    }
    found = {}

    def visit(node, above):
        keys = channels[node, "rotation"][1]
        place = channels[node, "translation"][1] if (node, "translation") in channels else None
        matrix = np.zeros((len(keys), 4, 4))
        x, y, z, w = keys.T
        matrix[:, 0, :3] = np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)], 1)
        matrix[:, 1, :3] = np.stack([2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)], 1)
        matrix[:, 2, :3] = np.stack([2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)], 1)
        matrix[:, :3, 3] = document.nodes[node].translation if place is None else place
        matrix[:, 3, 3] = 1.0
        world = above @ matrix
        found[document.nodes[node].name] = world[:, :3, 3]
        for child in document.nodes[node].children:
            visit(child, world)

    (hips,) = document.nodes[root].children
    visit(hips, np.eye(4))
    return np.stack([found[name] for name in SKELETON.names], axis=1), channels.get((root, "scale"))


@pytest.mark.long
def test_glb_holds_every_dancer_where_the_show_draws_them(show_files):
    folder, joints, said = show_files
    document = pygltflib.GLTF2().load(str(folder / "show.glb"))
    roots = [skin.skeleton for skin in document.skins]
    names = [document.nodes[root].name for root in roots]
    assert names == [f"dancer {n}" for n in range(1, 25)]
    assert f"24 dancers in {FRAMES} frames" in said["show.glb"]
    groups = [document.nodes[root].extras["group"] for root in roots]
    assert len(set(groups)) == 3
    assert {len(skin.joints) for skin in document.skins} == {JOINT_COUNT}
    assert all(mesh.primitives[0].material is not None for mesh in document.meshes)
    assert len(document.materials) == 3
    bodies = bodies_of(read_patch(PATCHES / "first_show.toml"))
    worn = set(zip(groups, bodies, strict=True))
    assert len(document.meshes) == len(worn)  # one for each colour and body; those of a body share their data
    for attributes in {tuple(vars(mesh.primitives[0].attributes).items()) for mesh in document.meshes}:
        weights = document.accessors[dict(attributes)["WEIGHTS_0"]]
        place = document.bufferViews[weights.bufferView].byteOffset
        shares = np.frombuffer(document.binary_blob(), np.float32, weights.count * 4, place).reshape(-1, 4)
        np.testing.assert_allclose(shares.sum(axis=1), 1.0, atol=1e-6)
        assert weights.count > 3000  # a body, not bones
    for dancer, root in enumerate(roots):
        found, scale = glb_joints(document, document.binary_blob(), root)
        np.testing.assert_allclose(found, joints[:, dancer], atol=1e-4)  # a tenth of a millimetre
        assert (scale is not None) == (dancer in HIDDEN)
    for dancer, frames in HIDDEN.items():
        times, sizes = glb_joints(document, document.binary_blob(), roots[dancer])[1]
        at = [float(sizes[np.searchsorted(times, frame / FPS + 1e-6) - 1, 0]) for frame in range(FRAMES)]
        assert at == [0.0 if frames.start <= frame < frames.stop else 1.0 for frame in range(FRAMES)]


@pytest.mark.long
def test_bvh_files_hold_one_dancer_each(show_files):
    folder, joints, said = show_files
    paths = sorted(folder.glob("show-*.bvh"))
    assert [path.name for path in paths] == [f"show-{n:02d}.bvh" for n in range(1, 25)]
    assert said["show.bvh"].endswith(f"{folder / 'show-01.bvh'} to show-24.bvh")
    read = pybvh.read_bvh_file(paths[11])
    assert tuple(read.joint_names) == SKELETON.names
    places = np.stack([read.joint_positions(frame=frame) for frame in range(FRAMES)])
    np.testing.assert_allclose(0.01 * places, joints[:, 11], atol=1e-4)


def test_tables_hold_places_headings_and_measures(show_files):
    folder, joints, _ = show_files
    with (folder / "show.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert tuple(rows[0]) == COLUMNS
    assert len(rows) == FRAMES * 24
    document = json.loads((folder / "show.json").read_text())
    assert document["frames_per_second"] == FPS
    assert len(document["beat"]) == FRAMES
    assert set(document["measure"]) == {1}
    for dancer in (0, 4, 23):
        own = [row for row in rows if row["dancer"] == f"dancer {dancer + 1}"]
        place = np.array([[float(row["x_m"]), float(row["z_m"])] for row in own])
        np.testing.assert_allclose(place, joints[:, dancer, 0, ::2], atol=1e-4)
        np.testing.assert_allclose([float(row["time_s"]) for row in own], np.arange(FRAMES) / FPS, atol=1e-6)
        ways = document["dancers"][dancer]
        assert ways["group"] == own[0]["group"]
        np.testing.assert_allclose(np.stack([ways["x_m"], ways["z_m"]], 1), place, atol=1e-4)
        assert ways["present"] == [int(row["present"]) for row in own]
        legs = joints[:, dancer, SKELETON.names.index("leftUpperLeg")] - joints[:, dancer, 0]
        across = np.degrees(np.arctan2(legs[:, 0], legs[:, 2])) - 90.0  # the left leg is at the left of the heading
        off = (np.array(ways["heading_deg"]) - across + 180.0) % 360.0 - 180.0
        assert np.abs(off).max() < 15.0  # hips sway
    formations = {formation["name"]: formation for formation in document["formations"]}
    assert len(formations) >= 2
    for formation in formations.values():
        places = np.stack([formation["x_m"], formation["z_m"]], axis=1)
        assert len(places) == len(formation["heading_deg"]) > 0
        assert np.abs(places).max() < 8.0
        apart = np.linalg.norm(places[:, None] - places[None], axis=-1)
        assert apart[~np.eye(len(places), dtype=bool)].min() > 0.3
    assert document["dancers"][4]["present"] == [int(frame >= 11) for frame in range(FRAMES)]


@pytest.mark.long
def test_replay_writes_the_motion_of_the_night_and_a_part_of_it(tmp_path):
    options = ("--bpm", "120", "--seconds", "6", "--fps", "16", "--journal", str(tmp_path / "night.jsonl"))
    made = run_live("render", "--out", str(tmp_path / "a.json"), *options)
    assert made.returncode == 0, made.stderr
    again = run_live("replay", str(tmp_path / "night.jsonl"), "--render", str(tmp_path / "b.json"), "--fps", "16")
    assert again.returncode == 0, again.stderr
    part = run_live(
        "replay", str(tmp_path / "night.jsonl"), "--render", str(tmp_path / "c.json"), "--fps", "16", "--from", "2",
        "--to", "2",
    )  # fmt: skip
    assert part.returncode == 0, part.stderr
    first, second, third = (json.loads((tmp_path / f"{name}.json").read_text()) for name in "abc")
    assert third["begin_s"] == pytest.approx(2.0, abs=0.05)
    assert set(third["measure"][:-1]) == {2}  # the last frame is the first after it
    for one, other in zip(first["dancers"], second["dancers"], strict=True):
        count = min(len(one["x_m"]), len(other["x_m"]))
        assert count >= 90
        assert one["x_m"][:count] == other["x_m"][:count]
        assert one["heading_deg"][:count] == other["heading_deg"][:count]
    offset = round(third["begin_s"] * 16)  # a part begins at a tick, not on the grid of the whole
    for one, other in zip(first["dancers"], third["dancers"], strict=True):
        np.testing.assert_allclose(one["z_m"][offset : offset + 20], other["z_m"][:20], atol=0.05)


@mostly_long(
    ("arguments", "words"),
    [
        (("--out", "show.glb", "--alpha"), "has motion and no pictures"),
        (("--out", "show.fbx"), "the dancers' motion goes into .bvh, .glb"),
        (("--out", "nowhere/show.glb"), "there is no folder nowhere"),
        (("--out", "show.glb", "--fps", "480", "--seconds", "100000"), "GB of memory"),
    ],
    quick=[0, 1, 2],
)
def test_motion_that_cannot_be_written_is_refused_before_the_show_begins(tmp_path, arguments, words):
    result = run_live("render", *arguments, cwd=tmp_path)
    assert result.returncode == 2
    assert words in " ".join(result.stderr.split())
    assert not list(tmp_path.iterdir())


@pytest.mark.long
def test_motion_keeps_its_details_where_no_camera_looks(tmp_path):
    """Dancers behind the camera: their arms keep off each other as those of the same show with a usual camera."""
    usual = (PATCHES / "first_show.toml").read_text()
    found = {}
    for name, eye in (("usual", "[0.0, 2.4, 9.9]"), ("away", "[0.0, 2.4, -60.0]")):
        patch = tmp_path / name
        patch.mkdir()
        (patch / "show.toml").write_text(re.sub(r"\[camera\]\n(?:[^\n]+\n)+", f"[camera]\neye = {eye}\n\n", usual))
        done = run_live(
            "render", str(patch), "--bpm", "112", "--seconds", "4", "--fps", "5", "--out",
            str(tmp_path / f"{name}.bvh"),
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        found[name] = b"".join(path.read_bytes() for path in sorted(tmp_path.glob(f"{name}-*.bvh")))
    assert len(found["usual"]) > 100_000
    assert found["usual"] == found["away"]


def test_motion_longer_than_memory_ends_with_a_remedy(monkeypatch):
    options = LaunchOptions()
    loaded = options.load()
    show = loaded.start()
    monkeypatch.setattr("live.app.film.film_output.MAX_MOTION_BYTES", 3 * len(show.group) * (16 * JOINT_COUNT + 12))
    output, view = MotionOutput(loaded, show, loaded.path, frames=0, fps=30.0, begin=0.0), show.view()
    for _ in range(3):
        output.draw(view)
    with pytest.raises(PersonError, match="in 4 frames need") as error:
        output.draw(view)
    assert "--fps 30" in str(error.value.remedy)


def test_longest_motion_fits_into_the_bound():
    minutes = MAX_MOTION_BYTES / (50 * 30 * (16 * JOINT_COUNT + 12)) / 60.0
    assert math.floor(minutes) >= 110  # 50 dancers at 30 frames a second for two hours, nearly


def test_empty_stage_has_no_motion():
    options = LaunchOptions()
    loaded = options.load()
    output = MotionOutput(loaded, loaded.start(), loaded.path, frames=1, fps=30.0, begin=0.0)
    with pytest.raises(PersonError, match="nobody is on the stage"):
        output.motion()
