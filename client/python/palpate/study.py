"""Runs all combinations of scenes, hands, parameters and seeds, and writes a table.

    python3 -m palpate.study friction.toml -o friction
"""

import argparse
import concurrent.futures
import csv
import datetime
import functools
import hashlib
import importlib.util
import itertools
import json
import os
import pathlib
import platform
import sys
import threading
import time
import tomllib
import types
from typing import Any, Callable, Dict, List, Optional, Sequence, Union

import numpy

import palpate
from palpate import Error, Steps, hands
from palpate._physics import _usable_cores

_EPILOG = """\
example: python3 -m palpate.study friction.toml -o friction

a study file:
  title = "Does friction change how hard a hand presses?"
  # Names in the catalogue, or files beside this one:
  scenes = ["bunny-bunny", "mine.json"]
  seeds = "1..10"                # or a list of numbers
  steps = 20000                  # of each run, one per millisecond

  [hands.explorer]               # choose a name for each hand
  # Approaches, presses, slides and leaves; options: help("palpate.hands")
  kind = "generated"
  press_mm = 3

  [hands.scripted]
  kind = "script"                # the path supplied with the scene
  # For any kind; a script or file uses the seed only for this:
  tremor_um = 20

  [hands.recorded]
  # CSV or .npy; rows x,y,z or x,y,z,qw,qx,qy,qz in m, one per millisecond:
  kind = "file"
  file = "hand.csv"

  [hands.circling]
  # The function circle(scene, random, steps) returns such rows:
  kind = "python"
  function = "my_hands.py:circle"

  [parameters]                   # names, units, ranges: palpate.parameters()
  # A list is a factor; a number applies to all runs:
  stiffness_N_per_m = [500, 1000, 2000]
  friction = [0.0, 0.3]

optional: hands (default: the script), seeds, steps, and
  contacts = ["surface", "spheres"]
  # Of sphere trees, in place of the scenes' leaves:
  tolerances_um = [20, 50, 100]
  tools = ["bunny"]
  # measure(path, steps) returns further columns as a dict; steps is what
  # Proxy.steps returns:
  measures = "mine.py:measure"

files in FOLDER:
  table.csv    one row per run: its factors and results
  METHODS.md   versions, hashes of scenes, parameters with units, the machine,
               the meaning of each column
  runs/        with --keep: for each run an .npz with hand, wrench, pose,
               contacts, faults

Ctrl-C keeps the finished runs; the same command continues with the others.  A
row depends only on the scene, the hand, the parameters, the seed and the
versions; it has the same bits with any number of jobs.
"""

_FACTORS = {
    "run": "number of the run, in the order of the factors",
    "scene": "scene",
    "contact": "contact model; empty: the scene's",
    "tolerance_um": "tolerance of the sphere trees; empty: the scene's leaves",
    "tool": "tool, by name or number",
    "hand": "hand",
    "seed": "seed of the hand; empty: it uses none",
}
_COLUMNS = {  # description, and how to compute it from a run's steps
    "steps": ("number of steps, one per millisecond", lambda run: len(run.force)),
    "touching": ("fraction of the steps with a contact", lambda run: run.touching.mean()),
    "force_mean_N": ("mean magnitude of the force, over the steps with a contact",
                     lambda run: run.strength[run.touching].mean() if run.touching.any() else 0.0),
    "force_rms_N": ("root mean square of the force, over all steps", lambda run: numpy.sqrt((run.strength**2).mean())),
    "force_p99_N": ("99th percentile of its magnitude, over all steps", lambda run: numpy.percentile(run.strength, 99)),
    "force_max_N": ("largest magnitude of the force", lambda run: run.strength.max()),
    "torque_max_Nm": ("largest magnitude of the torque about the tool's centroid",
                      lambda run: _lengths(run.wrench[:, 3:]).max()),
    "jump_max_N": ("largest change of the force from one step to the next",
                   lambda run: _lengths(numpy.diff(run.force, axis=0)).max()),
    "slid_mm": ("path length of the origin of the tool's frame in contact",
                lambda run: 1e3 * run.way[run.touching[1:] & run.touching[:-1]].sum()),
    "fault_steps": ("number of steps with a fault", lambda run: (run.faults != 0).sum()),
    "faults": ("the faults, in words", lambda run: palpate.fault_words(int(numpy.bitwise_or.reduce(run.faults)))),
    "bits": ("first half of the SHA-256 of all wrenches and poses: equal if all bits are",
             lambda run: hashlib.sha256(run.wrench.tobytes() + run.pose.tobytes()).hexdigest()[:32]),
}
_HAND_OPTIONS = {
    "generated": {"press_mm", "slide_mm", "speed_mm_per_s", "turn_deg"},
    "script": set(),
    "file": {"file"},
    "python": {"function"},
}


def _lengths(vectors):
    return numpy.linalg.norm(vectors, axis=1)


def figures(steps: Union[Steps, types.SimpleNamespace]) -> Dict[str, Union[int, float, str]]:
    """Computes the _COLUMNS of a run."""
    run = types.SimpleNamespace(
        wrench=steps.wrench, pose=steps.pose, faults=steps.faults, force=steps.wrench[:, :3],
        strength=_lengths(steps.wrench[:, :3]), touching=steps.contacts > 0,
        way=_lengths(numpy.diff(steps.pose[:, :3], axis=0)))
    found = {name: formula(run) for name, (_, formula) in _COLUMNS.items()}
    return {name: value.item() if isinstance(value, numpy.generic) else value for name, value in found.items()}


def _sha256(file):
    return hashlib.sha256(pathlib.Path(file).read_bytes()).hexdigest()


class Study:
    """A study file, checked.  Errors name the field that is wrong."""

    file: pathlib.Path
    folder: pathlib.Path
    said: Dict[str, Any]
    title: str
    scenes: List[str]
    contacts: List[str]
    tolerances_um: List[float]
    tools: List[Union[str, int]]
    steps: int
    seeds: List[int]
    sources: Dict[str, str]
    measure: Optional[Callable[..., Dict[str, Any]]]
    hands: Dict[str, Any]
    parameters: Dict[str, List[float]]

    def __init__(self, file: Union[str, "os.PathLike[str]"]) -> None:
        self.file, self.folder = pathlib.Path(file), pathlib.Path(file).parent
        try:
            text = self.file.read_bytes()
        except OSError as error:
            raise Error(f"{file}: cannot be read ({error.strerror}); --help shows a study file") from None
        if text[:2] in (b"\xff\xfe", b"\xfe\xff") or b"\0" in text[:2]:
            raise Error(f"{file}: its text is UTF-16; save it as UTF-8")
        try:
            self.said = tomllib.loads(text.decode("utf-8-sig"))  # perhaps with a byte order mark
        except ValueError as error:
            raise Error(f"{file}: {error}") from None
        self._known("", self.said, {"title", "scenes", "contacts", "tolerances_um", "tools", "seeds", "steps", "hands",
                                    "parameters", "measures"})
        self.title = self._take("title", self.file.stem, lambda x: isinstance(x, str), "a text")
        self.scenes = self._list("scenes", None, str)
        self.contacts = self._list("contacts", [""], str)
        self.tolerances_um = self._list("tolerances_um", [0], (int, float))
        self.tools = self._list("tools", [0], (str, int))
        self.steps = self._take("steps", 20000, lambda x: type(x) is int and x > 1, "a whole number above 1")
        self.seeds = self._seeds()
        self.sources = {}  # hashes of the files that the study names
        # Runs of one model are consecutive.
        self.model = functools.lru_cache(2 + _usable_cores())(
            lambda scene, tool, parameters: scene.model(tool, **dict(parameters)))
        self.measure = self._function("measures", self.said["measures"]) if "measures" in self.said else None
        self.hands = self._take("hands", {"script": {"kind": "script"}}, lambda x: isinstance(x, dict) and x, "tables")
        self.makers = {name: self._hand(f"hands.{name}", hand) for name, hand in self.hands.items()}
        self.parameters = self._parameters()

    def _wrong(self, field, words):
        raise Error(f"{self.file}: {field}: {words}")

    def _known(self, at, table, names):
        for name in set(table) - names:
            self._wrong(at + name, f"is not known; give one of {', '.join(sorted(names))}")

    def _take(self, field, default, right, words):
        value = self.said.get(field, default)
        if not right(value):
            self._wrong(field, f"is {'missing' if value is None else repr(value)}; give {words}")
        return value

    def _list(self, field, default, kind):
        return self._take(field, default, lambda x: isinstance(x, list) and x and len(set(map(str, x))) == len(x)
                          and all(isinstance(each, kind) for each in x), "a list without duplicates, as --help shows")

    def _seeds(self):
        first, dots, last = str(self.said.get("seeds", "1..1")).partition("..")
        if dots and first.isdecimal() and last.isdecimal() and int(first) <= int(last):
            return list(range(int(first), int(last) + 1))
        if isinstance(self.said["seeds"], str) or min(self._list("seeds", None, int)) < 0:
            self._wrong("seeds", f'is {self.said["seeds"]!r}; give a range, "1..10", or a list of numbers from 0')
        return self.said["seeds"]

    def _function(self, field, text):
        file, _, name = str(text).rpartition(":")
        path = self.folder / file
        if not path.is_file():
            self._wrong(field, f'is {text!r}; give "FILE.py:FUNCTION", of a file beside the study\'s')
        self.sources[field] = _sha256(path)
        spec = importlib.util.spec_from_file_location(path.stem, path)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        if not callable(getattr(module, name, None)):
            self._wrong(field, f"is {text!r}; but {path} has no function {name}")
        return getattr(module, name)

    def _rows(self, field, file):
        try:
            rows = numpy.load(file) if file.suffix == ".npy" else numpy.loadtxt(file, delimiter=",", ndmin=2)
        except (OSError, ValueError) as error:
            self._wrong(field, f"{error}; give .npy, or CSV without a title, rows x,y,z or x,y,z,qw,qx,qy,qz")
        if rows.ndim != 2 or len(rows) < self.steps:
            self._wrong(field, f"has the shape {rows.shape}; give {self.steps} rows, or fewer steps")
        self.sources[field] = _sha256(file)
        return rows[: self.steps]

    def _hand(self, at, hand):
        """Returns a function that makes poses from scene, tool and seed."""
        kind = hand.get("kind") if isinstance(hand, dict) else hand
        if kind not in _HAND_OPTIONS:
            self._wrong(f"{at}.kind", f"is {kind!r}; give one of {', '.join(_HAND_OPTIONS)}")
        self._known(at + ".", hand, _HAND_OPTIONS[kind] | {"kind", "tremor_um"})
        options = {name: value for name, value in hand.items() if name not in ("kind", "tremor_um")}
        for name in _HAND_OPTIONS[kind] & {"file", "function"} - set(hand):
            self._wrong(at, f"{name} is missing; --help shows an example")
        for name, value in hand.items():
            if name not in ("kind", "file", "function") and not (type(value) in (int, float) and 0 < value < 1e6):
                self._wrong(f"{at}.{name}", f"is {value!r}; give a number above 0")
        if kind == "generated":
            make = lambda scene, tool, seed: hands.generated(
                scene, tool=tool, seed=seed, steps=self.steps, model=self.model(scene, tool, ()), **options)
        elif kind == "script":
            make = lambda scene, tool, seed: hands.script(scene, steps=self.steps)
        elif kind == "file":
            rows = self._rows(f"{at}.file", self.folder / hand["file"])
            make = lambda scene, tool, seed: rows
        else:
            function = self._function(f"{at}.function", hand["function"])
            make = lambda scene, tool, seed: function(scene, numpy.random.default_rng(seed), self.steps)
        um = hand.get("tremor_um", 0)
        # Keeps hands for runs with other parameters: a megabyte each.
        return functools.lru_cache(64)(
            lambda scene, tool, seed: hands.trembling(make(scene, tool, seed), um=um, seed=seed) if um
            else numpy.asarray(make(scene, tool, seed)))

    def _parameters(self):
        table = {row["name"]: row for row in palpate.parameters()}
        said = self._take("parameters", {}, lambda x: isinstance(x, dict), "a table")
        self._known("parameters.", said, set(table))
        values = {name: value if isinstance(value, list) else [value] for name, value in said.items()}
        for name, factor in values.items():
            least, most = table[name]["least"], table[name]["most"]
            if not factor or not all(type(x) in (int, float) and least <= x <= most for x in factor):
                self._wrong(f"parameters.{name}", f"is {said[name]!r}; give numbers from {least:g} to {most:g} "
                            f"{table[name]['unit']}".rstrip())
        return values

    def runs(self) -> List[types.SimpleNamespace]:
        """Returns all runs in the order of the table; loads the scenes."""
        runs, scenes = [], []
        for name, contact, um in itertools.product(self.scenes, self.contacts, self.tolerances_um):
            beside = self.folder / name
            scene = palpate.load(beside if beside.is_file() else name, contact=contact or None, tolerance_um=um or None)
            scenes.append((scene, contact, um or ""))
        values = [tuple(zip(self.parameters, each)) for each in itertools.product(*self.parameters.values())]
        every = itertools.product(scenes, self.tools, values, self.hands.items())
        for (scene, contact, um), tool, parameters, (name, hand) in every:
            for seed in self.seeds if hand["kind"] in ("generated", "python") or "tremor_um" in hand else [""]:
                chosen = [len(runs) + 1, scene.name, contact, um, tool, name, seed]
                factors = dict(zip(_FACTORS, chosen)) | dict(parameters)
                depends = [palpate.physics_revision, numpy.__version__, scene.hash, self.steps, self.sources, hand,
                           {**factors, "run": 0}]
                key = hashlib.sha256(json.dumps(depends).encode()).hexdigest()[:16]
                runs.append(types.SimpleNamespace(scene=scene, parameters=parameters, factors=factors, key=key))
        return runs


class _Table:
    """table.csv with the rows of this and earlier calls; written at most once per second, and at the end."""

    def __init__(self, study, folder, keep):
        self.study, self.folder, self.keep = study, folder, keep
        self.file, self.rows, self._written = folder / "table.csv", {}, 0.0

    def resume(self, runs):
        """Takes over the finished ones of these runs, and returns the others."""
        there = {}
        if self.file.is_file():
            with self.file.open(newline="") as text:
                there = {row.get("key"): row for row in csv.DictReader(text)}
        for run in runs:
            if run.key in there and not (self.keep and not self._arrays(run).is_file()):
                self.rows[run.factors["run"]] = {**there[run.key], **run.factors}
        return [run for run in runs if run.factors["run"] not in self.rows]

    def _arrays(self, run):
        return self.folder / "runs" / f"{run.key}.npz"

    def make(self, run, stopped):
        """Computes a run, in parts, between which it checks for Ctrl-C."""
        f = run.factors
        path = self.study.makers[f["hand"]](run.scene, f["tool"], f["seed"] or 0)
        proxy, parts = palpate.Proxy(self.study.model(run.scene, f["tool"], run.parameters), path[0]), []
        for begin in range(0, len(path), 1000):
            if stopped.is_set():
                return
            parts.append(proxy.steps(path[begin : begin + 1000]))
        names = ("wrench", "pose", "contacts", "faults")
        steps = types.SimpleNamespace(**{n: numpy.concatenate([getattr(part, n) for part in parts]) for n in names})
        own = self.study.measure(path, steps) if self.study.measure else {}
        if self.keep:
            self._arrays(run).parent.mkdir(exist_ok=True)
            numpy.savez_compressed(self._arrays(run), hand=path, **vars(steps))
        self.rows[f["run"]] = {**f, **figures(steps), **own, "key": run.key}

    def write(self, at_once=True):
        if not self.rows or not (at_once or time.monotonic() - self._written > 1):
            return
        rows = [row for _, row in sorted(self.rows.items())]
        columns = dict.fromkeys(name for row in rows for name in row if name != "key") | {"key": None}
        with self.file.with_suffix(".new").open("w", newline="") as text:
            writer = csv.DictWriter(text, columns, lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)
        os.replace(text.name, self.file)
        self._written = time.monotonic()


def _markdown(*lines):
    lines = [lines[0], ["---"] * len(lines[0]), *lines[1:]]
    return "".join("| " + " | ".join(str(cell).replace("|", "\\|") for cell in line) + " |\n" for line in lines)


def _methods(study, runs, table):
    """Returns the text for a paper's methods section."""
    scenes = {id(run.scene): (run.scene, run.factors["contact"]) for run in runs}.values()
    cpu = [line for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines() if line.startswith("model name")]
    values = {name: ", ".join(f"{value:g}" for value in factor) for name, factor in study.parameters.items()}
    for row in palpate.parameters():
        used = dict.fromkeys(f"{scene.parameters[row['name']]:g}" for scene, _ in scenes)
        values.setdefault(row["name"], ", ".join(used).replace("nan", "differs by object") + " (the scenes')")
    own = set().union(*table.rows.values()) - set(_FACTORS) - set(_COLUMNS) - set(study.parameters) - {"key"}
    columns = [*_FACTORS.items(), *((name, "parameter, as above") for name in study.parameters),
               *((name, what) for name, (what, _) in _COLUMNS.items()),
               *((name, f"by {study.said['measures']}") for name in sorted(own)),
               ("key", "hash of everything that the row depends on")]
    hand_rows = ([name, ", ".join(f"{k} {v}" for k, v in hand.items())] for name, hand in study.hands.items())
    parameter_rows = ([row["name"], values[row["name"]], row["unit"] or "1", f"{row['default']:g}", row["what"]]
                      for row in palpate.parameters())
    return f"""# {study.title}

{len(table.rows)} of {len(runs)} runs of {study.steps} steps, by `palpate.study` of Palpate {palpate.__version__}, physics {palpate.physics_revision}, \
from `{study.file.name}` (SHA-256 {_sha256(study.file)}), {datetime.datetime.now(datetime.timezone.utc):%Y-%m-%d}.

In each run, one hand follows one path in one scene. A step of 1 ms takes the pose of the hand and returns force, \
torque and the pose of the tool. Each run starts afresh; no arm and no person takes part. A step is a pure function \
of scene, parameters and poses: with these versions, a run gives the same bits again.

## Scenes

{_markdown(["scene", "contact", "hash", "triangles", "leaves", "tools"], *(
    [scene.name, contact or "the scene's", scene.hash, sum(len(body.triangles) for body in scene.objects),
     sum(body.leaves for body in scene.objects), ", ".join(body.name for body in scene.tools)]
    for scene, contact in scenes))}
Recordings name a scene by the same hash.

## Hands

{_markdown(["hand", "options"], *hand_rows)}
Seeds: {study.said.get("seeds", 1)}. Other options are the defaults of `palpate.hands`. Files: \
{", ".join(f"{field} (SHA-256 {hash})" for field, hash in study.sources.items()) or "none"}.

## Parameters

{_markdown(["parameter", "values", "unit", "default", "what"], *parameter_rows)}
## Machine

{cpu[0].partition(": ")[2] if cpu else platform.processor()}, {_usable_cores()} cores, \
{platform.platform()}, Python {platform.python_version()}, numpy {numpy.__version__}.

## Columns of table.csv

{_markdown(["column", "what"], *columns)}"""


def _make_all(missing, table, jobs):
    """Computes the runs in parallel.  Returns False after Ctrl-C."""
    stopped, begun = threading.Event(), time.monotonic()
    pool = concurrent.futures.ThreadPoolExecutor(jobs)
    running = {pool.submit(table.make, run, stopped): run for run in missing}
    try:
        for done, made in enumerate(concurrent.futures.as_completed(running), 1):
            try:
                made.result()
            except Error as error:
                raise Error(f"run {running[made].factors}: {error}") from None
            table.write(at_once=False)
            if sys.stderr.isatty() or done == len(missing):
                gone = time.monotonic() - begun
                to_go = gone / done * (len(missing) - done)
                print(f"\r{done} of {len(missing)} runs in {gone:.0f} s, {to_go:.0f} s to go ", end="", file=sys.stderr,
                      flush=True)
        return True
    except KeyboardInterrupt:
        return False
    finally:
        stopped.set()
        pool.shutdown(cancel_futures=True)
        table.write()
        print(file=sys.stderr)


def main(arguments: Optional[Sequence[str]] = None) -> int:
    parser = argparse.ArgumentParser(prog="python3 -m palpate.study", description=__doc__.partition("\n")[0],
                                     epilog=_EPILOG, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("study", metavar="STUDY.toml", help="study file: see below")
    parser.add_argument("-o", metavar="FOLDER", help="folder for table.csv and METHODS.md; default: STUDY")
    parser.add_argument("--jobs", type=int, default=_usable_cores(),
                        help="number of parallel runs; default: all cores")
    parser.add_argument("--keep", action="store_true", help="also keep the arrays of each run")
    parser.add_argument("--list", action="store_true", help="list the runs, and compute none")
    parser.add_argument("--version", action="version", version=f"palpate.study {palpate.__version__}")
    options = parser.parse_args(arguments)
    if options.jobs < 1:
        parser.error("--jobs: give at least 1")
    study = Study(options.study)
    runs = study.runs()
    if options.list:
        for run in runs:
            print(", ".join(f"{name} {value}" for name, value in run.factors.items() if value != ""))
        return 0
    folder = pathlib.Path(options.o or study.file.with_suffix(""))
    folder.mkdir(parents=True, exist_ok=True)
    table = _Table(study, folder, options.keep)
    missing = table.resume(runs)
    print(f"{len(runs)} runs, {len(runs) - len(missing)} of them already done", file=sys.stderr)
    whole = _make_all(missing, table, options.jobs)
    if table.rows:
        (folder / "METHODS.md").write_text(_methods(study, runs, table))
    print(f"{folder}: table.csv of {len(table.rows)} of {len(runs)} runs, and METHODS.md"
          + ("" if whole else "; the same command continues"), file=sys.stderr)
    return 0 if whole else 1


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (Error, OSError) as wrong:
        sys.exit(f"palpate.study: {wrong}")
    except KeyboardInterrupt:
        sys.exit(1)
