"""Values that contradict each other, or themselves: reported as mistakes by the command itself."""

import pytest


@pytest.mark.parametrize(
    ("settings", "key"),
    [
        (["leakage.onset_duty=1.5"], "leakage.onset_duty"),
        (["actuator.end_stops=elastic", "actuator.end_stop_position=0.5"], "end_stop_position"),
        (["fluid.vapour_pressure=9 MPa"], "fluid.vapour_pressure"),
        (
            ["sweep.grid.supply.pressure=[17 MPa, 1 MPa]", "fluid.vapour_pressure=0.8 MPa"],
            "supply.pressure",
        ),
        (["analysis.discard=-1 period"], "analysis.discard"),
        (["pressure_1_sensor={lowest: 10 MPa, highest: 0}"], "pressure_1_sensor"),
    ],
)
def test_a_contradiction_is_one_line(hydrofdi, experiment_file, settings, key):
    config = experiment_file("record: {duration: 2 s}\n")
    options = [part for setting in settings for part in ("--set", setting)]
    command = "plan" if "sweep" in settings[0] else "simulate"
    result = hydrofdi(command, config, *options)
    assert (result.returncode, len(result.stderr.splitlines())) == (2, 1)
    assert key in result.stderr


def test_what_is_off_contradicts_nothing(hydrofdi):
    result = hydrofdi("simulate", "--set", "record.duration=2 s", "--set", "actuator.end_stop_position=0.5")
    assert result.returncode == 0


@pytest.mark.parametrize(
    "settings",
    [
        ["input.shape=sweep", "input.end_frequency=60"],
        ["input.shape=multisine", "input.harmonics=120"],
        ["measurement.anti_alias=60 Hz"],
    ],
)
def test_what_is_too_fast_for_the_sampling_is_reported(hydrofdi, settings):
    settings = ["record.duration=4 s", "wavelet.levels=3", "record.sampling_frequency=100", *settings]
    options = [part for setting in settings for part in ("--set", setting)]
    assert f"{settings[-1].partition('=')[0]} = " in hydrofdi("check", *options).stdout
