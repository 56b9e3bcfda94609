"""Adaptive quality of one live renderer: times its frames and sets its quality step.

Every live picture uses it: in a window, headless, and in the benchmark.
"""

from collections.abc import Callable
from typing import Any

from live.render.adaptive_quality import QualityController
from live.render.renderer import Renderer
from live.render.timing.frame_stats import FrameTimes


class FrameBudget:
    """Quality control of one renderer made with all its `steps`; called around every frame. Thread: the show's."""

    def __init__(self, renderer: Renderer, now: Callable[[], float], period: float = 0.0) -> None:
        """`now()`: monotonic time [s]; `period`: target time of a frame [s]."""
        self._renderer, self.period = renderer, period
        self.times = FrameTimes(now)
        self.controller = QualityController(len(renderer.steps), renderer.has_effect)
        self.overload: Callable[[], float] = lambda: 0.0
        """Returns the overload of the whole machine, 0 to 1."""
        self._late_count = 0
        renderer.mark = self.times.mark

    def begin(self, late: int, seconds: float) -> None:
        """Begin a frame, `seconds` after the last one; `late`: number of late frames so far (`Pacer.late`)."""
        was_late, self._late_count = late > self._late_count, late
        self.times.record_cause(self.period, late=was_late)
        step = self.controller.update(was_late, seconds, self.times.load(self.period), self.overload())
        self.times.begin()
        if step != self._renderer.step:
            self._renderer.set_step(step)

    def end(self) -> None:
        """End the frame."""
        self.times.mark("swap")
        self.times.end()

    def facts(self) -> dict[str, Any]:
        """Return the status: current quality step, what it leaves out, and the step held by the operator."""
        steps, step = self._renderer.steps, self._renderer.step
        left_out = [one.name for one in steps[1 : step + 1]]
        changes, held = self.controller.changes, self.controller.held
        return {"step": step, "of": len(steps), "left_out": left_out, "changes": changes, "held": held}

    def overlay_text(self) -> str:
        """Return the overlay text: the step and what it leaves out; empty for the best step if it is not held."""
        told = self.facts()
        if not told["step"] and told["held"] is None:
            return ""
        held = " (held)" if told["held"] is not None else ""
        without = f": {', '.join(told['left_out'])}" if told["left_out"] else ""
        return f"quality {told['step']} of {told['of'] - 1}{held}{without}"
