"""Process that draws parts of a film: it is told the film once, then one part after the other.

Messages are lines of JSON, on standard input and output; `live/app/film/film_worker.py` has the other end. It ends
when its input does.
"""

import contextlib
import json
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from live.app.film.film_output import PictureOutput
from live.app.film.film_plan import FilmPart
from live.app.film.film_worker import FilmOrder, check_needs, part_from_json
from live.app.film.replay_film import FilmLook, draw_part
from live.app.film.show_film import make_renderer
from live.app.launch_options import LaunchOptions
from live.base.errors import PersonError
from live.base.jit import KERNEL_SET
from live.clock.ticks import FrameGrid
from live.render.film.film_parts import PartWriter
from live.render.film.film_writer import FilmError
from live.render.film.image_sequence import ImageSequenceWriter
from live.show.journal.journal_reader import Journal, JournalError, read_journal
from live.show.journal.replay import Replayer, ReplayError, load_journal
from live.show.loader import LoadedShow
from live.show.view.render_scene import draw_patch

Tell = Callable[[dict[str, Any]], None]


class FilmDrawing:
    """Draws parts of one film with one renderer. Thread: one, which owns the OpenGL context."""

    def __init__(self, order: FilmOrder, stack: contextlib.ExitStack) -> None:
        """PersonError if it cannot be drawn here; the message names what is missing."""
        check_needs(order)
        self.order = order
        try:
            self.journal: Journal = read_journal(Path(order.journal))
            self.loaded: LoadedShow = load_journal(self.journal)
        except (JournalError, ReplayError) as error:
            raise PersonError(str(error)) from None
        self.look = FilmLook(order.size, FrameGrid(order.fps), fine=order.fine, alpha=order.alpha)
        options = LaunchOptions(size=order.size, fps=order.fps)
        self._target, self._renderer = make_renderer(stack, options, self.loaded, order.fine, alpha=order.alpha)
        self.gl = str(self._target.framebuffer.ctx.info["GL_RENDERER"])
        """Name of the OpenGL driver: others draw other pictures."""

    def draw(self, part: FilmPart, out: Path, tell: Tell) -> dict[str, Any]:
        """Draw a part to the file `out`, or as pictures; return hashes of the pictures before its first one and of its
        last one. PersonError if it cannot be drawn or written."""
        order, film = self.order, Path(self.order.film)
        start = part.start(self.journal, self.loaded)
        running = Replayer(start.show, self.journal.lines_with_damage(), tick=start.tick, compare=False)
        writer: ImageSequenceWriter | PartWriter
        try:
            if film.suffix.lower() == ".png":
                pattern = out / film.name
                writer = ImageSequenceWriter(
                    pattern, size=order.size, fps=order.fps, alpha=order.alpha, first=part.first
                )  # fmt: skip
            else:
                writer = PartWriter(
                    out, film, size=order.size, fps=order.fps, alpha=order.alpha, first=part.first,
                    threads=order.threads,
                )  # fmt: skip
        except FilmError as error:
            raise PersonError(str(error)) from None
        with writer:
            output = PictureOutput(self._renderer, self._target, writer, film)
            draw_patch(self._renderer, self.loaded.patch)  # as it was before any part
            output.begin_anew(part.titles)
            for _ in draw_part(part, running, output, self.look.grid, self.loaded.patch):
                tell({"drawn": 1})
            output.close()
        return {"before": output.before, "last": output.last}


def main() -> None:
    """Draw what standard input asks for."""
    out = os.fdopen(os.dup(sys.stdout.fileno()), "w", encoding="utf-8")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # nothing else may write between the messages, no driver either

    def tell(message: dict[str, Any]) -> None:
        out.write(json.dumps(message) + "\n")
        out.flush()

    with contextlib.ExitStack() as stack:
        try:
            drawing = FilmDrawing(FilmOrder(**json.loads(sys.stdin.readline())), stack)
            tell({"ready": {"gl": drawing.gl, "kernels": KERNEL_SET}})
            for line in sys.stdin:
                asked = json.loads(line)
                part = part_from_json(asked)
                tell({"done": part.number, **drawing.draw(part, Path(asked["out"]), tell)})
        except PersonError as error:
            tell({"refused": str(error)})
        except BrokenPipeError:  # the film was given up
            return


if __name__ == "__main__":
    main()
