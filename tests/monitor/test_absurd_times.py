"""One absurd time stamp costs its samples and nothing else: it is counted, and the state stays readable."""

import json

import pytest

from tests.commands import run


def records(log):
    return [json.loads(line) for line in log.read_text().splitlines()]


def of_kind(log, *kinds):
    return [each for each in records(log) if each.get("event", "window") in kinds]


def with_absurd_times(lines, is_json):
    """Three of them in the midst of a stream, the last one at its end."""
    header, *rows = lines
    absurd = [f"{stamp},1\n" for stamp in ("1e300", "-1e12", "1e11")]
    absurd[-1] = absurd[-1].replace("1e11", "1.0001e11")
    rows = [*rows[:5000], *absurd[:2], *rows[5000:], absurd[2]]
    if not is_json:
        return [header, *rows]
    pairs = (row.strip().split(",") for row in rows)
    return [f'{{"time [s]": {time}, "P1 [bar]": {pressure}}}\n' for time, pressure in pairs]


@pytest.mark.parametrize("is_json", [False, True], ids=["CSV", "JSON lines"])
def test_in_a_file_it_is_counted_and_changes_no_window(machine, is_json, tmp_path):
    stream, log = tmp_path / "stream", tmp_path / "log"
    run("monitor", machine.detector, machine.stream, "--no-follow", "--log", tmp_path / "expected", check=0)
    stream.write_text("".join(with_absurd_times(machine.lines, is_json)))
    files = ("--no-follow", "--state", tmp_path / "state", "--log", log)
    done = run("monitor", machine.detector, stream, *files, check=0)
    assert "Traceback" not in done.stderr
    assert of_kind(log, "window") == of_kind(tmp_path / "expected", "window")
    assert sum(each["count"] for each in of_kind(log, "malformed")) == 3
    assert not of_kind(log, "not_stored")
    with stream.open("a") as file:
        file.write(with_absurd_times(machine.lines, is_json)[-1])
    run("monitor", machine.detector, stream, *files, check=0)
    assert len(of_kind(log, "resumed")) == 1
    assert sum(each["count"] for each in of_kind(log, "malformed")) == 4
