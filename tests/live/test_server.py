"""Requests of strangers are refused, wrong messages are told, many end a connection; the server stays alive."""

import json
import re
import shutil
import socket
import time
from contextlib import ExitStack
from urllib.parse import urlsplit

import httpx
import pytest
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

import flexmb as fm
from flexmb.dynamics.sweeps import bifurcation as diagrams
from flexmb.mechanisms import slider_crank
from flexmb.show.live import page as messages
from flexmb.show.live import server as live_server

UPGRADE = {
    "Connection": "Upgrade",
    "Upgrade": "websocket",
    "Sec-WebSocket-Version": "13",
    "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==",
}


@pytest.fixture(scope="module")
def client(crank_page):
    """Client that comes as a browser on this machine does."""
    with httpx.Client(base_url=f"http://127.0.0.1:{crank_page._server.port}", timeout=60) as made:
        yield made


def token_of(page):
    return urlsplit(page.url).query.removeprefix("token=")


def socket_of(page, **options):
    url = urlsplit(page.url)
    headers = {"Origin": f"http://{url.netloc}"}
    return connect(f"ws://{url.netloc}/ws?{url.query}", additional_headers=headers, max_size=None, **options)


def heard(connection, kind):
    """The next message of a kind."""
    while True:
        said = json.loads(connection.recv(timeout=60))
        if said["type"] == kind:
            return said


def test_the_page_needs_no_network(crank_page):
    text = httpx.get(crank_page.url)
    assert text.status_code == 200
    assert "default-src &#x27;none&#x27;" in text.text
    assert f"connect-src ws://127.0.0.1:{crank_page._server.port}" in text.text
    assert not re.findall(r"""(?:src|href)=["'](?:https?:)?//""", text.text)
    for name, value in live_server.HEADERS.items():
        assert text.headers[name] == value
    assert "HttpOnly" in text.headers["set-cookie"]
    assert "SameSite=Strict" in text.headers["set-cookie"]


@pytest.mark.parametrize("path", ["/", "/run.nc", "/report.html", "/ws", "/nothing"])
def test_without_a_token_nothing_is_served(client, crank_page, path):
    for query in (
        "",
        "?token=",
        "?token=x",
        f"?token={token_of(crank_page)[:-1]}",
        "?token=%00",
        f"?t={token_of(crank_page)}",
    ):
        answer = client.get(path + query)
        assert answer.status_code == 403
        assert token_of(crank_page) not in answer.text


@pytest.mark.parametrize(
    "headers",
    [
        {"host": "evil.example"},
        {"host": "evil.example:80"},
        {"host": "127.0.0.1"},
        {"host": "127.0.0.1.evil.example:1"},
        {"host": ""},
        {"origin": "http://evil.example"},
        {"origin": "null"},
        {"origin": "https://127.0.0.1"},
        {"origin": "http://127.0.0.1:1"},
    ],
)
def test_foreign_hosts_and_origins_are_refused(client, crank_page, headers):
    query = f"token={token_of(crank_page)}"
    assert client.get(f"/?{query}", headers=headers).status_code == 403
    assert client.get(f"/ws?{query}", headers={**UPGRADE, **headers}).status_code == 403


@pytest.mark.parametrize(
    "path",
    [
        "/../etc/passwd",
        "/%2e%2e/%2e%2e/etc/passwd",
        "/assets/live.js",
        "/run.nc/../../x",
        "/report.html%2f..",
        "//etc/passwd",
    ],
)
def test_no_file_is_served_by_its_path(crank_page, path):
    url = urlsplit(crank_page.url)
    with socket.create_connection((url.hostname, url.port)) as raw:  # as it stands: clients tidy paths
        raw.sendall(f"GET {path}?{url.query} HTTP/1.1\r\nHost: {url.netloc}\r\nConnection: close\r\n\r\n".encode())
        answer = b""
        while piece := raw.recv(1 << 16):
            answer += piece
    assert answer.split(b" ", 2)[1] == b"404"
    assert b"root:" not in answer


def test_other_methods_are_refused(client, crank_page):
    query = f"?token={token_of(crank_page)}"
    for method in ("POST", "PUT", "DELETE"):
        assert client.request(method, f"/{query}").status_code == 405


@pytest.mark.slow
def test_the_newest_run_is_saved(crank_page, tmp_path):
    view = crank_page.set(speed=200.0, clearance=1e-4)
    url = urlsplit(crank_page.url)
    for name in ("run.nc", "report.html"):
        answer = httpx.get(f"http://{url.netloc}/{name}?{url.query}", timeout=60)
        assert answer.status_code == 200
        (tmp_path / name).write_bytes(answer.content)
    saved = fm.load(tmp_path / "run.nc")
    assert saved.status == view.status
    assert saved.peak("B.normal_force").value == view.largest["B.normal_force"]
    assert "slider-crank" in (tmp_path / "report.html").read_text(encoding="utf-8")


@pytest.mark.slow
@pytest.mark.parametrize("packages", [{"imageio_ffmpeg"}, pytest.param(set(), marks=pytest.mark.slow)])
def test_a_film_of_the_newest_run_is_saved(crank_page, monkeypatch, packages):
    """As .mp4 where the package for it is there, else as .gif; both begin as their formats say."""
    if packages:
        pytest.importorskip("imageio_ffmpeg")
    else:
        monkeypatch.setattr(messages, "find_spec", lambda _: None)
    url = urlsplit(crank_page.url)
    answer = httpx.get(f"http://{url.netloc}/film?{url.query}", timeout=120)
    assert answer.status_code == 200
    ending = ".mp4" if packages else ".gif"
    assert f'filename="slider-crank{ending}"' in answer.headers["content-disposition"]
    assert answer.content[4:8] == b"ftyp" if packages else answer.content[:6] == b"GIF89a"


def test_a_browser_sets_values_and_sees_the_run(crank_page):
    with socket_of(crank_page) as connection:
        first = heard(connection, "run")
        connection.send(json.dumps({"type": "set", "values": {"speed": 222.0}, "length": 0.5}))
        said = heard(connection, "run")
        while said["number"] == first["number"]:
            said = heard(connection, "run")
        assert said["values"]["speed"] == 222.0
        assert said["ok"]
        assert "speed=222.0" in said["code"]
        connection.send(json.dumps({"type": "want", "signals": ["crank.theta", "nothing", "<img src=x>"]}))
        again = heard(connection, "run")
        assert "crank.theta" in again["signals"]["names"]
        assert "nothing" not in again["signals"]["names"]
        assert heard(connection, "findings")["rows"] is not None
    crank_page._runner.wait(crank_page._runner.submit({}, 1.0))


def read_all(connection):
    while True:
        connection.recv(timeout=60)


def send_many(connection, sent):
    for _ in range(100_000):
        connection.send('{"type": "stop"}')
        sent.append(1)
    read_all(connection)


WRONG = [
    "", "no JSON", "[]", "null", "1e999", "[" * 60_000, '{"type": "eval"}', '{"type": "set", "values": 3}',
    '{"type": "set", "values": {"speed": NaN}}', '{"type": "set", "values": {"speed": 1e999}}',
    '{"type": "set", "values": {"speed": ' + "9" * 6000 + "}}", '{"type": "set", "values": {"__class__": 1}}',
    '{"type": "set", "values": {"speed": "__import__(\'os\')"}}', '{"type": "set", "values": {}, "length": 1e9}',
    '{"type": "set", "values": {"<script>alert(1)</script>": 1}}', '{"type": "want", "signals": "all"}',
    '{"type": "go", "on": "yes"}', '{"type": "study", "kind": "code"}',
    '{"type": "study", "kind": "diagram", "parameter": "speed", "low": 50, "high": 1e9, "count": 5}',
    '{"type": "study", "kind": "diagram", "parameter": "speed", "low": 50, "high": 60, "count": 1e9}',
]  # fmt: skip


@pytest.mark.quick(8)
@pytest.mark.parametrize("text", WRONG, ids=[text[:40] for text in WRONG])
def test_wrong_messages_are_refused_and_change_nothing(crank_page, text):
    before = crank_page.code()
    with socket_of(crank_page) as connection:
        heard(connection, "run")
        connection.send(text)
        assert len(heard(connection, "refused")["text"]) < 500
    assert crank_page.code() == before


def test_markup_in_a_refusal_is_no_markup_of_the_page(crank_page):
    with socket_of(crank_page) as connection:
        connection.send('{"type": "set", "values": {"<script>alert(1)</script>": 1}}')
        while "refused" not in (raw := connection.recv(timeout=60))[:40]:
            pass
    assert "<" not in raw


def test_names_with_markup_stay_text():
    arm = fm.RigidLink("arm", (0.0, 0.0), (0.5, 0.0), mass=1.0, inertia=0.02)
    mech = fm.Mechanism("<img src=x onerror=alert(1)>", [arm, fm.Revolute("O", fm.GROUND, arm, at=(0.0, 0.0))])
    with fm.explore(mech, vary=["arm.mass"], t_end=0.1, open=False, block=False) as page:
        assert "<img" not in httpx.get(page.url).text


def test_a_large_message_ends_its_connection_alone(crank_page):
    with socket_of(crank_page) as connection:
        heard(connection, "run")
        connection.send("x" * (2 * live_server.MOST_BYTES))
        with pytest.raises(ConnectionClosed):
            read_all(connection)
    assert crank_page.set(speed=210.0).ok


def test_too_many_messages_end_their_connection_alone(crank_page):
    sent = []
    with socket_of(crank_page) as connection:
        with pytest.raises(ConnectionClosed) as closed:
            send_many(connection, sent)
        assert closed.value.rcvd.code == live_server.POLICY_VIOLATION
    assert len(sent) >= live_server.BURST
    assert crank_page.set(speed=211.0).ok


def test_too_many_browsers_are_sent_away(crank_page):
    with ExitStack() as stack:
        for _ in range(live_server.MOST_CLIENTS):
            heard(stack.enter_context(socket_of(crank_page)), "run")
        with pytest.raises(ConnectionClosed) as closed, socket_of(crank_page) as one:
            one.recv(timeout=60)
        assert closed.value.rcvd.code == live_server.TRY_LATER
    end = time.monotonic() + 10.0
    while crank_page._server.clients and time.monotonic() < end:
        time.sleep(0.02)
    assert not crank_page._server.clients


@pytest.mark.slow
def test_a_browser_that_does_not_read_costs_no_memory(crank_page):
    with socket_of(crank_page):
        for k in range(30):
            crank_page.set(speed=200.0 + k)
        (client,) = crank_page._server.clients
        assert len(client.waiting) <= 3
    assert crank_page.set(speed=212.0).ok


def test_a_lost_connection_leaves_the_page(crank_page):
    url = urlsplit(crank_page.url)
    with socket_of(crank_page) as connection:
        connection.socket.shutdown(socket.SHUT_RDWR)
        assert crank_page.set(speed=213.0).ok
    with socket_of(crank_page) as again:
        assert heard(again, "run")["values"]["speed"] == 213.0
    assert url.port == crank_page._server.port


def test_close_frees_the_port():
    page = fm.explore(slider_crank, vary={"speed": (50.0, 500.0)}, periods=0.1, open=False, block=False)
    port = page._server.port
    with socket_of(page) as connection:
        heard(connection, "run")
        page.close()
    with socket.socket() as free:
        free.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        free.bind(("127.0.0.1", port))
    with pytest.raises(httpx.ConnectError):
        httpx.get(page.url)


def test_a_diagram_comes_point_by_point_and_its_points_are_those_of_the_run(crank_page):
    crank_page.set(clearance=1e-4)
    wish = {"type": "study", "kind": "diagram", "parameter": "speed", "low": 200, "high": 300, "count": 3}
    with socket_of(crank_page) as connection:
        connection.send(json.dumps({**wish, "signal": "slider.x", "skip": 2, "keep": 3}))
        found = [heard(connection, "study") for _ in range(4)]
    assert [one.get("at") for one in found] == [200.0, 300.0, 250.0, None]
    assert found[-1]["done"]
    direct = fm.bifurcation(
        slider_crank, "speed", [250.0], fixed={"clearance": 1e-4}, skip=2, keep=3, signals=["slider.x"]
    )
    assert found[2]["points"] == direct["slider.x"].values.ravel().tolist()


def test_an_unknown_signal_of_a_diagram_is_told(crank_page):
    wish = {"type": "study", "kind": "diagram", "parameter": "speed", "low": 200, "high": 300, "count": 2}
    with socket_of(crank_page) as connection:
        connection.send(json.dumps({**wish, "signal": "slider.xx", "skip": 0, "keep": 1}))
        assert "Did you mean 'slider.x'" in heard(connection, "study")["fault"]


def painted(store, wish, *, stop_after=None, model=slider_crank):
    """Messages of a diagram on a page of its own with a store, stopped after some points."""
    vary = {"speed": (50.0, 500.0)}
    with fm.explore(model, vary=vary, periods=0.1, store=store, open=False, block=False) as page:
        with socket_of(page) as connection:
            connection.send(json.dumps(wish))
            found = []
            while not found or not found[-1]["done"]:
                found.append(heard(connection, "study"))
                if len(found) == stop_after:
                    connection.send(json.dumps({"type": "stop"}))
        return found


@pytest.mark.slow
def test_a_stopped_diagram_goes_on_from_its_store(tmp_path, monkeypatch):
    wish = {"type": "study", "kind": "diagram", "parameter": "speed", "low": 100, "high": 300, "count": 9}
    wish |= {"signal": "slider.x", "skip": 2, "keep": 2}
    first = painted(tmp_path, wish, stop_after=2)
    assert first[-1]["stopped"]
    assert 2 <= len(first[:-1]) < 9
    computed, real = [], diagrams.section_point
    monkeypatch.setattr(diagrams, "section_point", lambda *given: computed.append(given[2]) or real(*given))
    second = painted(tmp_path, wish)
    told = {one["at"]: one["points"] for one in second[:-1]}
    assert not second[-1]["stopped"]
    assert sorted(told) == [100.0 + 25.0 * k for k in range(9)]
    known = {one["at"]: one["points"] for one in first[:-1]}
    assert {at: told[at] for at in known} == known
    assert sorted([*computed, *known]) == sorted(told)  # what was known is not computed again
    assert len(list(tmp_path.glob("speed-*.zarr"))) == 1
    painted(tmp_path, {**wish, "keep": 1})
    assert len(list(tmp_path.glob("speed-*.zarr"))) == 2  # another diagram has a store of its own


def heavier_slider_crank(speed: float = 100.0):
    """A slider-crank of another mass, with the same arguments."""
    return slider_crank(speed=speed).with_({"slider.mass": 1.0})


@pytest.mark.slow
def test_another_model_in_the_same_folder_has_a_store_of_its_own(tmp_path):
    wish = {"type": "study", "kind": "diagram", "parameter": "speed", "low": 100, "high": 300, "count": 2}
    wish |= {"signal": "A.fx", "skip": 0, "keep": 1}
    light, heavy = painted(tmp_path, wish), painted(tmp_path, wish, model=heavier_slider_crank)
    assert [one.get("fault") for one in [light[-1], heavy[-1]]] == [None, None]
    for a, b in zip(heavy[:-1], light[:-1], strict=True):
        assert abs(a["points"][0]) > 1.2 * abs(b["points"][0])
    assert len(list(tmp_path.glob("speed-*.zarr"))) == 2


@pytest.mark.slow
def test_points_of_a_store_that_is_refused_are_not_shown(tmp_path):
    wish = {"type": "study", "kind": "diagram", "parameter": "speed", "low": 100, "high": 300, "count": 2}
    wish |= {"signal": "slider.x", "skip": 0, "keep": 1}
    painted(tmp_path, wish)
    painted(tmp_path, {**wish, "signal": "slider.vx"})
    first, second = tmp_path.glob("speed-*.zarr")
    shutil.rmtree(second)
    shutil.copytree(first, second)  # a store of another diagram in the place of this one
    told = painted(tmp_path, wish) + painted(tmp_path, {**wish, "signal": "slider.vx"})
    (refused,) = (one for one in told if one["done"] and "fault" in one)
    assert "written by another sweep" in refused["fault"]
    assert len([one for one in told if not one["done"]]) == 2  # of the diagram whose store is its own
