"""The balances on machines whose physics they do not share: the real-rig population."""

import numpy as np
import pytest

import hydrofdi

pytestmark = pytest.mark.long

MOTIONS = ["open", "closed"]
FLOW, LEVELS = 1e-3 / 60.0, (0.1, 1.0)
N_HEALTHY = 50


@pytest.fixture(scope="module", params=MOTIONS)
def rigs(request, tmp_path_factory):
    """Healthy and leaking machines of any law, 20 s each: estimates and true mean flows [m³/s]."""
    study = {
        "name": "rigs",
        "extends": ["populations/real-rig.yaml", f"motions/{request.param}-loop.yaml"],
        "indicators": {
            "both": {"kind": "weak_rls", "spool": "command", "supply": "sum"},
            "balance": {"kind": "flow_balance", "spool": "command", "supply": "sum"},
        },
        "study": {
            "population": {"seed": 26},
            "healthy": {"fit": 40, "test": 10},
            "faults": {"leakage.internal_flow": [f"{each} L/min" for each in LEVELS], "each": 20},
        },
        "detection": {"false_alarm_rate": "10 %"},
    }
    folder = tmp_path_factory.mktemp(request.param) / "results"
    return hydrofdi.sweep(study, out=folder, engine="in-process").dataset


@pytest.mark.parametrize("name", ["both", "balance"])
def test_healthy_machines_are_within_three_deviations_and_means_of_any_law_within_two(rigs, name):
    truth = rigs["mean_internal_leakage_flow"].to_numpy()
    of = {key: rigs[f"{name}.{key}"].to_numpy() for key in ("internal_coefficient", "mean_leakage")}
    error = {key: rigs[f"{name}.{key}_error"].to_numpy() for key in of}
    healthy, laws = truth == 0.0, rigs["leakage_law"].to_numpy()
    assert healthy.sum() == N_HEALTHY
    assert (np.abs(of["internal_coefficient"]) > 3.0 * error["internal_coefficient"])[healthy].mean() <= 0.02
    held = (np.abs(of["mean_leakage"] - truth) < 2.0 * error["mean_leakage"])[~healthy]
    assert held.mean() >= 0.9
    assert {*laws[~healthy].astype(str)} == {"orifice", "laminar"}
    large = truth > 0.5 * LEVELS[-1] * FLOW  # a scored part of the bore leaks less if the piston is elsewhere
    assert of["mean_leakage"][large].min() > np.quantile(of["mean_leakage"][healthy], 0.99)
