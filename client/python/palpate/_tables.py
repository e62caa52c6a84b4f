"""Conversion of Steps to pandas and xarray, which are imported only here."""

import importlib

import numpy

_AXES = {3: list("xyz"), 7: ["x", "y", "z", "qw", "qx", "qy", "qz"]}


def _library(name):
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise ImportError(f"{name}: {error}; install it (Debian: python3-{name}), or use the arrays") from None


def _dims(shape):
    return ("path", "step")[2 - len(shape) :]


def _columns(steps):
    """Returns the columns as arrays of shape (..., steps), or with 3 or 7 numbers per step."""
    columns = {"force_N": steps.wrench[..., :3], "torque_Nm": steps.wrench[..., 3:], "tool": steps.pose,
               "contacts": steps.contacts, "faults": steps.faults}
    if steps.details is not None:  # rows are left out, since their number varies
        columns |= {name: steps.details[name] for name in steps.details.dtype.names if name != "rows"}
    return columns


def to_pandas(self):
    pandas, shape = _library("pandas"), self.contacts.shape
    table = {}
    for name, column in _columns(self).items():
        if column.ndim == len(shape):
            table[name] = column.ravel()
        else:
            for i, axis in enumerate(_AXES[column.shape[-1]]):
                table[f"{name}_{axis}"] = column[..., i].ravel()
    index = pandas.MultiIndex.from_product([range(n) for n in shape], names=_dims(shape)) if shape else [0]
    frame = pandas.DataFrame(table, index=index)
    frame.attrs.update(self.parameters)
    return frame


def to_xarray(self):
    xarray, dims = _library("xarray"), _dims(self.contacts.shape)
    names = {3: "axis", 7: "pose"}
    columns = {
        name: (dims if column.ndim == len(dims) else (*dims, names[column.shape[-1]]), numpy.asarray(column))
        for name, column in _columns(self).items()
    }
    return xarray.Dataset(columns, {names[n]: axes for n, axes in _AXES.items()}, self.parameters)
