#!/usr/bin/python3
"""Follows the tools of a running server for a while, and prints what each felt.

usage: follow_live.py [--domain N] [--for SECONDS] [-o COLUMNS.npy]
"""

import argparse
import time

import numpy

from palpate import live

arguments = argparse.ArgumentParser(description=__doc__)
arguments.add_argument("--domain", type=int, default=0, help="number of the domain: the same as the server's")
arguments.add_argument("--transport", default="auto", help="transport of the wrenches: auto, shm or udp")
arguments.add_argument("--for", dest="seconds", type=float, default=10.0, help="duration in seconds; default: 10")
arguments.add_argument("-o", help="file for the last station's wrenches, for numpy.load")
options = arguments.parse_args()

heard, wrenches = {}, {}
with live.Session(options.domain, transport=options.transport, wrenches=True) as session:
    until = time.monotonic() + options.seconds
    for state in session:  # raises palpate.live.Silence if no station is active
        heard.setdefault(state["station"].decode(), []).append(state)
        if time.monotonic() > until:
            break
    for station in heard:
        wrenches[station] = session.wrenches(station)

for station, states in heard.items():
    force = numpy.linalg.norm([state["force_N"] for state in states], axis=1)
    answers = wrenches[station]
    rate = (len(answers) - 1) / numpy.ptp(answers["time_s"])
    print(f"{station}: {len(states)} states, strongest {force.max():.2f} N, {rate:.0f} answers a second")
    if options.o:
        numpy.save(options.o, answers)
