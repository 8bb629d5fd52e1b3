"""Detector files are read strictly: they load, or a line says which key is wrong; nothing else happens."""

import json
import os

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hydrofdi.detectors.configuration import DetectorConfig
from hydrofdi.detectors.detector import Detector
from hydrofdi.detectors.file import detector_text, is_detector, load_detector
from hydrofdi.errors import ConfigError
from tests.detectors.trained.healthy import Records

MISTAKES = [
    ("version", 1), ("version", True), ("indicator_versions", {}), ("config.indicator", "pressure_statistic"),
    ("config.options.channel", "chamber_3_pressure"), ("config.options.levels", 3),
    ("config.output", "means"), ("config.direction", None), ("config.window.duration", 1e308),
    ("config.window.every", 1e-308), ("config.chart.chart", "cusm"), ("config.chart.options.weight", 7),
    ("limits.high", "1e5"), ("limits.high", None), ("limits.high", -1e7), ("limits.low", 1e7),
    ("limits.interval", [0.5, 0.1]), ("limits.interval_rests_on", "faith"), ("limits.confidence", -1),
    ("limits.false_alarm_rate", 1e308), ("healthy.spread", 0), ("sampling_frequency", 10**400),
    ("n_sample", True), ("channels", []), ("ranges.chamber_1_pressure.low", [2, 1]),
    ("ranges.chamber_1_pressure.at_end", -1), ("ranges.chamber_9_pressure", {}), ("chart", None),
    ("chart.limit", 0), ("basis.n_windows", 1), ("basis.n_record", -1), ("basis.sources", []),
    ("made", "today"), ("config.window.duration", 2.0, "n_sample"),
    ("config.direction", "falling", "limits.high"),
]  # fmt: skip

SCORE = {
    "indicator": "pressure_statistics", "output": "mean", "false_alarm_rate": 0.1, "direction": "both",
    "window": {"duration": 1.0},
}  # fmt: skip
CHART = {"chart": "ewma", "false_alarm_every": 20.0}


def trained(**more):
    config = DetectorConfig.model_validate(SCORE | {"chart": CHART} | more)
    records = Records(np.random.default_rng(1).standard_normal((30, 4)))
    file = Detector.fit(records, config, command="hydrofdi train [1,  2]").file
    return file.model_copy(update={"made": file.made.model_copy(update={"time": "2026-01-01"})})


@pytest.fixture(scope="module")
def file():
    return trained()


@pytest.fixture(scope="module")
def record(file):
    return json.loads(detector_text(file))


@pytest.fixture
def load(tmp_path):
    place = tmp_path / "detector.json"

    def read(content):
        text = content if isinstance(content, str | bytes) else json.dumps(content)
        place.write_bytes(text if isinstance(text, bytes) else text.encode())
        return load_detector(place)

    return read


def places(value, path=()):
    yield path
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, part in items:
        yield from places(part, (*path, key))


def changed(record, path, value):
    if not path:
        return value
    copy = json.loads(json.dumps(record))
    part = copy
    for key in path[:-1]:
        part = part[key]
    part[path[-1]] = value
    return copy


def test_a_detector_comes_back_as_it_was_written_and_the_same_records_give_the_same_bytes(file, load):
    assert load(detector_text(file)) == file
    assert detector_text(trained()) == detector_text(file)
    with pytest.raises(ConfigError):
        load(detector_text(file) + " " * 2**24)  # a file of more than 16 MB is not read


@pytest.mark.parametrize("mistake", MISTAKES)
def test_the_key_that_is_wrong_is_named(record, load, mistake):
    path, value, *key = mistake
    with pytest.raises(ConfigError, match=rf"detector\.json: {(key or [path])[0]}: "):
        load(changed(record, path.split("."), value))


@pytest.mark.parametrize(
    "text",
    ["", "[" * 100_000, '{"schema": "hydrofdi.detector", "schema": 1}', '{"limit": NaN}', '{"limit": 1e999}',
     f'{{"limit": {"9" * 5000}}}', b"\xff\xfe{}", "[1]"],
)  # fmt: skip
def test_what_is_no_detector_is_refused_in_one_line(load, text):
    with pytest.raises(ConfigError, match=r"^.*detector\.json: .*") as error:
        load(text)
    assert len(str(error.value).splitlines()) == 1


SCORED = {
    "indicator": "", "output": "", "indicators": {"p": {"kind": "pressure_statistics"}}, "chart": None,
    "score": {"kind": "mahalanobis", "of": ["p.mean", "p.kurtosis"]}, "direction": "rising",
}  # fmt: skip
WHITE = "score.rule.white"
MISTAKES_OF_SCORES = [
    ("score", None), ("score.rule", {}), ("score.numbers", []), ("score.numbers", ["p.mean", "p.median"]),
    (f"{WHITE}.mean", [0.0, 1.0, 2.0], WHITE), (f"{WHITE}.matrix", [[0.0, "x"]]),
    (f"{WHITE}.standardised.kept", [7], "score.rule"),
    (f"{WHITE}.standardised.scale", [-1.0], f"{WHITE}.standardised"),
    ("config.score.kind", "lda", "score.rule"), ("config.score.of", ["p.men"], "config.score"),
    ("config.score.options", {"shrinkage": 2}, "config.score.options.shrinkage"),
    ("indicator_versions.p", 99, "indicator_versions"),
]  # fmt: skip


def test_what_a_score_learned_is_read_strictly(load):
    file = trained(**SCORED)
    assert load(detector_text(file)) == file
    assert (file.score.n_healthy, file.score.n_faulty) == (120, 0)
    for path, value, *key in MISTAKES_OF_SCORES:
        with pytest.raises(ConfigError, match=rf"detector\.json: {(key or [path])[0]}: "):
            load(changed(json.loads(detector_text(file)), path.split("."), value))


numbers = st.integers() | st.floats(allow_nan=False, allow_infinity=False)
anything = st.recursive(
    st.none() | st.booleans() | numbers | st.text(max_size=12),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=6), inner, max_size=3),
    max_leaves=6,
)


@settings(max_examples=200)
@given(data=st.data())
def test_changed_and_damaged_files_load_or_are_refused(record, file, tmp_path_factory, data):
    place = tmp_path_factory.getbasetemp() / "changed.json"
    if data.draw(st.booleans()):
        content = record
        for _ in range(data.draw(st.integers(1, 3))):
            content = changed(content, data.draw(st.sampled_from(list(places(content)))), data.draw(anything))
        place.write_text(json.dumps(content), encoding="utf-8")
    else:
        text = detector_text(file).encode()
        first = data.draw(st.integers(0, len(text)))
        stop = data.draw(st.integers(first, min(len(text), first + 40)))
        place.write_bytes(text[:first] + data.draw(st.binary(max_size=20)) + text[stop:])
    before, refusal = set(os.listdir(place.parent)), ""
    try:
        loaded = load_detector(place)
    except ConfigError as error:
        refusal = str(error)
    assert all(line.startswith(f"{place}: ") for line in refusal.splitlines())
    assert refusal or json.loads(detector_text(loaded))["schema"] == "hydrofdi.detector"
    assert set(os.listdir(place.parent)) == before


def test_what_is_no_file_is_no_detector(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "absent", tmp_path, tmp_path / "pipe"):
        with pytest.raises(ConfigError):
            load_detector(path)
    assert not is_detector(tmp_path / "pipe")
