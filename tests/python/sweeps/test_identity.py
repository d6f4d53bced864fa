"""What a store names a case by: values, and the code of functions and of what they use."""

import functools
import importlib
import os
import subprocess
import sys
import types
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy import special

import rustchain as rc
from rustchain.sweeps.case_run import is_of_user
from rustchain.sweeps.identity import digest_of

PAPER = rc.paper_drive()


class Own(Exception):
    pass


class Timed(Exception):
    step_size = 1e-9


def test_two_functions_of_one_code_are_the_same_and_any_change_is_another():
    def made(limit, text="def measure(r, a=1): return r + limit + a"):
        space = {"limit": limit, "__name__": "somewhere"}
        exec(text, space)
        return space["measure"]

    base = digest_of(made(1.0))
    assert digest_of(made(1.0)) == base
    assert digest_of(made(2.0)) != base
    for text in (
        "def measure(r, a=2): return r + limit + a",
        "def measure(r, a=1): return r - limit + a",
        "def measure(r, a=1): return r + limit + a + 0.5",
        "def inner(r): return 3\ndef measure(r, a=1): return inner(r)",
        "def inner(r): return 4\ndef measure(r, a=1): return inner(r)",
        "measure = lambda r, a=1: r + limit + a",
    ):
        other = digest_of(made(1.0, text))
        assert other != base
        assert digest_of(made(1.0, text)) == other
    text = "def inner(r): return {}\ndef measure(r): return [inner(x) for x in r]"
    calls = [digest_of(made(1.0, text.format(k))) for k in (3, 4)]
    assert calls[0] != calls[1]

    def closed(value):
        return lambda: value

    assert digest_of(closed(1)) == digest_of(closed(1)) != digest_of(closed(2))
    one, other = (functools.partial(made(1.0), a=a) for a in (1, 2))
    assert digest_of(one) != digest_of(other)

    def again(n):
        return again(n - 1) if n else 0

    assert digest_of(again)
    assert digest_of(np.arange(3.0)) != digest_of(np.arange(3))
    assert digest_of([1]) != digest_of((1,))


def test_values_that_differ_in_one_thing_have_other_identities():
    laws = (rc.Johnson(), rc.HertzCylinder(), rc.Radzimovsky(), rc.Esdu78035(), rc.LiuConformal())
    arrays = [np.zeros(shape, kind) for shape in (4, (2, 2)) for kind in (float, int)]
    arrays += [np.array([0.0, 0.0, 0.0, 1.0])]
    signed = [replace(PAPER, gravity=(zero, -9.8)) for zero in (0.0, -0.0)]
    values = [*laws, *arrays, *signed, {"a": 1}, {"b": 1}, b"a", b"b", slice(1), slice(2)]
    methods = [np.random.default_rng(seed).normal for seed in (1, 2)]
    methods += [[3].count, [4].count, [4].index]
    partial = [functools.partial(max, *values, key=key) for values in ((1,), (2,)) for key in "ab"]
    values += [*methods, *partial, np.sin, np.cos, len, max, Own, Timed]
    assert len({digest_of(value) for value in values}) == len(values)


@pytest.mark.parametrize(
    ("text", "old", "new"),
    [
        ("def measure(r): return r.peaks", "peaks", "energy"),
        ("def measure(r, *, a=1): return a", "a=1", "a=2"),
        ("import math as m\ndef measure(r): return m.sqrt(r)", "math", "cmath"),
        ("f = {1: 'a'}.get\ndef measure(r): return f(r)", "'a'", "'b'"),
        ("import re\nf = re.compile('a').search\ndef measure(r): return f(r)", "'a'", "'b'"),
        ("def measure(r): return measure.limit\nmeasure.limit = 1", "= 1", "= 2"),
        ("def f(*v): return max(v)\ndef measure(r): return f(r)", "*v", "v"),
        ("def f(a, b): return a - b\ndef measure(r): return f(a=r, b=1)", "a, b", "b, a"),
        ("def f(a): return f.g(a)\nf.g = lambda a: a + 1\nmeasure = f", "+ 1", "+ 2"),
    ],
)
def test_names_methods_of_values_arguments_and_attributes_of_functions_count(text, old, new):
    def digest(text):
        space = {"__name__": "somewhere"}
        exec(text, space)
        return digest_of(space["measure"])

    assert digest(text) == digest(text)
    assert digest(text) != digest(text.replace(old, new))


OF_CLASSES = """
import functools

class Base:
    factor = 2.0

    def one(self, result):
        return result + 1

class Measure(Base):
    limits = [1.0, 2.0]

    def __init__(self, inner=None):
        self.inner = inner

    def __call__(self, result):
        return self.one(result) * self.factor

    def bound(self, result):
        return self.one(result)

    @property
    def half(self):
        return 0.5

    @functools.cached_property
    def third(self):
        return 0.75

class Helper:
    @staticmethod
    def two(result):
        return result + 2

@functools.lru_cache
def cached(result):
    return result + 3

def plain(result):
    return result + 4

def calls_cached(result):
    return cached(result)

def calls_helper(result):
    return Helper.two(result)

instance = Measure()
bound = Measure().bound
holds = Measure(plain)
part = functools.partial(cached)
"""


@pytest.mark.parametrize(
    ("name", "old", "new"),
    [
        ("instance", "factor = 2.0", "factor = 3.0"),
        ("instance", "[1.0, 2.0]", "[1.0, 2.5]"),
        ("instance", "result + 1", "result + 10"),
        ("instance", "return 0.5", "return 0.25"),
        ("instance", "return 0.75", "return 0.7"),
        ("bound", "result + 1", "result + 10"),
        ("bound", "factor = 2.0", "factor = 3.0"),
        ("holds", "result + 4", "result + 40"),
        ("calls_helper", "result + 2", "result + 20"),
        ("calls_cached", "result + 3", "result + 30"),
        ("cached", "result + 3", "result + 30"),
        ("part", "result + 3", "result + 30"),
    ],
)
def test_classes_and_helpers_of_the_module_of_a_measure_count(name, old, new, monkeypatch):
    def digest(text):
        module = types.ModuleType("of_classes")
        monkeypatch.setitem(sys.modules, "of_classes", module)
        exec(text, vars(module))
        return digest_of(getattr(module, name))

    assert old in OF_CLASSES
    base = digest(OF_CLASSES)
    assert digest(OF_CLASSES) == base
    assert digest(OF_CLASSES.replace(old, new)) != base


HELPERS = """
import threading

lock = threading.Lock()
factor = 2.0

def peak(result):
    with lock:
        return result * factor

class Base:
    def __call__(self, result):
        return self.one(result)
"""
OF_HELPERS = [
    ("from of_helpers import peak\ndef measure(r): return peak(r)", "result * factor"),
    ("import of_helpers\ndef measure(r): return of_helpers.peak(r)", "factor = 2.0"),
    ("import of_helpers\ndef measure(r): return [of_helpers.factor for _ in r]", "factor = 2.0"),
    ("import of_helpers as h\ndef inner(r): return h.peak(r)\nmeasure = lambda r: inner(r)", "2.0"),
    ("from of_helpers import Base\nclass Of(Base): one = abs\nmeasure = Of()", "self.one(result)"),
    ("from of_helpers import Base\ndef measure(r): return Base()(r)", "self.one(result)"),
    (
        "import of_helpers\ndef measure(r):\n with of_helpers.lock: return of_helpers.peak(r)",
        "result * factor",
    ),
]


@pytest.mark.parametrize(("text", "old"), OF_HELPERS)
def test_code_of_the_users_other_modules_counts(text, old, tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path)

    def digest(helpers):
        (tmp_path / "of_helpers.py").write_text(helpers)
        for name in ("of_helpers", "of_measure"):
            monkeypatch.delitem(sys.modules, name, raising=False)
        importlib.invalidate_caches()
        measures = types.ModuleType("of_measure")
        monkeypatch.setitem(sys.modules, "of_measure", measures)
        exec(text, vars(measures))
        return digest_of(measures.measure)

    base = digest(HELPERS)
    assert digest(HELPERS + "other = 3") == base
    assert digest(HELPERS.replace(old, old.replace("2.0", "3.0") + " + 1")) != base


@pytest.mark.parametrize("folder", ["of_tools", "rustchain_study"])
def test_code_of_a_folder_without_init_counts(folder, tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / folder).mkdir()

    def digest(factor):
        (tmp_path / folder / "helpers.py").write_text(f"factor = {factor}\n")
        for name in (folder, f"{folder}.helpers"):
            monkeypatch.delitem(sys.modules, name, raising=False)
        importlib.invalidate_caches()
        space = {"__name__": "somewhere"}
        exec(f"import {folder}.helpers\ndef measure(r): return {folder}.helpers.factor", space)
        return digest_of(space["measure"])

    assert digest(1.0) == digest(1.0)
    assert digest(1.0) != digest(10.0)  # of another length: bytecode is kept by size and second


def test_files_beside_the_package_are_of_the_user():
    package = Path(rc.__file__).parent
    assert not is_of_user(str(package / "errors.py"))
    assert is_of_user(str(package.with_name("rustchain_study") / "errors.py"))
    assert not is_of_user(np.__file__)
    assert not is_of_user("/home/me/.local/lib/python3.11/site-packages/tool/part.py")


@pytest.mark.parametrize(
    "text",
    [
        "g = np.vectorize(f)\ndef measure(r): return g(r)",
        "g = collections.deque([f])\ndef measure(r): return g[0](r)",
        "class C:\n one = f\ng = collections.deque([C()])\ndef measure(r): return g[0].one(r)",
        "class C: pass\nmeasure = C()\nmeasure.inner = np.vectorize(f)",
    ],
)
def test_functions_that_objects_of_installed_packages_hold_count(text, monkeypatch):
    def digest(added):
        module = types.ModuleType("of_held")
        monkeypatch.setitem(sys.modules, "of_held", module)
        head = f"import collections\nimport numpy as np\ndef f(*r): return len(r) + {added}\n"
        exec(head + text, vars(module))
        return digest_of(module.measure)

    assert digest(1) == digest(1)
    assert digest(1) != digest(2)


def test_a_function_of_a_notebook_counts_in_an_object_of_a_package():
    """Its module has no file."""
    script = (
        "import types, numpy as np\n"
        "from rustchain.sweeps.identity import digest_of\n"
        "def f(r): return ADDED\n"
        "print(digest_of(np.vectorize(f)), digest_of(types.SimpleNamespace(f=f)))\n"
    )
    found = [
        subprocess.run(
            [sys.executable, "-c", script.replace("ADDED", added)],
            capture_output=True, text=True, check=True,
        ).stdout.split()
        for added in ("1", "2")
    ]  # fmt: skip
    assert all(one != other for one, other in zip(*found, strict=True))


def test_a_call_of_a_vectorized_function_leaves_its_identity():
    function = np.vectorize(lambda x: 2 * x, otypes=[float])
    before = digest_of(function)
    function(1.0)
    assert digest_of(function) == before
    assert digest_of([function, 1]) != before


@pytest.mark.parametrize(
    "head",
    [
        "class C(NamedTuple):\n n: int = 1\n",
        "class C(dict):\n",
        "class C(float):\n",
        "class C(list):\n",
        "class C:\n def __reduce__(self): return 'measure'\n",
        "class C:\n def __reduce__(self): return dict, ()\n",
    ],
    ids=["tuple", "dict", "number", "list", "by name", "of another class"],
)
def test_methods_of_what_is_a_value_otherwise_count(head, monkeypatch):
    def digest(added):
        module = types.ModuleType("of_values")
        module.__file__ = "of_values.py"
        monkeypatch.setitem(sys.modules, "of_values", module)
        text = f"{head} def __call__(self, r): return r + {added}\nmeasure = C()"
        exec(f"from typing import NamedTuple\n{text}", vars(module))
        return digest_of(module.measure)

    assert digest(1) == digest(1)
    assert digest(1) != digest(2)


FROM_PYTHON = "import numpy as np\ng = np.frompyfunc(lambda x: x + 1, 1, 1)\n"


@pytest.mark.parametrize(
    "text",
    [
        "def measure(r): return g(r)",
        "measure = g",
        "class C:\n inner = g\nmeasure = C()",
        "class C: pass\nmeasure = C()\nmeasure.inner = g",
        "import of_ufunc as h\ndef measure(r): return h.g(r)",
    ],
)
def test_a_function_that_numpy_made_of_one_in_python_is_refused(text, monkeypatch):
    """NumPy shows nothing of its code: two of them would have the same identity."""
    module = types.ModuleType("of_ufunc")
    module.__file__ = "of_ufunc.py"
    monkeypatch.setitem(sys.modules, "of_ufunc", module)
    exec(FROM_PYTHON + text, vars(module))
    said = r"^store: <ufunc '<lambda> .*'> has no identity .*its Python code cannot be read"
    with pytest.raises(rc.InvalidInput, match=said):
        digest_of(module.measure)


def test_functions_of_numpy_and_scipy_count_by_their_names():
    found = {f for module in (np, special) for f in vars(module).values() if type(f) is np.ufunc}
    assert len(found) > 200
    assert len({digest_of(each) for each in found}) >= len({str(each) for each in found})


def test_a_value_that_holds_itself_has_no_identity():
    value = []
    value.append(value)
    with pytest.raises(rc.InvalidInput, match="it holds itself"):
        digest_of(value)


def test_code_of_installed_packages_counts_by_its_name(monkeypatch):
    def peak(result):
        return result

    def other(result):
        return result + 1

    found = []
    for each in (peak, other):
        each.__module__, each.__qualname__ = "numpy", "peak"
        space = {"peak": each, "np": np, "__name__": "somewhere"}
        exec("def measure(r): return np.median(peak(r))", space)
        found.append(digest_of(space["measure"]))
    assert found[0] == found[1]


def test_an_identity_is_that_of_every_process():
    script = (
        "from rustchain.sweeps.identity import digest_of\n"
        "import numpy as np, rustchain as rc\n"
        "names = {'upper', 'lower', 'left', 'right'}\n"
        "def measure(result, of=frozenset(names)):\n"
        "    if result in {'a', 'b', 'c', 'd'}: return np.pi\n"
        "    return [n for n in names if n in of]\n"
        "print(digest_of([measure, rc.Result.summary, rc.Scene(rc.paper_drive(25.0))]))\n"
    )
    found = {
        subprocess.run(
            [sys.executable, "-c", script], capture_output=True, text=True, check=True,
            env=os.environ | {"PYTHONHASHSEED": seed},
        ).stdout
        for seed in ("1", "2", "3")
    }  # fmt: skip
    assert len(found) == 1
