"""Meshes of other libraries' objects, and files of meshes, read back by palpate-import."""

import pathlib
import tempfile
import types
import unittest

import numpy

import palpate


def volume(vertices, triangles):
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    return (a * numpy.cross(b, c)).sum() / 6


class Mesh(unittest.TestCase):
    def test_is_any_object_with_vertices_and_faces(self):
        vertices, triangles = palpate.box([0.04, 0.02, 0.04])
        truth = palpate.body("block", vertices, triangles, leaves=64)
        corners = vertices[triangles]  # as trimesh's `triangles`

        class Numbers:  # converts as Open3D's vectors do
            def __init__(self, array):
                self.array = array

            def __array__(self, dtype=None):
                return self.array if dtype is None else self.array.astype(dtype)

        for mesh in (types.SimpleNamespace(vertices=vertices, faces=triangles, triangles=corners),
                     types.SimpleNamespace(vertices=Numbers(vertices), triangles=Numbers(triangles.astype(numpy.int32))),
                     types.SimpleNamespace(points=vertices, cells_dict={"triangle": triangles, "line": [[0, 1]]}),
                     truth, (vertices, triangles)):
            body = palpate.body("block", mesh, leaves=64)
            self.assertEqual(body.vertices.tobytes(), truth.vertices.tobytes())
            self.assertEqual(body.triangles.tobytes(), truth.triangles.tobytes())
            self.assertEqual(body.leaf_radii.tobytes(), truth.leaf_radii.tobytes())

    def test_is_refused_by_its_type_or_cells_if_it_is_none(self):
        quads = types.SimpleNamespace(points=numpy.zeros((4, 3)), cells_dict={"quad": [[0, 1, 2, 3]]})
        lines = types.SimpleNamespace(points=numpy.zeros((4, 3)), cells_dict={"line": [[0, 1]]})
        padded = types.SimpleNamespace(vertices=numpy.zeros((3, 3)), faces=[3, 0, 1, 2])
        for wrong, named in ((quads, "quad"), (lines, "SimpleNamespace"), (padded, r"triangles.*\(4,\)"),
                             (numpy.zeros((3, 3)), "ndarray"), (None, "NoneType"), ("tooth.stl", "type str")):
            with self.assertRaisesRegex(palpate.Error, named):
                palpate.body("wrong", wrong)


class Files(unittest.TestCase):
    def setUp(self):
        kept = tempfile.TemporaryDirectory()
        self.addCleanup(kept.cleanup)
        self.folder = pathlib.Path(kept.name)

    def test_of_each_format_hold_the_mesh_that_was_written(self):
        vertices, triangles = palpate.ellipsoid([0.01, 0.02, 0.03], 320)
        body = palpate.body("egg", vertices, triangles, leaves=64)
        corners = vertices[triangles]
        for name in ("egg.stl", "egg.obj", "egg.PLY"):
            for unit in ("m", "mm", "inch"):
                palpate.write_mesh(self.folder / name, body, unit=unit)
                points, faces = palpate.read_mesh(self.folder / name, unit=unit)
                self.assertEqual(len(faces), len(triangles))
                self.assertAlmostEqual(volume(points, faces) / volume(vertices, triangles), 1, 6)
                # What is read has single precision.
                self.assertLess(abs(points[faces] - corners).max(), 2.0**-24 * 0.04, f"{name} in {unit}")
                if unit == "m":
                    self.assertEqual(points[faces].tobytes(), corners.astype(numpy.float32).astype(float).tobytes())
                palpate.write_mesh(self.folder / name, points, faces)
                again, same = palpate.read_mesh(self.folder / name)
                self.assertLess(abs(again[same] - points[faces]).max(), 2.0**-24 * 0.04)

    def test_are_refused_with_the_number_or_ending_that_is_wrong_and_leave_no_file(self):
        vertices, triangles = palpate.box([0.04, 0.02, 0.04])
        hole, beyond = vertices.copy(), triangles.copy()
        hole[3, 1], beyond[5, 0] = numpy.nan, 8
        for name, mesh, options, named in (
                ("box.glb", (vertices, triangles), {}, "glb.*ply"), ("box", (vertices, triangles), {}, "stl"),
                ("box.stl", (hole, triangles), {}, "vertex 3"), ("box.stl", (vertices, beyond), {}, "triangle 5.*vertex 8"),
                ("box.stl", (vertices, triangles), {"unit": "ft"}, "unit: 'ft'")):
            with self.assertRaisesRegex(palpate.Error, named):
                palpate.write_mesh(self.folder / name, *mesh, **options)
        self.assertEqual(list(self.folder.iterdir()), [])
        with self.assertRaisesRegex(palpate.Error, "box.stl"):
            palpate.write_mesh("/proc/box.stl", vertices, triangles)


if __name__ == "__main__":
    unittest.main()
