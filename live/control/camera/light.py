"""Whether a camera sees well: darkness, back light, strobe, a projection on the bodies, in words for the operator."""

from collections import deque
from collections.abc import Sequence
from typing import Final

import numpy as np

from live.base.arrays import Float64, UInt8
from live.control.camera.costume import colour_difference, costume_colours
from live.control.camera.seen_person import Person

BLACK: Final = 0.02
"""Mean brightness of a picture in which nobody is looked for, 0 to 1."""
_DARK: Final = 0.12
"""Brightness that the brightest tenth of a dark picture stays below."""
_STROBE: Final = 0.08
"""Mean change of brightness from picture to picture that is a strobe."""
_BACK_LIGHT: Final = 0.4
"""A body darker than this share of a bright picture stands against the light."""
_PATTERN: Final = 0.12
"""Difference of a costume from its remembered colours that is a projection on the body."""
_UNSURE: Final = 0.55
"""Mean visibility of the landmarks below which the model guesses."""
_WINDOW: Final = 20
"""Pictures over which is judged."""
_EVERY: Final = 8
"""One pixel in so many, along each edge, is looked at."""


class LightMeter:
    """Judges one camera's pictures. Thread: one."""

    def __init__(self) -> None:
        self.word = ""
        """What is wrong: `dark`, `strobe`, `back light`, `projection on the body`, `unsure`; empty: nothing."""
        self.brightness = 0.0
        """Mean brightness of the last picture, 0 to 1."""
        self._bright: deque[float] = deque(maxlen=_WINDOW)
        self._pattern: deque[float] = deque(maxlen=_WINDOW)
        self._sure: deque[float] = deque(maxlen=_WINDOW)

    def look(self, picture: UInt8) -> bool:
        """Measure a picture (H, W, 3); return whether it is worth looking for people."""
        self._few = picture[::_EVERY, ::_EVERY].mean(axis=2) / 255.0
        self.brightness = float(self._few.mean())
        self._bright.append(self.brightness)
        return self.brightness > BLACK

    def judge(self, picture: UInt8, people: Sequence[Person]) -> str:
        """Judge the picture (H, W, 3) last looked at, in which these people were seen; return `word`."""
        for person in people:
            self._sure.append(float(person.pose.visibility[11:].mean()))
            if not person.is_crossing:
                seen = costume_colours(picture, person.pose.picture, person.pose.visibility)
                apart = colour_difference(person.colours, seen)
                if np.isfinite(apart):
                    self._pattern.append(apart)
        self.word = self._judgement(picture, people)
        return self.word

    def _judgement(self, picture: UInt8, people: Sequence[Person]) -> str:
        bright = np.array(self._bright)
        if len(bright) >= _WINDOW and float(np.abs(np.diff(bright)).mean()) > _STROBE:
            return "strobe"
        if float(np.quantile(self._few, 0.9)) < _DARK:
            return "dark"
        for person in people:
            body = _brightness_at(picture, person.pose.picture[11:29])
            if self.brightness > 0.45 and body < _BACK_LIGHT * self.brightness:
                return "back light"
        if len(self._pattern) == _WINDOW and float(np.mean(self._pattern)) > _PATTERN:
            return "projection on the body"
        if len(self._sure) == _WINDOW and float(np.mean(self._sure)) < _UNSURE:
            return "unsure"
        return ""


def _brightness_at(picture: UInt8, points: Float64) -> float:
    """Return the median brightness at `points` (n, 2) [pixels] of a picture, 0 to 1."""
    height, width = picture.shape[:2]
    x = np.clip(points[:, 0].astype(np.intp), 0, width - 1)
    y = np.clip(points[:, 1].astype(np.intp), 0, height - 1)
    return float(np.median(picture[y, x].mean(axis=1)) / 255.0)
