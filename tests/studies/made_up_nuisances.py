"""A study of a score made of two nuisances, a leak and noise; a third nuisance does nothing."""

import numpy as np

from hydrofdi.evaluation.scores import NOTHING, Kind, Population
from hydrofdi.studies.records import Scored, StudyRecords

BULK, FRICTION, IDLE = NAMES = ("fluid.bulk_modulus", "friction.scale", "supply.pressure")
NOISE = 0.2
LITRES_PER_MINUTE = 1e-3 / 60.0


class Study:
    """Records of a score 3 x₁ + x₂ + 0 x₃ + noise + 2 lg(leak/1 mL/min), all x uniform about 0."""

    def __init__(self):
        self.draw = np.random.default_rng(3)
        self.populations, self.scores, self.severity = [], [], []

    def add(self, population, x, leak=0.0):
        shift = 2.0 * np.log10(leak / 1e-3) if leak else 0.0
        self.populations += [population]
        self.scores += [3.0 * x[:, 0] + x[:, 1] + shift + NOISE * self.draw.standard_normal(len(x))]
        self.severity += [np.full(len(x), leak * LITRES_PER_MINUTE)]

    def uniform(self, n, *varied):
        x = np.zeros((n, 3))
        for name in varied:
            x[:, NAMES.index(name)] = self.draw.uniform(-0.5, 0.5, n)
        return x

    def records(self):
        order = np.random.default_rng(5).permutation(len(self.populations))
        sizes = [self.scores[place].size for place in order]
        joined = [np.concatenate([part[place] for place in order]) for part in (self.scores, self.severity)]
        own = tuple(self.populations[place] for place in order)
        return StudyRecords(own, np.repeat(np.arange(len(own)), sizes), joined[1]), Scored("score", joined[0])


def study(alone=400, levels=(0.01, 0.1, 1.0)):
    made = Study()
    for is_fit in (True, False):
        made.add(Population("healthy", Kind.HEALTHY, is_fit), made.uniform(1000, *NAMES))
    for level in levels:
        made.add(
            Population(f"{level:g} L/min", Kind.FAULT, False, level * LITRES_PER_MINUTE),
            made.uniform(200, *NAMES),
            level,
        )
    made.add(Population("stiffer", Kind.SHIFT), made.uniform(50, *NAMES) + 9.0)
    if alone:
        for name in NAMES:
            made.add(Population(name, Kind.ALONE), made.uniform(alone, name))
        made.add(Population(NOTHING, Kind.ALONE), made.uniform(alone))
    return made
