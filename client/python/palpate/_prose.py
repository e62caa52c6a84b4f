"""Gives help() the documentation of the stubs, so that editors, web pages and the prompt show one text."""

import ast
import functools
import pathlib
import types


def _entries(body, prefix=""):
    for node, after in zip(body, [*body[1:], None]):
        if isinstance(node, ast.ClassDef):
            yield prefix + node.name, ast.get_docstring(node) or ""
            yield from _entries(node.body, f"{prefix}{node.name}.")
        elif isinstance(node, ast.FunctionDef):
            prose, returns = ast.get_docstring(node) or "", ast.unparse(node.returns)
            if any(isinstance(mark, ast.Name) and mark.id == "property" for mark in node.decorator_list):
                yield prefix + node.name, f"{returns}: {prose}" if prose else returns
            else:
                yield prefix + node.name, f"{node.name}({ast.unparse(node.args)}) -> {returns}\n\n{prose}".rstrip()
        elif isinstance(node, ast.AnnAssign):
            # A string after an attribute documents it.
            text = after.value if isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant) else None
            kind = ast.unparse(node.annotation)
            yield prefix + node.target.id, f"{kind}: {text.value}" if text else kind


@functools.cache
def read(stub):
    """Returns the documentation of each name, such as "Proxy.step", in a stub beside this file: the signature
    and text of a function, the type and text of a property."""
    return dict(_entries(ast.parse(pathlib.Path(__file__).with_name(stub).read_text()).body))


def dress(namespace, stub):
    """Sets the docstrings of a module's classes, properties and Python functions to those of its stub.
    Functions of C++ have read-only docstrings; they take theirs from `read` when they are made."""
    for name, text in read(stub).items():
        owner, _, member = name.rpartition(".")
        thing = vars(namespace[owner]).get(member) if owner else namespace.get(member)
        if text and isinstance(thing, (type, property, types.FunctionType)):
            thing.__doc__ = text
