"""``hydrofdi detect``: a row for each window, those of a monitor, and exit codes that scripts can use."""

import csv
import io
import json

import numpy as np
import pytest

from hydrofdi.detectors.detector import Detector
from hydrofdi.detectors.file import detector_text, load_detector
from hydrofdi.detectors.lines import WindowLine, line_record
from hydrofdi.records import Channel
from hydrofdi.records.streams import Chunk
from tests.commands import run_hydrofdi
from tests.detectors.trained.made import FREQUENCY, noise_detector, pressure, with_chart, written


@pytest.fixture(scope="module")
def trained(tmp_path_factory):
    window = {"duration": 1.0, "every": 0.5}
    return noise_detector(tmp_path_factory.mktemp("detector"), output="d2", direction="rising", window=window)


def detected(trained, *sources):
    ended = run_hydrofdi("detect", trained, *sources, "--json")
    return ended, json.loads(ended.stdout)


def test_rows_are_those_of_a_monitor_on_the_same_stream(trained, tmp_path):
    samples = pressure(12, leaking=[7])
    samples[3000:3005] = np.nan
    ended, found = detected(trained, written(tmp_path / "long.csv", samples))
    watch, lines = Detector(load_detector(trained)), []
    state = watch.start()
    for first in range(0, samples.size, 777):
        part = slice(first, first + 777)
        time = np.arange(samples.size)[part] / FREQUENCY
        state, more = watch.step(state, Chunk(time, {Channel.CHAMBER_1_PRESSURE: samples[part]}))
        lines += [line_record(line, "Pa") for line in more if isinstance(line, WindowLine)]
    rows = [{key: row[key] for key in lines[0]} for row in found["windows"]]
    assert rows == lines
    assert len(rows) == 23
    assert [row["number"] for row in rows if row["alarm"]] == [13, 14, 15]
    assert {row["fault"]["kind"] for row in rows if row["fault"]} == {"missing"}
    assert ended.returncode == 0


def test_the_summary_counts_what_the_rows_say_and_more_records_never_lose_the_interval(trained, tmp_path):
    files = [written(tmp_path / f"{n}.csv", pressure(4, n, [2] if n == 1 else [])) for n in range(5)]
    found = [detected(trained, *files[:count]) for count in (1, 2, 4, 5)]
    summary, rows = found[-1][1]["summary"], found[-1][1]["windows"]
    assert (summary["n_record"], summary["n_judged"], len(rows)) == (5, 35, 35)
    assert summary["n_alarm"] == sum(row["alarm"] for row in rows) == 3
    assert summary["hours"] == pytest.approx(35 * 0.5 / 3600.0)
    low, high = summary["alarm_share_interval"]
    assert 0.0 <= low < 3 / 35 < high <= 1.0
    rests_on = [each["summary"]["interval_rests_on"] for _, each in found]
    assert rests_on == ["windows", "windows", "windows", "records"]
    widths = [np.ptp(each["summary"]["alarm_share_interval"]) for _, each in found]
    assert widths[2] < widths[1]
    codes = [run_hydrofdi("detect", trained, each, "--fail-on-alarm").returncode for each in files[:2]]
    assert [*codes, found[-1][0].returncode] == [0, 1, 0]


def test_windows_that_overlap_do_not_narrow_the_interval(trained, tmp_path):
    source = written(tmp_path / "long.csv", pressure(12, leaking=[7]))
    file, apart = load_detector(trained), tmp_path / "apart.json"
    window = file.config.window.model_copy(update={"every": 1.0})
    config = file.config.model_copy(update={"window": window})
    apart.write_text(detector_text(file.model_copy(update={"config": config})), encoding="utf-8")
    summaries = [detected(each, source)[1]["summary"] for each in (trained, apart)]
    assert [each["n_judged"] for each in summaries] == [23, 12]
    widths = [np.ptp(each["alarm_share_interval"]) for each in summaries]
    assert widths[0] > 0.9 * widths[1]


@pytest.mark.parametrize(("kind", "options"), [
    ("short_record", {"samples": pressure()[:900]}), ("other_rate", {"frequency": 500.0}),
    ("missing_channel", {"name": "P2 [Pa]"}),
])  # fmt: skip
def test_a_record_that_cannot_be_judged_says_why(trained, tmp_path, kind, options):
    odd = written(tmp_path / "odd.csv", **{"samples": pressure(), **options})
    ended, found = detected(trained, written(tmp_path / "healthy.csv", pressure()[:1000]), odd)
    assert ended.returncode == 1
    assert [row["record_id"] for row in found["windows"]] == ["healthy.csv", "odd.csv"]
    assert found["windows"][1]["fault"]["kind"] == kind
    assert found["summary"]["not_judged"] == {kind: 1}
    assert "no window of odd.csv was judged: " in ended.stderr


def test_late_alarms_are_in_the_table_and_all_rows_in_csv(trained, tmp_path):
    source = written(tmp_path / "long.csv", pressure(40, leaking=[38]))
    shown = run_hydrofdi("detect", trained, source).stdout
    assert (shown.count("ALARM"), shown.count("healthy")) == (3, 17)
    assert "20 of 79 rows" in shown
    table = run_hydrofdi("detect", trained, source, "--format", "csv").stdout
    rows = list(csv.DictReader(io.StringIO(table)))
    assert ({row["unit"] for row in rows}, len(rows)) == ({"Pa"}, 79)
    assert [float(row["start_s"]) for row in rows if row["alarm"] == "True"] == [37.5, 38.0, 38.5]
    assert sum(float(row["score"]) > float(row["high"]) for row in rows) == 3


def test_a_chart_decides_where_there_is_one_and_starts_anew_with_each_record(trained, tmp_path):
    charted = tmp_path / "charted.json"
    file = with_chart(load_detector(trained), limit=1e6, direction="rising")
    charted.write_text(detector_text(file), encoding="utf-8")
    sources = [written(tmp_path / name, pressure(4, leaking=[2])) for name in ("a.csv", "b.csv")]
    _, found = detected(charted, *sources)
    statistics = [row["chart"]["statistic"] for row in found["windows"]]
    assert any(row["beyond_limit"] for row in found["windows"])
    assert not any(row["alarm"] for row in found["windows"])
    assert found["summary"]["n_alarm"] == 0
    assert statistics[:7] == statistics[7:]
    assert max(statistics) > 10.0
