"""The file modelDescription.xml of an FMU, for FMI 2.0 and 3.0."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from rustchain.fmi.variables import Input, Variable

_UNITS: Mapping[str, Mapping[str, int]] = {
    "s": {"s": 1},
    "rad": {"rad": 1},
    "rad/s": {"rad": 1, "s": -1},
    "N": {"kg": 1, "m": 1, "s": -2},
    "N.m": {"kg": 1, "m": 2, "s": -2},
}
"""Exponents of the base units of each unit."""

_COMMON = {
    "needsExecutionTool": "false",
    "canHandleVariableCommunicationStepSize": "true",
    "canBeInstantiatedOnlyOncePerProcess": "false",
    "maxOutputDerivativeOrder": "0",
}
_CAPABILITIES: Mapping[str, Mapping[str, str]] = {
    "2.0": {
        "canInterpolateInputs": "false",
        "canRunAsynchronuously": "false",  # the standard has this spelling
        "canNotUseMemoryManagementFunctions": "true",
        "canGetAndSetFMUstate": "true",
        "canSerializeFMUstate": "true",
        "providesDirectionalDerivative": "false",
    },
    "3.0": {
        "canGetAndSetFMUState": "true",
        "canSerializeFMUState": "true",
        "providesDirectionalDerivatives": "false",
        "providesIntermediateUpdate": "false",
        "mightReturnEarlyFromDoStep": "false",
        "hasEventMode": "false",
    },
}


_NO_CHARACTER = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""What XML 1.0 cannot contain."""


@dataclass(frozen=True)
class Model:
    """Contents of the model description of an FMU.

    Attributes
    ----------
    name, identifier, token, description : str
        Name of the model, of its library, its instantiation token, and a line of text.
    time : float
        Start time [s].
    variables : sequence of Variable
        Inputs and outputs in the order of their value references, which begin with 1.
    start : sequence of float
        Value of each variable at the start.
    """

    name: str
    identifier: str
    token: str
    description: str
    time: float
    variables: Sequence[Variable]
    start: Sequence[float]


def model_description(model: Model, version: str) -> bytes:
    """Return modelDescription.xml in the version "2.0" or "3.0"."""
    from rustchain import __version__

    root = Element(
        "fmiModelDescription",
        fmiVersion=version,
        modelName=model.name,
        description=model.description,
        generationTool=f"rustchain {__version__}",
        variableNamingConvention="structured",
    )
    root.set("guid" if version == "2.0" else "instantiationToken", model.token)
    capabilities = {"modelIdentifier": model.identifier, **_COMMON, **_CAPABILITIES[version]}
    SubElement(root, "CoSimulation", capabilities)
    _add_units(root, ["s", *(variable.unit for variable in model.variables)])
    categories = SubElement(root, "LogCategories")
    SubElement(categories, "Category", name="logStatusError", description="Errors of functions")
    SubElement(root, "DefaultExperiment", startTime=repr(model.time))
    if version == "2.0":
        _add_variables_2(root, model)
    else:
        _add_variables_3(root, model)
    for element in root.iter():
        for name, text in element.items():
            element.set(name, _NO_CHARACTER.sub("_", text))
    ElementTree.indent(root)
    content: bytes = ElementTree.tostring(root, encoding="UTF-8", xml_declaration=True)
    return content


def _add_units(root: Element, units: Sequence[str]) -> None:
    definitions = SubElement(root, "UnitDefinitions")
    for unit in dict.fromkeys(units):
        exponents = {base: str(exponent) for base, exponent in _UNITS[unit].items()}
        SubElement(SubElement(definitions, "Unit", name=unit), "BaseUnit", exponents)


def _add_variables_2(root: Element, model: Model) -> None:
    """Add variables, and their structure, which has them by their place in the list, from 1."""
    variables = SubElement(root, "ModelVariables")
    for reference, (variable, start) in enumerate(_with_start(model), 1):
        scalar = SubElement(variables, "ScalarVariable", _attributes(variable, reference))
        SubElement(scalar, "Real", start, unit=variable.unit)
    structure = SubElement(root, "ModelStructure")
    for part in ("Outputs", "InitialUnknowns"):
        unknowns = Element(part)
        for reference in _outputs(model):
            # The inputs act from the next step on.
            SubElement(unknowns, "Unknown", index=str(reference), dependencies="")
        if len(unknowns):
            structure.append(unknowns)


def _add_variables_3(root: Element, model: Model) -> None:
    """Add the time, the variables, and their structure, which has them by value references."""
    variables = SubElement(root, "ModelVariables")
    time = {"causality": "independent", "variability": "continuous", "unit": "s"}
    SubElement(variables, "Float64", time, name="time", valueReference="0")
    for reference, (variable, start) in enumerate(_with_start(model), 1):
        attributes = {**_attributes(variable, reference), **start}
        SubElement(variables, "Float64", attributes, unit=variable.unit)
    structure = SubElement(root, "ModelStructure")
    for part in ("Output", "InitialUnknown"):
        for reference in _outputs(model):
            SubElement(structure, part, valueReference=str(reference), dependencies="")


def _attributes(variable: Variable, reference: int) -> dict[str, str]:
    return {
        "name": variable.name,
        "valueReference": str(reference),
        "description": variable.description,
        "causality": "input" if isinstance(variable, Input) else "output",
        "variability": "continuous",
    }


def _with_start(model: Model) -> list[tuple[Variable, dict[str, str]]]:
    """Return each variable with its attribute ``start``, which inputs have."""
    pairs = zip(model.variables, model.start, strict=True)
    return [(each, {"start": repr(x)} if isinstance(each, Input) else {}) for each, x in pairs]


def _outputs(model: Model) -> list[int]:
    """Return the value references of the outputs."""
    numbered = enumerate(model.variables, 1)
    return [reference for reference, each in numbered if not isinstance(each, Input)]
