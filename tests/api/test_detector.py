"""`hydrofdi.Detector`: the rows and the lines of the commands, from files and from memory."""

import doctest
import inspect
import json
import os
from importlib import import_module

import numpy as np
import pandas
import pytest

import hydrofdi
from tests.commands import run
from tests.conftest import REPOSITORY
from tests.detectors.trained.made import FREQUENCY, noise_detector, pressure, written

CONFIG = {"output": "d2", "direction": "rising", "window": {"duration": 1.0, "every": 0.5}}


@pytest.fixture(scope="module")
def trained(tmp_path_factory):
    return noise_detector(tmp_path_factory.mktemp("detector"), **CONFIG)


@pytest.fixture(scope="module")
def samples():
    """P1 of five seconds; in the third the noise is threefold."""
    return pressure(leaking=[2])


def test_an_array_gives_the_rows_of_the_command_on_a_file(trained, samples, tmp_path):
    file = written(tmp_path / "rig.csv", samples)
    told = json.loads(run("detect", trained, file, "--json").stdout)["windows"]
    loaded = hydrofdi.Detector.load(str(trained))
    for table in (
        loaded.judge(file),
        loaded.judge(samples, sampling_frequency=FREQUENCY),
        hydrofdi.detect(trained, samples, sampling_frequency=FREQUENCY),
    ):
        assert table["alarm"].tolist() == [each["alarm"] for each in told]
        assert any(table["alarm"].tolist())
        np.testing.assert_allclose(table["score"].astype(float), [each["score"] for each in told], rtol=1e-9)
        np.testing.assert_allclose(table["start"].astype(float), [each["start"] for each in told], atol=1e-9)
    assert table.units["score"] == "Pa"


def test_a_stream_in_chunks_of_any_size_gives_the_lines_of_the_monitor(trained, samples, tmp_path):
    file = written(tmp_path / "rig.csv", samples)
    loaded, lines = hydrofdi.Detector.load(trained), []
    assert loaded.monitor(file, follow=False, on_line=lines.append) == "the stream is over"
    told = run("monitor", trained, file, "--no-follow", "--json", check=0).stdout
    assert [json.loads(line) for line in told.splitlines()] == lines
    windows = [line for line in lines if line["line"] == "window"]
    dates = pandas.date_range("2026-01-31T12:00Z", periods=samples.size, freq="1ms")
    frame, noon = pandas.DataFrame({"P1 [bar]": samples / 1e5}, index=dates), dates[0].timestamp()
    for data, n_chunk, n_sample, begin in (
        (samples, 1, 3000, 0.0), (samples, 1999, 5000, 0.0), (frame, 300, 5000, noon),
    ):  # fmt: skip
        chunks = (data[first : first + n_chunk] for first in range(0, n_sample, n_chunk))
        found = [line for line in loaded.watch(chunks) if line["line"] == "window"]
        assert len(found) == n_sample // 500 - 1
        for line, other in zip(found, windows, strict=False):
            assert (line["number"], line["alarm"]) == (other["number"], other["alarm"])
            assert line["start"] - begin == pytest.approx(other["start"], rel=1e-9, abs=1e-5 * (begin > 0.0))
            assert line["score"] == pytest.approx(other["score"], rel=1e-9)


PUBLIC = [getattr(hydrofdi, name) for name in hydrofdi.__all__]
MODULES = sorted({
    each.__module__ for each in PUBLIC
    if ">>>" in (inspect.getdoc(each) or "")
    and each.__module__.startswith(("hydrofdi.api", "hydrofdi.execution"))
})  # fmt: skip


@pytest.mark.parametrize("name", ["hydrofdi", *MODULES, "docs/python.md"])
def test_the_examples_of_docstrings_and_of_the_page_run(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    os.symlink(REPOSITORY / "configs", "configs")
    if name.endswith(".md"):
        page = {"module_relative": False, "encoding": "utf-8"}
        outcome = doctest.testfile(str(REPOSITORY / name), optionflags=doctest.ELLIPSIS, **page)
    else:
        outcome = doctest.testmod(import_module(name), optionflags=doctest.ELLIPSIS)
    assert outcome.attempted > 5 * name.endswith(".md")
    assert outcome.failed == 0


def test_a_state_or_a_chunk_of_another_kind_is_refused(trained, samples):
    detector = hydrofdi.Detector.load(trained)
    chunk = next(hydrofdi.replay(samples, sampling_frequency=FREQUENCY))
    for call in (
        lambda: detector.step(detector.start(), samples),
        lambda: detector.step({}, chunk),
        lambda: detector.end(None),
        lambda: detector.score(samples),
        lambda: hydrofdi.Detector.fit(samples, CONFIG),
    ):
        with pytest.raises(hydrofdi.HydrofdiError):
            call()
