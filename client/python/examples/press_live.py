#!/usr/bin/python3
"""Acts as a station: presses a tool into a scene of a running server in steps of a tenth of a millimetre.

usage: press_live.py [SCENE] [--domain N] [--to X Y Z] [--depth MM]
"""

import argparse

import numpy

from palpate import live

arguments = argparse.ArgumentParser(description=__doc__)
arguments.add_argument("scene", nargs="?", default="cube")
arguments.add_argument("--domain", type=int, default=0, help="number of the domain: the same as the server's")
arguments.add_argument("--transport", default="auto", help="transport of poses and wrenches: auto, shm or udp")
arguments.add_argument("--to", nargs=3, type=float, default=[0, 0.03, 0], help="start of the motion, in m")
arguments.add_argument("--depth", type=float, default=1.0, help="depth to press to, in mm; default: 1")
options = arguments.parse_args()

with live.Station(options.scene, "press", domain=options.domain, transport=options.transport) as station:
    above = numpy.array(options.to)
    station.move(above, seconds=0.5)
    depths = numpy.arange(0, options.depth + 0.05, 0.1)
    try:
        for depth, felt in zip(depths, station.follow(above - [0, 1e-3, 0] * depths[:, None], period=0.02)):
            print(f"{depth:4.1f} mm  {felt.force[1]:6.3f} N")
    except live.Silence as silence:
        print(f"{silence}; the hand feels {numpy.linalg.norm(station.felt.force):.1f} N")
        raise SystemExit(1)
    station.move(above, seconds=0.2)
