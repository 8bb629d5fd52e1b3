"""Which fault is named on machines of other kinds than those on which the method was tuned.

    python benchmarks/diagnosis_elsewhere.py --loop open [--kinds hoses,valve] [--machines 3]

Machines of `KINDS` with seeds of their own, 12 healthy records of 20 s each; then 10 healthy records, and two
of each fault, of random size from a usual one to eight times it (without a hypothesis: three times). A fault
counts if `diagnose` says that it would have seen its size; one without a hypothesis, if it is not called
healthy. Last, how many of histories of 6 to 20 healthy records lose one of them. About 40 s of processor time
for each machine.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np
from diagnosis import EDGES, NOTHING, error, expected, faults, records_of, share

from hydrofdi.config import load_experiment
from hydrofdi.diagnosis.history import history_of, signatures
from hydrofdi.diagnosis.hypotheses import HEALTHY, NONE
from hydrofdi.diagnosis.judging import Judge
from hydrofdi.execution.simulated import SimulatedRecords
from hydrofdi.indicators.nominal_actuator import from_sheet
from hydrofdi.indicators.registry import sound_indicator

N_PAST, N_HISTORY, N_HEALTHY, N_DRAW, N_MACHINE, SEED = 20, 12, 10, 2, 3, 9101
Law = Callable[[np.random.Generator], Any]


def uniform(low: float, high: float) -> Law:
    return lambda draw: draw.uniform(low, high)


def normal(middle: float, deviation: float) -> Law:
    return lambda draw: middle + draw.normal(0.0, deviation)


KINDS: dict[str, tuple[dict[str, float], dict[str, Law]]] = {
    "hoses": ({}, {
        "actuator.hose_volume": uniform(1.2e-4, 2.2e-4), "actuator.hose_modulus": uniform(2.5e8, 3.5e8),
        "actuator.hose_resistance": uniform(4e9, 1e10), "actuator.hose_inertance": uniform(3e7, 8e7),
    }),
    "friction": ({"friction.coulomb": 500.0, "friction.breakaway": 900.0, "friction.viscous": 300.0}, {
        "friction.law": lambda _: "lugre", "friction.pressure_slope": uniform(8e-8, 1.5e-7),
        "friction.position_share": uniform(0.3, 0.5),
    }),
    "valve": ({"valve.natural_frequency": 60.0}, {
        "valve.lap": uniform(3e-6, 7e-6), "valve.natural_frequency": uniform(45.0, 75.0),
        "valve.gain_slope": normal(0.0, 1e3), "valve.hysteresis": uniform(0.06, 0.12),
        "valve.edge_rounding": uniform(2e-6, 4e-6),
        **{f"{edge}.lap": uniform(-2.5e-6, 2.5e-6) for edge in EDGES},
        **{f"{edge}.flow_gain_ratio": normal(1.0, 0.05) for edge in EDGES},
    }),
    "single": ({"actuator.piston_area_2": 3.5e-4, "actuator.chamber_volume_2": 1.55e-4}, {}),
    "oil": ({
        "fluid.bulk_modulus": 1.4e9, "supply.pressure": 2.5e7, "valve.flow_gain": 0.0294,
        "pressure_1_sensor.highest": 4e7, "pressure_2_sensor.highest": 4e7,
    }, {"fluid.free_air": uniform(1e-3, 1e-2), "actuator.hose_volume": uniform(5e-6, 1.5e-5)}),
}  # fmt: skip
"""Kind → what its data sheet states otherwise, and what is drawn for each machine beside real-rig."""


def experiment_of(loop: str, fixed: dict[str, float], study: dict[str, Any]) -> Any:
    sections: dict[str, Any] = {}
    for key, value in fixed.items():
        section, name = key.split(".")
        sections.setdefault(section, {})[name] = value
    return load_experiment({
        "extends": ["populations/real-rig.yaml", f"motions/{loop}-loop.yaml"], "name": "rig", "study": study,
    } | sections)  # fmt: skip


def machines(loop: str, kind: str) -> tuple[list[dict[str, Any]], int]:
    """Parameters of the machines of a kind, and their seed."""
    fixed, over = KINDS[kind]
    seed = SEED + 10 * list(KINDS).index(kind) + (0 if loop == "closed" else 5)
    study = {"population": {"seed": seed}, "healthy": {"fit": 1, "test": N_MACHINE}}
    experiment, draw = experiment_of(loop, fixed, study), np.random.default_rng(seed)
    runs = SimulatedRecords(experiment, "drawn").runs
    columns = {name: runs.values(name) for name in experiment.study.population.over}
    owns = [{name: values[1 + row] for name, values in columns.items()} for row in range(N_MACHINE)]
    for own in owns:
        own |= {name: law(draw) for name, law in over.items()}
    return owns, seed


def simulated(loop: str, fixed: dict[str, float], rows: list[dict[str, Any]]) -> tuple[Any, list[Any]]:
    """Options of the balance of the machine's data sheet, and records with these parameters, in order."""
    rig = experiment_of(loop, fixed, {"healthy": {"fit": 1, "test": 1}})
    sheet = SimulatedRecords(rig, "sheet").data_sheet
    settings = {"spool": "command", "supply": "nominal"}
    made = sound_indicator("flow_balance", settings).options
    options = sound_indicator("flow_balance", settings | from_sheet(made, sheet)).options
    return options, records_of(rig, rows)


def stated(name: str, size: float, own: dict[str, Any], fixed: dict[str, float]) -> float:
    """A size as `diagnose` states it."""
    rubbing = own["friction.scale"] * fixed.get("friction.coulomb", 200.0)
    softness = fixed.get("fluid.bulk_modulus", 551e6) / own["fluid.bulk_modulus"]
    of = {
        "friction_up": rubbing * size, "friction_down": rubbing * (1.0 - 1.0 / (1.0 + size)),
        "weak_supply": own["supply.pressure"] * size, "soft_oil": softness * size,
        "stiff_oil": softness * (1.0 - 1.0 / (1.0 + size)),
    }  # fmt: skip
    return float(of.get(name, size))


def judged(loop: str, kind: str, number: int) -> tuple[list[tuple[str, float, list[Any]]], list[bool]]:
    """Fault, size and findings of the records of a machine; whether histories lose a record."""
    fixed, (owns, seed) = KINDS[kind][0], machines(loop, kind)
    own, draw = owns[number], np.random.default_rng(1000 * seed + number)
    asked: list[tuple[str, float, dict[str, Any]]] = [(HEALTHY, 0.0, {})] * (N_PAST + N_HEALTHY)
    for _ in range(N_DRAW):
        for name, (usual, change) in faults(own, draw).items():
            size = usual * float(np.exp(draw.uniform(0.0, np.log(3.0 if name.startswith("~") else 8.0))))
            asked.append((name, stated(name, size, own, fixed), change(size)))
    rows = []
    for *_, change in asked:
        day = {
            "fluid.temperature_rise": draw.uniform(-10.0, 10.0),
            "fluid.temperature_drift": draw.uniform(-0.15, 0.15),
        } | {f"{part}.seed": int(draw.integers(2**31)) for part in ("input", "load", "measurement")}
        rows.append(own | NOTHING | day | {"leakage.law": "orifice"} | change)
    options, records = simulated(loop, fixed, rows)
    judge, found = Judge(history_of(records[:N_HISTORY], options)), []
    for (name, size, _), record in zip(asked[N_PAST:], records[N_PAST:], strict=True):
        if record is not None:
            (signature,), made = signatures(judge.history.balance, record, judge.history.variance)
            found.append((name, size, judge.judge(signature, made.gains[0], made.noise[0])))
    healthy = [each for each in records[: N_PAST + N_HEALTHY] if each is not None]
    lost = [
        Judge(history_of([healthy[row] for row in draw.permutation(len(healthy))[:n]], options)).stranger()
        for n in (6, 8, 12, 20)
    ]
    return found, [each is not None for each in lost]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--loop", default="closed", choices=("closed", "open"))
    parser.add_argument("--kinds", default=",".join(KINDS))
    parser.add_argument("--machines", type=int, default=N_MACHINE)
    asked = parser.parse_args()
    right, missed, calm, unlisted, lost = (list[bool]() for _ in range(5))
    pairs: list[tuple[float, bool]] = []
    called: dict[str, Counter[str]] = {}
    for kind in asked.kinds.split(","):
        for number in range(asked.machines):
            found, own_lost = judged(asked.loop, kind, number)
            lost += own_lost
            seen = [each for name, _, findings in found if name == HEALTHY for each in findings]
            for name, size, findings in found:
                first = findings[0].name if findings else ""
                sizes = [each.visible for each in seen if each.name == name]
                is_listed = name != HEALTHY and not name.startswith("~")
                # Beside the healthy records stands what would have been seen.
                if (is_listed and not size >= np.median(sizes)) or (
                    name.startswith("~") and first == HEALTHY
                ):
                    continue
                ok = first == expected(name)
                called.setdefault(name, Counter())[first] += 1
                pairs.append((findings[0].probability if findings else 0.0, ok))
                if is_listed:
                    right, missed = [*right, ok], [*missed, first == HEALTHY]
                elif name == HEALTHY:
                    calm.append(first not in (HEALTHY, ""))
                else:
                    unlisted.append(first == NONE)
    print(f"{asked.loop} loop: right first {share(right)}; called healthy {share(missed)}")
    print(f"healthy called a fault {share(calm)}; unlisted called {NONE} {share(unlisted)}")
    print(f"expected calibration error {error(pairs):.3f}; histories that lose a record {share(lost)}")
    for name, counts in called.items():
        print(f"{name}: {dict(counts.most_common())}")


if __name__ == "__main__":
    main()
