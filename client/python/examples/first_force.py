#!/usr/bin/python3
"""First force from a mesh file: presses a ball 1 mm into its top.  Usage: first_force.py MESH [UNIT]"""

import sys

import palpate

if len(sys.argv) < 2:
    sys.exit(__doc__)
vertices, triangles = palpate.read_mesh(sys.argv[1], *sys.argv[2:])
thing = palpate.body("thing", vertices, triangles)
model = palpate.Model([thing], palpate.ball("ball", 0.002))
top = vertices[vertices[:, 2].argmax()]
proxy = palpate.Proxy(model, top + [0, 0, 0.003])
for lower in range(200):  # the ball touches at 2 mm above the top; 1 mm further
    report = proxy.step(top + [0, 0, 0.003 - 1e-5 * lower])
print("force", report.force, "N, faults", palpate.fault_words(report.faults))
