#!/usr/bin/python3
"""Speed against error: an ellipsoid felt by more and more spheres, beside the mesh itself.

usage: speed_against_error.py [-o PICTURE] [--quick]

More spheres than a smooth body needs err more again: a sphere is ten times as large as the way to
its neighbour at most, lest all of them come near to whatever touches one.
"""

import argparse
import time

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy

import palpate

arguments = argparse.ArgumentParser(description=__doc__)
arguments.add_argument("-o", default="speed_against_error.png", help="picture to write")
arguments.add_argument("--quick", action="store_true", help="fewer trees")
options = arguments.parse_args()

AXES, RADIUS = numpy.array([0.03, 0.02, 0.02]), 0.004
mesh = palpate.ellipsoid(AXES, 5120 if options.quick else 20480)  # facets are off, too: see the mesh
tool = palpate.ball("ball", RADIUS)
angle = numpy.linspace(0.1, numpy.pi - 0.1, 500 if options.quick else 2000)
surface = numpy.column_stack([AXES[0] * numpy.cos(angle), AXES[1] * numpy.sin(angle), 0 * angle])
normal = surface / AXES**2
normal /= numpy.linalg.norm(normal, axis=1)[:, None]
path = surface + (RADIUS - 1e-3) * normal  # 1 mm deep: the force should be 1 N along the normal


def measure(contact, leaves):
    egg = palpate.body("egg", *mesh, contact=contact, leaves=leaves)
    proxy = palpate.Proxy(palpate.Model([egg], tool, contact=contact), path[0])
    taken = []
    for _ in range(5):  # the best of them: a machine has other work, too
        proxy.restart(path[0])
        began = time.perf_counter()
        force = proxy.steps(path).wrench[:, :3]
        taken.append(time.perf_counter() - began)
    return 1e6 * min(taken) / len(path), numpy.linalg.norm(force - normal, axis=1)[50:].mean()


figure, axes = plt.subplots(figsize=(7, 5))
for leaves in [128, 512] if options.quick else [128, 256, 512, 1024, 2048, 4096]:
    us, error = measure("spheres", leaves)
    axes.loglog(us, error, "o", color="C0")
    axes.annotate(f"{leaves}", (us, error), xytext=(4, 4), textcoords="offset points")
us, error = measure("surface", 512)
axes.loglog(us, error, "s", color="C1")
axes.annotate("mesh", (us, error), xytext=(4, 4), textcoords="offset points")
axes.margins(0.12)
axes.set_title("an ellipsoid by the number of its spheres, and by its mesh")
axes.set_xlabel("time of a step in us")
axes.set_ylabel("mean error of a force of 1 N, in N")
figure.tight_layout()
figure.savefig(options.o, dpi=120)
print(options.o)
