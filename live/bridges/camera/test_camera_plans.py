"""Which cameras of the command line and the venue publish silhouettes."""

from pathlib import Path
from types import SimpleNamespace

import pytest

from live.app.bridges import ServiceContext
from live.base.errors import PersonError
from live.base.event_queue import EventQueue
from live.bridges.camera import CameraOptions, services
from live.bridges.camera.camera_service import CameraTables, camera_plans
from live.clock.time_source import ManualClock

MARKS = [[-2, 1, 0.2, 0.8], [2, 1, 0.8, 0.8], [2, -2, 0.7, 0.5], [-2, -2, 0.3, 0.5]]


@pytest.fixture
def film(tmp_path: Path) -> str:
    path = tmp_path / "film.mp4"
    path.write_bytes(b"nobody opens it here")
    return str(path)


def test_silhouettes_are_published_only_by_cameras_that_were_asked_to(film: str) -> None:
    tables = CameraTables.model_validate({
        "stage_camera": [
            {"name": "front", "source": film, "marks": MARKS, "silhouette": True},
            {"name": "side", "source": film, "marks": MARKS},
        ]
    }).stage_camera  # fmt: skip
    assert [each.silhouette for each in camera_plans((film,), ())] == [False]
    assert [each.silhouette for each in camera_plans((film,), (), silhouette=True)] == [True]
    assert [each.silhouette for each in camera_plans((), tables)] == [True, False]
    assert [each.silhouette for each in camera_plans((), tables, silhouette=True)] == [True, True]
    assert camera_plans((film,), tables[:1])[0].silhouette, "the venue's camera with another source"


def test_silhouettes_without_a_camera_are_refused() -> None:
    context = ServiceContext(
        options=CameraOptions(camera_silhouette=True), engine=SimpleNamespace(), venue=None, clock=ManualClock(),
        add_queue=EventQueue().add_queue, osc=("127.0.0.1", 9010), host_names=(), resumes=False,
    )  # fmt: skip
    with pytest.raises(PersonError, match=r"--camera-silhouette.*--camera any"):
        services(context)
