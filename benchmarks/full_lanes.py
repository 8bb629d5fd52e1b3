"""Kernel alone, with all lanes in use."""

from __future__ import annotations

import numpy as np
from jobs import Job

from hydrofdi.simulation.batch import chunks
from hydrofdi.simulation.inputs import Inputs
from hydrofdi.simulation.kernel import advance_lanes
from hydrofdi.simulation.lanes import N_PAPER_SAMPLED, WIDTH, ModelOptions, pack_lanes


def advance_full_lanes(jobs: list[Job]) -> None:
    """Run only the kernels: spools and lanes, chunk by chunk."""
    runs = [parameters for parameters, _ in jobs]
    record, inputs = runs[0].record, Inputs(runs, runs[0].record)
    lanes = pack_lanes(runs, [coefficient for _, coefficient in jobs])
    for window, chunk in chunks(inputs, record):
        samples = np.empty((window.stop - window.start, N_PAPER_SAMPLED, WIDTH))
        advance_lanes(
            lanes, chunk.stages, inputs.column_of_run, chunk.loads, inputs.load_of_run,
            int(len(set(inputs.column_of_run.tolist())) == 1), record.step, record.steps_per_sample, 1,
            samples, window.start * record.steps_per_sample, ModelOptions(),
        )  # fmt: skip
