#!/usr/bin/python3
"""First force in a scene of the catalogue, or a scene file with a path.  Usage: first_scene.py [SCENE]"""

import sys

import palpate

scene = palpate.load(*(sys.argv[1:] or ["bunny-bunny"]))
path = scene.path()
proxy = palpate.Proxy(scene.model(), path[0])
report = next(report for report in map(proxy.step, path) if report.contacts)
print(scene.tools[0].name, "feels", report.force, "N")
