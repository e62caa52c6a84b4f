#!/usr/bin/python3
"""Friction limit: how hard a ball may be drawn across a rough face before it slips.

usage: friction_limit.py [-o PICTURE] [--quick]
"""

import argparse

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy

import palpate

arguments = argparse.ArgumentParser(description=__doc__)
arguments.add_argument("-o", default="friction_limit.png", help="picture to write")
arguments.add_argument("--quick", action="store_true", help="fewer presses")
options = arguments.parse_args()

MU_S, MU_D = 0.6, 0.4
block = palpate.body("block", *palpate.box([0.06, 0.04, 0.06]), static_friction=MU_S, dynamic_friction=MU_D)
model = palpate.Model([block], palpate.ball("ball", 0.005))
presses = numpy.linspace(0.5e-3, 4e-3, 6 if options.quick else 24)
steps = 3000
paths = numpy.zeros((len(presses), steps, 3))
paths[:, :, 1] = 0.025 - presses[:, None]
paths[:, :, 0] = numpy.linspace(0, 6e-3, steps)
felt = model.follow(paths).wrench

normal = felt[:, -1, 1]
limit = numpy.abs(felt[:, :, 0]).max(axis=1)
sliding = numpy.abs(felt[:, -200:, 0]).mean(axis=1)
figure, axes = plt.subplots(figsize=(7, 5))
axes.plot(normal, limit, "o", label="greatest before it slips")
axes.plot(normal, sliding, "s", label="while it slides")
line = numpy.array([0, normal.max()])
axes.plot(line, MU_S * line, "-", color="C0", lw=0.8, label=r"$\mu_s N$")
axes.plot(line, MU_D * line, "-", color="C1", lw=0.8, label=r"$\mu_d N$")
axes.set_xlabel("normal force in N")
axes.set_ylabel("drag in N")
axes.legend()
figure.tight_layout()
figure.savefig(options.o, dpi=120)
print(f"mu_s {numpy.median(limit / normal):.3f} ({MU_S}), mu_d {numpy.median(sliding / normal):.3f} ({MU_D}): {options.o}")
