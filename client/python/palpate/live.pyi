from os import PathLike
from types import TracebackType
from typing import Dict, Iterable, Iterator, List, Optional, Sequence, Type, Union

import numpy
from numpy.typing import ArrayLike, NDArray

from palpate import Effect, Error

tool_dtype: numpy.dtype
wrench_dtype: numpy.dtype

class Silence(Error):
    """Nobody answers any more, or yet: forces are zero, and what was asked for may still come."""

class Felt:
    """What a hand was given in a millisecond: force and torque at the handle's origin, in the scene's axes."""

    @property
    def force(self) -> NDArray[numpy.float64]:
        """N, as the limiter let it through."""
    @property
    def torque(self) -> NDArray[numpy.float64]:
        """N m, as the limiter let it through."""
    @property
    def wanted_force(self) -> NDArray[numpy.float64]:
        """Before the limiter."""
    @property
    def wanted_torque(self) -> NDArray[numpy.float64]:
        """Before the limiter."""
    @property
    def hand(self) -> NDArray[numpy.float64]:
        """Where the hand was: x y z w x y z."""
    @property
    def twist(self) -> NDArray[numpy.float64]:
        """The hand's velocity in m/s and its turning in rad/s."""
    @property
    def tool(self) -> Optional[NDArray[numpy.float64]]:
        """Where the graphic tool was, which enters nothing; None before the first reply."""

class Station:
    """A station whose hand a program moves: the loop, the session and the limiter of palpate-station.

    The loop runs at 1 kHz in threads of its own, which are not real-time; a program moves the hand at a
    rate of its own, 100 Hz say, and the hand goes from pose to pose at one speed, 0.5 m/s and 5 rad/s at
    most.  Where the server dies forces are zero within 25 ms, `phase` says "no replies", and `move` raises
    Silence; when a server answers again the session is resumed.

    scene      its name, as palpate-station's --scene; empty: the first that the server has
    name       of the station, as --id: letters, digits and _
    tool       empty: the scene's only one
    domain, network, peers, identity, transport
               as the options of palpate-station; identity is of role station, and of this name
    start      where the hand begins; None: where the server says
    max_force, max_torque
               N and N m: the limiter's figures, as an arm's data sheet gives them; 3 N or more, for the
               passivity controller lets little of a force through where the peak is low
    patience   seconds that the first answer of a server may take
    """

    def __init__(
        self,
        scene: str = "",
        name: str = "python",
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
        """Moves the hand there, and returns what it feels there, once the server has answered that pose.

        seconds  that the way takes; longer where the hand would be too fast.  Forces ramp in when a
                 session begins, and are slew-limited: after a move in no time they are still rising
        timeout  seconds without an answer after which Silence is raised
        """
    def follow(self, poses: Iterable[ArrayLike], period: float = 0.01, *, timeout: float = 1.0) -> Iterator[Felt]:
        """One move after the other, each of `period` seconds."""
    def set_effect(
        self, effect: Optional[Effect], *, rate_hz: float = 100.0, max_force: float = 1.0, max_torque: float = 0.01
    ) -> None:
        """Adds a force of one's own, as Proxy.set_effect: asked in a thread of Python's at that rate, once there is a
        tool, and held in between by the loop, which never waits for it.

        It goes where a guide's force goes: the limiter lets 1 N and 10 mN m of it through, and `wanted_force` has it
        whole.  What is four times as late as it should be, and by 50 ms, acts no more.  What it raises puts it off,
        and comes out of set_effect or the next `move`.
        """
    def news(self) -> List[str]:
        """What was told of the session since the last call, a line each."""
    def close(self) -> None:
        """Leaves the session."""
    @property
    def felt(self) -> Felt:
        """Of the newest millisecond."""
    @property
    def phase(self) -> str:
        """asking, held, matching, waiting, tool starts inside, active, muted, no replies, asking again; over
        or closed."""
    @property
    def name(self) -> str: ...
    @property
    def scene(self) -> str: ...
    @property
    def tool(self) -> str: ...
    @property
    def counts(self) -> Dict[str, int]:
        """Poses sent, replies used, poses lost: "sent", "replies" and "lost"."""
    def __enter__(self) -> "Station": ...
    def __exit__(
        self, kind: Optional[Type[BaseException]], error: Optional[BaseException], trace: Optional[TracebackType]
    ) -> None: ...

class Session:
    """Hears what goes on at a server.  A minute of it is kept for who is busy; what is older is dropped.

    Times are seconds by time.monotonic().  Poses are x y z w x y z, in the scene's frame.

    domain, network, peers, identity, transport
               as the options of palpate-record; identity is of role viewer, or recorder with wrenches
    wrenches   hears each answer of the loop, too: a thousand a second and station
    patience   seconds without anything after which Silence is raised, where no timeout is given
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
        """Each tool's state as it comes, of all stations, 60 a second and station (tool_dtype)."""
    def tools(self, *, timeout: Optional[float] = None) -> NDArray[numpy.void]:
        """The states that came since the last call, at least one (tool_dtype)."""
    def wrenches(self, station: str, *, timeout: Optional[float] = None) -> NDArray[numpy.void]:
        """The station's wrenches that came since the last call, at least one (wrench_dtype)."""
    def latest_tool(self, station: str) -> Optional[numpy.void]:
        """The station's newest state, taken or not."""
    def latest_wrench(self, station: str) -> Optional[numpy.void]:
        """The station's newest wrench, taken or not."""
    def close(self) -> None:
        """Hears no more."""
    @property
    def stations(self) -> Dict[str, str]:
        """By name: waiting, acquiring, active, held, refused or ended, as the server last said."""
    @property
    def dropped(self) -> int:
        """Records that nobody took within a minute."""
    def __enter__(self) -> "Session": ...
    def __exit__(
        self, kind: Optional[Type[BaseException]], error: Optional[BaseException], trace: Optional[TracebackType]
    ) -> None: ...
