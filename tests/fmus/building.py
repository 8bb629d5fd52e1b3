"""FMUs for tests: the paper's cylinder in C, well-behaved or not, built with the compiler of this machine."""

import math
import re
import shutil
import subprocess
import tempfile
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import fmpy
import pytest

HERE = Path(__file__).parent
COMPILER = shutil.which("cc")
needs_compiler = pytest.mark.skipif(COMPILER is None, reason="there is no C compiler (cc)")

GUID = "{a5c81c9e-0f2f-4d7b-9a53-5d7e1c2f8b60}"
IDENTIFIER = "cylinder"

_FACTORS = {"bar": ("Pa", 1e5), "l/min": ("m3/s", 1e-3 / 60.0), "mm": ("m", 1e-3), "kN/m": ("N/m", 1e3)}
"""Unit that is not SI → its SI unit, and its size."""

_BASES: dict[str, dict[str, int]] = {
    "kg": {"kg": 1}, "m": {"m": 1}, "m2": {"m": 2}, "m3": {"m": 3}, "m/s": {"m": 1, "s": -1}, "s": {"s": 1},
    "m/s2": {"m": 1, "s": -2}, "s/m": {"m": -1, "s": 1}, "N": {"kg": 1, "m": 1, "s": -2}, "N/m": {"kg": 1, "s": -2},
    "N.s/m": {"kg": 1, "s": -1}, "Pa": {"kg": 1, "m": -1, "s": -2}, "Pa/s": {"kg": 1, "m": -1, "s": -3},
    "m3/s": {"m": 3, "s": -1}, "m3/(s.Pa)": {"kg": -1, "m": 4, "s": 1}, "rad/s": {"rad": 1, "s": -1}, "1": {},
    "V": {"kg": 1, "m": 2, "s": -3, "A": -1}, "m/V": {"kg": -1, "m": -1, "s": 3, "A": 1},
    # Half powers of base units cannot be written down.
    "m3.5/kg0.5": {}, "m1.5/kg0.5": {},
}  # fmt: skip


@dataclass(frozen=True)
class Variable:
    """A variable of the cylinder; its start value is in SI.

    `kind`: (i)nput, (o)utput, (f)ixed or (t)unable parameter, (s)tate with a start value, (c)alculated
    parameter, (l)ocal.
    """

    name: str
    kind: str
    unit: str | None = None
    start: float | str = 0.0
    type: str = "Real"
    derivative_of: str | None = None
    description: str = ""

    @property
    def symbol(self) -> str:
        """Its name in C."""
        return re.sub(r"\W", "_", self.name).upper()


VARIABLES = (
    Variable("u", "i", "V", description="voltage of the valve"),
    Variable("x", "s", "m", description="position of the piston"),
    Variable("v", "s", "m/s", description="velocity of the piston"),
    Variable("cyl.port_a.p", "o", "Pa", description="pressure of chamber 1"),
    Variable("cyl.port_b.p", "o", "Pa", description="pressure of chamber 2"),
    Variable("valve.x", "s", "m", description="position of the spool"),
    Variable("valve.v", "s", "m/s", description="velocity of the spool"),
    Variable("q_leak", "o", "m3/s", description="leakage across the piston"),
    Variable("supply.port.p", "o", "Pa", description="supply pressure"),
    Variable("der(x)", "l", "m/s", derivative_of="x"),
    Variable("der(v)", "l", "m/s2", derivative_of="v"),
    Variable("der(cyl.port_a.p)", "l", "Pa/s", derivative_of="cyl.port_a.p"),
    Variable("der(cyl.port_b.p)", "l", "Pa/s", derivative_of="cyl.port_b.p"),
    Variable("der(valve.x)", "l", "m/s", derivative_of="valve.x"),
    Variable("der(valve.v)", "l", "m/s2", derivative_of="valve.v"),
    Variable("cyl.mass", "f", "kg", 12.3),
    Variable("cyl.area", "f", "m2", 633e-6),
    Variable("cyl.volume", "f", "m3", 280e-6, description="volume of each chamber, piston in the centre"),
    Variable("cyl.k_ext[1]", "f", "m3/(s.Pa)", description="external leakage of chamber 1"),
    Variable("cyl.k_ext[2]", "f", "m3/(s.Pa)", description="external leakage of chamber 2"),
    Variable("cyl.p_rest", "c", "Pa", description="pressure of both chambers at rest"),
    Variable("load.stiffness", "f", "N/m", 150e3),
    Variable("load.on", "f", start=1.0, type="Boolean", description="whether the spring is mounted"),
    Variable("supply.p", "f", "Pa", 17.2e6),
    Variable("supply.ret", "f", "Pa", 0.0),
    Variable("oil.beta", "f", "Pa", 551e6, description="effective bulk modulus"),
    Variable("oil.name", "f", start="HLP32", type="String"),
    Variable("valve.K", "f", "m1.5/kg0.5", 0.0292, description="flow gain"),
    Variable("valve.w", "f", "m", 20.75e-3, description="area gradient"),
    Variable("valve.gain", "f", "m/V", 22e-6),
    Variable("valve.omega", "f", "rad/s", 2.0 * math.pi * 175.0),
    Variable("valve.xi", "f", "1", 0.7),
    Variable("friction.law", "f", start=1.0, type="Enumeration"),
    Variable("friction.coulomb", "f", "N", 200.0),
    Variable("friction.breakaway", "f", "N", 250.0),
    Variable("friction.viscous", "f", "N.s/m", 50.0),
    Variable("friction.decay", "f", "s/m", 40.0),
    Variable("friction.threshold", "f", "m/s", 1e-3),
    Variable("seal.k", "t", "m3.5/kg0.5", description="leakage across the piston: flow per root of the pressure difference"),
    # Instants after which the FMU misbehaves; never if negative.
    Variable("hazard.crash", "f", "s", -1.0),
    Variable("hazard.hang", "f", "s", -1.0),
    Variable("hazard.fail", "f", "s", -1.0),
    Variable("hazard.discard", "f", "s", -1.0),
    Variable("hazard.nan", "f", "s", -1.0),
)  # fmt: skip

ATTRIBUTES = {"canHandleVariableCommunicationStepSize": "true", "canNotUseMemoryManagementFunctions": "true"}


@dataclass(frozen=True)
class Recipe:
    """An FMU of the cylinder.

    Attributes
    ----------
    version : int
        2 or 3 of FMI.
    kinds : tuple of str
        Of ``CoSimulation`` and ``ModelExchange``; only version 2 has the latter.
    attributes : mapping
        Of the element ``CoSimulation`` or ``ModelExchange`` of modelDescription.xml.
    defines : tuple of str
        ``NO_RESET``: fmi2Reset fails. ``ONCE``: no second instance in a process. ``NO_LICENCE``: no instance.
    units : mapping
        Name of a variable → another unit (of `_FACTORS`), or None; the key "" stands for all variables.
    without_start : tuple of str
        Parameters that state no start value, as the standard demands they did.
    platform : str, optional
        Folder of the binary; by default that of this machine.
    """

    version: int = 2
    kinds: tuple[str, ...] = ("CoSimulation",)
    attributes: tuple[tuple[str, str], ...] = ()
    defines: tuple[str, ...] = ()
    units: tuple[tuple[str, str | None], ...] = ()
    without_start: tuple[str, ...] = ()
    platform: str | None = None

    def variables(self) -> list[Variable]:
        """Variables with the units of this recipe."""
        units = dict(self.units)
        return [
            replace(v, unit=units.get(v.name, units.get("", v.unit))) if v.type == "Real" else v
            for v in VARIABLES
        ]


def build(folder: Path, recipe: Recipe = Recipe(), name: str = "cylinder.fmu") -> Path:
    """Compile and zip an FMU; the file in `folder`."""
    platform = recipe.platform or (fmpy.platform if recipe.version == 2 else fmpy.platform_tuple)
    binary = f"binaries/{platform}/{IDENTIFIER}{fmpy.sharedLibraryExtension}"
    with zipfile.ZipFile(folder / name, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("modelDescription.xml", description(recipe))
        archive.writestr(binary, _compiled(recipe))
    return folder / name


def _compiled(recipe: Recipe) -> bytes:
    headers = Path(fmpy.__file__).parent / "c-code"
    with tempfile.TemporaryDirectory() as work:
        (Path(work) / "variables.h").write_text(_header(recipe.variables()), encoding="utf-8")
        library = Path(work) / "library"
        subprocess.run(
            [str(COMPILER), "-O2", "-shared", "-fPIC", "-fvisibility=hidden", f"-I{headers}", f"-I{work}",
             *(f"-D{each}" for each in recipe.defines), HERE / f"fmi{recipe.version}.c", "-o", library, "-lm"],
            check=True,
        )  # fmt: skip
        return library.read_bytes()


def _header(variables: Sequence[Variable]) -> str:
    def row(values: Sequence[Any]) -> str:
        return "{" + ", ".join(map(str, values)) + "}"

    scales = [_FACTORS.get(v.unit or "", ("", 1.0))[1] for v in variables]
    starts = [0.0 if isinstance(v.start, str) else v.start for v in variables]
    kinds = "".join(v.kind for v in variables)
    return (
        f"enum {row([*(v.symbol for v in variables), 'N_VARIABLE'])};\n"
        f"static const double START[] = {row(starts)}, SCALE[] = {row(scales)};\n"
        f'static const char KIND[] = "{kinds}", GUID[] = "{GUID}";\n'
    )


def description(recipe: Recipe) -> bytes:
    """modelDescription.xml."""
    return (_description_2 if recipe.version == 2 else _description_3)(recipe)


_ROLES = {
    "i": ("input", "continuous", None), "o": ("output", "continuous", "calculated"),
    "s": ("output", "continuous", "exact"), "f": ("parameter", "fixed", None),
    "t": ("parameter", "tunable", None), "c": ("calculatedParameter", "fixed", "calculated"),
    "l": ("local", "continuous", "calculated"),
}  # fmt: skip
"""Kind → causality, variability and initial; the default of `initial` is left out."""


def _common(recipe: Recipe, root: Element, identifier: str) -> None:
    for kind in recipe.kinds:
        SubElement(root, kind, {"modelIdentifier": identifier, **_attributes(recipe, kind)})
    units = SubElement(root, "UnitDefinitions")
    for unit in sorted({v.unit for v in recipe.variables() if v.unit}):
        base, factor = _FACTORS.get(unit, (unit, 1.0))
        powers: Mapping[str, Any] = _BASES[base] | ({"factor": factor} if factor != 1.0 else {})
        element = SubElement(units, "Unit", {"name": unit})
        if powers or unit == "1":
            SubElement(element, "BaseUnit", {key: str(value) for key, value in powers.items()})


def _attributes(recipe: Recipe, kind: str) -> dict[str, str]:
    known = dict(ATTRIBUTES) if kind == "CoSimulation" else {}
    if recipe.version == 3:
        known.pop("canNotUseMemoryManagementFunctions", None)
    return known | dict(recipe.attributes)


def _start(variable: Variable) -> str:
    if isinstance(variable.start, str):
        return variable.start
    match variable.type:
        case "Boolean":
            return str(variable.start != 0.0).lower()
        case "Enumeration":
            return str(int(variable.start))
    return repr(variable.start / _FACTORS.get(variable.unit or "", ("", 1.0))[1])


def _description_2(recipe: Recipe) -> bytes:
    root = Element("fmiModelDescription", {
        "fmiVersion": "2.0", "modelName": "cylinder", "guid": GUID, "generationTool": "tests of hydrofdi",
        "variableNamingConvention": "structured", "numberOfEventIndicators": "0",
    })  # fmt: skip
    variables = recipe.variables()
    _common(recipe, root, IDENTIFIER)
    law = SubElement(SubElement(root, "TypeDefinitions"), "SimpleType", {"name": "FrictionLaw"})
    items = SubElement(law, "Enumeration")
    for value, name in enumerate(("threshold", "viscous alone"), 1):
        SubElement(items, "Item", {"name": name, "value": str(value)})
    SubElement(root, "DefaultExperiment", {"startTime": "0", "stopTime": "20", "stepSize": "0.002"})
    model = SubElement(root, "ModelVariables")
    place = {v.name: str(index) for index, v in enumerate(variables, 1)}
    for reference, v in enumerate(variables):
        causality, variability, initial = _ROLES[v.kind]
        variability = variability if v.type == "Real" or causality == "parameter" else "discrete"
        element = SubElement(model, "ScalarVariable", {
            "name": v.name, "valueReference": str(reference), "causality": causality, "variability": variability,
        } | ({"initial": initial} if initial else {}) | ({"description": v.description} if v.description else {}))  # fmt: skip
        content = {"declaredType": "FrictionLaw"} if v.type == "Enumeration" else {}
        if v.kind in "ifts" and v.name not in recipe.without_start:
            content["start"] = _start(v)
        if v.unit:
            content["unit"] = v.unit
        if v.derivative_of:
            content["derivative"] = place[v.derivative_of]
        SubElement(element, v.type, content)
    structure = SubElement(root, "ModelStructure")
    _unknowns(structure, "Outputs", [place[v.name] for v in variables if v.kind in "os"])
    _unknowns(structure, "Derivatives", [place[v.name] for v in variables if v.derivative_of])
    first = [place[v.name] for v in variables if v.kind in "oc" or v.derivative_of]
    _unknowns(structure, "InitialUnknowns", first)
    return _text(root)


def _unknowns(structure: Element, name: str, places: Sequence[str]) -> None:
    parent = SubElement(structure, name)
    for place in places:
        SubElement(parent, "Unknown", {"index": place})


def _description_3(recipe: Recipe) -> bytes:
    root = Element("fmiModelDescription", {
        "fmiVersion": "3.0", "modelName": "cylinder", "instantiationToken": GUID, "generationTool": "tests of hydrofdi",
        "variableNamingConvention": "structured",
    })  # fmt: skip
    _common(recipe, root, IDENTIFIER)
    types = SubElement(root, "TypeDefinitions")
    law = SubElement(types, "EnumerationType", {"name": "FrictionLaw"})
    for value, name in enumerate(("threshold", "viscous alone"), 1):
        SubElement(law, "Item", {"name": name, "value": str(value)})
    SubElement(root, "DefaultExperiment", {"startTime": "0", "stopTime": "20", "stepSize": "0.002"})
    model = SubElement(root, "ModelVariables")
    variables = recipe.variables()
    reference = {v.name: str(index) for index, v in enumerate(variables)}
    SubElement(model, "Float64", {
        "name": "time", "valueReference": str(len(variables)), "causality": "independent", "variability": "continuous",
    })  # fmt: skip
    for v in variables:
        if v.name == "cyl.k_ext[2]":
            continue
        causality, variability, initial = _ROLES[v.kind]
        content = {
            "name": v.name.removesuffix("[1]"), "valueReference": reference[v.name], "causality": causality,
            "variability": variability,
        } | ({"initial": initial} if initial else {}) | ({"description": v.description} if v.description else {})  # fmt: skip
        is_array = v.name.endswith("[1]")
        has_start = v.kind in "ifts" and v.name not in recipe.without_start
        if v.type == "Enumeration":
            content["declaredType"] = "FrictionLaw"
        if v.unit:
            content["unit"] = v.unit
        if v.derivative_of:
            content["derivative"] = reference[v.derivative_of]
        if has_start and v.type != "String":
            content["start"] = " ".join([_start(v)] * (2 if is_array else 1))
        element = SubElement(model, "Float64" if v.type == "Real" else v.type, content)
        if is_array:
            SubElement(element, "Dimension", {"start": "2"})
        if has_start and v.type == "String":
            SubElement(element, "Start", {"value": _start(v)})
    structure = SubElement(root, "ModelStructure")
    for name, kinds in (("Output", "os"), ("InitialUnknown", "oc")):
        for v in variables:
            if v.kind in kinds:
                SubElement(structure, name, {"valueReference": reference[v.name]})
    return _text(root)


def _text(root: Element) -> bytes:
    indent(root)
    return bytes(tostring(root, encoding="utf-8", xml_declaration=True))
