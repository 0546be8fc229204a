"""``make stubs``: write stub files for the ROS messages and services that the sources use.

rosidl's Python classes carry no annotations. Read are the .msg and .srv files of the environment, as rosidl reads them;
written is one stub a package, ``PACKAGE/msg/__init__.pyi`` and ``PACKAGE/srv/__init__.pyi``, with the types that the
sources import and all that these are made of.
"""

from __future__ import annotations

import ast
import sys
from collections import defaultdict
from collections.abc import Iterable, Iterator
from pathlib import Path

from rosidl_adapter.parser import (
    Constant,
    Field,
    MessageSpecification,
    parse_message_file,
    parse_service_file,
)

from bootstrap.places import MESSAGE_PACKAGES, venv_places

STUBS = Path(__file__).resolve().parent
ROOT = STUBS.parent
FOLDERS = ("ros2_ws/src", "tests", "benchmarks", "examples", "bootstrap")
"""Where messages are imported."""

HEAD = "# Written by `make stubs` from the .{kind} files; see typings/README.md.\n"
PLAIN = {"bool": "bool", "byte": "bytes", "string": "str", "wstring": "str", "float32": "float", "float64": "float"}
"""Types of single values; all others are whole numbers."""

Name = tuple[str, str, str]
"""Package, "msg" or "srv", type."""


def imported() -> set[Name]:
    """The message and service types that the sources import."""
    found = set()
    for path in (path for folder in FOLDERS for path in (ROOT / folder).rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.ImportFrom) and node.module and node.module.endswith((".msg", ".srv")):
                package, _, kind = node.module.partition(".")
                found |= {(package, kind, alias.name) for alias in node.names}
    return found


def _folder(package: str) -> Path:
    """Where a package's definitions are: of the own ones the sources, so that none has to be built."""
    places = venv_places()
    return dict(zip(MESSAGE_PACKAGES, places.message_sources, strict=True)).get(
        package, places.venv / "share" / package
    )


def stubs() -> dict[Path, str]:
    """All stub files, from ``STUBS`` on, with their text."""
    messages: dict[Name, str] = {}
    needs: dict[Name, set[Name]] = {}
    to_do = imported()
    while to_do:
        name = to_do.pop()
        package, kind, short = name
        file = str(_folder(package) / kind / f"{short}.{kind}")
        if kind == "msg":
            specifications = [parse_message_file(package, file)]
            messages[name] = _message(short, specifications[0])
        else:
            service = parse_service_file(package, file)
            specifications = [service.request, service.response]
            messages[name] = _service(short, *specifications)
        needs[name] = {used for part in specifications for used in _used(part)}
        to_do |= needs[name] - set(messages)
    files: dict[Path, str] = {}
    for package, kind in sorted({name[:2] for name in messages}):
        inside = sorted(name for name in messages if name[:2] == (package, kind))
        outside = {used for name in inside for used in needs[name] if used[:2] != (package, kind)}
        text = "\n\n".join(messages[name] for name in inside)
        files[Path(package, "__init__.pyi")] = ""
        files[Path(package, kind, "__init__.pyi")] = f"{HEAD.format(kind=kind)}{_imports(text, outside)}\n{text}"
    return files


def _imports(text: str, outside: Iterable[Name]) -> str:
    """What a stub's text needs, in the order that the linter asks for."""
    lines = ["from array import array"] if "array[" in text else []
    lines += ["from collections.abc import Iterable"] if "Iterable[" in text else []
    typing = [word for word in ("Any", "ClassVar", "TypeAlias") if word in text]
    lines += [f"from typing import {', '.join(typing)}", ""]
    lines += ["import numpy as np", "import numpy.typing as npt"] if "npt." in text else []
    modules = defaultdict(list)
    for package, kind, short in sorted(outside):
        modules[f"{package}.{kind}"].append(short)
    lines += [f"from {module} import {', '.join(names)}" for module, names in modules.items()]
    return "\n".join(lines).rstrip() + "\n"


def _used(specification: MessageSpecification) -> Iterator[Name]:
    for field in specification.fields:
        if not field.type.is_primitive_type():
            yield field.type.pkg_name, "msg", field.type.type


def _message(name: str, specification: MessageSpecification) -> str:
    fields = specification.fields
    lines = [f"class {name}:"]
    lines += [_constant(constant) for constant in specification.constants]
    lines += ["    SLOT_TYPES: ClassVar[tuple[Any, ...]]"]
    for field in fields:
        read, written = _types(field)
        if read == written:
            lines.append(f"    {field.name}: {read}")
        else:
            lines += ["    @property", f"    def {field.name}(self) -> {read}: ..."]
            lines += [f"    @{field.name}.setter", f"    def {field.name}(self, value: {written}) -> None: ..."]
    arguments = "".join(f"        {field.name}: {_types(field)[1]} = ...,\n" for field in fields)
    head = f"    def __init__(\n        self,\n        *,\n{arguments}" if fields else "    def __init__(self"
    lines.append(f"{head}{'    ' if fields else ''}) -> None: ...")
    lines += ["    @classmethod", "    def get_fields_and_field_types(cls) -> dict[str, str]: ..."]
    return "\n".join(lines) + "\n"


def _service(name: str, request: MessageSpecification, response: MessageSpecification) -> str:
    parts = [_message(f"{name}_Request", request), _message(f"{name}_Response", response)]
    aliases = [f"    {part}: TypeAlias = {name}_{part}\n" for part in ("Request", "Response")]
    return "\n\n".join([*parts, f"class {name}:\n{''.join(aliases)}"])


def _constant(constant: Constant) -> str:
    return f"    {constant.name}: ClassVar[{PLAIN.get(constant.type, 'int')}]"


def _types(field: Field) -> tuple[str, str]:
    """What a field reads as, and what may be written into it, as rosidl_generator_py stores it."""
    kind = field.type
    single = PLAIN.get(kind.type, "int") if kind.is_primitive_type() else kind.type
    if not kind.is_array:
        return single, single
    number = kind.is_primitive_type() and single in ("int", "float")
    if number and kind.array_size and not kind.is_upper_bound:
        dtype = kind.type.replace("char", "uint8")
        return f"npt.NDArray[np.{dtype}]", f"npt.NDArray[np.{dtype}] | Iterable[{single}]"
    if number:
        return f"array[{single}]", f"Iterable[{single}]"
    return f"list[{single}]", f"list[{single}]"


def write() -> int:
    """Write all stubs anew, and remove those of packages that are not used any more.

    Returns:
        How many files there are.
    """
    wanted = stubs()
    for old in STUBS.rglob("*.pyi"):
        if old.relative_to(STUBS) not in wanted:
            old.unlink()
    for path, text in wanted.items():
        (STUBS / path).parent.mkdir(parents=True, exist_ok=True)
        (STUBS / path).write_text(text)
    return len(wanted)


if __name__ == "__main__":
    print(f"{write()} stub files", file=sys.stderr)
