"""palpate.study as a researcher calls it: against palpate itself for the bits of a row."""

import contextlib
import csv
import io
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import numpy

import palpate
from palpate import hands
from palpate.study import Study, figures, main

EXAMPLES = pathlib.Path(os.environ["PALPATE_SOURCE_DIR"], "client/python/examples")
STUDY = """
title = "A test"
scenes = ["cube"]
seeds = "1..2"
steps = 1500
measures = "own.py:measure"
[hands.explorer]
kind = "generated"
speed_mm_per_s = 200
[hands.trembling]
kind = "script"
tremor_um = 20
[hands.plain]
kind = "script"
[hands.own]
kind = "python"
function = "own.py:down"
[parameters]
friction = [0.0, 0.3]
stiffness_N_per_m = 500
"""
OWN = """
import numpy
def down(scene, random, steps):
    path = numpy.tile([0, 0.03, 0], (steps, 1))
    path[:, 1] -= numpy.linspace(0, 0.005 + 0.001 * random.uniform(), steps)
    return path
def measure(path, steps):
    return {"end_m": float(steps.pose[-1, 1])}
"""


def study(*arguments):
    return subprocess.run([sys.executable, "-m", "palpate.study", *map(str, arguments)], capture_output=True, text=True,
                          timeout=120, check=False)


class Folder(unittest.TestCase):
    def setUp(self):
        kept = tempfile.TemporaryDirectory()
        self.addCleanup(kept.cleanup)
        self.folder = pathlib.Path(kept.name)
        self.file = self.folder / "study.toml"
        self.write(STUDY)
        (self.folder / "own.py").write_text(OWN)
        self.table = self.folder / "out" / "table.csv"

    def write(self, text):
        self.file.write_text(text)

    def run_study(self, *arguments):
        said = io.StringIO()
        with contextlib.redirect_stderr(said):
            self.assertEqual(main([str(self.file), "-o", str(self.folder / "out"), *arguments]), 0)
        return said.getvalue()

    def rows(self):
        with self.table.open(newline="") as text:
            return list(csv.DictReader(text))


class Table(Folder):
    def test_has_the_same_bytes_on_one_core_on_three_and_after_an_interruption(self):
        self.run_study("--jobs", "1")
        once = self.table.read_bytes()
        self.assertEqual(len(self.rows()), 2 * (2 + 2 + 1 + 2))
        self.table.unlink()
        self.run_study("--jobs", "3", "--keep")
        self.assertEqual(self.table.read_bytes(), once)
        self.table.write_bytes(b"\n".join(once.split(b"\n")[:6]) + b"\n")
        self.assertIn("14 runs, 5 of them already done", self.run_study())
        self.assertEqual(self.table.read_bytes(), once)
        self.assertIn("14 runs, 14 of them already done", self.run_study())
        # The key has all that a row depends on.
        self.write(STUDY.replace("0.3]", "0.4]"))
        self.assertIn("14 runs, 7 of them already done", self.run_study())
        (self.folder / "own.py").write_text(OWN + "# not the same\n")
        self.assertIn("14 runs, 0 of them already done", self.run_study())

    def test_varies_how_closely_sphere_trees_follow(self):
        self.write('scenes = ["cube"]\nsteps = 50\ntolerances_um = [200, 1000]\n')
        self.run_study()
        self.assertEqual([row["tolerance_um"] for row in self.rows()], ["200", "1000"])
        methods = (self.folder / "out" / "METHODS.md").read_text()
        for um in (200, 1000):
            scene = palpate.load("cube", tolerance_um=um)
            self.assertIn(f"{len(scene.objects[0].triangles)} | {scene.objects[0].leaves} | ball", methods)

    def test_has_what_palpate_gives(self):
        self.run_study("--keep")
        scene = palpate.load("cube")
        for row in self.rows():
            if row["hand"] == "explorer":
                path = hands.generated(scene, steps=1500, seed=int(row["seed"]), speed_mm_per_s=200)
            elif row["hand"] == "plain":
                self.assertEqual(row["seed"], "")
                path = scene.path()[:1500]
            else:
                continue
            model = scene.model(friction=float(row["friction"]), stiffness_N_per_m=500)
            steps = palpate.Proxy(model, path[0]).steps(path)
            for name, value in figures(steps).items():
                self.assertEqual(row[name], str(value), name)
            self.assertEqual(float(row["end_m"]), steps.pose[-1, 1])
            kept = numpy.load(self.folder / "out" / "runs" / f"{row['key']}.npz")
            numpy.testing.assert_array_equal(kept["wrench"], steps.wrench)
            numpy.testing.assert_array_equal(kept["hand"], path)
        felt = {row["hand"]: float(row["touching"]) for row in self.rows()}
        self.assertGreater(felt["explorer"], 0.2)
        self.assertGreater(felt["own"], 0.1)
        # A hand that presses straight down feels no friction, but for what contacts yield.
        ends = [float(row["end_m"]) for row in self.rows() if row["hand"] == "own"]
        numpy.testing.assert_allclose(ends[:2], ends[2:], rtol=0.0, atol=1e-12)
        self.assertEqual(len({row["bits"] for row in self.rows()}), 14)

    def test_comes_with_the_text_of_its_methods(self):
        self.run_study()
        methods = (self.folder / "out" / "METHODS.md").read_text()
        for words in ("# A test\n", f"Palpate {palpate.__version__}", palpate.load("cube").hash,
                      "14 of 14 runs of 1500 steps", "speed_mm_per_s 200", "own.py:measure", numpy.__version__):
            self.assertIn(words, methods)
        self.assertRegex(methods, r"\| friction \| 0, 0\.3 \| 1 \|")
        self.assertRegex(methods, r"\| stiffness_N_per_m \| 500 \| N/m \| 1000 \|")
        self.assertRegex(methods, r"\| separation_um \| 1 \(the scenes'\) \| um \|")
        for column in self.rows()[0]:
            self.assertRegex(methods, rf"(?m)^\| {column} \| ")
        for lines in re.findall(r"(?m)(?:^\|.*\n)+", methods):
            self.assertEqual(len({line.count("|") for line in lines.splitlines()}), 1, lines)

    def test_keeps_what_is_done_when_it_is_interrupted(self):
        self.write(STUDY.replace("1..2", "1..500"))
        running = subprocess.Popen([sys.executable, "-m", "palpate.study", self.file, "-o", self.folder / "out"],
                                   stderr=subprocess.PIPE, text=True)
        until = time.monotonic() + 60
        while not self.table.exists() and running.poll() is None and time.monotonic() < until:
            time.sleep(0.02)
        running.send_signal(signal.SIGINT)
        said = running.communicate(timeout=60)[1]
        self.assertEqual(running.returncode, 1, said)
        self.assertRegex(said, r"table.csv of \d+ of 3002 runs, and METHODS.md; the same command continues")
        self.assertNotIn("Traceback", said)
        self.assertGreater(len(self.rows()), 0)


class Mistakes(Folder):
    def test_are_told_with_file_field_and_remedy(self):
        for change, words in {
            ("steps = 1500", "steps = 1500.5"): "steps: is 1500.5; give a whole number above 1",
            ("steps =", "stepps ="): "stepps: is not known; give one of contacts, hands",
            ('["cube"]', '"cube"'): "scenes: is 'cube'; give a list",
            ('"1..2"', '"2..1"'): "seeds: is '2..1'; give a range",
            ('"1..2"', "[1, -2]"): "seeds: is [1, -2]; give a range",
            ('kind = "generated"', 'kind = "generate"'): "hands.explorer.kind: is 'generate'; give one of generated, ",
            ("mm_per_s = 200", "mm_per_s = 0"): "hands.explorer.speed_mm_per_s: is 0; give a number above 0",
            ("speed_mm_per_s", "speed"): "hands.explorer.speed: is not known; give one of kind, press_mm",
            ('function = "own.py:down"', ""): "hands.own: function is missing",
            ("own.py:down", "own.py:up"): "hands.own.function: is 'own.py:up'; but ",
            ("own.py:measure", "other.py:measure"): "measures: is 'other.py:measure'; give \"FILE.py:FUNCTION\"",
            ("friction =", "fricton ="): "parameters.fricton: is not known; give one of friction, ",
            ("= 500", "= 0"): "parameters.stiffness_N_per_m: is 0; give numbers from 0.01 to 100000 N/m",
            ("title =", "title"): "at line 2",
        }.items():
            with self.subTest(words):
                self.write(STUDY.replace(*change))
                with self.assertRaises(palpate.Error) as wrong:
                    Study(self.file)
                self.assertIn(f"{self.file}: ", str(wrong.exception))
                self.assertIn(words, str(wrong.exception))

    def test_name_an_encoding_that_a_study_may_not_have(self):
        pathlib.Path(self.file).write_bytes(STUDY.encode("utf-8-sig"))
        Study(self.file)
        for encoding in ("utf-16", "utf-16-le", "utf-16-be"):
            pathlib.Path(self.file).write_bytes(STUDY.encode(encoding))
            with self.assertRaises(palpate.Error) as wrong:
                Study(self.file)
            self.assertEqual(str(wrong.exception), f"{self.file}: its text is UTF-16; save it as UTF-8")

    def test_end_the_program_with_a_sentence(self):
        done = study(self.folder / "none.toml")
        self.assertEqual((done.returncode, done.stderr),
                         (1, f"palpate.study: {self.folder}/none.toml: cannot be read (No such file or directory); "
                             "--help shows a study file\n"))
        self.assertEqual(study(self.file, "--jobs", "0").returncode, 2)
        self.write(STUDY.replace("= 500", "= 500\nsub_steps = 2.5"))
        done = study(self.file, "-o", self.folder / "out")
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr, r"run \{.*'hand': .*\}: parameter sub_steps is 2.5; give a whole number")
        self.assertNotIn("Traceback", done.stderr)

    def test_are_seen_before_a_run_by_list(self):
        done = study(self.file, "--list")
        self.assertEqual(len(done.stdout.splitlines()), 14)
        self.assertIn("scene cube, tool 0, hand explorer, seed 2, friction 0.3, stiffness_N_per_m 500", done.stdout)


class Examples(unittest.TestCase):
    def test_are_right(self):
        Study(EXAMPLES / "friction_study.toml")
        said = study("--help").stdout
        begin = said.index('  title = "')
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "study.toml")
            numpy.savetxt(pathlib.Path(folder, "hand.csv"), numpy.zeros((20000, 3)), delimiter=",")
            pathlib.Path(folder, "my_hands.py").write_text("def circle(scene, random, steps): pass\n")
            file.write_text(said[begin : said.index("optional: hands")])
            self.assertEqual(len(Study(file).hands), 4)


class Hands(unittest.TestCase):
    def test_begin_free_move_smoothly_and_depend_on_the_seed(self):
        scene = palpate.load("cube")
        path = hands.generated(scene, steps=4000, seed=3)
        numpy.testing.assert_array_equal(path, hands.generated(scene, steps=4000, seed=3))
        self.assertFalse(numpy.array_equal(path, hands.generated(scene, steps=4000, seed=4)))
        numpy.testing.assert_allclose(numpy.linalg.norm(path[:, 3:], axis=1), 1, atol=1e-12)
        self.assertLess(numpy.linalg.norm(numpy.diff(path[:, :3], axis=0), axis=1).max(), 0.0015)
        self.assertEqual(palpate.Proxy(scene.model(), path[0]).start_depth, 0)
        felt = palpate.Proxy(scene.model(), path[0]).steps(path)
        self.assertGreater((felt.contacts > 0).mean(), 0.3)
        self.assertLess(numpy.linalg.norm(felt.wrench[:, :3], axis=1).max(), 3.5)  # it presses 3 mm deep at most

    def test_of_a_script_go_the_same_way_back(self):
        scene = palpate.load("cube")
        path = scene.path()
        longer = hands.script(scene, steps=len(path) + 100)
        numpy.testing.assert_array_equal(longer[: len(path)], path)
        numpy.testing.assert_array_equal(longer[len(path) :], path[-2:-102:-1])

    def test_tremble_by_what_is_said(self):
        path = numpy.tile([0.1, 0.2, 0.3, 1, 0, 0, 0], (20000, 1))
        trembling = hands.trembling(path, um=20, seed=1)
        numpy.testing.assert_allclose(trembling[:, :3].std(axis=0), 20e-6, rtol=0.1)
        numpy.testing.assert_array_equal(trembling[:, 3:], path[:, 3:])


if __name__ == "__main__":
    unittest.main()
