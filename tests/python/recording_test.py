"""A recording made by the real programs: as read_recording gives it, as palpate-replay exports it, and as it was
heard while it was made."""

import csv
import json
import os
import pathlib
import subprocess
import tempfile
import unittest

import numpy

import palpate
from palpate import live
from support import Program, own_domain, server, station

DOMAIN = own_domain()


def export(recording, folder, form):
    done = subprocess.run([os.path.join(os.environ["PALPATE_PROGRAMS"], "palpate-replay"), "export", recording, "-o",
                           folder, "--format", form], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(done.stderr)


class Recording(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.file = pathlib.Path(cls.folder.name, "lesson.mcap")
        with server(DOMAIN), live.Session(DOMAIN, transport="udp", wrenches=True) as session:
            recorder = Program("palpate-record", "-o", cls.file, "--domain", DOMAIN, "--transport", "udp")
            with recorder:
                assert recorder.says("recording"), recorder.text
                with station(DOMAIN, "hand", "--for", "4") as hand:
                    assert hand.ends() == 0, hand.text
            cls.heard = session.wrenches("hand")
        cls.tables = palpate.read_recording(cls.file)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def session(self):
        self.assertEqual(len(self.tables), 1, list(self.tables))
        return next(iter(self.tables.values()))

    def test_has_the_session_as_it_was_heard(self):
        wrenches = self.session()["wrenches"]
        recorded = {row["pose_sequence"]: row for row in wrenches}
        both = [(heard, recorded[heard["pose_sequence"]]) for heard in self.heard
                if heard["pose_sequence"] in recorded]
        self.assertGreater(len(both), 500)  # how many of the 4,000 come depends on the load
        force = numpy.array([list(heard["force_N"]) for heard, _ in both])
        columns = numpy.array([[row["force_x_N"], row["force_y_N"], row["force_z_N"]] for _, row in both])
        numpy.testing.assert_array_equal(force, columns)
        # The hand rests on the cube with a third of a newton.
        self.assertGreater(numpy.linalg.norm(columns, axis=1).max(), 0.2)
        tool = numpy.array([list(heard["tool"][:3]) for heard, _ in both])
        numpy.testing.assert_array_equal(tool[:, 1], [row["tool_y_m"] for _, row in both])

    def test_has_tables_that_fit_each_other(self):
        tables = self.session()
        for name in ("poses", "wrenches", "tool_states", "session", "loop"):
            self.assertGreater(len(tables[name]), 0, name)
        poses, wrenches = tables["poses"], tables["wrenches"]
        self.assertTrue(numpy.all(numpy.diff(poses["time_s"]) >= 0))
        self.assertEqual(set(numpy.diff(poses["pose_sequence"].astype(int))), {1})
        # The spring's force is 1 N/mm between hand and tool, for wrenches with the full force.
        hand = {row["pose_sequence"]: row["hand_y_m"] for row in poses}
        settled = [row for row in wrenches[-500:] if row["pose_sequence"] in hand and row["faults"] == 0]
        for row in settled:
            self.assertAlmostEqual(row["force_y_N"], 1e3 * (row["tool_y_m"] - hand[row["pose_sequence"]]), delta=0.01)
        self.assertGreater(len(settled), 100)
        self.assertIn("active", {row["phase"].decode() if isinstance(row["phase"], bytes) else row["phase"]
                                 for row in tables["session"]})

    def test_has_the_same_figures_in_every_form_of_export(self):
        with tempfile.TemporaryDirectory() as folder:
            for form in ("npy", "csv"):
                export(self.file, os.path.join(folder, form), form)
            methods = json.loads(pathlib.Path(folder, "csv", "methods.json").read_text())
            self.assertEqual(methods["scenes"], [{"scene": "cube", "hash": palpate.load("cube").hash}])
            compared = set()
            for file in sorted(pathlib.Path(folder, "npy").glob("*/*.npy")):
                array = numpy.load(file, allow_pickle=False)
                text = pathlib.Path(folder, "csv", file.parent.name, file.stem + ".csv").read_text()
                rows = list(csv.reader(text.splitlines()))
                self.assertEqual(tuple(rows[0]), array.dtype.names, file)
                self.assertEqual(len(rows) - 1, len(array), file)
                numpy.testing.assert_array_equal(array, self.tables[file.parent.name][file.stem])
                for column, name in enumerate(rows[0]):
                    values = [row[column] for row in rows[1:]]
                    if array.dtype[name].kind == "S":
                        self.assertEqual([value.encode() for value in values], array[name].tolist(), name)
                    elif array.dtype[name].kind == "U":
                        self.assertEqual(values, array[name].tolist(), name)
                    else:
                        # The numbers read back to the last bit.
                        numpy.testing.assert_array_equal(numpy.array(values, array.dtype[name]), array[name])
                    compared |= {(file.stem, name)} if values else set()
            tables = self.session()
            self.assertEqual(compared, {(table, name) for table, rows in tables.items() if len(rows)
                                        for name in rows.dtype.names})


class OwnRecording(unittest.TestCase):
    """A path of one's own, written as a session."""

    def test_has_the_proxys_bits_and_verifies(self):
        scene = palpate.load("cube")
        t = numpy.linspace(0, 1, 500)
        path = numpy.stack([0.01 * t, 0.0302 - 0.001 * numpy.sin(3 * t), 0 * t], axis=1)
        steps = palpate.Proxy(scene.model(), path[0]).steps(path)
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "mine.mcap")
            palpate.record(file, scene, path)
            self.assertEqual(subprocess.run([os.path.join(os.environ["PALPATE_PROGRAMS"], "palpate-replay"), "--verify",
                                             file], capture_output=True, check=False).returncode, 0)
            wrenches = next(iter(palpate.read_recording(file).values()))["wrenches"]
            with self.assertRaises(palpate.Error):
                palpate.record(file, scene, path)  # replaces nothing
            for wrong in ([], [[0, 0]], [[numpy.nan, 0, 0]], [[0, 0, 0, 2, 0, 0, 0]]):
                with self.assertRaises(palpate.Error):
                    palpate.record(pathlib.Path(folder, "no.mcap"), scene, wrong)
        at = numpy.stack([wrenches[f"tool_{axis}_m"] for axis in "xyz"], axis=1)
        numpy.testing.assert_array_equal(at, steps.pose[:, :3])
        force = numpy.stack([wrenches[f"force_{axis}_N"] for axis in "xyz"], axis=1)
        self.assertGreater(numpy.abs(steps.force).max(), 0.5)
        numpy.testing.assert_array_equal(force[200:], steps.force[200:])


if __name__ == "__main__":
    unittest.main()
