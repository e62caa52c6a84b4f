"""Scenes by keyword: against the catalogue's files for the bits, and at their own mistakes."""

import os
import pathlib
import pickle
import tempfile
import unittest

import numpy

import palpate

SIZE = [0.004, 0.004, 0.004]
SOFT = {"cutting_pressure_MPa": 0.05, "cutting_viscosity_MPa_s_per_mm": 0.005}
HARD = {"cutting_pressure_MPa": 0.2, "cutting_viscosity_MPa_s_per_mm": 0.02}


def mandible(kind, **more):
    return {"shape": "mandible", "kind": kind, "length_mm": 20, **more}


def osteotomy():
    bur = palpate.tool(
        "bur", {"shape": "bur", "kind": "cylinder", "diameter_mm": 1.6, "length_mm": 5, "rounding_mm": 0.2,
                "handle_mm": 30},
        look="steel", leaves=256, start={"position_mm": [-3, 3, 20], "rotation_deg": {"axis": [1, 0, 0], "angle": 90}})
    bone = palpate.object(
        "mandible", mandible("bone", cortex_mm=2), grid_um=100,
        material={"name": "cortical", "colour": "#ece3cc", **HARD},
        regions=[palpate.region({"name": "cancellous", "colour": "#c98f6d", **SOFT},
                                mesh=mandible("marrow", cortex_mm=2)),
                 palpate.region({"name": "nerve", "colour": "#f0d24a", "cutting_pressure_MPa": 0.01,
                                 "cutting_viscosity_MPa_s_per_mm": 0.005}, mesh=mandible("nerve"))])
    return palpate.scene("osteotomy", tools=[bur], objects=[bone], description="A window in a jaw.",
                         first_sight={"centre_mm": [0, 0, 0], "radius_mm": 12.5, "from": [0.45, 0.45, 1]})


def cube_with_a_core(**fields):
    """A cube that is cut, its core of another material, both from arrays."""
    bur = palpate.tool("bur", bur="001/014", speed_rpm=100000, leaves=64, start=[0, 0.02, 0])
    cube = palpate.object("cube", palpate.box(SIZE), grid_um=100, material=HARD, pose=palpate.pose([0, 0.001, 0]),
                          regions=[palpate.region(SOFT, mesh=palpate.box([0.002, 0.002, 0.002]))])
    return palpate.scene("own", tools=[bur], objects=[cube], coupling={"stiffness_N_per_m": 800}, **fields)


class Scene(unittest.TestCase):
    def test_that_is_cut_has_the_bits_of_the_catalogues(self):
        own, truth = osteotomy(), palpate.load("osteotomy")
        self.assertEqual(own.hash, truth.hash)
        path = truth.path()
        begin = numpy.flatnonzero(path[:, 2] < path[:, 2].max() - 0.005)[0]
        path = path[begin : begin + 1500]
        felt, right = (palpate.Proxy(scene.model(), path[0]).steps(path) for scene in (own, truth))
        self.assertEqual(felt.wrench.tobytes(), right.wrench.tobytes())
        self.assertEqual(felt.pose.tobytes(), right.pose.tobytes())
        self.assertGreater(abs(right.wrench[:, :3]).max(), 0.1)

    def test_of_arrays_is_saved_with_its_meshes_and_has_the_same_hash_and_bits_again(self):
        own = cube_with_a_core()
        self.assertEqual(own.model().parameters["stiffness_N_per_m"], 800)
        path = numpy.linspace([0, 0.006, 0], [0, 0.002, 0], 400)
        felt = palpate.Proxy(own.model(), path[0]).steps(path)
        self.assertGreater(felt.wrench[-1, 1], 0.01)
        for scene in (own, pickle.loads(pickle.dumps(own))):
            with tempfile.TemporaryDirectory() as folder:
                scene.save(pathlib.Path(folder, "x.json"))
                self.assertEqual(len(list(pathlib.Path(folder).iterdir())), 3)  # two meshes
                again = palpate.load(pathlib.Path(folder, "x.json"))
                self.assertEqual((again.name, again.hash), ("own", own.hash))
                steps = palpate.Proxy(again.model(), path[0]).steps(path)
                self.assertEqual(steps.wrench.tobytes(), felt.wrench.tobytes())

    def test_has_meshes_of_arrays_in_other_units_or_sizes(self):
        vertices, triangles = palpate.box([4, 2, 1])
        for more, size in (({"unit": "mm"}, [0.004, 0.002, 0.001]), ({"longest_side_m": 0.02}, [0.02, 0.01, 0.005])):
            ball = palpate.tool("ball", {"shape": "sphere", "radius_m": 0.001}, leaves=1, start=[0, 0.1, 0])
            block = palpate.object("block", {"arrays": (vertices, triangles), **more})
            made = palpate.scene(tools=[ball], objects=[block]).objects[0].vertices
            numpy.testing.assert_allclose(numpy.ptp(made, axis=0), size, rtol=1e-6)

    def test_has_regions_by_the_named_parts_of_a_file_that_stays_where_it_is(self):
        with tempfile.TemporaryDirectory() as folder:
            low, high = (palpate.ellipsoid([0.01, 0.01, 0.01], 320) for _ in range(2))
            file, saved = pathlib.Path(folder, "two.obj"), pathlib.Path(folder, "saved")
            lines, first = [], 1
            for name, (vertices, triangles), y in (("low", low, -0.02), ("high", high, 0.02)):
                lines += [f"o {name}", *(f"v {x} {z + y} {w}" for x, z, w in vertices)]
                lines += [f"f {a} {b} {c}" for a, b, c in triangles + first]
                first += len(vertices)
            file.write_text("\n".join(lines))
            ball = palpate.tool("ball", {"shape": "sphere", "radius_m": 0.001}, leaves=1, start=[0, 0.1, 0])
            two = palpate.object("two", {"file": os.path.relpath(file), "unit": "m", "origin": "file"}, leaves=200,
                                 regions=[palpate.region({"stiffness_N_per_m": 700}, group="high")])
            scene = palpate.scene("two", tools=[ball], objects=[two])
            body = scene.objects[0]
            above, of_part = body.leaf_centres[:, 1] > 0, body.leaf_materials == 1
            self.assertFalse((of_part & ~above).any())
            self.assertLessEqual((above & ~of_part).sum(), 2)  # what fills the inside has no surface of a part
            self.assertGreater(of_part.sum(), 50)
            saved.mkdir()
            scene.save(saved / "two.json")
            self.assertEqual([each.name for each in saved.iterdir()], ["two.json"])
            self.assertEqual(palpate.load(saved / "two.json").hash, scene.hash)

    def test_with_a_region_cuts_softer_there(self):
        path = numpy.linspace([0, 0.0045, 0], [0, 0.0005, 0], 4000)  # 1 mm/s, through 1 mm of the hard
        force = palpate.Proxy(cube_with_a_core().model(), path[0]).steps(path).wrench[:, 1]
        hard = force[path[:, 1] > 0.0022].max()
        self.assertLess(force[-300:].mean(), 0.6 * hard)

    def test_has_effects_with_their_parameters(self):
        ball = palpate.tool("ball", {"shape": "sphere", "radius_m": 0.005}, leaves=1, start=[0, 0.1, 0])
        block = palpate.object("block", {"shape": "box", "size_m": SIZE})
        scene = palpate.scene(tools=[ball], objects=[block], effects=[palpate.effect("viscous", damping_N_s_per_m=2)])
        path = numpy.linspace([0, 0.1, 0], [0.05, 0.1, 0], 501)  # 0.1 m/s in the air
        wrench = palpate.Proxy(scene.model(), path[0]).steps(path).wrench
        numpy.testing.assert_allclose(wrench[-1, :3], [-0.2, 0, 0], atol=1e-6)

    def test_takes_all_that_a_file_says(self):
        cube = palpate.object("cube", {"arrays": palpate.box([0.04] * 3), "origin": "file"}, leaves=numpy.int64(64),
                              material={"static_friction": numpy.float32(0.5), "dynamic_friction": 0.25},
                              regions=[palpate.region({"stiffness_N_per_m": 700.0},
                                                      sphere={"centre_mm": (0, 20, 0), "radius_mm": 15})])
        ball = palpate.tool("ball", {"shape": "sphere", "radius_m": 0.005}, leaves=1, look=None)
        scene = palpate.scene("all", tools=[ball], objects=[cube], contact="spheres", friction="coulomb",
                              step={"separation_um": 3})
        self.assertEqual([m.stiffness for m in scene.objects[0].materials][1], 700)
        self.assertEqual(scene.objects[0].materials[0].static_friction, 0.5)
        self.assertEqual(scene.parameters["separation_um"], 3)
        self.assertEqual(scene.objects[0].leaf_materials.max(), 1)


class Mistakes(unittest.TestCase):
    def refused(self, named, tool=(), thing=(), **scene):
        tool = {"name": "ball", "mesh": {"shape": "sphere", "radius_m": 0.005}, "leaves": 1, **dict(tool)}
        thing = {"name": "cube", "mesh": {"shape": "box", "size_m": SIZE}, **dict(thing)}
        with self.assertRaisesRegex(palpate.Error, named) as refused:
            palpate.scene(**{"name": "mine", "tools": [tool], "objects": [thing], **scene})
        self.assertNotIn(tempfile.gettempdir(), str(refused.exception))

    def test_are_told_with_their_field(self):
        self.refused(r"mine:\d+: objects\[0\]\.grid_um", thing={"grid_um": 1})
        self.refused(r"objects\[0\]\.gridum.*grid_um", thing={"gridum": 50})
        self.refused(r"coupling\.stiffness_N_per_m", coupling={"stiffness_N_per_m": -1})
        self.refused(r"objects\[0\]\.material\.static_friction: is nan",
                     thing={"material": {"static_friction": numpy.nan}})
        self.refused(r"tools\[0\]: mesh is missing", tool={"mesh": None})
        self.refused(r"tools\[0\]\.leaves: is of type complex", tool={"leaves": 1j})
        self.refused(r"tools\[0\]: is of type Body", tools=[palpate.ball("ball", 0.005)])
        self.refused(r"cube: pose.*\(2,\)", thing={"pose": [1, 2]})
        self.refused(r"cube: pose", thing={"pose": numpy.zeros((1, 7))})
        self.refused(r"effects\[0\]\.name.*viscous", effects=[palpate.effect("viscus")])
        self.refused(r"effects\[0\].*damping", effects=[palpate.effect("viscous", damping=1)])
        self.refused(r"name", name="a/b")
        self.refused("type set", thing={"mesh": {"arrays": {1, 2}}})
        self.refused("unit", thing={"mesh": "tooth.stl"})
        self.refused("tooth.stl", thing={"mesh": {"file": "tooth.stl", "unit": "mm"}})

    def test_of_saving_leave_no_file_that_is_another_scene(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "x.json")
            own = cube_with_a_core()
            own.objects[0].pose = [0, 0.01, 0]
            with self.assertRaisesRegex(palpate.Error, "changed"):
                own.save(file)
            with self.assertRaisesRegex(palpate.Error, "palpate.scene"):
                palpate.load("cube").save(file)
            self.assertEqual(list(pathlib.Path(folder).iterdir()), [])
            own.save(file.with_suffix(".palpate"))
            self.assertEqual(palpate.load(file.with_suffix(".palpate")).hash, own.hash)


if __name__ == "__main__":
    unittest.main()
