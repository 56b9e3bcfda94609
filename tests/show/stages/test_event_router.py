"""Events reach the parts that declare them; what a part refuses is counted with the event's source."""

from live.control.events import events
from live.show.desk.refusals import Refusals
from live.show.stages.event_router import EventRouter
from tests.show.made_show import made_show

STAMP = {"time": 0.0, "source": "osc"}


class Recorder:
    """A part that records what it handles, and returns `answer` to the first event."""

    def __init__(self, log, name, *kinds, answer=()):
        self.EVENTS, self._log, self._name, self._answer = kinds, log, name, answer

    def handle(self, event, now):
        self._log.append((self._name, type(event).__name__, now.time))
        answer, self._answer = self._answer, ()
        return answer


def router_of(*parts):
    show = made_show()
    return EventRouter(parts, show.clock, show.motion, show.desk.undo_history, Refusals())


def test_event_goes_to_all_parts_that_declare_it_in_their_order():
    log = []
    router = router_of(
        Recorder(log, "one", events.Clear, events.Blackout), Recorder(log, "two", events.Panic),
        Recorder(log, "three", events.Clear),
    )  # fmt: skip
    assert router.apply(events.Clear(**STAMP))
    assert log == [("one", "Clear", 0.0), ("three", "Clear", 0.0)]
    assert router.apply(events.Undo(**STAMP))  # nobody's: for a device
    assert len(log) == 2


def test_triggered_events_follow_at_once():
    log = []
    answer = [events.Clear(**STAMP), events.Blackout(**STAMP, on=True)]
    desk = Recorder(log, "desk", events.Panic, answer=answer)
    router_of(desk, Recorder(log, "light", events.Clear, events.Blackout)).apply(events.Panic(**STAMP))
    assert [(part, kind) for part, kind, _ in log] == [("desk", "Panic"), ("light", "Clear"), ("light", "Blackout")]


def test_refusal_names_source_and_reason():
    show = made_show()
    assert not show.apply(events.CallStep(**STAMP, name="nowhere"))
    assert show.refusals.last_reason.startswith("osc: no step is called 'nowhere'")
    assert not show.apply(events.ResetBreaker(**STAMP, name="nothing"))
    assert show.refusals.last_reason.startswith("osc: there is no breaker 'nothing'")
    assert show.refusals.count == 2


def test_every_declared_event_is_an_event_of_the_table():
    router = made_show().frame.router
    assert set(router._handlers) <= set(events.EVENT_TYPES.values())
    assert [len(router._handlers[kind]) for kind in (events.Clear, events.LaunchEnded)] == [4, 3]
    assert len(router._handlers[events.FreezePicture]) == 2
