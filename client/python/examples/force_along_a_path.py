#!/usr/bin/python3
"""Force along a path: a ball is drawn over an ellipsoid, whose height and force are known.

usage: force_along_a_path.py [-o PICTURE] [--quick]
"""

import argparse

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy

import palpate

arguments = argparse.ArgumentParser(description=__doc__)
arguments.add_argument("-o", default="force_along_a_path.png", help="picture to write")
arguments.add_argument("--quick", action="store_true", help="fewer steps")
options = arguments.parse_args()

egg = palpate.body("egg", *palpate.ellipsoid([0.03, 0.02, 0.02]))
model = palpate.Model([egg], palpate.ball("ball", 0.004))
steps = 500 if options.quick else 4000
x = numpy.linspace(-0.03, 0.03, steps)
path = numpy.column_stack([x, numpy.full(steps, 0.0215), numpy.zeros(steps)])
felt = palpate.Proxy(model, path[0]).steps(path)

figure, (heights, forces) = plt.subplots(2, 1, sharex=True, figsize=(7, 6))
heights.plot(1e3 * x, 1e3 * path[:, 1], label="hand")
heights.plot(1e3 * felt.pose[:, 0], 1e3 * felt.pose[:, 1], label="tool, which stays outside")
heights.set_ylabel("height of the centre in mm")
heights.legend()
for row, name in enumerate("xyz"):
    forces.plot(1e3 * x, felt.wrench[:, row], label=f"$F_{name}$")
forces.set_xlabel("hand along x in mm")
forces.set_ylabel("force in N")
forces.legend()
figure.tight_layout()
figure.savefig(options.o, dpi=120)
print(f"strongest {numpy.linalg.norm(felt.wrench[:, :3], axis=1).max():.2f} N: {options.o}")
