"""Poses as the API takes them, x y z w x y z, from what other libraries have."""

import numpy

from palpate._physics import Error

_ORDERS = "give xyzw= or wxyz=, which name it, rotvec= or matrix="
_NEAR = 1e-3  # how far from 1 the squares of a unit vector may add up: common/math/pose_check.h


def numbers(name, given, *shape):
    """Returns finite numbers whose last dimensions are these."""
    try:
        array = numpy.asanyarray(given)
        if array.dtype.kind not in "fiu" or array.itemsize > 8 or numpy.ma.is_masked(array):
            raise ValueError
        array = numpy.asarray(array, dtype=float)
    except (TypeError, ValueError):
        raise Error(f"{name}: is not an array of real numbers of up to 64 bits, none of them masked") from None
    if array.shape[-len(shape):] != shape:
        raise Error(f"{name}: must be an array (..., {', '.join(map(str, shape))}); its shape is {array.shape}")
    if not numpy.isfinite(array).all():
        raise Error(f"{name}: has numbers that are not finite")
    return array


def _unit(name, quaternions):
    squares = (quaternions**2).sum(axis=-1)
    wrong = numpy.abs(squares - 1) >= _NEAR
    if wrong.any():
        raise Error(f"{name}: has a quaternion of length {numpy.sqrt(squares[wrong].flat[0]):g}; it must be 1")
    return quaternions


def _of_xyzw(name, given):
    return _unit(name, numbers(name, given, 4))[..., [3, 0, 1, 2]]


def _of_rotvec(name, given):
    turn = numbers(name, given, 3)
    angle = numpy.linalg.norm(turn, axis=-1, keepdims=True)
    # sin(angle / 2) / angle, which numpy's sinc has without a division by 0
    return numpy.concatenate([numpy.cos(angle / 2), turn * numpy.sinc(angle / (2 * numpy.pi)) / 2], axis=-1)


def _of_matrix(name, given):
    R = numbers(name, given, 3, 3)
    off = numpy.abs(R @ numpy.swapaxes(R, -1, -2) - numpy.eye(3)).max(initial=0)
    if off > _NEAR or (numpy.linalg.det(R) < 0).any():
        raise Error(f"{name}: is no rotation: " + (f"its rows are off by {off:g}" if off > _NEAR else "it mirrors")
                    + "; give orthogonal rows of length 1, right-handed")
    # Four times the outer product of the quaternion with itself; the row of the greatest component loses no digits
    # (Shepperd, J. Guid. Control 1 (1978) 223).
    xx, yy, zz = (R[..., i, i] for i in range(3))
    (xy, yx), (xz, zx), (yz, zy) = ((R[..., i, j], R[..., j, i]) for i, j in ((0, 1), (0, 2), (1, 2)))
    outer = numpy.stack([
        1 + xx + yy + zz, zy - yz, xz - zx, yx - xy,
        zy - yz, 1 + xx - yy - zz, xy + yx, xz + zx,
        xz - zx, xy + yx, 1 - xx + yy - zz, yz + zy,
        yx - xy, xz + zx, yz + zy, 1 - xx - yy + zz], axis=-1).reshape(*xx.shape, 4, 4)
    best = numpy.diagonal(outer, axis1=-2, axis2=-1).argmax(axis=-1)
    q = numpy.take_along_axis(outer, best[..., None, None], axis=-2)[..., 0, :]
    q /= numpy.linalg.norm(q, axis=-1, keepdims=True)
    return numpy.where(q[..., :1] < 0, -q, q)


_MAKERS = {
    "xyzw": _of_xyzw,
    "wxyz": lambda name, given: _unit(name, numbers(name, given, 4)),
    "rotvec": _of_rotvec,
    "matrix": _of_matrix,
}


def _is_rotation(given):
    return hasattr(given, "as_quat")  # scipy's Rotation, which need not be imported


def pose(xyz=(0.0, 0.0, 0.0), rotation=None, *, xyzw=None, wxyz=None, rotvec=None, matrix=None):
    forms = {"xyzw": xyzw, "wxyz": wxyz, "rotvec": rotvec, "matrix": matrix}
    forms = {name: given for name, given in forms.items() if given is not None}
    if len(forms) + (rotation is not None) > 1:
        raise Error(f"pose: has more than one orientation: {', '.join(forms)}; give one")
    if rotation is not None:
        if not _is_rotation(rotation):
            raise Error(f"rotation: is no Rotation of scipy, and four numbers do not say their order; {_ORDERS}")
        forms = {"rotation": rotation}
    name, given = next(iter(forms.items()), ("wxyz", (1.0, 0.0, 0.0, 0.0)))
    if _is_rotation(given):
        q = _of_xyzw(name, given.as_quat())
    elif name == "matrix" and numpy.shape(given)[-2:] == (4, 4):
        whole = numbers(name, given, 4, 4)
        if (whole[..., 3, :] != (0, 0, 0, 1)).any():
            raise Error("matrix: the last row of a pose (4, 4) must be 0 0 0 1")
        if numpy.any(xyz):
            raise Error("matrix: (4, 4) has a position, too; leave out xyz, or give the rotation, (3, 3)")
        xyz, q = whole[..., :3, 3], _of_matrix(name, whole[..., :3, :3])
    else:
        q = _MAKERS[name](name, given)
    xyz = numbers("xyz", xyz, 3)
    try:
        shape = numpy.broadcast_shapes(xyz.shape[:-1], q.shape[:-1])
    except ValueError:
        raise Error(f"pose: {xyz.shape[:-1]} positions and {q.shape[:-1]} orientations do not match; give as many of "
                    "each, or one of either") from None
    return numpy.concatenate([numpy.broadcast_to(xyz, (*shape, 3)), numpy.broadcast_to(q, (*shape, 4))], axis=-1)
