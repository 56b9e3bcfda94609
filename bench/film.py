"""Films and sharing: what they cost the frame loop of a live show, and how fast films are written."""

import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import numpy.typing as npt

from live.base.system.picture_ring import FrameRing
from live.cli.bench import Row
from live.render.film.film_writer import FilmWriter, PictureWriter
from live.render.film.image_sequence import ImageSequenceWriter
from live.render.film.network_stream import NetworkStream
from live.render.headless import OffscreenTarget, create_headless_context

SIZE = (1280, 720)
FPS = 30.0

Picture = npt.NDArray[np.uint8]


def run(full: bool, shared: Path | None) -> list[Row]:
    """Median time of a call in the frame loop, paced at 30 pictures/s; films in pictures/s. The bar is a quarter of
    what is left of a frame's 33 ms beside 20 ms of drawing."""
    pictures = _pictures()
    rows = [_read_back()]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder)
        rows += _live(path, pictures, 90 if full else 30)
        rows += _written(path, pictures, 60 if full else 20)
    return rows


def _pictures() -> list[Picture]:
    """A soft picture that moves: neither as easy as black nor as hard as noise."""
    x, y = np.meshgrid(np.linspace(0, 6, SIZE[0]), np.linspace(0, 4, SIZE[1]))
    waves = [
        127 + 60 * np.sin(x + t / 5)[..., None] * np.cos(y * (1 + np.arange(4) / 3)[:, None, None]).transpose(1, 2, 0)
        for t in range(8)
    ]
    return [wave.astype(np.uint8) for wave in waves]


def _read_back() -> Row:
    ctx = create_headless_context()
    target = OffscreenTarget(ctx, SIZE)
    took = []
    for number in range(30):
        target.framebuffer.use()
        target.framebuffer.clear(number / 30)
        ctx.finish()
        begin = time.perf_counter()
        target.push()
        took.append(time.perf_counter() - begin)
    target.release()
    ctx.release()
    return Row("picture back from the card", float(np.median(took[3:])) * 1e3, "ms", 3.0)


def _live(folder: Path, pictures: list[Picture], count: int) -> list[Row]:
    ring = FrameRing("choreographics-bench", SIZE)
    stream = NetworkStream("udp://127.0.0.1:49151", size=SIZE, fps=FPS)
    film = FilmWriter(folder / "live.mp4", size=SIZE, fps=FPS, live=True)
    takers: list[tuple[str, Callable[[Picture, int], None]]] = [
        ("shared in memory", lambda picture, frame: ring.write(picture, frame / FPS)),
        ("sent as a stream", stream.write),
        ("recorded", lambda picture, frame: film.write(picture)),
    ]
    plain = [np.ascontiguousarray(picture[..., :3]) for picture in pictures]
    copies = [_paced(lambda picture, frame: np.copyto(plain[-1], picture), plain[0][::-1], n) for n in range(20)]
    peers = {"a copy of the picture": float(np.median(copies)) * 1e3}
    rows = []
    for name, take in takers:
        took = [_paced(take, plain[n % len(plain)][::-1], n) for n in range(count)]
        rows.append(Row(f"{name}: in the frame", float(np.median(took)) * 1e3, "ms", 3.0, peers=peers))
        rows.append(Row(f"{name}: in the frame, longest", float(np.max(took)) * 1e3, "ms"))
    ring.close()
    stream.close()
    film.close()
    rows.append(Row("sent as a stream: left out", float(stream.dropped), f"of {count}"))
    rows.append(Row("recorded: left out", float(film.dropped), f"of {count}"))
    return rows


def _paced(take: Callable[[Picture, int], None], picture: Picture, frame: int) -> float:
    begin = time.perf_counter()
    take(picture, frame)
    took = time.perf_counter() - begin
    time.sleep(max(1.0 / FPS - took, 0.0))
    return took


def _written(folder: Path, pictures: list[Picture], count: int) -> list[Row]:
    makers: list[tuple[str, Callable[[], PictureWriter]]] = [
        ("H.264", lambda: FilmWriter(folder / "a.mp4", size=SIZE, fps=FPS)),
        ("ProRes 4444 with alpha", lambda: FilmWriter(folder / "a.mov", size=SIZE, fps=FPS, alpha=True)),
        ("FFV1 with alpha", lambda: FilmWriter(folder / "a.mkv", size=SIZE, fps=FPS, alpha=True)),
        ("PNG with alpha", lambda: ImageSequenceWriter(folder / "%05d.png", size=SIZE, fps=FPS, alpha=True)),
    ]
    rows = []
    for name, make in makers:
        channels = 3 if name == "H.264" else 4
        given = [np.ascontiguousarray(picture[..., :channels]) for picture in pictures]
        begin = time.perf_counter()
        with make() as film:
            for number in range(count):
                film.write(given[number % len(given)])
        rows.append(Row(f"{name}: written", count / (time.perf_counter() - begin), "pictures/s"))
    return rows
