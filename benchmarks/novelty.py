"""Fraction of windows that a detector calls novel or clipped: other healthy machines, leaks, other operation.

    python benchmarks/novelty.py [--seed 10] [--duration '20 s']

Machines are those of configs/populations/unknown-plant.yaml in closed loop; each gives one window. Columns:
number of healthy windows in the training set.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

import numpy as np

from hydrofdi.config import load_experiment
from hydrofdi.config.runs import study_roles
from hydrofdi.detectors.verdicts import channel_facts, findings, learned_range
from hydrofdi.execution.simulated import SimulatedRecords
from hydrofdi.records import Channel

CONFIGS = Path(__file__).parent.parent / "configs"

CHANNELS = (
    Channel.CHAMBER_1_PRESSURE, Channel.CHAMBER_2_PRESSURE, Channel.PISTON_POSITION, Channel.INPUT_VOLTAGE,
)  # fmt: skip

LEARNED = (10, 30, 100, 300)

STUDY = """\
extends: [{configs}/populations/unknown-plant.yaml, {configs}/motions/closed-loop.yaml]
name: novelty
record: {{duration: {duration}}}
study:
  population: {{seed: {seed}}}
  healthy: {{fit: 300, test: 400, shift: 100}}
  faults: {{leakage.internal_flow: [0.1 L/min, 0.3 L/min, 1 L/min], each: 100, fit: 0, severity: level}}
  shifts:
    supply 15 MPa: {{supply.pressure: 15 MPa}}
    twice the load: {{load.random_force: 2 kN}}
    half the motion: {{control.amplitude: 10 mm}}
"""


def main() -> None:
    """Print the fractions."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--seed", type=int, default=10)
    parser.add_argument("--duration", default="20 s")
    with tempfile.NamedTemporaryFile("w", suffix=".yaml") as file:
        file.write(STUDY.format(configs=CONFIGS, **vars(parser.parse_args())))
        file.flush()
        experiment = load_experiment(Path(file.name))
    roles = study_roles(experiment)
    print(f"{'windows':28}", *(f"{n:>6}" for n in LEARNED))
    learned = []
    for place, population in enumerate(roles.populations):
        rows = np.flatnonzero(roles.of_run == place).tolist()
        batches = [*SimulatedRecords(experiment, "study", CHANNELS, rows).batches()]
        if population.is_fit:
            rows_of = {channel: np.concatenate([each[channel] for each in batches]) for channel in CHANNELS}
            learned = [
                {each: learned_range(each, [channel_facts(rows_of[each][:n])]) for each in CHANNELS}
                for n in LEARNED
            ]
            continue
        found = [[each is not None for batch in batches for each in findings(batch, own)] for own in learned]
        print(f"{population.title:28}", *(f"{np.mean(each):6.1%}" for each in found), flush=True)


if __name__ == "__main__":
    main()
