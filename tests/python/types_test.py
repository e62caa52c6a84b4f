"""Types for editors and checkers: the stub against what there is."""

import ast
import inspect
import pathlib
import unittest

import palpate

STUB = {node.name: node for node in
        ast.parse(pathlib.Path(palpate.__file__).with_suffix(".pyi").read_text()).body
        if isinstance(node, (ast.ClassDef, ast.FunctionDef))}


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


if __name__ == "__main__":
    unittest.main()
