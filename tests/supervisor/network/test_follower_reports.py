"""What a leader tells operators of the machines that stand by, and what these tell it."""

import json
from types import SimpleNamespace

from live.clock.ticks import TICK
from live.supervisor.network.follower_reports import CANNOT_KEPT, MOST_CANNOT, FollowerReports, order_restart
from live.supervisor.network.leadership import Leadership, Pulse, Role, Term
from live.supervisor.network.peer_messages import FollowerState, parse_message
from live.supervisor.supervisor_config import Report


class Link(SimpleNamespace):
    """A link that keeps what is sent."""

    def __init__(self, name, **facts):
        peer = SimpleNamespace(name=name)
        start = {"follows": True, "state": FollowerState(), "state_tick": 0}
        super().__init__(name=f"{name} #1", peer=peer, peer_name=f"{name}-process", sent=[], channel=self, **start)
        self.__dict__.update(facts)

    def send_line(self, line):
        self.sent.append(parse_message(json.loads(line)))


def leading(*links, ready=()):
    lead = Leadership("leader", Role.LEADS)
    for link in links:
        lead.link_opened(link.name, 10.0)
        lead.handle(link.name, Pulse(Term(1, "leader"), False, ready=link in ready), 10.0)
    lead.update(10.1, 0.1, ready=False)
    return lead


def test_leader_tells_state_lateness_and_deputy():
    near, far = Link("near", state=FollowerState(640, 9, 1), state_tick=642), Link("far")
    asking = Link("asking", follows=False)
    rows = FollowerReports().rows([near, far, asking], leading(near, far, asking, ready=(near,)), 10.5)
    assert rows == [
        {"name": "near", "process": "near-process", "state": "ready", "why": "takes over next",
         "late_ms": round(2e3 * TICK, 1), "silent_ms": 500.0, "compared": 9, "different": 1},
        {"name": "far", "process": "far-process", "state": "follows", "why": "", "late_ms": 0.0, "silent_ms": 500.0,
         "compared": 0, "different": 0},
    ]  # fmt: skip


def test_machines_that_cannot_stand_by_are_told_for_a_while_and_not_once_they_can():
    reports, link = FollowerReports(), Link("second")
    for number in range(MOST_CANNOT + 1):
        reports.note_cannot(f"machine {number}", "version 9, the leader 1", 10.0)
    assert len(reports.rows([], leading(), 11.0)) == MOST_CANNOT
    reports.note_cannot("second", "version 9, the leader 1", 11.0 + CANNOT_KEPT)
    [row] = reports.rows([], leading(), 12.0 + CANNOT_KEPT)
    assert (row["name"], row["state"], row["why"]) == ("second", "refused", "version 9, the leader 1")
    assert [row["state"] for row in reports.rows([link], leading(link), 13.0 + CANNOT_KEPT)] == ["follows"]


def test_machine_that_stands_by_tells_how_far_it_is_once_a_second():
    reports, link, report = FollowerReports(), Link("leader"), Report()
    report.compared, report.different = 4, 2
    engine = SimpleNamespace(heartbeat=SimpleNamespace(tick=77))
    for now in (100.0, 100.5, 101.0):
        reports.tell(link, engine, report, now)
    assert link.sent == [FollowerState(77, 4, 2)] * 2


def test_order_reaches_the_process_that_is_meant():
    links = [Link("second"), Link("third"), Link("second", peer_name="later", follows=True)]
    order_restart(links, "second", "second-process")
    assert [len(link.sent) for link in links] == [1, 0, 0]
