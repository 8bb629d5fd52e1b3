"""Records of a sealed single-rod cylinder, simulated by equations that are not those of hydrofdi."""

import math

import numpy as np
import pytest

import hydrofdi
from hydrofdi.errors import ConfigError, DataError

BORE_AREA, ROD_AREA = math.pi / 4.0 * 0.050**2, math.pi / 4.0 * (0.050**2 - 0.028**2)
STROKE, DEAD, MODULUS, SUPPLY = 0.4, 50e-6, 1.2e9, 21e6
RATE, STEPS = 500.0, 40
RIGHT = {
    "piston_area": BORE_AREA,
    "piston_area_2": ROD_AREA,
    "chamber_volume": DEAD + BORE_AREA * STROKE / 2.0,
    "chamber_volume_2": DEAD + ROD_AREA * STROKE / 2.0,
    "bulk_modulus": 1e9,
    "supply": "nominal",
    "supply_pressure": SUPPLY,
}
FROM_THE_END = RIGHT | {"position_zero": "retracted", "stroke": "400 mm"}
MEAN_AREA = (BORE_AREA + ROD_AREA) / 2.0
ONE_AREA = {name: value for name, value in RIGHT.items() if not name.endswith("_2")} | {
    "piston_area": MEAN_AREA,
    "chamber_volume": DEAD + MEAN_AREA * STROKE / 2.0,
}


def edge_flow(opening, drop):
    return 0.0292 * 20.75e-3 * opening * math.copysign(math.sqrt(abs(drop)), drop)


def valve(spool, pressure):
    return edge_flow(spool, SUPPLY - pressure) if spool > 0.0 else edge_flow(spool, pressure)


@pytest.fixture(scope="module")
def records():
    """P1, P2, x_p from the centre and x_v over 20 s, semi-implicit Euler with a step of 50 µs."""
    step, target, spool, x, v, p1, p2 = (
        1.0 / RATE / STEPS,
        0.0,
        0.0,
        0.0,
        0.0,
        9e6,
        9e6 * BORE_AREA / ROD_AREA,
    )
    random, rows = np.random.default_rng(3), []
    for sample in range(round(20 * RATE)):
        if sample % 300 == 0:
            target = random.uniform(-0.06, 0.06)
        rows.append((p1, p2, x, spool))
        for _ in range(STEPS):
            command = min(max(8e-3 * (target - x), -200e-6), 200e-6)
            spool += step / 4e-3 * (command - spool)
            q1, q2 = valve(spool, p1), -valve(-spool, p2)
            force = BORE_AREA * p1 - ROD_AREA * p2 - 2e3 * v - 200.0 * math.tanh(v / 5e-3) - 3000.0
            v += step * force / 250.0
            p1 += step * MODULUS * (q1 - BORE_AREA * v) / (DEAD + BORE_AREA * (STROKE / 2.0 + x))
            p2 += step * MODULUS * (ROD_AREA * v - q2) / (DEAD + ROD_AREA * (STROKE / 2.0 - x))
            x += step * v
    names = ("chamber_1_pressure", "chamber_2_pressure", "piston_position", "spool_position")
    found = dict(zip(names, np.array(rows).T, strict=True))
    noise = {name: 2e3 if "pressure" in name else 1e-7 for name in names}
    return {name: row + noise[name] * random.standard_normal(row.size) for name, row in found.items()}


def moved(of, distance):
    return of | {"piston_position": of["piston_position"] + distance}


def measured(signals, options):
    return hydrofdi.measure(signals, "flow_balance", options=options, sampling_frequency=RATE)


@pytest.mark.parametrize(
    ("distance", "options"),
    [
        (0.0, RIGHT),
        (0.0, {name: value for name, value in RIGHT.items() if name != "chamber_volume_2"}),
        (STROKE / 2.0, FROM_THE_END),
        (-STROKE / 2.0, FROM_THE_END | {"position_zero": "extended"}),
        (STROKE / 2.0, RIGHT | {"chamber_volume": DEAD, "chamber_volume_2": DEAD + ROD_AREA * STROKE}),
    ],
)
def test_a_sealed_cylinder_has_no_leak_wherever_its_position_is_zero(records, distance, options):
    found = measured(moved(records, distance), options)
    assert abs(found["flow_balance.leakage"][0]) < 4.0 * found["flow_balance.leakage_error"][0]
    assert found["flow_balance.bulk_modulus"][0] == pytest.approx(MODULUS, rel=0.03)
    assert not [remark for remark in found.remarks if "doubtful" in remark]


@pytest.mark.parametrize(
    "indicator", ["flow_balance", "weak_rls", "ekf_joint", "adaptive_observer", "reduced_order"]
)
def test_a_chamber_without_volume_is_not_measured(records, indicator):
    plain = {name: value for name, value in RIGHT.items() if name != "supply"}
    found = hydrofdi.measure(
        moved(records, STROKE / 2.0), {indicator: plain | {"spool": "measured"}}, sampling_frequency=RATE
    )
    assert "volume of chamber 2" in found["reasons"][0]


def test_constants_and_strokes_that_no_actuator_has_are_refused(records):
    for key, value in {"bulk_modulus": 689, "damping_ratio": 0.001, "reference_pressure": 8}.items():
        with pytest.raises(ConfigError, match=key):
            measured(records, RIGHT | {key: value})
    with pytest.raises(ConfigError):
        measured(records, RIGHT | {"position_zero": "retracted"})
    found = measured(moved(records, STROKE / 2.0), FROM_THE_END | {"stroke": "10 mm"})
    assert "stroke" in found["reasons"][0]


def trained(signals, indicator, options, **more):
    given = {"window": "4 s", "false_alarm_rate": "25 %", "sampling_frequency": RATE} | more
    return hydrofdi.train(signals, {indicator: options}, **given)


def test_an_impossible_estimate_is_a_remark_and_a_warning_of_training(records):
    found = measured(records, ONE_AREA)
    assert found["status"][0] == "doubtful"
    assert any("doubtful" in remark for remark in found.remarks)
    looked = hydrofdi.inspect(records, {"flow_balance": ONE_AREA}, sampling_frequency=RATE)
    assert looked.remarks["doubtful"] == 1
    accepted = trained(records, "flow_balance", ONE_AREA)
    assert "Warning" in accepted.summary
    assert None not in list(accepted.judge(records, sampling_frequency=RATE)["alarm"])


def told(table):
    return zip(table["doubt"], table["fault"], strict=True)


@pytest.mark.parametrize("by", ["time", "estimate"])
def test_a_model_that_does_not_explain_a_machine_is_a_doubt_or_novel_unless_it_was_trained_on_it(records, by):
    wrong, more = moved(records, 0.12), {"window": None} if by == "estimate" else {}
    judged = [
        trained(healthy, "weak_rls", RIGHT, by=by, accept=True, **more).judge(wrong, sampling_frequency=RATE)
        for healthy in (records, wrong)
    ]
    of_another, own = (
        np.mean(["misfit" in doubt or "novel" in fault for doubt, fault in told(each)]) for each in judged
    )
    assert of_another > 0.5
    assert own == 0.0


def test_training_says_that_a_data_sheet_does_not_fit_the_healthy_records(records):
    def fits(healthy):
        return "data sheet does not fit" not in trained(healthy, "weak_rls", RIGHT, accept=True).summary

    assert fits(records)
    assert not fits(moved(records, 0.12))


P1, P2, X, U = "chamber_1_pressure", "chamber_2_pressure", "piston_position", "input_voltage"
INDICATOR = {"flow_balance": {"spool": "command", "supply": "sum"}}
RATE_SIGNS = "500 Hz"


def machine(seed, duration="64 s", leak="0 L/min"):
    run = hydrofdi.simulate(
        "motions/closed-loop", duration=duration, input={"seed": seed}, load={"seed": seed},
        pressure_1_sensor={"noise": "20 kPa"}, pressure_2_sensor={"noise": "20 kPa"}, internal_flow=leak,
    )  # fmt: skip
    signals = run.to_xarray()
    return {name: np.array(signals[name]) for name in (P1, P2, X, U)}


def reversed_position(of):
    return of | {X: -of[X]}


def swapped_pressures(of):
    return of | {P1: of[P2], P2: of[P1]}


@pytest.fixture(scope="module")
def healthy():
    return machine(1)


@pytest.fixture(scope="module")
def leaking():
    return machine(9, "16 s", "0.5 L/min")


def trained_signs(signals, **more):
    return hydrofdi.train(
        signals, INDICATOR, window="2 s", false_alarm_rate="5 %", sampling_frequency=RATE_SIGNS, **more
    )  # fmt: skip


@pytest.mark.parametrize("mistaken", [reversed_position, swapped_pressures])
def test_a_detector_is_not_trained_on_records_that_no_actuator_gives(healthy, mistaken):
    table = hydrofdi.measure(mistaken(healthy), INDICATOR, sampling_frequency=RATE_SIGNS)
    assert any("bulk_modulus" in remark for remark in table.remarks)
    assert list(table["status"]) == ["doubtful"]
    with pytest.raises(DataError):
        trained_signs(mistaken(healthy))
    assert "Warning: flow_balance.bulk_modulus" in trained_signs(mistaken(healthy), accept=True).summary


def test_a_leaking_machine_with_mistaken_channels_is_never_healthy(healthy, leaking):
    sound = hydrofdi.measure(healthy, INDICATOR, sampling_frequency=RATE_SIGNS)
    assert not any("doubtful" in remark for remark in sound.remarks)
    assert list(sound["status"]) == ["ok"]
    detector = trained_signs(healthy)
    assert all(detector.judge(leaking, sampling_frequency=RATE_SIGNS)["alarm"])
    for mistaken in (reversed_position, swapped_pressures):
        found = detector.judge(mistaken(leaking), sampling_frequency=RATE_SIGNS)
        assert False not in list(found["alarm"])
        assert all(doubt or fault == "novel" for doubt, fault in told(found))
    found = detector.judge(reversed_position(machine(9, "16 s")), sampling_frequency=RATE_SIGNS)
    assert False not in list(found["alarm"])
    assert all(doubt or fault == "novel" for doubt, fault in told(found))
