"""The user study that the examples begin one with: its orders, and all of it with a simulated hand."""

import csv
import importlib.util
import os
import pathlib
import subprocess
import sys
import tempfile
import tomllib
import unittest
from collections import Counter

from support import Program, own_domain

EXAMPLES = pathlib.Path(os.environ["PALPATE_SOURCE_DIR"], "client/python/examples")
spec = importlib.util.spec_from_file_location("user_study", EXAMPLES / "user_study.py")
user_study = importlib.util.module_from_spec(spec)
spec.loader.exec_module(user_study)


class Orders(unittest.TestCase):
    def test_have_each_condition_at_each_place_and_after_each_other_equally_often(self):
        for count in range(2, 8):
            orders = user_study.latin_square(count)
            self.assertEqual(len(orders), count if count % 2 == 0 else 2 * count)
            for place in range(count):
                self.assertEqual(set(Counter(order[place] for order in orders).values()), {len(orders) // count})
            pairs = Counter(pair for order in orders for pair in zip(order, order[1:]))
            self.assertEqual(len(pairs), count * (count - 1))
            self.assertEqual(len(set(pairs.values())), 1)

    def test_of_the_example_are_printed(self):
        done = subprocess.run([sys.executable, EXAMPLES / "user_study.py", "order", EXAMPLES / "user_study.toml"],
                              capture_output=True, text=True, check=True)
        self.assertEqual(done.stdout.splitlines()[:3], ["P01: flat, round", "P02: round, flat", "P03: flat, round"])


class Trials(unittest.TestCase):
    def test_are_recorded_asked_about_and_exported(self):
        text = (EXAMPLES / "user_study.toml").read_text()
        text = text.replace("seconds = 20", "seconds = 1").replace('"simulated"', '"simulated", "--realtime", "off"')
        text = text.replace('round = "ellipsoid"', 'round = "cube"').replace("participants = 12", "participants = 2")
        questions = list(tomllib.loads(text)["questions"])
        domain = str(own_domain())
        with tempfile.TemporaryDirectory() as folder:
            file, table = pathlib.Path(folder, "mine.toml"), pathlib.Path(folder, "table.csv")
            file.write_text(text)

            def call(*arguments, said=""):
                words = [sys.executable, EXAMPLES / "user_study.py", *arguments, "--domain", domain,
                         "--transport", "udp"]
                return subprocess.run([*map(str, words)], input=said, capture_output=True, text=True, timeout=120,
                                      check=False)

            server = Program("palpate-server", "cube", "--domain", domain, "--transport", "udp", "--realtime", "off")
            with server:
                self.assertTrue(server.says("ready"), server.text)
                answers = "\n" + "".join(f"{10 * i}\n" for i in range(6))
                # A number out of range is asked for again; the second trial stops at its questions.
                done = call("run", file, 2, said=answers.replace("\n0\n", "\n101\n0\n") + "\n5\n")
                self.assertIn("EOFError", done.stderr)
                done = call("run", file, 2, said=answers)
                self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            self.assertEqual(call("run", file, 3).returncode, 2)
            done = call("export", file, "-o", table)
            self.assertEqual(done.returncode, 0, done.stderr)
            with table.open(newline="") as rows:
                rows = list(csv.DictReader(rows))
        self.assertEqual([(row["participant"], row["place"], row["condition"]) for row in rows],
                         [("2", "1", "round"), ("2", "2", "flat")])
        for row in rows:
            self.assertEqual([row[name] for name in questions], ["0", "10", "20", "30", "40", "50"])
            self.assertGreater(int(row["steps"]), 0)


if __name__ == "__main__":
    unittest.main()
