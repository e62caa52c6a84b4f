"""Reads meshes, reads and makes recordings, with the programs palpate-import and palpate-replay."""

import os
import pathlib
import shutil
import struct
import subprocess
import tempfile

import numpy

from palpate._physics import Error, _offer_programs

METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001, "inch": 0.0254}
_MESH_MAGIC = b"palpmsh1"  # scenes/mesh/mesh_packet.cpp
_OWN = pathlib.Path(__file__).with_name("programs") / "bin"  # in a wheel

if _OWN.exists():
    _offer_programs(str(_OWN))


def _program(name):
    """Returns the path of a program: in $PALPATE_PROGRAMS if set, else beside this module or on the PATH."""
    folder = os.environ.get("PALPATE_PROGRAMS")
    found = shutil.which(name, path=folder or f"{_OWN}{os.pathsep}{os.environ.get('PATH', os.defpath)}")
    if not found:
        raise Error(
            f"{name}: is not {'in ' + folder if folder else 'on the PATH'}; install palpate-common and "
            "palpate-tools, or set the environment variable PALPATE_PROGRAMS to the folder that has it"
        )
    return found


def _complaint(name, done):
    text = done.stderr.decode(errors="replace").strip().removeprefix(f"{name}: ")
    return text or f"{name} ended with {done.returncode}"


def read_mesh(file, unit="m"):
    if unit not in METRES:
        raise Error(f"unit: '{unit}' is not known; give one of {', '.join(METRES)}")
    done = subprocess.run(
        [_program("palpate-import"), os.fspath(file)], capture_output=True, check=False
    )
    if done.returncode != 0:
        raise Error(_complaint("palpate-import", done))
    packet = done.stdout
    if len(packet) < 32 or packet[:8] != _MESH_MAGIC[:8]:
        raise Error(f"{file}: palpate-import and this module have different versions; install both again")
    vertices, triangles = struct.unpack_from("=QQ", packet, 8)
    if 32 + 24 * vertices + 12 * triangles > len(packet):
        raise Error(f"{file}: the output of palpate-import is incomplete; run it by hand to see why")
    points = numpy.frombuffer(packet, numpy.float64, 3 * vertices, 32).reshape(-1, 3)
    faces = numpy.frombuffer(packet, numpy.uint32, 3 * triangles, 32 + 24 * vertices)
    return points * METRES[unit], faces.reshape(-1, 3).copy()


def read_recording(file):
    with tempfile.TemporaryDirectory(prefix="palpate-") as folder:
        out = os.path.join(folder, "columns")
        done = subprocess.run(
            [_program("palpate-replay"), "export", os.fspath(file), "-o", out, "--format", "npy"],
            capture_output=True,
            check=False,
        )
        if done.returncode != 0:
            raise Error(_complaint("palpate-replay", done))
        return {
            session.name: {
                table.name.removesuffix(".npy"): numpy.load(table.path)
                for table in sorted(os.scandir(session.path), key=lambda entry: entry.name)
                if table.name.endswith(".npy")
            }
            for session in sorted(os.scandir(out), key=lambda entry: entry.name)
            if session.is_dir()
        }


def record(file, scene, path, tool=""):
    rows = numpy.atleast_2d(numpy.asarray(path, dtype=float))
    if rows.ndim != 2 or rows.shape[1] not in (3, 7) or not len(rows):
        raise Error(f"path: has the shape {rows.shape}; give (n, 3) or (n, 7), a row a millisecond")
    with tempfile.TemporaryDirectory(prefix="palpate-") as folder:
        poses = os.path.join(folder, "poses.csv")
        numpy.savetxt(poses, rows, fmt="%.17g", delimiter=",")
        source = os.fspath(scene) if isinstance(scene, (str, os.PathLike)) else os.path.join(folder, "scene.palpate")
        if not isinstance(scene, (str, os.PathLike)):
            scene.save(source)
        words = ["steps", poses, "--scene", source, "-o", os.fspath(file), *(["--tool", tool] if tool else [])]
        done = subprocess.run([_program("palpate-replay"), *words], capture_output=True, check=False)
        if done.returncode != 0:
            raise Error(_complaint("palpate-replay", done))
