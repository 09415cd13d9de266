"""Structured Text in the files that PLC projects import: PLCopen XML (TC6) and TwinCAT's."""

from collections.abc import Iterator, Sequence
from uuid import NAMESPACE_URL, uuid5
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from hydroservo.export.st.pou import Declaration, Pou, Structure, Value

TC6 = "http://www.plcopen.org/xml/tc6_0201"
XHTML = "http://www.w3.org/1999/xhtml"
SECTIONS = {  # order and names of a POU's declarations in TC6
    "VAR": ("localVars", False),
    "VAR CONSTANT": ("localVars", True),
    "VAR_INPUT": ("inputVars", False),
    "VAR_OUTPUT": ("outputVars", False),
}
ELEMENTARY = frozenset(("LREAL", "REAL", "LINT", "DINT", "BOOL"))
DATE = "2000-01-01T00:00:00"  # TC6 asks for one, and the same export shall give the same file
HEAD = '<?xml version="1.0" encoding="utf-8"?>\n<!-- {mark} -->\n'
TWINCAT = '<TcPlcObject Version="1.1.0.1" ProductVersion="3.1.4024.0">'


def plcopen_xml(name: str, mark: str, structures: Sequence[Structure], pous: Sequence[Pou]) -> str:
    """A project in PLCopen XML, TC6 2.01."""
    project = Element("project", xmlns=TC6)
    SubElement(
        project,
        "fileHeader",
        companyName="",
        productName="hydroservo",
        productVersion=mark.rpartition(" ")[2],
        creationDateTime=DATE,
    )
    coordinates = SubElement(SubElement(project, "contentHeader", name=name), "coordinateInfo")
    for language in ("fbd", "ld", "sfc"):
        SubElement(SubElement(coordinates, language), "scaling", x="1", y="1")
    types = SubElement(project, "types")
    data_types = SubElement(types, "dataTypes")
    for structure in structures:
        data_type = SubElement(data_types, "dataType", name=structure.name)
        add_variables(SubElement(SubElement(data_type, "baseType"), "struct"), structure.fields)
        add_documentation(data_type, structure.about)
    units = SubElement(types, "pous")
    for pou in pous:
        add_pou(units, pou)
    SubElement(SubElement(project, "instances"), "configurations")
    ElementTree.indent(project)
    return f"{HEAD.format(mark=mark)}{ElementTree.tostring(project, encoding='unicode')}\n"


def add_pou(pous: Element, pou: Pou) -> None:
    """A function or a function block."""
    kind = "function" if pou.returns else "functionBlock"
    unit = SubElement(pous, "pou", name=pou.name, pouType=kind)
    interface = SubElement(unit, "interface")
    if pou.returns:
        add_type(SubElement(interface, "returnType"), pou.returns)
    for head, (tag, constant) in SECTIONS.items():
        declared = pou.sections.get(head)
        if declared:
            variables = SubElement(interface, tag, {"constant": "true"} if constant else {})
            add_variables(variables, declared)
    text = SubElement(SubElement(unit, "body"), "ST")
    SubElement(text, "p", xmlns=XHTML).text = "\n" + "\n".join(pou.body) + "\n"
    add_documentation(unit, pou.about)


def add_variables(parent: Element, declared: Sequence[Declaration]) -> None:
    for one in declared:
        variable = SubElement(parent, "variable", name=one.name)
        kind = SubElement(variable, "type")
        if one.length:
            array = SubElement(kind, "array")
            SubElement(array, "dimension", lower="0", upper=str(one.length - 1))
            add_type(SubElement(array, "baseType"), one.kind)
        else:
            add_type(kind, one.kind)
        if one.value is not None:
            add_value(SubElement(variable, "initialValue"), one.value)
        add_documentation(variable, one.note)


def add_type(parent: Element, kind: str) -> None:
    if kind in ELEMENTARY:
        SubElement(parent, kind)
    else:
        SubElement(parent, "derived", name=kind)


def add_value(parent: Element, value: Value) -> None:
    """A first value: of a number or an array."""
    if isinstance(value, str):
        SubElement(parent, "simpleValue", value=value)
    else:
        values = SubElement(parent, "arrayValue")
        for number in value:
            SubElement(SubElement(values, "value"), "simpleValue", value=number)


def add_documentation(parent: Element, text: str) -> None:
    if text:
        SubElement(SubElement(parent, "documentation"), "p", xmlns=XHTML).text = text


def twincat_files(
    mark: str, hash_: str, structures: Sequence[Structure], pous: Sequence[Pou]
) -> dict[str, str]:
    """Each type and each POU as TwinCAT has it in a file of its own, by file name."""
    head = f"{HEAD.format(mark=mark)}{TWINCAT}"
    return {name: f"{head}\n{text}" for name, text in twincat_objects(hash_, structures, pous)}


def twincat_objects(
    hash_: str, structures: Sequence[Structure], pous: Sequence[Pou]
) -> Iterator[tuple[str, str]]:
    for structure in structures:
        text = f"    <Declaration>{character_data(structure.text)}</Declaration>\n"
        yield f"{structure.name}.TcDUT", twincat_object("DUT", structure.name, hash_, text)
    for pou in pous:
        body = character_data("\n".join(pou.body))
        text = (
            f"    <Declaration>{character_data(pou.declaration)}</Declaration>\n"
            f"    <Implementation>\n      <ST>{body}</ST>\n    </Implementation>\n"
        )
        yield f"{pou.name}.TcPOU", twincat_object("POU", pou.name, hash_, text)


def twincat_object(tag: str, name: str, hash_: str, text: str) -> str:
    identity = uuid5(NAMESPACE_URL, f"hydroservo:{hash_}:{name}")
    special = ' SpecialFunc="None"' if tag == "POU" else ""
    return f'  <{tag} Name="{name}" Id="{{{identity}}}"{special}>\n{text}  </{tag}>\n</TcPlcObject>\n'


def character_data(text: str) -> str:
    """A text as XML's character data."""
    return f"<![CDATA[{text.replace(']]>', ']] >')}]]>"
