"""AudioChoice: which sound device is listened to, and which of its channels."""

from dataclasses import dataclass

from live.base.errors import PersonError
from live.control.audio.channel_mixer import Channels
from live.control.audio.sound_devices import SoundDevice, find_again, find_device


@dataclass(frozen=True, slots=True)
class AudioChoice:
    """A device as it was found, and the channels that are wished of it."""

    device: SoundDevice
    channels: Channels

    @classmethod
    def of(cls, device: str | int | None, channels: Channels) -> "AudioChoice":
        """`device` as for `find_device`; SoundUnavailable, UnknownDevice, PersonError if it lacks the channels."""
        return cls(find_device(device), channels)._checked()

    def other(self, device: str, channels: str) -> "AudioChoice":
        """Another device, other channels, or both; empty: as they are. Raises as `of` does."""
        return AudioChoice(
            find_device(device) if device else self.device, Channels.of(channels) if channels else self.channels
        )._checked()

    def again(self) -> "AudioChoice":
        """The same device as it is there now, with whichever channels it has; UnknownDevice if it is not there."""
        return AudioChoice(find_again(self.device), self.channels)

    def _checked(self) -> "AudioChoice":
        missing = self.channels.missing(self.device.channels)
        if missing:
            raise PersonError(f"{self.device.name}: {missing}", "choose others, see `live devices`")
        return self
