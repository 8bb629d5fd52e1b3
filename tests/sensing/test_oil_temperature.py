"""The oil temperature of simulated records: in files and streams, measured, and compensated by detectors."""

import h5py
import numpy as np
import yaml

import hydrofdi
from hydrofdi.api.sources import open_records
from hydrofdi.records import Channel
from tests.conftest import sweep_in
from tests.machines import RIG, sections_of

SHORT = RIG | {"record.duration": "2 s", "input.period": "0.5 s"}
WARM = {"fluid.temperature_rise": "5 K", "fluid.temperature_drift": "2 K/s"}


def experiment(values, **more):
    return yaml.safe_dump(sections_of(SHORT | values) | more, allow_unicode=True)


SWEEP = experiment(
    {
        "fluid.temperature": "45 °C", "fluid.temperature_rise": "5 K", "temperature_sensor.noise": "0.1 K",
        "temperature_sensor.bias": "0.5 K", "leakage.internal_coefficient": 0,
    },
    name="warm", sweep={"grid": {"fluid.temperature_drift": ["0 K/s", "1 K/s"]}},
    indicators={"warmth": {"kind": "pressure_statistics", "channel": "oil_temperature"}},
)  # fmt: skip


def test_record_has_the_stated_temperature_with_rise_and_drift_and_its_other_signals_keep_their_bits():
    plain, warm = (
        hydrofdi.simulate(sections_of(SHORT | WARM | {"fluid.temperature": stated}))
        for stated in (None, "45 °C")
    )
    np.testing.assert_allclose(warm["Toil"], 273.15 + 45.0 + 5.0 + 2.0 * warm.time, rtol=1e-15)
    assert warm.signals.keys() - plain.signals.keys() == {"oil_temperature", "Toil"}
    for name in plain.signals:
        np.testing.assert_array_equal(plain[name], warm[name], err_msg=name)


def test_stored_temperatures_are_those_of_records_that_are_simulated_again_as_the_sensor_shows_them(tmp_path):
    sweep = sweep_in(tmp_path, SWEEP)
    stored, again = (next(open_records(each)[0].batches()) for each in (sweep.directory, sweep.config))
    np.testing.assert_array_equal(stored[Channel.OIL_TEMPERATURE], again[Channel.OIL_TEMPERATURE])
    first = next(iter(hydrofdi.replay(sweep.directory)))
    part = stored[Channel.OIL_TEMPERATURE][0, : len(first.time)]
    np.testing.assert_array_equal(first.channels[Channel.OIL_TEMPERATURE], part)
    with h5py.File(sweep.file) as file:
        np.testing.assert_allclose(file["warmth.mean"], [323.65, 324.65], atol=0.02)
        np.testing.assert_allclose(file["warmth.standard_deviation"], [0.1, 12**-0.5 * 2.0], rtol=0.05)


MACHINE = {
    "fluid.temperature": "45 °C", "valve.lap_leakage": 1e-12, "pressure_1_sensor.noise": "1 kPa",
    "temperature_sensor.noise": "0.2 K",
}  # fmt: skip
STUDY = {
    "population": {"per_record": {"fluid.temperature_rise": {"uniform": ["-10 K", "10 K"]}}},
    "healthy": {"fit": 40, "test": 2}, "faults": {"leakage.internal_flow": ["0.2 L/min"], "each": 2},
}  # fmt: skip
RISES = {"grid": {"fluid.temperature_rise": ["-8 K", "-4 K", "1e-30 K", "4 K", "8 K"]}}


def test_compensated_leak_of_a_warm_machine_varies_less_with_its_temperature(tmp_path):
    """Flow through clearances rises with thinner oil: by 0.12 L/min over 16 K, which the channel explains."""
    study, fresh = tmp_path / "study.yaml", tmp_path / "fresh.yaml"
    study.write_text(experiment(MACHINE, study=STUDY), encoding="utf-8")
    fresh.write_text(experiment(MACHINE | {"leakage.internal_coefficient": 0}, sweep=RISES), encoding="utf-8")
    spans = {}
    for compensate in (True, False):
        detector = hydrofdi.train(
            study, "flow_balance", output="cross_port_leakage", direction="both", false_alarm_rate="10 %",
            compensate=compensate,
        )  # fmt: skip
        spans[compensate] = np.ptp(np.array(detector.judge(fresh)["score"], dtype=float))
    assert spans[False] > 1e-6  # m³/s
    assert spans[True] < 0.05 * spans[False]
