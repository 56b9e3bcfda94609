"""Recording: the running show's picture, and its music, into a film that keeps time whatever the frame rate does."""

from pathlib import Path

import moderngl
from rich.console import Console

from live.app.wish import Wish
from live.base.errors import PersonError
from live.control.audio.music_file import Music
from live.render.film.film_sound import FilmSound
from live.render.film.film_writer import FilmError, FilmWriter, PictureWriter
from live.render.film.image_sequence import PictureFolder
from live.render.headless import is_software
from live.render.readback import FrameReader

SOFTWARE_FPS = 30.0


def film_sound(music: Music | None) -> FilmSound | None:
    """The music that is played, from its beginning, again and again."""
    return None if music is None else FilmSound.of(music.samples, music.sample_rate, loop=True)


def film_writer(
    path: Path, *, size: tuple[int, int], fps: float, sound: FilmSound | None, alpha: bool = False
) -> PictureWriter:
    """A film with its sound, of the kind that its name says; PersonError if it cannot be made."""
    try:
        if path.suffix.lower() == ".png":
            return PictureFolder(path, size=size, fps=fps, sound=sound, alpha=alpha)
        return FilmWriter(path, size=size, fps=fps, sound=sound, alpha=alpha)
    except FilmError as error:
        raise PersonError(str(error)) from None


def live_rate(wish: Wish, ctx: moderngl.Context, refresh_hz: float = 0.0) -> float:
    """Frames per second of a live show: as wished, else the display's, but 30 where the processor draws.

    A processor that draws as fast as it can leaves no time to the threads that listen and film, and stutters besides.
    """
    if wish.fps is not None:
        return wish.fps
    return SOFTWARE_FPS if is_software(ctx) else refresh_hz or wish.film_fps


class LiveRecording:
    """Films a framebuffer while the show runs: drops pictures rather than hold it up, and keeps time.

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
        """Take the picture just drawn at `time` [s of the show]: once, more often, or not at all, as the rate asks."""
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
        """Complete the film, and say what became of it."""
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
            dropped = f"; {self._writer.dropped} pictures were left out: a lower --fps or --size leaves out fewer"
        console.print(f"the film is here: {self._writer.path.resolve()}{dropped}", soft_wrap=True, markup=False)
