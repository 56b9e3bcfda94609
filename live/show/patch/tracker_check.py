"""Whether the trackers that performers of a patch stand at are there, each for one performer."""

from collections.abc import Sequence

from live.show.patch.mocap import MocapSection
from live.show.patch.psn import PsnSection
from live.show.patch.section_base import Amiss


def check_trackers(psn: PsnSection, performers: Sequence[MocapSection]) -> None:
    """Amiss for a tracker that `[psn]` does not name, if it names any, and for one that two performers have."""
    whose = {each.name: each.name for each in performers if each.tracker is None}
    for index, each in enumerate(performers):
        if each.tracker is None:
            continue
        place = "mocap", index, "tracker"
        if psn.trackers and each.tracker not in psn.trackers:
            known = ", ".join(psn.trackers)
            words = f"mocap {each.name!r}: no tracker is called {each.tracker!r}; [psn] trackers has: {known}"
            raise Amiss(words, *place)
        other = whose.setdefault(each.tracker, each.name)
        if other != each.name:
            words = f"mocap {each.name!r}: tracker {each.tracker!r} is already {other!r}; give each her own"
            raise Amiss(words, *place)
