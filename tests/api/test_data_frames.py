"""Data frames of runs and results, as notebooks ask for them."""

import numpy as np

import hydrofdi


def test_signals_of_a_run_come_as_a_data_frame_that_is_measured_like_the_run():
    run = hydrofdi.simulate(duration="2 s", internal_flow="0.2 L/min")
    frame = run.to_pandas()
    assert frame.columns[0] == "time [s]"
    assert "chamber_1_pressure [Pa]" in frame.columns
    same, own = hydrofdi.measure(frame, "dwt"), hydrofdi.measure(run, "dwt")
    np.testing.assert_allclose(same["dwt.d2"], own["dwt.d2"], rtol=1e-12)


def test_results_are_a_data_frame(tmp_path):
    study = {
        "name": "two",
        "record": {"duration": "2 s"},
        "sweep": {"grid": {"leakage.internal_flow": [0, "1 L/min"]}},
    }
    results = hydrofdi.sweep(study, out=tmp_path / "two", engine="in-process")
    assert results.to_pandas().run_id.nunique() == results.data.n_run
