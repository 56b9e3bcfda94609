"""Directed: what patch and people say of a captured performer: who she is, where, how, and what she does to others."""

import math

from live.control.registry.control import Plain
from live.show.patch.mocap import MocapSection


class Directed:
    """What is said of one performer. Thread: the show's."""

    def __init__(self, section: MocapSection) -> None:
        self.section = section
        self.shown, self.mirrored = section.shown, section.mirrored
        self.obstacle, self.attract, self.attracts = section.obstacle, section.attract, section.attracts
        self.dancer = section.dancer
        """Words for the dancer who is her; None: anybody who is free."""
        self.canon, self.canon_beats = section.canon, section.canon_beats
        self.lay(*section.at, section.turn_deg, section.scale)

    def lay(self, x: float, z: float, turn: float, scale: float) -> None:
        """The middle of her floor lies at x, z [m], it is turned so far [degrees], and her ways are so long."""
        self.turn, self.scale = turn, scale
        self.origin = x, z, math.radians(turn)

    @property
    def later(self) -> float:
        """How much later she is shown than she was received [s]."""
        return self.section.delay_ms / 1000.0

    @property
    def said(self) -> dict[str, tuple[Plain, ...]]:
        """What is said of her now, as in `/dance/mocap/NAME/...`: the values that each control takes."""
        x, z, _ = self.origin
        return {
            "dancer": ("*" if self.dancer is None else self.dancer,),
            "shown": (self.shown,),
            "mirrored": (self.mirrored,),
            "place": (float(x), float(z), float(self.turn), float(self.scale)),
            "canon": (self.canon, float(self.canon_beats)),
            "obstacle": (self.obstacle,),
            "attract": (float(self.attract), self.attracts),
        }
