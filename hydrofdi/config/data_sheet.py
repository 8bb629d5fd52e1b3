"""The data sheet of a cylinder with its valve and oil, the numbers that follow from it, and their commented
experiment file.
"""

from __future__ import annotations

import math
import re
import shlex
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, model_validator

from hydrofdi.config.loading import load_experiment
from hydrofdi.physics.cylinder import STANDARD_GRAVITY
from hydrofdi.physics.fluid import COOLING, KELVIN, OILS, Oil
from hydrofdi.physics.hydraulic_mode import steady_speed
from hydrofdi.physics.valve import clearance_conductance
from hydrofdi.records.data_sheet import StatedMachine, data_sheet_lines
from hydrofdi.settings import quantities as usual
from hydrofdi.settings.files import Source, parse_yaml, ready_folder, scalar, validated
from hydrofdi.settings.files import plain as plain_data
from hydrofdi.settings.messages import convert, plain
from hydrofdi.settings.quantities import SI, Section
from hydrofdi.units import parse_quantity

_VALVE = re.compile(r"(.+?)\s*(?:at|@)\s*(.+?)(?:\s+per edge)?")
_RANGE = re.compile(r"(.+?)\s*to\s*(.+)")
_HOSE = re.compile(r"(.+?)\s*[x×]\s*(.+)")

LENGTH = SI("m", above=0, usual=("1 mm", "20 m"))


def _pair(text: str, form: re.Pattern[str], units: tuple[str, str], what: str) -> tuple[float, float]:
    """Two quantities above zero of a text such as ``2 m x 12 mm``."""
    match = form.fullmatch(text.strip())
    if match is None:
        raise ValueError(f"{text!r} is not {what}")
    first, second = (parse_quantity(part, unit) for part, unit in zip(match.groups(), units, strict=True))
    if not (first > 0.0 and second > 0.0):
        raise ValueError(f"{text!r} must be above zero")
    return first, second


def valve_rating(text: str) -> tuple[float, float]:
    """Flow [m³/s] and pressure drop over both edges [Pa] of a text such as ``40 L/min at 70 bar``."""
    what = (
        "a rated flow; write it like '40 L/min at 70 bar', the drop over both metering edges together,"
        " or like '40 L/min at 35 bar per edge'"
    )
    flow, drop = _pair(text, _VALVE, ("m^3/s", "Pa"), what)
    drop *= 2.0 if text.strip().endswith("per edge") else 1.0
    if not 5e5 <= drop <= 350e5:
        raise ValueError(f"{text!r}: valves are rated at 5 to 350 bar over both metering edges")
    return flow, drop


def pressure_range(text: str) -> tuple[float, float]:
    """Lowest and highest pressure [Pa] of a text such as ``2 bar to 6 bar``."""
    low, high = _pair(text, _RANGE, ("Pa", "Pa"), "a range; write it like '2 bar to 6 bar'")
    if low >= high:
        raise ValueError(f"{text!r} must rise")
    return low, high


def hose_size(text: str) -> tuple[float, float]:
    """Length and inner diameter [m] of a text such as ``2 m x 12 mm``; both 0 of an empty one."""
    if not text:
        return 0.0, 0.0
    length, diameter = _pair(text, _HOSE, ("m", "m"), "a hose; write it like '2 m x 12 mm'")
    if diameter > 0.1:
        raise ValueError(f"{text!r}: hoses have inner diameters up to 100 mm")
    return length, diameter


_SPELLINGS = {
    "ISOVG": "HLP", "VG": "HLP", "HM": "HLP", "HV": "HVLP", "MILPRF5606": "MILH5606", "H515": "MILH5606",
}  # fmt: skip
"""Other names, of ISO 6743-4 and of specifications, without spaces → the own one."""


def named_oil(text: str) -> Oil:
    """The oil of a name such as ``HLP 46``, or of three numbers of its data sheet."""
    name = re.sub(r"[\s_-]+", "", text).upper()
    # The lookbehind keeps the number of a specification, such as H515, which is no viscosity grade.
    stem = re.sub(r"(?<![\dH])\d+$", "", name)
    name = _SPELLINGS.get(name, _SPELLINGS.get(stem, stem) + name[len(stem) :])
    for known, oil in OILS.items():
        if name == known.replace("-", ""):
            return oil
    parts = text.split(",")
    if len(parts) == 3:
        units = ("m^2/s", "m^2/s", "kg/m^3")
        cold, hot, density = (parse_quantity(part, unit) for part, unit in zip(parts, units, strict=True))
        if not cold > hot > 1e-6 or density <= 0.0:
            raise ValueError(f"{text!r}: the oil must be thinner at 100 than at 40 °C, and above 1 mm²/s")
        return Oil(text, cold, hot, density)
    raise ValueError(
        f"{text!r} is not a known oil; known are {', '.join(OILS)}; or give its viscosities at 40 and 100"
        " °C and its density at 15 °C: '46 mm²/s, 6.8 mm²/s, 877 kg/m³'"
    )


def _checked(parse: Any) -> AfterValidator:
    """Check a text, which stays as it is written."""
    return AfterValidator(lambda text: (parse(text), text)[1])


HOSE_MODULUS, DEAD_SHARE, RATED_VOLTAGE, TRAVEL, STEP = 400e6, 0.05, 10.0, 220e-6, 1e-4
"""Guesses of oil and wall of a hose [Pa] and of the dead volume over the swept one [-]; the voltage [V] and
the travel [m] of the rated flow; and the Runge-Kutta step [s].
"""


class CylinderSheet(Section):
    """Numbers of a data sheet; chamber 1 is on the bore side."""

    bore: Annotated[float, LENGTH]
    """Bore of the cylinder, e.g. '50 mm' [m]."""

    rod: Annotated[float, LENGTH]
    """Diameter of the rod [m]."""

    stroke: Annotated[float, LENGTH]
    """Full stroke [m]."""

    supply: Annotated[float, SI("Pa", above=0, most=2e8, usual=usual.SUPPLY_PRESSURE)]
    """Supply pressure [Pa]."""

    valve: Annotated[str, _checked(valve_rating)]
    """Rated flow of the valve and its pressure drop over both metering edges, e.g. '40 L/min at 70 bar', or
    over one, '40 L/min at 35 bar per edge'."""

    mass: Annotated[float, SI("kg", above=0, usual=("10 g", "100000 kg"))]
    """Moved mass: piston, rod and load [kg]."""

    oil: Annotated[str, _checked(named_oil)] = "HLP46"
    """Oil: HLP or HVLP with 22, 32, 46 or 68 (ISO VG), MIL-H-5606, or its viscosities at 40 and 100 °C and
    its density: '46 mm²/s, 6.8 mm²/s, 877 kg/m³'."""

    air: Annotated[float, SI("1", above=0, most=0.2)] = 0.01
    """Volume of free air over that of the oil at atmospheric pressure [-]."""

    temperature: Annotated[float, SI("K", least=230, most=400)] = 318.15
    """Temperature of the oil, by default '45 °C' [K]."""

    valve_frequency: Annotated[float, SI("Hz", above=0, usual=("1 Hz", "10 kHz"))] = 80.0
    """Frequency at which the spool lags by 90°, by default '80 Hz' [Hz]."""

    hose: Annotated[str, _checked(hose_size)] = ""
    """Length and inner diameter of the hose between valve and each chamber, e.g. '2 m x 12 mm'."""

    null_leakage: Annotated[float, SI("m^3/s", above=0, most=1.0)] | None = None
    """Largest null leakage of the valve at the supply pressure, e.g. '0.4 L/min'; by default 1 % of the rated
    flow [m³/s]."""

    return_pressure: Annotated[str, _checked(pressure_range)] = "2 bar to 6 bar"
    """Range of the return pressure, e.g. '2 bar to 6 bar'."""

    spring: Annotated[float, SI("N/m", least=0)] = 0.0
    """Stiffness of a spring on the piston [N/m]."""

    dead_volume: Annotated[float, SI("m^3", above=0)] | None = None
    """Volume of each chamber and its ports with the piston at its end; by default 5 % of area · stroke
    [m³]."""

    measured_modulus: Annotated[float, SI("Pa", above=0)] | None = None
    """Measured effective bulk modulus of oil and hoses [Pa]."""

    mounting: Literal["horizontal", "vertical-rod-up", "vertical-rod-down"] = "horizontal"
    """Direction of the axis, along which the mass weighs."""

    double_rod: bool = False
    """The rod passes through both chambers: equal areas."""

    @model_validator(mode="after")
    def _rod_fits(self) -> Self:
        if self.rod >= self.bore:
            raise ValueError(f"rod: {self.rod:g} m must be below the bore, {self.bore:g} m")
        return self


def _machine(sheet: CylinderSheet) -> dict[str, float]:
    """Numbers of cylinder, oil and valve that follow from the sheet [SI], by their names in the layout."""
    bore, annulus = sheet.bore**2, sheet.bore**2 - sheet.rod**2
    area_1 = 0.25 * math.pi * (annulus if sheet.double_rod else bore)
    area_2 = 0.25 * math.pi * annulus
    length, diameter = hose_size(sheet.hose)
    hose = 0.25 * math.pi * diameter**2 * length
    volume_1, volume_2 = (
        0.5 * swept + (DEAD_SHARE * swept if sheet.dead_volume is None else sheet.dead_volume) + hose
        for swept in (sheet.stroke * area_1, sheet.stroke * area_2)
    )
    oil, warm = named_oil(sheet.oil), sheet.temperature
    hose_share, oil_modulus = 2.0 * hose / (volume_1 + volume_2), oil.bulk_modulus(warm, 0.5 * sheet.supply)
    in_series = 1.0 / ((1.0 - hose_share) / oil_modulus + hose_share / HOSE_MODULUS)
    modulus = in_series if sheet.measured_modulus is None else sheet.measured_modulus
    viscosities = [oil.kinematic_viscosity(warm + step) for step in (0.5, -0.5)]
    density = oil.density(warm)
    lowest, highest = pressure_range(sheet.return_pressure)
    rated_flow, rated_drop = valve_rating(sheet.valve)
    edge_drop, tank, flow_gain = 0.5 * rated_drop, 0.5 * (lowest + highest), 0.6 * math.sqrt(2.0 / density)
    leakage = 0.01 * rated_flow if sheet.null_leakage is None else sheet.null_leakage
    ranges = 60e5, 100e5, 160e5, 250e5, 315e5, 400e5, 600e5, 1000e5
    return {
        "area_1": area_1, "area_2": area_2, "volume_1": volume_1, "volume_2": volume_2,
        "hose_share": hose_share, "oil_modulus": oil_modulus, "bulk_modulus": modulus, "density": density,
        "celsius": warm - KELVIN, "viscosity": oil.kinematic_viscosity(warm),
        "modulus_slope": -COOLING, "viscosity_slope": math.log(viscosities[0] / viscosities[1]),
        "rated_flow": rated_flow, "rated_drop": rated_drop, "edge_drop": edge_drop, "flow_gain": flow_gain,
        "area_gradient": rated_flow / (flow_gain * TRAVEL * math.sqrt(edge_drop)),
        "lowest_tank": lowest, "highest_tank": highest, "tank": tank, "largest_leakage": leakage,
        "clearance": clearance_conductance(leakage, sheet.supply, tank),
        # of pressure sensors: the next usual range
        "full_scale": next((end for end in ranges if end >= 1.2 * sheet.supply), 2.0 * sheet.supply),
        "balance_error": math.sqrt(2.0) * area_1 * 5e-5 * sheet.stroke,
    }  # fmt: skip


def _motion(sheet: CylinderSheet, machine: Mapping[str, float]) -> dict[str, float]:
    """Numbers of motion, controller and load that follow [SI]."""
    area_1, area_2 = areas = machine["area_1"], machine["area_2"]
    push, pull = sheet.supply * area_1, sheet.supply * area_2
    gain = machine["rated_flow"] / math.sqrt(machine["edge_drop"])
    speed_out, speed_in = (
        steady_speed(sheet.supply, 0.0, fed, drained, gain, gain, 0.0)
        for fed, drained in (areas, areas[::-1])
    )
    stiffness = area_1**2 / machine["volume_1"] + area_2**2 / machine["volume_2"]
    frequency = math.sqrt(machine["bulk_modulus"] * stiffness / sheet.mass) / (2.0 * math.pi)
    crossover = 0.05 * 2.0 * math.pi * frequency
    proportional = crossover / (speed_out / RATED_VOLTAGE)
    # half the stroke in the slower direction, and five time constants of the loop
    period = 0.1 * math.ceil(10.0 * (0.5 * sheet.stroke / min(speed_out, speed_in) + 5.0 / crossover) - 1e-9)
    load_share = min(0.3, 0.7 * (area_2 / area_1) ** 2)
    weight = 0.0 if sheet.mounting == "horizontal" else STANDARD_GRAVITY * sheet.mass
    random_force = 0.5 * load_share * pull
    hangs = sheet.mounting == "vertical-rod-down"
    return {
        "push": push, "pull": pull, "weight": weight, "load_share": load_share, "random_force": random_force,
        "constant_force": 0.0 if hangs else max(random_force - weight, 0.0),
        "inclination": {"vertical-rod-up": 90.0, "vertical-rod-down": -90.0}.get(sheet.mounting, 0.0),
        "velocity_threshold": max(1e-3, 1.5 * 0.03 * push * STEP / sheet.mass),
        "viscous": 0.05 * push / speed_out, "speed_out": speed_out, "speed_in": speed_in,
        "natural_frequency": frequency, "period": period, "proportional_gain": proportional,
        "integral_gain": 0.1 * crossover * proportional,
        "duration": max(10.0, math.ceil(6.0 * period - 1e-9)),
        "sampling_frequency": next((rate for rate in (500.0, 1000.0) if rate >= 8.0 * frequency), 2000.0),
    }  # fmt: skip


_COMMENT = re.compile(r"^([^#\n]*[^#\s]) {2,}(# .*)$", re.MULTILINE)

_PLACE = re.compile(r"\$\{(?:([\d.e-]+) )?([a-z]\w*) (\S+?)(?: (\d))?\}|\$(\w+)")
"""A place in the layout: ``${0.02 push N 3}`` is a share of a number of the sheet, in a unit and with so many
digits, or in a format such as ``.3g``; ``$name`` is a text.
"""


def name_text(name: str) -> str:
    """A name that YAML reads as text."""
    return name if isinstance(scalar(name), str) else f"'{name}'"


def sheet_text(name: str, given: Mapping[str, Any]) -> str:
    """The file of a cylinder with this data sheet."""
    sheet = validated(CylinderSheet, Source(plain_data(dict(given))))
    layout = (ready_folder() / "templates" / "data-sheet.txt").read_text(encoding="utf-8")
    machine = _machine(sheet)
    numbers = sheet.model_dump() | machine | _motion(sheet, machine)
    texts = _texts(name, given, sheet, numbers)

    def filled(place: re.Match[str]) -> str:
        factor, quantity, form, n_digit, text = place.groups()
        if text:
            return texts[text]
        value = float(factor or 1.0) * numbers[quantity]
        return format(value, form) if form.startswith(".") else _shown(value, form, int(n_digit or 4))

    return _COMMENT.sub(_aligned, _PLACE.sub(filled, layout))


def section_text(text: str) -> str:
    """The section ``actuator`` of a description, from the file of a data sheet."""
    made = load_experiment(parse_yaml(text, "").data)
    stated = made.data_sheet | made.indicators["flow_balance"]
    values = {name: stated[name] for name in StatedMachine.model_fields if name in stated}
    return "\n".join(data_sheet_lines(values)) + "\n"


def _aligned(line: re.Match[str]) -> str:
    """A line whose comment begins in column 41 or 65, if there is room."""
    before, comment = line.groups()
    width = next((each for each in (40, 64) if len(before) < each), len(before) + 2)
    return f"{before:{width}}{comment}"


def _command(name: str, given: Mapping[str, Any]) -> str:
    """The command that writes the file, in lines of a comment."""
    lines = [f"hydrofdi init {name}"]
    for key, value in given.items():
        option = f"--{key.replace('_', '-')}" + ("" if value is True else f" {shlex.quote(str(value))}")
        if len(lines[-1]) + len(option) > 100:
            lines.append(f"   {option}")
        else:
            lines[-1] += f" {option}"
    return " \\\n#   ".join(lines)


def _shown(value: float, unit: str, n_digit: int = 4) -> str:
    return f"{plain(convert(value, unit), n_digit)} {unit}"


def _texts(
    name: str, given: Mapping[str, Any], sheet: CylinderSheet, numbers: Mapping[str, float]
) -> dict[str, str]:
    """Place in the layout → text, or lines."""
    bore, rod, stroke = (_shown(each, "mm") for each in (sheet.bore, sheet.rod, sheet.stroke))
    share, weight, is_guess = numbers["hose_share"], numbers["weight"], "return_pressure" not in given
    in_series = (
        f"1/({1.0 - share:.3f}/{_shown(numbers['oil_modulus'], 'MPa')} +"
        f" {share:.3f}/{_shown(HOSE_MODULUS, 'MPa')}); guess: oil and wall of a hose"
    )
    of_oil = in_series if sheet.hose else "that of the oil; no hoses"
    return {
        "title": f"{name}: {'double' if sheet.double_rod else 'single'}-rod cylinder"
        f" {bore.removesuffix(' mm')}/{rod.removesuffix(' mm')} × {stroke} at {_shown(sheet.supply, 'bar')}",
        "command": _command(name, given),
        "name": name_text(name),
        "actuator": "\n".join(_areas_and_volumes(sheet, numbers, bore, rod)),
        "volumes_vary": "\n".join(
            f"      actuator.{key}: {{uniform: ±7 %}}  # guess: ports and manifold are not on the data sheet"
            for key in ("chamber_volume", "chamber_volume_2")[: 1 if sheet.double_rod else 2]
        ),
        "oil": named_oil(sheet.oil).name,
        "oil_table": "\n".join(_oil_table(sheet)),
        "modulus_formula": of_oil if sheet.measured_modulus is None else "measured",
        "null_known": "guess 1 % of the rated flow" if sheet.null_leakage is None else "data sheet",
        "return_guess": "; guess: filter and cooler" if is_guess else "",
        "return_comment": "  # guess" if is_guess else "",
        "less_weight": f", less the weight of {_shown(weight, 'kN')}" if weight else "",
        "load_formula": _load_formula(numbers),
        "supply_known": "sum" if sheet.double_rod else "nominal",
    }


def _areas_and_volumes(
    sheet: CylinderSheet, numbers: Mapping[str, float], bore: str, rod: str
) -> Iterator[str]:
    """Lines of the section ``actuator``."""
    annulus = f"π/4 · (({bore})² − ({rod})²)"
    dead = f"{100 * DEAD_SHARE:g} % of area · stroke (guess: ports)"
    if sheet.dead_volume is not None:
        dead = f"dead volume {_shown(sheet.dead_volume, 'cm³')}"
    hose = f" + hose {sheet.hose}" if sheet.hose else ""
    chambers = (("_1", "", annulus if sheet.double_rod else f"π/4 · ({bore})²"), ("_2", "_2", annulus))
    for own, key, formula in chambers[: 1 if sheet.double_rod else 2]:
        yield f"  piston_area{key}: {_shown(numbers[f'area{own}'], 'mm²')}  # {formula}"
        volume = _shown(numbers[f"volume{own}"], "cm³")
        yield f"  chamber_volume{key}: {volume}  # area · ½ stroke + {dead}{hose}"


def _oil_table(sheet: CylinderSheet) -> Iterator[str]:
    """β, density and viscosity of the oil over temperature and pressure, in lines of a comment."""
    oil = named_oil(sheet.oil)
    yield "#     °C   bar   β [MPa]   density [kg/m³]   viscosity [mPa·s]"
    for celsius in sorted({20.0, round(sheet.temperature - KELVIN, 1), 70.0}):
        for pressure in (0.0, sheet.supply):
            at = KELVIN + celsius, pressure
            modulus, viscosity = 1e-6 * oil.bulk_modulus(*at), 1e3 * oil.viscosity(*at)
            row = f"#   {celsius:4.0f}{1e-5 * pressure:6.0f}{modulus:10.0f}{oil.density(*at):18.0f}"
            yield f"{row}{viscosity:20.3g}"


def _load_formula(numbers: Mapping[str, float]) -> str:
    """How the random load follows."""
    ratio, share = numbers["area_2"] / numbers["area_1"], numbers["load_share"]
    text = f"{100.0 * share:.3g} % of supply pressure · A_2 = {_shown(numbers['pull'], 'kN')}"
    if share < 0.3 - 1e-12:
        text += f" (0.7 · (A_2/A_1 = {ratio:.3f})²: from (A_2/A_1)² on, a pulling load cavitates chamber 1)"
    return text
