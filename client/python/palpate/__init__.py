"""Haptic rendering in six degrees of freedom: from a scene, or two meshes, to a wrench.

    import palpate
    scene = palpate.load("bunny-bunny")
    path = scene.path()                             # poses of the hand, supplied with the scene
    steps = palpate.Proxy(scene.model(), path[0]).steps(path)
    print(abs(steps.wrench).max(axis=0))            # the greatest force in N and torque in N m

    # or from meshes of your own
    block = palpate.body("block", *palpate.box([0.04, 0.04, 0.04]))
    model = palpate.Model([block], palpate.ball("ball", 0.005))
    proxy = palpate.Proxy(model, [0, 0.03, 0])
    print(proxy.step([0, 0.022, 0]).force)          # 3 N upwards

Units are metres, newtons and newton metres.  A pose is x y z, or x y z followed by the unit quaternion
w x y z; palpate.pose makes it of other orders and forms.  Arrays are NumPy arrays: functions accept integers
and floats of up to 64 bits, and return float64.  Errors are palpate.Error, a ValueError.  The same poses give
the same bits as in C++.

Everything can be copied and pickled.  A proxy's copy, and one that gets its state, continues to the same bits.
"""

from palpate import _prose, _tables
from palpate._physics import (
    Batch,
    Body,
    Error,
    Material,
    Model,
    Proxy,
    Report,
    Scene,
    State,
    Steps,
    __version__,
    ball,
    body,
    box,
    ellipsoid,
    fault_words,
    load,
    parameters,
    physics_revision,
    report_dtype,
)
from palpate.described import effect, object, region, scene, tool
from palpate.files import read_mesh, read_recording, record
from palpate.meshes import write_mesh
from palpate.poses import pose

__all__ = [
    "Batch",
    "Body",
    "Error",
    "Material",
    "Model",
    "Proxy",
    "Report",
    "Scene",
    "State",
    "Steps",
    "__version__",
    "ball",
    "body",
    "box",
    "effect",
    "ellipsoid",
    "fault_words",
    "load",
    "parameters",
    "physics_revision",
    "pose",
    "read_mesh",
    "read_recording",
    "record",
    "region",
    "report_dtype",
    "scene",
    "tool",
    "write_mesh",
]
# `object` is left out, so that `from palpate import *` keeps Python's own.

Steps.to_pandas, Steps.to_xarray = _tables.to_pandas, _tables.to_xarray

_prose.dress(globals(), "__init__.pyi")
