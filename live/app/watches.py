"""Watches: what is edited while a show runs: its patch's files, and the steps of its own folder."""

from collections.abc import Callable

from live.control.events.events import ControlEvent
from live.show.core import Show
from live.show.load import LoadedShow
from live.show.patch.hot_reload import PatchWatch
from live.show.selection.library_watch import LibraryWatch


def make_watches(
    loaded: LoadedShow, show: Show, *, post: Callable[[ControlEvent], None], now: Callable[[], float]
) -> tuple[PatchWatch, LibraryWatch | None]:
    """On the patch, and on its steps if they lie in a folder; the first is to be started, and minds the other.

    Takes that are recorded meanwhile join the dance.
    """
    folder, library = loaded.steps_folder, None
    if folder is not None:
        library = LibraryWatch(folder, show.graph, offer=show.offer, post=post, now=now, read=loaded.clips)
    return PatchWatch(loaded, show, post=post, now=now, library=library), library
