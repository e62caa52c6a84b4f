from os import PathLike
from typing import Any, Callable, Dict, Iterator, List, Optional, Sequence, Tuple, Union

import numpy
import pandas
import xarray
from numpy.typing import ArrayLike, NDArray

__version__: str
physics_revision: str  # builds of one revision give the same bits for the same inputs

report_dtype: numpy.dtype
"""Columns of details, with units in their names.  rows (7) are the contacts of the report, of which the first `listed`
are valid: force_N is the multiplier; offset_m the offset of the linearised constraint; body the object felt by its
mesh, or -1 for a leaf; tool_part, object_part and row identify the features in contact.  prediction_ns, rows_ns,
solve_ns and response_ns are the times of the step's stages; qp_iterations and others count its work."""

Effect = Callable[[NDArray[numpy.float64], NDArray[numpy.float64], NDArray[numpy.float64]], Any]
"""A function for Proxy.set_effect: effect(hand, twist, tool)."""

class Error(ValueError):
    """Invalid input; the message names it and says what to give instead."""

class Material:
    """The material of a part of an object."""

    name: str
    stiffness: float
    """Contact stiffness of a leaf in N/m; infinite: rigid."""
    static_friction: float
    dynamic_friction: float

class Body:
    """A mesh with its sphere tree and materials."""

    name: str
    remarks: List[str]
    """Repairs of the mesh and other remarks, one sentence each."""
    pose: NDArray[numpy.float64]
    """Pose of an object: x y z w x y z.  Can also be set to x y z only."""
    materials: List[Material]
    """Materials of an object; leaf_materials assigns them to leaves."""
    @property
    def leaf_materials(self) -> NDArray[numpy.uint8]:
        """Index into materials for each leaf."""
    @property
    def leaves(self) -> int:
        """Number of leaves of the sphere tree."""
    @property
    def vertices(self) -> NDArray[numpy.float64]:
        """(n, 3), in metres, in the body's frame."""
    @property
    def triangles(self) -> NDArray[numpy.uint32]:
        """(m, 3): vertex indices, counter-clockwise seen from outside."""
    @property
    def leaf_centres(self) -> NDArray[numpy.float64]:
        """(leaves, 3), in metres, in the body's frame."""
    @property
    def leaf_radii(self) -> NDArray[numpy.float64]:
        """(leaves), in metres."""

class Scene:
    """Tools and the objects that they touch, loaded or made of bodies.

    contact     "surface" or "spheres"
    parameters  values that differ from the defaults, by the names that parameters() lists
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
        """Makes a scene of copies of the bodies.  Names consist of letters, digits, - _ and ."""
    def save(self, file: Union[str, PathLike[str]]) -> None:
        """Writes a file *.palpate for load and palpate-server, and the hand's script beside it.

        A scene that palpate.scene has made can also be written as *.json, with the meshes of its arrays beside it.
        """
    @property
    def name(self) -> str: ...
    @property
    def hash(self) -> str:
        """Hash of the scene's content, as in recordings, their METHODS.md and servers."""
    @property
    def tools(self) -> List[Body]:
        """The tools, with their poses at the start."""
    @property
    def objects(self) -> List[Body]:
        """The objects with their materials, regions and poses.  Set a pose before you make a model."""
    said: List[str]
    """Assumptions and repairs, one sentence each."""
    @property
    def parameters(self) -> Dict[str, float]:
        """The scene's values of the parameters, by name; parameters() has units and ranges."""
    def path(self, rate: float = 1000.0) -> NDArray[numpy.float64]:
        """Returns the hand's script beside the scene file: (n, 7), with `rate` poses per second."""
    def model(self, tool: Union[int, str] = 0, **parameters: float) -> Model:
        """Makes a model of one tool, by index or name, and all objects.

        parameters  values that differ from the scene's, which does not change, as in
                    scene.model(stiffness_N_per_m=500, separation_um=2, friction=0.3)
        """

def load(
    name: Union[str, PathLike[str]],
    *,
    contact: Optional[str] = None,
    tolerance_um: Optional[float] = None,
    unit: str = "",
) -> Scene:
    """Loads a scene of the catalogue ("bunny-bunny") or of a file: .json, .palpate, or a mesh, to which a ball is
    added as the tool.  The scene is the server's: the same poses give the same bits.

    contact       "surface" or "spheres"; default: the scene's
    tolerance_um  largest distance of the sphere trees from their meshes; default: the scene's numbers of leaves
    unit          of a mesh: m, cm, mm or inch; default: guessed from its size

    The first time it builds the scene, which takes seconds (a minute for a whole mouth) and shows its progress; the
    result is kept in ~/.cache/palpate.  The catalogue is found beside palpate-import, which read_mesh needs, too.
    """

def parameters() -> List[Dict[str, Union[str, float]]]:
    """Lists the parameters of a scene with name, unit, default, least, most and description; suits pandas.DataFrame."""

def body(
    name: str,
    vertices: Any,
    triangles: Optional[ArrayLike] = None,
    *,
    leaves: int = 0,
    contact: str = "surface",
    static_friction: float = 0.0,
    dynamic_friction: float = 0.0,
    stiffness: float = ...,
) -> Body:
    """Makes a body from a mesh: vertices (n, 3) in metres, triangles (m, 3), counter-clockwise seen from outside.
    Or from one object that has both: .vertices and .faces (trimesh) or .triangles (Open3D, Body), .points and .cells_dict
    (meshio), or a pair of arrays, as read_mesh and box return.

    leaves     number of leaves of its sphere tree; 0: 32 at most where its mesh is felt, else as many as its shape needs
    contact    contact model for which it is made: "surface" or "spheres"
    stiffness  contact stiffness of a leaf in N/m; infinite: rigid
    """

def ball(name: str, radius: float) -> Body:
    """Makes a ball around the origin, with a single leaf, which is exact."""

def box(size: ArrayLike) -> Tuple[NDArray[numpy.float64], NDArray[numpy.uint32]]:
    """Returns vertices and triangles of a box around the origin."""

def ellipsoid(
    semi_axes: ArrayLike, triangles: int = 5120
) -> Tuple[NDArray[numpy.float64], NDArray[numpy.uint32]]:
    """Returns vertices and triangles of an ellipsoid around the origin, with at least this many triangles."""

def fault_words(faults: int) -> str:
    """Describes the bits of a report's faults in words; empty if there are none."""

class Report:
    """The result of one step.  Force and torque act on the hand, at the tool's centroid."""

    @property
    def force(self) -> NDArray[numpy.float64]:
        """x y z in N, in the axes of the scene."""
    @property
    def torque(self) -> NDArray[numpy.float64]:
        """x y z in N m, in the axes of the scene."""
    @property
    def wrench(self) -> NDArray[numpy.float64]:
        """Force and torque: (6)."""
    @property
    def pose(self) -> NDArray[numpy.float64]:
        """Pose of the proxy (the graphic tool, which enters nothing): x y z w x y z."""
    @property
    def contacts(self) -> int:
        """Number of contacts."""
    @property
    def points(self) -> NDArray[numpy.float64]:
        """One row per listed contact: its position, and its force on the tool."""
    @property
    def faults(self) -> int:
        """Bits of the faults, 0 if there are none; fault_words describes them."""
    @property
    def substeps(self) -> int:
        """Number of sub-steps into which the step was divided."""
    @property
    def rows(self) -> NDArray[numpy.void]:
        """The listed contacts as constraints of the solver, with the columns of report_dtype["rows"]."""
    @property
    def details(self) -> numpy.void:
        """The whole report as a record of report_dtype.  Stage times are 0; only Proxy.steps measures them."""
    @property
    def parameters(self) -> Dict[str, float]:
        """Parameters of the model."""

class Steps:
    """The results of many steps: arrays with one row per step.

    len(steps) is the number of steps, or of paths for Model.follow.  steps[100:200] has a part of them, steps[7]
    one step (or path), and steps[steps.contacts > 0] those in contact: their arrays are indexed alike.
    """

    wrench: NDArray[numpy.float64]
    """Force in N and torque in N m: (..., 6)."""
    @property
    def force(self) -> NDArray[numpy.float64]:
        """Force in N: (..., 3), a part of wrench."""
    @property
    def torque(self) -> NDArray[numpy.float64]:
        """Torque in N m: (..., 3), a part of wrench."""
    @property
    def bad_poses(self) -> int:
        """Number of steps whose pose was not finite."""
    pose: NDArray[numpy.float64]
    """Pose of the proxy, x y z w x y z: (..., 7)."""
    contacts: NDArray[numpy.int32]
    """Number of contacts."""
    faults: NDArray[numpy.uint32]
    """Bits of the faults, as in Report."""
    details: Optional[NDArray[numpy.void]]
    """Whole reports with stage times, as records of report_dtype; None if not requested."""
    parameters: Dict[str, float]
    """Parameters of the model."""
    def __len__(self) -> int: ...
    def __getitem__(self, at: Any) -> Steps: ...
    def __iter__(self) -> Iterator[Steps]: ...
    def to_pandas(self) -> pandas.DataFrame:
        """Returns one row per step (and path) and one column per number, with those of details except rows.  Needs
        pandas."""
    def to_xarray(self) -> xarray.Dataset:
        """Returns the same with dimensions path, step, axis and pose.  Needs xarray."""

class Model:
    """One tool and all objects.  Immutable; several threads may use it.

    contact     "surface" or "spheres"
    parameters  values that differ from the defaults, by the names that parameters() lists, as in
                Model([block], ball, stiffness_N_per_m=500, friction=0.3)

    Bodies need names, each its own.
    """

    def __init__(
        self, objects: Sequence[Body], tool: Body, *, contact: str = "surface", **parameters: float
    ) -> None: ...
    @property
    def parameters(self) -> Dict[str, float]:
        """The parameters by name; NaN for friction that differs between objects."""
    def follow(
        self, paths: ArrayLike, *, threads: int = 0, details: bool = False, on_bad_pose: str = "fault"
    ) -> Steps:
        """Steps along many paths, (paths, steps, 3 or 7), in parallel; threads=0: on all cores, as far as
        affinity and a container's CPU quota allow.

        Each path has its own proxy, which starts at the path's first pose.  The result does not depend on the
        number of threads.  details: also return Steps.details (1.4 kB per step), with stage times.
        on_bad_pose: as in Proxy.steps.

        Ctrl-C ends it at once.  The KeyboardInterrupt has the steps taken so far as its attribute `steps`, of the
        whole shape; steps that were not taken have NaN as wrench and pose, and a fault.
        """

class State:
    """The state of a proxy: all that its next step depends on, beside its pose and its effect's function.  Immutable.

    A pickled state names the physics and the model.  Another physics', another model's and a damaged one are an Error.
    """

class Proxy:
    """The proxy (god-object) of one hand.  Only one thread at a time may use it.

    A copy (copy.copy or pickle) stands where the original does, with the same effect, and continues to the same bits.
    States of solids that burs cut can be copied, but not pickled.
    """

    def __init__(self, model: Model, pose: ArrayLike) -> None: ...
    @property
    def start_depth(self) -> float:
        """Distance of the tool from the hand at the start, in metres."""
    @property
    def moved(self) -> Dict[str, NDArray[numpy.float64]]:
        """Where the groups of objects that move are, by name: poses relative to where the objects are placed."""
    def restart(self, pose: ArrayLike) -> None:
        """Starts again with the hand at this pose, like a new proxy."""
    def state(self) -> State:
        """Returns the present state, for set_state: to go on from it again, or to branch."""
    def set_state(self, state: State) -> None:
        """Continues from a state of a proxy of the same model: the same poses then give the same bits.

        The effect stays this proxy's own; what it had returned last is the state's.
        """
    def set_effect(
        self, effect: Optional[Effect], *, rate_hz: float = 100.0, max_force: float = 1.0, max_torque: float = 0.01
    ) -> None:
        """Adds a force of your own to the contact forces, replacing the previous one; None: removes it.

        effect      effect(hand, twist, tool) gets the hand's pose (x y z w x y z), its linear and angular velocity in
                    m/s and rad/s (6, smoothed over 4 ms), and the tool's pose of the previous step.  It returns the
                    force on the hand in N (3), or force and torque in N m (6), at the origin of the tool's frame.  It
                    may return a pair of that wrench and its stiffness, (3, 3) or (6, 6): the decrease of the wrench
                    per metre and radian of motion until the next call.  For an energy, these are minus the gradient,
                    and the Hessian
        rate_hz     rate of the calls, 1000 divided by an integer: at the first step, then every 1000 / rate_hz steps.
                    Between calls the wrench is held, or extrapolated by its stiffness
        max_force, max_torque
                    limits in N and N m, to which longer vectors are shortened.  An arm renders at most 1 N and 10 mN m

        If the effect raises an exception or returns an invalid or non-finite wrench (an Error), no step is taken, and
        the effect is removed.  The effect cannot step or change the proxy that calls it.
        """
    def step(self, pose: ArrayLike) -> Report:
        """Takes one step of a millisecond with the hand at this pose, and returns what the hand feels.

        The tool moves towards the hand until objects stop it.  After a jump of some centimetres it arrives some
        steps later.
        """
    def steps(self, poses: ArrayLike, *, details: bool = False, on_bad_pose: str = "fault") -> Steps:
        """Takes one step for each pose, (steps, 3 or 7), like step but without Python in between.

        details: also return Steps.details (1.4 kB per step), with stage times.
        on_bad_pose: what a pose that is not finite is: "fault", of its step, which gives no force (Steps.bad_poses
        counts them), or "raise": an Error, before any step is taken.

        Ctrl-C ends it at once.  The KeyboardInterrupt (or what an effect raises) has the steps taken so far as its
        attribute `steps`; the proxy stands where they end, and can go on with poses[len(error.steps):].
        """

class Batch:
    """Many proxies of one model that step together on all cores, for loops that are closed in Python.

    Each gives the bits of a single Proxy, whatever the number of threads.  Only one thread at a time may use it.
    """

    def __init__(self, model: Model, n: int, pose: Optional[ArrayLike] = None, *, threads: int = 0) -> None:
        """Makes n proxies.

        pose     where their hands start: one pose for all, or (n, 3 or 7); None: where the first actions are
        threads  0: one for each core, as far as affinity and a container's CPU quota allow; they are kept
        """
    @property
    def threads(self) -> int: ...
    def __len__(self) -> int: ...
    def step(self, actions: ArrayLike, *, details: bool = False, on_bad_pose: str = "fault") -> Steps:
        """Takes one step of each proxy, with its hand at its row of the actions: (n, 3 or 7).  Returns a row for each.

        details: also return Steps.details (1.4 kB per proxy), with stage times.
        on_bad_pose: as in Proxy.steps.
        """
    def restart(self, pose: ArrayLike, mask: Optional[ArrayLike] = None) -> None:
        """Starts again, as Proxy.restart, those proxies that the booleans select; None: all.

        pose  one for all, or (n, 3 or 7)
        """

def read_mesh(
    file: Union[str, PathLike[str]], unit: str = "m"
) -> Tuple[NDArray[numpy.float64], NDArray[numpy.uint32]]:
    """Reads vertices (in metres) and triangles of an STL, OBJ, PLY, 3DS or glTF file.

    unit  unit of the file: m, cm, mm or inch
    """

def read_recording(
    file: Union[str, PathLike[str]],
) -> Dict[str, Dict[str, NDArray[numpy.void]]]:
    """Reads a recording (MCAP) as arrays with named columns: [session][table][column].

    Tables are poses, wrenches, faults, tool_states, contacts, session, loop, limiter and guide.
    Column names include units.
    """

def record(
    file: Union[str, PathLike[str]],
    scene: Union[Scene, str, PathLike[str]],
    path: ArrayLike,
    tool: str = "",
) -> None:
    """Steps a scene's tool along a path, (n, 3 or 7), a pose a millisecond, and writes the session as a recording.

    palpate-replay plays and verifies it.  Poses are those of Proxy.steps(path) of a proxy that starts at path[0], bit
    for bit; forces ramp in over the first 200 ms, as in a session, and are Proxy's from then on.
    """

def pose(
    xyz: ArrayLike = (0.0, 0.0, 0.0),
    rotation: Any = None,
    *,
    xyzw: Any = None,
    wxyz: Any = None,
    rotvec: Any = None,
    matrix: Any = None,
) -> NDArray[numpy.float64]:
    """Returns poses as all functions take them, x y z w x y z: (..., 7), of positions (..., 3) and an orientation.

    rotation  a scipy.spatial.transform.Rotation; the others take it, too
    xyzw      unit quaternions, the scalar last, as scipy, ROS and Open3D's files have them
    wxyz      unit quaternions, the scalar first
    rotvec    axis times angle in rad, (..., 3)
    matrix    rotations (..., 3, 3), or whole poses (..., 4, 4) without xyz

    Quaternions in the wrong order are poses, too, often turned by half a turn: no function can find that out.
    """

def write_mesh(
    file: Union[str, PathLike[str]], mesh: Any, triangles: Optional[ArrayLike] = None, *, unit: str = "m"
) -> None:
    """Writes a mesh, a body's too, as a binary STL, an OBJ or a binary PLY, by the file's ending.

    mesh, triangles  two arrays, or one object that has both, as for body; a Body's is in its own frame
    unit             unit of the file: m, cm, mm or inch

    An STL has single precision, which is also what read_mesh and scenes keep of every file.
    """

def scene(
    name: str = "scene",
    *,
    tools: Sequence[Mapping[str, Any]],
    objects: Sequence[Mapping[str, Any]],
    **fields: Any,
) -> Scene:
    """Makes a scene of the fields of a scene file, which are checked as in one: errors name the field.

    tools, objects  what tool and object return
    fields          contact, friction, coupling, step, effects (what effect returns), first_sight, whole_at_start,
                    description

    scenes/catalogue/README.md lists all fields.  Their lengths have the unit in their names, those of arrays are in m.
    scene.save("x.json") writes the file and its meshes for load and palpate-server, to the same hash and bits.
    """

def tool(name: str, mesh: Any = None, **fields: Any) -> Dict[str, Any]:
    """Describes a tool of a scene.

    mesh    whatever body takes; a dict, {"shape": "bur", ...} or {"file": "tip.stl", "unit": "mm"}; or a dict
            {"arrays": ..., "unit": "mm", "curved": ...} of a mesh and further fields.  Files count from the working
            folder.  None: give bur="237/014"
    fields  start (a pose in metres, or a dict), leaves, tree, look; for what cuts: bur, speed_rpm, vibration, edge
    """

def object(name: str, mesh: Any, **fields: Any) -> Dict[str, Any]:
    """Describes an object of a scene.  (`from palpate import *` leaves it out.)

    mesh    as of a tool
    fields  pose (in metres, or a dict), material (a dict), regions (what region returns), leaves, tree, look, and for a
            solid that burs cut: grid_um
    """

def region(material: Mapping[str, Any], **where: Any) -> Dict[str, Any]:
    """Describes a region of an object with another material: by box, sphere, group, or, in what burs cut, mesh."""

def effect(name: str, **parameters: Any) -> Dict[str, Any]:
    """Describes an added force, one of those that come with the programs or a shared object of your own, with its
    parameters (scenes/effects/README.md)."""
