"""Recording of a running show to a film, and sharing of its picture by shared memory, network streams or web pages."""

from pathlib import Path
from typing import Protocol

import moderngl
from rich.console import Console

from live.app.launch_options import LaunchOptions
from live.base.errors import PersonError
from live.base.system.picture_ring import FrameRing
from live.control.audio.music_file import Music
from live.render.film.film_writer import FilmError, FilmWriter, PictureWriter
from live.render.film.image_sequence import ImageSequenceWriter
from live.render.film.network_stream import NetworkStream
from live.render.film.streams import FilmSound
from live.render.headless import FrameReader, Picture, is_software
from live.render.outputs.projection import PictureSampler

SOFTWARE_FPS = 30.0
PAGE_INTERVAL = 0.25
"""Time between two pictures for web pages [s]."""


def film_sound(music: Music | None) -> FilmSound | None:
    """Return the music as a film's sound, looped from its beginning; None without music."""
    return None if music is None else FilmSound.from_samples(music.samples, music.sample_rate, loop=True)


def film_writer(
    path: Path, *, size: tuple[int, int], fps: float, sound: FilmSound | None, alpha: bool = False, first: int = 0
) -> PictureWriter:
    """Open a film with sound, in the format of its file name; raise PersonError if that fails. `first`: number of its
    first frame in the whole show."""
    try:
        if path.suffix.lower() == ".png":
            return ImageSequenceWriter(path, size=size, fps=fps, sound=sound, alpha=alpha, first=first)
        return FilmWriter(path, size=size, fps=fps, sound=sound, alpha=alpha, first=first)
    except FilmError as error:
        raise PersonError(str(error)) from None


def live_fps(options: LaunchOptions, ctx: moderngl.Context, refresh_hz: float = 0.0) -> float:
    """Return the frames per second of a live show: as in `options`, else the display's rate; 30 with software OpenGL.

    Software OpenGL at full rate would stutter and starve the threads for audio and film.
    """
    if options.fps is not None:
        return options.fps
    return SOFTWARE_FPS if is_software(ctx) else refresh_hz or options.film_fps


class LiveRecording:
    """Records a framebuffer while the show runs; drops or repeats pictures to keep time, and never blocks the show.

    Thread: the main thread, which owns the OpenGL context.
    """

    def __init__(
        self, path: Path, ctx: moderngl.Context, size: tuple[int, int], fps: float, music: Music | None
    ) -> None:
        try:
            self._writer = FilmWriter(path, size=size, fps=fps, sound=film_sound(music), live=True)
        except FilmError as error:
            raise PersonError(str(error)) from None
        self._reader = FrameReader(ctx, size)
        self._fps = fps
        self._written = 0
        self._failed: FilmError | None = None

    def frame(self, framebuffer: moderngl.Framebuffer, time: float) -> None:
        """Record the picture drawn at `time` [s of the show] once, repeatedly or never, to match the film's rate."""
        picture = self._reader.push(framebuffer)
        due = int(time * self._fps)
        if picture is None or self._failed is not None:
            return
        try:
            if due > self._written:
                self._writer.write(picture, due - self._written)
                self._written = due
        except FilmError as error:  # a full disk ends the film, not the show
            self._failed = error

    def close(self, console: Console) -> None:
        """Complete the film, and print the result."""
        try:
            self._writer.close()
        except FilmError as error:
            self._failed = error
        self._reader.release()
        if self._failed is not None:
            console.print(f"the film is not complete: {self._failed}", style="red", markup=False)
            return
        for note in self._writer.notes:
            console.print(f"note: {note}", style="yellow", markup=False)
        dropped = ""
        if self._writer.dropped:
            dropped = f"; {self._writer.dropped} pictures were dropped: try a lower --fps or --size"
        console.print(f"the film is here: {self._writer.path.resolve()}{dropped}", soft_wrap=True, markup=False)


class LiveSharing:
    """Passes every picture to shared memory and streams, without waiting for them.

    Thread: the main thread, which owns the OpenGL context.
    """

    def __init__(
        self, shares: tuple[str, ...], ctx: moderngl.Context, size: tuple[int, int], fps: float, music: Music | None
    ) -> None:
        """`shares`: as returned by `option_values.parse_shares`; raise PersonError if one cannot be opened."""
        self._rings: list[FrameRing] = []
        self._streams: list[NetworkStream] = []
        for share in shares:
            try:
                if share.startswith("shm:"):
                    self._rings.append(FrameRing(share[4:], size))
                else:
                    self._streams.append(NetworkStream(share, size=size, fps=fps, sound=film_sound(music)))
            except (ValueError, OSError) as error:
                self._close()
                raise PersonError(f"--share {share}: {error}") from None
        self._reader = FrameReader(ctx, size)
        self._fps, self._frame, self._time = fps, -1, 0.0

    def frame(self, framebuffer: moderngl.Framebuffer, time: float) -> None:
        """Read the picture drawn at `time` [s of the show]; it is passed on in the next call."""
        picture, drawn = self._reader.push(framebuffer), self._time
        self._time = time
        if picture is None:
            return
        for ring in self._rings:
            ring.write(picture, drawn)
        frame = int(drawn * self._fps)
        if frame > self._frame:
            self._frame = frame
            for stream in self._streams:
                stream.write(picture, frame)

    def problem_text(self) -> str:
        """Return the streams that fail now and why, for the overlay; empty if there is none."""
        return "; ".join(f"{stream.url}: {stream.error}" for stream in self._streams if stream.error)

    def facts(self) -> dict[str, dict[str, int | str]]:
        """Return pictures sent and dropped and the problem, by address, for the status."""
        told: dict[str, dict[str, int | str]] = {}
        for ring in self._rings:
            told[f"shm:{ring.path.name}"] = {"sent": ring.frames, "dropped": 0, "trouble": ""}
        for one in self._streams:
            told[one.url] = {"sent": one.sent, "dropped": one.dropped, "trouble": one.error}
        return told

    def _close(self) -> None:
        for ring in self._rings:
            ring.close()
        for stream in self._streams:
            stream.close()

    def close(self, console: Console) -> None:
        """Close shared memory and streams, and print the result of the streams."""
        self._close()
        self._reader.release()
        for stream in self._streams:
            told = f"{stream.url}: {stream.sent} pictures sent"
            told += f", {stream.dropped} dropped" if stream.dropped else ""
            told += f" ({stream.error})" if stream.error else ""
            console.print(told, style="dim", soft_wrap=True, markup=False)


class PicturePages(Protocol):
    """Web pages that show the picture as it is projected."""

    @property
    def wants_picture(self) -> bool:
        """Whether a page looks at it, and the last one has been sent."""

    def put_picture(self, picture: Picture) -> None:
        """Show a picture: RGB, uint8, shape (height, width, 3); copied if kept."""


class LivePages:
    """Passes small pictures to web pages, a few in a second, while one looks. Thread: as `LiveSharing`."""

    def __init__(self, pages: PicturePages, ctx: moderngl.Context, size: tuple[int, int]) -> None:
        self._pages, self._sampler, self._next = pages, PictureSampler(ctx, size), 0.0

    def frame(self, framebuffer: moderngl.Framebuffer, time: float) -> None:
        """Pass on the picture that was begun, or begin one of what was drawn at `time` [s of the show]."""
        if (picture := self._sampler.take()) is not None:
            self._pages.put_picture(picture)
        elif time >= self._next and self._pages.wants_picture:
            self._next = time + PAGE_INTERVAL
            self._sampler.start(framebuffer)

    def close(self, console: Console) -> None:
        """Free what it made; there is no result to print."""
        self._sampler.release()
