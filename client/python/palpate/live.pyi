from os import PathLike
from types import TracebackType
from typing import Dict, Iterable, Iterator, List, Optional, Sequence, Type, Union

import numpy
from numpy.typing import ArrayLike, NDArray

from palpate import Effect, Error

tool_dtype: numpy.dtype
wrench_dtype: numpy.dtype

class Silence(Error):
    """No answer (yet): forces are zero.  Temporary; a later call may succeed."""

class Felt:
    """What a hand felt in one millisecond: force and torque at the handle's origin, in the scene's axes."""

    @property
    def force(self) -> NDArray[numpy.float64]:
        """In N, after the limiter."""
    @property
    def torque(self) -> NDArray[numpy.float64]:
        """In N m, after the limiter."""
    @property
    def wanted_force(self) -> NDArray[numpy.float64]:
        """In N, before the limiter."""
    @property
    def wanted_torque(self) -> NDArray[numpy.float64]:
        """In N m, before the limiter."""
    @property
    def hand(self) -> NDArray[numpy.float64]:
        """Pose of the hand: x y z w x y z."""
    @property
    def twist(self) -> NDArray[numpy.float64]:
        """Linear and angular velocity of the hand, in m/s and rad/s."""
    @property
    def tool(self) -> Optional[NDArray[numpy.float64]]:
        """Pose of the proxy (the graphic tool, which enters nothing); None before the first reply."""

class Station:
    """A station whose hand is moved by your program, with the loop, session and limiter of palpate-station.

    The loop runs at 1 kHz in its own threads, which are not real-time.  Your program moves the hand at any
    rate, such as 100 Hz; the hand travels from pose to pose at constant speed, at most 0.5 m/s and 5 rad/s.
    If the server dies, forces are zero within 25 ms, `phase` is "no replies", and `move` raises Silence;
    when a server answers again, the session is resumed.

    scene      name of the scene, as for palpate-station --scene; empty: the server's first
    id         name of the station, as for palpate-station --id: letters, digits and _
    tool       tool of the scene; empty: its only one
    domain, network, peers, identity, transport
               as the options of palpate-station; the identity has the role station and this id
    start      initial pose of the hand; None: as the server says
    max_force, max_torque
               limits of the limiter in N and N m, as in an arm's data sheet.  Give 3 N or more: with a low
               limit the passivity controller suppresses most of a force
    patience   how long to wait for the first answer of a server, in seconds
    """

    def __init__(
        self,
        scene: str = "",
        id: str = "python",
        *,
        tool: str = "",
        domain: int = 0,
        network: str = "lo",
        peers: Sequence[str] = (),
        identity: Union[str, PathLike[str]] = "",
        transport: str = "auto",
        start: Optional[ArrayLike] = None,
        max_force: float = 100.0,
        max_torque: float = 10.0,
        local_model: bool = True,
        patience: float = 10.0,
    ) -> None: ...
    def move(self, pose: ArrayLike, seconds: float = 0.0, *, timeout: float = 1.0) -> Felt:
        """Moves the hand to this pose.  Returns what it feels there, once the server has answered that pose.

        seconds  duration of the motion; longer if the hand would be too fast.  Forces ramp in when a
                 session begins and are slew-limited, so after an instant move they are still rising
        timeout  raise Silence after this many seconds without an answer
        """
    def follow(self, poses: Iterable[ArrayLike], period: float = 0.01, *, timeout: float = 1.0) -> Iterator[Felt]:
        """Moves through the poses, each in `period` seconds, and yields what the hand feels."""
    def set_effect(
        self, effect: Optional[Effect], *, rate_hz: float = 100.0, max_force: float = 1.0, max_torque: float = 0.01
    ) -> None:
        """Adds a force of your own, like Proxy.set_effect.  It is called in a Python thread at that rate, as soon as
        there is a tool; the loop holds it between calls and never waits for it.

        It is limited like the force of a guide, to 1 N and 10 mN m; `wanted_force` includes it unlimited.  Without a
        new call, its wrench ends after four periods, but not before 50 ms.  An exception removes the effect, and is
        raised from set_effect or the next `move`.
        """
    def news(self) -> List[str]:
        """Returns the messages about the session since the last call."""
    def close(self) -> None:
        """Ends the session."""
    @property
    def felt(self) -> Felt:
        """What the hand felt in the newest millisecond."""
    @property
    def phase(self) -> str:
        """One of: asking, held, matching, waiting, tool starts inside, active, muted, no replies, asking again,
        over, closed."""
    @property
    def id(self) -> str: ...
    @property
    def scene(self) -> str: ...
    @property
    def tool(self) -> str: ...
    @property
    def counts(self) -> Dict[str, int]:
        """Numbers of poses sent ("sent"), replies used ("replies") and poses lost ("lost")."""
    def __enter__(self) -> "Station": ...
    def __exit__(
        self, kind: Optional[Type[BaseException]], error: Optional[BaseException], trace: Optional[TracebackType]
    ) -> None: ...

class Session:
    """Listens to the sessions of a server.  Keeps the last minute until it is read; older data is dropped.

    Times are in seconds, as by time.monotonic().  Poses are x y z w x y z, in the scene's frame.

    domain, network, peers, identity, transport
               as the options of palpate-record; the identity has the role viewer, or recorder with wrenches
    wrenches   also receive each wrench of the loop: a thousand per second and station
    patience   default timeout: seconds without data after which Silence is raised
    """

    patience: float
    def __init__(
        self,
        domain: int = 0,
        *,
        network: str = "lo",
        peers: Sequence[str] = (),
        identity: Union[str, PathLike[str]] = "",
        transport: str = "auto",
        wrenches: bool = False,
        patience: float = 5.0,
    ) -> None: ...
    def __iter__(self) -> Iterator[numpy.void]:
        """Yields the tool states of all stations as they arrive, 60 per second and station (tool_dtype)."""
    def tools(self, *, timeout: Optional[float] = None) -> NDArray[numpy.void]:
        """Returns the tool states that arrived since the last call, at least one (tool_dtype)."""
    def wrenches(self, station: str, *, timeout: Optional[float] = None) -> NDArray[numpy.void]:
        """Returns the station's wrenches that arrived since the last call, at least one (wrench_dtype)."""
    def latest_tool(self, station: str) -> Optional[numpy.void]:
        """Returns the station's newest tool state, even if it was returned before; None: there is none."""
    def latest_wrench(self, station: str) -> Optional[numpy.void]:
        """Returns the station's newest wrench, even if it was returned before; None: there is none."""
    def close(self) -> None:
        """Stops listening."""
    @property
    def stations(self) -> Dict[str, str]:
        """Phase of each station: waiting, acquiring, active, held, refused or ended."""
    @property
    def dropped(self) -> int:
        """Number of records that were not read within a minute."""
    def __enter__(self) -> "Session": ...
    def __exit__(
        self, kind: Optional[Type[BaseException]], error: Optional[BaseException], trace: Optional[TracebackType]
    ) -> None: ...
