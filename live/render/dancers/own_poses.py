"""Texture of the characters' own joints (fingers, face, springs) and of the weights of their blend shapes."""

from collections.abc import Mapping, Sequence
from typing import Final

import moderngl
import numpy as np

from live.base.arrays import Int32
from live.base.body.expression import FACE_SIZE
from live.base.stage_snapshot import StageView
from live.motion.skeleton import JOINT_COUNT, SKELETON
from live.render.body.drawn_joints import EXPRESSION_SIZE
from live.render.characters.character import Character
from live.render.characters.expressions import CHANNELS
from live.render.characters.own_joint_kernels import own_poses
from live.render.shader import release_all

MORPH_TEXELS: Final = (len(CHANNELS) + 3) // 4
"""Texels of a dancer with the weights of its face's channels."""
_CHANNEL: Final = np.array([channel.column for channel in CHANNELS], np.int32)
_FACTOR: Final = np.array([channel.factor for channel in CHANNELS], np.float32)
_REST: Final = np.ascontiguousarray(SKELETON.rest_positions(), np.float32)


class OwnPoses:
    """The texture `texture`, filled for every picture; call `allocate` first."""

    texture: moderngl.Texture

    def __init__(self, ctx: moderngl.Context, characters: Mapping[str, Character], bodies: Sequence[str]) -> None:
        """`bodies`: names of all bodies, in the order of their numbers."""
        self._ctx = ctx
        own = [characters[name].own for name in bodies if name in characters]
        self._character_of_body = np.full(len(bodies), -1, np.int32)
        at = [number for number, name in enumerate(bodies) if name in characters]
        self._character_of_body[at] = np.arange(len(at))
        self._first = np.concatenate([[0], np.cumsum([each.count for each in own])]).astype(np.int32)
        self._table = (
            np.concatenate([each.parent for each in own]), np.concatenate([each.joint for each in own]),
            np.concatenate([each.rest for each in own]), np.concatenate([each.column for each in own]),
            np.concatenate([each.turn for each in own]), np.concatenate([each.spring for each in own]),
        )  # fmt: skip
        self.texels = 2 * max(each.count for each in own) + MORPH_TEXELS
        """Texels of a dancer."""
        self.has_morphs = any(each.channels for each in characters.values())
        """Whether any face has blend shapes."""
        self._rows = 0

    def allocate(self, capacity: int, rows: int) -> None:
        """Make room for so many dancers, in blocks of `rows` like their poses; ValueError if the driver cannot hold
        them."""
        self.release()
        self._rows, blocks = rows, -(-capacity // rows)
        limit = int(self._ctx.info["GL_MAX_TEXTURE_SIZE"])
        if blocks * self.texels > limit:
            raise ValueError(f"{capacity} dancers with characters: this driver can hold {limit // self.texels * rows}")
        self.texture = self._ctx.texture((blocks * self.texels, rows), 4, dtype="f4")
        self.texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
        self._character = np.full(capacity, -1, np.int32)
        self._out = np.zeros((capacity, self.texels, 4), np.float32)
        self._expression = np.zeros((capacity, EXPRESSION_SIZE), np.float32)
        self.update(StageView.allocate(0, JOINT_COUNT))  # the kernel is loaded now, not in the first frame

    def set_bodies(self, body: Int32) -> None:
        """Set the number of each dancer's body, shape (A,)."""
        self._character[: len(body)] = self._character_of_body[body]

    def update(self, view: StageView) -> None:
        """Compute and upload the own joints of all dancers of a moment."""
        count = len(view.joint_position)
        expression = self._expression[:count]
        expression[:, :FACE_SIZE] = view.face
        expression[:, FACE_SIZE:] = view.hand.reshape(count, EXPRESSION_SIZE - FACE_SIZE)
        own_poses(
            view.joint_position, view.joint_rotation, view.present, _REST, expression, view.spring, view.spring_slot,
            self._character,
            self._first, *self._table, _CHANNEL, _FACTOR, self._out,
        )  # fmt: skip
        for block, first in enumerate(range(0, count, self._rows)):
            height = min(count - first, self._rows)
            viewport = block * self.texels, 0, self.texels, height
            self.texture.write(self._out[first : first + height], viewport=viewport)

    def release(self) -> None:
        """Free the texture."""
        if self._rows:
            release_all(self.texture)
            self._rows = 0
