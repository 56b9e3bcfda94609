"""The registry: one table of every control, whoever uses it (OSC, keys, web pages).

The reference in docs/osc.md is written from this table.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Final

from live.control.registry.asking import ASKING_CONTROLS
from live.control.registry.audience_controls import AUDIENCE_CONTROLS
from live.control.registry.audio_controls import AUDIO_CONTROLS
from live.control.registry.capture_controls import MOCAP_CONTROLS
from live.control.registry.clock_controls import CLOCK_CONTROLS
from live.control.registry.control import Control, Result
from live.control.registry.cues_controls import CUE_CONTROLS
from live.control.registry.elements_controls import ELEMENT_CONTROLS
from live.control.registry.groups_controls import GROUP_CONTROLS
from live.control.registry.machines import MACHINE_CONTROLS
from live.control.registry.midi_controls import MIDI_CONTROLS
from live.control.registry.motion import MOTION_CONTROLS
from live.control.registry.output_controls import OUTPUT_CONTROLS
from live.control.registry.partners_controls import PARTNER_CONTROLS
from live.control.registry.rejections import Reason, Rejection
from live.control.registry.scenes_controls import SCENE_CONTROLS
from live.control.registry.score_controls import SCORE_CONTROLS
from live.control.registry.steps import STEP_CONTROLS

_PASS: Final = "/dance/pass/"
_MOCAP: Final = "/dance/mocap/"
"""Below it the performer's name may stand in the address: `/dance/mocap/anna/mirrored`."""


class Registry:
    """Controls by their exact address; patterns are for the port to find out (`osc_pattern`)."""

    def __init__(self, controls: Sequence[Control]) -> None:
        self._controls: Mapping[str, Control] = {control.address: control for control in controls}
        if len(self._controls) != len(controls):
            raise ValueError("two controls have one address")

    def __iter__(self) -> Iterator[Control]:
        return iter(self._controls.values())

    def __getitem__(self, address: str) -> Control:
        return self._controls[address]

    def find(self, address: str) -> Control | None:
        """The control at an address; None if there is none."""
        return self._controls.get(address)

    def meant(self, address: str) -> Control | None:
        """The control that answers to an address: of a patch's own passes only the show knows the names."""
        control = self._controls.get(address)
        if control is None and address.startswith(_PASS):
            return self._controls.get(f"{_PASS}set" if address.count("/") == 4 else _PASS.rstrip("/"))
        if control is None and address.startswith(_MOCAP) and address.count("/") == 4:
            return self._controls.get(_MOCAP + address.rpartition("/")[2])
        return control

    def call(self, address: str, values: Sequence[object], time: float, source: str) -> Result:
        """What the control at `address` makes of `values`, received at `time` [s of the show] from `source`.

        Thread: any. Never raises for anything a sender can choose.
        """
        control = self.meant(address)
        if control is None:
            return Rejection(Reason.UNKNOWN_ADDRESS, address)
        return control.call(self.whole(address, values), time, source)

    def whole(self, address: str, values: Sequence[object]) -> Sequence[object]:
        """The values of a message, with those before them that stand in its address."""
        if address in self._controls or self.meant(address) is None:
            return values
        within = address.removeprefix(_PASS).split("/")
        return [*(address.split("/")[3:4] if address.startswith(_MOCAP) else within), *values]

    def kept_at(self, address: str) -> tuple[str, str]:
        """The address under which the show tells the value of `address`, and the name that this has in it, or ""."""
        control = None if address in self._controls else self.meant(address)
        return (address, "") if control is None or not control.named else (control.address, address.split("/")[3])


REGISTRY: Final = Registry(
    (
        *ELEMENT_CONTROLS,
        *GROUP_CONTROLS,
        *STEP_CONTROLS,
        *MOTION_CONTROLS,
        *PARTNER_CONTROLS,
        *SCENE_CONTROLS,
        *CUE_CONTROLS,
        *OUTPUT_CONTROLS,
        *AUDIENCE_CONTROLS,
        *CLOCK_CONTROLS,
        *AUDIO_CONTROLS,
        *SCORE_CONTROLS,
        *MOCAP_CONTROLS,
        *MACHINE_CONTROLS,
        *MIDI_CONTROLS,
        *ASKING_CONTROLS,
    )
)
"""Every control there is."""
