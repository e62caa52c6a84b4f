"""The module for Python: against the library in C for the bits, against geometry for the forces."""

import ast
import copy
import ctypes
import gc
import math
import os
import pathlib
import pickle
import pydoc
import shutil
import subprocess
import sys
import tempfile
import threading
import unittest
import warnings
import weakref
from unittest import mock

import numpy

import palpate
from palpate import live

SIZE = [0.04, 0.04, 0.04]


def ball_on_block(**options):
    block = palpate.body("block", *palpate.box(SIZE), **options)
    return palpate.Model([block], palpate.ball("ball", 0.005), contact=options.get("contact", "surface"))


def cube_with_effects(folder):
    catalogue = pathlib.Path(os.environ["PALPATE_SOURCE_DIR"], "scenes/catalogue")
    effects = '{ "effects": [{"name": "stick"}, {"name": "vibration"}],'
    cube = (catalogue / "cube.json").read_text().replace(',\n      "leaves": 4096', "")
    (folder / "own.json").write_text(cube.replace("{", effects, 1))
    (folder / "own.path.json").write_text((catalogue / "cube.path.json").read_text())
    return str(folder / "own.json")


def wandering_path(steps, seed):
    """Poses of a hand that wanders about in the upper face, and turns."""
    random = numpy.random.default_rng(seed)
    positions = numpy.cumsum(random.normal(0.0, 2e-5, (steps, 3)), axis=0) + [0.0, 0.023, 0.0]
    angles = numpy.cumsum(random.normal(0.0, 1e-3, steps))
    poses = numpy.zeros((steps, 7))
    poses[:, :3] = positions
    poses[:, 3] = numpy.cos(angles / 2)
    poses[:, 5] = numpy.sin(angles / 2)
    return poses


class Force(unittest.TestCase):
    def test_is_the_springs_over_the_depth(self):
        proxy = palpate.Proxy(ball_on_block(), [0, 0.03, 0])
        for y in numpy.linspace(0.03, 0.022, 100):
            report = proxy.step([0, y, 0])
        numpy.testing.assert_allclose(report.force, [0, 3, 0], atol=5e-3)
        numpy.testing.assert_allclose(report.pose[:3], [0, 0.025, 0], atol=5e-6)
        self.assertEqual(report.contacts, len(report.points))
        numpy.testing.assert_allclose(report.points[:, 3:].sum(axis=0), report.force, atol=1e-9)
        self.assertEqual(report.faults, 0)

    def test_of_a_body_elsewhere_is_felt_there(self):
        block = palpate.body("block", *palpate.box(SIZE))
        block.pose = [0.1, 0, 0]
        model = palpate.Model([block], palpate.ball("ball", 0.005))
        self.assertEqual(palpate.Proxy(model, [0, 0.022, 0]).step([0, 0.022, 0]).force[1], 0)
        self.assertAlmostEqual(palpate.Proxy(model, [0.1, 0.022, 0]).step([0.1, 0.022, 0]).force[1], 3, 2)


class Pose(ctypes.Structure):
    _fields_ = [("position", ctypes.c_double * 3), ("orientation", ctypes.c_double * 4)]


class CReport(ctypes.Structure):
    _fields_ = [
        ("force", ctypes.c_double * 3),
        ("torque", ctypes.c_double * 3),
        ("tool", Pose),
        ("faults", ctypes.c_uint32),
        ("contacts", ctypes.c_int32),
        ("points", ctypes.c_int32),
        ("point", ctypes.c_double * 42),
        ("parameter", ctypes.c_void_p),
        ("parameters", ctypes.c_size_t),
    ]


class Bits(unittest.TestCase):
    def setUp(self):
        self.c = ctypes.CDLL(os.environ["PALPATE_C_LIBRARY"])
        for name in ("palpate_scene_new", "palpate_scene_load", "palpate_model_new", "palpate_proxy_new"):
            getattr(self.c, name).restype = ctypes.c_void_p

    def assert_same_in_c(self, scene, path, steps):
        pose, report = Pose(), CReport()

        def at(row):
            pose.position[:], pose.orientation[:] = row[:3], row[3:]
            return ctypes.byref(pose)

        model = ctypes.c_void_p(self.c.palpate_model_new(scene, ctypes.c_size_t(0)))
        hand = ctypes.c_void_p(self.c.palpate_proxy_new(model, at(path[0])))
        for row, wrench, tool in zip(path, steps.wrench, steps.pose):
            self.c.palpate_proxy_step(hand, at(row), ctypes.byref(report))
            self.assertEqual(bytes(report.force) + bytes(report.torque), wrench.tobytes())
            self.assertEqual(bytes(report.tool), tool.tobytes())
        self.assertGreater((steps.contacts > 0).sum(), 500)

    def test_of_a_loaded_scene_are_those_of_the_library_in_c(self):
        with tempfile.TemporaryDirectory() as folder:
            for name in ("cube", cube_with_effects(pathlib.Path(folder))):
                loaded = ctypes.c_void_p(self.c.palpate_scene_load(name.encode()))
                self.assertEqual(self.c.palpate_scene_set_parameter(loaded, b"friction", ctypes.c_double(0.3)), 0)
                scene = palpate.load(name)
                path = scene.path()[2000:6000]
                self.assert_same_in_c(loaded, path, palpate.Proxy(scene.model(friction=0.3), path[0]).steps(path))

    def test_are_the_same_step_by_step_in_one_call_and_on_all_cores(self):
        model = ball_on_block()
        paths = numpy.stack([wandering_path(300, seed) for seed in range(9)])
        one = model.follow(paths, threads=1)
        for threads in (0, 2, 5, 40):
            many = model.follow(paths, threads=threads)
            self.assertEqual(many.wrench.tobytes(), one.wrench.tobytes())
            self.assertEqual(many.pose.tobytes(), one.pose.tobytes())
        proxy = palpate.Proxy(model, paths[4, 0])
        for i, pose in enumerate(paths[4]):
            report = proxy.step(pose)
            self.assertEqual(report.force.tobytes(), one.wrench[4, i, :3].tobytes())
            self.assertEqual(report.torque.tobytes(), one.wrench[4, i, 3:].tobytes())


class Poses(unittest.TestCase):
    def test_of_a_step_may_have_any_form_with_the_same_numbers(self):
        model, path = ball_on_block(), wandering_path(60, 4)
        path[:, :3] = path[:, :3].astype(numpy.float32)
        forms = (list, tuple, lambda pose: [*map(float, pose)], lambda pose: tuple(map(float, pose)),
                 lambda pose: numpy.repeat(pose, 2)[::2], lambda pose: pose.astype(">f8"), numpy.ma.masked_array)
        truth = palpate.Proxy(model, path[0]).steps(path)
        for form in forms:
            proxy = palpate.Proxy(model, path[0])
            felt = [proxy.step(form(pose)).force.tobytes() for pose in path]
            self.assertEqual(b"".join(felt), numpy.ascontiguousarray(truth.wrench[:, :3]).tobytes())
        self.assertEqual(proxy.step([0, 1, 0]).force.tolist(), proxy.step((0.0, 1, 0.0)).force.tolist())
        for wrong in ([0, 1], [0] * 8, [0, 10**400, 0], [0, True, 0, 1], "012", [[0, 1, 0]], numpy.zeros((1, 3)), None):
            with self.assertRaises(palpate.Error):
                proxy.step(wrong)


class Effects(unittest.TestCase):
    AIR = numpy.array([0, 0.04, 0])

    def setUp(self):
        self.proxy = palpate.Proxy(ball_on_block(), self.AIR)

    def test_an_effect_beside_a_scene_runs_only_from_a_folder_that_is_named(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(cube_with_effects(pathlib.Path(folder)))
            file.write_text(file.read_text().replace('"stick"', '"mine.so"'))
            stick = pathlib.Path(os.environ["PALPATE_PROGRAMS"], "effects/stick.so")
            shutil.copy(stick, pathlib.Path(folder, "mine.so"))
            with self.assertRaisesRegex(palpate.Error, "mine.so.*--effects"):
                palpate.load(str(file))
            with mock.patch.dict(os.environ, PALPATE_EFFECTS=folder):
                palpate.load(str(file))

    def test_act_as_one_in_c_does_and_to_the_same_bits_in_one_call_and_many(self):
        moves = self.AIR + numpy.linspace([0, 0, 0], [0, -0.015, 0.003], 400)
        with tempfile.TemporaryDirectory() as folder:
            file = cube_with_effects(pathlib.Path(folder))
            text = pathlib.Path(file).read_text().replace('{"name": "vibration"}', '{"name": "viscous"}')
            pathlib.Path(file).write_text(text.replace('{"name": "stick"}, ', ""))
            viscous = palpate.Proxy(palpate.load(file).model(), moves[0]).steps(moves).wrench
        for steps in (lambda proxy: proxy.steps(moves).wrench,
                      lambda proxy: numpy.array([numpy.r_[(now := proxy.step(pose)).force, now.torque] for pose in moves])):
            proxy = palpate.Proxy(palpate.load("cube").model(), moves[0])
            proxy.set_effect(lambda hand, twist, tool: -3 * twist[:3], rate_hz=1000)
            self.assertEqual(steps(proxy).tobytes(), viscous.tobytes())
        self.assertGreater(viscous[-1, 1], 1)

    def test_are_asked_at_their_rate_and_held_or_go_on_as_a_spring(self):
        asked = []

        def spring(stiffness):
            def effect(hand, twist, tool):
                asked.append((hand, tool))
                force = 20 * (self.AIR - hand[:3])
                return force if stiffness is None else (numpy.r_[force, 0, 0, 0], stiffness)
            return effect

        moves = self.AIR + numpy.linspace([0, 0, 0], [0.02, 0, 0.01], 95)
        truth = 20 * (self.AIR - moves)
        for stiffness in (None, numpy.diag([20, 20, 20, 0, 0, 0])):
            asked.clear()
            self.proxy.restart(moves[0])
            self.proxy.set_effect(spring(stiffness), rate_hz=100)
            force = self.proxy.steps(moves).wrench[:, :3]
            numpy.testing.assert_array_equal([hand[:3] for hand, _ in asked], moves[::10])
            numpy.testing.assert_array_equal([tool[:3] for _, tool in asked[1:]], moves[9:-1:10])
            numpy.testing.assert_allclose(force, truth if stiffness is not None else truth[numpy.arange(95) // 10 * 10],
                                          atol=1e-12)
        self.proxy.restart(moves[0])  # whose count begins anew
        self.proxy.step(moves[0])
        self.assertEqual(len(asked), 11)

    def test_turn_about_the_tools_origin_and_stay_within_their_bounds(self):
        vertices, triangles = palpate.box(SIZE)
        block = palpate.body("block", vertices, triangles)
        model = palpate.Model([block], palpate.body("lever", vertices + [0.1, 0, 0], triangles))
        proxy = palpate.Proxy(model, [0, 0.2, 0])
        proxy.set_effect(lambda *_: [0, 3, 4, 0, 0, 0.5], max_force=1)
        report = proxy.step([0, 0.2, 0])
        numpy.testing.assert_allclose(report.force, [0, 0.6, 0.8], atol=1e-15)
        numpy.testing.assert_allclose(report.torque, [0, 0.08, -0.06 + 0.01], atol=1e-12)  # at its centroid
        proxy.set_effect(None)
        self.assertFalse(proxy.step([0, 0.2, 0]).torque.any())

    def test_that_fail_say_so_and_act_no_more(self):
        for words, what in {
            "<lambda>: its wrench is not finite": lambda *_: [0, math.nan, 0],
            "its stiffness is not finite": lambda *_: ([0, 0, 0], numpy.full((3, 3), math.inf)),
            r"its wrench: must be a force x y z in N, .*; its shape is \(2,\)": lambda *_: numpy.zeros(2),
            r"its stiffness: must be \(3, 3\) beside a force": lambda *_: ([0, 0, 0], numpy.eye(6)),
            "its wrench: is of type NoneType": lambda *_: None,
            "an effect cannot step": lambda *_: self.proxy.step(self.AIR),
        }.items():
            self.proxy.set_effect(what)
            with self.subTest(words), self.assertRaisesRegex(palpate.Error, words):
                self.proxy.step(self.AIR)
            self.assertFalse(self.proxy.step(self.AIR).force.any())
        times = []

        def enough(*_):
            times.append(0)
            if len(times) > 3:
                raise RuntimeError("enough")
            return [1, 0, 0]

        self.proxy.set_effect(enough, rate_hz=500)
        with self.assertRaisesRegex(RuntimeError, "enough"):
            self.proxy.steps(numpy.tile(self.AIR, (20, 1)))
        self.assertFalse(self.proxy.step(self.AIR).force.any())
        for words, wrong in {"rate_hz: must be 1000 divided by": {"rate_hz": 300}, "max_force, ": {"max_force": -1}}.items():
            with self.assertRaisesRegex(palpate.Error, words):
                self.proxy.set_effect(enough, **wrong)
        with self.assertRaisesRegex(palpate.Error, "effect: is not a function"):
            self.proxy.set_effect(3)


class Interrupts(unittest.TestCase):
    """Each in a Python of its own, which is sent SIGINT in the midst of a call that takes many seconds."""

    BEGIN = """
import os, signal, threading, time
import numpy, palpate
from module_test import ball_on_block, wandering_path
path = numpy.tile(wandering_path(1000, 5), (400, 1))
paths = numpy.tile(path, (3, 1, 1))
model = ball_on_block()
proxy = palpate.Proxy(model, path[0])
def interrupt():
    until = time.process_time() + 0.5  # of computing, however busy the machine is
    while time.process_time() < until:
        time.sleep(0.01)
    os.kill(os.getpid(), signal.SIGINT)
threading.Thread(target=interrupt, daemon=True).start()
try:
    CALL
    raise SystemExit("was not interrupted")
except KeyboardInterrupt as stopped:
    steps = getattr(stopped, "steps", None)
"""

    def holds(self, call, then):
        done = subprocess.run([sys.executable, "-c", self.BEGIN.replace("CALL", call) + then], capture_output=True,
                              text=True, check=False, cwd=pathlib.Path(__file__).parent)
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_keep_the_steps_so_far_and_the_proxy_goes_on_from_there(self):
        self.holds("proxy.steps(path)", """
assert 0 < len(steps) < len(path), len(steps)
more = proxy.steps(path[len(steps):len(steps) + 500])
whole = palpate.Proxy(model, path[0]).steps(path[:len(steps) + 500])
assert whole.wrench.tobytes() == steps.wrench.tobytes() + more.wrench.tobytes()
""")

    def test_end_paths_on_all_threads_and_mark_what_was_not_taken(self):
        for threads in (1, 3):
            self.holds(f"model.follow(paths, threads={threads})", """
taken = ~numpy.isnan(steps.wrench[..., 0])
assert steps.wrench.shape == (3, len(path), 6) and 0 < taken.sum() < taken.size
assert (numpy.diff(taken.astype(int), axis=1) <= 0).all()
assert (steps.faults[~taken] != 0).all() and (steps.contacts[~taken] == 0).all()
most = taken.sum(axis=1).argmax()
same = palpate.Proxy(model, path[0]).steps(path[:taken[most].sum()])
assert same.wrench.tobytes() == steps.wrench[most][taken[most]].tobytes()
""")


def sent(thing):
    return pickle.loads(pickle.dumps(thing))


def spring(hand, twist, tool):
    return -20 * hand[:3], numpy.diag([20, 20, 20])


class States(unittest.TestCase):
    def test_let_a_proxy_go_on_from_them_to_the_same_bits(self):
        for model in (ball_on_block(static_friction=0.5, dynamic_friction=0.3),
                      ball_on_block(contact="spheres", leaves=300, static_friction=0.5, dynamic_friction=0.3)):
            path = wandering_path(700, 3)
            proxy = palpate.Proxy(model, path[0])
            proxy.set_effect(spring, rate_hz=40)
            proxy.steps(path[:317])
            state, copies = proxy.state(), [copy.copy(proxy), copy.deepcopy(proxy), sent(proxy)]
            for made in (state, sent(state)):
                copies.append(palpate.Proxy(sent(model), path[5]))
                copies[-1].set_effect(spring, rate_hz=40)
                copies[-1].set_state(made)
                self.assertEqual(copies[-1].start_depth, proxy.start_depth)
            truth = proxy.steps(path[317:])
            self.assertGreater((truth.contacts > 0).sum(), 200)
            proxy.set_state(state)
            for other in (*copies, proxy):
                felt = other.steps(path[317:])
                self.assertEqual(felt.wrench.tobytes(), truth.wrench.tobytes())
                self.assertEqual(felt.pose.tobytes(), truth.pose.tobytes())

    def test_of_a_solid_that_is_cut_branch_in_the_process(self):
        scene = palpate.load("caries")
        path, model = scene.path()[:2500], scene.model()
        proxy = palpate.Proxy(model, path[0])
        proxy.steps(path[:1500])
        state, other = proxy.state(), copy.copy(proxy)
        truth = proxy.steps(path[1500:])
        self.assertGreater(abs(truth.wrench).max(), 0.01)
        proxy.set_state(state)
        for again in (proxy, other):
            self.assertEqual(again.steps(path[1500:]).wrench.tobytes(), truth.wrench.tobytes())
        with self.assertRaisesRegex(palpate.Error, "another model"):
            palpate.Proxy(scene.model(), path[0]).set_state(state)
        with self.assertRaisesRegex(palpate.Error, "solids"):
            pickle.dumps(state)

    def test_of_others_are_refused(self):
        model, other = ball_on_block(), ball_on_block(static_friction=0.5)
        proxy = palpate.Proxy(model, [0, 0.03, 0])
        for state in (palpate.Proxy(other, [0, 0.03, 0]).state(), sent(palpate.Proxy(other, [0, 0.03, 0]).state())):
            with self.assertRaisesRegex(palpate.Error, "another model"):
                proxy.set_state(state)
        for thing in (model, proxy, proxy.state()):
            stored = pickle.dumps(thing, 2)
            with self.assertRaisesRegex(palpate.Error, "9" * 12):
                pickle.loads(stored.replace(palpate.physics_revision.encode(), b"9" * 12))
        version, stored, effect = proxy.state().__getstate__()
        for wrong in ((version, stored[:-1], effect), (version, b"", None), (version, bytes(len(stored)), None)):
            state = palpate.State.__new__(palpate.State)
            state.__setstate__(wrong)
            with self.assertRaisesRegex(palpate.Error, "state: "):
                proxy.set_state(state)
        self.assertIs(copy.deepcopy(model), model)

    def test_of_models_keep_their_tool_and_parameters(self):
        model = palpate.load("cube").model(separation_um=2, friction=0.3, stiffness_N_per_m=700)
        self.assertEqual(sent(model).parameters, model.parameters)
        self.assertEqual(repr(sent(model)), repr(model))
        with tempfile.TemporaryDirectory() as folder, self.assertRaisesRegex(palpate.Error, "effects"):
            pickle.dumps(palpate.load(cube_with_effects(pathlib.Path(folder))).model())


class Batches(unittest.TestCase):
    def test_give_the_bits_of_single_proxies_on_any_number_of_threads(self):
        model = ball_on_block(static_friction=0.5, dynamic_friction=0.5)
        paths = numpy.stack([wandering_path(80, seed) for seed in range(7)])
        truth = model.follow(paths, details=True)
        for threads in (1, 2, 5, 0):
            for start in (None, paths[:, 0]):
                batch = palpate.Batch(model, 7, start, threads=threads)
                for i in range(paths.shape[1]):
                    felt = batch.step(paths[:, i], details=True)
                    for name in ("wrench", "pose", "contacts", "faults"):
                        self.assertEqual(getattr(felt, name).tobytes(), getattr(truth, name)[:, i].tobytes())
                self.assertEqual(felt.details["rows"].tobytes(), truth.details["rows"][:, -1].tobytes())
        self.assertGreater((truth.contacts > 0).sum(), 200)
        self.assertEqual((len(batch), felt.parameters), (7, model.parameters))
        self.assertGreaterEqual(batch.threads, 1)

    def test_start_those_again_that_a_mask_selects(self):
        model = ball_on_block()
        batch = palpate.Batch(model, 3, [0, 0.03, 0], threads=2)
        batch.step([[0, 0.022, 0]] * 3)
        batch.restart([0, 0.05, 0], [True, False, True])
        self.assertEqual((batch.step([[0, 0.05, 0]] * 3).pose[:, 1] > 0.049).tolist()[::2], [True, True])
        batch.restart([[0, 0.03, 0.001 * i] for i in range(3)])
        numpy.testing.assert_allclose(batch.step([[0, 0.03, 0.001 * i] for i in range(3)]).pose[:, 2], [0, 1e-3, 2e-3])

    def test_say_what_is_wrong(self):
        model = ball_on_block()
        batch = palpate.Batch(model, 3, [0, 0.03, 0])
        for words, wrong in {
            "n: ": lambda: palpate.Batch(model, 0),
            "threads: ": lambda: palpate.Batch(model, 2, threads=-1),
            "3 proxies": lambda: batch.step([[0, 0.03, 0]] * 2),
            "an array": lambda: batch.step([0, 0.03, 0]),
            "pose": lambda: palpate.Batch(model, 2, [0, math.nan, 0]),
            "row 1": lambda: palpate.Batch(model, 2, [[0, 0.03, 0], [0, math.nan, 0]]),
            "mask": lambda: batch.restart([0, 0.03, 0], [0, 1, 1]),
            "mask: ": lambda: batch.restart([0, 0.03, 0], [True]),
        }.items():
            with self.subTest(words), self.assertRaisesRegex(palpate.Error, words):
                wrong()
        self.assertTrue(batch.step([[0, math.nan, 0]] * 3).faults.all())

    def test_go_on_in_a_forked_child(self):
        model = ball_on_block()
        batch = palpate.Batch(model, 8, [0, 0.03, 0], threads=3)
        batch.step([[0, 0.022, 0]] * 8)
        child = os.fork()
        if not child:
            os._exit(0 if batch.step([[0, 0.022, 0]] * 8).contacts.all() else 1)
        self.assertEqual(os.waitpid(child, 0)[1], 0)
        self.assertTrue(batch.step([[0, 0.022, 0]] * 8).contacts.all())


class Circles(unittest.TestCase):
    def test_of_a_proxy_and_its_effect_are_collected(self):
        gone = []
        for _ in range(3):
            proxy = palpate.Proxy(ball_on_block(), [0, 0.03, 0])

            def effect(*_, proxy=proxy):
                return -proxy.start_depth * numpy.ones(3)

            weakref.finalize(effect, gone.append, True)
            proxy.set_effect(effect)
            proxy.step([0, 0.03, 0])
        del proxy, effect
        gc.collect()
        self.assertEqual(len(gone), 3)

    def test_of_nothing_but_a_used_effect_are_kept(self):
        proxy = palpate.Proxy(ball_on_block(), [0, 0.03, 0])
        proxy.set_effect(lambda *_: [0, 0.5, 0])
        gc.collect()
        self.assertEqual(proxy.step([0, 0.03, 0]).force[1], 0.5)


class Reports(unittest.TestCase):
    def test_have_all_that_the_step_says_and_the_same_bits_with_and_without(self):
        model = ball_on_block(static_friction=0.5, dynamic_friction=0.3)
        path = wandering_path(500, 3)
        plain = palpate.Proxy(model, path[0]).steps(path)
        full = palpate.Proxy(model, path[0]).steps(path, details=True)
        self.assertIsNone(plain.details)
        self.assertEqual(full.wrench.tobytes(), plain.wrench.tobytes())
        details = full.details
        self.assertEqual(details.dtype, palpate.report_dtype)
        self.assertEqual(numpy.hstack([details["force_N"], details["torque_Nm"]]).tobytes(), plain.wrench.tobytes())
        self.assertEqual(details["tool"].tobytes(), plain.pose.tobytes())
        rows = details["rows"]
        felt = (rows["force_N"][..., None] * rows["normal"] + rows["friction_N"]).sum(axis=1)
        numpy.testing.assert_allclose(felt, plain.wrench[:, :3], atol=1e-6)
        self.assertEqual(set(rows["static_friction"][rows["force_N"] > 0]), {0.5})
        for stage in ("prediction_ns", "solve_ns", "response_ns"):
            self.assertGreater(details[stage].sum(), 0, stage)
        many = model.follow(path[None], details=True)
        self.assertEqual(many.details["rows"].tobytes(), rows[None].tobytes())
        proxy = palpate.Proxy(model, path[0])
        for row, pose in zip(details, path):
            report = proxy.step(pose)
            self.assertEqual(report.rows.tobytes(), row["rows"][: row["listed"]].tobytes())
        self.assertEqual(report.details["qp_iterations"], details["qp_iterations"][-1])
        self.assertEqual(report.parameters["separation_um"], 1)

    def test_and_bodies_and_scenes_go_through_pickle(self):
        scene = palpate.load("cube")
        path = scene.path()
        model = scene.model(separation_um=2, friction=0)
        steps = palpate.Proxy(model, path[0]).steps(path, details=True)
        report = palpate.Proxy(model, path[0]).step(path[0])

        def loads(thing):
            return pickle.loads(pickle.dumps(thing))

        self.assertEqual(loads(report).details.tobytes(), report.details.tobytes())
        self.assertEqual(loads(report).parameters, model.parameters)
        again = loads(steps)
        self.assertEqual(again.details.tobytes(), steps.details.tobytes())
        self.assertEqual((again.wrench.tobytes(), again.parameters), (steps.wrench.tobytes(), steps.parameters))
        there = loads(scene)
        self.assertEqual(there.path().tobytes(), path.tobytes())
        model = there.model(separation_um=2, friction=0)
        self.assertEqual(palpate.Proxy(model, path[0]).steps(path).wrench.tobytes(), steps.wrench.tobytes())
        body = loads(scene.objects[0])
        self.assertEqual(body.leaf_radii.tobytes(), scene.objects[0].leaf_radii.tobytes())

    def test_have_the_same_names_for_one_step_and_many(self):
        path = wandering_path(50, 3)
        steps, proxy = palpate.Proxy(ball_on_block(), path[0]).steps(path), palpate.Proxy(ball_on_block(), path[0])
        reports = [proxy.step(pose) for pose in path]
        for name in ("wrench", "force", "torque", "pose"):
            numpy.testing.assert_array_equal(getattr(steps, name), [getattr(report, name) for report in reports])

    def test_are_indexed_like_arrays_of_steps(self):
        path = wandering_path(200, 3)
        model = ball_on_block()
        steps = palpate.Proxy(model, path[0]).steps(path, details=True)
        self.assertEqual(len(steps), 200)
        for at in (slice(20, 60, 3), steps.contacts > 0, [3, 1], -1):
            part = steps[at]
            for name in ("wrench", "pose", "contacts", "faults", "details"):
                self.assertEqual(getattr(part, name).tobytes(), getattr(steps, name)[at].tobytes(), name)
            self.assertEqual(part.parameters, steps.parameters)
        self.assertEqual(sum(int(step.contacts) for step in steps), steps.contacts.sum())
        self.assertEqual(pickle.loads(pickle.dumps(steps[20:60])).wrench.tobytes(), steps.wrench[20:60].tobytes())
        for beyond in (200, (slice(None), 1)):
            with self.assertRaises(IndexError):
                steps[beyond]
        with self.assertRaisesRegex(TypeError, "a single step has no length"):
            len(steps[0])
        many = model.follow(numpy.array([path, path[::-1]]))
        self.assertIsNone(many[1].details)
        self.assertEqual([len(many), len(many[1])], [2, 200])
        self.assertEqual(many[1, 5].wrench.tobytes(), many.wrench[1, 5].tobytes())
        asked = mock.MagicMock()
        with mock.patch.dict(sys.modules, pandas=asked, xarray=asked):
            steps[0].to_pandas()
            steps[0].to_xarray()
        self.assertEqual({len(column) for column in asked.DataFrame.call_args.args[0].values()}, {1})
        self.assertEqual(asked.Dataset.call_args.args[0]["faults"][0], ())

    def test_become_tables_only_where_pandas_and_xarray_are(self):
        path = numpy.tile([0, 0.022, 0], (3, 5, 1))
        steps = ball_on_block().follow(path, details=True)
        with mock.patch.dict(sys.modules, pandas=None, xarray=None):
            with self.assertRaisesRegex(ImportError, "pandas: .*python3-pandas"):
                steps.to_pandas()
            with self.assertRaisesRegex(ImportError, "xarray: .*python3-xarray"):
                steps.to_xarray()
        asked = mock.MagicMock()
        with mock.patch.dict(sys.modules, pandas=asked, xarray=asked):
            steps.to_pandas()
            steps.to_xarray()
        table = asked.DataFrame.call_args.args[0]
        self.assertEqual(table["force_N_y"].tobytes(), steps.wrench[..., 1].tobytes())
        self.assertEqual({len(column) for column in table.values()}, {15})
        self.assertIn("solve_ns", table)
        self.assertNotIn("rows", table)
        variables, axes, parameters = asked.Dataset.call_args.args
        self.assertEqual(variables["tool"][0], ("path", "step", "pose"))
        self.assertEqual(variables["faults"][0], ("path", "step"))
        self.assertEqual([len(axes["axis"]), len(axes["pose"])], [3, 7])
        self.assertEqual(parameters, steps.parameters)


class Scenes(unittest.TestCase):
    def test_made_here_are_saved_and_have_the_same_bits_when_they_are_loaded(self):
        block = palpate.body("block", *palpate.box(SIZE), static_friction=0.5, dynamic_friction=0.3)
        block.pose = [0, 0.001, 0]
        scene = palpate.Scene([block], [palpate.ball("ball", 0.005)], name="mine", stiffness_N_per_m=700)
        path = wandering_path(300, 7)
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "mine.palpate")
            scene.save(file)
            same = palpate.load(file)
            with self.assertRaisesRegex(palpate.Error, "ends in .palpate"):
                scene.save(pathlib.Path(folder, "mine.json"))
            palpate.load("cube").save(pathlib.Path(folder, "cube.palpate"))
            self.assertEqual(len(palpate.load(pathlib.Path(folder, "cube.palpate")).path()),
                             len(palpate.load("cube").path()))
        self.assertEqual((same.name, same.parameters["stiffness_N_per_m"]), ("mine", 700))
        felt = [palpate.Proxy(one.model(), path[0]).steps(path).wrench for one in (scene, same)]
        self.assertEqual(felt[0].tobytes(), felt[1].tobytes())
        self.assertGreater(abs(felt[0]).max(), 1)
        with self.assertRaisesRegex(palpate.Error, "'a b': is no name in a scene file"):
            palpate.Scene([block], [palpate.ball("a b", 0.005)])
        with self.assertRaisesRegex(palpate.Error, "no tool, or no object"):
            palpate.Scene([], [palpate.ball("ball", 0.005)])

    def test_have_tools_objects_and_a_path(self):
        scene = palpate.load("caries")
        self.assertEqual(scene.name, "caries")
        self.assertIn("dentine", [material.name for body in scene.objects for material in body.materials])
        self.assertEqual(len(scene.objects[0].leaf_materials), scene.objects[0].leaves)
        self.assertRegex(repr(scene), "Scene caries: tools .*; objects tooth")
        path = scene.path(500)
        self.assertEqual(path.shape[1], 7)
        self.assertEqual(len(scene.path()), 2 * len(path) - 1)
        tool = scene.tools[-1]
        self.assertIn(f"{tool.name} in caries", repr(scene.model(tool.name)))

    def test_of_a_mesh_say_what_was_assumed(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "corner.obj")
            file.write_text("v 0 0 0\nv 10 0 0\nv 0 10 0\nv 0 0 10\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
            scene = palpate.load(file)
            self.assertRegex(" ".join(scene.said), "mm")
            with self.assertRaisesRegex(palpate.Error, "no script"):
                scene.path()

    def test_are_varied_by_name_and_carry_what_was_used(self):
        scene = palpate.load("cube")
        rows = {row["name"]: row for row in palpate.parameters()}
        self.assertEqual(list(rows), list(scene.parameters))
        self.assertEqual(rows["separation_um"]["unit"], "um")
        model = scene.model(stiffness_N_per_m=500, separation_um=2)
        self.assertEqual(model.parameters, {**scene.parameters, "stiffness_N_per_m": 500, "separation_um": 2})
        path = scene.path()[:100]
        self.assertEqual(palpate.Proxy(model, path[0]).steps(path).parameters, model.parameters)
        self.assertEqual(model.follow(path[None]).parameters, model.parameters)
        self.assertIn("separation_um=2,", repr(model))

    def test_tell_which_library_their_reader_lacks(self):
        with tempfile.TemporaryDirectory() as folder:
            reader = pathlib.Path(folder, "palpate-import")
            reader.write_text("#!/bin/sh\necho $0: libassimp.so.5: cannot open >&2\nexit 127\n")
            reader.chmod(0o755)
            mesh = pathlib.Path(folder, "corner.obj")
            mesh.write_text("v 0 0 0\n")
            with mock.patch.dict(os.environ, PALPATE_PROGRAMS=folder):
                with self.assertRaisesRegex(palpate.Error, "libassimp.so.5: cannot open"):
                    palpate.load(mesh)
                with self.assertRaisesRegex(palpate.Error, "libassimp.so.5: cannot open"):
                    palpate.read_mesh(mesh)

    def test_tell_what_is_wrong(self):
        scene = palpate.load("cube")
        for words, wrong in {
            'no scene "cub"': lambda: palpate.load("cub"),
            "give 'surface' or 'spheres'": lambda: palpate.load("cube", contact="air"),
            "stiffness_N_per_m: is of type str; give real numbers": lambda: scene.model(stiffness_N_per_m="500"),
            "friction: is of type bool": lambda: scene.model(friction=True),
            "friction: must be a single number": lambda: scene.model(friction=[0.3]),
            "seperation_um is not known; did you mean .separation_um": lambda: scene.model(seperation_um=1),
            "sub_steps is 0; give a whole number from 1 to 64": lambda: scene.model(sub_steps=0),
            "tool: 7 is not in the scene; give one of ": lambda: scene.model(7),
            "rate": lambda: scene.path(0),
            "tolerance_um": lambda: palpate.load("cube", tolerance_um=0),
        }.items():
            with self.subTest(words), self.assertRaisesRegex(palpate.Error, words):
                wrong()


class Errors(unittest.TestCase):

    def test_say_what_is_wrong_with_numbers_that_numpy_would_make_others_of(self):
        vertices, triangles = palpate.box(SIZE)
        model = ball_on_block()
        hidden = numpy.ma.masked_array(vertices, mask=numpy.zeros(vertices.shape))
        hidden[3, 1] = numpy.ma.masked

        def with_index(index, dtype=None):
            changed = triangles.astype(dtype or type(index)).copy()
            changed[2, 1] = index
            return lambda: palpate.body("thing", vertices, changed)

        turned = [0, 0.03, 0, 2, 0, 0, 0]
        for words, wrong in {
            "triangles: 0.5 is not a vertex": with_index(0.5),
            "triangles: 4294967297.0 is not a vertex": with_index(2**32 + 1, numpy.int64),
            "triangles: -1.0 is not a vertex": with_index(-1, numpy.int64),
            "triangles: nan is not a vertex": with_index(math.nan),
            "triangle 2 names vertex 8 of 8": with_index(8, numpy.int8),
            "triangles: is an array of object": with_index(2**70, object),
            "triangles: is an array of <U": lambda: palpate.body("thing", vertices, triangles.astype(str)),
            "triangles: is an array of bool": lambda: palpate.body("thing", vertices, triangles > 3),
            "vertices: is an array of complex128": lambda: palpate.body("thing", vertices + 0j, triangles),
            "vertices: is an array of object": lambda: palpate.body("thing", vertices.astype(object), triangles),
            "vertices: some of its numbers are masked": lambda: palpate.body("thing", hidden, triangles),
            r"vertices: is not an array of numbers \(its rows differ in length\)": lambda: palpate.body(
                "thing", [[1, 2, 3], [4]], triangles),
            r"poses: is not an array of numbers \(its rows differ in length\)": lambda: model.follow(
                [[[0, 1, 0]] * 2, [[0, 1, 0]] * 3]),
            "steps: an index chooses paths and steps": lambda: palpate.Proxy(model, [0, 1, 0]).steps(
                [[0, 1, 0]] * 3)[..., 0],
            "vertex 1, from 0, is not finite": lambda: palpate.body("thing", [[0, 0, 0], [1, 0, math.inf], [0, 1, 0]],
                                                                    [[0, 1, 2]]),
            "pose: .* length 1": lambda: palpate.Proxy(model, turned),
            "row 1 has a quaternion of length 2": lambda: palpate.Proxy(model, [0, 1, 0]).steps(
                [[0, 0.03, 0, 1, 0, 0, 0], turned]),
            "row 0 has a quaternion of length 2": lambda: palpate.Proxy(model, [0, 1, 0]).step(turned),
            "row 0 has": lambda: model.follow([[turned]]),
            "pose: is an array of <U": lambda: palpate.Proxy(model, ["0", "1", "0"]),
            "pose: is an array of float128": lambda: palpate.Proxy(model, numpy.zeros(3, numpy.longdouble)),
            "size: is an array of complex128": lambda: palpate.box([1j, 1, 1]),
        }.items():
            with self.subTest(words), self.assertRaisesRegex(palpate.Error, words):
                wrong()

    def test_are_none_where_numbers_are_whole_or_nothing_is_masked(self):
        vertices, triangles = palpate.box(SIZE)
        for same in (triangles.astype(float), triangles.tolist(), numpy.asfortranarray(triangles),
                     numpy.ma.masked_array(triangles), triangles.astype(">i8")):
            block = palpate.body("block", numpy.ma.masked_array(vertices), same, leaves=64)
            self.assertEqual(block.triangles.tobytes(), triangles.tobytes())
            self.assertEqual(block.vertices.tobytes(), vertices.tobytes())

    def test_are_warnings_where_lengths_are_hardly_metres(self):
        vertices, triangles = palpate.box(SIZE)
        with self.assertWarnsRegex(UserWarning, "tooth: its longest side is 40 m.* likely mm: multiply them by 0.001"):
            tooth = palpate.body("tooth", 1000 * vertices, triangles, leaves=64)
        self.assertRegex(tooth.remarks[-1], "longest side is 40 m")
        with self.assertWarnsRegex(UserWarning, "probe"):
            palpate.ball("probe", 5)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            palpate.body("tooth", vertices, triangles, leaves=64)

    def test_of_names_and_numbers_are_the_same_at_every_door(self):
        block, ball = palpate.body("block", *palpate.box(SIZE)), palpate.ball("ball", 0.005)
        scene = palpate.Scene([block], [ball])
        for name, value in {"stiffness_N_per_m": 1e9, "torsional_stiffness_Nm_per_rad": 0, "friction": 11,
                            "separation_um": math.nan}.items():
            for door in (lambda: palpate.Model([block], ball, **{name: value}), lambda: scene.model(**{name: value}),
                         lambda: palpate.Scene([block], [ball], **{name: value})):
                with self.subTest(name), self.assertRaisesRegex(palpate.Error, name):
                    door()
        twin, blank = palpate.ball("block", 0.005), palpate.ball("", 0.005)
        for tool, words in ((twin, "two bodies"), (blank, "no name")):
            for door in (lambda: palpate.Model([block], tool), lambda: palpate.Scene([block], [tool])):
                with self.assertRaisesRegex(palpate.Error, words):
                    door()
        with self.assertRaisesRegex(palpate.Error, "11"):
            palpate.body("block", *palpate.box(SIZE), static_friction=11)
        self.assertEqual(palpate.Model([block], ball, friction=0.3).parameters["friction"], 0.3)
        self.assertEqual(sent(block).name, "block")

    def test_of_open_meshes_are_remarks_of_the_body(self):
        vertices, triangles = palpate.box(SIZE)
        self.assertRegex(" ".join(palpate.body("lid", vertices, triangles[2:]).remarks), "open")
        self.assertEqual(palpate.body("box", vertices, triangles).remarks, [])

    def test_of_poses_are_raised_or_counted(self):
        model = ball_on_block()
        path = numpy.tile([0, 0.022, 0], (5, 1))
        path[3, 1] = math.nan
        proxy, batch = palpate.Proxy(model, [0, 0.022, 0]), palpate.Batch(model, 5, [0, 0.022, 0])
        self.assertEqual([proxy.steps(path).bad_poses, model.follow(path[None, :3]).bad_poses], [1, 0])
        self.assertEqual(batch.step(path).bad_poses, 1)
        self.assertIn("1 bad pose", repr(proxy.steps(path)))
        state = pickle.dumps(proxy.state())
        for call in (proxy.steps, batch.step, lambda poses, **how: model.follow(poses[None], **how)):
            with self.assertRaisesRegex(palpate.Error, "row 3 is not finite"):
                call(path, on_bad_pose="raise")
            with self.assertRaisesRegex(palpate.Error, "on_bad_pose"):
                call(path, on_bad_pose="ignore")
        self.assertEqual(pickle.dumps(proxy.state()), state)

    def test_of_poses_are_faults_and_give_no_force(self):
        proxy = palpate.Proxy(ball_on_block(), [0, 0.022, 0])
        self.assertEqual(proxy.step([0, math.nan, 0]).faults, 1)
        self.assertEqual(list(proxy.step([0, math.inf, 0]).force), [0, 0, 0])
        self.assertNotEqual(palpate.fault_words(1), palpate.fault_words(0))

    def test_come_of_two_threads_at_one_proxy_not_a_crash(self):
        proxy = palpate.Proxy(ball_on_block(), [0, 0.03, 0])
        path = numpy.tile([0, 0.022, 0], (20_000, 1))
        complaints = []

        def step():
            try:
                proxy.steps(path)
            except palpate.Error as error:
                complaints.append(str(error))

        threads = [threading.Thread(target=step) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for complaint in complaints:
            self.assertIn("another thread", complaint)


class Memory(unittest.TestCase):
    def test_lives_as_long_as_what_looks_at_it(self):
        radii = palpate.body("block", *palpate.box(SIZE), leaves=64).leaf_radii
        proxy = palpate.Proxy(ball_on_block(), [0, 0.022, 0])
        gc.collect()
        self.assertEqual(len(radii), 64)
        self.assertGreater(radii.min(), 0)
        with self.assertRaises(ValueError):
            radii[0] = 1
        self.assertAlmostEqual(proxy.step([0, 0.022, 0]).force[1], 3, 2)


class Files(unittest.TestCase):
    def test_of_meshes_are_read_in_their_unit(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "corner.obj")
            file.write_text("v 0 0 0\nv 10 0 0\nv 0 10 0\nv 0 0 10\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
            vertices, triangles = palpate.read_mesh(file, unit="mm")
            self.assertEqual(triangles.shape, (4, 3))
            self.assertAlmostEqual(vertices.max(), 0.01)
            self.assertEqual(palpate.body("corner", vertices, triangles, leaves=64).leaves, 64)
            with self.assertRaisesRegex(palpate.Error, "unit"):
                palpate.read_mesh(file, unit="furlong")
            with self.assertRaisesRegex(palpate.Error, "nowhere.stl"):
                palpate.read_mesh(pathlib.Path(folder, "nowhere.stl"))


class Help(unittest.TestCase):
    def test_says_what_the_stubs_say_of_every_name(self):
        said = 0
        for module, stub in ((palpate, "__init__.pyi"), (live, "live.pyi")):
            tree = ast.parse((pathlib.Path(palpate.__file__).parent / stub).read_text())
            for owner in [tree, *(node for node in tree.body if isinstance(node, ast.ClassDef))]:
                place = module if owner is tree else getattr(module, owner.name)
                for node in owner.body:
                    if not isinstance(node, (ast.ClassDef, ast.FunctionDef)) or not ast.get_docstring(node):
                        continue
                    shown = pydoc.plain(pydoc.render_doc(getattr(place, node.name)))
                    for line in ast.get_docstring(node).splitlines():
                        self.assertIn(line, shown, f"{stub}: {node.name}")
                    said += 1
        self.assertGreater(said, 45)


class Examples(unittest.TestCase):
    def test_as_notebooks_find_the_truth_and_are_shown_as_they_are(self):
        render = pathlib.Path(os.environ["PALPATE_SOURCE_DIR"], "client/python/notebooks/render")
        done = subprocess.run([render, "--check"], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stdout.count("up to date"), 3)

    def test_give_a_first_force_in_a_scene_in_five_statements(self):
        example = pathlib.Path(os.environ["PALPATE_SOURCE_DIR"], "client/python/examples/first_scene.py")
        tree = ast.parse(example.read_text())
        self.assertLessEqual(sum(not isinstance(node, (ast.Import, ast.Expr)) for node in tree.body), 4)
        done = subprocess.run([sys.executable, example, "cube"], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, r"ball feels \[.*\d.*\] N")

    def test_lead_into_a_groove_by_a_force_of_ones_own(self):
        example = pathlib.Path(os.environ["PALPATE_SOURCE_DIR"], "client/python/examples/own_effect.py")
        done = subprocess.run([sys.executable, example], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, r"(?s) 8\.9 mm beside it: -0\.4\d\d N to it, 0\.000 .* 0\.020 N to it, 2\.00\d N")

    def test_give_a_first_force_in_twenty_lines(self):
        example = pathlib.Path(os.environ["PALPATE_SOURCE_DIR"], "client/python/examples/first_force.py")
        self.assertLessEqual(len(example.read_text().splitlines()), 20)
        done = subprocess.run([sys.executable, example], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 1)
        self.assertIn("Usage: first_force.py MESH", done.stderr)
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "pyramid.obj")
            file.write_text("v -9 -9 0\nv 9 -9 0\nv 9 9 0\nv -9 9 0\nv 0 0 6\n"
                            "f 4 3 2 1\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n")
            done = subprocess.run([sys.executable, example, file, "mm"], capture_output=True, text=True,
                                  check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, r"force \[.* 0\.9\d.*\] N, faults none")


if __name__ == "__main__":
    unittest.main()
