"""What newcomers type first works, or is answered with the name that they mean."""

import numpy as np
import pytest

import hydrofdi

WORK = [
    "run.plot()", "run.to_pandas()", "run.to_xarray()", "run.features['dwt.d2']", "run.signals['P1']",
    "run.P1", "run['P1']", "run.t", "run.time", "run.chamber_1_pressure", "run['dwt.d2']", "run.x",
    "run.table", "run.save('again.h5')", "run.mean_internal_leakage_flow.to('L/min')", "run.to_dict()",
    "hydrofdi.load('study')", "hydrofdi.load('study').dataset",
    "hydrofdi.load(pathlib.Path('study')).plot()", "hydrofdi.report('study')",
    "hydrofdi.load('study').report()", "hydrofdi.indicators()", "hydrofdi.indicators('dwt')",
    "hydrofdi.measure(run)", "hydrofdi.measure(run, 'ring_down')", "hydrofdi.measure('run.h5')",
    "hydrofdi.simulate(bulk_modulus='689 MPa', duration='1 s')",
    "hydrofdi.load_experiment(settings='bulk_modulus=689 MPa')", "hydrofdi.plan({'name': 'x'})",
]  # fmt: skip
ANSWERED = {
    "run.p1": "'P1'", "run['p1']": "'P1'", "run.to_dataframe()": "'to_pandas'", "run.export()": "'save'",
    "run.write('run.h5')": "'save'", "run.summary()": "'table'",
    "run.natural_frequency": "'hydraulic_mode_frequency'", "hydrofdi.open('study')": "'load'",
    "hydrofdi.results('study')": "'load'", "run.measure()": "'hydrofdi.measure'",
    "hydrofdi.Detector.train(run)": "'hydrofdi.train'",
    "hydrofdi.Detector('detector.json')": "Detector.load", "hydrofdi.list_indicators()": "'indicators'",
    "hydrofdi.simulate(leakage='0.5 L/min')": "internal_flow",
    "hydrofdi.simulate(beta=1e9)": "'bulk_modulus'",
    "hydrofdi.simulate(leak='0.5 L/min')": "'internal_flow'",
}  # fmt: skip


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("guesses")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        simulated = hydrofdi.simulate(duration="2 s", out="run.h5")
        study = {"name": "study", "sweep": {"grid": {"fluid.bulk_modulus": ["551 MPa", "689 MPa"]}}}
        hydrofdi.sweep(study, out="study", engine="in-process", duration="2 s")
        yield simulated


@pytest.mark.parametrize("guess", [*WORK, *ANSWERED])
def test_a_guess_works_or_is_answered(guess, run):
    import pathlib

    names = {"run": run, "hydrofdi": hydrofdi, "pathlib": pathlib}
    if guess in WORK:
        eval(guess, names)
        return
    with pytest.raises((AttributeError, hydrofdi.HydrofdiError)) as raised:
        eval(guess, names)
    assert ANSWERED[guess] in str(raised.value)


def test_signals_are_arrays_over_time_in_si(run):
    assert run.P1.shape == run.time.shape == (1000,)
    assert np.isclose(run.mean_internal_leakage_flow.to("L/min"), run.mean_internal_leakage_flow * 60e3)
    with pytest.raises(ValueError, match="dimension"):
        run.mean_internal_leakage_flow.to("bar")


def test_a_room_with_the_name_of_a_function_stays_a_module():
    import hydrofdi.report.table as table

    assert hydrofdi.report.table is table
    assert callable(hydrofdi.report)
