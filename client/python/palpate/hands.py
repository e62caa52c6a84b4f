"""Hand paths for studies: poses of a hand, one per millisecond, for Proxy.steps.

    from palpate import hands
    path = hands.generated(palpate.load("bunny-bunny"), seed=7)

A generated path depends only on the scene, the options and the seed.  It is found with the parameters of the scene
file; so it stays the same when a study varies stiffness or friction.
"""

from typing import Optional, Union

import numpy
from numpy.typing import ArrayLike, NDArray

from palpate import Error, Model, Proxy, Scene

_CLEARANCE = 0.005  # m between the bounding spheres of tool and objects when the hand is outside
_STRIDE = 0.001  # m per step of the hand that searches for contact
_LEAST_S = 0.15  # least duration of a movement, in s


def _unit(vector):
    return vector / numpy.linalg.norm(vector)


def _rotated(q, vectors):
    """Rotates vectors by one quaternion, or each by its own."""
    w, u = q[..., :1], q[..., 1:]
    return vectors + 2 * numpy.cross(u, numpy.cross(u, vectors) + w * vectors)


class _Walk:
    """Finds by contact where the tool of a scene touches its objects, and makes a path from these places.  A place
    is the position of the centre of the tool's bounding box, and a quaternion."""

    def __init__(self, scene, tool, model, random, options):
        body = next((body for i, body in enumerate(scene.tools) if tool in (i, body.name)), None)
        if body is None:
            raise Error(f"tool: {tool} is not in the scene; give one of {', '.join(body.name for body in scene.tools)}")
        self.model, self.random, self.options = model or scene.model(tool), random, options
        self.q = body.pose[3:]
        self.middle = (body.vertices.min(axis=0) + body.vertices.max(axis=0)) / 2
        points = [_rotated(each.pose[3:], each.vertices) + each.pose[:3] for each in scene.objects]
        self.points = numpy.concatenate(points) if points else numpy.zeros((0, 3))
        if not len(self.points):
            raise Error(f"{scene.name}: has no object that a hand could touch; add one")
        self.centre = (self.points.min(axis=0) + self.points.max(axis=0)) / 2
        self.outside = _CLEARANCE + numpy.linalg.norm(self.points - self.centre, axis=1).max()
        self.outside += numpy.linalg.norm(body.vertices - self.middle, axis=1).max()
        self.keys = []  # time in s, place
        self.stiffness = self.model.parameters["stiffness_N_per_m"]

    def poses(self, places):
        """Returns the poses of the tool's frame at these places."""
        places = numpy.asarray(places)
        return numpy.concatenate([places[:, :3] - _rotated(places[:, 3:], self.middle), places[:, 3:]], axis=1)

    def go(self, place, speed):
        before = self.keys[-1] if self.keys else (0.0, place)
        seconds = numpy.linalg.norm(place[:3] - before[1][:3]) / speed
        self.keys.append((before[0] + max(_LEAST_S, seconds), place))

    def touch(self, place, towards):
        """Returns where a surface stops the tool on its way, and the surface normal there; None if nothing stops it."""
        far = numpy.arange(0, numpy.linalg.norm(place[:3] - towards) + self.outside, _STRIDE)
        along = _unit(towards - place[:3])
        places = numpy.tile(place, (len(far), 1))
        places[:, :3] += far[:, None] * along
        poses = self.poses(places)
        proxy = Proxy(self.model, poses[0])
        for begin in range(0, len(poses), 20):
            felt = proxy.steps(poses[begin : begin + 20])
            force = numpy.linalg.norm(felt.wrench[:, :3], axis=1)
            stopped = numpy.flatnonzero(force > 0.5 * _STRIDE * self.stiffness)
            if len(stopped):
                first = stopped[0]
                at = felt.pose[first, :3] + _rotated(felt.pose[first, 3:], self.middle)
                return at, felt.wrench[first, :3] / force[first]
        return None

    def visit(self, came_from):
        """Approaches an object from outside, presses, slides there and back, and leaves.  Returns the direction."""
        random, press = self.random, self.options["press_mm"] / 1000
        for _ in range(100):
            direction = _unit(came_from + 0.7 * _unit(random.normal(size=3)))
            turn = numpy.sin(numpy.radians(self.options["turn_deg"]) / 2) * random.uniform()
            q = _unit(self.q + turn * _unit(random.normal(size=4)))
            outside = numpy.concatenate([self.centre + self.outside * direction, q])
            found = self.touch(outside, self.points[random.integers(len(self.points))])
            if found and found[1] @ direction > 0.3:  # otherwise a press would slip past the surface
                break
        else:
            raise Error("hand: found no place on the objects that the tool can reach; give a path of your own")
        at, normal = found
        speed = self.options["speed_mm_per_s"] / 1000
        self.go(outside, 10 * speed)
        self.go(numpy.append(at, q), 4 * speed)
        pressed = at - press * random.uniform(0.5, 1) * normal
        self.go(numpy.append(pressed, q), speed)
        along = random.normal(size=3)
        along = _unit(along - along @ normal * normal) * self.options["slide_mm"] / 1000
        for share in (1, -1, 0):
            self.go(numpy.append(pressed + share * along, q), speed)
        self.go(numpy.append(at, q), speed)
        self.go(outside, 4 * speed)
        return direction


def _between(keys, steps):
    """Interpolates places at each millisecond, with minimum jerk (Flash & Hogan, J. Neurosci. 5 (1985) 1688)."""
    times, places = numpy.array([key[0] for key in keys]), numpy.array([key[1] for key in keys])
    t = numpy.arange(steps) / 1000
    i = numpy.clip(numpy.searchsorted(times, t, "right") - 1, 0, len(times) - 2)
    u = numpy.clip((t - times[i]) / (times[i + 1] - times[i]), 0, 1)
    share = (u**3 * (10 - 15 * u + 6 * u**2))[:, None]
    between = (1 - share) * places[i] + share * places[i + 1]
    between[:, 3:] /= numpy.linalg.norm(between[:, 3:], axis=1)[:, None]  # linear: rotations are small
    return between


def generated(
    scene: Scene,
    *,
    tool: Union[int, str] = 0,
    steps: int = 20000,
    seed: int = 1,
    press_mm: float = 3.0,
    slide_mm: float = 8.0,
    speed_mm_per_s: float = 50.0,
    turn_deg: float = 20.0,
    model: Optional[Model] = None,
) -> NDArray[numpy.float64]:
    """Returns a path that repeatedly approaches an object from outside, presses, slides there and back, and leaves.

    press_mm        largest depth below the point of contact; the least is half of that
    slide_mm        length of the slide to either side
    speed_mm_per_s  speed in contact; the approach is four times as fast
    turn_deg        largest rotation of the tool from its pose in the scene
    model           scene.model(tool), if you have it already, which saves most of the time
    """
    options = {"press_mm": press_mm, "slide_mm": slide_mm, "speed_mm_per_s": speed_mm_per_s, "turn_deg": turn_deg}
    walk = _Walk(scene, tool, model, numpy.random.default_rng(seed), options)
    direction = _unit(walk.random.normal(size=3))
    while not walk.keys or walk.keys[-1][0] < steps / 1000:
        direction = walk.visit(direction)
    walk.keys[0] = (0.0, walk.keys[0][1])
    return walk.poses(_between(walk.keys, steps))


def script(scene: Scene, *, steps: Optional[int] = None) -> NDArray[numpy.float64]:
    """Returns the path supplied with the scene; for more steps it is traversed back and forth."""
    path = scene.path()
    if steps is None:
        return path
    there = numpy.arange(steps) % max(1, 2 * (len(path) - 1))
    return path[numpy.where(there < len(path), there, 2 * (len(path) - 1) - there)]


def trembling(path: ArrayLike, *, um: float, seed: int = 1) -> NDArray[numpy.float64]:
    """Returns the path with a tremor of `um` root mean square per axis: three tones from 8 to 12 Hz."""
    random = numpy.random.default_rng(seed)
    hertz, phase = random.uniform(8, 12, (3, 3)), random.uniform(0, 2 * numpy.pi, (3, 3))
    t = numpy.arange(len(path))[:, None, None] / 1000
    path = numpy.array(path, dtype=float)
    path[:, :3] += 1e-6 * um * numpy.sqrt(2 / 3) * numpy.sin(2 * numpy.pi * hertz * t + phase).sum(axis=2)
    return path
