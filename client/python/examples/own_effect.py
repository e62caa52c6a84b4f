#!/usr/bin/python3
"""A force of one's own: a groove along z that draws the hand, beside what a cube gives."""

import numpy

import palpate

STIFFNESS, DAMPING = 50.0, 2.0  # N/m, N s/m


def groove(hand, twist, tool):
    """Of an energy minus the gradient and its Hessian, so that it is a spring in between, too; and a brake."""
    pull = [-STIFFNESS * hand[0] - DAMPING * twist[0], 0, 0]
    return pull, numpy.diag([STIFFNESS, 0, 0])


path = numpy.linspace([0.01, 0.04, 0], [0, 0.028, 0], 1000)  # down to the cube, and into the groove
proxy = palpate.Proxy(palpate.load("cube").model(), path[0])
proxy.set_effect(groove, rate_hz=100)  # for a server's scene: station.set_effect(groove) of palpate.live
for moment, wrench in zip(path[::111], proxy.steps(path).wrench[::111]):
    print(f"{1000 * moment[0]:4.1f} mm beside it: {wrench[0]:6.3f} N to it, {wrench[1]:5.3f} N of the cube")
