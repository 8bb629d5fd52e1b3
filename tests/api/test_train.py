"""`hydrofdi.train` and `hydrofdi.evaluate`: what the commands say, from files and from memory."""

import json
from dataclasses import replace

import numpy as np
import pandas
import pytest
import xarray

import hydrofdi
from hydrofdi.errors import ConfigError, ReportError
from tests.commands import run, run_json

RATE = 1000.0
WANTED = {"output": "d2", "direction": "both", "false_alarm_rate": 0.2}


def noisy(n_record, scale=1e4, seed=1):
    return 5e6 + scale * np.random.default_rng(seed).standard_normal((n_record, 1000))


HEALTHY, LEAKING = noisy(30), noisy(40, 3e4, 2)


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """The same records as files with a description."""
    folder = tmp_path_factory.mktemp("rig")
    for label, records in (("sound", HEALTHY), ("leaking", LEAKING)):
        for number, samples in enumerate(records):
            text = "".join(f"{value!r}\n" for value in samples.tolist())
            (folder / f"{label}_{number:02}.csv").write_text(f"P1 [Pa]\n{text}")
    description = {
        "files": "*.csv", "sampling_frequency": "1 kHz", "path": "{label}_{number}.csv", "label": "{label}",
        "channels": {"chamber_1_pressure": {"column": "P1 [Pa]"}},
    }  # fmt: skip
    (folder / "rig.yaml").write_text(json.dumps(description))
    return folder / "rig.yaml"


LABELS = ["sound"] * 30 + ["leaking"] * 40
BOTH = np.vstack([HEALTHY, LEAKING])


def promise(detector):
    file = detector.file
    return file.limits, file.healthy, file.ranges, file.basis.n_window


def test_records_in_memory_teach_what_the_command_learns_from_files(files, tmp_path):
    options = ("--output", "d2", "--direction", "both", "--false-alarm-rate", "20 %", "--healthy", "sound")
    run("train", files, *options, "--out", tmp_path / "detector.json", check=0)
    told = promise(hydrofdi.Detector.load(tmp_path / "detector.json"))
    labelled = xarray.DataArray(
        BOTH, {"label": ("record", LABELS)}, ("record", "time"), "P1", {"units": "Pa"}
    )
    frames = [pandas.DataFrame({"P1 [Pa]": samples}) for samples in BOTH]
    for given in (
        {"data": files, "healthy": "sound"},
        {"data": BOTH, "label": LABELS, "healthy": ["sound"], "sampling_frequency": "1 kHz"},
        {"data": frames, "label": LABELS, "healthy": "sound", "sampling_frequency": RATE},
        {"data": labelled, "healthy": "sound", "sampling_frequency": RATE},
        {"data": HEALTHY, "sampling_frequency": RATE},
    ):
        assert promise(hydrofdi.train(**given, **WANTED)) == told


def test_settings_come_from_a_mapping_a_file_or_keywords(tmp_path):
    config = {"indicator": "dwt", "options": {"name": "db4"}, **WANTED, "window": {"duration": "0.5 s"}}
    (file := tmp_path / "wanted.yaml").write_text(json.dumps(config))
    keywords = {**WANTED, "window": "0.5 s", "sampling_frequency": RATE}
    expected = promise(hydrofdi.train(HEALTHY, "dwt", options={"name": "db4"}, **keywords))
    assert expected != promise(hydrofdi.train(HEALTHY, "dwt", **keywords))
    for given in (config, file, str(file), {"dwt": {"name": "db4"}}, {"own": {"kind": "dwt", "name": "db4"}}):
        more = {"sampling_frequency": RATE} if given in (config, file, str(file)) else keywords
        assert promise(hydrofdi.train(HEALTHY, given, **more)) == expected
    chosen = {"indicators": {"dwt": {"name": "db4"}}}
    assert promise(hydrofdi.train(HEALTHY, config=chosen, **keywords)) == expected
    assert hydrofdi.train(HEALTHY, config=config, window=0.48, sampling_frequency=RATE).file.n_sample == 480


def test_an_evaluation_in_memory_is_that_of_the_command(files):
    told = run_json("evaluate", files, "--healthy", "sound", "--false-alarm-rate", "20 %")
    given = {"healthy": "sound", "false_alarm_rate": 0.2}
    assert hydrofdi.evaluate(files, **given).to_dict() == told
    made = hydrofdi.evaluate(BOTH, label=LABELS, sampling_frequency=RATE, **given)
    frame = made.to_pandas()
    found = frame[(frame.indicator == made.best) & (frame.population == "leaking")].iloc[0]
    assert (found.alarms, found.n, found.auc) == (40, 40, 1.0)
    assert found.low < found.rate == 1.0
    assert made.best in made._repr_html_()
    with pytest.raises(hydrofdi.HydrofdiError, match="label: state the condition of each record"):
        hydrofdi.evaluate(BOTH, sampling_frequency=RATE)


def test_a_score_of_several_numbers_learns_from_labelled_faulty_records_too(files, tmp_path):
    held = {"label": LABELS, "healthy": "sound", "sampling_frequency": "1 kHz"}
    config = {"indicators": ["dwt"], "score": {"kind": "lda", "of": ["dwt.d1", "dwt.d2", "dwt.a3"]}}
    with pytest.raises(ConfigError, match=r"^indicator: "):
        hydrofdi.train(files, config=config | {"indicator": "modwt"})
    detector = hydrofdi.train(BOTH, config=config, false_alarm_rate=0.2, **held)
    assert (detector.file.score.n_healthy, detector.file.score.n_faulty) == (30, 40)
    assert detector.left_out.n_leaking == 0
    verdicts = detector.judge(noisy(20, 1.05e4, 3), sampling_frequency="1 kHz")
    assert verdicts["fault"].tolist() == [""] * 20
    (tmp_path / "lda.yaml").write_text(json.dumps(config))
    options = ("--config", tmp_path / "lda.yaml", "--false-alarm-rate", "20 %", "--healthy", "sound")
    run("train", files, *options, "--out", tmp_path / "detector.json", check=0)
    same = hydrofdi.Detector.load(tmp_path / "detector.json")
    assert (same.file.limits, same.file.score) == (detector.file.limits, detector.file.score)
    watched = detector.watch(noisy(3, 1.05e4, 3).reshape(30, 100))
    lines = [each for each in watched if each["line"] == "window"]
    assert [line["score"] for line in lines] == verdicts["score"][:3].tolist()
    with pytest.raises(hydrofdi.HydrofdiError):
        hydrofdi.train(HEALTHY, config=config, sampling_frequency="1 kHz", false_alarm_rate=0.2)
    for wrong in (
        {"score": {"kind": "lda", "of": ["dwt.d9"]}},
        {"score": {"kind": "mahalanobis", "of": ["dwt"], "shrinkage": 2}},
        {**config, "output": "d2"},
        {"score": {"kind": "mahalanobis", "of": ["dwt"]}, "direction": "falling"},
        {"score": {"kind": "compensated", "of": ["dwt"], "by": ["dwt.d1"]}, "direction": "both"},
    ):
        with pytest.raises(hydrofdi.HydrofdiError):
            hydrofdi.train(BOTH, config=wrong, **held)


@pytest.mark.parametrize("n_healthy", [100, 4], ids=["with limits", "too few for limits"])
def test_the_scores_are_drawn_with_limits_if_there_are_any(n_healthy):
    records, label = np.vstack([noisy(n_healthy), noisy(10, 1.5e4, 2)]), ["sound"] * n_healthy + ["worn"] * 10
    given = {"healthy": "sound", "false_alarm_rate": "5 %", "sampling_frequency": "1 kHz"}
    found = hydrofdi.evaluate(records, "dwt", label=label, **given)
    has_limits = any(each.threshold is not None for each in found.detection.judgements)
    assert has_limits == (n_healthy == 100)
    figure = found.plot()
    rows = [text.get_text() for text in figure.axes[0].get_yticklabels()]
    assert rows == ["healthy (fit)", "healthy", "worn"]
    assert any(axis.lines for axis in figure.axes) == has_limits
    assert not has_limits or found.plot("roc").axes
    with pytest.raises(ReportError, match="densities"):
        found.plot("density")
    empty = replace(found, detection=replace(found.detection, judgements=()))
    assert (len(empty.table), len(empty.pairs), empty.best) == (0, 0, "")
