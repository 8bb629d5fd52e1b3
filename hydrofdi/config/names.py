"""Names of parameters: full ones with a dot, symbols of the field, and last parts that are unique."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from functools import cache
from itertools import chain

from hydrofdi.config.request import parameter_names
from hydrofdi.settings.messages import nearest

SYMBOLS = {
    "fluid.bulk_modulus": ("EBM", "ebm", "beta", "beta_e", "β"),
    "leakage.internal_coefficient": ("K_i", "Ki"),
    "leakage.internal_flow": ("q_il", "q_i"),
    "leakage.external_coefficient": ("K_e", "Ke"),
    "supply.pressure": ("P_s", "Ps", "p_s"),
    "supply.return_pressure": ("P_r", "Pr", "p_r"),
    "actuator.mass": ("m", "M"),
    "actuator.piston_area": ("A", "A_1", "A1"),
    "actuator.piston_area_2": ("A_2", "A2"),
    "actuator.chamber_volume": ("V", "V_1", "V1"),
    "actuator.chamber_volume_2": ("V_2", "V2"),
    "actuator.load_stiffness": ("K_ex",),
    "valve.spool_gain": ("k_v",),
    "valve.flow_gain": ("K_v",),
    "valve.area_gradient": ("w",),
    "valve.natural_frequency": ("f_v",),
    "valve.damping_ratio": ("xi", "ξ"),
    "friction.coulomb": ("F_c",),
    "friction.breakaway": ("F_brk",),
    "friction.viscous": ("f",),
    "friction.transition": ("c_v",),
    "friction.velocity_threshold": ("v_th",),
    "input.amplitude": ("U",),
    "input.period": ("T",),
    "control.proportional_gain": ("K_p",),
    "record.sampling_frequency": ("f_s", "fs"),
    "record.step": ("h", "dt"),
}
"""Full name → its symbols in equations and papers; exactly as written, because K_v and k_v differ."""


def full_name(name: str) -> str:
    """The full name that a name, a symbol or a unique last part stands for; any other text as it is."""
    return full_names().get(name, name)


def short_name(full: str) -> str:
    """The first symbol of a parameter, else its last part if it is unique, else the full name."""
    last = full.partition(".")[2]
    return SYMBOLS[full][0] if full in SYMBOLS else last if full_name(last) == full else full


@cache
def full_names() -> dict[str, str]:
    """All that stands for a full name."""
    last = {full: full.partition(".")[2] for full in parameter_names()}
    count = Counter(last.values())
    unique = {part: full for full, part in last.items() if count[part] == 1 and part != "name"}
    spelt = {name.replace(".", "__"): name for name in parameter_names()}
    symbols = {symbol: full for full, own in SYMBOLS.items() for symbol in own}
    in_section = {f"{full.partition('.')[0]}.{symbol}": full for symbol, full in symbols.items()}
    return unique | spelt | in_section | symbols


def meant(name: str, known: Sequence[str] = ()) -> str:
    """The end of a message on a name of no parameter: those that it may stand for, other known ones first."""
    several = [full for full in parameter_names() if full.partition(".")[2] == name]
    if several:
        return f"; write {' or '.join(several[:3])}{' …' * (len(several) > 3)}"
    return nearest(name, [*known, *parameter_names(), *chain(*SYMBOLS.values())]) if len(name) > 1 else ""
