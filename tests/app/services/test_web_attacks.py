"""The operator's page under attack: foreign pages, wrong keys, and abandoned connections."""

import asyncio
import base64
import contextlib
import json
import os
import socket
import threading
import time

import aiohttp
import pytest

from live.app.services.http_services import HttpService
from live.clock.time_source import SystemClock
from tests.end_to_end.browser import browser, needs_browser

KEY = "a-key-of-the-tests-4711"
BLACKOUT = json.dumps({"address": "/dance/blackout", "values": [1]})


class PageServer:
    """The page's own process, and a socket in place of the show's OSC port."""

    def __init__(self, hosts=(), at="127.0.0.1"):
        self.show = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.show.bind(("127.0.0.1", 0))
        plan = {
            "key": KEY, "osc": self.show.getsockname(), "name": "a show", "half": (5.0, 3.0), "names": {},
            "hosts": list(hosts),
        }  # fmt: skip
        self.part = HttpService((at, 0), "--web", "live.control.web.web_server", lambda: plan, SystemClock())

    def __enter__(self):
        self.part.start()
        self.port = self.part.port
        with self.connected() as ready:  # until the process answers
            assert ready.status() == 200
        return self

    def __exit__(self, *_):
        self.part.stop()
        self.show.close()

    def connected(self, path="/", host=None, **headers):
        """Send a request and return it."""
        return RawRequest(self.port, path, f"127.0.0.1:{self.port}" if host is None else host, headers)

    @property
    def dark(self):
        """Whether a blackout message has arrived since the last check."""
        self.show.setblocking(False)
        with contextlib.suppress(BlockingIOError):
            while True:
                if self.show.recv(2000).startswith(b"/dance/blackout\0"):
                    return True
        return False


class RawRequest:
    """One handwritten HTTP request over a socket of its own."""

    def __init__(self, port, path, host, headers, room=None):
        self.socket = socket.socket()
        self.socket.settimeout(20.0)
        if room is not None:
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, room)
        self.socket.connect(("127.0.0.1", port))
        lines = [f"GET {path} HTTP/1.1", *([f"Host: {host}"] if host else [])]
        lines += [f"{name.replace('_', '-')}: {value}" for name, value in headers.items()]
        self.socket.sendall("\r\n".join([*lines, "", ""]).encode("latin-1"))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.socket.close()

    def head(self):
        got = b""
        while b"\r\n\r\n" not in got:
            more = self.socket.recv(4096)
            if not more:
                break
            got += more
        return got.partition(b"\r\n\r\n")[0].decode("latin-1")

    def status(self):
        head = self.head()
        return int(head.split()[1]) if head else 0

    def send_text(self, text):
        """A masked text frame (RFC 6455)."""
        data, mask = text.encode(), os.urandom(4)
        body = bytes(byte ^ mask[place % 4] for place, byte in enumerate(data))
        self.socket.sendall(bytes([0x81, 0x80 | len(data)]) + mask + body)

    def closed_within(self, seconds):
        """Seconds until the other side closes; None if it stays open."""
        started = time.monotonic()
        self.socket.settimeout(seconds)
        try:
            while self.socket.recv(65536):
                pass
        except TimeoutError:
            return None
        except OSError:
            pass
        return time.monotonic() - started


def upgrade_headers(**headers):
    return {
        "Upgrade": "websocket", "Connection": "Upgrade", "Sec_WebSocket_Version": "13",
        "Sec_WebSocket_Key": base64.b64encode(os.urandom(16)).decode(), **headers,
    }  # fmt: skip


def key_headers(key=KEY):
    return {"Sec_WebSocket_Protocol": f"live.operator, live.key.{key}"}


def attempt_blackout(served, host, headers, path="/ws"):
    """The status that a foreign page receives, and whether the show became dark."""
    with served.connected(path, host, **upgrade_headers(**headers)) as raw:
        status = raw.status()
        if status == 101:
            raw.send_text(BLACKOUT)
            raw.closed_within(0.3)
    return status, served.dark


@pytest.mark.long
def test_foreign_page_cannot_black_out_show():
    with PageServer() as served:
        here = f"127.0.0.1:{served.port}"
        # its own name leads here by now (DNS rebinding): to the browser it is one site, Host and Origin agree
        for name in ("evil.local", "evil.example", "localhost.evil.example", "127.0.0.1.evil.local", "localhost."):
            host = f"{name}:{served.port}"
            headers = {"Origin": f"http://{host}"}
            assert attempt_blackout(served, host, headers) == (403, False), name
            assert attempt_blackout(served, host, headers | key_headers()) == (403, False), f"{name}, with the key"
            assert attempt_blackout(served, host, headers, f"/ws?key={KEY}") == (403, False), name
            for path in ("/", "/surface.json"):
                with served.connected(path, host) as raw:
                    assert raw.status() == 403
        # it asks across sites
        for origin in (
            "http://evil.example",
            f"http://localhost:{served.port}",
            "http://127.0.0.1:1",
            "null",
            "file://",
        ):
            assert attempt_blackout(served, here, {"Origin": origin} | key_headers()) == (403, False), origin
        for host in (
            "127.0.0.1:1",
            "127.0.0.1",
            f"127.0.0.2:{served.port}",
            f"[::2]:{served.port}",
            "",
            ":",
            "x" * 8000,
        ):
            assert attempt_blackout(served, host, key_headers())[1] is False, host
        with RawRequest(served.port, "/", "", {}) as raw:  # none at all
            assert raw.status() in (400, 403)
        with RawRequest(served.port, "/", f"{here}\r\nHost: evil.example", {}) as raw:  # two
            assert raw.status() in (400, 403)
        # another program of this machine has no key
        for headers in ({}, {"Origin": f"http://{here}"}, key_headers("another-key-of-the-tests"), key_headers("")):
            assert attempt_blackout(served, here, headers)[1] is False
        # the page itself
        for host in (here, f"localhost:{served.port}", f"LOCALHOST:{served.port}", f"[::1]:{served.port}"):
            assert attempt_blackout(served, host, {"Origin": f"http://{host}"} | key_headers()) == (101, True), host


@pytest.mark.long
def test_host_name_is_accepted_only_if_configured():
    with PageServer(hosts=["show.example:443", "stage.example"]) as served:
        for host, status in (
            ("show.example", 200), ("show.example:443", 200), (f"stage.example:{served.port}", 200),
            ("stage.example", 403), (f"show.example:{served.port}", 403), (f"x.stage.example:{served.port}", 403),
        ):  # fmt: skip
            with served.connected("/", host) as raw:
                assert raw.status() == status, host
        assert attempt_blackout(served, "show.example", {"Origin": "https://show.example"} | key_headers()) == (
            101,
            True,
        )
        assert attempt_blackout(served, "show.example", {"Origin": "https://evil.example"} | key_headers()) == (
            403,
            False,
        )


def test_wrong_keys_are_answered_slowly_and_right_key_at_once():
    with PageServer() as served:

        def attempt(key):
            started = time.monotonic()
            with served.connected("/surface.json", Authorization=f"Bearer {key}") as raw:
                return raw.status(), time.monotonic() - started

        for text in (
            "",
            "Bearer",
            "Bearer ",
            f"Basic {KEY}",
            KEY,
            f"Bearer {KEY}x",
            f"Bearer {KEY[:-1]}",
            "Bearer ü\xff",
        ):
            with served.connected("/surface.json", Authorization=text) as raw:
                assert raw.status() == 401, text
        assert [attempt("wrong")[0] for _ in range(2)] == [401, 401]
        more = []
        threads = [threading.Thread(target=lambda: more.append(attempt("wrong"))) for _ in range(24)]
        for thread in threads:
            thread.start()
        status, took = attempt(KEY)
        assert status == 200
        assert took < 0.9, "whoever has the key does not wait for those who have none"
        for thread in threads:
            thread.join()
        slow = [took for status, took in more if status == 429]
        assert len([status for status, _ in more if status == 401]) <= 2
        assert len(slow) <= 9
        assert min(slow) > 0.9


@pytest.mark.long
def test_half_open_slow_and_dead_connections_are_closed_within_seconds():
    with PageServer() as served:
        here = f"127.0.0.1:{served.port}"
        silent = [socket.create_connection(("127.0.0.1", served.port)) for _ in range(20)]
        head = socket.create_connection(("127.0.0.1", served.port))
        body = socket.create_connection(("127.0.0.1", served.port))
        body.sendall(f"POST / HTTP/1.1\r\nHost: {here}\r\nContent-Length: 1000\r\n\r\n".encode())
        deaf = served.connected("/ws", **upgrade_headers(**key_headers()))  # answers no ping
        unread = RawRequest(served.port, "/surface.json", here, {"Authorization": f"Bearer {KEY}"}, room=2048)
        idle = served.connected("/")
        until, left = time.monotonic() + 15.0, {*silent, head, body, deaf.socket, unread.socket, idle.socket}
        for each in left:
            each.setblocking(False)
        while left and time.monotonic() < until:
            for slowly, more in ((head, b"G"), (body, b"x")):
                with contextlib.suppress(OSError):
                    slowly.send(more)
            for each in list(left):
                try:
                    if not each.recv(65536):
                        left.discard(each)
                except BlockingIOError:
                    pass
                except OSError:
                    left.discard(each)
            time.sleep(0.1)
        for each in (*silent, head, body, deaf.socket, unread.socket, idle.socket):
            each.close()
        assert not left, f"{len(left)} of {len(silent) + 5} stayed"


@pytest.mark.long
def test_client_that_reads_nothing_delays_no_other_client():
    def tell(text):
        served.part.publish({"/dance/status/source": (("", (text,)),)})
        served.part.frame()

    async def operator():
        protocols = ("live.operator", f"live.key.{KEY}")
        at = f"http://127.0.0.1:{served.port}/ws"
        async with aiohttp.ClientSession() as client, client.ws_connect(at, protocols=protocols) as ws:
            for n in range(60):
                text = f"{n:60000}"
                tell(text)
                told = {}
                while told.get("/dance/status/source") != [text]:
                    told = json.loads((await ws.receive(timeout=3.0)).data)["values"]

    with PageServer() as served:
        here = f"127.0.0.1:{served.port}"
        with RawRequest(served.port, "/ws", here, upgrade_headers(**key_headers()), room=2048) as deaf:
            assert deaf.status() == 101
            asyncio.run(operator())


@pytest.mark.long
def test_operator_connects_while_hundreds_of_connections_are_abandoned():
    with PageServer() as served:
        over, opened, left, lost = threading.Event(), [], [], []

        def open_many():
            while not over.is_set():
                with contextlib.suppress(OSError):
                    made = socket.create_connection(("127.0.0.1", served.port), timeout=0.5)
                    opened.append(1)
                    left.append(made)
                    made.send(b"GET / HT")
                while len(left) > 600:  # what one process may have open
                    left.pop(0).close()

        async def operator():
            """One visit; as a browser does, it asks again if the connection went before there was an answer."""
            try:
                await visit()
            except aiohttp.ServerDisconnectedError as error:
                lost.append(error)
                await visit()

        async def visit():
            async with aiohttp.ClientSession(f"http://127.0.0.1:{served.port}") as client:
                async with client.get("/") as answer:
                    assert answer.status == 200
                async with client.get("/surface.json", headers={"Authorization": f"Bearer {KEY}"}) as answer:
                    assert answer.status == 200
                    await answer.json()
                protocols = ("live.operator", f"live.key.{KEY}")
                async with client.ws_connect("/ws", protocols=protocols) as ws:
                    await ws.send_str(BLACKOUT)
                    await asyncio.sleep(0.2)
                    assert not ws.closed

        thread = threading.Thread(target=open_many)
        thread.start()
        try:
            while len(opened) < 400:
                time.sleep(0.01)
            waits = []
            for _ in range(5):
                started = time.monotonic()
                asyncio.run(asyncio.wait_for(operator(), 20.0))
                waits.append(time.monotonic() - started)
                assert served.dark
        finally:
            over.set()
            thread.join()
            for each in left:
                each.close()
        assert sorted(waits)[2] < 3.0, waits
        assert len(lost) <= 1


@pytest.mark.long
@pytest.mark.browser
@needs_browser
def test_foreign_page_in_browser_is_blocked_and_link_logs_in():
    attack = f"""<!doctype html><title>evil</title><script>
    const done = [];
    for (const host of [location.host, "127.0.0.1:" + location.port])
      for (const more of [undefined, ["live.operator", "live.key.guessed-key-0001"]]) done.push(new Promise(end => {{
        const ws = new WebSocket("ws://" + host + "/ws?key=", more);
        ws.onopen = () => {{ ws.send({json.dumps(BLACKOUT)}); setTimeout(() => end("open"), 200); }};
        ws.onclose = () => end("closed");
      }}));
    Promise.all(done).then(all => {{ document.title = all.join(" "); }});
    </script>"""
    with PageServer() as served, browser("--host-resolver-rules=MAP evil.local 127.0.0.1") as (opened, _):
        evil = opened.new_page()
        at = f"http://evil.local:{served.port}/"
        # the first answer came from the attacker's machine; since then the name leads here
        evil.route(at, lambda route: route.fulfill(body=attack, content_type="text/html"))
        evil.goto(at)
        evil.wait_for_function("document.title !== 'evil'")
        assert evil.title() == "closed closed closed closed"
        assert not served.dark

        page = opened.new_page(viewport={"width": 900, "height": 700})
        problems = []
        page.on("pageerror", lambda error: problems.append(str(error)))
        page.goto(f"http://127.0.0.1:{served.port}/")
        page.get_by_label("The key of this show").fill("a-wrong-key-of-mine")
        page.get_by_role("button", name="Open", exact=True).click()
        page.get_by_text("this key is not").wait_for()
        assert not page.get_by_role("button", name="Blackout").is_visible()
        page.goto(f"http://127.0.0.1:{served.port}/#key={KEY}")
        page.get_by_role("button", name="Blackout").wait_for()
        assert page.url == f"http://127.0.0.1:{served.port}/", "the key does not stay in the address"
        page.get_by_role("button", name="Blackout").click()
        until = time.monotonic() + 10.0
        while not served.dark:
            assert time.monotonic() < until
            page.wait_for_timeout(20)
        page.goto(f"http://127.0.0.1:{served.port}/#key=a-wrong-key-in-a-link")
        page.reload()
        page.get_by_role("button", name="Blackout").wait_for()  # the browser has kept the right one
        assert problems == []
