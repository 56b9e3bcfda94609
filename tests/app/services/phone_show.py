"""A show with the real web server and the port for phones that are cameras, whose frames a thread draws."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from live.app.launch_options import LaunchOptions
from live.app.services.phone_camera import PhoneCameraPort
from live.app.services.web_service import WebService
from live.clock.time_source import SystemClock
from live.control.camera.phone_landmarks import PhoneCameras
from live.show.patch.patch_reader import parse_patch
from tests.show.made_show import PATCH, made_show

KEY = "a-key-of-the-tests-4711"
PERFORMERS = '[[mocap]]\nname = "anna"\n[[mocap]]\nname = "ben"\n'


class PhoneShow:
    """Takes what phones send: phone, performer, packet, arrival."""

    def __init__(self, performers: str = PERFORMERS) -> None:
        self.clock = SystemClock()
        self.heard: list[tuple[str, str, bytes, float]] = []
        self.phones = PhoneCameras()
        self.phones.handlers.append(lambda *told: self.heard.append(told))
        self.port = PhoneCameraPort(LaunchOptions(phone_camera=("127.0.0.1", 0)), None, KEY)
        self.web = WebService(
            ("127.0.0.1", 0), KEY, ("127.0.0.1", 9), made_show(performers), self.clock, camera=self.port,
            phones=self.phones,
        )  # fmt: skip
        self.web.start()
        self._stop = threading.Event()
        self._lock = threading.Lock()
        self._thread = threading.Thread(target=self._draw)
        self._thread.start()

    def _draw(self) -> None:
        while not self._stop.wait(1 / 60):
            with self._lock:
                self.web.frame()

    def use_performers(self, performers: str) -> None:
        """Edit the patch."""
        with self._lock:
            self.web.update_patch(parse_patch(PATCH + performers, "test.toml"))

    @property
    def facts(self) -> dict[str, Any]:
        """What the status tells of phones."""
        return dict(self.web.status().get("phones") or {})

    @property
    def link(self) -> str:
        """The camera page's link with its key."""
        return self.port.link

    @property
    def key(self) -> str:
        """The key of that page."""
        return self.link.partition("#key=")[2]

    @property
    def at(self) -> str:
        """The address of the port for phones."""
        return self.link.partition("/camera")[0]

    def stop(self) -> None:
        """End it."""
        self._stop.set()
        self._thread.join()
        self.web.stop()


@contextmanager
def phone_show(folder: Path, monkeypatch: Any, models: Path | None = None) -> Iterator[PhoneShow]:
    """Yields a running show; settings and files that stand for the model are in `folder` unless `models` are given."""
    if models is None:
        models = folder / "models"
        models.mkdir()
        (models / "pose.js").write_text("// the model")
        (models / "pose_solution_simd_wasm_bin.wasm").write_bytes(b"\0asm" * 1000)
        (models / "package.json").write_text("{}")
    monkeypatch.setenv("LIVE_CONFIG_DIR", str(folder / "config"))
    monkeypatch.setattr("live.app.services.phone_camera.phone_folder", lambda: models)
    show = PhoneShow()
    try:
        yield show
    finally:
        show.stop()
