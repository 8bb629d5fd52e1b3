import time
from threading import enumerate as threads

import pytest

from hydrofdi.errors import ConfigError
from hydrofdi.monitor.lines import Event, EventKind
from hydrofdi.monitor.sinks.webhook import WebhookSink
from hydrofdi.monitor.sinks.webhook_config import TOKEN, WebhookConfig
from tests.monitor.certificates import Authority
from tests.monitor.opcua_server import free_port
from tests.monitor.web_server import WebServer

SECRET = "hunter2-of-the-press"
RAISED = Event(EventKind.ALARM_RAISED, "the score is above its limit", time=12.5)


@pytest.fixture
def sink_at(closing):
    def opened(url, capacity=1000, **more):
        config = WebhookConfig(url=url, machine="press 3", timeout=20.0, **more)
        return closing(WebhookSink(config, capacity=capacity, first_wait=0.02))

    return opened


def said(sink, kind):
    """What the sink says of this kind, waited for."""
    deadline, events = time.monotonic() + 60, []
    while not (found := [event for event in events if event.kind is kind]):
        assert time.monotonic() < deadline, events
        events += sink.put(None, [])
        time.sleep(0.01)
    return found


def test_an_alarm_is_posted_with_its_machine(sink_at):
    with WebServer() as server:
        sink_at(server.url).put(None, [RAISED])
        (document,) = server.wait_for(1)
    assert document["machine"] == "press 3"
    assert document["event"] == "alarm_raised"
    assert document["time"] == 12.5
    assert server.posts[0][1]["Content-Type"] == "application/json"


def test_only_wanted_events_are_posted(sink_at):
    gap, silent = Event(EventKind.GAP, "a gap"), Event(EventKind.ALARM_RAISED, "again", is_silent=True)
    with WebServer() as server:
        sink_at(server.url).put(None, [gap, silent, RAISED])
        sink_at(server.url, events=("gap",)).put(None, [gap, RAISED])
        documents = server.wait_for(2)
    assert sorted(document["event"] for document in documents) == ["alarm_raised", "gap"]


def test_a_server_in_trouble_is_asked_again_and_gets_all_in_order(sink_at):
    events = [Event(EventKind.ALARM_RAISED, str(number)) for number in range(3)]
    with WebServer([503, 500, 429]) as server:
        sink = sink_at(server.url)
        sink.put(None, events)
        documents = server.wait_for(6)
        assert len(said(sink, EventKind.CONNECTED)) == 1
    assert [document["text"] for document in documents] == ["0", "0", "0", "0", "1", "2"]
    keys = [headers["Idempotency-Key"] for _, headers in server.posts]
    assert [keys.index(key) for key in keys] == [0, 0, 0, 0, 4, 5]


def test_a_server_that_is_not_there_is_waited_for_and_said_once(sink_at):
    port = free_port()
    sink = sink_at(f"http://127.0.0.1:{port}/hook")
    sink.put(None, [RAISED])
    (event,) = said(sink, EventKind.DISCONNECTED)
    assert "connection refused" in event.text
    with WebServer(port=port) as server:
        server.wait_for(1)
        said(sink, EventKind.CONNECTED)


@pytest.mark.parametrize("status", [400, 401, 404])
def test_a_post_that_is_refused_is_not_repeated(sink_at, status):
    with WebServer([status]) as server:
        sink = sink_at(server.url)
        sink.put(None, [RAISED, RAISED])
        (event,) = said(sink, EventKind.DROPPED)
        server.wait_for(2)
    assert str(status) in event.text
    assert len(server.posts) == 2


@pytest.mark.parametrize("status", [301, 302, 303, 307, 308])
def test_a_redirect_does_not_get_the_secret(sink_at, monkeypatch, status):
    monkeypatch.setenv(TOKEN, SECRET)
    with WebServer() as elsewhere, WebServer([status], location=elsewhere.url) as server:
        sink = sink_at(server.url)
        sink.put(None, [RAISED])
        (event,) = said(sink, EventKind.DROPPED)
    assert server.posts[0][1]["Authorization"] == f"Bearer {SECRET}"
    assert elsewhere.posts == []
    assert "redirects are not followed" in event.text


def test_a_full_queue_loses_new_events_and_counts_them(sink_at):
    sink = sink_at(f"http://127.0.0.1:{free_port()}", capacity=3)
    events = [*sink.put(None, [RAISED] * 5), *sink.put(None, [RAISED] * 2)]
    dropped = [event for event in events if event.kind is EventKind.DROPPED]
    assert sum(event.count for event in dropped) == 4
    assert [event.is_silent for event in dropped] == [False, True]


def test_what_waits_is_posted_before_the_end():
    with WebServer() as server:
        sink = WebhookSink(WebhookConfig(url=server.url))
        sink.put(None, [RAISED] * 5)
        sink.close()
        assert len(server.posts) == 5
    assert not [thread for thread in threads() if thread.name == "webhook"]


def test_a_certificate_is_checked(sink_at, tmp_path):
    authority = Authority(tmp_path)
    with WebServer(certificate=authority.signed("server")) as server:
        (event,) = said_after_post(sink_at(server.url))
        assert "its certificate is refused" in event.text
        sink_at(server.url, ca_file=authority.file).put(None, [RAISED])
        assert server.wait_for(1)


def said_after_post(sink):
    sink.put(None, [RAISED])
    return said(sink, EventKind.DISCONNECTED)


@pytest.mark.parametrize("url", ["", "ftp://host/x", "https://", "https://host:x/", "https://host/a b"])
def test_what_is_no_address_is_refused(url):
    with pytest.raises(ConfigError, match="as https://host/path"):
        WebhookSink(WebhookConfig(url=url))


def test_secrets_are_refused_where_others_see_them(tmp_path):
    token = tmp_path / "token"
    token.write_text(SECRET + "\n")
    with pytest.raises(ConfigError, match="no credentials in an address") as error:
        WebhookSink(WebhookConfig(url=f"https://me:{SECRET}@host/"))
    assert SECRET not in str(error.value)
    with pytest.raises(ConfigError, match="use https") as error:
        WebhookSink(WebhookConfig(url="http://host/", token_file=token))
    assert SECRET not in str(error.value)


@pytest.mark.parametrize("content", ["", "one\ntwo\n"])
def test_a_file_that_holds_no_single_line_is_named(tmp_path, content):
    file = tmp_path / "token"
    file.write_text(content)
    with pytest.raises(ConfigError, match=f"{file}: must contain one line"):
        WebhookSink(WebhookConfig(url="https://host/", token_file=file))
