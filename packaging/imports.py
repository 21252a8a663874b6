"""Names that the project imports from itself exist, and no files import each other in a circle.

    python packaging/imports.py [ROOT]

Names are resolved in the sources, nothing is run. Read are all Python files, and the Python blocks
and `python -m` commands of the documentation. Checked are imports anywhere in a file, be they
within a function or of a test, which no type checker reads; and, but for tests, texts such as
`"rigctl.cli.demo:demo"` that name what is imported only when it is called. Circles are looked for
below src, imports within functions included, those for types alone left out. Ends with status 1 and
a line for each fault.
"""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

PACKAGES = ("analysis", "rigctl", "simulators", "benchmarks", "tests")
FOLDERS = ("src", "simulators", "benchmarks", "tests", "packaging")
_OURS = rf"(?:{'|'.join(PACKAGES)})(?:\.\w+)*"
_NAMED = re.compile(rf"({_OURS}\.\w+)(?::(\w+))?")
_FENCED = re.compile(r"^```python\n(.*?)^```", re.DOTALL | re.MULTILINE)
_COMMAND = re.compile(rf"python3? -m ({_OURS})")


class Sources:
    """Modules of the project and the names that each of them binds."""

    def __init__(self, root: Path) -> None:
        self._roots = (root / "src", root)
        self._bound: dict[Path, set[str]] = {}

    def is_module(self, name: str) -> bool:
        """Say whether a dotted name is a file, or a folder with files of Python."""
        return self._file(name) is not None or self._folder(name) is not None

    def has(self, module: str, name: str) -> bool:
        """Say whether a module binds a name or holds a module of that name."""
        if self.is_module(f"{module}.{name}"):
            return True
        file = self._file(module)
        return file is not None and bool({name, "__getattr__"} & self._names(file))

    def resolves(self, dotted: str) -> bool:
        """Say whether a dotted name leads to a module, or to what one binds."""
        parts = dotted.split(".")
        for end in range(len(parts), 0, -1):
            if self.is_module(".".join(parts[:end])):
                return end == len(parts) or self.has(".".join(parts[:end]), parts[end])
        return False

    def _file(self, name: str) -> Path | None:
        place = name.replace(".", "/")
        candidates = (
            root / end for root in self._roots for end in (f"{place}.py", f"{place}/__init__.py")
        )
        return next((path for path in candidates if path.is_file()), None)

    def _folder(self, name: str) -> Path | None:
        folders = (root / name.replace(".", "/") for root in self._roots)
        return next((folder for folder in folders if any(folder.glob("*.py"))), None)

    def _names(self, file: Path) -> set[str]:
        if file not in self._bound:
            self._bound[file] = set(bound_names(ast.parse(file.read_text("utf-8"))))
        return self._bound[file]


def bound_names(node: ast.AST) -> Iterator[str]:
    """Yield the names that a module binds, in branches too, not within functions and classes."""
    for inner in ast.iter_child_nodes(node):
        if isinstance(inner, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            yield inner.name
        elif isinstance(inner, ast.Import | ast.ImportFrom):
            yield from (alias.asname or alias.name.split(".")[0] for alias in inner.names)
        else:
            if isinstance(inner, ast.Name) and isinstance(inner.ctx, ast.Store):
                yield inner.id
            yield from bound_names(inner)


def imported_names(tree: ast.Module, package: str) -> Iterator[tuple[int, str, str | None]]:
    """Yield the line, module, and name of what a file takes from the project.

    ``package`` is the dotted name of the file's folder, which relative imports start from.
    """
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            named = _NAMED.fullmatch(node.value)
            if named and not package.startswith("tests"):
                yield node.lineno, named[1], named[2]
        else:
            yield from statement_names(node, package)


def statement_names(node: ast.AST, package: str) -> Iterator[tuple[int, str, str | None]]:
    """Yield the line, module and name of what one statement takes from other files."""
    if isinstance(node, ast.Import):
        yield from ((node.lineno, alias.name, None) for alias in node.names)
    elif isinstance(node, ast.ImportFrom):
        base = node.module or ""
        if node.level:
            above = package.split(".")[: len(package.split(".")) - node.level + 1]
            base = ".".join([*above, base] if base else above)
        yield from ((node.lineno, base, alias.name) for alias in node.names)


def run_parts(node: ast.AST) -> Iterator[ast.AST]:
    """Yield all parts of a module but what is there for types alone."""
    for inner in ast.iter_child_nodes(node):
        if not (isinstance(inner, ast.If) and ast.unparse(inner.test) == "TYPE_CHECKING"):
            yield inner
            yield from run_parts(inner)


def circle(root: Path) -> list[str]:
    """Return the modules of one circle of imports below src, in their order; empty without one."""
    paths = {}
    for path in (root / "src").rglob("*.py"):
        parts = path.relative_to(root / "src").with_suffix("").parts
        paths[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    imports: dict[str, set[str]] = {}
    for name, path in paths.items():
        package = name if path.name == "__init__.py" else name.rpartition(".")[0]
        found = imports[name] = set()
        for node in run_parts(ast.parse(path.read_text("utf-8"))):
            for _, module, taken in statement_names(node, package):
                inner = f"{module}.{taken}"
                found.add(inner if inner in paths else module)
        found.discard(name)
    try:
        TopologicalSorter(imports).prepare()
    except CycleError as error:
        # Given from what is imported to what imports it.
        return list(error.args[1])[::-1]
    return []


def missing_names(tree: ast.Module, package: str, sources: Sources) -> Iterator[tuple[int, str]]:
    """Yield the line and the name of each import of the project that leads nowhere."""
    for line, module, name in imported_names(tree, package):
        if module.split(".")[0] not in PACKAGES:
            continue
        if name is None or name == "*":
            found = sources.resolves(module)
        else:
            found = sources.is_module(module) and sources.has(module, name)
        if not found:
            yield line, module if name is None else f"{module}.{name}"


def missing(root: Path) -> list[str]:
    """Return a line for each name under ``root`` that is imported or called and does not exist."""
    sources = Sources(root)
    found = []
    for path in sorted(path for folder in FOLDERS for path in (root / folder).rglob("*.py")):
        place = path.relative_to(root)
        package = ".".join(part for part in place.parent.parts if part != "src")
        tree = ast.parse(path.read_text("utf-8"))
        lines = missing_names(tree, package, sources)
        found += [f"{place}:{line}: {name} does not exist" for line, name in lines]
    pages = [*root.glob("*.md"), *(root / "docs").rglob("*.md"), *root.glob("Makefile")]
    for path in sorted(pages):
        text, place = path.read_text("utf-8"), path.relative_to(root)
        for block in _FENCED.findall(text):
            lines = missing_names(ast.parse(block), "", sources)
            found += [f"{place}: {name} does not exist" for _, name in lines]
        commands = _COMMAND.findall(text)
        gone = [name for name in commands if not sources.is_module(name)]
        found += [f"{place}: {name} does not exist" for name in gone]
    return found


def main() -> int:
    """Print what is missing or circular; return the status of the process."""
    root = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parents[1]
    lines = missing(root)
    if around := circle(root):
        lines.append(f"imported in a circle: {' -> '.join(around)}")
    sys.stdout.writelines(f"{line}\n" for line in lines)
    return 1 if lines else 0


if __name__ == "__main__":
    sys.exit(main())
