"""Which fault is named on machines of real-rig with their own history: the tables of docs/diagnosis.md.

    python benchmarks/diagnosis.py [--loop closed] [--fit 12] [--test 40] [--workers 2] [--out FOLDER]
    python benchmarks/diagnosis.py --figure reliability.png      # and a reliability diagram

Machines are drawn from configs/populations/real-rig.yaml; each has 12 healthy records of 20 s, of other days
and motions. On the fit machines the size is found from which on each fault is called nine times in ten. The
test machines have each fault at twice that size. What is stored in the folder is not computed again. About
25 minutes for each loop on two cores.
"""

from __future__ import annotations

import argparse
import json
import os
import pickle
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

import hydrofdi
from hydrofdi.config import ExperimentConfig, load_experiment
from hydrofdi.diagnosis.history import history_of, signatures
from hydrofdi.diagnosis.hypotheses import HEALTHY, NONE
from hydrofdi.diagnosis.judging import Judge
from hydrofdi.evaluation.rates import clopper_pearson
from hydrofdi.execution.simulated import SimulatedRecords
from hydrofdi.indicators.registry import sound_indicator

N_HISTORY, N_HEALTHY = 12, 5
LITRE_PER_MINUTE = 1e-3 / 60.0
EDGES = ("supply_1_edge", "return_1_edge", "supply_2_edge", "return_2_edge")
SENSORS = {
    "P1 P2 x u": {"spool": "command", "supply": "nominal"},
    "P1 P2 x xv": {"spool": "measured", "supply": "nominal"},
    "P1 x u": {"spool": "command", "supply": "nominal", "chambers": 1},
}
BINS = ((0.0, 0.5), (0.5, 0.7), (0.7, 0.9), (0.9, 0.99), (0.99, 1.01))
OTHERWISE = (HEALTHY, "friction_up", "friction_down", "weak_supply", "stiff_oil", "soft_oil")
GRID = [0.25, 0.5, 1.0, 2.0, 4.0]
NOTHING = {
    "leakage.internal_coefficient": 0.0, "leakage.external_coefficient_1": 0.0,
    "leakage.external_coefficient_2": 0.0, "voltage_sensor.gain_error": 0.0,
}  # fmt: skip


def faults(own: dict[str, Any], draw: np.random.Generator) -> dict[str, tuple[float, Any]]:
    """Fault → a usual size, and what it changes in a machine at a size; those with ~ are no hypothesis."""
    sign = iter(draw.choice([-1.0, 1.0], 20).tolist())
    edge, centre = EDGES[draw.integers(4)], float(draw.uniform(-8e-3, 8e-3))
    flow = 0.1 * LITRE_PER_MINUTE

    def seal(law: str, width: float, scale: float = 1.0) -> Any:
        return lambda size: {
            "leakage.law": law, "leakage.internal_coefficient": scale * size / 8e6**0.5,
            "leakage.scored_width": width, "leakage.scored_centre": centre,
        }  # fmt: skip

    def added(name: str, side: float = 1.0) -> Any:
        return lambda size: {name: own.get(name, 0.0) + side * size}

    def times(name: str, power: float) -> Any:
        return lambda size: {name: own[name] * (1.0 + size) ** power}

    return {
        "seal_orifice": (flow, seal("orifice", 1.0)),
        # The gap leaks at 10 MPa as much as the hole.
        "seal_laminar": (flow, seal("laminar", 1.0, 1.25**0.5)),
        "seal_scored": (flow, seal("orifice", 0.015)),
        "external_1": (flow, lambda size: {"leakage.external_coefficient_1": size / 8e6}),
        "external_2": (flow, lambda size: {"leakage.external_coefficient_2": size / 8e6}),
        "worn_edge": (1e-6, added(f"{edge}.lap", -1.0)),
        "null_shift": (1e-6, added("valve.null_offset", next(sign))),
        "free_air": (0.04, added("fluid.free_air")),
        "friction_up": (2.0, times("friction.scale", 1.0)),
        "friction_down": (2.0, times("friction.scale", -1.0)),
        "weak_supply": (0.05, lambda size: {"supply.pressure": own["supply.pressure"] * (1.0 - size)}),
        "raised_return": (4e5, added("supply.return_pressure")),
        "stiff_oil": (0.3, times("fluid.bulk_modulus", 1.0)),
        "soft_oil": (0.3, times("fluid.bulk_modulus", -1.0)),
        "bias_P1": (2e5, added("pressure_1_sensor.bias", next(sign))),
        "bias_P2": (2e5, added("pressure_2_sensor.bias", next(sign))),
        "gain_P1": (0.02, added("pressure_1_sensor.gain_error", next(sign))),
        "gain_P2": (0.02, added("pressure_2_sensor.gain_error", next(sign))),
        "gain_x": (0.02, added("position_sensor.gain_error", next(sign))),
        "flow_gain": (0.04, added("voltage_sensor.gain_error", next(sign))),
        "~ slow valve": (3.0, times("valve.natural_frequency", -1.0)),
        "~ hysteresis": (0.05, added("valve.hysteresis")),
        "~ late position": (2e-3, added("position_sensor.delay")),
        "~ loose mounting": (2.0, times("actuator.foundation_stiffness", -2.0)),
        "~ bowed flow curve": (1e3, added("valve.gain_slope", -1.0)),
    }


def machines(loop: str, count: int) -> list[dict[str, Any]]:
    """Parameters that are drawn for each machine."""
    experiment = load_experiment({
        "extends": ["populations/real-rig.yaml", f"motions/{loop}-loop.yaml"], "name": "drawn",
        "study": {"population": {"seed": 33}, "healthy": {"fit": 1, "test": count}},
    })  # fmt: skip
    runs = SimulatedRecords(experiment, "drawn").runs
    assert experiment.study is not None
    names = list(experiment.study.population.over)
    columns = {name: runs.values(name) for name in names}
    return [{name: columns[name][1 + row] for name in names} for row in range(count)]


def simulated(loop: str, rows: list[dict[str, Any]]) -> list[Any]:
    """Records of machines with these parameters, in order."""
    return records_of(load_experiment({
        "extends": ["populations/real-rig.yaml", f"motions/{loop}-loop.yaml"], "name": "rig",
        "record": {"duration": "20 s"},
        "study": {"healthy": {"fit": 1, "test": 1}},
    }), rows)  # fmt: skip


def records_of(rig: ExperimentConfig, rows: list[dict[str, Any]]) -> list[Any]:
    """Records of the machine of a study with these parameters, in order; None of one that failed."""
    left_out = ("study", "name", "baseline", "extends")
    kept = {key: value for key, value in rig.model_dump(exclude_unset=True).items() if key not in left_out}
    keys = dict.fromkeys(key for row in rows for key in row)
    swept = {"zip": {key: [row[key] for row in rows] for key in keys}}
    experiment = load_experiment(kept | {"name": "machine", "sweep": swept})
    source = SimulatedRecords(experiment, "machine", only=range(len(rows)))
    found = {}
    for batch in source.batches():
        found |= {each: batch.rows([row]) for row, each in enumerate(batch.record_ids)}
    return [found.get(each) for each in source.record_ids[: len(rows)]]


def machine(task: tuple[str, int, dict[str, Any], dict[str, float] | None, str]) -> dict[str, Any]:
    """For each set of sensors, the judged records of a machine: fault, size, name → probability, named."""
    loop, number, own, sizes, folder = task
    file = Path(folder, f"{loop}-{'fit' if sizes is None else 'test'}-{number}.pkl")
    if file.exists():
        return pickle.loads(file.read_bytes())  # type: ignore[no-any-return]
    draw = np.random.default_rng(number)
    kinds = faults(own, draw)
    asked = [(HEALTHY, 0.0, {})] * (N_HISTORY + N_HEALTHY)
    for name, (usual, change) in kinds.items():
        for size in [usual * each for each in GRID] if sizes is None else [sizes[name]]:
            asked.append((name, size, change(size)))
    rows = []
    for _, _, change in asked:
        day = {
            "fluid.temperature_rise": draw.uniform(-10.0, 10.0),
            "fluid.temperature_drift": draw.uniform(-0.15, 0.15),
        } | {f"{part}.seed": int(draw.integers(2**31)) for part in ("input", "load", "measurement")}
        rows.append(own | NOTHING | day | {"leakage.law": "orifice"} | change)
    records = simulated(loop, rows)
    done: dict[str, Any] = {}
    for sensors, options in SENSORS.items():
        made = sound_indicator("flow_balance", options).options
        past = records[:N_HISTORY]
        history = history_of(past, made)
        judge, found = Judge(history), []
        for (name, size, _), record in zip(asked[N_HISTORY:], records[N_HISTORY:], strict=True):
            if record is None:
                continue
            (signature,), estimates = signatures(history.balance, record, history.variance)
            findings = judge.judge(signature, estimates.gains[0], estimates.noise[0])
            chances = {each.name: each.probability for each in findings}
            sized = [(each.size, each.size_low, each.size_high) for each in findings if each.name == name]
            deviation = (signature - history.centre) / np.sqrt(np.diag(history.scatter))
            found.append((name, size, chances, findings[0].looks_like, sized, deviation))
        done[sensors] = found
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_bytes(pickle.dumps(done))
    return done


def expected(name: str) -> str:
    return NONE if name.startswith("~") else name


def top(chances: dict[str, float]) -> str:
    return max(chances, key=chances.__getitem__)


def least(done: list[dict[str, Any]], sensors: str) -> dict[str, float]:
    """Fault → the size from which on it is called nine times in ten; infinite if none is."""
    called: dict[str, dict[float, list[bool]]] = {}
    for each in done:
        for place, (name, size, chances, *_) in enumerate(each[sensors]):
            step = (place - N_HEALTHY) % len(GRID)
            if name != HEALTHY:
                called.setdefault(name, {}).setdefault(step, []).append(top(chances) != HEALTHY)
                SIZE[name, step] = size
    found = {}
    for name, steps in called.items():
        shares = [np.mean(steps[step]) >= 0.9 for step in sorted(steps)]
        n_held = int(np.cumprod(shares[::-1]).sum())
        found[name] = SIZE[name, len(GRID) - n_held] if n_held else np.inf
    return found


SIZE: dict[tuple[str, int], float] = {}


def control(
    fit: list[dict[str, Any]], done: list[dict[str, Any]], sensors: str, least: dict[str, float]
) -> str:
    """A linear discriminant on the same numbers, trained on the fit machines, on faults that have names."""
    from sklearn.discriminant_analysis import LinearDiscriminantAnalysis

    def rows(machines: list[dict[str, Any]]) -> tuple[Any, list[str]]:
        known = [
            (np.arcsinh(deviation), name)
            for each in machines
            for name, size, _, _, _, deviation in each[sensors]
            if not name.startswith("~")
            and size >= 0.99 * min(least.get(name, 0.0), SIZE.get((name, 4), np.inf))
        ]
        return np.array([values for values, _ in known]), [name for _, name in known]

    model = LinearDiscriminantAnalysis(solver="lsqr", shrinkage="auto").fit(*rows(fit))
    values, names = rows(done)
    called = model.predict(values)
    right = [one == name for one, name in zip(called, names, strict=True) if name != HEALTHY]
    calm = [one != HEALTHY for one, name in zip(called, names, strict=True) if name == HEALTHY]
    return f"linear discriminant: right {share(right)}; healthy called a fault: {share(calm)}"


def error(chances: list[tuple[float, bool]]) -> float:
    """Expected calibration error of the probabilities of the first names, in ten bins."""
    stated, right = (np.array(column, dtype=float) for column in zip(*chances, strict=True))
    bins = np.minimum((10.0 * stated).astype(int), 9)
    parts = [(bins == each) for each in range(10) if np.any(bins == each)]
    return float(sum(part.mean() * abs(stated[part].mean() - right[part].mean()) for part in parts))


def share(are: list[bool]) -> str:
    low, high = clopper_pearson(sum(are), len(are))
    return f"{100.0 * np.mean(are):.1f} ({100.0 * low:.1f}–{100.0 * high:.1f}) %, {sum(are)} of {len(are)}"


def tables(done: list[dict[str, Any]], sensors: str, sizes: dict[str, float]) -> Iterator[str]:
    """Confusion matrix, rates and reliability of a set of sensors."""
    judged = [row for each in done for row in each[sensors]]
    names = list(dict.fromkeys(name for name, *_ in judged))
    yield f"\n## {sensors}\n"
    yield "| true fault | size | called | right first | named | size in its interval | called instead |"
    yield "|---|---:|---:|---:|---:|---:|---|"
    first, named, unknown, calm, pairs = [], [], [], [], []
    for name in names:
        own = [(chances, alike) for other, _, chances, alike, *_ in judged if other == name]
        called = [top(chances) for chances, _ in own]
        meant = expected(name)
        right = [each == meant for each in called]
        among = [chances.get(meant, 0.0) >= 0.05 or meant in alike for chances, alike in own]
        pairs += [(max(chances.values()), ok) for (chances, _), ok in zip(own, right, strict=True)]
        if name == HEALTHY:
            calm += [not each for each in right]
        elif name.startswith("~"):
            unknown += right
        else:
            first, named = first + right, named + among
        others = {each: called.count(each) for each in dict.fromkeys(called) if each != meant}
        text = ", ".join(f"{each} {n}" for each, n in sorted(others.items(), key=lambda item: -item[1]))
        size = "" if name == HEALTHY else f"{sizes[name]:.3g}"
        holds = [
            low <= true <= high
            for other, true, _, _, sized, _ in judged
            for _, low, high in sized
            if other == name
        ]
        # Sizes of the others are stated in another way than here.
        within = sum(holds) if name not in OTHERWISE and not name.startswith("~") else ""
        found = np.mean([each != HEALTHY for each in called])
        yield (
            f"| {name} | {size} | {100.0 * found:.0f} % | {sum(right)} of {len(right)} | {sum(among)}"
            f" | {within} | {text} |"
        )
    yield f"\nright first: {share(first)}; among the named: {share(named)}"
    yield f"healthy called a fault: {share(calm)}"
    yield f"a fault without a hypothesis called {NONE}: {share(unknown)}"
    yield f"expected calibration error of the first name's probability: {error(pairs):.3f}"
    yield "\n| stated | records | mean | right |\n|---|---:|---:|---:|"
    for low, high in BINS:
        own = [(stated, right) for stated, right in pairs if low <= stated < high]
        if own:
            stated, right = np.mean(own, axis=0)
            yield f"| {low:g} to {min(high, 1):g} | {len(own)} | {stated:.2f} | {right:.2f} |"


def picture(file: str, done: list[dict[str, Any]], loop: str) -> None:
    """Share of right first names over their probability, for each set of sensors."""
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(5.0, 4.4), layout="constrained")
    axes.plot([0.0, 1.0], [0.0, 1.0], color="0.7", linewidth=1.0)
    for sensors in SENSORS:
        rows = [row for each in done for row in each[sensors]]
        pairs = [(max(chances.values()), top(chances) == expected(name)) for name, _, chances, *_ in rows]
        stated, right = (np.array(column, dtype=float) for column in zip(*pairs, strict=True))
        parts = [(stated >= low) & (stated < high) for low, high in BINS]
        points = [(stated[part].mean(), right[part].mean(), part.sum()) for part in parts if part.sum() >= 5]
        x, y, n = np.transpose(points)
        spread = 1.96 * np.sqrt(np.maximum(y * (1.0 - y), 0.25 / n) / n)
        axes.errorbar(x, y, spread, fmt="o-", capsize=3.0, label=sensors, markersize=5.0)
    axes.set(
        xlabel="probability stated for the first name", ylabel="share that is right", title=f"{loop} loop"
    )
    axes.set(xlim=(0.3, 1.02), ylim=(0.0, 1.02))
    axes.legend()
    axes.grid(alpha=0.3)
    figure.savefig(file, dpi=150)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--loop", default="closed", choices=("closed", "open"))
    for name, default in (("fit", 12), ("test", 40), ("workers", 2)):
        parser.add_argument(f"--{name}", type=int, default=default)
    parser.add_argument("--out", default="results/diagnosis")
    parser.add_argument("--figure")
    asked = parser.parse_args()
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    drawn = machines(asked.loop, asked.fit + asked.test)
    with ProcessPoolExecutor(asked.workers) as pool:
        fit = [(asked.loop, number, drawn[number], None, asked.out) for number in range(asked.fit)]
        found = list(pool.map(machine, fit))
        sizes = least(found, "P1 P2 x u")
        largest = {name: max(size for (own, _), size in SIZE.items() if own == name) for name in sizes}
        print(f"hydrofdi {hydrofdi.__version__}, {asked.loop} loop: sizes called nine times in ten")
        print(json.dumps({name: f"{size:.3g}" for name, size in sizes.items()}))
        twice = {name: 2.0 * min(size, largest[name]) for name, size in sizes.items()}
        test = [
            (asked.loop, number, drawn[number], twice, asked.out)
            for number in range(asked.fit, asked.fit + asked.test)
        ]
        done = list(pool.map(machine, test))
    if asked.figure:
        picture(asked.figure, done, asked.loop)
    for sensors in SENSORS:
        for line in tables(done, sensors, twice):
            print(line)
        print(f"\n{control(found, done, sensors, sizes)}")


if __name__ == "__main__":
    main()
