"""Types for editors and checkers: the stub against what there is, and inline types against what comes back."""

import ast
import inspect
import pathlib
import tempfile
import typing
import unittest

import numpy
from numpy.typing import NDArray

import palpate
from palpate import hands, study

STUB = {node.name: node for node in
        ast.parse(pathlib.Path(palpate.__file__).with_suffix(".pyi").read_text()).body
        if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
ARRAY = NDArray[numpy.float64]


def functions_of(module):
    """Public functions that a module defines, and those of its public classes, by name."""
    for name, thing in vars(module).items():
        if name.startswith("_") or getattr(thing, "__module__", "") != module.__name__:
            continue
        if inspect.isfunction(thing):
            yield name, thing
        elif inspect.isclass(thing):
            yield from ((f"{name}.{member}", each) for member, each in vars(thing).items()
                        if inspect.isfunction(each) and (member == "__init__" or not member.startswith("_")))


def fits(value, kind):
    """Whether a value is of a type: a class, a Union or Optional, or an array of doubles."""
    if kind == ARRAY:
        return isinstance(value, numpy.ndarray) and value.dtype == numpy.float64
    if typing.get_origin(kind) is typing.Union:
        return any(fits(value, each) for each in typing.get_args(kind))
    if typing.get_origin(kind) is dict:
        of_key, of_value = typing.get_args(kind)
        return isinstance(value, dict) and all(fits(k, of_key) and fits(v, of_value) for k, v in value.items())
    if typing.get_origin(kind) is list:
        return isinstance(value, list) and all(fits(each, *typing.get_args(kind)) for each in value)
    if kind is typing.Any:
        return True
    return isinstance(value, (int, float) if kind is float else typing.get_origin(kind) or kind)


class Stub(unittest.TestCase):
    def test_has_every_name(self):
        self.assertLessEqual(set(palpate.__all__) - {"__version__", "physics_revision", "report_dtype"}, set(STUB))
        self.assertEqual({name for name in STUB if not hasattr(palpate, name)}, set())

    def test_has_the_parameters_and_defaults_of_functions_in_python(self):
        compared = 0
        for name, node in STUB.items():
            if not inspect.isfunction(real := getattr(palpate, name)):
                continue
            namespace = {}
            for each in [*node.args.args, *node.args.kwonlyargs, node.args.kwarg]:
                if each:
                    each.annotation = None
            stubbed = ast.unparse(ast.FunctionDef("f", node.args, [ast.Pass()], [], None, lineno=0))
            exec(stubbed, namespace)
            self.assertEqual(str(inspect.signature(namespace["f"])), str(inspect.signature(real)), name)
            compared += 1
        self.assertGreaterEqual(compared, 9)


class Inline(unittest.TestCase):
    def test_are_there_for_every_parameter_and_fit_the_defaults(self):
        compared = 0
        for module in (hands, study):
            for name, function in functions_of(module):
                kinds = typing.get_type_hints(function)
                self.assertIn("return", kinds, name)
                for parameter in inspect.signature(function).parameters.values():
                    if parameter.name == "self":
                        continue
                    self.assertIn(parameter.name, kinds, name)
                    if parameter.default is not parameter.empty:
                        self.assertTrue(fits(parameter.default, kinds[parameter.name]), f"{name}: {parameter}")
                        compared += 1
        self.assertGreaterEqual(compared, 11)

    def test_of_hands_are_what_comes_back(self):
        scene = palpate.load("cube")
        for path, function in ((hands.generated(scene, steps=300), hands.generated),
                               (hands.script(scene, steps=5), hands.script),
                               (hands.trembling([[0, 1, 2]], um=1), hands.trembling)):
            self.assertTrue(fits(path, typing.get_type_hints(function)["return"]), function)

    def test_of_a_study_are_what_it_has(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "study.toml")
            file.write_text('scenes = ["cube"]\nsteps = 20\n[parameters]\nfriction = [0, 0.3]\n')
            made = study.Study(file)
            kinds = typing.get_type_hints(study.Study)
            self.assertLessEqual({name for name in vars(made) if name not in ("model", "makers")}, set(kinds))
            for name, kind in kinds.items():
                if name != "measure":
                    self.assertTrue(fits(getattr(made, name), kind), f"{name}: {getattr(made, name)!r}, {kind}")
            self.assertTrue(fits(made.runs(), typing.get_type_hints(study.Study.runs)["return"]))
        path = palpate.load("cube").path()[:50]
        found = study.figures(palpate.Proxy(palpate.load("cube").model(), path[0]).steps(path))
        self.assertTrue(fits(found, typing.get_type_hints(study.figures)["return"]), found)


if __name__ == "__main__":
    unittest.main()
