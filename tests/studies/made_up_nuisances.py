"""A study of a score made of two nuisances, a leak and noise; a third nuisance does nothing."""

import numpy as np

from hydrofdi.evaluation.scores import NOTHING, Kind, Population
from hydrofdi.studies.records import Scored, StudyRecords

BULK, FRICTION, IDLE = NAMES = ("fluid.bulk_modulus", "friction.scale", "supply.pressure")
NOISE = 0.2
LITRES_PER_MINUTE = 1e-3 / 60.0


def study(alone=400, levels=(0.01, 0.1, 1.0), wide=1.0):
    """Records of a score 3 x₁ + x₂ + 0 x₃ + noise + 2 lg(leak/1 mL/min), all x uniform about 0.

    With x₁ alone the score is `wide` times as wide.
    """
    draw, parts = np.random.default_rng(3), []

    def add(population, n, varied=NAMES, leak=0.0, scale=1.0):
        x = np.array([draw.uniform(-0.5, 0.5, n) if name in varied else np.zeros(n) for name in NAMES])
        shift = 2.0 * np.log10(leak / 1e-3) if leak else 0.0
        score = scale * (3.0 * x[0] + x[1] + shift + NOISE * draw.standard_normal(n))
        parts.append((population, score, np.full(n, leak * LITRES_PER_MINUTE)))

    for is_fit in (True, False):
        add(Population("healthy", Kind.HEALTHY, is_fit), 1000)
    for level in levels:
        fault = Population(f"{level:g} L/min", Kind.FAULT, severity=level * LITRES_PER_MINUTE)
        add(fault, 200, leak=level)
    add(Population("stiffer", Kind.SHIFT), 50, scale=9.0)
    for name in (*NAMES, NOTHING) if alone else ():
        add(Population(name, Kind.ALONE), alone, (name,), scale=wide if name == BULK else 1.0)
    order = np.random.default_rng(5).permutation(len(parts))
    populations, scores, severity = zip(*(parts[place] for place in order), strict=True)
    of_record = np.repeat(np.arange(len(parts)), [each.size for each in scores])
    records = StudyRecords(populations, of_record, np.concatenate(severity))
    return records, Scored("score", np.concatenate(scores))
