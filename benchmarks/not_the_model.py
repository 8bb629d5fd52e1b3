"""Detectors on machines whose physics they do not know: the tables of docs/not-the-model.md.

    python benchmarks/not_the_model.py [--small] [--workers 2] [--out results/not-the-model]
    python benchmarks/not_the_model.py --figure answer.png      # and a picture
    python benchmarks/not_the_model.py --parts

Machines are those of configs/populations/unknown-plant.yaml plus some or all entries of real-rig.yaml, which
states the magnitudes. Equal seeds: the same machines, motions and noise in each row. What is stored in the
folder is not computed again. The first command takes about 20 minutes of a processor, the second about 8.
"""

from __future__ import annotations

import argparse
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import yaml

import hydrofdi
from hydrofdi.evaluation.rates import clopper_pearson

RIG = yaml.safe_load((Path(__file__).parent.parent / "configs/populations/real-rig.yaml").read_text())
POPULATION = RIG["study"]["population"]
DRAWN = {key: how for how in ("over", "per_record") for key in POPULATION[how]}

TIGHT = {
    "over": {"valve.lap_leakage": {"uniform": ["0 m^3/(s*Pa)", "3e-14 m^3/(s*Pa)"]}},
    "stated": {"null_leakage": "0.03 L/min"},
}
ROWS: dict[str, tuple[str, dict[str, Any]]] = {
    "none": ("$", {}), "all": ("", {"stated": {"null_leakage": "0.5 L/min"}}), "all, tight valve": ("", TIGHT)
}  # fmt: skip
"""Row → how the entries of real-rig begin that belong to it; what its machines have instead, and what the
detectors are told."""

NEEDED_BY = {
    "fluid": "fluid.free_air", "friction": "friction", "supply": "supply.droop",
    "measurement": "actuator.hose", "load": "load",
}  # fmt: skip
"""Section of real-rig → how the entries begin that need its settings."""

WEAK, PRESSURE = {"spool": "command", "supply": "sum"}, {"kind": "pressure_balance", "supply": "sum"}
DETECTORS: dict[str, dict[str, Any]] = {
    "`weak_rls` P1 P2 x u": WEAK | {"kind": "weak_rls"},
    "`flow_balance` P1 x u": WEAK | {"kind": "flow_balance", "chambers": 1},
    "`pressure_balance` P1 P2 u": PRESSURE,
    "`pressure_balance` P1 u": PRESSURE | {"chambers": 1, "settling": "0.15 s"},
    "d2 P1": {"kind": "dwt"},
}
LEAKS = [0.01, 0.02, 0.05, 0.1, 0.3, 1.0]
LITRE_PER_MINUTE = 1e-3 / 60.0


def study(name: str, entries: str, healthy: dict[str, int], asked: Any, each: int = 0, **more: Any) -> Any:
    """Runs of machines that have the entries of real-rig whose names begin like this.

    ``score`` rises with a leak: the flow of K_i and that of any law with the clearance of the valve, both at
    8 MPa [L/min], or minus d2 [Pa] twice; ``wrong``: K_i differs from 0 by more than 3 deviations;
    ``covered``: the true mean flow is within 2 deviations of its estimate; ``ratio``: of the estimate to that
    flow; ``gap``: the leak is laminar over the whole stroke.
    """
    own = [key for key in DRAWN if re.match(entries, key)]
    # The closed loop has a force of its own.
    needed = [section for section, start in NEEDED_BY.items() if any(key.startswith(start) for key in own)]
    needed = [section for section in needed if section != "load" or name.startswith("open")]
    drawn = {how: {key: POPULATION[how][key] for key in own if DRAWN[key] == how} for how in POPULATION}
    population = {how: drawn[how] | more.get(how, {}) for how in drawn} | {"seed": 2027}
    plan = {"population": population, "healthy": healthy, "shifts": more.get("shifts", {})}
    if each:
        plan["faults"] = {"leakage.internal_flow": [f"{a} L/min" for a in LEAKS], "each": each, "fit": 0}
    experiment = {section: RIG[section] for section in needed if section in RIG} | {
        "name": "run", "extends": ["populations/unknown-plant.yaml", f"motions/{name.split()[0]}-loop.yaml"],
        "study": plan, "indicators": {
            f"i{k}": options | (more.get("stated", {}) if k < 4 else {})
            for k, options in enumerate(DETECTORS.values())
        },
        "record": {"duration": more.get("duration", "20 s")},
    }  # fmt: skip
    folder = Path(asked.out, re.sub(r"\W+", "-", f"{name} {json.dumps(healthy | {'each': each})}"))
    engine: dict[str, Any] = {"engine": "in-process"} if asked.workers == 1 else {"workers": asked.workers}
    runs = hydrofdi.sweep(experiment, out=folder, **engine, progress=True).dataset

    def values(name: str) -> Any:
        return np.array([runs[f"i{k}.{name}"].values for k in range(4)])

    coefficient, mean = values("internal_coefficient"), runs.mean_internal_leakage_flow.values
    flows = [values(output) / LITRE_PER_MINUTE for output in ("leakage", "cross_port_leakage")]
    law, width = (
        runs[key].values if key in runs else None for key in ("leakage_law", "leakage_scored_width")
    )
    found = {
        "score": np.array([np.vstack([flow, -runs["i4.d2"].values]) for flow in flows]),
        "wrong": np.abs(coefficient) > 3.0 * values("internal_coefficient_error"),
        "covered": np.abs(values("mean_leakage") - mean) <= 2.0 * values("mean_leakage_error"),
        "ratio": values("mean_leakage") / np.where(mean > 0.0, mean, np.nan),
        "gap": np.zeros(mean.size, bool) if law is None else (law.astype(str) == "laminar") & (width > 0.5),
    }
    dims = {"score": ("alarm", "detector", "run"), "gap": ("run",)}
    usual = ("balance", "run")
    return runs.assign({name: (dims.get(name, usual), each) for name, each in found.items()})


def of(runs: Any, kind: str, fit: bool = False) -> Any:
    return runs.isel(run=(runs.population_kind == kind).values & (runs.is_fit == fit).values)


def limits(scores: Any) -> Any:
    """Limit of each alarm that one new record in two hundred exceeds, or the largest score of fewer."""
    return np.sort(np.nan_to_num(scores, nan=-np.inf), axis=2)[:, :, [-max(1, (scores.shape[2] + 1) // 200)]]


def beyond(runs: Any, limit: Any) -> Any:
    """Whether one of both alarms is raised, (n_detector, n_run)."""
    return np.any(runs.score.values > limit, axis=0)


def rates(are: Any) -> list[str]:
    """Percentages of each detector with their 95 % intervals."""
    ends = [(np.mean(row), *clopper_pearson(int(np.sum(row)), len(row))) for row in np.asarray(are)]
    return ["{:.0f} ({:.0f}–{:.0f})".format(*(100.0 * end for end in each)) for each in ends]


def smallest(alarms: Any, flow: Any) -> list[str]:
    """Smallest tested leak of each detector from which on each leak is found nine times in ten [L/min]."""
    # A leak is as large as its mean flow in the record, and counts for the tested leak that is nearest.
    factor = np.abs(np.log(flow[:, None] / LITRE_PER_MINUTE / LEAKS))
    near = (factor == factor.min(axis=1, keepdims=True)) & (factor < np.log(2.0))
    found, holds = np.full(len(alarms), np.nan), np.ones(len(alarms), bool)
    for size, each in zip(reversed(LEAKS), near.T[::-1], strict=True):
        if each.any():
            holds &= alarms[:, each].mean(axis=1) >= 0.9
            found[holds] = size
    return ["–" if np.isnan(each) else f"{'≤' * int(each == LEAKS[0])}{each:g}" for each in found]


def sizes_of(alarms: Any, *leaking: Any) -> list[list[str]]:
    """`smallest` hole or score, and gap."""
    names = "mean_internal_leakage_flow", "gap"
    flow, gap = (np.hstack([each[name].values for each in leaking]) for name in names)
    return [smallest(alarms[:, kind], flow[kind]) for kind in (~gap, gap)]


def joined(*columns: list[str]) -> list[str]:
    return [" / ".join(cells) for cells in zip(*columns, strict=True)]


def table(title: str, rows: dict[str, list[str]], columns: list[str]) -> None:
    lines = [[title, *columns], ["---"] * (len(columns) + 1), *([row, *cells] for row, cells in rows.items())]
    print("", *(f"| {' | '.join(cells)} |" for cells in lines), sep="\n", flush=True)


FOUND: dict[tuple[str, str], list[str]] = {}
"""Loop, and where limits and machines come from → smallest leak found by each detector [L/min]."""


def picture(file: str) -> None:
    """Draw the smallest leaks of `FOUND`: one row for each detector, one mark for each loop and origin."""
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(8.0, 4.2), layout="constrained")
    marks = {"mild": ("o", "data sheet, mild machines"), "rig": ("s", "data sheet, real rig"),
             "tight": ("^", "the same, tight valve"),
             "own": ("D", "own history, real rig")}  # fmt: skip
    for (loop, origin), cells in FOUND.items():
        place = np.arange(len(cells)) + 0.1 * ((loop == "closed") * 4 + [*marks].index(origin) - 3.5)
        leaks = np.array([3.0 if cell == "–" else float(cell.lstrip("≤")) for cell in cells])
        colour, (mark, text) = "C0" if loop == "open" else "C1", marks[origin]
        axes.plot(leaks, place, mark, color=colour, markersize=6, label=f"{text}, {loop} loop")
    axes.set(xscale="log", xlim=(0.007, 4.5), xlabel="smallest hole or score found nine times in ten [L/min]")
    axes.set_xticks([0.01, 0.03, 0.1, 0.3, 1.0, 3.0], ["≤ 0.01", "0.03", "0.1", "0.3", "1", "none\nup to 1"])
    axes.set_yticks(range(len(DETECTORS)), [name.replace("`", "") for name in DETECTORS])
    axes.invert_yaxis()
    axes.grid(axis="x", alpha=0.3)
    axes.minorticks_off()
    figure.legend(loc="outside lower center", ncols=2, fontsize=8)
    figure.savefig(file, dpi=150)


def fleets(loop: str, asked: Any) -> dict[str, Any]:
    """Table of a loop: limits from the mild fleet and from that of the row. Returns the runs."""
    runs = {
        row: study(
            f"{loop} {row}", entries, {"fit": asked.fit, "test": asked.healthy}, asked, asked.leaking, **more
        )
        for row, (entries, more) in ROWS.items()
    }
    alarms, numbers = {}, {}
    own = {row: limits(of(each, "healthy", True).score.values) for row, each in runs.items()}
    for row, each in runs.items():
        healthy, leaking = of(each, "healthy"), of(each, "fault")
        sizes = sizes_of(beyond(leaking, own[row]), leaking)
        alarms[row] = joined(rates(beyond(healthy, own["none"])), rates(beyond(healthy, own[row])), *sizes)
        FOUND[loop, {"none": "mild", "all": "rig"}.get(row, "tight")] = sizes[0]
        in_litres = own[row][:, :, 0] * np.array([1e3] * 4 + [-1e-3])
        alarms[f"limits of {row} [mL/min; d2: kPa]"] = [
            f"{of_k:.3g} / {of_all:.3g}" for of_k, of_all in in_litres.T
        ]
        large = leaking.ratio.values[:, leaking.mean_internal_leakage_flow.values > 0.1 * LITRE_PER_MINUTE]
        ends = zip(*np.nanquantile(large, (0.1, 0.9), axis=1), strict=True)
        shown = [f"{low:.2f} to {high:.2f}" for low, high in ends]
        numbers[row] = joined(rates(healthy.wrong.values), rates(leaking.covered.values), shown)
    table(f"{loop} loop, alarms", alarms, [*DETECTORS])
    table(f"{loop} loop, estimates", numbers, [*DETECTORS][:4])
    return runs


def histories(loop: str, fleet: dict[str, Any], asked: Any) -> None:
    """Table of a loop: the limit is the largest of 110 healthy windows of the same machine.

    It is also raised by what warmer oil adds to the flow through clearances, as `hydrofdi.train` does.
    """
    rows = {}
    # Oil that is 15 K warmer adds 0.6 of the flow through clearances; K_i takes up a share of it.
    taken_up = np.array([[0.1, 0.1, 0.6, 0.6, 0.0], [1.0, 1.0, 1.0, 1.0, 0.0]])
    for row, warmer in (("all", 0.0), ("all", 0.6)):
        machines, (entries, more) = of(fleet[row], "healthy"), ROWS[row]
        keys = json.loads(machines.attrs["configuration"])["study"]["population"]["over"]
        columns = {
            key: name if (name := key.replace(".", "_")) in machines else key.split(".")[1] for key in keys
        }
        alarms: dict[str, list[Any]] = {"healthy": [], "shift": [], "fault": []}
        leaking = []
        for m in range(asked.machines):
            # Each leak has its own law.
            own_keys = [key for key in columns if not key.startswith("leakage.")]
            values = {key: machines[columns[key]].values[m].item() for key in own_keys}
            stiffer = 1.25 * values["fluid.bulk_modulus"]
            one = {
                "over": {key: {"choice": [value]} for key, value in values.items()},
                "per_record": {"fluid.temperature_rise": {"uniform": "±10 K"}}, "duration": "10 s",
                "shifts": {"warm": {"fluid.temperature_rise": "15 K", "fluid.bulk_modulus": stiffer}},
            }  # fmt: skip
            sizes = {"fit": 110, "test": 24, "shift": 24}
            runs = study(f"{loop} own {row} {m}", entries, sizes, asked, asked.own, **more | one)
            own = of(runs, "healthy", True).score.values
            high = np.nan_to_num(own, nan=-np.inf).max(axis=2)
            high += warmer * taken_up * np.maximum(np.nanmedian(own[1], axis=1), 0.0)
            for kind, found in alarms.items():
                found.append(beyond(of(runs, kind), high[:, :, None]))
            leaking.append(of(runs, "fault"))
        inside, outside, leaks = (np.hstack(found) for found in alarms.values())
        sizes = sizes_of(leaks, *leaking)
        FOUND[loop, "own"] = sizes[0]
        rows[f"{row}, limit raised" if warmer else row] = joined(rates(inside), rates(outside), *sizes)
    table(f"{loop} loop, own history", rows, [*DETECTORS])


def parts(asked: Any) -> None:
    """Table of paired changes of the estimate [mL/min]: mean (deviation over machines)."""
    part_of = {
        key: re.match(r".*\.(droop|ripple|position|hose)|.*", key)[0]
        for key in DRAWN
        if "leakage." not in key
    }
    rows, small = {}, []
    sizes = {"fit": 1, "test": asked.pairs}
    before = [
        of(study(f"{loop} part none", "$", sizes, asked), "healthy").score for loop in ("open", "closed")
    ]
    keys = {
        part: [key for key in part_of if part_of[key] == part] for part in dict.fromkeys(part_of.values())
    }
    for part, own in (keys | {"all": [*part_of]}).items():
        entries, cells = "|".join(f"{re.escape(key)}$" for key in own), []
        for loop, reference in zip(("open", "closed"), before, strict=True):
            after = of(study(f"{loop} part {part}", entries, sizes, asked), "healthy").score
            cells += [(1e3 * (after - reference)).values[0, k] for k in (0, 1)]
        if max(np.sqrt(np.mean(cell**2)) for cell in cells) < 1.5:
            small.append(part)
        else:
            rows[f"`{part}`"] = [f"{np.mean(cell):+.1f} ({np.std(cell, ddof=1):.1f})" for cell in cells]
    kinds = [*DETECTORS][:2]
    table("entry", rows, [f"{kind}, {loop}" for loop in ("open", "closed") for kind in kinds])
    print("\nChanges below 1.5 mL/min (RMS):", ", ".join(f"`{part}`" for part in small))


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--small", action="store_true", help="a quick try")
    parser.add_argument("--parts", action="store_true", help="one entry at a time")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out", default="results/not-the-model")
    parser.add_argument("--figure", help="file of a picture of the smallest leaks")
    asked = parser.parse_args()
    sizes = {"fit": 199, "healthy": 100, "leaking": 12, "machines": 1, "own": 6, "pairs": 4}
    few = {"fit": 6, "healthy": 4, "leaking": 3, "machines": 1, "own": 1, "pairs": 2}
    vars(asked).update(few if asked.small else sizes)
    if asked.parts:
        parts(asked)
        return
    fleet = {loop: fleets(loop, asked) for loop in ("open", "closed")}
    for loop, runs in fleet.items():
        histories(loop, runs, asked)
    if asked.figure:
        picture(asked.figure)


if __name__ == "__main__":
    main()
