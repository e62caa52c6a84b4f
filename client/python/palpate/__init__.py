"""Haptic rendering in six degrees of freedom: from a scene, or two meshes, to a wrench.

    import palpate
    scene = palpate.load("bunny-bunny")
    path = scene.path()                             # of the hand that comes with it
    print(palpate.Proxy(scene.model(), path[0]).steps(path).wrench)

    # or of meshes of one's own
    block = palpate.body("block", *palpate.box([0.04, 0.04, 0.04]))
    model = palpate.Model([block], palpate.ball("ball", 0.005))
    proxy = palpate.Proxy(model, [0, 0.03, 0])
    print(proxy.step([0, 0.022, 0]).force)          # 3 N upwards

Lengths are metres, forces newtons, torques newton metres; a pose is x y z, or x y z and the unit
quaternion w x y z.  Arrays are numpy's: what comes out is float64; whole numbers and floats of up to
64 bits go in everywhere, all others nowhere.  What is wrong is told by palpate.Error, a ValueError.
Equal poses give equal bits, those of C++.

Scenes, bodies, reports and steps are pickled; models and proxies are made of them.
"""

from palpate import _prose, _tables
from palpate._physics import (
    Body,
    Error,
    Material,
    Model,
    Proxy,
    Report,
    Scene,
    Steps,
    __version__,
    ball,
    body,
    box,
    ellipsoid,
    fault_words,
    load,
    parameters,
    report_dtype,
)
from palpate.files import read_mesh, read_recording

__all__ = [
    "Body",
    "Error",
    "Material",
    "Model",
    "Proxy",
    "Report",
    "Scene",
    "Steps",
    "__version__",
    "ball",
    "body",
    "box",
    "ellipsoid",
    "fault_words",
    "load",
    "parameters",
    "read_mesh",
    "read_recording",
    "report_dtype",
]

Steps.to_pandas, Steps.to_xarray = _tables.to_pandas, _tables.to_xarray

_prose.dress(globals(), "__init__.pyi")
