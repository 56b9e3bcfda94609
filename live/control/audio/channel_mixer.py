"""Channel selection of an audio device and the mix of the selected channels to mono."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float32
from live.base.errors import PersonError

MAX_CHANNELS: Final = 128
"""Maximum channel number; no card has more."""

MUTE: Final = 1e-4
"""A channel below this share of the loudest one's power (-40 dB) is muted and does not count."""

UNMUTED: Final = 1e-5
"""A channel that counts is muted only below this share (hysteresis)."""

POWER_WINDOW: Final = 0.3
"""Seconds over which a channel's power is averaged."""

OPPOSED: Final = 0.02
"""If the channels' mean has less than this share of their power, they cancel out, and only one is used …"""

AGREED: Final = 0.1
"""… until the mean has this share again."""

LOUDEST: Final = 64.0
"""Samples above this level are faults (full scale is 1)."""


@dataclass(frozen=True, slots=True)
class Channels:
    """Selected channels, numbered from 0; empty: all channels."""

    numbers: tuple[int, ...] = (0, 1)

    @staticmethod
    def parse(text: str | Sequence[int]) -> "Channels":
        """Parse `3`, `5,6`, `all` or a list of numbers, counted from 1. PersonError for anything else."""
        if isinstance(text, str):
            if text.strip().casefold() in ("all", "mix", "*"):
                return Channels(())
            if not re.fullmatch(r"\s*\d{1,3}(\s*[,+ ]\s*\d{1,3})*\s*", text):
                raise _refused(text)
            text = [int(number) for number in re.findall(r"\d+", text)]
        if (
            not text
            or any(isinstance(n, bool) or not 1 <= n <= MAX_CHANNELS for n in text)
            or len(text) != len(set(text))
        ):
            raise _refused(text)
        return Channels(tuple(number - 1 for number in text))

    def __str__(self) -> str:
        return ",".join(str(number + 1) for number in self.numbers) or "all"

    def select(self, available: int) -> tuple[int, ...]:
        """Return the selected channels of a device with `available` channels; up to its first two if it has none of
        them."""
        if not self.numbers:
            return tuple(range(available))
        there = tuple(number for number in self.numbers if number < available)
        return there or tuple(range(min(available, 2)))

    def missing(self, available: int) -> str:
        """Describe the selected channels missing from a device with `available` channels; empty if none.

        For the default selection, the first two, one channel is enough.
        """
        lacking = [str(number + 1) for number in self.numbers if number >= available]
        if not lacking or (self == Channels() and available):
            return ""
        return f"no channel {', '.join(lacking)} among {available}"


def _refused(words: object) -> PersonError:
    return PersonError(
        f"channels {str(words)[:60]!r}: numbers from 1 to {MAX_CHANNELS}, or all, expected", "3, or 5,6, or all"
    )


class ChannelMixer:
    """Mixes the selected channels of blocks to mono; muted channels do not lower the level.

    The mix is the mean of the channels that are not muted. If they cancel each other (one of a pair with reversed
    polarity), only the loudest is used. Changes are cross-faded over a block.
    """

    def __init__(self, chosen: Sequence[int], sample_rate: float, longest: int) -> None:
        """`chosen`: channels from 0; `longest`: maximum frames of a block."""
        count = len(chosen)
        self._chosen = np.array(chosen, np.intp)
        self._sample_rate = sample_rate
        self._picked: Float32 = np.zeros((longest, count), np.float32)
        self._mono: Float32 = np.zeros(longest, np.float32)
        self._block_power: Float32 = np.zeros(count, np.float32)
        self._power = np.zeros(count)
        self._mean_power = 0.0
        self._opposed = False
        self._mean: Float32 = np.full(count, 1.0 / count, np.float32)
        self._weights: Float32 = self._mean.copy()
        self.bad_samples = 0
        """Invalid samples replaced by 0 if there are several channels; for a single channel the tracker counts them."""

    def mix(self, block: Float32) -> Float32:
        """Return the mono mix, shape (n,), of a block, shape (n, channels of the device); valid until the next call."""
        picked = self._picked[: block.shape[0]]
        np.take(block, self._chosen, axis=1, out=picked, mode="clip")
        if picked.shape[1] == 1 or not picked.shape[0]:
            return picked[:, 0]
        self._measure(picked)
        mono = self._mono[: picked.shape[0]]
        np.dot(picked, self._mean, out=mono)
        self._update_opposed(float(np.dot(mono, mono)) / mono.shape[0], mono.shape[0])
        wanted = self._target_weights()
        if np.array_equal(wanted, self._weights):
            if self._opposed:
                np.dot(picked, wanted, out=mono)
            return mono
        fade = np.linspace(0.0, 1.0, mono.shape[0], dtype=np.float32)
        mono[:] = (picked @ self._weights) * (1.0 - fade) + (picked @ wanted) * fade
        self._weights = wanted.copy()
        return mono

    def _measure(self, picked: Float32) -> None:
        np.einsum("nc,nc->c", picked, picked, out=self._block_power)
        if not float(self._block_power.max()) <= LOUDEST**2:  # NaN too
            bad = ~(np.abs(picked) <= LOUDEST)
            self.bad_samples += int(np.count_nonzero(bad))
            picked[bad] = 0.0
            np.einsum("nc,nc->c", picked, picked, out=self._block_power)
        count = picked.shape[0]
        share = min(count / (POWER_WINDOW * self._sample_rate), 1.0)
        self._power += share * (self._block_power / count - self._power)

    def _update_opposed(self, mean_power: float, count: int) -> None:
        share = min(count / (POWER_WINDOW * self._sample_rate), 1.0)
        self._mean_power += share * (mean_power - self._mean_power)
        whole = float(self._power.max())
        if whole > 0.0:
            self._opposed = self._mean_power < (AGREED if self._opposed else OPPOSED) * whole

    def _target_weights(self) -> Float32:
        """Return the weights for the present powers, and update `_mean`, the weights of the unmuted channels."""
        loudest = float(self._power.max())
        heard = self._power > np.where(self._mean > 0.0, UNMUTED, MUTE) * loudest
        if not heard.any():
            return self._weights
        mean = (heard / np.count_nonzero(heard)).astype(np.float32)
        if not np.array_equal(mean, self._mean):
            self._mean = mean
        if not self._opposed:
            return self._mean
        alone = np.zeros_like(self._mean)
        alone[int(np.argmax(self._power))] = 1.0
        return alone
