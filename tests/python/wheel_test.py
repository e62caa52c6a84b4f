"""The wheel that deploy/wheel makes, in a virtual environment that has nothing of this build."""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest
import zipfile

SOURCE = pathlib.Path(os.environ["PALPATE_SOURCE_DIR"])
FIRST_FORCE = """
import palpate
scene = palpate.load("bunny-bunny")
path = scene.path()
proxy = palpate.Proxy(scene.model(), path[0])
report = next(report for report in map(proxy.step, path) if report.contacts)
print(palpate.__file__, report.force)
from palpate import live
import json
with open("honey.json", "w") as file:
    json.dump({"tools": [{"name": "ball", "mesh": {"shape": "sphere", "radius_m": 0.005}, "leaves": 1}],
               "objects": [{"name": "cube", "mesh": {"shape": "box", "size_m": [0.05, 0.05, 0.05]}, "leaves": 64}],
               "effects": [{"name": "viscous"}]}, file)
proxy = palpate.Proxy(palpate.load("./honey.json").model(), (0, 0.040, 0))
proxy.step((0, 0.040, 0))
assert proxy.step((0, 0.041, 0)).force[1] < 0
"""


class Wheel(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        cls.root = pathlib.Path(cls.folder.name)
        made = subprocess.run([SOURCE / "deploy/wheel", "--no-build", "--out", cls.root], capture_output=True, text=True,
                              check=False)
        if "No module named wheel" in made.stdout:
            raise unittest.SkipTest("python3-wheel is missing: deploy/setup --for tests installs it")
        assert made.returncode == 0, made.stdout + made.stderr
        (cls.wheel,) = cls.root.glob("*.whl")

    def test_is_small_and_holds_what_the_package_does(self):
        self.assertLess(self.wheel.stat().st_size, 10e6)
        held = set(zipfile.ZipFile(self.wheel).namelist())
        for file in ("palpate/__init__.pyi", "palpate/programs/bin/palpate-import",
                     "palpate/programs/lib/palpate/effects/viscous.so",
                     "palpate/programs/share/palpate/catalogue/bunny-bunny.path.json"):
            self.assertIn(file, held)

    def test_feels_the_first_force_where_nothing_else_is_installed(self):
        there = self.root / "there"
        made = subprocess.run([sys.executable, "-m", "venv", "--without-pip", "--system-site-packages", there],
                              capture_output=True, text=True, check=False)
        pip = subprocess.run([sys.executable, "-m", "pip", "--python", there / "bin/python", "install", "--no-index",
                              "--no-compile", "--quiet", self.wheel], capture_output=True, text=True, check=False)
        if made.returncode or "No module named pip" in pip.stderr:
            self.skipTest("python3-venv or python3-pip is missing: deploy/setup --for tests installs them")
        self.assertEqual(pip.returncode, 0, pip.stderr)
        bare = {name: value for name, value in os.environ.items() if not name.startswith(("PALPATE_", "PYTHON"))}
        felt = subprocess.run([there / "bin/python", "-c", FIRST_FORCE], capture_output=True, text=True, check=False,
                              cwd=self.root, env={**bare, "PATH": "/usr/bin:/bin"})
        self.assertEqual(felt.returncode, 0, felt.stderr)
        self.assertRegex(felt.stdout, rf"^{there}/lib/.*__init__.py \[.*\d.*\]")


if __name__ == "__main__":
    unittest.main()
