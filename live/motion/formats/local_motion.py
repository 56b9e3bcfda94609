"""Joints relative to their parent joints: chains of nodes put together, scales folded into the translations."""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion import quaternion
from live.motion.formats.animation import Channel, CurveReader
from live.motion.formats.nodes import NodeRest, Nodes, even, is_even

Float = npt.NDArray[np.floating]
Float64 = npt.NDArray[np.float64]

_IDENTITY: Final = np.array((1.0, 0.0, 0.0, 0.0))


@dataclass(frozen=True, slots=True, eq=False)
class Chain:
    """Where the last node of a chain is, seen from above the first, over T frames."""

    translation: Float
    """In metres of the world, shape (T, 3)."""
    rotation: Float
    """Unit quaternions, shape (T, 4)."""
    scale: float
    """Of everything above the last node and of itself: metres of the world per unit below it."""


class LocalMotion:
    """Chains of `nodes` as one animation moves them; a scale is one factor, which must not change."""

    def __init__(
        self,
        nodes: Nodes,
        curves: CurveReader,
        channels: dict[tuple[int, str], Channel],
        used: set[int],
        carrying: set[int],
    ) -> None:
        """`channels` by node and path; `used` are the nodes of all chains, `carrying` those with a joint below."""
        self._nodes, self._curves, self._channels = nodes, curves, channels
        self.warnings: list[str] = []
        self._rests = {node: self._rest(node, node in carrying) for node in sorted(used)}

    def at_rest(self, chain: list[int], scale: float) -> Chain:
        """The chain in the rest pose, T = 1; `scale` is that of everything above it."""
        return self._compose(chain, scale, {}, np.zeros(1))

    def at(self, chain: list[int], scale: float, times: Float64) -> Chain:
        """The chain at `times` (T,) [s]."""
        return self._compose(chain, scale, self._channels, times)

    def _rest(self, node: int, carries: bool) -> NodeRest:
        """The node at rest; where its scale is animated, the scale of the animation."""
        rest = self._nodes.rest(node)
        scale, name = rest.scale, repr(self._nodes.name(node))
        channel = self._channels.get((node, "scale"))
        if channel is not None:
            values = self._curves.curve(channel).values
            if not (values > 1e-9).all():
                raise channel.place.error("", f"scales {name} to nothing", "factors above zero expected")
            scale = np.median(values, axis=0)
            if carries and not all(is_even(column) for column in values.T):
                self.warnings.append(f"the scale of {name} changes: its middle value is used")
        if carries and not is_even(scale):
            self.warnings.append(f"the scale of {name} differs along its axes: their mean is used, its bones are off")
        return NodeRest(rest.translation, rest.rotation, scale)

    def _compose(
        self, chain: list[int], scale: float, channels: dict[tuple[int, str], Channel], times: Float64
    ) -> Chain:
        translation: Float = np.zeros((len(times), 3))
        rotation: Float = np.broadcast_to(_IDENTITY, (len(times), 4))
        for node in chain:
            rest = self._rests[node]
            moves, turns = channels.get((node, "translation")), channels.get((node, "rotation"))
            move = rest.translation if moves is None else self._curves.curve(moves).at(times)
            turn = rest.rotation if turns is None else self._curves.curve(turns).at(times)
            translation = translation + quaternion.rotate(rotation, scale * move)
            rotation = quaternion.mul(rotation, turn)
            scale *= even(rest.scale)
        return Chain(translation, quaternion.unit(rotation), scale)
