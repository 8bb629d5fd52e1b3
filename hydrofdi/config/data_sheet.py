"""The data sheet of a cylinder with its valve and oil, the numbers that follow from it, and their commented
experiment file.
"""

from __future__ import annotations

import math
import re
import shlex
from collections.abc import Mapping
from functools import cached_property
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
    """Numbers of a data sheet. Properties are in SI; chamber 1 is on the bore side."""

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

    @cached_property
    def fluid(self) -> Oil:
        """The oil."""
        return named_oil(self.oil)

    @cached_property
    def areas(self) -> tuple[float, float]:
        """A_1 and A_2 [m²]."""
        bore, annulus = self.bore**2, self.bore**2 - self.rod**2
        return 0.25 * math.pi * (annulus if self.double_rod else bore), 0.25 * math.pi * annulus

    @property
    def hose_volume(self) -> float:
        """Volume of the hose at each chamber [m³]."""
        length, diameter = hose_size(self.hose)
        return 0.25 * math.pi * diameter**2 * length

    @cached_property
    def volumes(self) -> tuple[float, float]:
        """V_1 and V_2 with the piston at the centre [m³]."""
        swept = [self.stroke * area for area in self.areas]
        dead = [DEAD_SHARE * volume if self.dead_volume is None else self.dead_volume for volume in swept]
        first, second = (0.5 * full + own + self.hose_volume for full, own in zip(swept, dead, strict=True))
        return first, second

    @property
    def oil_modulus(self) -> float:
        """Bulk modulus of the oil at half the supply pressure [Pa]."""
        return self.fluid.bulk_modulus(self.temperature, 0.5 * self.supply)

    @property
    def hose_share(self) -> float:
        """Share of the hoses in the volume of both chambers [-]."""
        return 2.0 * self.hose_volume / sum(self.volumes)

    @cached_property
    def bulk_modulus(self) -> float:
        """β of oil and hoses in series, if it is not measured [Pa]."""
        if self.measured_modulus is not None:
            return self.measured_modulus
        return 1.0 / ((1.0 - self.hose_share) / self.oil_modulus + self.hose_share / HOSE_MODULUS)

    @property
    def density(self) -> float:
        """ρ of the oil at its temperature [kg/m³]."""
        return self.fluid.density(self.temperature)

    @property
    def viscosity_slope(self) -> float:
        """d ln ν/dT [1/K]."""
        warm, cold = (self.fluid.kinematic_viscosity(self.temperature + step) for step in (0.5, -0.5))
        return math.log(warm / cold)

    @property
    def modulus_slope(self) -> float:
        """d ln β/dT [1/K]."""
        return -COOLING

    @cached_property
    def flow_gain(self) -> float:
        """K_v [m^1.5/kg^0.5]."""
        return 0.6 * math.sqrt(2.0 / self.density)

    @property
    def rated_flow(self) -> float:
        """Rated flow of the valve [m³/s]."""
        return valve_rating(self.valve)[0]

    @property
    def rated_drop(self) -> float:
        """Its pressure drop over both edges [Pa]."""
        return valve_rating(self.valve)[1]

    @property
    def edge_drop(self) -> float:
        """Pressure drop of one edge at the rated flow [Pa]."""
        return 0.5 * self.rated_drop

    @property
    def area_gradient(self) -> float:
        """w [m]."""
        return self.rated_flow / (self.flow_gain * TRAVEL * math.sqrt(self.edge_drop))

    @cached_property
    def speeds(self) -> tuple[float, float]:
        """Steady speeds out and in without load and friction, with the valve at its rated signal [m/s]."""
        gain, (first, second) = self.rated_flow / math.sqrt(self.edge_drop), self.areas
        out, back = (
            steady_speed(self.supply, 0.0, fed, drained, gain, gain, 0.0)
            for fed, drained in ((first, second), (second, first))
        )
        return out, back

    @cached_property
    def natural_frequency(self) -> float:
        """f_h with the piston at the centre [Hz]."""
        stiffness = sum(area**2 / volume for area, volume in zip(self.areas, self.volumes, strict=True))
        return math.sqrt(self.bulk_modulus * stiffness / self.mass) / (2.0 * math.pi)

    @property
    def crossover(self) -> float:
        """Crossover of the position loop, 5 % of the natural frequency [rad/s]."""
        return 0.05 * 2.0 * math.pi * self.natural_frequency

    @property
    def proportional_gain(self) -> float:
        """K_p [V/m]."""
        return self.crossover / (self.speeds[0] / RATED_VOLTAGE)

    @cached_property
    def period(self) -> float:
        """Time for half the stroke in the slower direction, and five time constants of the loop [s]."""
        return 0.1 * math.ceil(10.0 * (0.5 * self.stroke / min(self.speeds) + 5.0 / self.crossover) - 1e-9)

    @property
    def duration(self) -> float:
        """Length of a record: six periods, at least 10 s [s]."""
        return max(10.0, math.ceil(6.0 * self.period - 1e-9))

    @property
    def sampling_frequency(self) -> float:
        """At least eight samples per period of the natural frequency [Hz]."""
        return next((rate for rate in (500.0, 1000.0) if rate >= 8.0 * self.natural_frequency), 2000.0)

    @property
    def push(self) -> float:
        """Supply pressure times A_1 [N]."""
        return self.supply * self.areas[0]

    @property
    def pull(self) -> float:
        """Supply pressure times A_2 [N]."""
        return self.supply * self.areas[1]

    @property
    def weight(self) -> float:
        """Force of the mass along the axis [N]."""
        return 0.0 if self.mounting == "horizontal" else STANDARD_GRAVITY * self.mass

    @property
    def load_share(self) -> float:
        """Load over the pulling force [-]."""
        return min(0.3, 0.7 * (self.areas[1] / self.areas[0]) ** 2)

    @property
    def random_force(self) -> float:
        """Half of the load [N]."""
        return 0.5 * self.load_share * self.pull

    @property
    def constant_force(self) -> float:
        """The other half beyond the weight, pressing the rod in [N]; none on a mass that hangs on the rod."""
        hangs = self.mounting == "vertical-rod-down"
        return 0.0 if hangs else max(self.random_force - self.weight, 0.0)

    @property
    def velocity_threshold(self) -> float:
        """v_th [m/s]."""
        return max(1e-3, 1.5 * 0.03 * self.push * STEP / self.mass)

    @property
    def full_scale(self) -> float:
        """Range of the pressure sensors: the next usual one above 1.2 times the supply pressure [Pa]."""
        ranges = (60e5, 100e5, 160e5, 250e5, 315e5, 400e5, 600e5, 1000e5)
        return next((end for end in ranges if end >= 1.2 * self.supply), 2.0 * self.supply)

    @property
    def largest_leakage(self) -> float:
        """Largest null leakage [m³/s]."""
        return 0.01 * self.rated_flow if self.null_leakage is None else self.null_leakage

    @property
    def tank(self) -> float:
        """Return pressure in the middle of its range [Pa]."""
        return 0.5 * sum(pressure_range(self.return_pressure))

    @property
    def lowest_tank(self) -> float:
        """Its lowest value [Pa]."""
        return pressure_range(self.return_pressure)[0]

    @property
    def highest_tank(self) -> float:
        """Its highest value [Pa]."""
        return pressure_range(self.return_pressure)[1]

    @property
    def clearance(self) -> float:
        """Conductance of the clearance at each edge of a valve with this null leakage [m³/(s·Pa)]."""
        return clearance_conductance(self.largest_leakage, self.supply, self.tank)


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
    texts = _texts(name, given, sheet)

    def filled(place: re.Match[str]) -> str:
        factor, quantity, form, n_digit, text = place.groups()
        if text:
            return texts[text]
        value = float(factor or 1.0) * getattr(sheet, quantity)
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


def _texts(name: str, given: Mapping[str, Any], sheet: CylinderSheet) -> dict[str, str]:
    """Place in the layout → text, or lines."""
    (area_1, area_2), oil, warm = sheet.areas, sheet.fluid, sheet.temperature
    bore, rod, stroke = (_shown(each, "mm") for each in (sheet.bore, sheet.rod, sheet.stroke))
    speed_out, speed_in = sheet.speeds
    return {
        "title": f"{name}: {'double' if sheet.double_rod else 'single'}-rod cylinder"
        f" {bore.removesuffix(' mm')}/{rod.removesuffix(' mm')} × {stroke} at {_shown(sheet.supply, 'bar')}",
        "command": _command(name, given),
        "name": name_text(name),
        "actuator": "\n".join(_areas_and_volumes(sheet, bore, rod)),
        "volumes_vary": "\n".join(
            f"      actuator.{key}: {{uniform: ±7 %}}  # guess: ports and manifold are not on the data sheet"
            for key in ("chamber_volume", "chamber_volume_2")[: 1 if sheet.double_rod else 2]
        ),
        "inclination": f"{ {'vertical-rod-up': 90, 'vertical-rod-down': -90}.get(sheet.mounting, 0)} deg",
        "oil": oil.name,
        "temperature": f"{warm - KELVIN:.4g} °C",
        "viscosity": _shown(oil.kinematic_viscosity(warm), "mm²/s"),
        "oil_table": "\n".join(_oil_table(sheet)),
        "modulus_formula": "measured"
        if sheet.measured_modulus is not None
        else "that of the oil; no hoses"
        if not sheet.hose
        else f"1/({1.0 - sheet.hose_share:.3f}/{_shown(sheet.oil_modulus, 'MPa')} +"
        f" {sheet.hose_share:.3f}/{_shown(HOSE_MODULUS, 'MPa')}); guess: oil and wall of a hose",
        "null_known": "data sheet" if sheet.null_leakage is not None else "guess 1 % of the rated flow",
        "return_guess": "" if "return_pressure" in given else "; guess: filter and cooler",
        "return_comment": "" if "return_pressure" in given else "  # guess",
        "viscous": f"{plain(0.05 * sheet.push / speed_out, 3)} N·s/m",
        "speed_out": _shown(speed_out, "m/s", 3),
        "speed_in": _shown(speed_in, "m/s", 3),
        "integral_gain": plain(0.1 * sheet.crossover * sheet.proportional_gain, 3),
        "less_weight": f", less the weight of {_shown(sheet.weight, 'kN')}" if sheet.weight else "",
        "load_formula": _load_formula(sheet),
        "balance_error": _shown(math.sqrt(2.0) * area_1 * 5e-5 * sheet.stroke, "mm³", 2),
        "supply_known": "sum" if area_1 == area_2 else "nominal",
    }  # fmt: skip


def _areas_and_volumes(sheet: CylinderSheet, bore: str, rod: str) -> list[str]:
    """Lines of the section ``actuator``."""
    annulus, hose = f"π/4 · (({bore})² − ({rod})²)", f" + hose {sheet.hose}" if sheet.hose else ""
    first = annulus if sheet.double_rod else f"π/4 · ({bore})²"
    lines = []
    for key, area, volume, formula in (
        ("", *((sheet.areas[0], sheet.volumes[0], first))),
        ("_2", *((sheet.areas[1], sheet.volumes[1], annulus))),
    ):
        dead = f"{100 * DEAD_SHARE:g} % of area · stroke (guess: ports)"
        if sheet.dead_volume is not None:
            dead = f"dead volume {_shown(sheet.dead_volume, 'cm³')}"
        half = f"area · ½ stroke + {dead}{hose}"
        named = [
            (f"piston_area{key}", _shown(area, "mm²"), formula),
            (f"chamber_volume{key}", _shown(volume, "cm³"), half),
        ]
        lines += [f"  {name}: {number}  # {text}" for name, number, text in named]
    return lines[:2] if sheet.double_rod else lines


def _oil_table(sheet: CylinderSheet) -> list[str]:
    """β, density and viscosity of the oil over temperature and pressure, in lines of a comment."""
    oil, lines = sheet.fluid, ["#     °C   bar   β [MPa]   density [kg/m³]   viscosity [mPa·s]"]
    for celsius in sorted({20.0, round(sheet.temperature - KELVIN, 1), 70.0}):
        for pressure in (0.0, sheet.supply):
            at = KELVIN + celsius, pressure
            modulus, viscosity = 1e-6 * oil.bulk_modulus(*at), 1e3 * oil.viscosity(*at)
            row = f"#   {celsius:4.0f}{1e-5 * pressure:6.0f}{modulus:10.0f}{oil.density(*at):18.0f}"
            lines.append(f"{row}{viscosity:20.3g}")
    return lines


def _load_formula(sheet: CylinderSheet) -> str:
    """How the random load follows."""
    ratio = sheet.areas[1] / sheet.areas[0]
    share = f"{100.0 * sheet.load_share:.3g} % of supply pressure · A_2 = {_shown(sheet.pull, 'kN')}"
    if sheet.load_share < 0.3 - 1e-12:
        share += f" (0.7 · (A_2/A_1 = {ratio:.3f})²: from (A_2/A_1)² on, a pulling load cavitates chamber 1)"
    return share
