"""palpate.live with a real server, over real DDS."""

import ast
import gc
import inspect
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import weakref

import numpy

import palpate
from palpate import live
from support import own_domain, server, station

DOMAIN = own_domain()
# The cube's upper face is at 0.025 m and the ball's radius 5 mm; the spring gives 1 N/mm.
TOUCH = 0.030


def opened(name="script", **options):
    return live.Station("cube", name, domain=DOMAIN, transport="udp", **options)


def eventually(condition, seconds=20):
    until = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > until:
            return False
        time.sleep(0.01)
    return True


def pressed(hand, depth, wanted):
    """Presses until the spring's force is as wanted: where a busy host makes answers late, it comes in again."""
    eventually(lambda: abs(hand.move([0, TOUCH - depth, 0], 0.3).wanted_force[1] - wanted) < 0.02)
    return hand.felt


def script(text, *arguments):
    return subprocess.Popen([sys.executable, "-c", text, str(DOMAIN), *arguments], stdin=subprocess.PIPE,
                            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


class Served(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = server(DOMAIN)

    @classmethod
    def tearDownClass(cls):
        cls.server.kill()


class Station(Served):
    def test_feels_the_springs_force_where_it_is_moved_to(self):
        with opened() as hand:
            self.assertEqual((hand.scene, hand.tool, hand.id), ("cube", "ball", "script"))
            self.assertIn("session: tool 'ball' of scene 'cube'", hand.news())
            hand.move([0, TOUCH + 0.001, 0], 0.2)
            numpy.testing.assert_array_equal(hand.felt.wanted_force, [0, 0, 0])
            felt = pressed(hand, 0.002, 2)
            numpy.testing.assert_allclose(felt.wanted_force, [0, 2, 0], atol=0.02)
            numpy.testing.assert_allclose(felt.hand[:3], [0, TOUCH - 0.002, 0], atol=0)
            numpy.testing.assert_allclose(felt.tool[:3], [0, TOUCH, 0], atol=2e-5)
            self.assertTrue(eventually(lambda: numpy.allclose(hand.felt.force, [0, 2, 0], atol=0.02)), hand.felt)
            depths = (0.002, 0.0015, 0.001, 0.0005, 0)
            self.assertTrue(eventually(lambda: numpy.allclose(
                [felt.wanted_force[1] for felt in hand.follow([[0, TOUCH - depth, 0] for depth in depths])],
                [2, 1.5, 1, 0.5, 0], atol=0.02)))
            self.assertEqual(hand.phase, "active")
        self.assertEqual(hand.phase, "closed")
        with self.assertRaisesRegex(palpate.Error, "closed"):
            hand.move([0, 0.04, 0])

    def test_is_refused_in_a_forked_child_which_ends_all_the_same(self):
        child = script("""
import os, sys
from palpate import Error, live
make = lambda name: live.Station("cube", name, domain=int(sys.argv[1]), transport="udp")
hand = make("parent")
child = os.fork()
if child:
    hand.move([0, 0.04, 0])
    sys.exit(os.waitpid(child, 0)[1] != 0)
for use in (lambda: make("child"), lambda: live.Session(int(sys.argv[1])), lambda: hand.move([0, 0.04, 0]),
            lambda: hand.felt, lambda: hand.phase, lambda: hand.set_effect(None)):
    try:
        use()
    except Error as error:
        assert "spawn" in str(error), error
    else:
        raise AssertionError("was allowed")
hand.close()
""")
        self.assertEqual(child.communicate(timeout=60)[1], "")
        self.assertEqual(child.returncode, 0)

    def test_with_an_effect_that_refers_to_it_is_collected(self):
        hand = opened("circle")
        hand.set_effect(lambda *_, hand=hand: [0, 0, 0])
        hand.move([0, 0.04, 0])
        gone = weakref.ref(hand)
        del hand
        self.assertTrue(eventually(lambda: gc.collect() >= 0 and gone() is None))

    def test_is_under_the_limiter_like_any(self):
        with opened(max_force=3) as hand:
            felt = pressed(hand, 0.005, 5)
            self.assertAlmostEqual(felt.wanted_force[1], 5, delta=0.02)
            until = time.monotonic() + 5  # a busy host fades it for a while
            while abs(felt.force[1] - 3) > 0.02 and time.monotonic() < until:
                self.assertLessEqual(numpy.linalg.norm(felt.force), 3 + 1e-9)
                time.sleep(0.01)
                felt = hand.felt
            self.assertAlmostEqual(felt.force[1], 3, delta=0.02)

    def test_lets_other_threads_run_while_it_waits(self):
        counted = 0
        done = threading.Event()

        def count():
            nonlocal counted
            while not done.is_set():
                counted += 1
                time.sleep(0.001)

        other = threading.Thread(target=count)
        with opened() as hand:
            hand.move([0, 0.04, 0], 0.1)
            other.start()
            hand.move([0, 0.045, 0], 0.5)
            done.set()
        other.join()
        self.assertGreater(counted, 50)

    def test_is_led_by_a_force_in_python_until_that_fails(self):
        with opened() as hand:
            hand.move([0, 0.04, 0], 0.1)
            hand.set_effect(lambda hand, twist, tool: 20 * ([0, 0.04, 0.01] - hand[:3]), rate_hz=50)
            self.assertTrue(eventually(lambda: abs(hand.felt.force[2] - 0.2) < 1e-6), hand.felt)
            hand.set_effect(lambda hand, twist, tool: [0, 0, 5, *tool[3:6]], max_force=3)
            self.assertTrue(eventually(lambda: hand.felt.wanted_force[2] == 3 and abs(hand.felt.force[2] - 1) < 1e-6))

            def fails(hand, twist, tool):
                if twist[1] > 0.01:
                    raise RuntimeError("enough")
                return [0, 0, 0.5]

            hand.set_effect(fails)
            with self.assertRaisesRegex(palpate.Error, "the effect is off: RuntimeError: enough"):
                hand.move([0, 0.06, 0], 0.5)
                self.fail("went all the way")
            self.assertTrue(eventually(lambda: not hand.felt.wanted_force.any() and not hand.felt.force.any()))
            with self.assertRaisesRegex(palpate.Error, "its wrench: must be"):
                hand.set_effect(lambda *_: [1, 2])
            hand.move([0, 0.04, 0], 0.1)

    def test_tells_what_is_wrong_in_the_stations_words(self):
        for words, wrong in {
            "give 1 to 32 letters": lambda: opened("no name!"),
            "scene 'nowhere' is not served here; choose one of: cube":
                lambda: live.Station("nowhere", domain=DOMAIN, transport="udp"),
            "the server refuses the session": lambda: opened(tool="spoon"),
            "pose: must be": lambda: opened(start=[1, 2]),
            "start: must be finite": lambda: opened(start=[0, float("nan"), 0]),
            "'pigeon'": lambda: live.Station("cube", domain=DOMAIN, transport="pigeon"),
            "domain": lambda: live.Station("cube", domain=-1),
        }.items():
            with self.subTest(words), self.assertRaisesRegex(palpate.Error, words.replace("pose: must", "start: must")):
                wrong()
        with opened() as hand:
            for pose in ([1, 2], [0, float("nan"), 0], [0, 0, 0, 2, 0, 0, 0], [0, 40, 0]):
                with self.subTest(str(pose)), self.assertRaisesRegex(palpate.Error, "pose: "):
                    hand.move(pose)

    def test_ends_at_ctrl_c(self):
        waits = script("""
import sys
from palpate import live
hand = live.Station("cube", "interrupted", domain=int(sys.argv[1]), transport="udp")
hand.move([0, 0.04, 0], 0.1)
print("moves", flush=True)
hand.move([0, 0.045, 0], 60)
""")
        self.assertEqual(waits.stdout.readline(), "moves\n")
        time.sleep(0.1)
        waits.send_signal(signal.SIGINT)
        _, errors = waits.communicate(timeout=20)
        self.assertIn("KeyboardInterrupt", errors)
        self.assertTrue(self.server.says("station interrupted: ended: the station left", 10), self.server.text[-2000:])

    def test_presses_in_an_example(self):
        example = pathlib.Path(os.environ["PALPATE_SOURCE_DIR"], "client/python/examples/press_live.py")
        # Where a busy machine makes wrenches late, the limiter lets the force fade, as it must.
        for _ in range(8):
            done = subprocess.run([sys.executable, example, "cube", "--domain", str(DOMAIN), "--transport", "udp"],
                                  capture_output=True, text=True, timeout=60, check=False)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(len(done.stdout.splitlines()), 11)
            if re.search(r" 1\.0 mm   (0\.9[89]|1\.0[012])\d N", done.stdout):
                return
        self.fail(done.stdout)


class Session(Served):
    def test_hears_the_tools_and_every_wrench_of_a_station(self):
        with station(DOMAIN, "hand", "--loop"), live.Session(DOMAIN, transport="udp", wrenches=True) as session:
            states, pressing = [], 0
            for state in session:
                states.append(state)
                pressing += numpy.linalg.norm(state["force_N"]) > 0.2  # later where a busy host holds it back
                if len(states) >= 120 and pressing > 10 or len(states) == 2000:
                    break
            states = numpy.array(states)
            self.assertEqual(set(states["station"]), {b"hand"})
            self.assertEqual(set(states["scene"]), {b"cube"})
            self.assertGreater(numpy.diff(states["time_s"]).min(), -1e-9)
            self.assertEqual(session.stations, {"hand": "active"})
            wrenches = session.wrenches("hand")
            self.assertGreater(len(wrenches), 1000)
            steps = numpy.diff(wrenches["answer"].astype(int))  # from 1 where a busy host's hand came again
            self.assertEqual(set(steps[steps > 0]), {1})
            # The state says what the loop has sent.
            felt = {wrench["pose_sequence"]: wrench for wrench in wrenches}
            both = [(state, felt[state["pose_sequence"]]) for state in states if state["pose_sequence"] in felt]
            self.assertGreater(len(both), 60)
            for state, wrench in both:
                numpy.testing.assert_array_equal(state["force_N"], wrench["force_N"])
                numpy.testing.assert_array_equal(state["tool"], wrench["tool"])
            self.assertEqual(session.latest_tool("hand").dtype, live.tool_dtype)
            self.assertGreater(session.latest_wrench("hand")["pose_sequence"], wrenches["pose_sequence"][0])
            self.assertIsNone(session.latest_tool("nobody"))
            pressed = states[numpy.linalg.norm(states["force_N"], axis=1) > 0.2]
            self.assertGreater(len(pressed), 10)
            for state in pressed:
                numpy.testing.assert_allclose(state["point"][: state["points"], 3:].sum(axis=0), state["force_N"],
                                              atol=0.05)
            self.assertEqual(session.dropped, 0)

    def test_tells_that_nobody_plays_or_that_there_is_no_server(self):
        with live.Session(DOMAIN, patience=0.5) as session:
            self.assertTrue(eventually(lambda: "active" not in session.stations.values()))
            self.assertTrue(eventually(lambda: self._words(session).startswith("no tool's state came: no station")))
        with live.Session(own_domain(), patience=0.5) as session:
            self.assertIn("no server answers in domain", self._words(session))

    def _words(self, session):
        try:
            session.tools()
        except live.Silence as silence:
            return str(silence)
        return ""

    def test_follows_in_an_example(self):
        example = pathlib.Path(os.environ["PALPATE_SOURCE_DIR"], "client/python/examples/follow_live.py")
        with station(DOMAIN, "hand", "--loop"), tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "wrenches.npy")
            done = subprocess.run([sys.executable, example, "--domain", str(DOMAIN), "--transport", "udp", "--for", "3",
                                   "-o", file], capture_output=True, text=True, timeout=60, check=False)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertRegex(done.stdout, r"hand: 1\d\d states, strongest \d\.\d\d N, \d{3,4} answers a second")
            self.assertEqual(numpy.load(file).dtype, live.wrench_dtype)


class DeadServer(unittest.TestCase):
    def test_ends_in_no_force_and_silence_and_its_successor_is_felt(self):
        dying = server(DOMAIN)
        self.addCleanup(dying.kill)
        with opened() as hand, live.Session(DOMAIN, patience=5) as session:
            hand.move([0, TOUCH - 0.002, 0], 0.3)
            self.assertTrue(eventually(lambda: abs(hand.felt.force[1] - 2) < 0.02))
            session.tools()
            dying.kill()
            self.assertTrue(eventually(lambda: not hand.felt.force.any() and not hand.felt.torque.any(), 5))
            with self.assertRaisesRegex(live.Silence, "no replies for 1 s: forces are zero until they come again"):
                hand.move([0, TOUCH - 0.001, 0], 0.1)
            numpy.testing.assert_array_equal(hand.felt.force, [0, 0, 0])
            self.assertTrue(eventually(lambda: hand.phase in ("no replies", "asking again"), 10), hand.phase)
            with self.assertRaisesRegex(live.Silence, "the server has"):
                for _ in session:
                    pass
            with server(DOMAIN):
                self.assertTrue(eventually(lambda: hand.phase in ("active", "waiting", "tool starts inside"), 30))
                self.assertTrue(eventually(lambda: self._moves_to(hand, TOUCH + 0.005)))
                time.sleep(0.5)
                self.assertTrue(eventually(lambda: self._moves_to(hand, TOUCH - 0.001)))
                self.assertAlmostEqual(hand.felt.wanted_force[1], 1, delta=0.02)
                self.assertGreater(len(session.tools(timeout=20)), 0)

    def _moves_to(self, hand, y):
        try:
            hand.move([0, y, 0], 0.2)
            return True
        except live.Silence:
            return False


class Secured(unittest.TestCase):
    """In processes of their own: a process has one identity."""

    def test_station_and_session_have_their_roles_and_no_others(self):
        identities = pathlib.Path(os.environ["PALPATE_SOURCE_DIR"], "deploy/security/identities")
        domain = own_domain()
        with tempfile.TemporaryDirectory() as folder:
            lab = pathlib.Path(folder, "lab")
            subprocess.run([identities, "new", lab], check=True, capture_output=True)
            for role, name in (("server", "desk"), ("station", "script"), ("viewer", "class")):
                subprocess.run([identities, "add", lab, role, name], check=True, capture_output=True)
            who = {name: str(lab / "identities" / name) for name in ("desk", "script", "class")}
            with server(domain, "--identity", who["desk"]):
                hand = script("""
import sys
from palpate import live
with live.Station("cube", sys.argv[3], domain=int(sys.argv[2]), identity=sys.argv[4]) as hand:
    for _ in range(20):  # a busy host's answers may be late
        force = hand.move([0, 0.029, 0], 0.3).wanted_force[1].round(1)
        if force == 1:
            break
    print(force, flush=True)
    sys.stdin.readline()
""", str(domain), "script", who["script"])
                self.assertEqual(hand.stdout.readline(), "1.0\n", hand.poll() and hand.stderr.read())
                look = script("""
import sys
from palpate import live
print(live.Session(int(sys.argv[2]), identity=sys.argv[3]).tools(timeout=20)["station"][0].decode())
""", str(domain), who["class"])
                self.assertEqual(look.communicate(timeout=60)[0], "script\n")
                hand.communicate("\n", timeout=20)  # and leaves the tool
                for name, identity in (("other", who["script"]), ("class", who["class"])):
                    wrong = script("""
import sys
from palpate import live
live.Station("cube", sys.argv[3], domain=int(sys.argv[2]), identity=sys.argv[4])
""", str(domain), name, identity)
                    self.assertIn("palpate._physics.Error", (words := wrong.communicate(timeout=60)[1]))
                    self.assertIn("the role of this --identity", words)


class MadeByKeyword(unittest.TestCase):
    def test_scenes_are_served_as_they_were_saved(self):
        ball = palpate.tool("ball", {"shape": "sphere", "radius_m": 0.005}, leaves=1, start=[0, 0.1, 0])
        block = palpate.object("block", palpate.box([0.05, 0.05, 0.05]), pose=palpate.pose([0.1, 0, 0]))
        domain = own_domain()
        with tempfile.TemporaryDirectory() as folder:
            palpate.scene("mine", tools=[ball], objects=[block]).save(os.path.join(folder, "x.json"))
            with server(domain, scene=os.path.join(folder, "x.json")), \
                    live.Station("mine", "script", domain=domain, transport="udp") as hand:
                hand.move(palpate.pose([0.1, TOUCH + 0.005, 0], rotvec=[0, 0.3, 0]), 0.5)
                felt = hand.move(palpate.pose([0.1, TOUCH - 0.002, 0], rotvec=[0, 0.3, 0]), 0.3)
                numpy.testing.assert_allclose(felt.wanted_force, [0, 2, 0], atol=0.02)


class Stubs(unittest.TestCase):
    def test_say_what_there_is_with_the_same_parameters_and_defaults(self):
        stubs = pathlib.Path(live.__file__).with_suffix(".pyi").read_text()
        compared = 0
        for kind in [node for node in ast.parse(stubs).body if isinstance(node, ast.ClassDef)]:
            there = getattr(live, kind.name)
            stubbed = {node.name: node for node in kind.body if isinstance(node, ast.FunctionDef)}
            public = {name for name in vars(there) if not name.startswith("_")}
            inherited = {name for base in there.__mro__[1:-1] for name in vars(base) if not name.startswith("_")}
            if not issubclass(there, Exception):
                self.assertLessEqual(public, set(stubbed), kind.name)
                self.assertLessEqual({name for name in stubbed if not name.startswith("_")}, public | inherited)
            if kind.name not in ("Station", "Session"):
                continue  # those of the extension module have no signature
            for name, node in stubbed.items():
                real = getattr(there, name)
                if not callable(real):
                    continue
                signature = [(p.name, p.kind.name, None if p.default is p.empty else p.default)
                             for p in inspect.signature(real).parameters.values()]
                if name.startswith("__") and name != "__init__":
                    continue
                arguments = node.args
                fixed = [argument.arg for argument in arguments.args]
                defaults = [None] * (len(fixed) - len(arguments.defaults)) + [*map(ast.literal_eval, arguments.defaults)]
                said = [(argument, "POSITIONAL_OR_KEYWORD", default) for argument, default in zip(fixed, defaults)]
                said += [(argument.arg, "KEYWORD_ONLY", ast.literal_eval(default)) for argument, default in
                         zip(arguments.kwonlyargs, arguments.kw_defaults)]
                self.assertEqual(said, signature, f"{kind.name}.{name}")
                compared += len(said)
        self.assertGreater(compared, 25)


class Package(unittest.TestCase):
    def test_alone_needs_no_dds(self):
        loaded = subprocess.run(
            [sys.executable, "-c", "import palpate, sys; print(open('/proc/self/maps').read());"
             "print('palpate.live' in sys.modules)"], capture_output=True, text=True, check=True).stdout
        self.assertNotIn("libdds", loaded)
        self.assertTrue(loaded.endswith("False\n"))


if __name__ == "__main__":
    unittest.main()
