"""Which fault a record shows: findings with probabilities, sizes, and what tells them apart."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from hydrofdi.diagnosis.balance import CAUSES
from hydrofdi.diagnosis.history import HealthyMachine, signatures
from hydrofdi.diagnosis.hypotheses import (
    HEALTHY,
    NONE,
    REPAIRS,
    SIZES,
    Evidence,
    Hypothesis,
    Shift,
    hypotheses,
    whitened,
)
from hydrofdi.evaluation.scores import comparable
from hydrofdi.indicators.balancing import P1, P2, X
from hydrofdi.records import Array, Channel, RecordBatch

NAMED = 0.01
"""Least probability of a fault that is named."""

_SENSORS: Mapping[str, Mapping[str, float]] = {
    "supply pressure": {"supply": 2e-3},
    "return pressure": {"return_pressure": 2e4},
    "load force": {"coulomb": 10.0, "force": 50.0},
    "a second gauge on chamber 1": {"bias_1": 1e4, "gain_1": 1e-3},
    "a second gauge on chamber 2": {"bias_2": 1e4, "gain_2": 1e-3},
    "a second position sensor": {"position_gain": 1e-3},
    "spool position": {"flow_gain": 5e-3},
    "an oil sample (air, bulk modulus)": {"free_air": 1e-3},
}
"""What can be measured in addition → quantities that it states, and their errors in SI."""


_SIZE = 0.85
"""Error of a size over the error of its direction: sizes of leaks were 0.5 to 1.4 of the true ones on twelve
machines of real-rig."""

_STRANGE = 0.01
"""Probability with which a healthy history has a record that counts as unlike the others."""

_MOST_SEEN = 12.5
"""Size over the usual one from which on half of the faults must be seen: a leak of 37 % of the flow."""

_TOLD_APART = 2.0 * np.log(20.0)
"""Squared distance at which one fault is expected to be twenty times as likely as the other."""


@dataclass(frozen=True)
class Finding:
    """A hypothesis after a record was seen.

    Attributes
    ----------
    name, title, unit, advice : str
    probability, low, high : float
        With its range if the healthy scatter is as small or large as its 95 % interval allows.
    size, size_low, size_high : float
        Estimate of the size and its 95 % interval, in `unit`; NaN if it has none.
    visible : float
        Size from which on most of its forms would be seen, in `unit`; infinite if no size would, NaN if it
        has none.
    looks_like : tuple of str
        Other faults that the sensors would not tell from it at this size; of none of these, the nearest one.
    told_by : mapping of str to str
        Such a fault → what to measure to tell it apart; missing if nothing that is known does.
    """

    name: str
    title: str
    unit: str
    advice: str
    probability: float
    low: float
    high: float
    size: float = float("nan")
    size_low: float = float("nan")
    size_high: float = float("nan")
    visible: float = float("nan")
    looks_like: tuple[str, ...] = ()
    told_by: Mapping[str, str] = field(default_factory=dict)


class Judge:
    """States probabilities of faults of records with one history."""

    def __init__(self, history: HealthyMachine) -> None:
        self.history = history
        self.hypotheses = hypotheses(history)

    def stranger(self) -> tuple[int, Judge, Finding] | None:
        """The record of the history that differs most, what the others judge it to be, and these; None if it
        is like them."""
        from scipy.stats import f

        seen, gains, noises = self.history.seen
        white, _ = whitened(self.history.scatter, seen - self.history.centre)
        row = int(np.argmax(comparable(np.sum(white**2, axis=1))))
        history = self.history.without(row)
        own, _ = whitened(history.scatter_of(noises[row]), (seen[row] - history.centre)[None])
        others = Judge(history)
        findings = others.judge(seen[row], gains[row], noises[row])
        # The mean square of a Student vector is distributed as F, and any of the records may be this one.
        chance = len(seen) * float(f.sf(np.mean(own**2), own.size, history.dof))
        if chance > _STRANGE or not findings or findings[0].name == HEALTHY:
            return None
        return row, others, findings[0]

    def findings(self, record: RecordBatch) -> list[Finding]:
        """Findings on one record, the most probable first; none if no fault could be seen."""
        history = self.history
        (own,), estimates = signatures(history.balance, record, history.variance)
        gain, noise = estimates.gains[0], estimates.noise[0]
        findings = self.judge(own, gain, noise)
        if not findings or findings[0].name == HEALTHY:
            return findings
        # A recording that is wired wrongly is undone exactly; only then is it worth the time.
        repaired = {
            name: signatures(history.balance, other, history.variance)[0][0]
            for name, other in self._repaired(record)
        }
        return self.judge(own, gain, noise, repaired)

    def _repaired(self, record: RecordBatch) -> Iterator[tuple[str, RecordBatch]]:
        """The record as it would be without each fault of the recording."""
        balance, channels = self.history.balance, record.channels
        drive = Channel.SPOOL_POSITION if balance.options.spool == "measured" else Channel.INPUT_VOLTAGE
        if balance.both:
            changed = {P1: channels[P2], P2: channels[P1]}
            yield "swapped_pressures", replace(record, channels={**channels, **changed})
        yield "wrong_sign_u", replace(record, channels={**channels, drive: -channels[drive]})
        if balance.options.position_zero == "centre":
            yield "wrong_sign_x", replace(record, channels={**channels, X: -channels[X]})

    def judge(
        self, signature: Array, gain: Array, noise: Array, repaired: Mapping[str, Array] | None = None
    ) -> list[Finding]:
        """Findings, the most probable first; none if most faults could not be seen at any size.

        Parameters
        ----------
        signature : ndarray, shape (n_name,)
            That of the record.
        gain, noise : ndarray, shapes (N, M) and (N, N)
            Gain matrix and expected covariance of its estimates.
        repaired : mapping of str to ndarray, optional
            Name in `REPAIRS` → signature of the repaired record.
        """
        from scipy.stats import chi2

        if not np.all(np.isfinite(signature)):
            return []
        history = self.history
        evidence = Evidence(history, signature - history.centre, history.scatter_of(noise), gain)
        shifts, visible = dict[str, list[Shift]](), dict[str, float]()
        for fault in self.hypotheses:
            bound = evidence.shift(fault, is_free=False)
            shifts[fault.name] = [bound, *([evidence.shift(fault)] if fault.free else [])]
            visible[fault.name] = evidence.visible(bound, fault, len(self.hypotheses))
        if np.median([visible[fault.name] / fault.usual for fault in self.hypotheses]) > _MOST_SEEN:
            return []
        seen = [
            (fault, shifts[fault.name] if np.isfinite(visible[fault.name]) else ())
            for fault in self.hypotheses
        ]
        dof = history.dof
        # The scatter as estimated, and with the ends of its 95 % interval.
        factors = (1.0, *(float(dof / chi2.ppf(share, dof)) for share in (0.975, 0.025)))
        chances = [evidence.probabilities(seen, repaired or {}, factor) for factor in factors]
        # Rounded, so that the order is the same on all processors.
        order = sorted(chances[0], key=lambda name: -comparable(chances[0][name]))
        listed = {fault.name: fault for fault in self.hypotheses}
        findings = list[Finding]()
        for name in order:
            own = [chance[name] for chance in chances]
            if (hypothesis := listed.get(name)) is not None:
                about = hypothesis.title, hypothesis.unit, hypothesis.advice
                finding = Finding(name, *about, own[0], min(own), max(own), visible=visible[name])
                findings.append(self._sized(finding, hypothesis, shifts[name][-1], evidence))
                continue
            title = {HEALTHY: "nothing is wrong", NONE: "none of these"}.get(name) or REPAIRS[name]
            advice = "compare the description of the channels with the wiring" if name in REPAIRS else ""
            alike = (max(shifts, key=lambda other: _cosine(shifts[other][-1])),) if name == NONE else ()
            findings.append(Finding(name, title, "", advice, own[0], min(own), max(own), looks_like=alike))
        return findings

    def _sized(self, finding: Finding, hypothesis: Hypothesis, shift: Shift, evidence: Evidence) -> Finding:
        """A finding with its size, and what looks like it."""
        moved = np.maximum(np.sum(shift.directions**2, axis=1), 1e-30)
        # Least squares along each direction; sizes are not negative.
        sizes = np.maximum(shift.directions @ shift.difference, 0.0) / moved
        # The direction that takes most from the squared distance.
        best = int(np.argmax(sizes**2 * moved))
        size = float(sizes[best])
        if hypothesis.usual * SIZES[-1] * np.sqrt(moved[best]) < 1.0:
            # Not even the largest size moves the record by its deviation.
            return finding
        deviation = float(np.hypot(1.0 / np.sqrt(moved[best]), _SIZE * hypothesis.error * size))
        is_named = finding.probability >= NAMED
        alike, told = self._confusable(hypothesis, best, size if is_named else 0.0, evidence)
        low, high = max(0.0, size - 1.96 * deviation), size + 1.96 * deviation
        return replace(finding, size=size, size_low=low, size_high=high, looks_like=alike, told_by=told)

    def _confusable(
        self, hypothesis: Hypothesis, best: int, size: float, evidence: Evidence
    ) -> tuple[tuple[str, ...], dict[str, str]]:
        """Faults of which some size looks like this one, and what would tell them apart."""
        alike, told = list[str](), dict[str, str]()
        for other in (*self.hypotheses, evidence.unlisted) if size > 0.0 else ():
            if other.name == hypothesis.name:
                continue
            # Both may move what either may move by an unknown amount.
            together = np.vstack((hypothesis.directions[[best]], other.directions))
            both = replace(other, directions=together, free=(*hypothesis.free, *other.free))
            shift = evidence.shift(both)
            mine = size * shift.directions[0]
            # A difference counts over the scatter and the error of the direction.
            errors = np.sqrt(1.0 + hypothesis.error**2 * (mine @ mine) * shift.shares)
            mine, rows = mine / errors, shift.directions[1:] / errors
            factors = np.maximum(rows @ mine, 0.0) / np.maximum(np.sum(rows**2, axis=1), 1e-30)
            left = np.sum((mine - factors[:, None] * rows) ** 2, axis=1)
            nearest = int(np.argmin(left))
            if factors[nearest] == 0.0 or left[nearest] >= _TOLD_APART:
                continue
            alike.append(other.name)
            change = size * hypothesis.directions[best] - factors[nearest] * other.directions[nearest]
            sensor = self._telling(change, float(left[nearest]))
            if sensor:
                told[other.name] = sensor
        return tuple(alike), told

    def _telling(self, change: Array, known: float) -> str:
        """The sensor that tells a change of the true quantities best; empty if none does."""
        scales = np.concatenate((self.history.balance.scales, np.ones(len(change) - len(CAUSES))))
        best, teller = known, ""
        for sensor, errors in _SENSORS.items():
            square = known
            for name, error in errors.items():
                if name in self.history.causes:
                    index = self.history.causes.index(name)
                    square += float(change[index] * scales[index] / error) ** 2
            if comparable(square) > comparable(max(best, _TOLD_APART)):
                best, teller = square, sensor
        return teller


def _cosine(shift: Shift) -> float:
    """Cosine of the angle between a difference and the nearest direction of a fault."""
    lengths = np.linalg.norm(shift.directions, axis=1) * np.linalg.norm(shift.difference)
    return float(comparable(np.max(shift.directions @ shift.difference / np.maximum(lengths, 1e-30))))
