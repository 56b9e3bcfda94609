"""OSCQuery namespace: the tree of all controls and readings as JSON, for discovery by other programs.

After the proposal at github.com/Vidvox/OSCQueryProposal (2018). A control lists its required arguments and those that
are its value. Optional arguments (duration, addressee) are only in the reference.
"""

from dataclasses import replace
from typing import Any, Final

from live.control.registry.control import Argument, ArgumentValue, Control
from live.control.registry.registry import READINGS, REGISTRY, Reading, Values

ATTRIBUTES: Final = (
    "FULL_PATH", "CONTENTS", "TYPE", "ACCESS", "VALUE", "RANGE", "DESCRIPTION", "TAGS", "UNIT", "CLIPMODE", "CRITICAL",
)  # fmt: skip
NONE, READ, WRITE, BOTH = 0, 1, 2, 3
"""ACCESS of a node."""
_NAMED: Final = tuple(control for control in REGISTRY if control.named)
_NAMES: Final = frozenset(control.address for control in _NAMED)
_TYPES: Final = {"float": "f", "bool": "T", "name": "s", "text": "s", "int": "i"}


def listed_arguments(control: Control) -> tuple[Argument, ...]:
    """Return the arguments that the tree lists."""
    if control.value:
        return control.arguments[: control.named + control.value]
    return tuple(argument for argument in control.arguments if argument.default is None)


class Namespace:
    """The tree of nodes. Use from one thread."""

    def __init__(self, values: Values) -> None:
        self._values = values
        self._tree: dict[str, Any] = {"FULL_PATH": "/", "ACCESS": NONE, "DESCRIPTION": "ChoreoGraphics Live"}
        self._nodes = {"/": self._tree}
        for reading in READINGS:
            self._add(reading.address, _of_reading(reading))
        for control in REGISTRY:
            self._add(control.address, _of_control(control))

    def _add(self, address: str, facts: dict[str, Any]) -> None:
        path, node = "", self._tree
        for part in address[1:].split("/"):
            path += "/" + part
            node = node.setdefault("CONTENTS", {}).setdefault(part, {"FULL_PATH": path, "ACCESS": NONE})
            self._nodes[path] = node
        node |= facts

    def _add_named_nodes(self) -> None:
        """Add a node for each name that has a value."""
        for control in _NAMED:
            for name, _ in self._values.rows(control.address):
                path = control.address_of(name)
                if path is not None and path not in self._nodes:
                    own = replace(control, address=path, arguments=control.arguments[1:], named=False)
                    self._add(path, _of_control(own))

    def has(self, path: str) -> bool:
        """Whether a node exists."""
        self._add_named_nodes()
        return _clean(path) in self._nodes

    def node(self, path: str) -> dict[str, Any]:
        """Return a node with all below it and their current values; KeyError if there is none."""
        self._add_named_nodes()
        return self._with_values(self._nodes[_clean(path)])

    def attribute(self, path: str, name: str) -> dict[str, Any] | None:
        """Return one attribute of a node; None if the node lacks it; KeyError for an unknown node or attribute."""
        if name not in ATTRIBUTES:
            raise KeyError(name)
        node = self.node(path)
        return {name: node[name]} if name in node else None

    def _with_values(self, node: dict[str, Any]) -> dict[str, Any]:
        told = dict(node)
        if node["ACCESS"] & READ:
            rows = self._values.rows(node["FULL_PATH"])
            if rows:  # if groups differ, the first; LISTEN sends all of them
                name, value = rows[0]
                whole = (name, *value) if node["FULL_PATH"] in _NAMES else value
                told["VALUE"] = list(whole)
                told["TYPE"] = "".join(_type_of(tag, value) for tag, value in zip(told["TYPE"], whole, strict=True))
        if "CONTENTS" in node:
            told["CONTENTS"] = {name: self._with_values(below) for name, below in node["CONTENTS"].items()}
        return told


def _clean(path: str) -> str:
    return path.rstrip("/") or "/"


def _type_of(tag: str, value: ArgumentValue) -> str:
    return ("T" if value else "F") if tag == "T" else tag


def _of_reading(reading: Reading) -> dict[str, Any]:
    return {
        "TYPE": _TYPES[reading.type], "ACCESS": READ, "DESCRIPTION": reading.description,
        **({"UNIT": [reading.unit]} if reading.unit else {}), "TAGS": ["status"],
    }  # fmt: skip


def _of_control(control: Control) -> dict[str, Any]:
    arguments = listed_arguments(control)
    facts: dict[str, Any] = {
        "TYPE": "".join(_TYPES[argument.type] for argument in arguments) or "I",
        "ACCESS": BOTH if control.value else WRITE,
        "DESCRIPTION": control.description,
        "TAGS": [control.role, control.kind],
    }
    if control.kind == "event":
        facts["CRITICAL"] = True
    if arguments:
        facts["RANGE"] = [_range(argument) for argument in arguments]
        facts["CLIPMODE"] = ["none"] * len(arguments)
    if any(argument.unit for argument in arguments):
        facts["UNIT"] = [argument.unit or None for argument in arguments]
    return facts


def _range(argument: Argument) -> dict[str, Any]:
    if argument.type == "float":
        return {"MIN": argument.minimum, "MAX": argument.maximum}
    return {"VALS": [False, True]} if argument.type == "bool" else {}


def host_info(name: str, osc: tuple[str, int], http: tuple[str, int]) -> dict[str, Any]:
    """Return HOST_INFO: name, extensions, and the addresses of OSC and WebSocket."""
    can = ("ACCESS", "VALUE", "RANGE", "DESCRIPTION", "TAGS", "UNIT", "CLIPMODE", "CRITICAL", "LISTEN")
    info: dict[str, Any] = {
        "NAME": name, "EXTENSIONS": dict.fromkeys(can, True), "OSC_PORT": osc[1], "OSC_TRANSPORT": "UDP",
        "WS_PORT": http[1],
    }  # fmt: skip
    for key, (host, _) in (("OSC_IP", osc), ("WS_IP", http)):
        if host not in ("0.0.0.0", "::"):  # if left out, clients use the host they queried
            info[key] = host
    return info
