from os import PathLike
from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence, Tuple, Union

import numpy
import pandas
import xarray
from numpy.typing import ArrayLike, NDArray

__version__: str

report_dtype: numpy.dtype
"""Columns of details, with their units in their names; rows (7) are the contacts that a report lists, `listed` of
them: force_N is the multiplier, offset_m what the linearised gap lacks, body the object that is felt by its mesh,
-1: a leaf, tool_part, object_part and row what touches there.  prediction_ns, rows_ns, solve_ns and response_ns are
the stages of the step; qp_iterations and others count what it took."""

Effect = Callable[[NDArray[numpy.float64], NDArray[numpy.float64], NDArray[numpy.float64]], Any]
"""What Proxy.set_effect takes."""

class Error(ValueError):
    """What was wrong with what was given, and what to do."""

class Material:
    """What a part of an object is made of."""

    name: str
    stiffness: float
    """Of a leaf's contact in N/m; infinite: rigid."""
    static_friction: float
    dynamic_friction: float

class Body:
    """A mesh with its sphere tree, and what it is made of."""

    name: str
    remarks: List[str]
    """What was mended of the mesh, and what might surprise: a sentence each."""
    pose: NDArray[numpy.float64]
    """Objects: where they stand, x y z w x y z.  To be set with x y z alone, too."""
    materials: List[Material]
    """Objects: what there is in them; leaf_materials says where."""
    @property
    def leaf_materials(self) -> NDArray[numpy.uint8]:
        """Of each leaf, as an index into materials."""
    @property
    def leaves(self) -> int:
        """How many leaves the sphere tree has."""
    @property
    def vertices(self) -> NDArray[numpy.float64]:
        """(n, 3), metres, in the body's frame."""
    @property
    def triangles(self) -> NDArray[numpy.uint32]:
        """(m, 3): vertices of each, counter-clockwise from outside."""
    @property
    def leaf_centres(self) -> NDArray[numpy.float64]:
        """(leaves, 3), metres, in the body's frame."""
    @property
    def leaf_radii(self) -> NDArray[numpy.float64]:
        """Metres, one of each leaf."""

class Scene:
    """Tools, and the objects that they touch: what load has read, or bodies put together.

    contact     "surface" or "spheres"
    parameters  what is to differ from the defaults, by the names of parameters()
    """

    def __init__(
        self,
        objects: Sequence[Body],
        tools: Sequence[Body],
        *,
        name: str = "scene",
        contact: str = "surface",
        **parameters: float,
    ) -> None:
        """Copies of the bodies.  Names are letters, digits, - _ and ."""
    def save(self, file: Union[str, PathLike[str]]) -> None:
        """Into a file *.palpate, which load and palpate-server read, and the script of the hand beside it."""
    @property
    def name(self) -> str: ...
    @property
    def hash(self) -> str:
        """Of its content: what recordings, their METHODS.md and servers name it by."""
    @property
    def tools(self) -> List[Body]:
        """Their poses are where the scene places them at the start."""
    @property
    def objects(self) -> List[Body]:
        """With their materials, regions and poses; a pose may be set before a model is made."""
    said: List[str]
    """What was assumed or mended, a sentence each."""
    @property
    def parameters(self) -> Dict[str, float]:
        """What may be varied, by name, as the scene has it; parameters() has units and ranges."""
    def path(self, rate: float = 1000.0) -> NDArray[numpy.float64]:
        """The hand's script that stands beside the scene's file: (n, 7), so many poses a second."""
    def model(self, tool: Union[int, str] = 0, **parameters: float) -> Model:
        """One of the tools, by index or name, against all objects.

        parameters: what is to differ from the scene, which stays as it is, as
        scene.model(stiffness_N_per_m=500, separation_um=2, friction=0.3).
        """

def load(
    name: Union[str, PathLike[str]],
    *,
    contact: Optional[str] = None,
    tolerance_um: Optional[float] = None,
    unit: str = "",
) -> Scene:
    """A scene of the catalogue ("bunny-bunny"), or of a file: .json, .palpate, or a mesh, which gets a ball to
    feel it.  As the server has it: the same poses give the same bits.

    contact       "surface" or "spheres", in place of the scene's
    tolerance_um  to which sphere trees follow their meshes, in place of the scene's leaves
    unit          of a mesh: what a number in its file means, m, cm, mm or inch; left out: guessed

    A first time takes seconds, a minute for a whole mouth, and shows how far it is; what was built is kept in
    ~/.cache/palpate.  Catalogue and meshes are found beside palpate-import, as read_mesh finds it.
    """

def parameters() -> List[Dict[str, Union[str, float]]]:
    """What may be varied of a scene: name, unit, default, least, most, and what it is.  pandas.DataFrame takes it."""

def body(
    name: str,
    vertices: ArrayLike,
    triangles: ArrayLike,
    *,
    leaves: int = 0,
    contact: str = "surface",
    static_friction: float = 0.0,
    dynamic_friction: float = 0.0,
    stiffness: float = ...,
) -> Body:
    """Makes a body of a mesh: vertices (n, 3) in metres, triangles (m, 3), counter-clockwise from outside.

    leaves     of its sphere tree; 0: 512 where the mesh is felt, else as many as its shape needs
    contact    as the model's: "surface" or "spheres"
    stiffness  of a leaf's contact in N/m; infinite: rigid
    """

def ball(name: str, radius: float) -> Body:
    """A ball round the origin, of one leaf, which is exact."""

def box(size: ArrayLike) -> Tuple[NDArray[numpy.float64], NDArray[numpy.uint32]]:
    """Vertices and triangles of a box round the origin."""

def ellipsoid(
    semi_axes: ArrayLike, triangles: int = 5120
) -> Tuple[NDArray[numpy.float64], NDArray[numpy.uint32]]:
    """Vertices and triangles of an ellipsoid round the origin; at least so many triangles."""

def fault_words(faults: int) -> str:
    """What the bits of a report's faults mean, in words; empty where there is none."""

class Report:
    """What came of one step.  Force and torque act on the hand, at the tool's centroid."""

    @property
    def force(self) -> NDArray[numpy.float64]:
        """x y z in N, in the axes of the scene."""
    @property
    def torque(self) -> NDArray[numpy.float64]:
        """x y z in N m, in the axes of the scene."""
    @property
    def pose(self) -> NDArray[numpy.float64]:
        """Of the graphic tool, which enters nothing: x y z w x y z."""
    @property
    def contacts(self) -> int:
        """How many places touch."""
    @property
    def points(self) -> NDArray[numpy.float64]:
        """A row for each contact listed: where it is, and its force on the tool."""
    @property
    def faults(self) -> int:
        """A bit for each thing that went wrong, 0 where nothing did; fault_words says what they mean."""
    @property
    def substeps(self) -> int:
        """Into how many parts the step's way was divided."""
    @property
    def rows(self) -> NDArray[numpy.void]:
        """The contacts listed, as the solver had them: columns are those of report_dtype["rows"]."""
    @property
    def details(self) -> numpy.void:
        """All of it, as a record of report_dtype.  Stage times are 0: Proxy.steps takes them."""
    @property
    def parameters(self) -> Dict[str, float]:
        """As the model's: what the step was made with."""

class Steps:
    """What came of many steps: arrays with a row for each."""

    wrench: NDArray[numpy.float64]
    """Force in N and torque in N m: six numbers for each step."""
    pose: NDArray[numpy.float64]
    """Of the graphic tool: x y z w x y z for each step."""
    contacts: NDArray[numpy.int32]
    """How many places touched."""
    faults: NDArray[numpy.uint32]
    """As a report's."""
    details: Optional[NDArray[numpy.void]]
    """Where it was asked for: all that each step reports, with its stage times, as report_dtype."""
    parameters: Dict[str, float]
    """As the model's: what these steps were made with."""
    def to_pandas(self) -> pandas.DataFrame:
        """A row for each step (and path), a column for each number, details' among them but for rows; pandas is needed
        for this alone."""
    def to_xarray(self) -> xarray.Dataset:
        """The same with dimensions path, step, axis and pose; xarray is needed for this alone."""

class Model:
    """One tool against all objects; never changes, and may be used by all threads.

    stiffness and torsional_stiffness: of the spring between hand and tool, N/m and N m/rad.
    step: what else may be varied, by the names of parameters(), as {"separation_um": 2}.
    """

    def __init__(
        self,
        objects: Sequence[Body],
        tool: Body,
        *,
        contact: str = "surface",
        stiffness: float = 1000.0,
        torsional_stiffness: float = 1.0,
        step: Mapping[str, float] = {},
    ) -> None: ...
    @property
    def parameters(self) -> Dict[str, float]:
        """What it was made with, by name; not a number where the objects' friction differs."""
    def follow(self, paths: ArrayLike, *, threads: int = 0, details: bool = False) -> Steps:
        """Lets a hand follow each of many paths, (paths, steps, 3 or 7), on all cores (threads=0).

        Each has a proxy of its own, that begins at its first pose; what comes out is the same for
        any number of threads.  details: Steps.details, of 1.4 kB a step, and its stages are timed.
        """

class Proxy:
    """The tool that follows one hand; for one thread at a time."""

    def __init__(self, model: Model, pose: ArrayLike) -> None: ...
    @property
    def start_depth(self) -> float:
        """How far the tool was from the hand at the start, in metres."""
    def restart(self, pose: ArrayLike) -> None:
        """Begins anew with the hand at this pose, as a new proxy would."""
    def set_effect(
        self, effect: Optional[Effect], *, rate_hz: float = 100.0, max_force: float = 1.0, max_torque: float = 0.01
    ) -> None:
        """Adds a force of one's own to what contacts give, in place of the one before; None: no more.

        effect      effect(hand, twist, tool) is given where the hand is (x y z w x y z), its velocity in m/s and
                    turning in rad/s (6, smoothed over 4 ms), and where the tool was a step before.  It returns the
                    force on the hand in N (3), or force and torque in N m (6), at the origin of the tool's frame; or
                    a pair of that and its stiffness, (3, 3) or (6, 6): what it loses per metre and rad on the way to
                    the next time.  Of an energy these are minus the gradient, and the Hessian
        rate_hz     how often it is asked, 1000 over a whole number: at the first step, then at every 1000 / rate_hz-th.
                    In between the wrench is held, or goes on by its stiffness
        max_force, max_torque
                    N and N m: longer ones are shortened.  At an arm 1 N and 10 mN m is all that gets through

        Where it raises something, no step is taken, and it is off; so it is where what it returns is no such wrench or
        not finite, which is an Error.
        """
    def step(self, pose: ArrayLike) -> Report:
        """One step of a millisecond: the hand is at this pose now; returns what it feels.

        The tool moves towards the hand until objects stop it.  A hand that leaps some centimetres in one
        step has its tool arrive some steps later.
        """
    def steps(self, poses: ArrayLike, *, details: bool = False) -> Steps:
        """One step after the other, (steps, 3 or 7): as step for each, without Python in between.

        details: Steps.details, of 1.4 kB a step, and its stages are timed.
        """

def read_mesh(
    file: Union[str, PathLike[str]], unit: str = "m"
) -> Tuple[NDArray[numpy.float64], NDArray[numpy.uint32]]:
    """Vertices in metres and triangles of an STL, OBJ, PLY, 3DS or glTF file.

    unit  what a number in the file means: m, cm, mm or inch
    """

def read_recording(
    file: Union[str, PathLike[str]],
) -> Dict[str, Dict[str, NDArray[numpy.void]]]:
    """A recording (MCAP) as arrays with named columns: [session][table][column].

    Tables are poses, wrenches, faults, tool_states, contacts, session, loop, limiter and guide;
    columns have their units in their names.
    """
