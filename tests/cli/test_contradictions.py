"""Values that contradict each other, or themselves: reported as mistakes by the command itself."""

import pytest

CONTRADICTIONS = {
    "duty": (["leakage.onset_duty=1.5"], "leakage.onset_duty=1.5: must be at most 1; found 1.5"),
    "stop outside": (
        ["actuator.end_stops=elastic", "actuator.end_stop_position=0.5"],
        "actuator: end_stop_position = 0.5 m must be below V/A = 0.4423 m, where a chamber vanishes",
    ),
    "boiling": (
        ["fluid.vapour_pressure=9 MPa"],
        "fluid.vapour_pressure = 9 MPa must be below the 8.6 MPa at which the chambers start",
    ),
    "boiling in a sweep": (
        ["sweep.grid.supply.pressure=[17.2 MPa, 1 MPa]", "fluid.vapour_pressure=0.8 MPa"],
        "at supply.pressure = 1 MPa: fluid.vapour_pressure = 800 kPa must be below",
    ),
    "negative periods": (
        ["analysis.discard=-1 period"],
        "analysis.discard=-1 period: must be zero or more periods, such as '1 period'; found '-1 period'",
    ),
    "range": (
        ["pressure_1_sensor={lowest: 10 MPa, highest: 0}"],
        "pressure_1_sensor={lowest: 10 MPa, highest: 0}: lowest = 10 MPa must be below highest = 0 kPa",
    ),
}


@pytest.mark.parametrize(("settings", "expected"), CONTRADICTIONS.values(), ids=CONTRADICTIONS)
def test_a_contradiction_is_one_line(hydrofdi, experiment_file, settings, expected):
    config = experiment_file("record: {duration: 2 s}\n")
    options = [part for setting in settings for part in ("--set", setting)]
    command = "plan" if "sweep" in settings[0] else "simulate"
    result = hydrofdi(command, config, *options)
    assert (result.returncode, len(result.stderr.splitlines())) == (2, 1)
    assert expected in result.stderr


def test_what_is_off_contradicts_nothing(hydrofdi):
    result = hydrofdi("simulate", "--set", "record.duration=2 s", "--set", "actuator.end_stop_position=0.5")
    assert result.returncode == 0


@pytest.mark.parametrize(
    ("settings", "expected"),
    [
        (
            ["input.shape=sweep", "input.end_frequency=60", "record.sampling_frequency=100"],
            "input.end_frequency = 60 Hz is more than half of record.sampling_frequency = 100 Hz",
        ),
        (
            ["input.shape=multisine", "input.harmonics=120", "record.sampling_frequency=100"],
            "input.harmonics = 120 reach 60 Hz, more than half of record.sampling_frequency = 100 Hz",
        ),
        (
            ["measurement.anti_alias=60 Hz", "record.sampling_frequency=100"],
            "measurement.anti_alias = 60 Hz is not below half of record.sampling_frequency = 100 Hz:"
            " sampling folds what it lets pass",
        ),
    ],
)
def test_what_is_too_fast_for_the_sampling_is_reported(hydrofdi, settings, expected):
    settings = ["record.duration=4 s", "wavelet.levels=3", *settings]
    options = [part for setting in settings for part in ("--set", setting)]
    assert expected in " ".join(hydrofdi("check", *options).stdout.split())
