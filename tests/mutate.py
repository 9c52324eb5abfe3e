"""What do the tests not see? Change one thing in the code at a time, and run the tests that come by there.

    make mutants                                                    # all modules, ten minutes on one core
    NUMBA_DISABLE_JIT=1 python -m tests.mutate engine/harm.py       # some of them
    NUMBA_DISABLE_JIT=1 python -m tests.mutate --survivors          # what survived last time, after tests were added

Kernels run as plain Python, and tests that look for a seed or play whole games are left out, so a mutant that survives
may still fall to them. Every mutant is tried, none is drawn. results/mutants.txt holds the counts and what survived,
with the reasons that stand in tests/mutants_kept.txt; the exit status is 1 where a survivor has none.
"""

from __future__ import annotations

import ast
import copy
import functools
import gc
import importlib
import inspect
import os
import resource
import sys
import time
from collections import Counter, defaultdict
from collections.abc import Iterator
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import CodeType
from typing import Any, NamedTuple

import pytest

from hexwar_sb3.cache import Cache

ROOT = Path(__file__).parent.parent
KEPT = Path(__file__).with_name("mutants_kept.txt")
RESULTS = ROOT / "results" / "mutants.txt"
ALIVE, NOT_IMPORTED = b"alive", b"not so when imported"
NO_REASON = "no reason yet"
IMPORT_S = 60  # CPU seconds for all tests of the rules
SPARE_S = 5  # a test hangs that needs so many CPU seconds more than twice what it needed without the mutant

RULES = "rules/"
MODULES = [
    "algorithms/td_targets.py",
    *(f"engine/{name}.py" for name in ("fights", "fire", "harm", "movement", "score", "sight")),
    *(f"{RULES}{name}.py" for name in ("adjudicate", "check", "fill", "odds", "page", "rows", "ruleset")),
    "tasks/phi.py",
]
TESTS = {
    "algorithms": ["algorithms/test_td_targets.py"],
    "engine": [f"engine/test_{name}.py" for name in (
        "boarding", "close_combat", "edge_cases", "fire", "guided", "harm", "legality", "mortar", "movement", "occupy",
        "score", "sight", "suppression",
    )],
    "rules": ["rules", "house/test_docs.py"],
    "tasks": ["tasks/test_phi.py", "tasks/test_execute.py"],
}  # fmt: skip
OPTIONS = ("-q", "-s", "--assert=plain", "-p", "no:cacheprovider", "-p", "no:xdist")
SLOW = ("seed", "until(", "suppressed_by_fire", "sticky", "range_of")  # words in the source of slow tests

SWAPS: dict[type[ast.AST], type[ast.AST]] = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
    ast.In: ast.NotIn, ast.NotIn: ast.In, ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.And: ast.Or, ast.Or: ast.And,
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.FloorDiv, ast.FloorDiv: ast.Mult, ast.Div: ast.Mult, ast.Pow: ast.Mult,
    ast.BitOr: ast.BitAnd, ast.BitAnd: ast.BitOr, ast.LShift: ast.RShift, ast.RShift: ast.LShift,
}  # fmt: skip
LEFT = ("annotation", "returns", "decorator_list", "bases")  # types


class Mutant(NamedTuple):
    """One change: its name, the function that it is in ("" for none), and the changed module."""

    name: str
    function: str
    code: CodeType


def mutants(module: str) -> Iterator[Mutant]:
    """Every mutant of a module, in the order of its lines."""
    path = ROOT / "hexwar_sb3" / module
    tree = ast.parse(path.read_text("utf-8"))
    seen: Counter[str] = Counter()
    for function, top in units(tree):
        for holder, key, node in list(slots(top)):
            for new in variants(node):
                name = f"{function or 'module'}: {words(node)} -> {words(new)}"
                seen[name] += 1
                holder[key] = new
                code = compile(ast.fix_missing_locations(tree), str(path), "exec")
                holder[key] = node
                yield Mutant(name if seen[name] == 1 else f"{name} ({seen[name]})", function, code)


def units(tree: ast.Module) -> Iterator[tuple[str, ast.AST]]:
    """Functions and methods by name, and the statements outside of them ("")."""
    for top in tree.body:
        if isinstance(top, ast.ClassDef):
            for item in top.body:
                yield (f"{top.name}.{item.name}" if isinstance(item, ast.FunctionDef) else ""), item
        elif not isinstance(top, ast.Import | ast.ImportFrom):
            yield (top.name if isinstance(top, ast.FunctionDef) else ""), top


def slots(node: ast.AST) -> Iterator[tuple[Any, Any, ast.AST]]:
    """Every node below one, with its holder and its key there."""
    for field, value in ast.iter_fields(node):
        if field in LEFT or isinstance(node, ast.arguments | ast.JoinedStr | ast.Raise):
            continue
        entries = enumerate(value) if isinstance(value, list) else [(field, value)]
        for key, child in entries:
            if isinstance(child, ast.AST):
                yield (value if isinstance(value, list) else vars(node)), key, child
                yield from slots(child)


def variants(node: ast.AST) -> Iterator[ast.AST]:
    """What is tried in the place of a node."""
    match node:
        case ast.Compare():
            for k, op in enumerate(node.ops):
                yield changed(node, ops=[*node.ops[:k], SWAPS[type(op)](), *node.ops[k + 1 :]])
        case ast.BoolOp():
            yield changed(node, op=SWAPS[type(node.op)]())
            for k in range(len(node.values)):
                rest = node.values[:k] + node.values[k + 1 :]
                yield changed(node, values=rest) if len(rest) > 1 else rest[0]
        case ast.BinOp() | ast.AugAssign() if type(node.op) in SWAPS:
            yield changed(node, op=SWAPS[type(node.op)]())
        case ast.UnaryOp():
            yield node.operand
        case ast.Constant(value=bool()):
            yield ast.Constant(not node.value)
        case ast.Constant(value=int() | float() as number):
            yield ast.Constant(number + 1)
        case ast.Call(func=ast.Name(id="min" | "max")):
            yield changed(node, func=ast.Name("max" if node.func.id == "min" else "min", ast.Load()))  # type: ignore[attr-defined]
        case (
            ast.If(test=ast.Name() | ast.Attribute() | ast.Call())
            | ast.IfExp(test=ast.Name() | ast.Attribute() | ast.Call())
        ):
            yield changed(node, test=ast.UnaryOp(ast.Not(), node.test))
    is_call = isinstance(node, ast.Expr) and isinstance(node.value, ast.Call)
    is_write = isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Attribute | ast.Subscript)
    if is_call or is_write or isinstance(node, ast.AugAssign | ast.Return | ast.Continue | ast.Break):
        yield ast.Pass()


def changed(node: ast.AST, **fields: Any) -> Any:
    new = copy.copy(node)
    vars(new).update(fields)
    return new


def words(node: ast.AST) -> str:
    """Source of a node; of a statement that holds others, its first line."""
    return ast.unparse(ast.fix_missing_locations(node)).splitlines()[0]


class Hunt:
    """A pytest plugin: one run of all tests to see which functions each calls, then a process a mutant."""

    def __init__(self, modules: list[str], only: dict[str, set[str]]) -> None:
        self.modules, self.only, self.noting = modules, only, True
        self.callers: defaultdict[tuple[str, str], list[pytest.Item]] = defaultdict(list)
        self.needs_s: dict[pytest.Item, float] = {}
        self.cached: list[Any] = []
        self.done = 0

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Leave out what is slow in plain Python."""
        source = {item: inspect.getsource(item.function) for item in items}  # type: ignore[attr-defined]
        items[:] = [item for item in items if not any(word in source[item] for word in SLOW)]

    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        """Take the place of pytest's own loop over the tests."""
        for item in session.items:
            start = time.process_time()
            item.config.hook.pytest_runtest_protocol(item=item, nextitem=None)
            self.needs_s[item] = time.process_time() - start
        if session.testsfailed:
            raise session.Failed("tests fail without any mutant")
        self.noting = False
        self.cached = [thing for thing in gc.get_objects() if type(thing) is functools._lru_cache_wrapper]
        for items in self.callers.values():
            items.sort(key=lambda item: self.needs_s[item])
        for module in self.modules:
            every = list(mutants(module))
            wanted = [one for one in every if module not in self.only or one.name in self.only[module]]
            alive = [one.name for one in wanted if self.survives(module, one, session)]
            write_results(module, len(every), alive)
            self.done += 1
        return True

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_call(self, item: pytest.Item) -> Iterator[None]:
        """In the first run, note the modules and functions of ours that a test calls."""
        places = {(RULES, "")} if {"rules", "house"} & set(item.path.parts) else set()

        def note(frame: Any, event: str, _: object) -> None:
            if event == "call" and "/hexwar_sb3/" in frame.f_code.co_filename:
                places.add((frame.f_code.co_filename.rpartition("/hexwar_sb3/")[2], frame.f_code.co_qualname))

        sys.setprofile(note if self.noting else None)
        try:
            return (yield)
        finally:
            sys.setprofile(None)
            if self.noting:
                for place in places:
                    self.callers[place].append(item)

    def survives(self, module: str, mutant: Mutant, session: pytest.Session) -> bool:
        """Whether all tests that come by pass; the one that failed goes to the front for the next."""
        place = (RULES, "") if module.startswith(RULES) else (module, mutant.function)
        items = self.callers[place] if place[1] or place[0] == RULES else session.items
        reader, writer = os.pipe()
        if os.fork() == 0:
            try:
                os.write(writer, self.seen_by(module, mutant, items, session))
            except BaseException as error:  # noqa: BLE001  # our own: those of the mutant are the tests'
                os.write(writer, repr(error).encode())
            finally:
                os._exit(0)
        os.close(writer)
        with open(reader, "rb") as pipe:  # noqa: PTH123
            answer = pipe.read()
        os.wait()
        if answer.isdigit():
            items.insert(0, items.pop(int(answer)))
        elif answer not in (ALIVE, NOT_IMPORTED, b""):  # empty: the mutant ended its process
            raise session.Failed(f"{module} {mutant.name}: {answer.decode()}")
        return answer == ALIVE

    def seen_by(
        self, module: str, mutant: Mutant, items: list[pytest.Item], session: pytest.Session
    ) -> bytes:
        """In the child: number of the first test that fails."""
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, 1)
        os.dup2(nowhere, 2)
        Cache.keep = lambda *_: False  # type: ignore[method-assign]  # nothing that a mutant makes is filed
        if not put_in(sys.modules[name_of(module)], mutant):
            return NOT_IMPORTED
        for cached in self.cached if module.startswith(RULES) else ():
            cached.cache_clear()
        for k, item in enumerate(items):
            limit = time.process_time() + SPARE_S + 2 * self.needs_s[item]
            resource.setrlimit(resource.RLIMIT_CPU, (int(limit), resource.RLIM_INFINITY))
            item.config.hook.pytest_runtest_protocol(item=item, nextitem=None)
            if session.testsfailed:
                return str(k).encode()
        return ALIVE if not module.startswith(RULES) or passes_anew(module, mutant) else NOT_IMPORTED


def passes_anew(module: str, mutant: Mutant) -> bool:
    """Whether the tests pass where all is imported again: tables and tests read rules when they are imported."""
    for known in [known for known in sys.modules if known.startswith(("hexwar_sb3", "tests"))]:
        del sys.modules[known]
    limit = int(time.process_time()) + IMPORT_S
    resource.setrlimit(resource.RLIMIT_CPU, (limit, resource.RLIM_INFINITY))
    code_of = SourceFileLoader.get_code
    SourceFileLoader.get_code = lambda self, fullname: (  # type: ignore[method-assign]
        mutant.code if fullname == name_of(module) else code_of(self, fullname)
    )
    return pytest.main([*OPTIONS, "-x", *(str(ROOT / "tests" / test) for test in TESTS["rules"])]) == 0


def put_in(home: Any, mutant: Mutant) -> bool:
    """Give the function its changed code, or every module that has them the changed constants; False: it breaks."""
    if mutant.function:
        live, code = home, mutant.code
        for part in mutant.function.split("."):
            live = vars(live)[part]
            code = next(one for one in code.co_consts if isinstance(one, CodeType) and one.co_name == part)
        live = (
            getattr(live, "fget", None) or getattr(live, "func", None) or getattr(live, "__wrapped__", live)
        )
        live.__code__ = code
        return True
    new: dict[str, Any] = {"__name__": home.__name__, "__file__": home.__file__}
    try:
        exec(mutant.code, new)  # noqa: S102
    except Exception:  # noqa: BLE001
        return False
    for constant, old in [(name, value) for name, value in vars(home).items() if name.strip("_").isupper()]:
        for user in list(sys.modules.values()):
            if getattr(user, constant, None) is old:
                setattr(user, constant, new[constant])
    return True


def name_of(module: str) -> str:
    return f"hexwar_sb3.{module.removesuffix('.py').replace('/', '.')}"


def reasons() -> dict[str, str]:
    """Why a mutant may live: lines "module function: change | reason"."""
    return dict(line.split(" | ", 1) for line in KEPT.read_text("utf-8").splitlines() if " | " in line)


def sections() -> dict[str, list[str]]:
    """Lines of the results by module, the head of each section first."""
    blocks = RESULTS.read_text("utf-8").split("\n\n")[1:] if RESULTS.exists() else []
    return {block.split(":")[0]: block.splitlines() for block in blocks}


def write_results(module: str, made: int, alive: list[str]) -> None:
    """Put the counts and survivors of a module into their place in the results."""
    known, why = sections(), reasons()
    known[module] = [f"{module}: {made} made, {made - len(alive)} killed, {len(alive)} survived"]
    for name in alive:
        known[module] += [f"    {name}", f"        {why.get(f'{module} {name}', NO_REASON)}"]
    text = "\n\n".join("\n".join(known[place]) for place in sorted(known))
    RESULTS.write_text(f"Made by `make mutants`; tests/mutate.py says how.\n\n{text}\n", "utf-8")


def make_tables_once() -> None:
    """Most boards of the tests lie on the same few maps, whose tables take a second each in plain Python."""
    terrain: Any = importlib.import_module("hexwar_sb3.maps.terrain")
    world: Any = importlib.import_module("hexwar_sb3.engine.world")
    read, made = terrain._kept, {}

    def once(name: str, *rest: Any) -> Any:
        if name not in made:
            made[name] = read(name, *rest)
        return made[name]

    terrain._kept = once
    world._world = functools.cache(world._world.__wrapped__)


def main(arguments: list[str]) -> int:
    again = "--survivors" in arguments
    modules = [argument for argument in arguments if argument != "--survivors"] or MODULES
    last = {module: {line.strip() for line in lines} for module, lines in sections().items()}
    hunt = Hunt(modules, last if again else {})
    tests = [
        test for layer, tests in TESTS.items() for test in tests if any(m.startswith(layer) for m in modules)
    ]
    pytest.main([*OPTIONS, *(str(ROOT / "tests" / test) for test in tests)], plugins=[hunt])
    return int(hunt.done < len(modules) or NO_REASON in RESULTS.read_text("utf-8"))


if __name__ == "__main__":
    for module in MODULES:
        importlib.import_module(name_of(module))
    make_tables_once()
    sys.exit(main(sys.argv[1:]))
