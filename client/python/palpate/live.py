"""Connects to a running server: listens to its sessions, or acts as a station.

    from palpate import live
    for state in live.Session():                       # 60 per second and station
        print(state["station"].decode(), state["force_N"])

    with live.Station("cube") as station:
        print(station.move([0, 0.03, 0], 0.5).force)   # moves there in half a second

This module needs DDS; palpate itself does not.  Errors are palpate.Error.  One of them, Silence, is
temporary: the server does not answer, and forces are zero.
"""

import atexit
import os
import threading
import time
import weakref

from palpate import Error, _prose

try:
    from palpate import _live
except ImportError as error:  # a wheel contains no libraries
    raise ImportError(f"palpate.live: {error}; on Debian 12: apt-get install libddsc0debian libspdlog1.10 libspnav0 "
                      "libxxhash0") from None
from palpate._live import Felt, Silence, tool_dtype, wrench_dtype

__all__ = ["Felt", "Session", "Silence", "Station", "tool_dtype", "wrench_dtype"]

_open = weakref.WeakSet()


@atexit.register
def _close_all():
    """Closes everything before Python ends, since the threads of DDS must not outlive it."""
    for opened in list(_open):
        opened.close()


def _felt(felt):
    return f"<palpate.live.Felt force {felt.force} N, torque {felt.torque} N m>"


Felt.__repr__ = _felt


class _Opened:
    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


class _Asking(threading.Thread):
    """Calls a station's effect at its rate until `over` is set or the effect raises an exception.

    Between calls it holds neither, so that a station whose effect refers to it can be collected."""

    def __init__(self, station, *terms):
        super().__init__(daemon=True)
        self.over, self.error = threading.Event(), None
        self._station, self._terms = weakref.ref(station), terms

    def _lead(self):
        if (station := self._station()) and not self.over.is_set():
            try:
                station._live.lead(station._effect, *self._terms)
            except BaseException as error:  # raised to the caller that moves the hand
                self.error = error
                self.over.set()
                station._live.lead(None, *self._terms)

    def run(self):
        period, due = 1 / self._terms[0], time.monotonic()
        while not self.over.is_set():
            self._lead()
            due = max(due + period, time.monotonic())  # skips late calls
            self.over.wait(due - time.monotonic())


class Station(_Opened):
    _asking = _effect = None

    def __init__(self, scene="", id="python", *, tool="", domain=0, network="lo", peers=(), identity="",
                 transport="auto", start=None, max_force=100.0, max_torque=10.0, local_model=True, patience=10.0):
        self._live = _live.Station(scene, id, tool, domain, network, list(peers), os.fspath(identity),
                                   transport, start, max_force, max_torque, local_model, patience)
        _open.add(self)

    def move(self, pose, seconds=0.0, *, timeout=1.0):
        self._complain()
        felt = self._live.move(pose, seconds, timeout)
        self._complain()
        return felt

    def follow(self, poses, period=0.01, *, timeout=1.0):
        for pose in poses:
            yield self.move(pose, period, timeout=timeout)

    def set_effect(self, effect, *, rate_hz=100.0, max_force=1.0, max_torque=0.01):
        terms = rate_hz, max_force, max_torque
        if self._asking:
            self._asking.over.set()
            self._asking.join(1)  # does not wait for a function that never returns
            self._asking = None
        self._effect = None
        self._live.lead(effect, *terms)
        if effect is not None:
            self._effect = effect
            self._asking = _Asking(self, *terms)
            weakref.finalize(self, self._asking.over.set)
            self._asking.start()

    def _complain(self):
        if self._asking and (error := self._asking.error):
            self._asking = None
            raise Error(f"the effect is off: {type(error).__name__}: {error}") from error

    def news(self):
        return self._live.news()

    def close(self):
        if not _live.is_forked():
            self.set_effect(None)
        self._live.close()

    def __repr__(self):
        return f"<palpate.live.Station {self.id} in {self.scene}: {self.phase}>"

    felt = property(lambda self: self._live.felt)
    phase = property(lambda self: self._live.phase)
    id = property(lambda self: self._live.id)
    scene = property(lambda self: self._live.scene)
    tool = property(lambda self: self._live.tool)
    counts = property(lambda self: self._live.counts)


class Session(_Opened):
    def __init__(self, domain=0, *, network="lo", peers=(), identity="", transport="auto", wrenches=False,
                 patience=5.0):
        self._live = _live.Session(domain, network, list(peers), os.fspath(identity), transport, wrenches)
        self.patience = patience
        _open.add(self)

    def __iter__(self):
        while True:
            yield from self.tools()

    def tools(self, *, timeout=None):
        return self._live.tools(self.patience if timeout is None else timeout)

    def wrenches(self, station, *, timeout=None):
        return self._live.wrenches(station, self.patience if timeout is None else timeout)

    def latest_tool(self, station):
        return self._live.latest_tool(station)

    def latest_wrench(self, station):
        return self._live.latest_wrench(station)

    def close(self):
        self._live.close()

    def __repr__(self):
        return f"<palpate.live.Session of {self.stations}>"

    stations = property(lambda self: self._live.phases)
    dropped = property(lambda self: self._live.dropped)


_prose.dress(globals(), "live.pyi")
