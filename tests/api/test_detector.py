"""`hydrofdi.Detector`: the rows of the command, from files and from memory."""

import json

import numpy as np
import pytest

import hydrofdi
from hydrofdi.detectors.trained import Judge
from hydrofdi.detectors.trained.reading import detector_text
from hydrofdi.records import Channel
from tests.commands import run
from tests.detectors.trained.made import FREQUENCY, detector, signals, window

CONFIG = {"output": "d2", "direction": "rising", "window": {"duration": 1.0, "every": 0.5}}


@pytest.fixture(scope="module")
def trained(tmp_path_factory):
    healthy = [window(number, 100 + number) for number in range(20)]
    scores = [verdict.score for verdict in Judge(detector(ranges=healthy, **CONFIG)).judge(healthy)]
    scale = (float(np.median(scores)), float(np.std(scores)))
    file = detector(limits=(None, 1.2 * max(scores)), scale=scale, ranges=healthy, **CONFIG)
    path = tmp_path_factory.mktemp("detector") / "detector.json"
    path.write_text(detector_text(file), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def pressure():
    """P1 of five seconds; in the third the noise is threefold."""
    samples = signals(1, 5000)[Channel.CHAMBER_1_PRESSURE].copy()
    samples[2000:3000] += np.random.default_rng(2).standard_normal(1000) * 3e4
    return samples


def test_an_array_gives_the_rows_of_the_command_on_a_file(trained, pressure, tmp_path):
    file = tmp_path / "rig.csv"
    rows = zip((np.arange(pressure.size) / FREQUENCY).tolist(), pressure.tolist(), strict=True)
    file.write_text("time [s],P1 [Pa]\n" + "".join(f"{time!r},{value!r}\n" for time, value in rows))
    told = json.loads(run("detect", trained, file, "--json").stdout)["windows"]
    loaded = hydrofdi.Detector.load(str(trained))
    for table in (loaded.judge(file), loaded.judge(pressure, sampling_frequency=FREQUENCY)):
        assert table["alarm"].tolist() == [each["alarm"] for each in told]
        assert any(table["alarm"].tolist())
        np.testing.assert_allclose(table["score"].astype(float), [each["score"] for each in told], rtol=1e-9)
        np.testing.assert_allclose(table["start"].astype(float), [each["start"] for each in told], atol=1e-9)
    assert table.units["score"] == "Pa"
    assert repr(loaded).startswith("dwt.d2: alarm above ")


def test_what_is_not_judged_says_why(trained, pressure):
    holed = pressure.copy()
    holed[100] = np.nan
    table = hydrofdi.Detector.load(trained).judge(holed, sampling_frequency=FREQUENCY)
    assert table["alarm"][0] is None
    assert "missing" in table["reason"][0]
    short = hydrofdi.Detector.load(trained).judge(pressure[:100], sampling_frequency=FREQUENCY)
    assert short["fault"].tolist() == ["short_record"]


def test_the_sentence_is_that_of_the_command(tmp_path):
    (tmp_path / "notes.json").write_text("{}")
    with pytest.raises(hydrofdi.HydrofdiError) as raised:
        hydrofdi.Detector.load(tmp_path / "notes.json")
    told = run("detect", tmp_path / "notes.json", "rig.csv", check=2).stderr
    assert told.strip() == f"hydrofdi: {raised.value}"
