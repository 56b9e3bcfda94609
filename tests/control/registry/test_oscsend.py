"""Every control sent by liblo's oscsend: an independent implementation of OSC in C."""

import shutil
import subprocess

import pytest

from live.control.registry.registry import REGISTRY
from tests.control.osc.osc_stage import DEADLINE_S, wait_until
from tests.control.osc.osc_table import every_control

OSCSEND = shutil.which("oscsend")


@pytest.mark.liblo
@pytest.mark.skipif(OSCSEND is None, reason="liblo's oscsend is not installed (Debian: liblo-tools)")
def test_oscsend_message_to_every_control_is_accepted(stage):
    sent = every_control()
    assert set(sent) == {control.address for control in REGISTRY}
    for count, (address, (arguments, event)) in enumerate(sent.items(), start=1):
        command = [OSCSEND, "127.0.0.1", str(stage.osc.port), address, *filter(None, arguments)]
        subprocess.run(command, check=True, timeout=DEADLINE_S)
        wait_until(lambda count=count: stage.osc.received == count)
        assert stage.events() == ([] if event is None else [event]), stage.osc.last_rejection
    assert stage.osc.rejected.total == 0
