"""Scenes by keyword: the fields of a scene file, which its one parser checks.

    bur = palpate.tool("bur", {"shape": "bur", "kind": "ball", "diameter_mm": 1.4}, leaves=256)
    enamel = {"cutting_pressure_MPa": 0.5, "cutting_viscosity_MPa_s_per_mm": 0.3}
    tooth = palpate.object("tooth", trimesh.load("tooth.ply"), grid_um=50, material=enamel)
    scene = palpate.scene("lesson", tools=[bur], objects=[tooth])
    scene.save("lesson.json")                                     # with the tooth's mesh beside it
"""

import hashlib
import json
import os
import pathlib
import re
import tempfile

import numpy

from palpate._physics import Error, Scene, _mesh_bytes, _write_file, load
from palpate.meshes import arrays
from palpate.poses import numbers


def _plain(value, where):
    """Returns a value as JSON has it; None is what is left out.  Errors name the field."""
    if isinstance(value, numpy.ndarray):
        value = value.tolist()
    if isinstance(value, numpy.generic):
        value = value.item()
    if isinstance(value, dict):
        at = f"{where}." if where else ""
        return {str(k): _plain(each, f"{at}{k}") for k, each in value.items() if each is not None}
    if isinstance(value, (list, tuple)):
        return [_plain(each, f"{where}[{i}]") for i, each in enumerate(value)]
    if isinstance(value, float) and not numpy.isfinite(value):
        raise Error(f"{where}: is {value}; give a finite number, or leave it out")
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if not isinstance(value, (str, bool, int, float)):
        raise Error(f"{where}: is of type {type(value).__name__}; give numbers, texts, lists or dicts, as in a file")
    return value


def _pose(given, where):
    if isinstance(given, dict):
        return given
    row = numbers(where, given, 3 if hasattr(given, "__len__") and len(given) == 3 else 7)
    if row.ndim != 1:
        raise Error(f"{where}: must be one pose; its shape is {row.shape}")
    return {"position_mm": 1000 * row[:3], **({"quaternion_wxyz": row[3:]} if len(row) == 7 else {})}


def _file(fields):
    """Files count from the working folder, wherever the scene is saved."""
    return {**fields, "file": os.path.abspath(fields["file"])} if "file" in fields else fields


def _mesh(given, name, meshes):
    """Returns the fields of a mesh; arrays become a file, whose name has a hash, in `meshes`."""
    if isinstance(given, (str, os.PathLike)):
        given = {"file": given}
    if not isinstance(given, dict):
        given = {"arrays": given}
    if "arrays" not in given:
        return _file(given)
    bytes_ = _mesh_bytes("mesh.ply", *arrays(given["arrays"]), 1.0)
    file = f"{re.sub('[^A-Za-z0-9_.-]', '-', str(name))}-{hashlib.sha256(bytes_).hexdigest()[:12]}.ply"
    meshes[file] = bytes_
    fields = {"file": file, "origin": "file", **{k: v for k, v in given.items() if k != "arrays"}}
    return fields if "longest_side_m" in fields else {"unit": "m", **fields}


def _body(fields, meshes):
    if not isinstance(fields, dict):
        return fields  # _plain or the parser names what it is
    fields, name = dict(fields), fields.get("name", "body")
    for place in {"start", "pose"} & set(fields):
        fields[place] = _pose(fields[place], f"{name}: {place}")
    if fields.get("mesh") is not None:
        fields["mesh"] = _mesh(fields["mesh"], name, meshes)
    if isinstance(fields.get("tree"), dict):
        fields["tree"] = _file(fields["tree"])
    fields["regions"] = [
        {**region, "mesh": _mesh(region["mesh"], f"{name}-region", meshes)}
        if isinstance(region, dict) and "mesh" in region else region for region in fields.get("regions") or []] or None
    return fields


def tool(name, mesh=None, **fields):
    return {"name": name, "mesh": mesh, **fields}


def object(name, mesh, **fields):  # as scene files call it
    return {"name": name, "mesh": mesh, **fields}


def region(material, **where):
    return {**where, "material": material}


def effect(name, **parameters):
    return {"name": name, **parameters}


def _write(folder, name, text, meshes):
    for file, bytes_ in meshes.items():
        _write_file(str(folder / file), bytes_)
    _write_file(str(folder / name), text)


def scene(name="scene", *, tools, objects, **fields):
    meshes = {}
    fields = {"name": name, **fields, "tools": [_body(each, meshes) for each in tools],
              "objects": [_body(each, meshes) for each in objects]}
    text = (json.dumps(_plain(fields, ""), indent=2, ensure_ascii=False) + "\n").encode()
    with tempfile.TemporaryDirectory(prefix="palpate-") as folder:
        _write(pathlib.Path(folder), "scene.json", text, meshes)
        try:
            made = load(pathlib.Path(folder, "scene.json"))
        except Error as error:
            raise Error(str(error).replace(f"{folder}/scene.json", str(name)).replace(f"{folder}/", "")) from None
    made._source = made.hash, text, meshes
    return made


def save(self, file):
    path = pathlib.Path(os.fspath(file))
    if path.suffix != ".json":
        self._save(path)
        return
    if self._source is None:
        raise Error(f"{path}: only scenes that palpate.scene has made are written as .json; give a name that "
                    "ends in .palpate")
    made, text, meshes = self._source
    if made != self.hash:
        raise Error(f"{path}: the scene has been changed since palpate.scene made it, so its fields are no longer "
                    "true; make it again, or give a name that ends in .palpate")
    _write(path.parent, path.name, text, meshes)


Scene.save = save
