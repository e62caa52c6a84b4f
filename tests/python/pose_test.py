"""palpate.pose: against rotations of known vectors, and at each function that takes poses."""

import unittest

import numpy

import palpate

HALF = numpy.sqrt(0.5)
RANDOM = numpy.random.default_rng(3)
QUATERNIONS = RANDOM.normal(size=(200, 4))  # w x y z
QUATERNIONS /= numpy.linalg.norm(QUATERNIONS, axis=1, keepdims=True)


class Rotation:
    """What of scipy's Rotation is used."""

    def __init__(self, wxyz):
        self.wxyz = numpy.asarray(wxyz)

    def as_quat(self):
        return self.wxyz[..., [1, 2, 3, 0]]


def matrices(q):
    """By the images of the axes: v + 2 u x (u x v + w v)."""
    w, u = q[..., None, :1], q[..., None, 1:]
    axes = numpy.eye(3)
    return numpy.swapaxes(axes + 2 * numpy.cross(u, numpy.cross(u, axes) + w * axes), -1, -2)



class Pose(unittest.TestCase):
    def test_has_the_same_numbers_from_every_form(self):
        quarter = [1, 2, 3, HALF, 0, HALF, 0]  # about y
        forms = ({"xyzw": [0, HALF, 0, HALF]}, {"wxyz": [HALF, 0, HALF, 0]}, {"rotvec": [0, numpy.pi / 2, 0]},
                 {"matrix": [[0, 0, 1], [0, 1, 0], [-1, 0, 0]]}, {"rotation": Rotation([HALF, 0, HALF, 0])},
                 {"matrix": Rotation([HALF, 0, HALF, 0])})
        for form in forms:
            numpy.testing.assert_allclose(palpate.pose([1, 2, 3], **form), quarter, atol=1e-15, err_msg=str(form))
        whole = [[0, 0, 1, 1], [0, 1, 0, 2], [-1, 0, 0, 3], [0, 0, 0, 1]]
        numpy.testing.assert_allclose(palpate.pose(matrix=whole), quarter, atol=1e-15)
        self.assertEqual(palpate.pose([1, 2, 3]).tolist(), [1, 2, 3, 1, 0, 0, 0])

    def test_keeps_quaternions_to_the_bit(self):
        self.assertEqual(palpate.pose([0, 0, 0], wxyz=QUATERNIONS)[:, 3:].tobytes(), QUATERNIONS.tobytes())
        self.assertEqual(palpate.pose(xyzw=QUATERNIONS[:, [1, 2, 3, 0]])[:, 3:].tobytes(), QUATERNIONS.tobytes())

    def test_is_that_of_the_matrix_also_near_half_a_turn(self):
        near = numpy.concatenate([[1e-9 * numpy.ones(len(QUATERNIONS))], QUATERNIONS[:, 1:].T]).T
        near /= numpy.linalg.norm(near, axis=1, keepdims=True)
        for q in (QUATERNIONS, near, numpy.eye(4)):
            found = palpate.pose(matrix=matrices(q))[:, 3:]
            numpy.testing.assert_allclose(numpy.abs((found * q).sum(axis=1)), 1, atol=1e-14)

    def test_of_a_rotation_vector_turns_about_it_even_by_nothing(self):
        axis = numpy.array([2, -1, 2]) / 3
        for angle in (0.0, 1e-300, 1e-9, 0.5, 3.0, 6.0):
            w, *u = palpate.pose(rotvec=angle * axis)[3:]
            self.assertAlmostEqual(w, numpy.cos(angle / 2), 15)
            numpy.testing.assert_allclose(u, numpy.sin(angle / 2) * axis, rtol=1e-14)

    def test_agrees_with_scipys_rotations(self):
        try:
            from scipy.spatial.transform import Rotation as Theirs
        except ImportError:
            self.skipTest("scipy is not installed")
        theirs = Theirs.from_quat(QUATERNIONS[:, [1, 2, 3, 0]])
        for form in ({"rotation": theirs}, {"matrix": theirs.as_matrix()}, {"rotvec": theirs.as_rotvec()}):
            found = palpate.pose(**form)[:, 3:]
            numpy.testing.assert_allclose(numpy.abs((found * QUATERNIONS).sum(axis=1)), 1, atol=1e-14)

    def test_is_made_for_as_many_as_positions_or_orientations(self):
        self.assertEqual(palpate.pose(numpy.zeros((5, 3)), rotvec=[0, 0, 1]).shape, (5, 7))
        self.assertEqual(palpate.pose([0, 0, 0], wxyz=QUATERNIONS).shape, (200, 7))
        self.assertEqual(palpate.pose(numpy.zeros((2, 5, 3))).shape, (2, 5, 7))
        with self.assertRaisesRegex(palpate.Error, "do not match"):
            palpate.pose(numpy.zeros((5, 3)), wxyz=QUATERNIONS)

    def test_is_refused_by_name_if_it_is_none(self):
        tall = numpy.diag([1, 1, 1.1])
        for wrong, named in (
                ({"rotation": [0, 0, 0, 1]}, "order"), ({"xyzw": [0, 0, 0, 2]}, "length 2"),
                ({"wxyz": [1, 0, 0]}, "wxyz.*shape"), ({"rotvec": [0, numpy.nan, 0]}, "rotvec.*finite"),
                ({"matrix": numpy.diag([1, 1, -1])}, "mirrors"), ({"matrix": tall}, "matrix.*off by 0.21"),
                ({"matrix": 2 * numpy.eye(4)}, "last row"), ({"wxyz": "1000"}, "wxyz.*numbers"),
                ({"xyz": [1, 2], "wxyz": [1, 0, 0, 0]}, "xyz.*shape"), ({"xyz": [[1, 2, 3], [1]]}, "xyz"),
                ({"xyzw": [0, 0, 0, 1], "rotvec": [0, 0, 0]}, "xyzw, rotvec"), ({"xyzw": None, "xyz": [0, 1j, 0]}, "xyz"),
                ({"xyz": [0, 1, 0], "matrix": numpy.eye(4)}, "position"),
                ({"xyz": numpy.ma.masked_array([0, 1, 0], [0, 1, 0])}, "xyz.*masked"),
                ({"xyz": numpy.zeros(3, numpy.longdouble)}, "xyz.*64 bits")):
            with self.assertRaisesRegex(palpate.Error, named, msg=str(wrong)):
                palpate.pose(**wrong)
        with self.assertRaises(palpate.Error):
            palpate.pose([0, 0, 0], None, matrix=numpy.zeros((0, 2)))

    def test_is_taken_by_proxies_models_batches_and_bodies(self):
        block = palpate.body("block", *palpate.box([0.04, 0.02, 0.04]))
        block.pose = palpate.pose([0, 0, 0], xyzw=[0, 0, HALF, HALF])  # about z: 40 mm high
        numpy.testing.assert_allclose(block.pose, [0, 0, 0, HALF, 0, 0, HALF])
        model = palpate.Model([block], palpate.ball("ball", 0.005))
        path = palpate.pose(numpy.linspace([0, 0.026, 0], [0, 0.022, 0], 50), rotvec=[0, 0, 0.3])
        alone = palpate.Proxy(model, path[0])
        steps = alone.steps(path)
        self.assertAlmostEqual(steps.wrench[-1, 1], 3, 1)
        self.assertEqual(model.follow(path[None]).wrench[0].tobytes(), steps.wrench.tobytes())
        one, batch = palpate.Proxy(model, path[0]), palpate.Batch(model, 2, path[0])
        for pose, wrench in zip(path, steps.wrench):
            self.assertEqual(one.step(pose).force.tobytes(), wrench[:3].tobytes())
            both = batch.step(palpate.pose([pose[:3]] * 2, wxyz=pose[3:]))
            self.assertEqual(both.wrench[1].tobytes(), wrench.tobytes())
        with self.assertRaisesRegex(palpate.Error, "w x y z"):
            one.step([0, 0.03, 0, 0, 0, 0, 2])


if __name__ == "__main__":
    unittest.main()
