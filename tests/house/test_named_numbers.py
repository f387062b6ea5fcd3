"""Compiled code reads tables, states and parameters by names: a literal is an index only where an order is natural."""

import ast
from collections.abc import Iterable, Iterator

import pytest
from trees import walk

COMPILERS = {"compiled", "fast", "summing", "apart"}
CONTRACTS = ("_kernel", "_law")
"""Decorators of compiled functions: by name, and those of kernels by how their names end."""

ORDERED = {
    "coordinates x, y, theta of nodes, the entries of rows and columns of matrices included": (
        "q v a x y r u f F X Y Jx Jy Gl"
    ),
    "rows of a constraint": "g gv gamma lam G H",
    "matrices of an element by its coordinates": "K C M A",
    "states before, newest first": "past projected_gaps",
}
"""Vectors whose entries have an order that needs no names, wherever they are, by that order."""

IN_FILES = {
    "flexmb/elastic/beams/corotational.py": {
        "accelerations and velocities of two ends in the axes of the chord": "chord_v chord_a",
        "forces on the ends, u1, u2 and alpha": "m n",
    },
    "flexmb/engine/dormand_prince/complement.py": {
        "a block of the matrix, row by row": "lu",
        "ends of what panels begin": "target_ptr",
    },
    "flexmb/engine/dormand_prince/tree.py": {"x and y of a point": "p"},
    "flexmb/engine/radau/method.py": {"ends and stages of a step, in time": "past_lam"},
    "flexmb/engine/radau/step.py": {
        "ends and stages of a step, in time": "past_lam b",
        "coordinates": "Q",
    },
    "flexmb/elastic/planes/cells.py": {"x and y of each node": "change own gain"},
    "flexmb/elastic/planes/elements.py": {
        "x and y of each node, and of a row of its stiffness": "d rate left right k p arms B",
        "components 11, 22, 12 of stress and strain": "S E D U V",
    },
    "flexmb/elastic/planes/loads.py": {"x and y of each node": "arms B"},
    "flexmb/elastic/beams/mass_damping.py": {"x and y of each node": "g u y f target"},
    "flexmb/elastic/planes/stress.py": {"x and y of each node": "d p places"},
    "flexmb/elastic/reduced/kernel.py": {
        "coordinates of nodes": "target of_x of_y w al rate total df both modal of_curve g1 g2 vt vs bd",
        "poses of nodes, in threes behind HEAD": "p",
    },
    "flexmb/elastic/reduced/peak_stress.py": {"x, y, theta of nodes, as deformed": "e"},
    "flexmb/engine/sensitivity/signal_rows.py": {"both sides of a difference": "pair"},
    "flexmb/engine/linalg/symbolic.py": {"columns before": "ptr parent"},
    "flexmb/engine/linalg/lu.py": {
        "a block of the matrix, row by row": "lu",
        "rows of a block": "seen order",
        "two right sides in turn": "pair",
    },
}
"""The same for names that mean this in one file only."""

LAST_INDEX = {"S"}
"""Jacobians of a contact: rows have names, columns are coordinates."""

BOUNDS = {
    *("dof", "row", "pos", "pos_g", "pos_h", "reaction", "reaction_on", "starts", "row_ptr"),
    *("first", "piece"),
    *("input", "output", "source_dof", "pos_state", "pos_load"),
}
"""Lists whose entry k + 1 is the end of what begins at entry k."""

TABLES = {
    "contact",
    "drive",
    "joint",
    "joint_friction",
    "loss",
    "slopes",
    "impacts",
    "episodes",
    "joint_friction_p",
    "joint_friction_z",
}
"""Fields of records whose columns have names in Python code, too."""

Function = ast.FunctionDef | ast.AsyncFunctionDef


def is_compiled(function: Function) -> bool:
    """Whether one of the decorators compiles the function."""
    names = map(last_name, function.decorator_list)
    return any(name in COMPILERS or name.endswith(CONTRACTS) for name in names)


def last_name(node: ast.expr) -> str:
    """'q' for q and for flow.q; nothing for what has no name."""
    return getattr(node, "id", getattr(node, "attr", ""))


def terms(index: ast.expr) -> Iterator[ast.expr]:
    """The terms of a sum; those of each entry of a tuple, of the ends of a slice, of both cases of a choice."""
    if isinstance(index, ast.BinOp) and isinstance(index.op, ast.Add | ast.Sub):
        parts = [index.left, index.right]
    elif isinstance(index, ast.UnaryOp):
        parts = [index.operand]
    elif isinstance(index, ast.IfExp):
        parts = [index.body, index.orelse]
    elif isinstance(index, ast.Tuple | ast.List):
        parts = index.elts
    elif isinstance(index, ast.Slice):
        parts = [end for end in (index.lower, index.upper) if end is not None]
    else:
        yield index
        return
    for part in parts:
        yield from terms(part)


def has_literal(index: ast.expr) -> bool:
    """Whether an integer literal is a term of an index."""
    return any(isinstance(term, ast.Constant) and type(term.value) is int for term in terms(index))


def origin(value: ast.expr, aliases: dict[str, str]) -> str:
    """The last name of what is indexed: 'contact' for work.contact[c], and for a local name that stands for it."""
    while isinstance(value, ast.Subscript) or (isinstance(value, ast.Call) and last_name(value.func) == "part_of"):
        value = value.value if isinstance(value, ast.Subscript) else value.args[0]
    return aliases.get(value.id, value.id) if isinstance(value, ast.Name) else last_name(value)


def aliases_in(function: Function) -> dict[str, str]:
    """Local names that stand for fields of records, for their rows or parts, by the name of the field."""
    found: dict[str, str] = {}
    for node in walk(function):
        if not isinstance(node, ast.Assign):
            continue
        for target in node.targets:
            several = isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple)
            pairs = zip(target.elts, node.value.elts, strict=True) if several else [(target, node.value)]
            for name, value in pairs:
                if isinstance(name, ast.Name) and isinstance(value, ast.Attribute | ast.Subscript | ast.Call):
                    found[name.id] = origin(value, found)
    return {name: field for name, field in found.items() if field}


def is_natural(path: str, node: ast.Subscript, name: str) -> bool:
    """Whether a literal may stand in this index of what has this name."""
    if name == "shape" or name in ordered(path):
        return True
    if name in LAST_INDEX and isinstance(node.slice, ast.Tuple):
        return not any(map(has_literal, node.slice.elts[:-1]))
    return name in BOUNDS and ast.unparse(node.slice).endswith((" + 1", " - 1"))


def ordered(path: str) -> set[str]:
    """Names of all vectors of a natural order in a file."""
    return {name for text in (*ORDERED.values(), *IN_FILES.get(path, {}).values()) for name in text.split()}


def subscripts(path: str, tree: ast.Module) -> Iterator[tuple[ast.Subscript, str]]:
    """Every subscript with a literal in compiled functions, and on tables everywhere; the name of what it is of."""
    for function in walk(tree):
        if not isinstance(function, Function):
            continue
        compiled, aliases = is_compiled(function), aliases_in(function)
        for node in walk(function):
            if isinstance(node, ast.Subscript) and has_literal(node.slice):
                name = origin(node.value, aliases)
                table = isinstance(node.value, ast.Attribute) and (name in TABLES or is_of_contacts(node.value))
                if compiled or table:
                    yield node, name


def is_of_contacts(value: ast.Attribute) -> bool:
    """Whether this is one of the tables contacts.kernel, contacts.p, contacts.z."""
    return value.attr in {"kernel", "p", "z"} and last_name(value.value) == "contacts"


def unnamed(path: str, tree: ast.Module) -> list[str]:
    """One line for each literal subscript that wants a name."""
    return without_names((path, *one) for one in subscripts(path, tree))


def without_names(met: Iterable[tuple[str, ast.Subscript, str]]) -> list[str]:
    """The same for subscripts with their files and names."""
    return [
        f"{path}:{node.lineno}: {ast.unparse(node)}" for path, node, name in met if not is_natural(path, node, name)
    ]


@pytest.fixture(scope="module")
def met(package_sources):
    """Every subscript of the package, with its file and name."""
    return [(source.path, *one) for source in package_sources for one in subscripts(source.path, source.tree)]


def test_compiled_code_reads_numbers_by_their_names(met):
    found = without_names(met)
    assert not found, f"{len(found)} literal subscripts without a name:\n" + "\n".join(found)


def test_every_order_is_one_that_compiled_code_uses(met):
    anywhere = {name for _, _, name in met}
    listed = {name for text in ORDERED.values() for name in text.split()} | LAST_INDEX | BOUNDS
    assert not listed - anywhere, f"listed, but gone: {listed - anywhere}"
    own = {(path, name) for path, texts in IN_FILES.items() for text in texts.values() for name in text.split()}
    assert not own - {(path, name) for path, _, name in met}, "listed for a file, but gone"


@pytest.mark.parametrize(
    "line",
    [
        "x = p[13]",
        "x = p[-1]",
        "x = p[13 + k]",
        "x = p[k if first else 3]",
        "x = p[2:4]",
        "x = E.p[e, 0]",
        "work.contact[c, 0] = 1.0",
        "work.contact[c, GAP_SIZE + 1] = 1.0",
        "row = work.loss[c]; x = row[2]",
        "S, row = el.scratch, part_of(work.contact, 0, n); x = row[2]",
        "x = flow.z[k + 2]",
        "x = z[0]",
        "out[9], out[10] = ex, ey",
        "x = S[0, j]",
        "x = direction(p, q)[0]",
        "x = C.dof[c + 2]",
        "x = m[3]",
    ],
)
def test_a_literal_subscript_is_found(line):
    code = f"@element_kernel\ndef f(p, q, z, out, work, S):\n    {line}"
    assert unnamed("flexmb/elastic/beams/some.py", ast.parse(code))


@pytest.mark.parametrize("decorator", ["@compiled", "@fast", "@kernels.gap_kernel", "@normal_law", "@apart"])
def test_every_compiled_function_is_looked_at(decorator):
    assert unnamed("flexmb/some.py", ast.parse(f"{decorator}\ndef f(p):\n    return p[13]"))
    assert not unnamed("flexmb/some.py", ast.parse("def f(p):\n    return p[13]"))


@pytest.mark.parametrize(
    "line", ["system.work.drive[rows, 0]", "tables.contacts.z[:, 0]", "flow.episodes[c, 3]", "self.contacts.p[:, 2:4]"]
)
def test_tables_are_looked_at_in_python_too(line):
    assert unnamed("flexmb/some.py", ast.parse(f"def f(rows):\n    return {line}"))


@pytest.mark.parametrize(
    "line",
    [
        "k, d, l0 = p",
        "x = p[STIFFNESS] * (q[3] - q[0])",
        "x = p[G11 + k] + p[6 * k]",
        "n = E.dof[e + 1] - E.dof[e]",
        "x = v[k + 2]",
        "n = x.shape[0]",
        "S[NORMAL, 0] = nx",
        "state = flow.q; x = state[2]",
        "x = flow.z[k + PHASE]",
    ],
)
def test_names_and_natural_orders_pass(line):
    code = f"@compiled\ndef f(p, q, v, E, S):\n    {line}"
    assert unnamed("flexmb/some.py", ast.parse(code)) == []
