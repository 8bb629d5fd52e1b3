"""Share of windows that a detector calls novel or clipped: other healthy machines, and leaking ones.

    python benchmarks/novelty.py [--fit 300] [--seed 9] [--duration '20 s']

Machines are those of configs/populations/unknown-plant.yaml in closed loop; each gives one window.
"""

from __future__ import annotations

import argparse
import tempfile
from collections import defaultdict
from pathlib import Path

import numpy as np

from hydrofdi.config import load_experiment
from hydrofdi.config.run_table.expansion import study_roles
from hydrofdi.detectors.trained.novelty import findings
from hydrofdi.detectors.trained.ranges import channel_facts, joined, learned_range
from hydrofdi.pipeline.simulated import SimulatedRecords
from hydrofdi.records import Channel

CONFIGS = Path(__file__).parent.parent / "configs"

CHANNELS = (
    Channel.CHAMBER_1_PRESSURE, Channel.CHAMBER_2_PRESSURE, Channel.PISTON_POSITION, Channel.INPUT_VOLTAGE,
)  # fmt: skip

STUDY = """\
extends: [{configs}/populations/unknown-plant.yaml, {configs}/motions/closed-loop.yaml]
name: novelty
record: {{duration: {duration}}}
study:
  population: {{seed: {seed}}}
  healthy: {{fit: {fit}, test: 400, shift: 100}}
  faults: {{leakage.internal_flow: [0.1 L/min, 0.3 L/min, 1 L/min], each: 100, fit: 0, severity: level}}
  shifts:
    supply 15 MPa: {{supply.pressure: 15 MPa}}
    twice the load: {{load.random_force: 2 kN}}
    half the motion: {{control.amplitude: 10 mm}}
"""


def main() -> None:
    """Print the shares."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--fit", type=int, default=300)
    parser.add_argument("--seed", type=int, default=9)
    parser.add_argument("--duration", default="20 s")
    chosen = parser.parse_args()
    with tempfile.NamedTemporaryFile("w", suffix=".yaml") as file:
        file.write(STUDY.format(configs=CONFIGS, **vars(chosen)))
        file.flush()
        experiment = load_experiment(Path(file.name))
    roles = study_roles(experiment)
    ranges, shares = {}, {}
    for population in roles.populations:
        rows = np.flatnonzero(roles.of_run == roles.populations.index(population)).tolist()
        batches = [*SimulatedRecords(experiment, "study", CHANNELS, rows).batches()]
        if population.is_fit:
            ranges = {
                channel: learned_range(channel, joined([channel_facts(batch[channel]) for batch in batches]))
                for channel in CHANNELS
            }
            continue
        kinds: dict[str, int] = defaultdict(int)
        for batch in batches:
            for finding in findings(batch, ranges):
                kinds[finding.kind if finding else "judged"] += 1
        shares[population.title] = dict(kinds)
        n_record = sum(kinds.values())
        print(
            f"{population.title:28} {n_record:4}",
            *(f"{kind} {n / n_record:.1%}" for kind, n in kinds.items()),
        )


if __name__ == "__main__":
    main()
