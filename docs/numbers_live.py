"""A build of flexmb whose numbers are read at run time, so that one compilation serves all their values.

numba freezes what a module holds into the machine code.  Here the modules are rewritten as they are imported: inside
functions the names of the listed constants, and listed literals, become calls of `read`, which loads a number from an
array of this module.  The machine code knows that array by the name of a symbol, so it may be cached between processes;
the cache is one for these sources and this list alone.

A place is a string: "engine.step.contact_events.ONSET_TOLERANCE" for a constant,
"engine.newmark.error_control.accept_or_reject#0.9" for a literal inside a function (of a class:
"run.run.Run._limits#0.01"), wherever it stands in it.
"""

import ast
import hashlib
import importlib
import importlib.machinery
import os
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
SYMBOL = "flexmb_live_numbers"
ROOM = 512
"""Numbers that there may be."""

VALUES = np.zeros(ROOM)
"""What the compiled functions read."""


def read(k: int) -> float:
    """Number k of the build."""
    return float(VALUES[k])


def read_whole(k: int) -> int:
    """Number k of the build, of those that count."""
    return int(VALUES[k])


class Place:
    """A number of the sources.

    Parameters
    ----------
    text : as the module says.
    k : its place in `VALUES`.
    """

    def __init__(self, text: str, k: int) -> None:
        path, _, literal = text.partition("#")
        self.text, self.k = text, k
        parts = path.split(".")
        size = max(n for n in range(1, len(parts)) if (ROOT / "flexmb" / Path(*parts[:n])).with_suffix(".py").exists())
        self.module, self.name = ".".join(["flexmb", *parts[:size]]), ".".join(parts[size:])
        self.literal = ast.literal_eval(literal) if literal else None
        self.value = self._found() if self.literal is None else self.literal

    @property
    def file(self) -> Path:
        """Where the number stands."""
        return ROOT.joinpath(*self.module.split(".")).with_suffix(".py")

    def _found(self) -> float:
        for name, value in constants(ast.parse(self.file.read_text(encoding="utf-8"))):
            if name == self.name:
                return ast.literal_eval(value)
        raise LookupError(f"{self.text}: {self.file.name} has no such constant.")


def constants(tree: ast.Module) -> Iterator[tuple[str, ast.expr]]:
    """Names that a module gives to values, one by one, with what stands on their right side."""
    for node in tree.body:
        if isinstance(node, ast.AnnAssign) and node.value is not None and isinstance(node.target, ast.Name):
            yield node.target.id, node.value
        for target in node.targets if isinstance(node, ast.Assign) else ():
            if isinstance(target, ast.Name):
                yield target.id, node.value
            elif isinstance(target, ast.Tuple):
                several = isinstance(node.value, ast.Tuple)
                for i, one in enumerate(target.elts):
                    yield one.id, (node.value.elts[i] if several else node.value)


class Rewriter(ast.NodeTransformer):
    """What puts calls of `read` where the functions of a module use listed numbers.

    Parameters
    ----------
    module : full name of the module.
    names : place by the name that the module knows a constant by, "module.NAME" for one of a module that it imports.
    literals : places of literals in this module.
    """

    def __init__(self, module: str, names: dict[str, Place], literals: Sequence[Place]) -> None:
        self.module, self.names, self.literals = module, names, literals
        self.inside: list[str] = []
        self.functions = 0
        self.met: set[str] = set()

    def visit_ClassDef(self, node: ast.ClassDef) -> ast.AST:
        """Go into a class."""
        self.inside.append(node.name)
        self.generic_visit(node)
        self.inside.pop()
        return node

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        """Go into the body of a function, and leave its decorators and defaults alone."""
        self.inside.append(node.name)
        self.functions += 1
        node.body = [self.visit(line) for line in node.body]
        self.functions -= 1
        self.inside.pop()
        return node

    def visit_Name(self, node: ast.Name) -> ast.AST:
        """Put a call in the place of a constant."""
        if self.functions == 0 or node.id not in self.names or not isinstance(node.ctx, ast.Load):
            return node
        return self._call(self.names[node.id], node)

    def visit_Attribute(self, node: ast.Attribute) -> ast.AST:
        """Put a call in the place of a constant of another module."""
        place = self.names.get(ast.unparse(node)) if self.functions and isinstance(node.ctx, ast.Load) else None
        return self.generic_visit(node) if place is None else self._call(place, node)

    def visit_Constant(self, node: ast.Constant) -> ast.AST:
        """Put a call in the place of a literal."""
        path = ".".join(self.inside)
        for place in self.literals if self.functions else ():
            if place.name == path and type(node.value) is type(place.literal) and node.value == place.literal:
                return self._call(place, node)
        return node

    def _call(self, place: Place, node: ast.expr) -> ast.AST:
        self.met.add(place.text)
        reader = "_live_read_whole" if isinstance(place.value, int) else "_live_read"
        call = ast.Call(ast.Name(reader, ast.Load()), [ast.Constant(place.k)], [])
        return ast.fix_missing_locations(ast.copy_location(call, node))


def rewritten(module: str, source: str, places: Sequence[Place]) -> tuple[ast.Module, set[str]]:
    """The tree of a module that reads its numbers, and which places it met."""
    tree = ast.parse(source)
    held = [p for p in places if p.literal is None]
    names = {p.name: p for p in held if p.module == module}
    for node in tree.body:
        for alias in node.names if isinstance(node, ast.Import | ast.ImportFrom) else ():
            own, home = alias.asname or alias.name, getattr(node, "module", None)
            other = alias.name if home is None else f"{home}.{alias.name}"
            found = {own if p.module == home else f"{own}.{p.name}": p for p in held
                     if p.module == other or (p.module, p.name) == (home, alias.name)}  # fmt: skip
            names |= found
    literals = [p for p in places if p.module == module and p.literal is not None]
    if not names and not literals:
        return tree, set()
    rewriter = Rewriter(module, names, literals)
    tree = rewriter.visit(tree)
    readers = [ast.alias("read", "_live_read"), ast.alias("read_whole", "_live_read_whole")]
    after = 1 + max(i for i, node in enumerate(tree.body) if i == 0 or getattr(node, "module", "") == "__future__")
    tree.body.insert(after, ast.ImportFrom("numbers_live", readers, 0))
    return ast.fix_missing_locations(tree), rewriter.met


class Loader(importlib.machinery.SourceFileLoader):
    """The loader of a module of flexmb whose numbers are read; bytecode is not kept."""

    places: Sequence[Place] = ()

    def get_code(self, fullname: str):
        """The code of the rewritten source."""
        path = self.get_filename(fullname)
        tree, _ = rewritten(fullname, self.get_data(path).decode("utf-8"), self.places)
        return compile(tree, path, "exec", dont_inherit=True)


class Finder:
    """The finder that gives modules of flexmb our loader."""

    @staticmethod
    def find_spec(fullname: str, path=None, target=None):
        """The spec of a module of flexmb, None for all others."""
        if fullname.partition(".")[0] != "flexmb":
            return None
        spec = importlib.machinery.PathFinder.find_spec(fullname, path or [str(ROOT)], target)
        if spec is not None and type(spec.loader) is importlib.machinery.SourceFileLoader:
            spec.loader = Loader(spec.loader.name, spec.loader.path)
        return spec


class Build:
    """The rewritten flexmb of this process; made before flexmb is imported.

    Parameters
    ----------
    texts : the places whose numbers may be changed.
    cache : folder of the caches of such builds.
    """

    def __init__(self, texts: Sequence[str], cache: Path) -> None:
        if "flexmb" in sys.modules or "numba" in sys.modules:
            raise RuntimeError("flexmb or numba was imported before its numbers could be made readable.")
        self.places = {text: Place(text, k) for k, text in enumerate(texts)}
        os.environ["NUMBA_CACHE_DIR"] = str(cache / self._stamp())
        Loader.places = tuple(self.places.values())
        self.reset()
        _teach_numba()
        sys.meta_path.insert(0, Finder())
        # A second process would compile the sources as they stand, and no number would change.
        importlib.import_module("flexmb.engine.compiled.ahead").cores = lambda: 1

    def _stamp(self) -> str:
        """A name for these sources with this list; every place has to be met somewhere."""
        places, met = list(self.places.values()), set()
        digest = hashlib.sha256(Path(__file__).read_bytes())
        for file in sorted((ROOT / "flexmb").rglob("*.py")):
            name = ".".join(file.relative_to(ROOT).with_suffix("").parts)
            tree, seen = rewritten(name, file.read_text(encoding="utf-8"), places)
            met |= seen
            digest.update(ast.unparse(tree).encode())
        lost = [p.text for p in places if p.text not in met and not self._of_an_attribute(p)]
        if lost:
            raise LookupError(f"No function uses {', '.join(lost)}.")
        return digest.hexdigest()[:16]

    @staticmethod
    def _of_an_attribute(place: Place) -> bool:
        return place.literal is None and "." not in place.name

    def set(self, text: str, value: float) -> None:
        """Give a number another value, for all that is run from now on."""
        place = self.places[text]
        VALUES[place.k] = value
        module = sys.modules.get(place.module)
        if module is not None and place.literal is None:
            setattr(module, place.name, type(place.value)(value))

    def reset(self) -> None:
        """Give all numbers the values of the sources."""
        for text, place in self.places.items():
            self.set(text, place.value)


def _teach_numba() -> None:
    """Make `read` and `read_whole` loads from the array, known to the machine code as an external symbol."""
    import llvmlite.binding  # noqa: PLC0415 - where a cache lies must be said before
    from llvmlite import ir  # noqa: PLC0415
    from numba import types  # noqa: PLC0415
    from numba.extending import lower_builtin, type_callable  # noqa: PLC0415

    llvmlite.binding.add_symbol(SYMBOL, VALUES.ctypes.data)

    def load(context, builder, k):
        array = builder.module.globals.get(SYMBOL)
        if array is None:
            array = ir.GlobalVariable(builder.module, ir.ArrayType(ir.DoubleType(), ROOM), SYMBOL)
        return builder.load(builder.gep(array, [ir.IntType(64)(0), k]))

    for reader, result in ((read, types.float64), (read_whole, types.int64)):
        type_callable(reader)(lambda context, result=result: lambda k: result)

    @lower_builtin(read, types.Integer)
    def lower_read(context, builder, signature, args):
        return load(context, builder, context.cast(builder, args[0], signature.args[0], types.int64))

    @lower_builtin(read_whole, types.Integer)
    def lower_whole(context, builder, signature, args):
        k = context.cast(builder, args[0], signature.args[0], types.int64)
        return builder.fptosi(load(context, builder, k), ir.IntType(64))
