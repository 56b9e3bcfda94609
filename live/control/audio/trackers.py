"""Which tracker listens: our network under the bar pointer, or aubio."""

from typing import Literal

from live.clock.tracking.aubio_tracker import AubioTracker
from live.clock.tracking.beat_tracker import Tracker
from live.clock.tracking.network import Network
from live.control.audio.beat_network import beat_weights

TrackerName = Literal["network", "aubio"]


def make_tracker(name: TrackerName, sample_rate: float) -> tuple[Tracker | AubioTracker, str]:
    """The tracker of that name, and words on what is different from what was asked for ("" if nothing is).

    Where the network's weights cannot be read, or at sample rates below what it can hear, aubio listens instead.
    ValueError for a sample rate that no sound has.
    """
    if name == "aubio":
        return AubioTracker(sample_rate), ""
    try:
        return Tracker(sample_rate, Network(beat_weights())), ""
    except (OSError, ValueError) as error:
        return AubioTracker(sample_rate), f"aubio listens instead of the beat network: {error}"
