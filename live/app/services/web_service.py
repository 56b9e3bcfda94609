"""Service of the operator's web page and of the studio's streams, whose process is a web server."""

import json
import struct
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import numpy.typing as npt
from rich.console import Console

from live.app.services.http_services import HttpService, own_address
from live.app.services.stage_stream import StageStream, byte_parts, text_parts
from live.base.event_queue import PriorityQueue
from live.clock.time_source import Clock
from live.control.camera.phone_landmarks import PhoneCameras
from live.control.events.document import EditDocument, RedoDocument, RestoreDocument, UndoDocument
from live.control.events.event import ControlEvent
from live.show.desk.completions import show_completions
from live.show.loader import LoadedShow
from live.show.patch.patch import Patch
from live.show.patch.section_io import DEFAULT_PERFORMER
from live.show.show import Show

if TYPE_CHECKING:
    from live.app.services.phone_camera import PhoneCameraPort

PREVIEW_MODULE: Final = "live.app.processes.preview_main"
SOURCE: Final = "studio "
"""Source of the edits of pages, followed by their number."""
MAX_ANSWER_LENGTH: Final = 1_000_000
"""A longer answer comes without the texts of its inverse [characters]."""


def preview_files(loaded: LoadedShow, seed: int | None) -> dict[str, Any]:
    """Return the plan of the preview process: what it reads, and the seed of the show."""
    recordings = None if loaded.recordings is None else str(loaded.recordings)
    files = {"module": PREVIEW_MODULE, "patch": str(loaded.path), "recordings": recordings, "seed": seed}
    return {**files, "tempo": asdict(loaded.tempo)}


def performers_of(patch: Patch) -> list[str]:
    """Return the performers whom a phone can see."""
    return [section.name for section in patch.mocap] or [DEFAULT_PERFORMER]


class WebService(HttpService):
    """Runs the process that serves the operator's web page."""

    def __init__(
        self, where: tuple[str, int], key: str, osc: tuple[str, int], show: Show, clock: Clock, *,
        hosts: Sequence[str] = (), stage: StageStream | None = None, files: dict[str, Any] | None = None,
        inbox: PriorityQueue[ControlEvent] | None = None, camera: "PhoneCameraPort | None" = None,
        phones: PhoneCameras | None = None,
    ) -> None:  # fmt: skip
        """`key`: the access key; `osc`: the show's OSC address; `hosts`: see `http_protection.accepted_hosts`;
        `stage`: frames for pages that look at the stage; `files`: the show's, for the preview, see `preview_files`;
        `inbox` gets the edits of pages; `camera`: the port for phones that are cameras, whose landmarks go to
        `phones`."""
        host = {"0.0.0.0": "127.0.0.1", "::": "::1"}.get(osc[0], osc[0])

        def plan() -> dict[str, Any]:
            return {"key": key, "osc": (host, osc[1]), "hosts": list(hosts), "preview": files, **self._surface()}

        super().__init__(where, "--web", "live.control.web.web_server", plan, clock)
        self._key, self._stage, self._show, self._inbox = key, stage, show, inbox
        self._camera, self._phones = camera, phones
        self._texts: deque[list[Any]] = deque()  # packets that may not be left out
        self._answers: deque[tuple[int, str]] = deque()  # the edit's number, and the answer
        self._picture: deque[list[Any]] = deque()  # parts of a picture that may be left out
        self._pictures = 0
        self.join_link: Callable[[], str] = str
        """Returns the invitation for phones, which pages show; empty: no audience can join."""
        self._told_link = ""

    def _surface(self) -> dict[str, Any]:
        """Return what the page's controls are made of."""
        patch = self._show.patch
        half = 0.5 * patch.stage.width, 0.5 * patch.stage.depth
        return {"name": patch.name, "names": show_completions(self._show), "half": half}

    def update_patch(self, patch: Patch) -> None:
        """Show pages an edited patch; their controls when they are loaded again."""
        if self._helper is not None:
            self._helper.send(["surface", self._surface()])
            if self._camera is not None:
                self._helper.send(["performers", performers_of(patch)])
        if self._stage is not None:
            self._stage.update_patch()

    def _listen_also(self) -> tuple[dict[str, Any], tuple[int, ...]]:
        if self._camera is None:
            return {}, ()
        told, inherit = self._camera.listen(resumes=self.resumes)
        return {"camera": told | {"performers": performers_of(self._show.patch)}}, inherit

    def stop(self) -> None:
        """Stop the process and close its ports."""
        super().stop()
        if self._camera is not None:
            self._camera.close()

    def _on_packet(self, packet: Any) -> None:
        """Put an edit of a page into the show's inbox; pass a phone's landmarks on."""
        match packet:
            case ("landmarks", str(phone), str(performer), bytes(data), float(arrival)) if self._phones is not None:
                self._phones.take(phone, performer, data, arrival)
            case (str(word), int(number), str(text), *rest) if self._inbox is not None:
                time, source = self._clock.now(), f"{SOURCE}{number}"
                match word, rest:
                    case "edit", []:
                        self._inbox.put(EditDocument(time=time, source=source, edit=text))
                    case "undo", _:
                        self._inbox.put(UndoDocument(time=time, source=source, by=text))
                    case "redo", _:
                        self._inbox.put(RedoDocument(time=time, source=source, by=text))
                    case "restore", [int(revision)]:
                        self._inbox.put(RestoreDocument(time=time, source=source, revision=revision, by=text))

    def answer(self, event: ControlEvent, answer: dict[str, Any]) -> None:
        """Send the answer to an edit to the page that it came from. Thread: any."""
        if not event.source.startswith(SOURCE):
            return
        text = json.dumps(answer)
        if len(text) > MAX_ANSWER_LENGTH and answer.get("inverse"):
            text = json.dumps({**answer, "inverse": {**answer["inverse"], "exact": None}})
        self._answers.append((int(event.source.removeprefix(SOURCE)), text))

    @property
    def wants_picture(self) -> bool:
        """Whether a page looks at the projected picture, and the last one has been sent."""
        return not self._picture and bool((self.status().get("stage") or {}).get("picture"))

    def put_picture(self, picture: npt.NDArray[np.uint8]) -> None:
        """Send a small picture to the pages in the next frames: RGB, uint8, shape (height, width, 3)."""
        self._pictures += 1
        height, width = picture.shape[:2]
        data = struct.pack("<HH", width, height) + picture.tobytes()
        self._picture.extend(byte_parts("picture", self._pictures, data))

    def _on_start(self) -> None:
        super()._on_start()
        self._told_link = ""

    def frame(self) -> None:
        """Send changed values, the invitation, and frames of the stage for the pages that look at it."""
        super().frame()
        link = self.join_link()
        if link != self._told_link and self._helper is not None and self._helper.send(["join", link]):
            self._told_link = link
        if self._helper is None or self._stage is None:
            return
        wants = self._helper.status().get("stage")
        if not wants:  # another process has not told yet
            self._texts.clear()
        for packet in self._stage.packets(self._clock.now(), wants):
            if packet[0] == "text" and packet[1] != "clock":
                self._texts.append(packet)
            else:
                self._helper.send(packet)  # one that finds no room is left out
        while self._answers:
            number, text = self._answers.popleft()
            self._texts.extend(text_parts("answer", number, text))
        while self._texts and self._helper.send(self._texts[0]):
            self._texts.popleft()
        if self._picture and not self._texts:
            self._helper.send(self._picture.popleft())  # one part a frame: the rest of the channel is free

    def start(self) -> None:
        """Listen, start the process and print the link; raise PersonError if that fails."""
        super().start()
        link, key = f"http://{_link_host(self._bind_address[0])}:{self.port}", f"#key={self._key}"
        console = Console(stderr=True, highlight=False)
        console.print(f"operator's page: {link}/{key}", soft_wrap=True, markup=False)
        console.print(f"studio: {link}/studio{key}", soft_wrap=True, markup=False)
        if self._camera is not None:
            self._camera.print_link()


def _link_host(host: str) -> str:
    """Return the host as written in a web address; for all interfaces, this machine's address."""
    if host not in ("0.0.0.0", "::"):
        return f"[{host}]" if ":" in host else host
    return own_address()
