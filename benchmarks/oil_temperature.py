"""What a recorded oil temperature is worth with a history of the machine's own: docs/not-the-model.md.

    python benchmarks/oil_temperature.py [--machines 8]

Machines of real-rig, each with 80 healthy windows of 10 s in oil within ±10 K that drifts by up to 0.15 K/s.
Forty set a limit: their largest value, or, with the temperature, the largest beyond a parabola over it. Room
is the limit over the healthy median; the other forty are the control. About four minutes.
"""

from __future__ import annotations

import argparse
import tempfile
from typing import Any

import numpy as np
from diagnosis import machines

import hydrofdi

N_FIT, N_TEST = 40, 40
SCORES = {"leakage": "K_i", "cross_port_leakage": "any law"}
ML_PER_MIN = 1e-6 / 60.0


def experiment(loop: str, **more: Any) -> dict[str, Any]:
    weak_rls = {"spool": "command", "supply": "sum", "null_leakage": "0.5 L/min"}
    extends = ["populations/real-rig.yaml", f"motions/{loop}-loop.yaml"]
    fixed = {"name": "oil", "record": {"duration": "10 s"}, "indicators": {"weak_rls": weak_rls}}
    return {**fixed, "extends": extends, **more}


def room(loop: str, machine: dict[str, Any], folder: str) -> dict[str, tuple[float, float, float]]:
    """Score → room without and with the temperature [mL/min], and share of the control beyond both limits."""
    temperature = {
        "fluid.temperature_rise": {"uniform": "±10 K"},
        "fluid.temperature_drift": {"uniform": "±0.15 K/s"},
    }
    population = {
        "seed": 7,
        "over": {k: {"choice": [v]} for k, v in machine.items()},
        "per_record": temperature,
    }
    study = {"population": population, "healthy": {"fit": 1, "test": N_FIT + N_TEST}, "shifts": {}}
    study["faults"] = {"leakage.internal_flow": ["0.1 L/min"], "each": 1, "fit": 0}
    found = hydrofdi.sweep(experiment(loop, study=study), out=folder).dataset
    own = np.flatnonzero(found.population_kind.values == "healthy")[-N_FIT - N_TEST :]
    rise = (
        found.fluid_temperature_rise.values[own]
        if "fluid_temperature_rise" in found
        else found.temperature_rise.values[own]
    )
    basis = np.stack([np.ones_like(rise), rise, rise**2], axis=1)
    fit, test = slice(0, N_FIT), slice(N_FIT, None)
    rooms = {}
    for score in SCORES:
        values = found[f"weak_rls.{score}"].values[own] / ML_PER_MIN
        beyond = values - basis @ np.linalg.lstsq(basis[fit], values[fit], rcond=None)[0]
        without, within = values[fit].max() - np.median(values[fit]), beyond[fit].max()
        alarms = (values[test] > values[fit].max()).mean(), (beyond[test] > within).mean()
        rooms[score] = (float(without), float(within), float(max(alarms)))
    return rooms


def main() -> None:
    """Print the rooms of all machines."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--machines", type=int, default=8)
    options = parser.parse_args()
    for loop in ("open", "closed"):
        with tempfile.TemporaryDirectory() as work:
            found = [
                room(loop, machine, f"{work}/{k}")
                for k, machine in enumerate(machines(loop, options.machines))
            ]
        for score, title in SCORES.items():
            without, within, alarms = np.array([each[score] for each in found]).T
            ratio = without / within
            print(
                f"{loop} loop, {title}: room {without.min():.2g} to {without.max():.2g}, with the"
                f" temperature {within.min():.2g} to {within.max():.2g} mL/min; ratio {np.median(ratio):.2g}"
                f" ({ratio.min():.2g} to {ratio.max():.2g}); control beyond {100 * alarms.mean():.1f} %"
            )


if __name__ == "__main__":
    main()
