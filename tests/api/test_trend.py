"""`hydrofdi trend`: from the log of a monitor and from records with dates to dates with intervals."""

import json
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest

import hydrofdi
from hydrofdi.errors import ConfigError, DataError
from tests.commands import run, run_json
from tests.machines import settings_of

FIRST, DAY, LITRE = datetime(2026, 1, 1, tzinfo=UTC).timestamp(), 86400.0, 1e-3 / 60.0


def lines(levels, *, temperature=None, first=FIRST):
    """Lines of a monitor: six windows of each day around its level [L/min]."""
    random = np.random.default_rng(1)
    found = [{"line": "event", "event": "started", "time": None}]
    for day, level in enumerate(levels):
        for number in range(6):
            start = first + DAY * day + 3600.0 * (8 + number)
            score = LITRE * (level + 0.005 * random.standard_normal())
            warm = None if temperature is None else float(temperature[day])
            found.append({
                "line": "window", "number": len(found) - 1, "start": start, "end": start + 4.0,
                "score": score, "unit": "m^3/s", "oil_temperature": warm,
            })  # fmt: skip
    return found


def growing(rate=0.01):
    """Levels of 60 days, of which the last 25 grow."""
    noise = np.random.default_rng(2).standard_normal(60)
    return 0.02 + rate * np.maximum(np.arange(60) - 35, 0) + 0.008 * noise


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    path = tmp_path_factory.mktemp("log") / "press.jsonl"
    path.write_text("".join(json.dumps(line) + "\n" for line in lines(growing())))
    return path


def day_of(instant):
    return (datetime.fromisoformat(instant["date"]).timestamp() - FIRST) / DAY


def test_a_log_gives_dates_of_onset_and_limit_and_a_picture(log, tmp_path):
    told = run_json("trend", log, "--limit", "0.4 L/min", "--figure", tmp_path / "trend.png", "--json")
    assert told["has_trend"] is True
    assert day_of(told["onset"]["low"]) < 35.0 < day_of(told["onset"]["high"])
    reached = told["limit_reached"]
    assert day_of(reached["low"]) < 35.0 + 38.0 < day_of(reached["high"]) < 90.0
    assert told["level_now"]["low"] < 0.26 * LITRE < told["level_now"]["high"]
    assert told["rate_per_s"]["low"] < 0.01 * LITRE / DAY < told["rate_per_s"]["high"]
    assert len(told["points"]) == 60
    assert (tmp_path / "trend.png").read_bytes().startswith(b"\x89PNG")
    shown = run("trend", log, "--limit", "0.4 L/min", check=0).stdout.splitlines()
    assert shown[-1].startswith("The score has been growing since 2026-02-0")


def test_a_limit_is_in_the_past_or_never_reached_beyond_the_length_of_the_history(log):
    found = hydrofdi.trend(log, limit="2 L/min")
    assert found.reached.value == found.reached.high == np.inf
    record = found.to_dict()
    assert record["limit_reached"]["high"] == {"time_s": None, "date": None}
    assert "not reach 2 L/min within 59 days" in found.answer
    assert json.loads(json.dumps(record, allow_nan=False)) == record
    past = hydrofdi.trend(log, limit=0.1 * LITRE)
    assert past.reached.low < FIRST + 43.5 * DAY < past.reached.high < FIRST + 60 * DAY
    assert hydrofdi.trend(log, limit=0.001 * LITRE).reached.value == -np.inf


def test_a_healthy_machine_has_no_trend_and_no_date():
    found = hydrofdi.trend(lines(growing(rate=0.0)), limit="0.4 L/min")
    assert not found.has_trend
    assert found.onset is found.reached is found.rate is None
    assert found.answer.startswith("No trend in 59 days")
    assert found.level_now.low < 0.02 * LITRE < found.level_now.high


def test_warmer_oil_is_no_leak_if_its_temperature_is_known():
    random = np.random.default_rng(4)
    warm = 310.0 + 12.0 * (np.arange(60) > 40) + random.standard_normal(60)
    levels = growing(rate=0.0) + 0.01 * (warm - 310.0)
    assert hydrofdi.trend(lines(levels)).has_trend
    compensated = hydrofdi.trend(lines(levels, temperature=warm))
    assert not compensated.has_trend
    effect = compensated.temperature_effect
    assert effect.low < 0.01 * LITRE < effect.high


def test_each_machine_of_a_fleet_has_its_own_answer_or_why_not(tmp_path):
    machines = {"m0": lines(growing()), "m1": lines(growing(rate=0.0)), "new": lines(growing()[:3])}
    mixed = [{**line, "machine": name} for name, own in machines.items() for line in own]
    log = tmp_path / "fleet.jsonl"
    log.write_text("".join(json.dumps({"line": each["line"], **each}) + "\n" for each in mixed))
    found = hydrofdi.trend(log, limit="0.4 L/min")
    assert {name: each.has_trend for name, each in found.items()} == {"m0": True, "m1": False}
    assert "3 points" in found.without["new"]
    assert found["m0"].onset == hydrofdi.trend(machines["m0"]).onset
    told = run_json("trend", log, "--machine", "m1", "--json")
    assert told == found.to_dict()["machines"]["m1"] | {"limit": None}
    shown = run("trend", log, check=0).stdout.splitlines()
    assert [line.partition(": ")[0] for line in shown] == ["m0", "m1"]
    for arguments in (["--machine", "m2"], ["--figure", tmp_path / "trend.png"]):
        run("trend", log, *arguments, check=2)


def test_another_detector_is_a_new_beginning():
    """Whichever order the logs are given in; lines of earlier versions do not say which detector it was."""
    before, own = lines(growing() + 3.0, first=FIRST - 70 * DAY), lines(growing())
    for line in own:
        line["digest"] = "b"
    known = [{**line, "digest": "a"} for line in before]
    expected = hydrofdi.trend(own).onset
    for history in ([*known, *own], [*own, *known]):
        found = hydrofdi.trend(history)
        assert found.onset == expected
        assert "360 windows of another detector" in found.remarks[0]
    assert hydrofdi.trend([*before, *own]).points.n_score.sum() == 720


@pytest.mark.parametrize("damage", [
    b'{"line": "window", "number": 3, "sta\n', b"\xff\x00\xfe\n", b'["line"]\n', b"[" * 100_000 + b"\n",
    b'{"line": "window", "end": NaN, "score": 1.0, "unit": "m^3/s"}\n', b'{"line": "window"}\n', b"\n",
    b'{"line": "window", "end": "soon", "score": 1.0, "unit": "m^3/s"}\n',
])  # fmt: skip
def test_damaged_lines_are_left_out_and_counted(log, tmp_path, damage):
    path = tmp_path / "damaged.jsonl"
    text = log.read_bytes().splitlines(keepends=True)
    path.write_bytes(damage + b"".join(text[:100]) + damage + b"".join(text[100:]))
    found = hydrofdi.trend(path)
    assert found.onset == hydrofdi.trend(log).onset
    assert "2 damaged lines" in found.remarks[0]
    assert f"{path}:1" in found.remarks[0]


def test_rotated_logs_are_one_repeated_lines_count_once_and_an_outlier_or_a_begin_changes_no_onset(
    log, tmp_path
):
    text = log.read_text().splitlines(keepends=True)
    (tmp_path / "a").write_text("".join(text[:200]))
    (tmp_path / "b").write_text("".join(text[180:]) + text[-1][:20])
    whole, parts = hydrofdi.trend(log), hydrofdi.trend([tmp_path / "b", tmp_path / "a"])
    assert parts.onset == whole.onset
    assert parts.points.n_score.sum() == whole.points.n_score.sum()
    undated = lines(growing(), first=0.0)
    assert hydrofdi.trend(undated).to_dict()["onset"]["value"]["date"] is None
    assert hydrofdi.trend(undated, begin="2026-01-01T00:00Z").onset == whole.onset
    levels = growing()
    levels[20] += 1.0
    assert np.flatnonzero(~hydrofdi.trend(lines(levels)).points.is_used).tolist() == [20]


@pytest.mark.parametrize(("arguments", "error", "named"), [
    ({"limit": "3 bar"}, ConfigError, "limit"), ({"every": "0 s"}, ConfigError, "every"),
    ({"begin": "2026-01-01"}, ConfigError, "begin"), ({"indicator": "dwt"}, ConfigError, "indicator"),
    ({"false_alarm_rate": "0.01 %"}, ConfigError, "false_alarm_rate"),
    ({"every": "20 days"}, DataError, "points of 20 days"),
])  # fmt: skip
def test_what_cannot_be_used_is_named(arguments, error, named):
    with pytest.raises(error, match=named):
        hydrofdi.trend(lines(growing()), **arguments)


def test_lines_of_another_unit_and_a_clock_that_starts_again_are_refused():
    undated, history = lines(growing(), first=0.0), lines(growing())
    history[41] |= {"unit": "Pa"}
    for wrong, named in ((history, "window 40"), ([*undated, *undated], "window 0")):
        with pytest.raises(DataError, match=named):
            hydrofdi.trend(wrong)


@pytest.fixture(scope="module")
def worn(tmp_path_factory):
    """A minute of a machine, from the middle of which on K_i grows to 0.3 L/min, as text."""
    settings = {
        "record.duration": "60 s", "pressure_1_sensor.noise": "20 kPa", "pressure_2_sensor.noise": "20 kPa",
        "leakage.internal_flow": "0.3 L/min", "leakage.onset": "ramp", "leakage.onset_time": "30 s",
        "leakage.onset_duration": "30 s",
    }  # fmt: skip
    stated = [f"--set={setting}" for setting in settings_of(settings)]
    played = run("replay", "motions/closed-loop", "--record", "1", "--rate", "max", *stated, check=0)
    path = tmp_path_factory.mktemp("worn") / "worn.csv"
    path.write_text(played.stdout)
    return path


def test_a_monitor_writes_all_that_a_trend_needs(worn, tmp_path):
    healthy, detector, log = (tmp_path / name for name in ("healthy.csv", "detector.json", "worn.jsonl"))
    text = worn.read_text().splitlines(keepends=True)
    healthy.write_text("".join(text[: len(text) // 2]))
    run(
        "train", healthy, "--indicator", "flow_balance", "--window", "1.5 s", "--false-alarm-rate", "10 %",
        "--out", detector, check=0,
    )  # fmt: skip
    run("monitor", detector, worn, "--no-follow", "--log", log, check=0)
    found = hydrofdi.trend(log, every="1.5 s", limit="0.1 L/min")
    assert found.onset.low - 1.5 < 30.0 < found.onset.high + 1.5
    assert found.reached.low < 60.0
    raised = next(line for line in map(json.loads, log.read_text().splitlines()) if "details" in line)
    assert raised["event"] == "alarm_raised"
    details = raised["details"]
    judged = (line for line in map(json.loads, log.read_text().splitlines()) if line.get("alarm") is not None)
    before = [line["alarm"] for line in judged if line["end"] <= raised["time"]]
    assert (details["windows_judged"], details["alarms"]) == (len(before), sum(before))
    assert details["false_alarms_expected"] == pytest.approx(0.1 * details["windows_judged"])
    assert details["flow_L_per_min"] > 0.0
    assert details["recommendation"] in raised["text"]


def test_records_with_dates_in_their_names_have_a_trend(worn, tmp_path, monkeypatch):
    header, *rows = worn.read_text().splitlines(keepends=True)
    n_each = len(rows) // 30
    for record in range(30):
        date = datetime.fromtimestamp(FIRST, UTC) + timedelta(days=record)
        part = rows[record * n_each : (record + 1) * n_each]
        (tmp_path / f"press {date:%Y-%m-%d}.csv").write_text(header + "".join(part))
    description = tmp_path / "press.yaml"
    description.write_text('files: "press *.csv"\npath: "press {date}.csv"\n')
    monkeypatch.setattr("hydrofdi.api.diagnosis.measure", None)  # before anything is measured
    with pytest.raises(DataError, match="has no date"):
        hydrofdi.trend(description)
    description.write_text(description.read_text() + 'date: "{date}"\n')
    for key, value in {"limit": "3 bar", "begin": "2026-01-31T12:00Z"}.items():
        with pytest.raises(ConfigError, match=key):
            hydrofdi.trend(description, **{key: value})
    monkeypatch.undo()
    found = hydrofdi.trend(description)
    assert found.history.meaning == "flow_balance.leakage"
    assert found.onset.low < FIRST + 15 * DAY < found.onset.high + DAY
    assert found.level_now.low > found.level_before.high
    options = tmp_path / "own.yaml"
    options.write_text("indicators: {own: {kind: flow_balance, spool: command, reference_pressure: 2 MPa}}\n")
    scaled = hydrofdi.trend(description, indicator=options)
    # A leak as that of K_i at a quarter of the pressure.
    assert scaled.level_now.value == pytest.approx(found.level_now.value / 2.0, rel=0.05)
    with pytest.raises(ConfigError, match="indicator"):
        hydrofdi.trend(description, indicator="dwt,vtnsi")


@pytest.mark.parametrize("form", ["%Y-%m-%dT%H:%M:%S.%fZ", "%d.%m.%Y %H:%M:%S,%f"])
def test_records_with_a_column_of_dates_have_a_trend_unless_they_are_too_few(tmp_path, form, monkeypatch):
    random = np.random.default_rng(6)
    for day in range(14):
        if day == 3:
            monkeypatch.setattr("hydrofdi.api.diagnosis.measure", None)  # before anything is measured
            with pytest.raises(DataError, match="12"):
                hydrofdi.trend(tmp_path, indicator="dwt", output="d2")
            monkeypatch.undo()
        first = datetime.fromtimestamp(FIRST, UTC) + timedelta(days=day)
        stamps = [f"{first + timedelta(milliseconds=n):{form}}" for n in range(500)]
        level = 60.0 + random.standard_normal(500) * (1.0 + day)
        rows = (f"{at};{bar:.3f}" for at, bar in zip(stamps, level, strict=True))
        (tmp_path / f"q{day:02}.csv").write_text("Zeit;P1 [bar]\n" + "\n".join(rows) + "\n")
    found = hydrofdi.trend(tmp_path, indicator="dwt", output="d2")
    assert found.points.time == pytest.approx(FIRST + DAY * np.arange(14.0))
