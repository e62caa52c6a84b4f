#!/usr/bin/python3
"""A force of your own, added to that of a cube: a groove along z that attracts the hand."""

import numpy

import palpate

STIFFNESS, DAMPING = 50.0, 2.0  # N/m, N s/m


def groove(hand, twist, tool):
    """Returns minus the gradient of an energy, plus damping; and its Hessian, which acts as a spring between calls."""
    pull = [-STIFFNESS * hand[0] - DAMPING * twist[0], 0, 0]
    return pull, numpy.diag([STIFFNESS, 0, 0])


path = numpy.linspace([0.01, 0.04, 0], [0, 0.028, 0], 1000)  # down to the cube, and into the groove
proxy = palpate.Proxy(palpate.load("cube").model(), path[0])
proxy.set_effect(groove, rate_hz=100)  # for a server's scene: station.set_effect(groove) of palpate.live
for moment, wrench in zip(path[::111], proxy.steps(path).wrench[::111]):
    print(f"{1000 * moment[0]:4.1f} mm beside it: {wrench[0]:6.3f} N to it, {wrench[1]:5.3f} N of the cube")
