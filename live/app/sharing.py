"""Sharing: the running show's picture for other programs, in memory or over the network."""

import moderngl
from rich.console import Console

from live.app.recording import film_sound
from live.base.errors import PersonError
from live.control.audio.music_file import Music
from live.render.film.network_stream import SharedStream
from live.render.film.shared_memory import SharedRing
from live.render.readback import FrameReader


class LiveSharing:
    """Hands every picture on to rings and streams; never waits for them.

    Thread: the main thread, which owns the OpenGL context.
    """

    def __init__(
        self, shares: tuple[str, ...], ctx: moderngl.Context, size: tuple[int, int], fps: float, music: Music | None
    ) -> None:
        """`shares` as `parse_shares` gives them; PersonError if one cannot be made."""
        self._rings: list[SharedRing] = []
        self._streams: list[SharedStream] = []
        for share in shares:
            try:
                if share.startswith("shm:"):
                    self._rings.append(SharedRing(share[4:], size))
                else:
                    self._streams.append(SharedStream(share, size=size, fps=fps, sound=film_sound(music)))
            except (ValueError, OSError) as error:
                self._close()
                raise PersonError(f"--share {share}: {error}") from None
        self._reader = FrameReader(ctx, size)
        self._fps, self._frame, self._time = fps, -1, 0.0

    def frame(self, framebuffer: moderngl.Framebuffer, time: float) -> None:
        """Take the picture just drawn at `time` [s of the show]; it is handed on with the next one."""
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

    def words(self) -> str:
        """For the overlay: what is not sent now, and why; empty if all is well."""
        return "; ".join(f"{stream.url}: {stream.trouble}" for stream in self._streams if stream.trouble)

    def facts(self) -> dict[str, dict[str, int | str]]:
        """For the status: pictures sent and left out, by address, and what is wrong."""
        told: dict[str, dict[str, int | str]] = {}
        for ring in self._rings:
            told[f"shm:{ring.path.name}"] = {"sent": ring.pictures, "dropped": 0, "trouble": ""}
        for one in self._streams:
            told[one.url] = {"sent": one.sent, "dropped": one.dropped, "trouble": one.trouble}
        return told

    def _close(self) -> None:
        for ring in self._rings:
            ring.close()
        for stream in self._streams:
            stream.close()

    def close(self, console: Console) -> None:
        """End rings and streams, and say what became of them."""
        self._close()
        self._reader.release()
        for stream in self._streams:
            told = f"{stream.url}: {stream.sent} pictures sent"
            told += f", {stream.dropped} left out" if stream.dropped else ""
            told += f" ({stream.trouble})" if stream.trouble else ""
            console.print(told, style="dim", soft_wrap=True, markup=False)
