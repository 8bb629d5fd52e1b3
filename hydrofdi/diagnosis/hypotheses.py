"""What may be wrong with a machine, and in which direction each fault moves what is compared."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from hydrofdi.diagnosis.causes import CAUSES, EDGES, GAPS, LEAKS, N_FINE, N_PLACE, OF_EDGES, PLACE, SCORES
from hydrofdi.diagnosis.history import History
from hydrofdi.records import Array


@dataclass(frozen=True)
class Hypothesis:
    """A fault.

    Attributes
    ----------
    name, title, unit : str
        Name in files, what a person calls it, and the SI unit of its size.
    usual : float
        A usual size.
    directions : ndarray, shape (n_direction, n_cause)
        Change of the true causes per size, over their scales; any of them may be true.
    free : tuple of str
        Quantities that it changes by an amount that is not known.
    advice : str
        What to look at.
    error : float
        Error of its direction, in any direction, over its length.
    """

    name: str
    title: str
    unit: str
    usual: float
    directions: Array
    free: tuple[str, ...] = ()
    advice: str = ""
    error: float = 0.3


HEALTHY, NONE = "healthy", "none_of_these"

_LEAKING = "stop the piston, close the valve and watch whether it drifts; plan to replace the seal"
_OUTSIDE = "look for oil at rod seal, fittings and hoses; a worn return edge of the valve looks the same"
_FRICTION = "look at rod guide, seals and alignment"

_NEEDS = {
    "external_2": "external_2", "bias_P2": "bias_2", "gain_P2": "gain_2", "friction_up": "coulomb",
    "friction_down": "coulomb",
}  # fmt: skip
"""Fault → quantity without which nothing shows it."""


def hypotheses(history: History) -> list[Hypothesis]:
    """All faults that the sensors can show."""
    balance, names = history.balance, history.causes
    options, (first, second) = balance.options, balance.options.areas
    at, supply, flow = options.reference_pressure, options.supply_pressure, 0.03 * balance.flow
    opening, modulus, mean = balance.largest_opening, 1.0 / options.bulk_modulus, history.value("pressure")
    friction, leak = 0.01 * supply * min(first, second), 1.0 / np.sqrt(at)
    places = np.interp(np.linspace(0.0, N_PLACE - 1.0, N_FINE), np.arange(N_PLACE), balance.places)
    stroke = (places - places[0]) / (places[-1] - places[0])
    # Flat tops with smooth ends, of any place and some widths; a score is a hole or a gap.
    scores = [
        np.exp(-(((stroke - centre) / half) ** 4))
        for half in (0.06, 0.1, 0.18, 0.3)
        for centre in np.linspace(0.05, 0.95, 13)
    ]
    # Share of one sensor in the mean pressure.
    share = 0.5 if balance.both else 1.0

    def moves(*changes: Mapping[str, float]) -> Array:
        made = np.zeros((len(changes), len(names)))
        for row, change in enumerate(changes):
            for place, name in enumerate(names):
                scale = balance.scales[place] if place < len(CAUSES) else 1.0
                made[row, place] = change.get(name, 0.0) / scale
        return made

    def signs(change: Mapping[str, float]) -> Array:
        return moves(change, {name: -value for name, value in change.items()})

    # Forces per position and speed are over what the sensor shows.
    of_position = {"position_gain": 1.0}
    of_position |= {name: -history.value(name) for name in ("stiffness", "viscous") if name in names}
    # A command that reads too much scales all laps with it; gains of edges are shares of the whole gain.
    of_command = {"flow_gain": 1.0}
    for name in (*OF_EDGES, "gain_by_direction", "gain_by_feeding", "gain_by_chamber"):
        share = history.value(name) * balance.scales[PLACE[name]]
        of_command[name] = -share if name in OF_EDGES else share

    def worn(edge: str, clearance: float) -> dict[str, float]:
        chamber, side = EDGES[edge]
        # Rows of `CONTRASTS` are orthogonal, of length 2, so a quarter of each moves one edge alone.
        parts = {"lap": 1, "offset": side, "lap_by_feeding": chamber * side, "lap_by_chamber": chamber}
        # It also leaks where it is closed: a share of what it feeds more at half the supply pressure.
        leaking = edge.replace("supply ", "feed_").replace("return ", "external_")
        share = clearance * options.flow_gain * options.area_gradient / np.sqrt(0.5 * supply)
        return {name: -0.25 * part for name, part in parts.items()} | {leaking: share}

    def sensor(chamber: int, area: float) -> tuple[Hypothesis, Hypothesis]:
        """Zero and gain of a pressure sensor; the area is positive if the pressure extends."""
        zero = {f"bias_{chamber}": 1.0, "force": area, "pressure": share}
        gain = {f"gain_{chamber}": 1.0, "force": area * mean, "pressure": share * mean}
        name, gauge = f"P{chamber}", f"compare P{chamber} with a gauge"
        return (
            Hypothesis(f"bias_{name}", f"zero of the {name} sensor", "Pa", 0.012 * supply, signs(zero),
                       advice=f"{gauge}, with the pump off"),
            Hypothesis(f"gain_{name}", f"gain of the {name} sensor", "1", 0.02, signs(gain),
                       advice=f"{gauge} under pressure"),
        )  # fmt: skip

    all_ = (
        Hypothesis("seal_orifice", "piston seal (hole)", "m^3/s", flow, moves(dict.fromkeys(LEAKS, leak)),
                   advice=_LEAKING),
        Hypothesis("seal_laminar", "piston seal (gap)", "m^3/s", flow, moves({"laminar": 1.0 / at}),
                   advice=_LEAKING),
        Hypothesis("seal_scored", "scored bore", "m^3/s", flow,
                   moves(*(dict(zip(law, scale * score, strict=True))
                           for law, scale in ((SCORES, leak), (GAPS, 1.0 / at)) for score in scores)),
                   advice="move slowly over the stroke and look where the piston drifts"),
        Hypothesis("external_1", "external leak, chamber 1", "m^3/s", flow, moves({"external_1": 1.0 / at}),
                   ("pressure",), _OUTSIDE),
        Hypothesis("external_2", "external leak, chamber 2", "m^3/s", flow, moves({"external_2": 1.0 / at}),
                   ("pressure",), _OUTSIDE),
        Hypothesis("worn_edge", "worn metering edge", "m", 0.05 * opening,
                   moves(*(worn(edge, share) for edge in EDGES for share in (0.0, 0.3, 1.0))), ("pressure",),
                   "measure the null leakage of the valve"),
        Hypothesis("null_shift", "null shift of the valve", "m", 0.03 * opening, signs({"offset": 1.0}),
                   advice="adjust the null; watch whether it shifts on"),
        Hypothesis("free_air", "free air in the oil", "1", 0.02, moves({"free_air": 1.0}),
                   advice="bleed the cylinder; look at tank level and suction line"),
        # The piston sticks and slips, which no equation of the balance states.
        Hypothesis("friction_up", "more friction", "N", friction, moves({"coulomb": 1.0}),
                   advice=_FRICTION, error=1.0),
        Hypothesis("friction_down", "less friction", "N", friction, moves({"coulomb": -1.0}),
                   advice=_FRICTION, error=1.0),
        Hypothesis("weak_supply", "low supply pressure", "Pa", 0.05 * supply,
                   moves({"supply": -1.0 / supply}), ("pressure",),
                   "read the supply gauge under load; look at pump, relief valve and filter"),
        Hypothesis("raised_return", "high return pressure", "Pa", 0.03 * supply,
                   moves({"return_pressure": 1.0}), ("pressure",), "look at the return filter and line"),
        Hypothesis("stiff_oil", "stiffer oil or hoses", "1", 0.2, moves({"compressibility": -modulus}),
                   advice="another oil, colder oil, or a hose was replaced"),
        Hypothesis("soft_oil", "softer oil or hoses", "1", 0.2, moves({"compressibility": modulus}),
                   advice="warm oil, an ageing hose, or air"),
        *sensor(1, first),
        *sensor(2, -second),
        Hypothesis("gain_x", "gain of the position sensor", "1", 0.02, signs(of_position),
                   advice="measure the stroke by hand"),
        Hypothesis("flow_gain", "gain of valve or command", "1", 0.05, signs(of_command),
                   advice="check the amplifier; compare spool position and command"),
    )  # fmt: skip
    shown = set(names) - (set() if balance.both else {"bias_2", "gain_2", "external_2"})
    return [each for each in all_ if each.name not in _NEEDS or _NEEDS[each.name] in shown]


REPAIRS: Mapping[str, str] = {
    "swapped_pressures": "P1 and P2 are swapped",
    "wrong_sign_u": "the command has the wrong sign",
    "wrong_sign_x": "the position has the wrong sign",
}
"""Fault of the recording that is undone exactly → what a person calls it."""
