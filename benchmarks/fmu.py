"""Runs on an FMU, as ratios: the loop against FMPy's own, the start of a run, and two workers against one.

``python benchmarks/fmu.py`` in a checkout, on a quiet machine with a C compiler; about a minute.
"""

import json
import sys
import tempfile
import time
from pathlib import Path

import fmpy
import numpy as np
from fmpy.simulation import instantiate_fmu

import hydrofdi
from hydrofdi.config import expand_runs
from hydrofdi.simulation import foreign

sys.path.insert(0, str(Path(__file__).parents[1]))
from tests.fmus.building import build

OUTPUTS = {"P1": "cyl.port_a.p", "P2": "cyl.port_b.p", "x": "x", "internal_leakage": "q_leak"}
N_REPEAT, N_RUN = 5, 200


def experiment(fmu: Path, duration: str, **more: object) -> dict[str, object]:
    plant = {"fmu": str(fmu), "inputs": {"u": "u"}, "outputs": OUTPUTS, "leakage": {"coefficient": "seal.k"}}
    record, wavelet = {"duration": duration}, {"levels": 3}
    return {
        "name": "fmu",
        "plant": plant,
        "record": record,
        "wavelet": wavelet,
        "store": {"signals": "none"},
        **more,
    }


def main() -> None:
    with tempfile.TemporaryDirectory() as work:
        fmu = build(Path(work))
        (run,) = expand_runs(hydrofdi.load_experiment(experiment(fmu, "4 s"))).runs
        (short,) = expand_runs(hydrofdi.load_experiment(experiment(fmu, "0.3 s"))).runs
        asked, brief = (foreign.Asked(each.parameters, 0.0, None, every_step=False) for each in (run, short))
        model, folder = fmpy.read_model_description(str(fmu)), fmpy.extract(str(fmu))
        instance = instantiate_fmu(folder, model)
        times, levels = np.repeat(np.arange(5.0), 2)[1:-1], np.tile([2.0, 2.0, -2.0, -2.0], 2)
        drive = np.rec.fromarrays([times, levels], names="time,u")
        loops, starts = [], []
        for _ in range(N_REPEAT):
            begin = time.process_time()
            foreign.simulated(asked)
            own = time.process_time() - begin
            fmpy.simulate_fmu(
                folder, model_description=model, fmu_instance=instance, stop_time=4.0, input=drive,
                output_interval=run.parameters.record.step, output=[*OUTPUTS.values()],
            )  # fmt: skip
            instance.reset()
            loops.append(own / (time.process_time() - begin - own))
            begin = time.process_time()
            foreign.simulated(brief)
            starts.append(
                time.process_time() - begin - own * brief.run.record.n_step / asked.run.record.n_step
            )
        seconds = {}
        grid = {"plant.oil.beta": {"linspace": ["551 MPa", "827 MPa", N_RUN]}}
        for workers in (1, 2):
            begin = time.perf_counter()
            out = Path(work) / str(workers)
            hydrofdi.sweep(experiment(fmu, "2 s", sweep={"grid": grid}), out=out, workers=workers)
            seconds[workers] = time.perf_counter() - begin
    found = {
        "cpu_of_loop_over_fmpy_simulate_fmu": float(np.median(loops)),
        "cpu_of_start_ms": 1e3 * float(np.median(starts)),
        "sweep_one_worker_over_two": seconds[1] / seconds[2],
    }
    print(json.dumps(found, indent=2))


if __name__ == "__main__":
    main()
