"""What is drawn of a live show, watched: where its time goes, and how much quality it can afford."""

from typing import Any

from live.base.errors import PersonError
from live.base.stage_view import StageView
from live.cli.session import Session
from live.render.frame_times import FrameTimes
from live.render.ladder import Ladder
from live.render.renderer import Renderer
from live.show.patch import Patch


class DrawingWatch:
    """Belongs to one window; called around every frame."""

    def __init__(self, session: Session, renderer: Renderer) -> None:
        self._renderer = renderer
        self.times = FrameTimes(session.clock.now)
        self._ladder = Ladder(len(renderer.steps))
        self._late = 0
        self.period = 0.0
        """What a frame should take [s]."""
        session.engine.mark = renderer.mark = self.times.mark
        session.status.more["quality"] = self.quality
        session.status.more["frame_parts"] = self.times.facts
        session.status.notes.append(self._words)
        self._problem = ""
        session.status.notes.append(lambda: self._problem)

    def take_patch(self, patch: Patch) -> None:
        """Another patch is in force: its own passes may have other texts."""
        try:
            self._renderer.take_own(patch.picture.own_passes)
            self._problem = ""
        except PersonError as error:
            self._problem = f"{error}; the last good one goes on"

    def begin(self, late: int, seconds: float) -> None:
        """A frame begins, `seconds` after the last one; `late` frames so far."""
        was_late, self._late = late > self._late, late
        self.times.judge(self.period, late=was_late)
        step = self._ladder.frame(was_late, seconds, self.times.load(self.period))
        self.times.begin()
        if step != self._renderer.step:
            self._renderer.take_step(step)

    def graph(self, view: StageView) -> None:
        """Let the overlay show the last frames."""
        graph = self._renderer.graph
        graph.period = self.period * 1e3 if view.overlay else 0.0
        if view.overlay:
            graph.count = self.times.recent(graph.times)

    def end(self) -> None:
        """A frame is over."""
        self.times.mark("swap")
        self.times.end()

    def quality(self) -> dict[str, Any]:
        """For the status: the step of the ladder that is drawn, and what it leaves out."""
        steps, step = self._renderer.steps, self._renderer.step
        left_out = [one.name for one in steps[1 : step + 1]]
        return {"step": step, "of": len(steps), "left_out": left_out, "changes": self._ladder.changes}

    def _words(self) -> str:
        told = self.quality()
        blamed = [f"{name} {count}" for name, count in self.times.blamed.items() if count]
        words = [f"quality {told['step']} of {told['of'] - 1}: {', '.join(told['left_out'])}"] if told["step"] else []
        return "   ".join([*words, f"late by {', '.join(blamed)}"] if blamed else words)
