"""Studies with known truth: synthetic healthy scores are standard normal, and rise with the severity."""

import numpy as np

from hydrofdi.config import load_experiment
from hydrofdi.engine import InProcessEngine
from hydrofdi.evaluation.scores import Direction, Kind, Population
from hydrofdi.execution.sweeping import run_sweep
from hydrofdi.store.results import read_results
from hydrofdi.studies.records import Scored, StudyRecords

FIT = Population("healthy (fit)", Kind.HEALTHY, is_fit=True)
PILOT = Population("pilot", Kind.FAULT, is_fit=True, severity=0.5)
TEST = Population("healthy", Kind.HEALTHY)
STIFFER = Population("stiffer", Kind.SHIFT)
WORN = Population("worn", Kind.CONFUSION)
LEVELS = tuple(Population(f"{level:.3g}", Kind.FAULT, severity=level) for level in np.geomspace(0.01, 1.0, 9))


def study(sizes, spread=0.02):
    """Records of populations → their number, with true severities around the nominal ones."""
    of_record = np.repeat(np.arange(len(sizes)), list(sizes.values()))
    nominal = np.array([population.severity for population in sizes])[of_record]
    true = nominal * np.exp(np.random.default_rng(0).normal(0.0, spread, of_record.size))
    return StudyRecords(tuple(sizes), of_record, true, "1")


def usual(healthy=1000, each=100):
    sizes = {FIT: healthy, PILOT: 100, TEST: healthy, **dict.fromkeys(LEVELS, each), STIFFER: 500, WORN: 500}
    return study(sizes)


def rising(records, slope=3.0, half=0.1, seed=1, name="rising", direction=Direction.RISING, **more):
    """A score whose distance to health is `slope` for each decade of severity above half of `half`, or 0.

    With a threshold at 2.33 about half of the records at `half` are detected where `slope` is 2.33/lg 2.
    """
    draw = np.random.default_rng(seed)
    with np.errstate(divide="ignore"):
        rise = np.maximum(np.log10(records.severity / half) * slope + 2.33, 0.0)
    values = draw.normal(size=rise.size) + rise
    return Scored(name, values, direction=direction, **more)


def stored(folder, text, *settings):
    """Results of a study that is written into a folder and computed there."""
    (folder / "study.yaml").write_text(text)
    run_sweep(load_experiment(folder / "study.yaml", settings), folder / "results", InProcessEngine())
    return read_results(folder / "results")


def rows(table, kind, *, is_fit=False, **known):
    """Runs of the first design in the population of a kind that is `known` by its name or severity."""
    wanted = {"kind": kind, "is_fit": is_fit, **known}.items()
    (number,) = (
        place
        for place, each in enumerate(table.study.populations)
        if all(getattr(each, name) == value for name, value in wanted)
    )
    return np.flatnonzero((table.study.of_run == number) & (table.study.design_of_run == 0))


def drawn(table, parameter, kind, **known):
    return np.array(table.runs.values(parameter))[rows(table, kind, **known)]
