"""The nodes of a glTF file: who hangs on whom, where each rests, and which of them are joints of the dancer."""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion import quaternion
from live.motion.formats.json_place import JsonPlace

Float = npt.NDArray[np.floating]

NODE_LIMIT: Final = 20_000
UNEVEN: Final = 0.01
"""Part by which the three factors of a scale may differ and still count as one."""


@dataclass(frozen=True, slots=True, eq=False)
class NodeRest:
    """A node's own transformation as the file rests: scaled, then turned, then moved."""

    translation: Float
    """Shape (3,) [m]."""
    rotation: Float
    """Unit quaternion (w, x, y, z), shape (4,)."""
    scale: Float
    """Factors along x, y, z, shape (3,); all above zero."""


class Nodes:
    """The node tree of a file, checked: every node has at most one parent, and there are no circles."""

    def __init__(self, root: JsonPlace) -> None:
        self._root = root
        self.count = root.length("nodes")
        if self.count > NODE_LIMIT:
            raise root.error("nodes", f"has {self.count} elements", f"at most {NODE_LIMIT} expected")
        self.parents = [-1] * self.count
        self.children: list[list[int]] = []
        for index, node in enumerate(root.elements("nodes")):
            self.children.append(node.wholes("children", below=self.count))
            for child in self.children[-1]:
                if self.parents[child] >= 0:
                    raise node.error("children", f"names node {child}, which has a parent already", "a tree expected")
                self.parents[child] = index
        self.order = self._parents_first()

    def _parents_first(self) -> list[int]:
        waiting = [node for node in range(self.count) if self.parents[node] < 0][::-1]
        order = []
        while waiting:  # depth first
            order.append(waiting.pop())
            waiting += self.children[order[-1]][::-1]
        if len(order) < self.count:
            lost = sorted(set(range(self.count)) - set(order))[0]
            raise self._root.error("nodes", f"hang on each other in a circle (node {lost})", "a tree expected")
        return order

    def place(self, node: int) -> JsonPlace:
        """The JSON of one node."""
        return self._root.element("nodes", node)

    def name(self, node: int) -> str:
        """Its name, or its number if it has none; on one line and of reasonable length."""
        return " ".join(self.place(node).text("name").split())[:200] or f"node {node}"

    def below(self, tops: set[int]) -> set[int]:
        """These nodes and all that hang on them."""
        found = set(tops)
        waiting = list(tops)
        while waiting:
            news = [child for child in self.children[waiting.pop()] if child not in found]
            found.update(news)
            waiting += news
        return found

    def common(self, nodes: list[int]) -> int | None:
        """The lowest node that is one of `nodes` or above, for all of them; None if they hang on different roots."""
        wanted = set(nodes)
        below = [0] * self.count
        for node in reversed(self.order):
            below[node] += node in wanted
            if below[node] == len(wanted):
                return node
            if self.parents[node] >= 0:
                below[self.parents[node]] += below[node]
        return None

    def rest(self, node: int) -> NodeRest:
        """Its resting transformation, whether written as a matrix or as its three parts."""
        place = self.place(node)
        if place.has("matrix"):
            return _of_matrix(place)
        turn = np.array(place.numbers("rotation", 4, (0.0, 0.0, 0.0, 1.0)))
        if np.linalg.norm(turn) < 1e-6:
            raise place.error("rotation", "is zero", "a unit quaternion expected")
        scale = np.array(place.numbers("scale", 3, (1.0, 1.0, 1.0)))
        if not (scale > 1e-9).all():
            raise place.error("scale", f"is {scale.tolist()}", "factors above zero expected; apply it and export again")
        translation = np.array(place.numbers("translation", 3, (0.0, 0.0, 0.0)))
        return NodeRest(translation, quaternion.unit(turn)[[3, 0, 1, 2]], scale)


def _of_matrix(place: JsonPlace) -> NodeRest:
    """Translation, rotation and scale of a matrix (column by column in the file); shear is refused."""
    matrix = np.array(place.numbers("matrix", 16, ())).reshape(4, 4).T
    scale = np.linalg.norm(matrix[:3, :3], axis=0)
    if not (scale > 1e-9).all() or np.linalg.det(matrix[:3, :3] / scale) < 0.9:
        raise place.error("matrix", "mirrors, shears or flattens", "apply the transformation and export again")
    turn = quaternion.from_columns(*(matrix[:3, n] / scale[n] for n in range(3)))
    return NodeRest(matrix[:3, 3].copy(), turn, scale)


def even(scale: Float) -> float:
    """One factor in place of three: their geometric mean."""
    return float(np.exp(np.mean(np.log(scale))))


def is_even(scale: Float) -> bool:
    """Whether the three factors are the same within 1 %."""
    return bool(scale.max() <= scale.min() * (1.0 + UNEVEN))
