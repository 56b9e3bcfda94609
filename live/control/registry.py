"""The registry: one table of every control, whoever uses it (OSC, keys, web pages).

The reference in docs/osc.md is written from this table.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Final

from live.control.control import Control, Released, Reply
from live.control.controls.audio import AUDIO_CONTROLS
from live.control.controls.clock import CLOCK_CONTROLS
from live.control.controls.cues import CUE_CONTROLS
from live.control.controls.elements import ELEMENT_CONTROLS
from live.control.controls.group_motion import GROUP_CONTROLS
from live.control.controls.machines import MACHINE_CONTROLS
from live.control.controls.motion import MOTION_CONTROLS
from live.control.controls.output import OUTPUT_CONTROLS
from live.control.controls.scenes import SCENE_CONTROLS
from live.control.controls.score import SCORE_CONTROLS
from live.control.controls.steps import STEP_CONTROLS
from live.control.events import ControlEvent
from live.control.rejections import Reason, Rejection

_PASS: Final = "/dance/pass/"


class Registry:
    """Controls by their exact address; there are no patterns."""

    def __init__(self, controls: Sequence[Control]) -> None:
        self._controls: Mapping[str, Control] = {control.address: control for control in controls}
        if len(self._controls) != len(controls):
            raise ValueError("two controls have one address")

    def __iter__(self) -> Iterator[Control]:
        return iter(self._controls.values())

    def __getitem__(self, address: str) -> Control:
        return self._controls[address]

    def call(
        self, address: str, values: Sequence[object], time: float, source: str
    ) -> ControlEvent | Reply | Released | Rejection:
        """What the control at `address` makes of `values`, received at `time` [s of the show] from `source`.

        Thread: any. Never raises for anything a sender can choose.
        """
        control = self._controls.get(address)
        if control is None and address.startswith(_PASS):  # of a patch's own passes only the show knows the names
            control = self._controls.get(f"{_PASS}set" if address.count("/") == 4 else _PASS.rstrip("/"))
            values = [*address.removeprefix(_PASS).split("/"), *values]
        if control is None:
            return Rejection(Reason.UNKNOWN_ADDRESS, address)
        return control.call(values, time, source)


REGISTRY: Final = Registry(
    (
        *ELEMENT_CONTROLS,
        *GROUP_CONTROLS,
        *STEP_CONTROLS,
        *MOTION_CONTROLS,
        *SCENE_CONTROLS,
        *CUE_CONTROLS,
        *OUTPUT_CONTROLS,
        *CLOCK_CONTROLS,
        *AUDIO_CONTROLS,
        *SCORE_CONTROLS,
        *MACHINE_CONTROLS,
    )
)
"""Every control there is."""
