"""The page of `live calibrate camera`: shows the camera's picture, takes clicks, answers with the camera they give.

Pictures go to the page that asks for them, under its key, and nowhere else. What is saved is what `FloorMarks` finds,
the same that a show uses.
"""

import asyncio
import io
import json
import socket
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, Final, Literal

import numpy as np
from PIL import Image
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from live.base.errors import PersonError
from live.bridges.camera.floor_marks import MOST_MARKS, Clicks, FloorMarks, Points
from live.bridges.camera.stage_camera import StageCamera
from live.control.camera.frame_source import FrameSource
from live.control.web.studio_files import StudioFiles
from live.control.web.studio_server import Frames, StudioServer
from live.motion.capture.camera_view import CameraView

ROOT: Final = "/marks"
WORD_PATH: Final = "/marks/words"
"""Path of the page's WebSocket."""
MAX_BYTES: Final = 8192
"""Maximum bytes of a message."""
_FOLDER: Final = Path(__file__).with_name("page")
_WAIT_S: Final = 1.0
"""Longest wait for a picture [s]; then the page asks again."""
_JPEG_QUALITY: Final = 90

Share = Annotated[float, Field(ge=-1, le=2, allow_inf_nan=False)]
Place = Annotated[list[Share], Field(min_length=2, max_length=2)]
Save = Callable[[Clicks, CameraView], str]
"""Keeps what was clicked, returns where in words; PersonError if that is not possible. It may take long."""


class Words(BaseModel):
    """A message of the page: it asks for a picture, for a check, or to save."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)
    kind: Literal["picture", "check", "save"]
    turn: Literal[0, 90, 180, 270] = 0
    """By how many degrees the picture is turned, counter-clockwise."""
    after: Annotated[int, Field(ge=0, le=2**53)] = 0
    """A picture with a greater number is wanted."""
    places: Annotated[list[Place], Field(max_length=MOST_MARKS)] = []
    screen: Annotated[list[Place], Field(max_length=4)] = []


class MarksPage:
    """Serves until marks were saved. Thread: the loop's; pictures are read and saved in others."""

    def __init__(self, marks: FloorMarks, camera: StageCamera, source: FrameSource, save: Save, where: str) -> None:
        """`camera`: what the venue has of it; `source`: running; `where`: what saving does, in words."""
        self._marks, self._camera, self._source, self._save, self._where = marks, camera, source, save, where
        self._size = (0, 0)
        """Width and height of the camera's picture before it is turned; zeros before there was one."""
        self._found: asyncio.Future[tuple[Clicks, CameraView]] | None = None
        self._saves = asyncio.Lock()

    async def run(self, listening: socket.socket, key: str) -> tuple[Clicks, CameraView]:
        """Serve, and return what was saved."""
        found: asyncio.Future[tuple[Clicks, CameraView]] = asyncio.get_running_loop().create_future()
        self._found = found
        files = StudioFiles(_FOLDER, ROOT)
        server = StudioServer(listening, key, self.facts, WORD_PATH, self._take, max_bytes=MAX_BYTES, files=files)
        await server.run_until(found)
        return found.result()

    def facts(self) -> dict[str, Any]:
        """Return what the page has to know: the marks, and what the venue has of the camera."""
        camera, marks = self._camera, [list(each) for each in self._marks.marks]
        known = [list(each[2:]) for each in camera.marks if 0.0 <= min(each[2:]) <= max(each[2:]) <= 1.0]
        same = len(known) == len(marks) and marks == [list(each[:2]) for each in camera.marks]
        return {
            "name": camera.name, "camera": self._source.address.label, "marks": marks, "turn": camera.turn_deg,
            "places": known if same else [], "screen": [list(each) for each in camera.screen], "where": self._where,
        }  # fmt: skip

    async def _take(self, text: str) -> Frames:
        try:
            words = Words.model_validate(json.loads(text))
        except (ValueError, RecursionError) as error:
            first = error.errors(include_url=False)[0]["msg"] if isinstance(error, ValidationError) else "no JSON"
            return [json.dumps({"kind": "refused", "problem": f"wrong message: {first}"[:200], "remedy": ""})]
        if words.kind == "picture":
            return await asyncio.to_thread(self._picture, words)
        try:
            if words.kind == "check":
                return [json.dumps(await asyncio.to_thread(self._check, words))]
            async with self._saves:
                return [json.dumps(await self._keep(words))]
        except PersonError as error:
            kind = "checked" if words.kind == "check" else "refused"
            return [json.dumps({"kind": kind, "problem": error.message, "remedy": error.remedy or ""})]

    def _picture(self, words: Words) -> Frames:
        """Return the newest picture as a JPEG, after a line about it; a line alone if there is none. Thread: any."""
        frame = self._source.newest(words.after, _WAIT_S)
        if frame is None:
            problem = self._source.problem or "it has sent no new picture"
            return [json.dumps({"kind": "none", "problem": problem})]
        height, width = frame.picture.shape[:2]
        self._size = (width, height)
        picture = Image.fromarray(np.rot90(frame.picture, words.turn // 90))
        buffer = io.BytesIO()
        picture.save(buffer, "JPEG", quality=_JPEG_QUALITY)
        told = {"kind": "picture", "number": frame.number, "turn": words.turn, "size": list(picture.size)}
        return [json.dumps(told), buffer.getvalue()]

    def _find(self, words: Words) -> tuple[Clicks, CameraView]:
        clicks = Clicks(_points(words.places), _points(words.screen), words.turn)
        width, height = self._size
        if not width:
            raise PersonError("the camera has sent no picture yet", "is it plugged in, and used by no other program?")
        return clicks, self._marks.find_camera(clicks, turned_aspect(width, height, words.turn))

    def _check(self, words: Words) -> dict[str, Any]:
        """Return the grid as the camera sees it, and where the camera stands. Thread: any."""
        clicks, view = self._find(words)
        facts = self._marks.describe(view, clicks)
        return {"kind": "checked", "problem": "", "remedy": "", **self._marks.grid(view), **facts}

    async def _keep(self, words: Words) -> dict[str, Any]:
        if self._found is None or self._found.done():
            raise PersonError("the marks were saved by another page", "close this one")
        clicks, view = await asyncio.to_thread(self._find, words)
        told = await asyncio.to_thread(self._save, clicks, view)
        asyncio.get_running_loop().call_soon(self._found.set_result, (clicks, view))
        return {"kind": "saved", "words": told}


def _points(pairs: list[list[float]]) -> Points:
    return tuple((u, v) for u, v in pairs)


def turned_aspect(width: int, height: int, turn_deg: int) -> float:
    """Return the width over the height of a picture that is turned."""
    return width / height if turn_deg % 180 == 0 else height / width
