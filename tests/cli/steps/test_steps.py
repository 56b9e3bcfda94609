"""`live steps`: add, list, show, check and play, and the preview danced by play."""

import json
import tomllib
from collections import Counter
from dataclasses import replace
from pathlib import Path

import av
import numpy as np
import pytest
from typer.testing import CliRunner

from live.app.offline.step_adding import ClapReference, add_to_library
from live.app.offline.step_listing import find_step, named_steps, user_library
from live.app.offline.step_preview import MAX_VARIATIONS, Preview, on_the_spot, play_step, preview_show
from live.base.errors import PersonError
from live.base.event_queue import EventQueue
from live.cli.main import app
from live.clock.time_source import ManualClock
from live.graph.step_library import build_library
from live.library.step_folder import load_folder
from live.motion.mirror import mirror_step
from live.motion.step_clip import measured_distance, travel
from live.show.engine import Engine
from live.show.loader import LoadedShow
from live.show.view.status import Status
from tests.cli.command import run_live
from tests.fixtures.made_steps import made_clip
from tests.fixtures.mocap import mocap_file
from tests.motion.formats.made_bvh import body_bvh, column, dance_values, still

NO_SCREEN = {"DISPLAY": "", "WAYLAND_DISPLAY": ""}
ASKED = ("--bpm", "120", "--anchor", "2.5", "--measures", "2")


@pytest.fixture
def take(tmp_path: Path) -> Path:
    path = tmp_path / "take.bvh"
    path.write_text(body_bvh(dance_values(601)))
    return path


def clapping_values(first: float, bpm: float, count: int, seconds: float = 12.0) -> np.ndarray:
    """Values of a body that claps `count` times at `bpm` from `first` [s] on, at 60 frames/s, then opens its arms."""
    time = np.arange(int(seconds * 60) + 1) / 60.0
    beat = (time - first) * bpm / 60.0
    near = np.clip(beat, 0.0, count - 1.0)
    wide = np.where(np.abs(beat - near) > 0.5, 1.0, np.minimum(1.0, 2.0 * np.abs(beat - np.round(near))))
    values = still(len(time))
    for side, sign in (("Left", 1.0), ("Right", -1.0)):
        values[:, column(side + "Arm", "Y")] = sign * (-90.0 + 50.0 * wide)
        values[:, column(side + "ForeArm", "Y")] = sign * -28.0
    return values


def test_recording_is_added_listed_checked_and_played(tmp_path: Path, take: Path) -> None:
    library = tmp_path / "library"
    where = ("--library", str(library))
    added = run_live("steps", "add", str(take), "--name", "sway", *ASKED, "--tag", "slow", "--mirror", *where)
    assert added.returncode == 0, added.stderr
    assert "added 'sway': 2 measures of 4 beats at 120 bpm, from measure 1 of take.bvh" in added.stdout
    assert sorted(path.name for path in library.iterdir()) == ["take.bvh", "take.toml"]

    listed = run_live("steps", "list", "--json", *where)
    (row,) = json.loads(listed.stdout)
    assert (row["name"], row["variations"], row["measures"], row["tags"]) == ("sway", 2, [2], ["slow"])
    words = run_live("steps", "show", "Sway", *where).stdout
    assert "left  foot on the floor" in words
    assert "8 beats, 4 to a measure" in words
    assert "sway, take from measure 1 (mirrored)" in words
    shown = run_live("steps", "list", *where).stdout
    assert "variations" in shown
    assert "poses" not in shown  # nobody has named any
    exported = run_live("export", "sway", "--to", str(tmp_path / "sway.bvh"), *where)
    assert exported.returncode == 0, exported.stderr

    checked = run_live("steps", "check", *where)
    assert checked.returncode == 0, checked.stdout + checked.stderr
    assert "1 step in" in checked.stdout
    assert "0 wrong" in checked.stdout

    played = run_live("steps", "play", "sway", "--headless", "--seconds", "1", *where, **NO_SCREEN)
    assert played.returncode == 0, played.stderr
    assert "2 dancers, internal clock" in played.stderr
    toml = library / "take.toml"
    toml.write_text(toml.read_text().replace("measures = 2", "measures = 99"))
    broken = run_live("steps", "check", *where)
    assert broken.returncode == 1
    assert "wrong: " in broken.stdout
    assert "take.toml, line " in broken.stdout
    assert "step.1.measures: the step ends with measure 99" in broken.stdout


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("show", "nothing like it"), "there is no step 'nothing like it'"),
        (("show", "grove"), "groove"),
        (("play", "samba", "--variation", "99"), "--variation 99: the step has 18"),
        (("play", "samba", "--tempo", "nan"), "--tempo nan: 20 to 400 expected"),
        (("play", "samba", "--film", "x.avi"), "a film's name ends in .mp4"),
        (("add", "gone.bvh", "--name", "x"), "gone.bvh: there is no such file"),
        (("add", "gone.bvh", "--name", "x", "--count", "8"), "--count counts the beats of a click"),
        (("list", "--library", "nowhere"), "there is no folder nowhere"),
        (("check", "--library", "nowhere"), "there is no folder nowhere"),
    ],
)
def test_invalid_arguments_are_refused_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: tuple[str, ...], words: str
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    result = CliRunner().invoke(app, ["steps", *arguments])
    assert isinstance(result.exception, PersonError)
    assert words in str(result.exception)
    assert "\n" not in str(result.exception)


@pytest.mark.long
def test_list_show_and_check_print_json(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    rows = {row["name"]: row for row in json.loads(CliRunner().invoke(app, ["steps", "list", "--json"]).stdout)}
    assert rows["samba"]["variations"] == 18
    assert len(rows["samba"]["directions"]) == 9
    shown = json.loads(CliRunner().invoke(app, ["steps", "show", "samba", "--json"]).stdout)
    assert shown.items() >= rows["samba"].items()
    assert [clip["mirrored"] for clip in shown["clips"]] == [False] * 9 + [True] * 9
    assert all(len(clip["contacts"]) == 4 for clip in shown["clips"])
    assert {follower["step"] for follower in shown["followers"]} >= {"samba", "walk"}
    checked = CliRunner().invoke(app, ["steps", "check", "--json"])
    assert (checked.exit_code, json.loads(checked.stdout)["findings"]) == (0, [])


@pytest.mark.long
def test_user_library_has_priority_over_project_steps(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    monkeypatch.setenv("LIVE_CACHE_DIR", str(tmp_path / "cache"))
    there = len(named_steps(None))
    own = user_library()
    own.mkdir(parents=True)
    assert len(named_steps(None)) == there
    (own / "samba.toml").write_text('name = "Samba"\nmirror = false\n[pelvis]\n"1" = "down 4"\n"2" = "up 1"\n')
    steps = named_steps(None)
    assert len(steps) == there
    assert (find_step(steps, "samba").folder, len(find_step(steps, "samba").clips)) == (own, 1)


@pytest.mark.long
def test_spellings_of_step_name_form_one_step(tmp_path: Path, take: Path) -> None:
    library = tmp_path / "library"
    for name, first in (("Long Sway", 2.5), ("long_sway", 3.0), ("long-sway ", 3.5)):
        add_to_library(take, {"name": name, "bpm": 120.0, "first_beat_s": first}, library, ClapReference())
    (step,) = named_steps(library)
    assert (step.name, len(step.clips)) == ("Long Sway", 3)
    assert build_library(load_folder(library)).steps == ("Long Sway",)


def test_claps_set_tempo_and_file_notes_source(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("LIVE_CACHE_DIR", str(tmp_path / "cache"))
    take = tmp_path / "claps.bvh"
    take.write_text(body_bvh(clapping_values(2.2, 100.0, 8)))
    add_to_library(take, {"name": "x", "start_measure": 3}, tmp_path / "library", ClapReference(click=100.0, count=8))
    text = (tmp_path / "library" / "claps.toml").read_text()
    (step,) = tomllib.loads(text)["step"]
    assert step["bpm"] == 100
    assert step["first_beat_s"] == pytest.approx(2.2, abs=0.03)
    assert "bpm = 100 # from claps to the click, confidence 0." in text
    assert "music found: 100.00 bpm" in capsys.readouterr().out


def test_manual_anchor_has_priority_and_drops_no_frames(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LIVE_CACHE_DIR", str(tmp_path / "cache"))
    take = tmp_path / "claps.bvh"
    take.write_text(body_bvh(clapping_values(2.2, 100.0, 8)))
    fields = {"name": "x", "first_beat_s": 1.25, "start_measure": 2}
    add_to_library(take, fields, tmp_path / "library", ClapReference(click=100.0))
    (step,) = tomllib.loads((tmp_path / "library" / "claps.toml").read_text())["step"]
    assert (step["first_beat_s"], step["bpm"]) == (1.25, 100)
    assert "drop_frames" not in step
    with pytest.raises(PersonError, match="--click: --bpm and --anchor say already"):
        add_to_library(take, fields | {"bpm": 90.0}, tmp_path / "library", ClapReference(click=100.0))


@pytest.mark.long
@pytest.mark.shared
def test_guessed_values_are_marked_in_file(tmp_path: Path) -> None:
    take = mocap_file("salsa/60_04.bvh")
    result = CliRunner().invoke(
        app, ["steps", "add", str(take), "--name", "salsa", "--fps", "60", "--start", "3", "--library", str(tmp_path)]
    )
    assert result.exit_code == 0, result.exception
    assert "guess, to be confirmed: 16" in result.stdout
    text = (tmp_path / "60_04.toml").read_text()
    assert text.count("# guess: confirm") == 2
    assert "drop_frames = 6 # found: a T-pose was put before the dance" in text
    where = ["--library", str(tmp_path)]
    again = CliRunner().invoke(app, ["steps", "add", str(take), "--name", "salsa", "--start", "5", *where])
    assert "guess, to be confirmed: 16" in again.stdout
    assert "(the library's, where it is not confirmed yet)" in again.stdout
    assert (tmp_path / "60_04.toml").read_text().count("# guess: confirm") == 4
    twice = CliRunner().invoke(app, ["steps", "add", str(take), "--name", "salsa", "--start", "5", *where])
    assert isinstance(twice.exception, PersonError)
    assert "the step 'salsa' is there already" in str(twice.exception)
    checked = CliRunner().invoke(app, ["steps", "check", *where])
    assert checked.exit_code == 0
    assert checked.stdout.count("is a guess; ") == 4


def test_on_the_spot_removes_travel_only() -> None:
    step = made_clip("glide", way=(0.3, -0.8), measures=2)
    spot = on_the_spot(step)
    assert measured_distance(spot) < 1e-6
    assert (spot.clip.rotation == step.clip.rotation).all()
    np.testing.assert_array_equal(spot.clip.root_position[:, 1], step.clip.root_position[:, 1])


def dance_preview(loaded: LoadedShow, seconds: float) -> tuple[np.ndarray, list[set[str]]]:
    """Dance a preview: places of the hips (A, 2) [m] at its end, and the steps that each dancer danced."""
    show, clock = loaded.start(tempo=120.0), ManualClock()
    status = Status(show, rejected=Counter, memory=lambda: 0.0)
    engine = Engine(show, clock=clock, inbox=EventQueue(), status=status, stall=np.inf)
    dance_values: list[set[str]] = [set() for _ in range(loaded.patch.dancer_count)]
    library = loaded.graph.library
    for frame in range(int(seconds * 16)):
        clock.set(frame / 16)
        engine.frame(lambda view: None)
        for dancer, node in enumerate(show.dancers.node):
            dance_values[dancer].add(library.steps[library.node_step[node]])
    return engine.view.joint_position[:, 0][:, (0, 2)].astype(np.float64), dance_values


@pytest.mark.long
def test_each_dancer_dances_own_variation_in_place() -> None:
    clips = [made_clip("glide", way=(0.0, 0.8)), made_clip("glide", way=(0.8, 0.0)), made_clip("glide", measures=2)]
    loaded = preview_show("glide", clips, travelling=False)
    places, dance_values = dance_preview(loaded, 9.0)
    assert dance_values == [{"glide 1"}, {"glide 2"}, {"glide 3"}]
    assert places == pytest.approx(np.array([group.centre for group in loaded.patch.group]), abs=0.45)


@pytest.mark.long
def test_travelling_preview_moves_dancers_by_step_travel() -> None:
    clips = [made_clip("glide", way=(0.0, 0.8)), made_clip("glide", way=(0.4, 0.0))]
    loaded = preview_show("glide", clips, travelling=True)
    places, _ = dance_preview(loaded, 8.0)  # four measures of 2 s
    moved = places - np.array([group.centre for group in loaded.patch.group])
    assert moved == pytest.approx(np.array([travel(clip) for clip in clips]) * 4, abs=0.3)


def test_step_follows_itself_despite_pose_and_weight_labels() -> None:
    step = replace(made_clip("échappé"), begin_pose="plié", end_pose="sous-sus", weight_transfer=True)
    loaded = preview_show("échappé", [step, mirror_step(step)], travelling=False)
    assert dance_preview(loaded, 5.0)[1] == [{"échappé 1"}, {"échappé 2"}]


@pytest.mark.long
def test_film_of_many_variations_shows_first_ones(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from live.render.headless import NoOpenGL, create_headless_context, release_headless_context

    try:
        release_headless_context(create_headless_context())
    except NoOpenGL as reason:
        pytest.skip(str(reason))
    film = tmp_path / "samba.mp4"
    play_step(Preview(step="samba", film=film, seconds=1.0, size=(160, 90), fps=10.0))
    with av.open(str(film)) as made:
        assert len(list(made.decode(video=0))) == 10
    told = capsys.readouterr().err
    assert f"18 variations, the first {MAX_VARIATIONS} are shown" in told
    assert str(film) in told.replace("\n", "")
