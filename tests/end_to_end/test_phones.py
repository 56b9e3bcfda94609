"""Phones in headless Chromium: join by the link, drag, appear in show and picture, disconnect and resume."""

import json
import os
import signal
import threading
import time
from dataclasses import replace
from statistics import median

import numpy as np
import pytest

from live.app.launch_options import LaunchOptions
from live.app.services.audience_service import AudienceService
from live.base.event_queue import EventQueue
from live.base.stage_snapshot import Camera, Scene
from live.clock.time_source import SystemClock
from live.control.events import events
from live.show.audience.voting import Vote
from live.show.engine import Engine
from live.show.view.status import Status
from tests.control.waiting import wait_for
from tests.end_to_end.browser import Phone, browser, needs_browser
from tests.show.made_show import made_show

pytestmark = [pytest.mark.browser, pytest.mark.long, needs_browser]
BEAT_WITHIN = 0.015
"""What a phone believes of the show's time [s], on the median."""


class Stage:
    """A show that runs in a thread, with its audience; hold `lock` to inspect it."""

    def __init__(self, audience='regions = ["stalls", "balcony"]\nvote_measures = 64\n', **wished):
        self.show = made_show(f"[audience]\n{audience}")
        self.clock, self.inbox, self.lock = SystemClock(), EventQueue(), threading.Lock()
        status = Status(self.show, rejected=dict, memory=lambda: 1.0)
        self.engine = Engine(self.show, clock=self.clock, inbox=self.inbox, status=status)
        options = LaunchOptions(audience=("127.0.0.1", 0), audience_secret=b"s" * 32, **wished)
        self.part = AudienceService(options, self.show, self.inbox.add_queue(), self.clock)
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run)

    def __enter__(self):
        self.part.start()
        self._thread.start()
        assert wait_for(lambda: bool(self.part.link), 5.0)
        return self

    def __exit__(self, *_):
        self._over.set()
        self._thread.join()
        self.part.stop()

    def _run(self):
        while not self._over.wait(1 / 60):
            with self.lock:
                self.part.before_frame()
                self.engine.frame(lambda view: None)
                self.part.frame()

    def say(self, kind, **values):
        self.inbox.put(kind(time=self.clock.now(), source="osc", **values))

    def close_vote(self):
        """Let the vote close at the next measure line: how long a test takes to vote does not matter."""
        with self.lock:
            audience = self.show.audience
            audience.vote = replace(audience.vote, closes=self.show.span.number + 1)

    def elements(self):
        with self.lock:
            return {e.source: e for e in self.show.motion.elements.in_force}

    def lights(self):
        with self.lock:
            return {row[0]: tuple(row[1:]) for row in self.show.audience.facts()["lights"]}

    def await_place(self, source, x, z, within=0.3):
        """Wait for an element near (x, z) [m]."""
        assert wait_for(
            lambda: (e := self.elements().get(source)) is not None and np.hypot(e.x - x, e.z - z) < within, 5.0
        ), self.elements().get(source)


@pytest.fixture(scope="module")
def chromium():
    with browser() as found:
        yield found


@pytest.fixture(scope="module")
def hall(chromium):
    opened, device = chromium
    with Stage() as stage:
        yield stage, lambda link=None, language="en-GB": Phone(opened, device, link or stage.part.link, language)


def stage_position(across, down):
    """The stage position [m] of a place on the page's surface: the page's perspective, computed in another way."""
    inset, far = 0.06, 0.7
    wide = far + (1 - far) * (down - inset) / (1 - 2 * inset)
    x = (across - 0.5) / (wide * (1 - 2 * inset)) * 12.0
    depth = (1 / far - 1 / wide) / (1 / far - 1)  # of a floor in perspective: its inverse width is even in depth
    return x, depth * 8.0 - 4.0


def test_phone_joins_by_link_and_drag_is_attractor_in_show_and_picture(hall):
    stage, phone_of = hall
    phone = phone_of().ready()
    number = phone.page.evaluate("live.me().number")
    assert "#" not in phone.page.url  # whoever sees it over her shoulder cannot use it
    assert phone.page.get_attribute("html", "lang") == "en"
    phone.drag((0.5, 0.5), (0.75, 0.6))
    stage.await_place("audience 1", *stage_position(0.75, 0.6))
    assert wait_for(
        lambda: np.hypot(*np.subtract(stage.lights().get(number, (99, 99)), stage_position(0.75, 0.6))) < 0.3, 5.0
    )
    phone.until("live.lit()")
    assert "light is on the stage" in phone.page.inner_text("#said")
    lit, dark = draw_pictures(stage)
    hue = phone.page.evaluate("live.me().hue") / 1000
    change = (lit - dark)[(lit - dark).max(axis=2) > 10]
    assert len(change) > 50  # it is seen ...
    pure = np.clip(np.abs((hue + np.array((0, 2, 1)) / 3) % 1 * 6 - 3) - 1, 0, 1)
    assert np.argmax(change.sum(axis=0)) == np.argmax(pure)  # ... in the phone's colour
    phone.lift()
    assert wait_for(lambda: number not in stage.lights(), 10.0)
    assert phone.errors == []
    phone.context.close()


def draw_pictures(stage):
    """The projector's picture now, with the phones' lights and without, each (180, 320, 3)."""
    from live.render.headless import create_headless_context, release_headless_context
    from live.render.renderer import Renderer

    view = stage.show.view()
    with stage.lock:
        stage.show.fill(view, stage.show.time)
    view.joint_position[:] = 100.0  # nobody stands in the light
    ctx, size, seen = create_headless_context(), (320, 180), []
    renderer = Renderer(ctx, Scene((12.0, 8.0), Camera(), len(view.group), 22), size=size)
    texture = ctx.texture(size, 4)
    target = ctx.framebuffer([texture])
    for count in (view.light_count, 0):
        view.light_count = count
        renderer.draw(view, target)
        seen.append(np.frombuffer(texture.read(), np.uint8).reshape(size[1], size[0], 4)[..., :3].astype(float))
    for each in (renderer, target, texture):
        each.release()
    release_headless_context(ctx)
    return seen


def test_hold_repels_and_phone_knows_beat(hall):
    stage, phone_of = hall
    phone = phone_of(language="pt-PT").ready()
    assert phone.page.get_attribute("html", "lang") == "pt"
    assert phone.page.inner_text("#come") == "Venham cá"
    for tongue, words in (("de", "Kommt her"), ("ja", "こっちへ"), ("en", "Come here")):
        phone.page.select_option("#tongue", tongue)
        assert phone.page.inner_text("#come") == words
        assert phone.page.get_attribute("html", "lang") == tongue
    phone.hold((0.3, 0.5))
    assert wait_for(
        lambda: any(e.kind == 1 and e.source.startswith("audience") for e in stage.elements().values()), 5.0
    )
    phone.lift()
    errors = []
    for _ in range(9):
        shown, wall = phone.page.evaluate("[live.showTime(), performance.timeOrigin + performance.now()]")
        true = stage.clock.now() - (time.time() - wall / 1000)
        errors.append(shown - true)
    assert abs(median(errors)) < BEAT_WITHIN
    beat = phone.page.evaluate("[live.beat(), live.showTime()]")
    assert abs(beat[0] - stage.show.timeline.beat_at(beat[1])) < 0.02
    assert phone.errors == []
    phone.context.close()


def test_five_phones_vote_and_take_turns_and_winner_is_reported(hall):
    stage, phone_of = hall
    phones = [phone_of() for _ in range(5)]
    for phone in phones:
        phone.ready()
    assert wait_for(lambda: stage.show.audience.phones == 5, 5.0)
    for phone in phones[3:]:
        phone.page.click("#where button:nth-of-type(2)")
    for index, phone in enumerate(phones):
        phone.hold((0.3 + 0.08 * index, 0.5))
    assert wait_for(lambda: len(stage.lights()) == 5, 5.0)
    assert len({phone.page.evaluate("live.me().hue") for phone in phones}) == 5
    stage.say(events.AskVote, what="step", first="sway", second="spin")
    for phone, choice in zip(phones, (1, 2, 2, 2, 1), strict=True):
        phone.page.click(f"#choices button:nth-of-type({choice})")
    phones[0].until("document.getElementById('ask').textContent.includes('more beat')")
    assert wait_for(lambda: stage.show.audience.vote.counts == (200, 300), 10.0)
    stage.close_vote()
    assert wait_for(lambda: stage.show.audience.result[1] == "spin", 10.0)
    phones[0].until("document.getElementById('said').textContent.includes('spin')")
    stage.say(events.GiveTurn, name="balcony", measures=2.0)
    phones[4].until("document.getElementById('turn').textContent.startsWith('Your turn')")
    phones[0].until("document.getElementById('turn').textContent.includes('balcony')")
    for phone in phones:
        phone.lift()
        assert phone.errors == []
        phone.context.close()


def test_killed_gateway_restarts_and_phones_resume_while_frames_continue(hall):
    stage, phone_of = hall
    phone = phone_of().ready()
    me = phone.page.evaluate("live.me()")
    frames, ticks = stage.engine._status.frames, stage.engine.ticks.index
    phone.page.evaluate("window.before = live.me()")
    os.kill(stage.part.pid, signal.SIGKILL)
    died = time.monotonic()
    phone.until("live.me() !== null && live.me() !== window.before")
    assert time.monotonic() - died < 3.0 * 4.0  # on an idle machine within 3 s: see waiting.py
    again = phone.page.evaluate("live.me()")
    assert (again["number"], again["hue"]) == (me["number"], me["hue"])
    assert stage.engine._status.frames > frames
    assert stage.engine.ticks.index > ticks
    phone.page.evaluate("window.before = live.me(); socket.close()")  # it fell asleep, and its socket with it
    phone.page.evaluate("document.dispatchEvent(new Event('visibilitychange'))")
    phone.until("live.me() !== null && live.me() !== window.before")
    assert phone.page.evaluate("live.me().number") == me["number"]
    phone.drag((0.5, 0.5), (0.2, 0.5))
    stage.await_place("audience 1", *stage_position(0.2, 0.5))
    stage.say(events.OpenAudience, on=False)
    phone.until("document.getElementById('said').textContent.startsWith('Not now')")
    assert wait_for(lambda: not any(source.startswith("audience") for source in stage.elements()), 5.0)
    phone.context.close()


def test_phone_without_link_is_asked_to_scan_code(hall):
    stage, phone_of = hall
    phone = phone_of(stage.part.address)
    phone.until("document.getElementById('said').textContent.includes('scan the code')")
    phone.context.close()


def test_phone_waits_with_voucher_when_full_and_joins_automatically(chromium):
    opened, device = chromium
    with Stage("phones = 1") as stage:
        first = Phone(opened, device, stage.part.link).ready()
        waiting = Phone(opened, device, stage.part.link)
        waiting.until("live.why() === 'full'")
        assert "All places are taken" in waiting.page.inner_text("#said")
        waiting.until("document.getElementById('said').textContent.includes('(5 s)')")
        waiting.page.goto(stage.part.address)  # the code that she scanned is not in the address any more
        waiting.until("live.why() === 'full'")
        first.context.close()
        waiting.ready()
        assert waiting.page.evaluate("localStorage.getItem('voucher')") == ""
        assert waiting.page.evaluate("live.me().number") > 1
        assert waiting.errors == []
        waiting.context.close()


def test_phone_returns_with_same_number_after_long_silence(hall):
    stage, phone_of = hall
    phone = phone_of().ready()
    number = phone.page.evaluate("live.me().number")
    os.kill(stage.part.pid, signal.SIGSTOP)  # as if it were out of reach: no socket is closed
    try:
        phone.until("live.why() === 'away'")
    finally:
        os.kill(stage.part.pid, signal.SIGCONT)
    phone.ready()
    assert phone.page.evaluate("live.me().number") == number
    assert phone.errors == []
    phone.context.close()


def test_phone_sees_dancers_is_heard_votes_and_sees_tally_and_winner(chromium):
    opened, device = chromium
    with Stage('regions = ["stalls", "balcony"]\nvote_measures = 64\nwinner_measures = 64\n') as stage:
        one, other = (Phone(opened, device, stage.part.invitation_link, language) for language in ("en-GB", "de-DE"))
        for phone in (one, other):
            phone.ready()
            phone.until("live.dancers().length === 9")
        seen = np.array(one.page.evaluate("live.dancers()"))
        with stage.lock:
            hips = stage.show.dancers.drawn_hips.copy()
        assert seen[:, 2].tolist() == [1] * 5 + [2] * 4
        assert np.abs((2 * seen[:, :2] - 1) * (6.0, 4.0) - hips).max() < 1.0  # they dance on meanwhile
        assert lights_on(one, stage) > 0.9 * len(seen)
        before = one.page.evaluate("live.dancers()")
        one.until(f"JSON.stringify(live.dancers()) !== {json.dumps(json.dumps(before))}")  # they move between frames
        other.page.emulate_media(reduced_motion="reduce")
        other.page.focus("#stage")
        other.page.keyboard.press("ArrowLeft")  # a screen reader is told who is near
        other.until("/Nähe/.test(document.getElementById('near').textContent)")
        assert lights_on(other, stage) > 0.9 * len(seen)
        assert one.page.evaluate("live.hearing()") == 0
        one.hold((0.4, 0.5))
        one.until("live.hearing() === 2")
        one.until("document.getElementById('me').className === 'seen'")
        one.until("live.elements().length > 0")  # where the phone pulls
        one.lift()
        stage.say(events.AskVote, what="step", first="sway", second="spin")
        one.page.click("#choices button:nth-of-type(2)")
        other.page.click("#choices button:nth-of-type(2)")
        for phone in (one, other):
            phone.until("document.querySelectorAll('#choices b')[1].textContent === '100 %'")
            phone.until("document.querySelectorAll('#choices b')[0].textContent === '0 %'")
        assert caption(stage) == (("sway", 0.0), ("spin", 1.0))  # the projectors have the same
        one.page.focus("#choices button:nth-of-type(1)")
        one.page.keyboard.press("Enter")  # thinks again, by keyboard
        one.until("document.querySelectorAll('#choices b')[0].textContent === '50 %'")
        assert one.page.evaluate("document.activeElement.textContent").startswith("sway")  # focus stays on its button
        one.page.click("#choices button:nth-of-type(2)")
        assert wait_for(lambda: stage.show.audience.vote.counts == (0, 200), 10.0)
        stage.close_vote()
        assert wait_for(lambda: stage.show.audience.result[1] == "spin", 10.0)
        one.until("document.querySelector('#choices .won span')?.textContent === 'spin'")
        one.until(
            "document.getElementById('said').textContent.replace(/[\u2068\u2069]/g, '') === 'You all chose: spin'"
        )
        other.until("document.getElementById('ask').textContent.startsWith('Ihr habt gewählt')")
        assert caption(stage) == (("spin", -1.0),)
        stage.say(events.GiveTurn, name="balcony", measures=64.0)
        one.hold((0.4, 0.5))
        one.until("live.hearing() === 3")
        one.until("document.getElementById('me').className === 'none'")
        one.lift()
        for phone in (one, other):
            assert phone.errors == []
            phone.context.close()


def lights_on(phone, stage):
    """How many of the dancers' lights are bright on the phone's canvas where the page says that they are."""
    return phone.page.evaluate("""() => live.dancers().filter(([x, z]) => {
        const [px, py] = outside(x, z), data = ctx.getImageData(px - 3, py - 3, 7, 7).data;
        let most = 0;
        for (let i = 0; i < data.length; i += 4) most = Math.max(most, data[i] + data[i + 1] + data[i + 2]);
        return most > 560;
    }).length""")


def caption(stage):
    """The audience's caption in the picture now."""
    view = stage.show.view()
    with stage.lock:
        stage.show.fill(view, stage.show.time)
    return view.caption


def test_hostile_names_are_text_and_fit_on_the_smallest_phone(chromium):
    opened, device = chromium
    hostile = '<img src=x onerror="document.title=1">'
    with Stage(f'regions = ["{{n}}", {json.dumps(hostile)}]\nvote_measures = 64\n') as stage:
        small = device | {"viewport": {"width": 320, "height": 568}}
        phone = Phone(opened, small, stage.part.invitation_link, "fr-FR").ready()
        with stage.lock:
            names = (hostile, "\u202eevil" + "x" * 200, "{who}", "ok")
            stage.show.audience.vote = Vote(5, "step", names, 999)
        phone.until("document.querySelectorAll('#choices button').length === 4")
        shown = phone.page.evaluate("[...document.querySelectorAll('#choices span')].map(one => one.textContent)")
        assert shown == list(names)
        assert phone.page.evaluate("document.querySelectorAll('img, script:not(body script)').length") == 0
        wide = phone.page.evaluate("[document.documentElement.scrollWidth, document.documentElement.scrollHeight]")
        assert wide == [320, 568]
        sizes = phone.page.evaluate(
            "[...document.querySelectorAll('button:not([hidden]), #pick')].filter(one => one.offsetParent)"
            ".map(one => [one.offsetWidth, one.offsetHeight])"
        )
        assert min(min(size) for size in sizes) >= 48  # for fingers
        assert phone.page.evaluate("document.getElementById('stage').clientHeight") >= 100
        assert phone.errors == []
        phone.context.close()
