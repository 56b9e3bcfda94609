"""Takers: who takes the pictures of a running show beside its window: a film, other programs."""

import moderngl
from rich.console import Console

from live.app.recording import LiveRecording, live_rate
from live.app.session import Session
from live.app.sharing import LiveSharing
from live.base.fault_isolation import Bulkhead, name_of


class Takers:
    """All of them; none costs nothing. Thread: the main thread, which owns the OpenGL context."""

    def __init__(
        self, session: Session, ctx: moderngl.Context, size: tuple[int, int], *, sharing: LiveSharing | None = None
    ) -> None:
        """As was wished for; PersonError if one cannot be made. `sharing`: made already, and not ended here."""
        self._lent = sharing
        wish, music, fps = session.wish, session.sound.music, live_rate(session.wish, ctx)
        self._calls = Bulkhead()
        self._all: list[LiveRecording | LiveSharing] = []
        if wish.record is not None:
            self._all.append(LiveRecording(wish.record, ctx, size, fps, music))
        if wish.share:
            sharing = sharing or LiveSharing(wish.share, ctx, size, fps, music)
            self._all.append(sharing)
            session.status.notes.append(sharing.words)
            session.status.more["shared"] = sharing.facts

    @property
    def any(self) -> bool:
        """Whether there is one."""
        return bool(self._all)

    def frame(self, framebuffer: moderngl.Framebuffer, time: float) -> None:
        """The picture just drawn at `time` [s of the show]."""
        for each in self._all:
            self._calls.call(name_of(each.frame), each.frame, framebuffer, time)

    def close(self, console: Console) -> None:
        """End them, and say what became of each."""
        for each in self._all:
            if each is not self._lent:
                each.close(console)
