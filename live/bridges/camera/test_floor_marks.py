"""`live calibrate camera` with clicks of the command line: the venue's file, other cameras in it, bad marks."""

import json
import re
import tomllib
from pathlib import Path

import av
import numpy as np
import pytest

from live.base.arrays import UInt8
from live.base.errors import PersonError
from live.bridges.camera.floor_marks import (
    Clicks,
    FloorMarks,
    chosen_camera,
    parse_points,
    stage_corners,
    update_camera_toml,
    venue_cameras,
)
from live.bridges.camera.stage_camera import CameraTables, StageCamera
from live.motion.capture.camera_view import CameraView, calibrate
from live.show.venue.venue import read_venue
from tests.cli.command import run_live
from tests.motion.capture.made_landmarks import look_at

MARKS = ((-2.0, 1.0), (2.0, 1.0), (2.0, -2.0), (-2.0, -2.0))
MARKS_TEXT = "-2,1 2,1 2,-2 -2,-2"
VIEW = look_at((0.4, 2.0, 5.0), (0.0, 0.3, 0.0), 0.95)
SIZE = (960, 540)


def floor_picture(view: CameraView = VIEW, size: tuple[int, int] = SIZE) -> UInt8:
    """A chequered floor of 1 m squares through a camera, with a red disc on each mark; white above the horizon."""
    width, height = size
    u, v = np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height)
    floor = view.on_floor(np.stack((u.ravel(), v.ravel()), axis=1)).reshape(height, width, 3)
    x, z = floor[:, :, 0], floor[:, :, 2]
    near = np.hypot(x, z) < 30.0
    dark = np.where(near, (np.floor(np.nan_to_num(x)) + np.floor(np.nan_to_num(z))) % 2, 0.0)
    picture = (
        np.where(near[:, :, None], np.where(dark[:, :, None] > 0, 70, 130), 235).astype(np.uint8).repeat(3, axis=2)
    )
    for mark in MARKS:
        picture[np.hypot(x - mark[0], z - mark[1]) < 0.08] = (220, 30, 30)
    return picture


def write_floor_film(path: Path, picture: UInt8) -> Path:
    """A film of one second of that picture."""
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=15)
        stream.width, stream.height, stream.pix_fmt = picture.shape[1], picture.shape[0], "yuv420p"
        for _ in range(15):
            container.mux(stream.encode(av.VideoFrame.from_ndarray(picture, "rgb24")))
        container.mux(stream.encode())
    return path


def mark_places(view: CameraView = VIEW) -> list[list[float]]:
    """Where the camera sees the marks."""
    places: list[list[float]] = view.project([(x, 0.0, z) for x, z in MARKS]).tolist()
    return places


def as_text(places: list[list[float]]) -> str:
    return " ".join(f"{u:.5f},{v:.5f}" for u, v in places)


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_floor_film(tmp_path_factory.mktemp("floor") / "floor.mp4", floor_picture())


@pytest.fixture
def venues(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of venues of a user, who has none yet."""
    monkeypatch.setenv("LIVE_CONFIG_DIR", str(tmp_path / "settings"))
    return tmp_path / "settings" / "venues"


def live(*words: str) -> str:
    """Run `live calibrate camera`, and return what it prints; PersonError with the message if it refuses."""
    done = run_live("calibrate", "camera", *words)
    if done.returncode == 2:
        raise PersonError(done.stderr)
    assert done.returncode == 0, done.stderr
    return done.stdout


def check_same_camera(found: CameraView, there: CameraView = VIEW) -> None:
    """The camera that made the picture was found."""
    np.testing.assert_allclose(found.position, there.position, atol=0.05)
    np.testing.assert_allclose(found.rotation, there.rotation, atol=0.01)
    assert found.focal == pytest.approx(there.focal, rel=0.01)


def venue_view(name: str, aspect: float = SIZE[0] / SIZE[1]) -> CameraView:
    """The camera of a venue's only table, as a show finds it."""
    (table,) = read_venue(name, (CameraTables,)).read_tables(CameraTables).stage_camera
    rows = np.array(table.marks)
    return calibrate(rows[:, :2], rows[:, 2:], aspect)


@pytest.mark.long
def test_clicks_of_the_command_line_are_written_to_a_new_venue(film: Path, venues: Path) -> None:
    words = ("--marks", MARKS_TEXT, "--clicks", as_text(mark_places()), "--camera", str(film))
    found = json.loads(live("--venue", "hall", *words, "--json"))
    assert found["file"] == str(venues / "hall.toml")
    assert (found["camera_x"], found["camera_height"], found["camera_z"]) == pytest.approx((0.4, 2.0, 5.0), abs=0.03)
    assert found["off_percent"] < 0.1
    table = tomllib.loads((venues / "hall.toml").read_text())["stage_camera"][0]
    assert (table["name"], table["source"]) == ("front", str(film))
    assert set(table) == {"name", "source", "marks"}
    check_same_camera(venue_view("hall"))


def test_another_venue_keeps_comments_and_its_other_cameras(film: Path, venues: Path) -> None:
    venues.mkdir(parents=True)
    before = (
        '# our hall\nname = "Kaufleuten"   # Zürich\n\n[audio]\ndevice = "USB"\n\n'
        '[[stage_camera]]\nname = "side"  # stage left\nsource = "1"\n\n'
        '[[stage_camera]]\nname = "front"\nsource = "HDMI grabber" # on the balcony\n'
        "marks = [[1, 1, 0.1, 0.1], [-1, 1, 0.2, 0.2], [-1, -1, 0.3, 0.3], [1, -1, 0.4, 0.3]]\n"
        "screen = [[0.1, 0.05], [0.9, 0.05], [0.9, 0.5], [0.1, 0.5]]\n\n[latency]\n# by ear\nprojector_ms = 40\n"
    )
    (venues / "hall.toml").write_text(before, encoding="utf-8")
    words = ("--venue", "hall", "--camera", str(film), "--marks", MARKS_TEXT, "--clicks", as_text(mark_places()))
    with pytest.raises(PersonError, match="2 cameras: side, front"):
        live(*words)
    live(*words, "--name", "front")
    after = (venues / "hall.toml").read_text("utf-8")
    old, new = (
        [line for line in text.splitlines() if not line.startswith("marks =")] for text in (before, after)
    )  # fmt: skip
    assert new == old, "all but the marks is as it was, the source too: a film is a recording of the venue's camera"
    front = tomllib.loads(after)["stage_camera"][1]
    assert np.array(front["marks"]) == pytest.approx(np.column_stack((MARKS, mark_places())), abs=1e-5)
    live(*words, "--name", "back", "--screen", "0.2,0.1 0.8,0.1 0.8,0.4 0.2,0.4")
    back = tomllib.loads((venues / "hall.toml").read_text("utf-8"))["stage_camera"][2]
    assert back["screen"] == [[0.2, 0.1], [0.8, 0.1], [0.8, 0.4], [0.2, 0.4]]


def test_marks_of_the_venue_or_corners_of_the_stage_are_the_default(film: Path, venues: Path) -> None:
    view = look_at((0.0, 3.0, 8.0), (0.0, 0.0, 0.0), 1.0)
    corners = view.project([(x, 0.0, z) for x, z in stage_corners(6.0, 4.0)]).tolist()
    clicks = ("--camera", str(film), "--clicks", as_text(corners))
    with pytest.raises(PersonError, match="where are the marks"):
        live(*clicks)
    live("--venue", "hall", "--stage", "6x4", *clicks)
    found = json.loads(live("--venue", "hall", *clicks, "--json"))  # again, after the camera was moved
    assert [each[:2] for each in found["marks"]] == [[-3, 2], [3, 2], [3, -2], [-3, -2]]
    check_same_camera(venue_view("hall"), view)


def test_without_a_venue_a_table_is_printed(film: Path, venues: Path) -> None:
    told = live("--marks", MARKS_TEXT, "--clicks", as_text(mark_places()), "--camera", str(film))
    printed = told[told.index("[[stage_camera]]") :]
    (table,) = tomllib.loads(printed)["stage_camera"]
    check_same_camera(calibrate(MARKS, np.array(table["marks"])[:, 2:], SIZE[0] / SIZE[1]))
    assert not venues.exists()


@pytest.mark.parametrize("turn_deg", [90, 180, 270])
def test_a_picture_that_is_not_upright_is_found_out(turn_deg: int) -> None:
    """Places as clicked in a picture that was not turned yet."""
    (width, height), quarters = SIZE, turn_deg // 90
    u, v = np.array(mark_places()).T
    for _ in range(quarters):  # the camera hangs turned clockwise
        u, v = 1.0 - v, u
    aspect = width / height if quarters % 2 == 0 else height / width
    clicks = Clicks(tuple(zip(u.tolist(), v.tolist(), strict=True)))
    with pytest.raises(PersonError) as error:
        FloorMarks(MARKS).find_camera(clicks, aspect)
    assert f"--turn-deg {turn_deg}" in str(error.value)
    assert ("upside down" in str(error.value)) == (turn_deg == 180)


def test_grid_lies_on_the_floor_and_ends_where_the_camera_does_not_see() -> None:
    marks = FloorMarks(MARKS, (12.0, 14.0))  # reaches behind the camera
    seen = marks.grid(VIEW)
    assert seen["step"] == 1.0
    ends = np.array(seen["lines"])
    assert ends.shape[1:] == (2, 2)
    assert ends.min() >= -0.5
    assert ends.max() <= 1.5
    places = VIEW.on_floor(ends.reshape(-1, 2)).reshape(-1, 2, 3)[:, :, (0, 2)]
    on_line = np.abs(places - np.round(places)).max(axis=1) < 0.02  # across the line both ends have one whole metre
    assert on_line.any(axis=1).all()
    assert seen["audience"] is None, "7 m towards the audience is behind the camera"
    assert seen["centre"] == pytest.approx(VIEW.project([(0.0, 0.0, 0.0)])[0], abs=1e-4)
    near = FloorMarks(MARKS).grid(VIEW)
    assert np.array(near["audience"]).shape == (2, 2)


REFUSED = [
    ("--marks", "-2,1 0,1 2,1 0,-2", "on a line on the stage"),
    ("--marks", "-2,1 2,-2 2,1 -2,-2", "convex shape on the stage"),
    ("--marks", "-2,1 2,1 2,-2", "3 marks"),
    ("--marks", "-2,1 2,1 2,-2 -2", "pair 4"),
    ("--marks", "-2,1 2,1 2,-2 -2,nan", "pair 4"),
    ("--marks", "-2,1 2,1 2,-2 -2,200", "pair 4"),
    ("--clicks", "0.2,0.8 0.5,0.8 0.8,0.8 0.5,0.5", "on a line in the picture"),
    ("--clicks", "0.2,0.8 0.7,0.5 0.8,0.8 0.3,0.5", "convex shape in the picture"),
    ("--clicks", "0.3,0.5 0.7,0.5 0.8,0.8 0.2,0.8", "clockwise in one list"),
    ("--clicks", "1.2,0.8 1.8,0.8 1.7,0.5 1.3,0.5", "mark 1 was clicked outside the picture"),
    ("--clicks", "0.2,0.8 0.8,0.8 0.7,0.5", "3 places were clicked for 4 marks"),
    ("--screen", "0.1,0.1 0.9,0.5 0.9,0.1 0.1,0.5", "corners of the screen are not in order"),
    ("--screen", "0.1,0.1 0.9,0.5", "2 corners of the screen"),
    ("--turn-deg", "45", "--turn-deg 45"),
    ("--stage", "6", "--stage '6'"),
    ("--name", "", "--name ''"),
    ("--venue", "../x", "--venue"),
]


@pytest.mark.parametrize(("option", "value", "words"), REFUSED)
def test_what_gives_no_camera_is_refused_and_nothing_is_written(
    film: Path, venues: Path, option: str, value: str, words: str
) -> None:
    options = {"--venue": "hall", "--camera": str(film), "--marks": MARKS_TEXT, "--clicks": as_text(mark_places())}
    with pytest.raises(PersonError, match=re.escape(words)) as error:
        live(*(word for pair in (options | {option: value}).items() for word in pair))
    assert "try: " in error.value.message
    assert not venues.exists()


@pytest.mark.long
def test_cameras_that_are_not_there_or_show_nothing_are_named(
    tmp_path: Path, venues: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    words = ("--marks", MARKS_TEXT, "--clicks", as_text(mark_places()))
    with pytest.raises(PersonError, match="no camera is called 'nowhere'"):
        live(*words, "--camera", "nowhere")
    monkeypatch.setattr("live.bridges.camera.calibrate_command._PICTURE_S", 0.5)
    broken = tmp_path / "broken.mp4"
    broken.write_bytes(b"no film")
    with pytest.raises(PersonError, match=r"no picture of the camera broken\.mp4: Invalid data"):
        live(*words, "--camera", str(broken))


def test_a_venue_that_cannot_be_written_is_refused_before_anybody_clicks(film: Path, venues: Path) -> None:
    words = ("--venue", "hall", "--camera", str(film), "--marks", MARKS_TEXT)  # without clicks: a page would be served
    venues.mkdir(parents=True)
    file = venues / "hall.toml"
    file.write_text('name = "hall"\n')
    file.chmod(0o444)
    with pytest.raises(PersonError, match="may not be written"):
        live(*words)
    file.chmod(0o644)
    file.write_text("name = \n")
    with pytest.raises(PersonError, match=r"hall\.toml"):
        live(*words)
    file.unlink()
    venues.rmdir()
    venues.write_text("a file where the folder should be")
    with pytest.raises(PersonError, match="may not be written"):
        live(*words)


def test_options_before_the_command_are_refused() -> None:
    done = run_live("calibrate", "--venue", "hall", "camera", "--marks", MARKS_TEXT)
    assert done.returncode == 2
    assert "--venue stands before camera" in done.stderr


def test_a_fifth_camera_is_not_added(venues: Path) -> None:
    tables = tuple(StageCamera(name=str(number)) for number in range(4))
    with pytest.raises(PersonError, match="no more are used"):
        chosen_camera(tables, "fifth")
    assert chosen_camera(tables, "2") is tables[2]
    assert chosen_camera(tables[:1], None) is tables[0]
    assert chosen_camera((), None).name == "front"
    assert venue_cameras("hall") == ()


def test_tables_in_one_line_are_kept_so() -> None:
    text = 'name = "hall"\nstage_camera = [{ name = "front", source = "0" }]  # one\n'
    camera = StageCamera(name="front", source="0", marks=tuple((x, z, 0.5, 0.25) for x, z in MARKS), turn_deg=90)
    found = tomllib.loads(update_camera_toml(text, "hall", camera))["stage_camera"]
    assert found == [
        {"name": "front", "source": "0", "turn_deg": 90, "marks": [[x, z, 0.5, 0.25] for x, z in MARKS]}
    ]  # fmt: skip
    other = tomllib.loads(update_camera_toml(text, "hall", camera.model_copy(update={"name": "back"})))["stage_camera"]
    assert [each["name"] for each in other] == ["front", "back"]


def test_points_are_parsed_with_signs_and_without_zeros() -> None:
    assert parse_points(" -2,.5  +1.25,-3. ", "--marks", "", 10.0) == ((-2.0, 0.5), (1.25, -3.0))
    for text in ("1", "1,2,3", "1;2", "1,2 x", "1e5,2", "1..2,3", ".,1"):
        with pytest.raises(PersonError, match="--marks: pair"):
            parse_points(text, "--marks", "", 10.0)
