from os import PathLike
from typing import Dict, List, Mapping, Sequence, Tuple, Union

import numpy
from numpy.typing import ArrayLike, NDArray

__version__: str

class Error(ValueError):
    """What was wrong with what was given, and what to do."""

class Body:
    """A mesh with its sphere tree, and what it is made of."""

    name: str
    remarks: List[str]
    """What was mended of the mesh, and what might surprise: a sentence each."""
    pose: NDArray[numpy.float64]
    """Objects: where they stand, x y z w x y z.  To be set with x y z alone, too."""
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

class Model:
    """One tool against all objects; never changes, and may be used by all threads.

    stiffness and torsional_stiffness: of the spring between hand and tool, N/m and N m/rad.
    step: what may be varied of the step, by its name in scene files, as {"separation_um": 2}.
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
    def follow(self, paths: ArrayLike, *, threads: int = 0) -> Steps:
        """Lets a hand follow each of many paths, (paths, steps, 3 or 7), on all cores (threads=0).

        Each has a proxy of its own, that begins at its first pose; what comes out is the same for
        any number of threads.
        """

class Proxy:
    """The tool that follows one hand; for one thread at a time."""

    def __init__(self, model: Model, pose: ArrayLike) -> None: ...
    @property
    def start_depth(self) -> float:
        """How far the tool was from the hand at the start, in metres."""
    def restart(self, pose: ArrayLike) -> None:
        """Begins anew with the hand at this pose, as a new proxy would."""
    def step(self, pose: ArrayLike) -> Report:
        """One step of a millisecond: the hand is at this pose now; returns what it feels.

        The tool moves towards the hand until objects stop it.  A hand that leaps some centimetres in one
        step has its tool arrive some steps later.
        """
    def steps(self, poses: ArrayLike) -> Steps:
        """One step after the other, (steps, 3 or 7): as step for each, without Python in between."""

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
