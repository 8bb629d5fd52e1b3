"""How often `train` names the constant of a data sheet that is wrong: the figures of docs/not-the-model.md.

    python benchmarks/wrong_sheet.py [--each 3] [--right 8] [--out results/wrong-sheet]

The machine of the paper with all entries of real-rig, and the ready machines with valves, supplies, hoses and
sensors that differ as much; a healthy record of another machine for each wrong number. About ten minutes.
"""

from __future__ import annotations

import argparse
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import yaml

import hydrofdi
from hydrofdi.api.sources import open_records
from hydrofdi.indicators.estimation.whole_record import likeliest_wrong
from hydrofdi.indicators.selection import make_indicators, of_machine

CONFIGS = Path(__file__).parent.parent / "configs"
PAPER = {"kind": "flow_balance", "spool": "command", "supply": "sum", "null_leakage": "0.5 L/min"}
MACHINES = ("paper open", "paper closed", "crane-boom", "rudder", "servo-press", "flight-actuator")
FACTORS = {
    "piston_area": (1.25, 3), "piston_area_2": (1.2, 2.5), "flow_gain": (1.25, 3),
    "supply_pressure": (1.2, 1.6), "chamber_volume": (1.5, 4), "chamber_volume_2": (1.5, 4),
    "natural_frequency": (2, 6),
}  # fmt: skip
"""Constant → how many times too large or too small it is."""


def experiment(machine: str, n: int) -> dict[str, Any]:
    """Healthy records of `n` machines."""
    plan = {
        "population": {"seed": 12}, "healthy": {"fit": 1, "test": n}, "shifts": {},
        "faults": {"leakage.internal_flow": ["1 L/min"], "each": 1, "fit": 0},
    }  # fmt: skip
    if machine.startswith("paper"):
        base = ["populations/real-rig.yaml", f"motions/{machine.split()[1]}-loop.yaml"]
        return {"name": "run", "extends": base, "study": plan, "indicators": {"b": PAPER}}
    sheet = yaml.safe_load((CONFIGS / f"machines/{machine}.yaml").read_text())
    pressure = 1e5 * float(sheet["supply"]["pressure"].split()[0])
    volume = float(sheet["actuator"]["chamber_volume"].split()[0])
    flow = float(sheet["study"]["faults"]["leakage.internal_flow"]["logspace"][1].split()[0]) / 0.03 / 60e3

    def drop(low: float, high: float) -> dict[str, list[str]]:
        return {"uniform": [f"{share * pressure / flow:.3g} Pa*s/m^3" for share in (low, high)]}

    channels = ("pressure_1", "pressure_2", "position", "voltage")
    edges = [f"{kind}_{chamber}_edge" for kind in ("supply", "return") for chamber in (1, 2)]
    over = {
        "friction.pressure_slope": {"uniform": ["1 %/MPa", "5 %/MPa"]},
        "valve.edge_rounding": {"uniform": ["1 µm", "4 µm"]}, "valve.gain_slope": {"normal": "±0.015 %/µm"},
        **{f"{edge}.lap": {"uniform": "±2.2 µm"} for edge in edges},
        **{f"{channel}_sensor.delay": {"uniform": ["0 ms", "2 ms"]} for channel in channels},
        "supply.droop_resistance": drop(0.002, 0.015), "supply.return_resistance": drop(0.002, 0.01),
        "actuator.hose_volume": {"uniform": [f"{share * volume:.3g} cm^3" for share in (0.1, 0.25)]},
        "actuator.hose_modulus": {"uniform": ["300 MPa", "500 MPa"]},
        "actuator.hose_resistance": drop(0.003, 0.012),
        "actuator.hose_inertance": {"uniform": ["5e6 kg/m^4", "2e7 kg/m^4"]},
    }  # fmt: skip
    plan["population"] |= {"over": over}
    return {
        "name": "run", "extends": [f"machines/{machine}.yaml"], "study": plan,
        "measurement": {"pressures_at": "valve"}, "supply": {"droop": "first_order"},
        "friction": {"velocity_threshold": "3 mm/s"},
    }  # fmt: skip


def main() -> None:
    """Print how many of each wrong constant are named."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--each", type=int, default=3)
    parser.add_argument("--right", type=int, default=8)
    parser.add_argument("--out", default="results/wrong-sheet")
    asked = parser.parse_args()
    draw, counts = np.random.default_rng(5), Counter[tuple[str, str]]()
    for machine in MACHINES:
        folder = Path(asked.out, machine.replace(" ", "-"))
        wanted = experiment(machine, 24) | {"store": {"signals": "all"}}
        runs = hydrofdi.sweep(wanted, out=folder, workers=2, progress=True).dataset
        (source,) = open_records(folder)
        given = PAPER
        if not machine.startswith("paper"):
            sheet = yaml.safe_load((CONFIGS / f"machines/{machine}.yaml").read_text())
            given = sheet["indicators"]["flow_balance"] | {"kind": "flow_balance"}
        options = of_machine(make_indicators({"b": given}), [source])["b"].options
        rows = [each.rows([row]) for each in source.batches() for row in range(each.n_record)]
        healthy = [rows[place] for place in np.flatnonzero(runs.population_kind.values == "healthy")]
        used = [name for name in FACTORS if getattr(options, name)]
        used = [name for name in used if name != "supply_pressure" or options.supply == "nominal"]
        for k, name in enumerate([""] * asked.right + used * asked.each):
            changed = options
            if name:
                factor = np.exp(draw.uniform(*np.log(FACTORS[name]))) ** draw.choice((-1, 1))
                changed = options.model_copy(update={name: getattr(options, name) * factor})
            found = [each.name for each in likeliest_wrong(changed, healthy[k % len(healthy)])]
            what = "none" if not found else "right" if name in found else "wrong"
            counts[name or "right sheet", what] += 1
    for name in ("right sheet", *FACTORS):
        of = {what: counts[name, what] for what in ("right", "wrong", "none")}
        print(f"{name}: named {', '.join(f'{what} {count}' for what, count in of.items())}")


if __name__ == "__main__":
    main()
