"""FMUs for tests: the paper's cylinder in C, well-behaved or not, built with the compiler of this machine."""

import math
import re
import shutil
import subprocess
import tempfile
import zipfile
from collections.abc import Iterable, Sequence
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

_OTHER_UNITS = {"bar": ("Pa", 1e5), "l/min": ("m3/s", 1e-3 / 60.0), "mm": ("m", 1e-3), "%": ("1", 1e-2)}
"""Unit that is not SI → its SI unit and factor."""

_BASES: dict[str, dict[str, int]] = {
    "kg": {"kg": 1}, "m": {"m": 1}, "m2": {"m": 2}, "m3": {"m": 3}, "s": {"s": 1}, "K": {"K": 1}, "1": {},
    "m/s": {"m": 1, "s": -1}, "m/s2": {"m": 1, "s": -2}, "s/m": {"m": -1, "s": 1},
    "rad/s": {"rad": 1, "s": -1},
    "N": {"kg": 1, "m": 1, "s": -2}, "N/m": {"kg": 1, "s": -2}, "N.s/m": {"kg": 1, "s": -1},
    "Pa": {"kg": 1, "m": -1, "s": -2}, "Pa/s": {"kg": 1, "m": -1, "s": -3}, "m3/s": {"m": 3, "s": -1},
    "m3/(s.Pa)": {"kg": -1, "m": 4, "s": 1}, "V": {"kg": 1, "m": 2, "s": -3, "A": -1},
    "m/V": {"kg": -1, "m": -1, "s": 3, "A": 1},
    # Half powers of base units cannot be written down.
    "m3.5/kg0.5": {}, "m1.5/kg0.5": {},
}  # fmt: skip


@dataclass(frozen=True)
class Variable:
    """A variable of the cylinder; its start value and limits are in SI, its kind is one of `_ROLES`."""

    name: str
    kind: str
    unit: str | None = None
    start: float | str = 0.0
    type: str = "Real"
    derivative_of: str | None = None
    limits: tuple[float, float] | None = None
    description: str = ""

    @property
    def symbol(self) -> str:
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
    Variable("oil.T", "k", "K", 313.15, description="temperature of the oil"),
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
    Variable("oil.beta", "f", "Pa", 551e6, limits=(1e7, 2e10), description="effective bulk modulus"),
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
    Variable("seal.k", "t", "m3.5/kg0.5", limits=(0.0, 1e-6), description="leakage across the piston"),
    # Instants after which the FMU misbehaves; never if negative.
    *(Variable(f"hazard.{each}", "f", "s", -1.0) for each in ("crash", "hang", "fail", "discard", "nan")),
)  # fmt: skip


@dataclass(frozen=True)
class Recipe:
    """An FMU of the cylinder.

    Attributes
    ----------
    kinds : tuple of str
        Of ``CoSimulation`` and ``ModelExchange``; only version 2 has the latter.
    attributes : tuple of pairs
        Of the element ``CoSimulation`` or ``ModelExchange`` of modelDescription.xml.
    defines : tuple of str
        ``NO_RESET``: a reset fails; ``FALSE_RESET``: it does nothing. ``ONCE``: no second instance in a
        process; ``NO_LICENCE``: none at all. ``CHATTY``: prints.
    units : tuple of pairs
        Name of a variable → another unit (of `_OTHER_UNITS`), or None.
    platform : str, optional
        Folder of the binary, one of Windows; by default that of this machine.
    """

    version: int = 2
    kinds: tuple[str, ...] = ("CoSimulation",)
    attributes: tuple[tuple[str, str], ...] = ()
    defines: tuple[str, ...] = ()
    units: tuple[tuple[str, str | None], ...] = ()
    platform: str | None = None

    def variables(self) -> list[Variable]:
        return [replace(v, unit=dict(self.units).get(v.name, v.unit)) for v in VARIABLES]


def build(folder: Path, recipe: Recipe = Recipe(), name: str = "cylinder.fmu") -> Path:
    """Compile and zip an FMU; the file in `folder`."""
    own = fmpy.platform if recipe.version == 2 else fmpy.platform_tuple
    suffix = fmpy.sharedLibraryExtension if recipe.platform is None else ".dll"
    binary = f"binaries/{recipe.platform or own}/{IDENTIFIER}{suffix}"
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
             *(f"-D{one}" for one in recipe.defines), HERE / f"fmi{recipe.version}.c", "-lm", "-o", library],
            check=True,
        )  # fmt: skip
        return library.read_bytes()


def _header(variables: Sequence[Variable]) -> str:
    def row(values: Iterable[Any]) -> str:
        return "{" + ", ".join(map(str, values)) + "}"

    starts = [0.0 if isinstance(v.start, str) else v.start for v in variables]
    kinds = "".join(v.kind for v in variables)
    return (
        f"enum {row([*(v.symbol for v in variables), 'N_VARIABLE'])};\n"
        f"static const double START[] = {row(starts)}, SCALE[] = {row(map(_scale, variables))};\n"
        f'static const char KIND[] = "{kinds}", GUID[] = "{GUID}";\n'
    )


def _scale(variable: Variable) -> float:
    """Factor that makes SI of its value."""
    return _OTHER_UNITS.get(variable.unit or "", ("", 1.0))[1]


def _text_of(variable: Variable, value: float | str) -> str:
    """A value as modelDescription.xml writes it."""
    if isinstance(value, str):
        return value
    words = {"Boolean": str(value != 0.0).lower(), "Enumeration": str(int(value))}
    return words.get(variable.type, repr(value / _scale(variable)))


def description(recipe: Recipe) -> bytes:
    root = {2: _description_2, 3: _description_3}[recipe.version](recipe)
    indent(root)
    return bytes(tostring(root, encoding="utf-8", xml_declaration=True))


_ROLES = {
    "i": ("input", "continuous", None), "o": ("output", "continuous", "calculated"),
    "s": ("output", "continuous", "exact"), "f": ("parameter", "fixed", None),
    "t": ("parameter", "tunable", None), "c": ("calculatedParameter", "fixed", "calculated"),
    "l": ("local", "continuous", "calculated"), "k": ("local", "constant", "exact"),
}  # fmt: skip
"""Kind → causality, variability and initial (None: the default). (i)nput, (o)utput, (s)tate
with a start value, (f)ixed or (t)unable parameter, (c)alculated parameter, (l)ocal, (k)onstant."""


def _root(recipe: Recipe, **attributes: str) -> Element:
    """Its beginning, which the versions share."""
    shared = {"modelName": "cylinder", "variableNamingConvention": "structured"}
    root = Element("fmiModelDescription", {"fmiVersion": f"{recipe.version}.0", **shared, **attributes})
    for kind in recipe.kinds:
        known = {"canHandleVariableCommunicationStepSize": "true"} if kind == "CoSimulation" else {}
        SubElement(root, kind, {"modelIdentifier": IDENTIFIER, **known, **dict(recipe.attributes)})
    used = sorted({v.unit for v in recipe.variables() if v.unit})
    units = SubElement(root, "UnitDefinitions") if used else root
    for unit in used:
        base, factor = _OTHER_UNITS.get(unit, (unit, 1.0))
        powers = {key: str(value) for key, value in _BASES[base].items()}
        element = SubElement(units, "Unit", {"name": unit})
        if powers or unit == "1":
            SubElement(element, "BaseUnit", powers | {"factor": repr(factor)})
        if unit == "Pa":  # values are in Pa all the same
            SubElement(element, "DisplayUnit", {"name": "bar", "factor": "1e-5"})
    return root


def _attributes(v: Variable, reference: int) -> dict[str, str]:
    names = ("causality", "variability", "initial", "description")
    given = zip(names, (*_ROLES[v.kind], v.description), strict=True)
    return {"name": v.name, "valueReference": str(reference)} | {key: value for key, value in given if value}


def _declared(v: Variable) -> dict[str, str]:
    given = {"declaredType": "FrictionLaw"} if v.type == "Enumeration" else {}
    if v.kind in "iftsk":
        given["start"] = _text_of(v, v.start)
    if v.unit:
        given |= {"unit": v.unit} | ({"displayUnit": "bar"} if v.unit == "Pa" else {})
    if v.limits:
        given |= {name: _text_of(v, limit) for name, limit in zip(("min", "max"), v.limits, strict=True)}
    return given


def _items(parent: Element) -> None:
    for value, name in enumerate(("threshold", "viscous alone"), 1):
        SubElement(parent, "Item", {"name": name, "value": str(value)})


def _description_2(recipe: Recipe) -> Element:
    root, variables = _root(recipe, guid=GUID, numberOfEventIndicators="0"), recipe.variables()
    law = SubElement(SubElement(root, "TypeDefinitions"), "SimpleType", {"name": "FrictionLaw"})
    _items(SubElement(law, "Enumeration"))
    SubElement(root, "DefaultExperiment", {"startTime": "0", "stopTime": "20", "stepSize": "0.002"})
    model = SubElement(root, "ModelVariables")
    place = {v.name: str(index) for index, v in enumerate(variables, 1)}
    for reference, v in enumerate(variables):
        derivative = {"derivative": place[v.derivative_of]} if v.derivative_of else {}
        element = SubElement(model, "ScalarVariable", _attributes(v, reference))
        SubElement(element, v.type, _declared(v) | derivative)
    structure = SubElement(root, "ModelStructure")
    for name, chosen in (
        ("Outputs", [v for v in variables if v.kind in "os"]),
        ("Derivatives", [v for v in variables if v.derivative_of]),
        ("InitialUnknowns", [v for v in variables if v.kind in "oc" or v.derivative_of]),
    ):
        parent = SubElement(structure, name)
        for v in chosen:
            SubElement(parent, "Unknown", {"index": place[v.name]})
    return root


def _description_3(recipe: Recipe) -> Element:
    root, variables = _root(recipe, instantiationToken=GUID), recipe.variables()
    _items(SubElement(SubElement(root, "TypeDefinitions"), "EnumerationType", {"name": "FrictionLaw"}))
    SubElement(root, "DefaultExperiment", {"startTime": "0", "stopTime": "20", "stepSize": "0.002"})
    model = SubElement(root, "ModelVariables")
    reference = {v.name: index for index, v in enumerate(variables)}
    clock = replace(VARIABLES[0], name="time", description="")
    SubElement(model, "Float64", _attributes(clock, len(variables)) | {"causality": "independent"})
    for v in variables:
        if v.name == "cyl.k_ext[2]":
            continue
        given, is_array = _attributes(v, reference[v.name]) | _declared(v), v.name.endswith("[1]")
        if v.derivative_of:
            given["derivative"] = str(reference[v.derivative_of])
        start = given.pop("start", None) if v.type == "String" else None
        if is_array:
            given |= {"name": v.name.removesuffix("[1]"), "start": f"{given['start']} {given['start']}"}
        element = SubElement(model, "Float64" if v.type == "Real" else v.type, given)
        if is_array:
            SubElement(element, "Dimension", {"start": "2"})
        if start is not None:
            SubElement(element, "Start", {"value": start})
    structure = SubElement(root, "ModelStructure")
    for name, kinds in (("Output", "os"), ("InitialUnknown", "oc")):
        for v in variables:
            if v.kind in kinds:
                SubElement(structure, name, {"valueReference": str(reference[v.name])})
    return root
