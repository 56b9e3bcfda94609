"""Recordings that are no ordinary dance: each gets a right answer or a refusal that says what to do."""

import resource
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from live.base.errors import PersonError
from live.cli.main import app
from live.clock.ticks import TICK
from live.graph.build.blend_feasibility import MIN_CHORD, MIN_ROOT_COSINE, Blends
from live.graph.build.blend_kernels import is_blendable
from live.graph.step_library import StepLibrary, build_library
from live.library.step_folder import load_folder
from live.motion.formats.bvh_reader import parse_bvh
from live.motion.formats.file_error import MotionFileError
from live.show.loader import LoadedShow, load_show
from live.show.patch.patch_search_path import DEFAULT_PATCH
from tests.cli.command import run_live
from tests.fixtures.made_steps import made_clip
from tests.fixtures.mostly_long import mostly_long
from tests.motion.formats.made_bvh import body_bvh, column, still
from tests.motion.retarget.made_source import moving_values

STEP = '[[step]]\nfile = "a.bvh"\nname = "{}"\nbpm = 112\nfirst_beat_s = {}\n'


def can_stand(library: StepLibrary, window: float, source: np.ndarray, target: np.ndarray) -> np.ndarray:
    """Whether a dancer has a foot to stand on in the blend of each pair; the poses are alike."""
    blends = Blends.of(library, window, source, target)
    rows = zip(blends.end, blends.start, blends.end_stands, blends.start_stands, strict=True)
    limits = MIN_ROOT_COSINE, MIN_CHORD
    return np.array([is_blendable(a, b, 0.0, blends.weight, c, d, *limits) for a, b, c, d in rows])


def folder(path: Path, text: str, *steps: tuple[str, float], more: str = "") -> Path:
    """A folder with the recording `text` and its steps: names and times at which they begin [s]."""
    path.mkdir()
    (path / "a.bvh").write_text(text)
    (path / "a.toml").write_text("".join(STEP.format(*step) + more for step in steps))
    return path


def stepping(seconds: float, *, turns: float = 0.0) -> np.ndarray:
    """A body that lifts one foot after the other on the beats of 112 bpm, and turns so often in a measure."""
    values = still(round(seconds * 60.0))
    beat = np.arange(len(values)) / 60.0 * 112.0 / 60.0
    for number, side in enumerate(("Left", "Right")):
        lift = np.maximum(np.sin(np.pi * (beat + number)), 0.0) ** 2
        values[:, column(f"{side}UpLeg", "X")], values[:, column(f"{side}Leg", "X")] = -40.0 * lift, 70.0 * lift
    values[:, column("Hips", "Y")] = 360.0 * turns * beat / 4.0
    return values


def danced(loaded: LoadedShow, seconds: float) -> None:
    """Run the show; its dancers always have a next measure and stay near the stage."""
    show = loaded.start()
    for number in range(1, round(seconds / TICK)):
        show.tick(number * TICK)
    assert show.scheduler.dead_ends == 0
    everybody = np.arange(len(show.group), dtype=np.int32)
    pose, _ = show.dancers.raw_poses(everybody, 0.5, show.time)
    assert np.isfinite(pose).all()
    half = np.array([show.patch.stage.width, show.patch.stage.depth]) / 2
    assert (np.abs(pose[show.motion.present][:, 0, (0, 2)]) < half + 1.0).all()


def refusal(*arguments: str) -> str:
    result = CliRunner().invoke(app, ["steps", *arguments])
    assert isinstance(result.exception, PersonError), result.output
    return str(result.exception)


ONE_LEG = (
    """HIERARCHY
ROOT LeftUpLeg
{ OFFSET 0 90 0 CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
JOINT LeftLeg
{ OFFSET 0 -42 0 CHANNELS 3 Zrotation Xrotation Yrotation
JOINT LeftFoot
{ OFFSET 0 -40 0 CHANNELS 3 Zrotation Xrotation Yrotation
End Site
{ OFFSET 0 -5 12 } } } }
MOTION
Frames: 300
Frame Time: 0.0166667
"""
    + 300 * "0 0 0 1 2 3 4 5 6 7 8 9\n"
)


def test_recording_of_one_leg_is_refused(tmp_path: Path) -> None:
    source, library = tmp_path / "leg.bvh", tmp_path / "library"
    source.write_text(ONE_LEG)
    words = refusal("add", str(source), "--name", "a", "--anchor", "1", "--bpm", "112", "--library", str(library))
    assert "rightUpperLeg" in words
    assert "a full body expected: hips, both legs and both arms" in words
    assert not library.exists()
    with pytest.raises(PersonError, match=r"a\.toml, line 2: step\.1\.file: .*no joints found for"):
        load_show(DEFAULT_PATCH, recordings=folder(tmp_path / "steps", ONE_LEG, ("a", 1.0)))


def test_too_many_numbers_are_refused_with_what_to_leave_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("live.motion.formats.bvh_numbers.VALUE_LIMIT", 6000)
    with pytest.raises(MotionFileError, match=r"in 100 frames of 66; export it at 60 frames a second, without fingers"):
        parse_bvh(body_bvh(still(100)), "long.bvh")


@pytest.mark.long
@pytest.mark.skipif(sys.platform != "linux", reason="ru_maxrss is in kilobytes on Linux only")
def test_ten_minutes_at_240_frames_are_read_in_bounded_time_and_memory(tmp_path: Path) -> None:
    text = body_bvh(stepping(10.0), fps=240.0)
    head, lines = text[: text.index("MOTION")], text.splitlines()[-600:]
    path = tmp_path / "long.bvh"
    with path.open("w") as file:
        file.write(f"{head}MOTION\nFrames: 144000\nFrame Time: {1 / 240:.8f}\n")
        for _ in range(240):
            file.write("\n".join(lines) + "\n")
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = run_live(
        "steps", "add", str(path), "--name", "a", "--start", "3", "--measures", "2", "--library", str(tmp_path / "l")
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    assert done.returncode == 0, done.stderr
    assert after.ru_maxrss * 1024 < 64_000_000 + 20 * path.stat().st_size
    assert after.ru_utime - before.ru_utime < 60.0
    (step,) = load_folder(tmp_path / "l")
    assert step.clip.seconds < 15.0  # of the ten minutes only the step is kept


@mostly_long("unit", [1.0, 0.01], quick=[0])
def test_body_of_three_metres_is_danced_at_our_size_and_told(tmp_path: Path, unit: float) -> None:
    values, source = moving_values(10.0, 60.0), tmp_path / "tall.bvh"
    source.write_text(body_bvh(values, fps=60.0, scale=unit * 3.0 / 1.7))
    same = folder(tmp_path / "same", body_bvh(values, fps=60.0), ("a", 2.5))
    library = str(tmp_path / "library")
    arguments = ["add", str(source), "--name", "a", "--anchor", "2.5", "--bpm", "112", "--library", library]
    done = CliRunner().invoke(app, ["steps", *arguments])
    assert done.exit_code == 0, done.output
    assert "in no usual unit is the dancer 1.2 to 2.2 m tall" in done.output.replace("\n", "")
    (tall,), (usual,) = load_folder(Path(library)), load_folder(same)
    np.testing.assert_allclose(tall.clip.root_position, usual.clip.root_position, atol=1e-3)
    words = refusal(*arguments, "--start", "2", "--unit", str(0.01 if unit == 1.0 else 1.0))
    assert "would be 3.06 m tall; 1.2 to 2.2 m is plausible, that is unit_m" in words


@pytest.mark.long
def test_step_that_ends_in_the_air_is_told_and_not_begun(tmp_path: Path) -> None:
    """The dancer rises half a second before the last line; who would come after stands on the floor."""
    values, beat = stepping(14.0), 60.0 / 112.0
    time = np.arange(len(values)) / 60.0 - (2.0 + 4 * beat)
    flies = np.abs(time) < 0.5
    values[flies, 1] += 100.0 * 4.905 * (0.25 - time[flies] ** 2)
    steps = folder(tmp_path / "steps", body_bvh(values), ("jump", 2.0), ("walk", 7.0), ("step", 2.0 + 18 * beat))
    checked = CliRunner().invoke(app, ["steps", "check", "--library", str(steps)])
    assert "it ends in the air, 1.2" in checked.output.replace("\n", "")
    loaded = load_show(DEFAULT_PATCH, recordings=steps)
    assert any(words.startswith("jump: nothing leads to it and away again") for words in loaded.graph.missing)
    danced(loaded, 12.0)
    alone = folder(tmp_path / "alone", body_bvh(values), ("jump", 2.0))
    with pytest.raises(PersonError, match="no step of jump leads to another"):
        load_show(DEFAULT_PATCH, recordings=alone)


def standing_on(side: str, *, both_before: bool = False) -> np.ndarray:
    """A body on one leg that sways; `both_before`: it puts the other foot down in the two beats before 2 s."""
    other = "Right" if side == "Left" else "Left"
    values = still(600)
    up = np.ones(600)
    if both_before:
        up[round(60 * (2.0 - 120.0 / 112.0)) : 120] = 0.0
    values[:, column(f"{other}UpLeg", "X")], values[:, column(f"{other}Leg", "X")] = -60.0 * up, 80.0 * up
    values[:, column("Spine", "Y")] = 10.0 * np.sin(np.arange(600) / 60.0 * 2.0 * np.pi)
    return values


@pytest.mark.long
def test_steps_without_a_common_foot_do_not_follow_each_other(tmp_path: Path) -> None:
    steps = folder(tmp_path / "steps", body_bvh(standing_on("Left")), ("left", 2.0))
    (steps / "b.bvh").write_text(body_bvh(standing_on("Right")))
    (steps / "b.toml").write_text(STEP.format("right", 2.0).replace("a.bvh", "b.bvh"))
    loaded = load_show(DEFAULT_PATCH, recordings=steps)
    assert len(loaded.graph.missing) == 1
    assert "nothing leads to it and away again within 0.35 m on a foot that stands in both" in loaded.graph.missing[0]
    danced(loaded, 8.0)


def test_foot_that_is_put_down_in_time_joins_steps(tmp_path: Path) -> None:
    texts = {"left": standing_on("Left"), "right": standing_on("Right"), "both": standing_on("Right", both_before=True)}
    clips = []
    for name, values in texts.items():
        clips += load_folder(folder(tmp_path / name, body_bvh(values), (name, 2.0)))
    library = build_library(clips)
    source, target = np.zeros(3, np.int32), np.arange(3, dtype=np.int32)
    assert can_stand(library, 0.25, source, target).tolist() == [True, False, True]


def test_sketched_steps_and_flights_need_no_common_foot() -> None:
    left, right, air = (made_clip(name) for name in ("left", "right", "air"))
    feet = {"left": (True, False), "right": (False, True), "air": (False, False)}
    clips = [
        replace(clip, clip=replace(clip.clip, contact=np.tile(feet[clip.step], (clip.clip.sample_count, 1))))
        for clip in (left, right, air)
    ]
    pairs = np.array([0, 0, 2, 2], np.int32), np.array([1, 2, 2, 0], np.int32)
    assert can_stand(build_library(clips), 0.25, *pairs).all()
    recorded = build_library([replace(clip, recorded=True) for clip in clips])
    assert can_stand(recorded, 0.25, *pairs).tolist() == [False, False, True, False]


@pytest.mark.long
@pytest.mark.parametrize(
    "turns", [pytest.param(0.25, marks=pytest.mark.long), 0.5, pytest.param(1.0, marks=pytest.mark.long)]
)
def test_library_of_nothing_but_turns_is_danced(tmp_path: Path, turns: float) -> None:
    text = body_bvh(stepping(16.0, turns=turns))
    measure = 4 * 60.0 / 112.0
    names = [(f"turn {n}", round(measure * n, 4)) for n in (1, 2, 3)]
    steps = folder(tmp_path / "steps", text, *names, more="mirror = true\n")
    loaded = load_show(DEFAULT_PATCH, recordings=steps)
    assert loaded.graph.missing == ()
    danced(loaded, 16.0)
