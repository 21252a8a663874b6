"""Size of the house: code lines of each room, and files that exist for one other file.

    python -m benchmarks.house [--depth 2] [--single ROOM] [--kinds] [--start]

Code lines are those of ``src`` without blanks, comments and docstrings. A file counts as single
where exactly one other file of ``src`` imports it, be that in a function; a package's ``__init__``
is not counted, nor is a file that an ``__init__`` alone imports. Members are those among the single
files whose one user is a list of things of one kind: effects, routes, pages, drivers.
``--kinds`` prints what lines of code consist of, and those of our own JavaScript and CSS without
blanks and comments. ``--start`` prints the time of `rigctl --help`, the least of ten, s.
"""

import argparse
import ast
import io
import re
import subprocess
import sys
import time
import tokenize
from collections import Counter, defaultdict
from pathlib import Path

SOURCES = Path(__file__).resolve().parents[1] / "src"

LISTS = {
    "analysis.effects.catalogue",
    "rigctl.cameras.build",
    "rigctl.devices.build",
    "rigctl.page.mounting",
    "rigctl.service.app",
}

_LAYOUT = {
    tokenize.COMMENT,
    tokenize.NL,
    tokenize.NEWLINE,
    tokenize.INDENT,
    tokenize.DEDENT,
    tokenize.ENDMARKER,
}


def docstring_lines(tree: ast.Module) -> set[int]:
    """Return the line numbers of all docstrings of a module."""
    lines: set[int] = set()
    for node in ast.walk(tree):
        if not isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            continue
        if ast.get_docstring(node, clean=False) is not None:
            text = node.body[0]
            lines.update(range(text.lineno, (text.end_lineno or text.lineno) + 1))
    return lines


def coded(text: str) -> set[int]:
    """Return the numbers of the lines that hold code."""
    lines: set[int] = set()
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type not in _LAYOUT:
            lines.update(range(token.start[0], token.end[0] + 1))
    return lines - docstring_lines(ast.parse(text))


def lines_by_kind(text: str) -> Counter[str]:
    """Return how many lines of code are imports, heads of functions and so on."""
    kinds: dict[int, str] = {}

    def mark(node: ast.stmt | ast.expr, last: int | None, kind: str) -> None:
        for line in range(node.lineno, (last or node.lineno) + 1):
            kinds.setdefault(line, kind)

    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import | ast.ImportFrom):
            mark(node, node.end_lineno, "imports")
        elif isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            for decorator in node.decorator_list:
                mark(decorator, decorator.end_lineno, "heads")
            mark(node, max(node.lineno, node.body[0].lineno - 1), "heads")
        if isinstance(node, ast.Module | ast.ClassDef):
            for each in node.body:
                if isinstance(each, ast.Assign | ast.AnnAssign):
                    mark(each, each.end_lineno, "constants and fields")
    return Counter(kinds.get(line, "statements") for line in coded(text))


def lines_of_page() -> Counter[str]:
    """Return lines of JavaScript and CSS of our own without blanks and comments."""
    found: Counter[str] = Counter()
    for path in SOURCES.rglob("*"):
        if path.suffix in {".js", ".css"} and ".min" not in path.suffixes:
            text = re.sub(r"/\*.*?\*/", "", path.read_text(encoding="utf-8"), flags=re.DOTALL)
            lines = (line.strip() for line in text.splitlines())
            found[path.suffix[1:]] += sum(bool(line) and line[:2] != "//" for line in lines)
    return found


def module_name(path: Path) -> str:
    """Return the dotted name under which a file of ``src`` is imported."""
    parts = path.relative_to(SOURCES).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imported(tree: ast.Module, name: str, package: bool, known: set[str]) -> set[str]:
    """Return the modules of ``src`` that a module names, anywhere in its text."""
    found: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            if node.level:
                parts = name.split(".")
                parts = parts[: len(parts) - node.level + package]
                base = ".".join([*parts, base] if base else parts)
            found.add(base)
            found.update(f"{base}.{alias.name}" for alias in node.names)
    return (found & known) - {name}


def help_time_s() -> float:
    """Return how long `rigctl --help` takes in a fresh process, s."""
    program = "from rigctl.cli import run; run(['--help'])"
    began = time.perf_counter()
    subprocess.run([sys.executable, "-c", program], check=True, capture_output=True)
    return time.perf_counter() - began


def main() -> None:
    """Print lines and single files of each room, then the single files of one room."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--depth", type=int, default=2, help="folders below src that make a room")
    parser.add_argument("--single", metavar="ROOM", help="list the single files below this room")
    parser.add_argument("--kinds", action="store_true", help="what lines consist of")
    parser.add_argument("--start", action="store_true", help="time `rigctl --help`")
    choice = parser.parse_args()
    if choice.start:
        print(f"rigctl --help: {min(help_time_s() for _ in range(10)):.3f} s")
        return
    if choice.kinds:
        texts = [path.read_text(encoding="utf-8") for path in SOURCES.rglob("*.py")]
        every = sum(map(lines_by_kind, texts), Counter[str]())
        for kind, count in [*every.most_common(), *sorted(lines_of_page().items())]:
            print(f"{kind:24}{count:7}")
        return
    paths = {module_name(path): path for path in sorted(SOURCES.rglob("*.py"))}
    known = set(paths)
    lines: dict[str, int] = {}
    users: dict[str, set[str]] = defaultdict(set)
    for name, path in paths.items():
        text = path.read_text(encoding="utf-8")
        lines[name] = len(coded(text))
        for other in imported(ast.parse(text), name, path.name == "__init__.py", known):
            users[other].add(name)
    single = {
        name: next(iter(users[name]))
        for name, path in paths.items()
        if path.name != "__init__.py" and len(users[name]) == 1
        if paths[next(iter(users[name]))].name != "__init__.py"
    }
    if choice.single is not None:
        for name, user in sorted(single.items(), key=lambda pair: pair[1]):
            if name.startswith(choice.single):
                print(f"{lines[name]:5} {name:60} for {user}")
        return
    rooms: dict[str, list[str]] = defaultdict(list)
    for name, path in paths.items():
        folders = path.relative_to(SOURCES).parts[:-1]
        rooms["/".join(folders[: choice.depth])].append(name)
    print(f"{'room':32}{'lines':>7}{'files':>7}{'single':>8}{'members':>9}")
    for room, names in [*sorted(rooms.items()), ("all", list(paths))]:
        alone = [name for name in names if name in single]
        members = sum(single[name] in LISTS for name in alone)
        size = sum(lines[name] for name in names)
        print(f"{room:32}{size:7}{len(names):7}{len(alone):8}{members:9}")


if __name__ == "__main__":
    main()
