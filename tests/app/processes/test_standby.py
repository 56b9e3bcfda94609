"""A standby machine whose steps or patch differ from the leader's reports it."""

import json
from pathlib import Path

import pytest

from live.app.processes.remote_standby import apply_log
from live.base.errors import PersonError
from live.control.events.event_json import event_to_json
from live.control.events.events import PatchChanged
from live.show.loader import LoadedShow
from live.show.patch.patch_reader import parse_patch
from live.show.patch.patch_update import patch_version
from live.supervisor.state_follower import StateFollower
from tests.show.made_show import GRAPH, PATCH


def test_different_steps_are_named_in_person_error():
    loaded = LoadedShow(Path("test.toml"), parse_patch(PATCH, "test.toml"), GRAPH)
    header = {"journal": 2, "origin": 0.0, **loaded.header(loaded.start(seed=1), tempo=None)}
    following = StateFollower(loaded)
    following.add_line(json.dumps(header | {"steps_hash": "0" * 16}))
    following.add_line(json.dumps({"tick": 3}))
    with pytest.raises(PersonError, match="cannot run here") as raised:
        apply_log(following)
    assert "same steps" in str(raised.value.remedy)


def make_follower(patch: str, *later: str) -> StateFollower:
    """A machine with the test show's patch that has received a show of another machine, edited later."""
    loaded, other = (LoadedShow(Path("test.toml"), parse_patch(text, "test.toml"), GRAPH) for text in (PATCH, patch))
    following = StateFollower(loaded)
    following.add_line(json.dumps({"journal": 2, "origin": 0.0, **other.header(other.start(seed=1), tempo=None)}))
    for text in later:
        edited = parse_patch(text, "test.toml").model_dump_json()
        event = PatchChanged(time=0.0, source="patch", patch=edited, version=patch_version(edited))
        following.add_line(json.dumps({"tick": 2, "event": event_to_json(event)}))
    following.add_line(json.dumps({"tick": 3}))
    return following


OTHER = PATCH.replace('steps = ["glide", "sway", "spin"]', 'steps = ["spin"]')


def test_different_patch_is_named_and_never_taken_over():
    assert OTHER != PATCH
    with pytest.raises(PersonError, match=r"plays another show.*different: group \(") as raised:
        apply_log(make_follower(OTHER))
    assert "same patch" in str(raised.value.remedy)


def test_original_and_edited_patch_of_leader_are_both_accepted():
    for begun, later in ((PATCH, [OTHER]), (OTHER, [PATCH])):
        assert make_follower(begun, *later).show_mismatch() is None
