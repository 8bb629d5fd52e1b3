"""``hydrofdi inspect`` and ``hydrofdi indicators``."""

import h5py
import matplotlib.image
import numpy as np
import pytest

from hydrofdi.indicators import indicator_kind, indicator_names
from hydrofdi.records import Channel
from tests.cli.test_measure import FAILING, MUSEUM
from tests.commands import run, run_json
from tests.conftest import sweep_in


def test_ranges_are_those_of_the_stored_signals(small_sweep):
    found = run_json("inspect", small_sweep.directory)
    assert (found["records"], found["rejected"]) == (4, 0)
    assert found["sampling_frequencies_Hz"] == [{"frequency": 500.0, "records": 4, "is": "given"}]
    assert found["samples"] == [{"samples": 1000, "records": 4}]
    assert found["drive_periods_s"] == [{"period": 2.0, "records": 4}]
    with h5py.File(small_sweep.file) as file:
        for name in ("chamber_1_pressure", "piston_position"):
            samples, channel = file[name][:], found["channels"][name]
            assert (channel["min"], channel["max"]) == (samples.min(), samples.max())
            assert channel["mean"] == pytest.approx(samples.mean(), rel=1e-12)
    assert found["channels"]["supply_pressure"]["unit"] == "Pa"
    assert len(found["labels"]) == 4


def test_rejected_records_are_counted_with_their_reason(tmp_path):
    swept = sweep_in(tmp_path, FAILING)
    found = run_json("inspect", swept.directory, check=1)
    assert (found["records"], found["rejected"]) == (2, 1)
    diverged = found["findings"]["diverged"]
    assert diverged["rejects"]
    assert diverged["records"] == 1
    (example,) = diverged["examples"]
    assert "grew without bound" in example["text"]
    text = run("inspect", swept.directory, check=1).stdout
    assert "2, and 1 rejected" in text
    assert "diverged (rejected)" in text
    refused = run("inspect", swept.directory, "--record", example["record_id"], check=2)
    assert "is rejected: the state grew" in refused.stderr


def test_defects_of_a_plain_file_are_named(tmp_path):
    pressure = np.clip(50 + 20 * np.random.default_rng(1).normal(size=600), 40, 1000)
    lines = [f"{value:.6g},2.5" for value in pressure.tolist()]
    (tmp_path / "rig.csv").write_text("p1 [bar],u [V]\n" + "\n".join(lines) + "\n")
    found = run_json("inspect", tmp_path / "rig.csv", "--sampling-frequency", "200 Hz")
    assert {"clipped", "stuck"} <= found["findings"].keys()
    assert "input_voltage" in found["findings"]["stuck"]["examples"][0]["text"]
    assert found["channels"]["chamber_1_pressure"]["min"] == pytest.approx(40e5)
    text = run("inspect", tmp_path / "rig.csv", "--sampling-frequency", "200 Hz", check=0).stdout
    assert "200 Hz" in text
    assert "never changes" in text


@pytest.mark.parametrize("name", ["record.png", "record.svg"])
def test_a_figure_of_the_record_that_is_asked_for(tmp_path, name):
    file = MUSEUM / "pressures.h5"
    last = run_json("measure", file)["records"][-1]["record_id"]
    first, chosen = tmp_path / f"first_{name}", tmp_path / name
    run("inspect", file, "--figure", first, check=0)
    done = run("inspect", file, "--record", last[:6], "--figure", chosen, check=0)
    assert f"drew {chosen}" in done.stderr
    assert first.read_bytes() != chosen.read_bytes()
    if name.endswith("png"):
        picture = matplotlib.image.imread(chosen)[..., :3]
        assert (picture.min(axis=2) < 0.5).mean() > 0.005


def test_a_record_too_short_for_details_is_drawn_all_the_same(tmp_path):
    (tmp_path / "rig.csv").write_text("p1 [bar]\n1\n2\n4\n3\n5\n")
    run(
        "inspect", tmp_path / "rig.csv", "--sampling-frequency", "10 Hz", "--figure", tmp_path / "f.png",
        check=0,
    )  # fmt: skip
    assert (tmp_path / "f.png").stat().st_size > 5_000


def test_every_indicator_is_listed_and_described():
    listed = run_json("indicators")["indicators"]
    assert [indicator["name"] for indicator in listed] == indicator_names()
    text = run("indicators", check=0).stdout
    for indicator in listed:
        name = indicator["name"]
        assert name in text
        assert run_json("indicators", name) == indicator
        kind = indicator_kind(name)
        assert {option["name"] for option in indicator["options"]} == kind.Options.model_fields.keys()
        assert all(option["text"] for option in indicator["options"]), name
        assert [output["name"] for output in indicator["outputs"]] == [o.name for o in kind().outputs]
        described = " ".join(run("indicators", name, check=0).stdout.split())
        assert " ".join(kind.summary.split()) in described


def test_the_symbols_of_the_list_are_those_that_plain_files_use(tmp_path):
    header = ",".join(f"{channel.symbol} [{channel.unit}]" for channel in Channel)
    lines = [",".join(f"{row}.{column}" for column in range(len(Channel))) for row in range(9)]
    (tmp_path / "rig.csv").write_text("\n".join([header, *lines]) + "\n")
    found = run_json("inspect", tmp_path / "rig.csv", "--sampling-frequency", "1kHz")["channels"]
    assert [found[channel]["min"] for channel in Channel] == [float(f"0.{n}") for n in range(len(Channel))]
