"""Meshes of other libraries, and files of meshes."""

import os

import numpy

from palpate._physics import Error, _mesh_bytes, _write_file
from palpate.files import METRES


def _triangles(mesh):
    """The faces of trimesh, the triangles of Open3D and of a Body, the cells of meshio."""
    cells = getattr(mesh, "cells_dict", None)
    if cells is None:
        return getattr(mesh, "faces", getattr(mesh, "triangles", None))
    if set(cells) - {"triangle", "line", "vertex"}:
        raise Error(f"mesh: has {', '.join(sorted(cells))}; split them into triangles")
    return cells.get("triangle")


def arrays(mesh):
    """Returns vertices and triangles of a pair of them, or of an object that has both."""
    if isinstance(mesh, tuple) and len(mesh) == 2:
        return mesh
    vertices, triangles = getattr(mesh, "vertices", getattr(mesh, "points", None)), _triangles(mesh)
    if vertices is None or triangles is None:
        raise Error(f"mesh: an object of type {type(mesh).__name__} has no vertices and faces; give one that has, or "
                    "two arrays, vertices and triangles")
    return numpy.asanyarray(vertices), numpy.asanyarray(triangles)


def write_mesh(file, mesh, triangles=None, *, unit="m"):
    if unit not in METRES:
        raise Error(f"unit: '{unit}' is not known; give one of {', '.join(METRES)}")
    file = os.fspath(file)
    _write_file(file, _mesh_bytes(file, mesh, triangles, METRES[unit]))
