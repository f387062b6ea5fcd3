"""`resume=True` after a change of something that a function names: no store may hold points of two models.

Every model is text before and after a change; its points are a function of the changed thing, so the right answer to
`resume=True` is a refusal, and for changes without influence the same dataset.
"""

import importlib
import sys
import threading

import pytest

import flexmb as fm
from flexmb.engine.compiled.digest import digest
from flexmb.model import field, record

CHANGES = {
    "global number": ("GAIN = 2.0\ndef f(a):\n    return GAIN * a\n", "GAIN = 2.0", "GAIN = 3.0"),
    "global tuple": ("GAIN = (2.0, 1)\ndef f(a):\n    return GAIN[0] * a\n", "2.0", "3.0"),
    "dictionary": ("SET = {'x': 1.0, 'gain': 2.0}\ndef f(a):\n    return SET['gain'] * a\n", "2.0", "3.0"),
    "nested dictionary": (
        "SET = {'x': [{'gain': 2.0}]}\ndef f(a):\n    return SET['x'][0]['gain'] * a\n",
        "2.0",
        "3.0",
    ),
    "array": ("import numpy as np\nGAIN = np.array([1.0, 2.0])\ndef f(a):\n    return GAIN[1] * a\n", "2.0", "3.0"),
    "masked array": (
        "import numpy as np\nT = np.ma.array([1.0, 2.0], mask=[0, 1])\ndef f(a):\n    return float(T.sum()) * a\n",
        "[0, 1]",
        "[0, 0]",
    ),
    "structured array": (
        "import numpy as np\nT = np.array([(2.0, 3)], [('x', float), ('y', int)])\n"
        "def f(a):\n    return float(T['x'][0]) * a\n",
        "[('x', float), ('y', int)]",
        "[('y', float), ('x', int)]",
    ),
    "order of a dictionary": (
        "SET = {'x': 2.0, 'y': 3.0}\ndef f(a):\n    return list(SET.values())[0] * a\n",
        "{'x': 2.0, 'y': 3.0}",
        "{'y': 3.0, 'x': 2.0}",
    ),
    "factory of a dictionary": (
        "import collections\nSET = collections.defaultdict(lambda: 2.0)\ndef f(a):\n    return SET['x'] * a\n",
        "2.0",
        "3.0",
    ),
    "set": ("LIMITS = {'2.0'}\ndef f(a):\n    return float(*LIMITS) * a\n", "2.0", "3.0"),
    "helper": ("def gain():\n    return 2.0\ndef f(a):\n    return gain() * a\n", "2.0", "3.0"),
    "helper's global": ("G = 2.0\ndef gain():\n    return G\ndef f(a):\n    return gain() * a\n", "G = 2.0", "G = 3.0"),
    "helper of a helper": (
        "def inner(k=2.0):\n    return k\ndef gain():\n    return inner()\ndef f(a):\n    return gain() * a\n",
        "2.0",
        "3.0",
    ),
    "lambda": ("gain = lambda: 2.0\ndef f(a):\n    return gain() * a\n", "2.0", "3.0"),
    "lambda's global": ("G = 2.0\ngain = lambda: G\ndef f(a):\n    return gain() * a\n", "G = 2.0", "G = 3.0"),
    "other lambda of a line": (
        "x, y = (lambda a: 2.0 * a), (lambda a: 3.0 * a)\nh = x\ndef f(a):\n    return h(a)\n",
        "h = x",
        "h = y",
    ),
    "method of a named tuple": (
        "from typing import NamedTuple\nclass Set(NamedTuple):\n    gain: float\n    def of(self, a):\n"
        "        return 2.0 * self.gain * a\nSET = Set(1.0)\ndef f(a):\n    return SET.of(a)\n",
        "2.0",
        "3.0",
    ),
    "tuple for a list": (
        "import numpy as np\nAT = [0, 1]\ndef f(a):\n    return np.eye(2)[AT].sum() * a\n",
        "[0, 1]\n",
        "(0, 1)\n",
    ),
    "attribute of a class's class": (
        "class Kind(type):\n    gain = 2.0\nclass Set(metaclass=Kind):\n    pass\ndef f(a):\n    return Set.gain * a\n",
        "2.0",
        "3.0",
    ),
    "attribute of a function": ("def f(a):\n    return f.gain * a\nf.gain = 2.0\n", "2.0", "3.0"),
    "attribute of a class": ("class Set:\n    gain = 2.0\ndef f(a):\n    return Set.gain * a\n", "2.0", "3.0"),
    "attribute set later": ("class Set:\n    pass\ndef f(a):\n    return Set.gain * a\nSet.gain = 2.0\n", "2.0", "3.0"),
    "base class": (
        "class Base:\n    gain = 2.0\nclass Set(Base):\n    pass\ndef f(a):\n    return Set.gain * a\n",
        "2.0",
        "3.0",
    ),
    "method": (
        "class Set:\n    def gain(self):\n        return 2.0\ndef f(a):\n    return Set().gain() * a\n",
        "2.0",
        "3.0",
    ),
    "method's global": (
        "G = 2.0\nclass Set:\n    def gain(self):\n        return G\nS = Set()\ndef f(a):\n    return S.gain() * a\n",
        "G = 2.0",
        "G = 3.0",
    ),
    "property": (
        "class Set:\n    @property\n    def gain(self):\n        return 2.0\nS = Set()\ndef f(a):\n"
        "    return S.gain * a\n",
        "2.0",
        "3.0",
    ),
    "static method": (
        "class Set:\n    @staticmethod\n    def gain():\n        return 2.0\ndef f(a):\n    return Set.gain() * a\n",
        "2.0",
        "3.0",
    ),
    "class method": (
        "class Set:\n    @classmethod\n    def gain(cls):\n        return 2.0\ndef f(a):\n    return Set.gain() * a\n",
        "2.0",
        "3.0",
    ),
    "attribute of an object": (
        "class Set:\n    def __init__(self, gain):\n        self.gain = gain\nS = Set(2.0)\ndef f(a):\n"
        "    return S.gain * a\n",
        "Set(2.0)",
        "Set(3.0)",
    ),
    "slots": (
        "class Set:\n    __slots__ = ('gain',)\nS = Set()\nS.gain = 2.0\ndef f(a):\n    return S.gain * a\n",
        "2.0",
        "3.0",
    ),
    "dataclass": (
        "from dataclasses import dataclass\n@dataclass\nclass Set:\n    gain: float = 1.0\n    def of(self, a):\n"
        "        return 2.0 * a\nS = Set()\ndef f(a):\n    return S.of(a)\n",
        "2.0",
        "3.0",
    ),
    "callable object": (
        "G = 2.0\nclass Gain:\n    def __call__(self, a):\n        return G * a\nf = Gain()\n",
        "G = 2.0",
        "G = 3.0",
    ),
    "enumeration": (
        "from enum import Enum\nclass Kind(Enum):\n    GAIN = 2.0\ndef f(a):\n    return Kind.GAIN.value * a\n",
        "2.0",
        "3.0",
    ),
    "closure": ("def make(g):\n    def f(a):\n        return g * a\n    return f\nf = make(2.0)\n", "2.0", "3.0"),
    "closure of a closure": (
        "def make(g):\n    def inner():\n        return g\n    def f(a):\n        return inner() * a\n    return f\n"
        "f = make(2.0)\n",
        "2.0",
        "3.0",
    ),
    "inner function": (
        "G = 2.0\ndef f(a):\n    def inner():\n        return G * a\n    return inner()\n",
        "G = 2.0",
        "G = 3.0",
    ),
    "comprehension": ("G = 2.0\ndef f(a):\n    return sum([G * x for x in (a,)])\n", "G = 2.0", "G = 3.0"),
    "class within": (
        "G = 2.0\ndef f(a):\n    class Set:\n        gain = G\n    return Set.gain * a\n",
        "G = 2",
        "G = 3",
    ),
    "default": ("def f(a, g=2.0):\n    return g * a\n", "2.0", "3.0"),
    "default of a name": ("G = 2.0\ndef f(a, *, g=G):\n    return g * a\n", "2.0", "3.0"),
    "default function": (
        "G = 2.0\ndef gain():\n    return G\ndef f(a, g=gain):\n    return g() * a\n",
        "G = 2",
        "G = 3",
    ),
    "partial": (
        "from functools import partial\ndef whole(g, a):\n    return g * a\nf = partial(whole, 2.0)\n",
        "2.0",
        "3.0",
    ),
    "decorator": (
        "from functools import wraps\ndef times(g):\n    def around(f):\n        @wraps(f)\n        def called(a):\n"
        "            return g * f(a)\n        return called\n    return around\nG = 2.0\n@times(G)\ndef f(a):\n"
        "    return a\n",
        "G = 2.0",
        "G = 3.0",
    ),
    "cached": (
        "from functools import cache\nG = 2.0\n@cache\ndef gain():\n    return G\ndef f(a):\n    return gain() * a\n",
        "G = 2.0",
        "G = 3.0",
    ),
    "single dispatch": (
        "from functools import singledispatch\n@singledispatch\ndef gain(a):\n    return 0.0\n"
        "@gain.register(float)\ndef _(a):\n    return 2.0 * a\ndef f(a):\n    return gain(a)\n",
        "2.0",
        "3.0",
    ),
    "compiled by numba": (
        "import numba\nG = 2.0\n@numba.njit\ndef gain(a):\n    return G * a\ndef f(a):\n    return gain(a)\n",
        "G = 2.0",
        "G = 3.0",
    ),
    "mutual calls": (
        "G = 2.0\ndef even(n):\n    return G if n == 0 else odd(n - 1)\ndef odd(n):\n    return even(n - 1)\n"
        "def f(a):\n    return even(2) * a\n",
        "G = 2.0",
        "G = 3.0",
    ),
    "by globals()": ("G = 2.0\ndef f(a):\n    return globals()['G'] * a\n", "G = 2.0", "G = 3.0"),
    "a global that is written": (
        "G = 2.0\ndef f(a):\n    global G\n    G = G + 0.0\n    return G * a\n",
        "G = 2.0\n",
        "G = 3.0\n",
    ),
    "operator": (
        "import operator\nop = operator.mul\ndef f(a):\n    return op(a, 2)\n",
        "= operator.mul",
        "= operator.add",
    ),
    "bound method": (
        "class Set:\n    def __init__(self):\n        self.gain = 2.0\n    def of(self, a):\n"
        "        return self.gain * a\n"
        "f = Set().of\n",
        "2.0",
        "3.0",
    ),
    "random numbers": (
        "import numpy as np\nuniform = np.random.default_rng(2).uniform\ndef f(a):\n    return uniform() * a\n",
        "(2)",
        "(3)",
    ),
    "mechanism": (
        "import flexmb as fm\nB = fm.RigidBody('b', (0.0, 0.0), mass=2.0, inertia=1.0)\nM = fm.Mechanism('m', [B])\n"
        "def f(a):\n    return M['b'].mass * a\n",
        "mass=2.0",
        "mass=3.0",
    ),
}
"""Text of a model, and what changes in it."""

OTHER_MODULES = {
    "attribute of a module": "import zz_numbers\ndef f(a):\n    return zz_numbers.GAIN * a\n",
    "renamed module": "import zz_numbers as n\ndef f(a):\n    return n.GAIN * a\n",
    "imported number": "from zz_numbers import GAIN\ndef f(a):\n    return GAIN * a\n",
    "function of a module": "import zz_numbers\ndef f(a):\n    return zz_numbers.gain() * a\n",
    "imported within": "def f(a):\n    import zz_numbers\n    return zz_numbers.GAIN * a\n",
    "taken within": "def f(a):\n    from zz_numbers import GAIN\n    return GAIN * a\n",
    "by getattr": "import zz_numbers\ndef f(a):\n    return getattr(zz_numbers, 'GAIN') * a\n",
    "module handed on": "import zz_numbers\ndef of(m):\n    return m.GAIN\ndef f(a):\n    return of(zz_numbers) * a\n",
}
"""Models that take a number from another module."""

PACKAGE = {
    "module of a package": "import zz_package.numbers\ndef f(a):\n    return zz_package.numbers.GAIN * a\n",
    "taken within": "def f(a):\n    from zz_package.numbers import GAIN\n    return GAIN * a\n",
    "module taken within": "def f(a):\n    from zz_package import numbers\n    return numbers.GAIN * a\n",
    "whole path within": "def f(a):\n    import zz_package.numbers\n    return zz_package.numbers.GAIN * a\n",
    "relative": "def f(a):\n    from .numbers import GAIN\n    return GAIN * a\n",
    "relative module": "def f(a):\n    from . import numbers\n    return numbers.GAIN * a\n",
}
"""Models that take a number from a module of a package; the last ones lie in it."""

NUMBERS = "import math\nOTHER = 1.0\nGAIN = 2.0\ndef gain():\n    return GAIN\n"


@pytest.fixture
def model(tmp_path, monkeypatch):
    """A function that writes modules and returns the function `f` of zz_model as it is in a new process."""
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)

    def written(**texts):
        for name, text in texts.items():
            (tmp_path / f"{name}.py").write_text(text)
        importlib.invalidate_caches()
        for name in ("zz_model", "zz_numbers"):
            sys.modules.pop(name, None)
        __import__("linecache").checkcache()
        return importlib.import_module("zz_model").f

    yield written
    for name in ("zz_model", "zz_numbers"):
        sys.modules.pop(name, None)


def swept(function, store, **more):
    return fm.sweep(function, {"a": [1.0, 2.0]}, store=store, **more)


@pytest.mark.quick(12)
@pytest.mark.parametrize("kind", CHANGES)
def test_another_model_is_refused(kind, model, tmp_path):
    text, old, new = CHANGES[kind]
    first = model(zz_model=text)
    before = swept(first, tmp_path / "s")
    (tmp_path / "s" / "status" / "c" / "1").unlink()  # unfinished
    same = model(zz_model=text)
    if kind != "random numbers":
        assert swept(same, tmp_path / "s", resume=True).identical(before)
        (tmp_path / "s" / "status" / "c" / "1").unlink()
    assert text.count(old) >= 1
    with pytest.raises(fm.errors.InputError, match="written by another sweep"):
        swept(model(zz_model=text.replace(old, new)), tmp_path / "s", resume=True)


@pytest.mark.parametrize("kind", OTHER_MODULES)
def test_another_module_is_refused(kind, model, tmp_path):
    texts = {"zz_model": OTHER_MODULES[kind], "zz_numbers": NUMBERS}
    before = swept(model(**texts), tmp_path / "s")
    assert before["value"].values.tolist() == [2.0, 4.0]
    (tmp_path / "s" / "status" / "c" / "1").unlink()
    if kind != "module handed on":  # of a module that is handed on everything counts
        other = NUMBERS.replace("OTHER = 1.0", "OTHER = 5.0  # of no influence")
        assert swept(model(zz_numbers=other), tmp_path / "s", resume=True).identical(before)
        (tmp_path / "s" / "status" / "c" / "1").unlink()
    with pytest.raises(fm.errors.InputError, match="written by another sweep"):
        swept(model(zz_numbers=NUMBERS.replace("GAIN = 2.0", "GAIN = 3.0")), tmp_path / "s", resume=True)


@pytest.mark.parametrize("kind", PACKAGE)
def test_another_module_of_a_package_is_refused(kind, tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    (tmp_path / "zz_package").mkdir()
    inner = kind.startswith("relative")
    file = tmp_path / ("zz_package/model.py" if inner else "zz_model.py")
    for name, text in (("__init__", ""), ("numbers", NUMBERS)):
        (tmp_path / "zz_package" / f"{name}.py").write_text(text)
    file.write_text(PACKAGE[kind])

    def function():
        importlib.invalidate_caches()
        for name in ("zz_package", "zz_package.numbers", "zz_package.model", "zz_model"):
            sys.modules.pop(name, None)
        return importlib.import_module("zz_package.model" if inner else "zz_model").f

    before = swept(function(), tmp_path / "s")
    assert before["value"].values.tolist() == [2.0, 4.0]
    assert swept(function(), tmp_path / "s", resume=True).identical(before)
    (tmp_path / "zz_package" / "numbers.py").write_text(NUMBERS.replace("GAIN = 2.0", "GAIN = 3.0"))
    with pytest.raises(fm.errors.InputError, match="written by another sweep"):
        swept(function(), tmp_path / "s", resume=True)
    for name in ("zz_package", "zz_package.numbers", "zz_package.model", "zz_model"):
        sys.modules.pop(name, None)


def test_a_file_that_was_edited_after_its_import_is_not_the_model(model, tmp_path):
    """A process goes on with the code that it has imported, under whatever text."""
    text = "def f(a):\n    return 2.0 * a\n"
    old = model(zz_model=text)
    (tmp_path / "zz_model.py").write_text(text.replace("2.0", "3.0"))
    assert swept(old, tmp_path / "s")["value"].values.tolist() == [2.0, 4.0]
    with pytest.raises(fm.errors.InputError, match="written by another sweep"):
        swept(model(zz_model=text.replace("2.0", "3.0")), tmp_path / "s", resume=True)


def test_the_message_names_the_global(model, tmp_path):
    text = "GAIN, LEFT = 2.0, 1.0\ndef f(a):\n    return GAIN * a + LEFT\n"
    swept(model(zz_model=text), tmp_path / "s")
    with pytest.raises(fm.errors.InputError, match=r"global GAIN: [0-9a-f]{16} there, [0-9a-f]{16} now; text"):
        swept(model(zz_model=text.replace("2.0", "3.0")), tmp_path / "s", resume=True)


def test_an_object_whose_content_cannot_be_told_is_named(model, tmp_path):
    """A lock has no content that could be compared: the sweep runs, its store is not gone on with."""
    text = "import threading\nLOCK = threading.Lock()\ndef f(a):\n    with LOCK:\n        return 2.0 * a\n"
    assert swept(model(zz_model=text), tmp_path / "s")["value"].values.tolist() == [2.0, 4.0]
    with pytest.raises(fm.errors.InputError, match=r"cannot be told .*global LOCK \(_thread\.lock\)"):
        swept(model(zz_model=text), tmp_path / "s", resume=True)
    assert "but for _thread.lock" in digest([threading.Lock()])


@record
class Own(fm.friction.SmoothCoulomb):
    """A law of a user, with a constructor of its own, which flexmb wraps."""

    gain: float = field("a number of one's own", default=1.0)

    def __post_init__(self):
        super().__post_init__()
        assert self.gain > 0.0


def test_an_own_law_with_a_constructor_can_be_told():
    """What the wrapper of its constructor names is flexmb's, and no part of the law."""
    assert len(digest(Own(0.1))) == len(digest(1.0))
    assert digest(Own(0.1)) == digest(Own(0.1, gain=1.0)) != digest(Own(0.1, gain=2.0))


def orbit(a, law):
    """A map that forgets its start."""
    return fm.chaos.Map(lambda x: 0.5 * x + law["gain"] * a, [0.1])


def test_an_argument_that_stays_fixed_is_named(tmp_path):
    def go(**more):
        law = {"gain": 1.0, "lock": threading.Lock()}
        return fm.bifurcation(orbit, "a", [0.1, 0.2], fixed={"law": law}, skip=1, keep=2, store=tmp_path / "s", **more)

    go()
    with pytest.raises(fm.errors.InputError, match=r"cannot be told .*law \(_thread\.lock\)"):
        go(resume=True)


def test_a_leftover_folder_and_a_long_name(tmp_path):
    def f(a):
        return 2.0 * a

    before = swept(f, tmp_path / "s")
    (tmp_path / "s" / "x.partial").mkdir()
    assert swept(f, tmp_path / "s", resume=True).identical(before)
    with pytest.raises(fm.errors.InputError, match="File name too long"):
        swept(f, tmp_path / ("x" * 300))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("# a remark", "# another remark"),
        ("UNUSED = 1.0", "UNUSED = 2.0"),
        ("def other():\n    return 1", "def other():\n    return 2"),
    ],
)
def test_what_the_function_does_not_name_is_free(old, new, model, tmp_path):
    text = "UNUSED = 1.0\ndef other():\n    return 1\ndef f(a):\n    return 2.0 * a  # a remark\n"
    before = swept(model(zz_model=text), tmp_path / "s")
    assert swept(model(zz_model=text.replace(old, new)), tmp_path / "s", resume=True).identical(before)


def test_typed_in_functions_count_with_their_inner_functions():
    def typed(text):
        space = {"__name__": "__main__"}
        exec(text, space)  # as at a prompt
        return digest(space["f"])

    text = "def f(a):\n    def inner():\n        return 2.0\n    return inner() * a\n"
    assert typed(text) == typed(text)
    assert typed(text) != typed(text.replace("2.0", "3.0"))
    assert typed("def f(a, b):\n    return a - b\n") != typed("def f(b, a):\n    return b - a\n")
