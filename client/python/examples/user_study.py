#!/usr/bin/python3
"""A template for user studies: counterbalanced conditions, recorded trials, questions, one table of results.

usage: user_study.py order|run|export STUDY.toml [PARTICIPANT] [-o TABLE.csv] [--domain N] [--transport auto|shm|udp]

  palpate-server ./smooth.json ./rough.json     # the conditions' scenes; in another terminal
  user_study.py order user_study.toml           # the order of trials for each participant
  user_study.py run user_study.toml 3           # participant 3: records each trial, then asks the questions
  user_study.py export user_study.toml -o table.csv

Participants are numbers; do not store their names here.  After an interruption, `run` continues with the trials
that have no answers yet.
"""

import argparse
import csv
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tomllib

import numpy

import palpate


def latin_square(count):
    """Returns orders in which each condition occurs equally often at each place, and after each other condition
    (Williams, Aust. J. Sci. Res. A 2 (1949) 149): as many as conditions, or twice as many if that is odd."""
    first = [(place + 1) // 2 if place % 2 else -(place // 2) for place in range(count)]
    rows = [[(row + step) % count for step in first] for row in range(count)]
    return rows if count % 2 == 0 else rows + [row[::-1] for row in rows]


def trials(study, participant):
    """Returns the trials of a participant (from 1): file without suffix, condition."""
    names = list(study["conditions"])
    orders = latin_square(len(names))
    order = [names[i] for i in orders[(participant - 1) % len(orders)]] * study.get("repeats", 1)
    folder = study["folder"] / f"P{participant:02d}"
    return [(folder / f"{place:02d}-{name}", name) for place, name in enumerate(order, 1)]


def program(name):
    found = shutil.which(name, path=os.environ.get("PALPATE_PROGRAMS"))
    return found or sys.exit(f"{name} is missing: install palpate-tools and palpate-station, or set PALPATE_PROGRAMS")


def record(study, file, participant, condition, network):
    """Records one trial: runs the station for the time that the study gives, and the recorder around it."""
    who = f"P{participant:02d}"
    recorder = subprocess.Popen([program("palpate-record"), "-o", f"{file}.mcap", "--overwrite", "--station", who,
                                 *network], stdout=subprocess.PIPE, text=True)
    try:
        while "recording" not in (line := recorder.stdout.readline()):
            if not line:
                sys.exit("palpate-record has ended; check that a palpate-server is running")
        subprocess.run([program("palpate-station"), *study["station"], "--scene", study["conditions"][condition],
                        "--id", who, "--for", str(study["seconds"]), *network], check=True, stdout=subprocess.DEVNULL)
    finally:
        recorder.send_signal(signal.SIGINT)
        recorder.communicate(timeout=30)


def ask(questions):
    answers = {}
    for name, question in questions.items():
        while name not in answers:
            said = input(f"{question['text']} [{question['least']} to {question['most']}] ")
            if said.lstrip("-").isdecimal() and question["least"] <= int(said) <= question["most"]:
                answers[name] = int(said)
    return answers


def run(study, participant, network):
    for file, condition in trials(study, participant):
        answers = file.with_suffix(".json")
        if answers.exists():
            continue
        file.parent.mkdir(parents=True, exist_ok=True)
        input(f"{file.name}: press Enter to begin {study['seconds']} s ")  # change this to instruct the participant
        record(study, file, participant, condition, network)
        answers.write_text(json.dumps(ask(study["questions"])))


def felt(file):
    """What the table has of a trial: put here what the study is about."""
    # The server may still report the previous trial: a session without data.
    session = next(one for one in palpate.read_recording(f"{file}.mcap").values() if "wrenches" in one)
    wrenches = session["wrenches"]
    force = numpy.linalg.norm([wrenches[f"force_{axis}_N"] for axis in "xyz"], axis=0)
    way = numpy.linalg.norm([numpy.diff(wrenches[f"tool_{axis}_m"]) for axis in "xyz"], axis=0)
    return {"steps": len(force), "touching": (force > 0).mean(), "force_mean_N": force.mean(),
            "force_max_N": force.max(), "way_mm": 1e3 * way.sum()}


def export(study, table):
    rows = []
    for participant in range(1, study["participants"] + 1):
        for place, (file, condition) in enumerate(trials(study, participant), 1):
            if file.with_suffix(".json").exists():
                answers = json.loads(file.with_suffix(".json").read_text())
                rows.append({"participant": participant, "place": place, "condition": condition, **felt(file),
                             **answers})
    if not rows:
        sys.exit(f"{study['folder']}: no trial is done yet; begin with `run`")
    with open(table, "w", newline="", encoding="utf-8") as text:
        writer = csv.DictWriter(text, rows[0], lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    print(f"{table}: {len(rows)} trials")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["order", "run", "export"])
    parser.add_argument("study", type=pathlib.Path)
    parser.add_argument("participant", type=int, nargs="?")
    parser.add_argument("-o", default="table.csv")
    parser.add_argument("--domain", default="0")
    parser.add_argument("--transport", default="auto")
    options = parser.parse_args()
    study = tomllib.loads(options.study.read_text(encoding="utf-8-sig"))
    study["folder"] = options.study.with_suffix("")  # recordings and answers
    everybody = range(1, study["participants"] + 1)
    if options.what == "order":
        for participant in everybody:
            print(f"P{participant:02d}:", ", ".join(name for _, name in trials(study, participant)))
    elif options.what == "export":
        export(study, options.o)
    elif options.participant not in everybody:
        parser.error(f"give a PARTICIPANT from 1 to {study['participants']}")
    else:
        run(study, options.participant, ["--domain", options.domain, "--transport", options.transport])


if __name__ == "__main__":
    main()
