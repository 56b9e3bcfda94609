"""Draw the moving pictures of the documentation: `python tools/draw_docs_films.py [NAME…]`.

Without a name it draws all of docs/films/, which takes some minutes; `--list` prints the names. Each film is danced or
computed by the engine from fixed seeds and encoded in one thread, so that files are the same each time on one machine.
docs/films/README.md says what is seen.
"""

import argparse
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Final

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from tools.docs_films import gallery, group_films, music_films, step_films
from tools.docs_films.film_file import Picture, write_film, write_poster, write_webp

ROOT: Final = Path(__file__).resolve().parent.parent
FOLDER: Final = ROOT / "docs" / "films"
FILM_BYTES: Final = 235_000
EXCERPT_BYTES: Final = 90_000
WEBP_BYTES: Final = 900_000
WEBP_WIDTH: Final = 480
GALLERY: Final = "gallery/"


@dataclass(frozen=True, slots=True)
class Film:
    """One film: how its pictures are drawn, and which share of it has passed at its poster."""

    draw: Callable[[], list[Picture]]
    poster: float = 0.5
    max_bytes: int = FILM_BYTES
    webp: bool = False
    """Whether it is also there as an animated WebP."""


FILMS: Final[dict[str, Film]] = {
    "first-show": Film(gallery.draw_first_show, 0.35, max_bytes=390_000, webp=True),
    "beat-clock": Film(music_films.draw_beat_clock, 0.6),
    "motion-graph": Film(step_films.draw_motion_graph),
    "measure-line": Film(step_films.draw_measure_line),
    "formation": Film(group_films.draw_formation, 0.2),
    "crossing": Film(group_films.draw_crossing, 0.4),
    "elements": Film(group_films.draw_elements, 0.9),
    "canon": Film(group_films.draw_canon, 0.8),
    "sketch-to-step": Film(step_films.draw_sketch_to_step, 0.6),
    "partner": Film(step_films.draw_partner),
    **{
        f"{GALLERY}{name}": Film(partial(gallery.draw_excerpt, name), max_bytes=EXCERPT_BYTES)
        for name in gallery.EXCERPTS
    },
}


def files_of(name: str) -> tuple[Path, ...]:
    """Return the files of a film below docs/films/: film, poster, WebP."""
    film = Path(f"{name}.mp4")
    poster = film.parent / "posters" / f"{film.stem}.jpg"
    return (film, poster, film.with_suffix(".webp")) if FILMS[name].webp else (film, poster)


def main() -> int:
    """Draw the films that are named, or all."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help="films, or gallery/ for all of the gallery")
    parser.add_argument("--list", action="store_true", help="print the names")
    asked = parser.parse_args()
    unknown = [each for each in asked.names if each not in FILMS and each != GALLERY]
    if unknown:
        parser.error(f"no film {', '.join(unknown)}: --list prints the names")
    wanted = [
        name
        for name in FILMS
        if not asked.names or name in asked.names or (GALLERY in asked.names and name.startswith(GALLERY))
    ]
    if asked.list:
        print("\n".join(FILMS))
        return 0
    for name in wanted:
        _draw(name)
    return 0


def _draw(name: str) -> None:
    film = FILMS[name]
    paths = [FOLDER / each for each in files_of(name)]
    for path in paths:
        path.parent.mkdir(parents=True, exist_ok=True)
    pictures = film.draw()
    write_film(pictures, paths[0], film.max_bytes)
    write_poster(pictures[int(film.poster * (len(pictures) - 1))], paths[1])
    if film.webp:
        write_webp(pictures, paths[2], WEBP_BYTES, WEBP_WIDTH)
    for path in paths:
        print(f"{path.relative_to(ROOT)}: {path.stat().st_size // 1000} kB, {len(pictures)} pictures", flush=True)


if __name__ == "__main__":
    raise SystemExit(main())
