"""TimelineFollower: laws that hold whatever comes in, in whatever order."""

from hypothesis import given, settings
from hypothesis import strategies as st

from live.clock.follow import SLEW_UNLOCKED, TimelineFollower
from live.clock.ticks import TICK
from live.clock.timeline import TEMPO_MAX_BPM, TEMPO_MIN_BPM

Action = tuple[str, float, float, float]

nil = st.just(0.0)
wild = st.floats(allow_nan=True, allow_infinity=True)
actions = st.one_of(
    st.tuples(st.just("play"), st.floats(40.0, 220.0), st.floats(0.0, 1.0), st.floats(1.0, 9.0)),
    st.tuples(st.just("wait"), nil, nil, st.floats(0.0, 5.0)),
    st.tuples(st.just("heard"), st.floats(-0.5, 0.3), st.floats(0.2, 2.0), st.floats(-1.0, 2.0)),
    st.tuples(st.just("taps"), st.floats(0.2, 1.5), nil, st.floats(0.5, 5.0)),
    st.tuples(st.just("set_tempo"), st.floats(-50.0, 500.0), st.floats(-1.0, 1.0), nil),
    st.tuples(st.sampled_from(["one", "silent", "lost", "found", "tap"]), st.floats(-1.0, 1.0), nil, nil),
    st.tuples(st.sampled_from(["heard", "tap", "set_tempo", "one", "silent", "found"]), wild, wild, wild),
)
stories = st.lists(actions, min_size=1, max_size=14)


class Story:
    """Acts a story out on a follower, tick by tick, and checks the laws at each one."""

    def __init__(self) -> None:
        self.follower = TimelineFollower()
        self.ticks = 0
        self.beat = self.follower.advance(0.0).beat_at(0.0)

    @property
    def now(self) -> float:
        return self.ticks * TICK

    def tick(self) -> None:
        before, last = self.follower.timeline, self.beat
        self.ticks += 1
        timeline = self.follower.advance(self.now)
        self.beat = timeline.beat_at(self.now)
        assert abs(self.beat - before.beat_at(self.now)) < 1e-9, "a new timeline starts where the old one is"
        assert TEMPO_MIN_BPM * 0.999 <= (self.beat - last) / TICK * 60.0 <= TEMPO_MAX_BPM * 1.001
        assert TEMPO_MIN_BPM <= timeline.tempo <= TEMPO_MAX_BPM
        slew = abs(timeline.tempo / self.follower.tempo - 1.0)
        assert slew <= SLEW_UNLOCKED * 1.001 or timeline.tempo in (TEMPO_MIN_BPM, TEMPO_MAX_BPM)
        assert 0.0 <= self.follower.confidence <= 1.0 + 1e-9

    def act(self, action: Action) -> None:
        kind, a, b, seconds = action
        follower, end = self.follower, self.now + (seconds if kind in ("play", "wait", "taps") else 0.0)
        due = self.now + b
        while self.now < end:
            self.tick()
            if self.now >= due and kind != "wait":
                if kind == "play":
                    follower.heard(due, 60.0 / a, 0.8, self.now)
                    due += 60.0 / a
                else:
                    follower.tap(self.now)
                    due += a
        if kind == "heard":
            follower.heard(self.now + a, b, seconds, self.now)
        elif kind == "set_tempo":
            follower.set_tempo(a, self.now + b)
        elif kind not in ("play", "wait", "taps"):
            getattr(follower, kind)(self.now + a)
        assert abs(follower.timeline.beat_at(self.now) - self.beat) < 1e-9, "no input moves the beat"


@given(stories)
@settings(max_examples=80, deadline=None)
def test_the_beat_never_jumps_and_never_stands(actions: list[Action]) -> None:
    story = Story()
    for action in actions:
        story.act(action)
        story.tick()


@given(stories)
@settings(max_examples=10, deadline=None)
def test_the_same_story_gives_the_same_timeline(actions: list[Action]) -> None:
    one, other = Story(), Story()
    for action in actions:
        one.act(action)
        other.act(action)
    assert one.follower.timeline == other.follower.timeline
    assert (one.follower.state, one.follower.source) == (other.follower.state, other.follower.source)
    assert one.follower.confidence == other.follower.confidence


@given(stories, st.floats(80.0, 160.0), st.floats(1.0, 8.0))
@settings(max_examples=15, deadline=None)
def test_freewheel_is_a_straight_line(actions: list[Action], bpm: float, seconds: float) -> None:
    story = Story()
    for action in (*actions, ("wait", 0.0, 0.0, 4.0), ("found", 0.0, 0.0, 0.0), ("play", bpm, 0.3, 16.0)):
        story.act(action)
    assert story.follower.source == "audio"
    story.follower.silent(story.now)
    story.tick()
    line = story.follower.timeline
    story.act(("wait", 0.0, 0.0, seconds))
    assert story.follower.state == "freewheel"
    assert abs(story.beat - line.beat_at(story.now)) < 1e-6


@given(stories, st.floats(60.0, 180.0))
@settings(max_examples=15, deadline=None)
def test_whatever_was_before_steady_music_is_reached(actions: list[Action], bpm: float) -> None:
    story = Story()
    for action in (*actions, ("found", 0.0, 0.0, 0.0), ("play", bpm, 0.1, 30.0)):
        story.act(action)
    assert story.follower.state == "locked"
    octave = story.follower.tempo / bpm
    assert min(abs(octave - level) for level in (0.5, 1.0, 2.0, 1.0 / 3.0, 3.0)) < 0.02 * octave
