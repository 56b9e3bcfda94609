"""Cameras in a live show: which are opened, what is refused, and a dancer who is seen for real."""

import os
from pathlib import Path
from types import SimpleNamespace

import av
import numpy as np
import pytest
from PIL import Image

from live.app.bridges import ServiceContext
from live.base.errors import PersonError
from live.base.event_queue import EventQueue
from live.base.system.picture_ring import FrameRingReader, ring_path
from live.bridges.camera import CameraOptions, services
from live.bridges.camera.camera_service import camera_plans, drawn_joints
from live.bridges.camera.stage_camera import CameraTables, StageCamera
from live.clock.time_source import SystemClock
from live.control.camera import model_files
from live.control.camera.model_files import model_folder
from live.control.camera.phone_landmarks import PhoneCameras
from live.control.events.events import ExchangeSeen, MocapFrame
from live.motion.capture.packed_pose import unpack_pose
from live.show.venue.venue import Venue
from tests.control.waiting import wait_for
from tests.places import ROOT
from tests.show.made_show import made_show

MARKS = ((-2.0, 1.0, 0.2, 0.8), (2.0, 1.0, 0.8, 0.8), (2.0, -2.0, 0.7, 0.55), (-2.0, -2.0, 0.3, 0.55))
PERFORMERS = '[[mocap]]\nname = "anna"\n[[mocap]]\nname = "ben"\n'
DANCER = ROOT / "tests/control/camera/dancer_1.png"


def make_service(options, show=None, venue=None, phones=None, inbox=None, resumes=False):
    """The service of these launch options, and its context."""
    show = show or made_show(PERFORMERS)
    context = ServiceContext(
        options=options, engine=SimpleNamespace(show=show, view=show.view()), venue=venue, clock=SystemClock(),
        add_queue=(EventQueue() if inbox is None else inbox).add_queue, osc=("127.0.0.1", 9010), host_names=(),
        resumes=resumes, phones=phones,
    )  # fmt: skip
    return services(context).get("camera"), context


def made_film(path: Path, frames: int = 120) -> Path:
    """A film in which one of the project's own dancers is carried to the right and back, again and again."""
    dancer = np.asarray(Image.open(DANCER).convert("RGB"))
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=30)
        stream.width, stream.height, stream.pix_fmt = 480, 360, "yuv420p"
        stream.options = {"preset": "ultrafast"}
        for number in range(frames):
            picture = np.full((360, 480, 3), 224, np.uint8)
            left = 20 + 4 * min(number, frames - number)
            picture[40:340, left : left + 150] = dancer
            container.mux(stream.encode(av.VideoFrame.from_ndarray(picture, "rgb24")))
        container.mux(stream.encode())
    return path


def test_without_a_camera_there_is_no_service():
    assert make_service(CameraOptions())[0] is None
    assert make_service(CameraOptions(camera=("off",)))[0] is None


def test_a_venues_cameras_are_opened_unless_they_are_switched_off(tmp_path):
    film = str(made_film(tmp_path / "a.mp4", 3))
    tables = (StageCamera(name="front", source=film, marks=MARKS),)
    (plan,) = camera_plans((), tables)
    assert (plan.name, plan.kind, plan.place, plan.marks) == ("front", "film", film, MARKS)
    assert camera_plans(("off",), tables) == []
    other = str(made_film(tmp_path / "b.mp4", 3))
    (plan,) = camera_plans((other,), tables)
    assert (plan.name, plan.place, plan.marks) == ("front", other, MARKS), "another source, the venue's marks"


def test_silhouettes_are_published_only_by_cameras_that_were_asked_to(tmp_path):
    film = str(made_film(tmp_path / "a.mp4", 3))
    asked = StageCamera(name="front", source=film, marks=MARKS, silhouette=True)
    tables = (asked, StageCamera(name="side", source=film, marks=MARKS))
    assert [each.silhouette for each in camera_plans((film,), ())] == [False]
    assert [each.silhouette for each in camera_plans((film,), (), silhouette=True)] == [True]
    assert [each.silhouette for each in camera_plans((), tables)] == [True, False]
    assert [each.silhouette for each in camera_plans((), tables, silhouette=True)] == [True, True]
    assert camera_plans((film,), (asked,))[0].silhouette, "the venue's camera with another source"
    with pytest.raises(PersonError, match="no camera whose silhouettes") as refused:
        make_service(CameraOptions(camera_silhouette=True))
    assert refused.value.remedy == "--camera any"


def test_several_cameras_need_marks(tmp_path):
    film = str(made_film(tmp_path / "a.mp4", 3))
    with pytest.raises(PersonError, match="several cameras need marks") as refused:
        camera_plans((film, film), ())
    assert "live camera calibrate" in str(refused.value) or "live calibrate camera" in str(refused.value)
    tables = tuple(StageCamera(name=name, source=film, marks=MARKS) for name in ("front", "side"))
    assert [each.name for each in camera_plans((), tables)] == ["front", "side"]


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({"name": "front", "marks": [[0, 0, 0.5, 0.5]]}, "four or more"),
        ({"name": "front", "screen": [[0, 0], [1, 0], [1, 1]]}, "four are needed"),
        ({"name": "front", "marks": [[0, 0, 0.5, float("nan")]] * 4}, "finite"),
        ({"name": "front", "turn_deg": 45}, "90"),
        ({"name": "front", "lens": 2}, "lens"),
    ],
)
def test_a_wrong_table_is_refused(table, words):
    with pytest.raises(ValueError, match=words):
        CameraTables.model_validate({"stage_camera": [table]})


def test_missing_parts_are_told_with_their_remedy(tmp_path, monkeypatch):
    film = str(made_film(tmp_path / "a.mp4", 3))
    monkeypatch.setenv(model_files.FOLDER_VARIABLE, str(tmp_path / "none"))
    with pytest.raises(PersonError, match="live camera models"):
        make_service(CameraOptions(camera=(film,)))
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(PersonError, match=r"choreographics-live\[camera\]"):
        make_service(CameraOptions(camera=(film,)))
    with pytest.raises(PersonError, match="no camera is called"):
        make_service(CameraOptions(camera=(str(tmp_path / "b.mp4"),)))
    with pytest.raises(PersonError, match="full or lite"):
        make_service(CameraOptions(camera=("off",), camera_model="huge"))


def test_a_resumed_show_goes_on_without_a_camera(tmp_path, monkeypatch):
    film = str(made_film(tmp_path / "a.mp4", 3))
    monkeypatch.setenv(model_files.FOLDER_VARIABLE, str(tmp_path / "none"))
    service, context = make_service(CameraOptions(camera=(film,)), resumes=True)
    assert service is None
    assert "no camera" in context.notices[0]()


def test_the_venue_is_read(tmp_path):
    venue = Venue.model_validate({"stage_camera": [{"name": "front", "source": "off.mp4"}]})
    with pytest.raises(PersonError, match=r"\[\[stage_camera\]\]: no camera is called 'off.mp4'"):
        make_service(CameraOptions(), venue=venue)


def test_phones_alone_need_no_models(tmp_path, monkeypatch):
    monkeypatch.setenv(model_files.FOLDER_VARIABLE, str(tmp_path / "none"))
    phones = PhoneCameras()
    service, _ = make_service(CameraOptions(), phones=phones)
    assert len(phones.handlers) == 1
    assert service.lamp() == "", "no camera of this machine is open"
    service.start()
    try:
        assert wait_for(lambda: bool(service.before_frame() or "phones" in service.status()), 10.0)
        phones.take("tablet", "anna", b"damaged", 0.0)
        assert wait_for(lambda: bool(service.before_frame() or service.refused().total() == 1), 10.0)
    finally:
        service.stop()


def test_where_dancers_are_drawn_is_told_in_shares_of_the_picture():
    show = made_show(PERFORMERS)
    view = show.view()
    show.fill(view, 0.0)
    joints = drawn_joints(SimpleNamespace(show=show, view=view))
    assert joints.dtype == np.float32
    assert joints.shape[0] == int(view.present.sum())
    assert joints.shape[1:] == (12, 2)
    feet, shoulders = joints[:, 10:, 1].mean(), joints[:, :2, 1].mean()
    assert 0.0 < shoulders < feet < 1.0, "y points down"


@pytest.mark.long
@pytest.mark.skipif(model_folder() is None, reason="needs the pose models: live camera models gets them once")
def test_a_dancer_is_seen_a_crash_is_survived_and_names_are_exchanged(tmp_path):
    pytest.importorskip("ai_edge_litert", reason="needs the extra camera")
    inbox = EventQueue()
    film = str(made_film(tmp_path / "a.mp4"))
    service, context = make_service(CameraOptions(camera=(film,)), inbox=inbox)
    assert context.notices == [service.lamp]
    assert service.lamp() == "● CAMERA: opens"
    service.start()
    told: list[MocapFrame] = []

    def hear(name):
        service.before_frame()
        service.frame()
        told.extend(inbox.drain())
        return [each for each in told if each.performer == name]

    try:
        assert wait_for(lambda: len(hear("anna")) >= 10, 15.0)
        assert wait_for(lambda: bool(hear("anna") and "sees 1" in service.lamp()), 10.0)
        assert service.lamp().startswith("● CAMERA OPEN: camera 1 sees 1")
        hips, rotation = unpack_pose(told[-1].pose)
        assert 0.5 < hips[1] < 1.1
        assert np.linalg.norm(rotation, axis=1) == pytest.approx(np.ones(22), abs=1e-3)
        assert all(each.time <= context.clock.now() for each in told)
        facts = service.status()
        assert facts["open"]
        assert facts["cameras"][0]["problem"] == ""
        service.handle(ExchangeSeen(time=0.0, source="osc", performer="anna", other="carla"))
        assert "no performer is called 'carla'; there are: anna, ben" in service.refusal()
        service.handle(ExchangeSeen(time=0.0, source="osc", performer="anna", other="ben"))
        assert service.refusal() == ""
        assert wait_for(lambda: len(hear("ben")) >= 3, 10.0)
        before = len(told)
        os.kill(service.pid, 9)
        assert wait_for(lambda: hear("anna") is not None and service.status()["restarts"] == 1, 10.0)
        assert wait_for(lambda: hear("anna") is not None and len(told) > before + 5, 15.0)
    finally:
        service.stop()


@pytest.mark.long
@pytest.mark.skipif(model_folder() is None, reason="needs the pose models: live camera models gets them once")
@pytest.mark.skipif(not Path("/dev/shm").is_dir(), reason="memory files are at another place here")
def test_a_dancers_silhouette_is_published_while_the_show_runs(tmp_path):
    pytest.importorskip("ai_edge_litert", reason="needs the extra camera")
    name = f"test-{os.getpid()}"
    film = str(made_film(tmp_path / "a.mp4"))
    options = CameraOptions(camera=(film,), camera_silhouette=True)
    service, _ = make_service(options, made_show(f'[[mocap]]\nname = "{name}"\n'))
    path = ring_path(f"camera-{name}")
    seen = []

    def look(reader):
        service.before_frame()
        picture = reader.read()
        if picture is not None:
            body = (picture > 127).all(axis=2)
            seen.append((float(body.mean()), float(body.any(axis=1).mean()), float(body.any(axis=0).mean())))
        # a slim dancer from the side: most of the picture's height, a third of its width
        return bool(seen) and seen[-1][0] > 0.05 and 0.5 < seen[-1][1] < 0.8 and 0.15 < seen[-1][2] < 0.5

    try:
        service.start()
        assert wait_for(path.exists, 15.0)
        reader = FrameRingReader(path.name)
        assert wait_for(lambda: look(reader), 15.0), seen
        assert wait_for(lambda: look(reader) and "silhouettes published" in service.lamp(), 10.0)
        reader.close()
    finally:
        service.stop()
    assert not path.exists()
