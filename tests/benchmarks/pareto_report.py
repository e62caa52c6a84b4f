#!/usr/bin/python3
"""usage: tests/benchmarks/pareto_report.py FILE.json

Writes the report of palpate-bench pareto or peers beside its FILE.json: report.md,
FILE.csv with one row per run, and its picture, drawn by plots.py.
"""
import json
import pathlib
import subprocess
import sys

# ---- numbers as people read them


def number(v):
    a = abs(v)
    if a == 0.0:
        return "0"
    if a < 1e-6:
        return "< 1e-6"
    for least, form in ((1e5, ".2e"), (100.0, ".0f"), (10.0, ".1f"), (0.1, ".2f"), (1e-4, ".2g"), (0.0, ".0e")):
        if a >= least:
            return format(v, form)
    return str(v)


def contact_name(contact):
    return ("sphere" if contact == "spheres" else contact) + " contact"


def depth(run, which):
    return number(run["penetration_um"][which]) if "penetration_um" in run else "–"


def best(run, which):
    return number(run["best_step_us"][which]) + ("" if run["repeatable"] else " raw")


# ---- Markdown


def table(align, head, rows):
    rule = ["---:" if a == "r" else "---" for a in align]
    lines = ["| " + " | ".join(cell.replace("|", "\\|").replace("\n", " ") for cell in row) + " |"
             for row in [head, rule, *rows]]
    return "\n".join(lines) + "\n\n"


class Rows:
    """Of what was measured, and a sentence on what was not: a reason is too long for a cell, and often the same
    for several."""

    def __init__(self):
        self.rows, self.refused = [], {}

    def add(self, run, name, cells):
        """`cells` gives a row's cells of what was measured."""
        if run.get("available", True):
            self.rows.append(cells())
        else:
            self.refused.setdefault(run["reason"], []).append(name)

    def text(self, align, head):
        text = table(align, head, self.rows) if self.rows else ""
        for reason, names in self.refused.items():
            text += f"Not available: {'; '.join(names)} ({reason}).\n\n"
        return text or "Not measured.\n\n"


def head(r, only_peers):
    text = f"# {'Palpate beside other libraries' if only_peers else 'Palpate: speed against error'}\n\n"
    every = "" if only_peers else ", for every scene, contact model and friction model"
    text += (f"What one haptic step costs, and how wrong its force and its contact are{every}, beside the libraries that "
             f"are installed. Written by `{r['command']}`.\n\n")
    if r["quick"]:
        text += ("**A quick look:** few scenes, the beginning of each path, few repeats. Leave out `--quick` for figures to "
                 "quote.\n\n")
    if not r["complete"]:
        text += "**Not complete:** the run was ended, or is still going on. What is here is whole.\n\n"
    machine = r["machine"]
    text += "## Machine\n\n" + table("ll", ["", ""], [
        ["processor", machine["cpu"]], ["cores", str(machine["cores"])], ["SIMD", machine["simd"]],
        ["compiler", machine["compiler"]]])
    return text + (
        "Times are in µs. *Best* is the least of each step over identical repeats, and then the percentile over the steps: "
        "it is what the step costs, while raw times also tell what else the machine did.\n\n")


def speed_against_error(r):
    low, high = r["human"]["force_jnd"]
    return ("## Speed against error\n\n![Force error and penetration against the time of a step](pareto.svg)\n\n"
            "Down and to the left is better. A value of 0 lies on the lower edge. People notice a difference of force of "
            f"{100 * low:.0f} to {100 * high:.0f} % (Jones 1989; Pang, Tan & Durlach 1991).\n\n")


def slides(r):
    rows = Rows()
    of_chapter = {("spheres", "cube", 4096): "mean 0.05", ("spheres", "ellipsoid", 512): "max 0.05"}
    for s in r["accuracy"]:
        rows.add(s, f"{s['object']} of {s['triangles']:,} triangles, {s['spheres']:,} spheres, {contact_name(s['contact'])}",
                 lambda: [s["object"], f"{s['spheres']:,}", f"{s['triangles']:,}", s["contact"],
                          number(s["force_error"]["mean"]), number(s["force_error"]["max"]),
                          of_chapter.get((s["contact"], s["object"], s["spheres"]), "–"),
                          number(s["best_step_us"]["p50"]), number(s["best_step_us"]["p999"])])
    return ("## Force error\n\n"
            "The experiment of chapter 2.5.1: a ball of 5 mm radius, commanded 1 mm deep at 1 N/mm, slides along a cube of "
            "50 mm side and along an ellipsoid of semi-axes 40, 25 and 30 mm. The error is that of the force (2.36) against "
            "the analytic object, as a part of 1 N.\n\n" +
            rows.text("lrrlrrlrr", ["object", "spheres", "triangles", "contact", "mean", "max", "chapter", "best p50",
                                    "best p99.9"]))


def scenes(r):
    rows = Rows()
    for s in r["scenes"]:
        name = f"`{s['scene']}`" + (" ¹" if s.get("yields") else "")
        measured = [run for run in s["runs"] if "penetration_um" in run]

        def cells():
            row = [name, f"{s['triangles']:,}", f"{s['steps']:,}"]
            for contact in ("spheres", "surface"):
                run = next((run for run in measured if (run["contact"], run["friction"]) == (contact, "off")), None)
                row += [number(run["best_step_us"]["p50"]), number(run["best_step_us"]["p999"]),
                        depth(run, "max")] if run else ["–"] * 3
            slowest = max((run["best_step_us"]["p999"] for run in measured), default=None)
            return row + ["–" if slowest is None else number(slowest)]

        reason = s.get("not_available") or ("" if s["runs"] else "not measured")
        rows.add({"available": not reason, "reason": reason}, name, cells)
        for run in s["runs"]:
            if not run["available"]:
                rows.add(run, f"{name}, {contact_name(run['contact'])}, friction {run['friction']}", None)
    return ("## Scenes\n\n"
            "Every scene's own path, friction off; *slowest* is the slowest of all contact and friction models, which "
            "`pareto.csv` has one by one. *Deepest* is the penetration of the meshes at the reported pose, on every n-th "
            "step: the deepest vertex inside a closed mesh, or the shortest way that takes two triangles apart, whichever is "
            "more. With sphere contact the meshes may meet where the spheres, which lie inside them, do not yet: that is the "
            "model's error. Objects of scenes with ¹ are soft: what the tool pressed in counts as penetration of the meshes, "
            "which are as they were. Where a scene has no friction of its own, its objects have μ_s 0.8 and μ_d 0.3 where a "
            "friction model is named.\n\n" +
            rows.text("lrrrrrrrrr", ["scene", "triangles", "steps", "spheres: best p50", "p99.9", "deepest [µm]",
                                     "surface: best p50", "p99.9", "deepest [µm]", "slowest, p99.9"]))


def peers(r):
    of = r["peers"]
    text = ("## Peers\n\n"
            "Each in the same run, on the same meshes and hand poses. A peer moves a body of 0.1 kg that a spring and damper "
            "(1000 N/m, 1 N·m/rad, critically damped, 6 degrees of freedom) tie to the hand, one step a millisecond, without "
            "friction and gravity; its force is the spring's. A ball is the peer's own exact sphere. Times hold the peer's "
            "collision detection and its step. Where a peer does not do the same again from a new start, its best times are "
            "raw ones, marked *raw*.\n\n")
    for kind in of["known"]:
        named = f"**{kind['name']} {kind['version']}**"
        text += "- " + (f"**{kind['name']}** {kind['install']}." if not kind["installed"]
                        else f"{named} (`{kind['package']}`): {kind['settings']}." if kind["asked"]
                        else f"{named} was not asked for.") + "\n"
    text += "\n" if of["known"] else ""
    if of["path"]:
        rows = Rows()
        for run in of["path"]:
            rows.add(run, run["name"], lambda: [
                run["name"], best(run, "p50"), best(run, "p999"), *(depth(run, which) for which in ("p50", "p99", "max")),
                *((number(run["force_rms_N"]), number(run["free_force_N"]), number(run["jump"]["force_N_max"]))
                  if "jump" in run else ["–"] * 3)])
        text += f"### The path of `{of['scene']}`\n\n" + rows.text("lrrrrrrrr", [
            "", "best p50", "best p99.9", "penetration p50 [µm]", "p99 [µm]", "max [µm]", "force, RMS [N]",
            "force in free space [N]", "greatest jump [N]"])
        text += (f"{of['steps']:,} steps. *Force in free space* is the mean where the hand's own pose is free: force of a mesh "
                 "that is not there, of a margin, or of inertia; or of a tool caught behind the object.\n\n")
    if of["slide"]:
        rows = Rows()
        for run in of["slide"]:
            rows.add(run, f"{run['object']}, {run['name']}", lambda: [
                run["object"], run["name"], best(run, "p50"), best(run, "p999"),
                *(number(run["force_error"][which]) for which in ("rms", "mean", "max")), depth(run, "max")])
        text += "### A slide with a known force\n\n" + rows.text("llrrrrrr", [
            "object", "", "best p50", "best p99.9", "force error, RMS", "mean", "max", "penetration max [µm]"])
        text += ("A ball of 5 mm radius, commanded 1 mm deep at 1 N/mm, over a cube of 50 mm and over the 20,480 flat "
                 "triangles of an ellipsoid, the same for all; errors are those of the force against the analytic object, as a "
                 "part of 1 N. The hand begins to slide at once, and a peer's body lags behind until its damper has caught up: "
                 "that is its greatest error.\n\n")
    return text


def missed(r):
    rows = []
    for goal in r["goals"]:
        bound, here = goal["bound"], goal.get("figure")
        shown = "–"
        if here is not None:
            # All digits if fewer would hide the difference to its bound.
            alike = here != bound and number(here) == number(bound)
            shown = (repr(here).removesuffix(".0") if alike else number(here)) + goal["unit"]
        rows.append([goal["what"], goal["of"], f"≤ {number(bound)}{goal['unit']}", shown,
                     "not measured" if here is None else "held" if goal["held"] else "**missed**"])
    return ("## Where a figure is missed\n\n" + table("lllrl", ["figure", "of", "bound", "here", ""], rows) +
            "A step's time is its best p99.9; the chapter's are on a 2.2 GHz Core 2.\n\n"
            "Times hold for this machine, and other work on it makes even the best of a few repeats longer; errors are the "
            "same anywhere.\n\n")


def report(r, only_peers):
    if only_peers:
        return head(r, True) + "![Penetration and force error against the time of a step](peers.svg)\n\n" + peers(r)
    return head(r, False) + "".join(section(r) for section in (speed_against_error, slides, scenes, peers, missed))


# ---- CSV: every run, for spreadsheets and plots.py

COLUMNS = ("part,name,contact,friction,tool_spheres,spheres,triangles,steps,repeatable,best_p50_us,best_p999_us,error_mean,"
           "error_max,penetration_p50_um,penetration_p99_um,penetration_max_um,sphere_overlap_um,free_force_N,force_jump_N")


def csv_row(part, name, run, counts):
    def figure(*keys):
        value = run
        for key in keys:
            value = value.get(key, {})
        return "" if value == {} else f"{value:.6g}"

    # Leaves out what is 0 because nobody counted it.
    cells = [part, f'"{name}"', run.get("contact", ""), run.get("friction", ""), *(str(n or "") for n in counts),
             "yes" if run["repeatable"] else "no", *(figure("best_step_us", which) for which in ("p50", "p999")),
             *(figure("force_error", which) for which in ("mean", "max")),
             *(figure("penetration_um", which) for which in ("p50", "p99", "max")), figure("sphere_overlap_um"),
             figure("free_force_N"), figure("jump", "force_N_max")]
    return ",".join(cells)


def csv(r):
    runs = [("slide", s["object"], s, (0, s["spheres"], s["triangles"], 0)) for s in r["accuracy"]]
    for s in r["scenes"]:
        counts = [s.get(count) for count in ("tool_spheres", "object_spheres", "triangles", "steps")]
        runs += [("scene", s["scene"], run, counts) for run in s["runs"]]
    for part, of in (("peer path", "path"), ("peer slide", "slide")):
        runs += [("peer slide on ellipsoid" if run.get("object") == "ellipsoid" else part, run["name"], run, [0] * 4)
                 for run in r["peers"][of]]
    return "\n".join([COLUMNS, *(csv_row(*run) for run in runs if run[2]["available"]), ""])


def main(arguments):
    if len(arguments) != 1 or arguments[0] in ("-h", "--help"):
        print(__doc__.strip())
        return 0 if arguments else 2
    file = pathlib.Path(arguments[0])
    r = json.loads(file.read_text(encoding="utf-8"))
    file.with_name("report.md").write_text(report(r, file.stem == "peers"), encoding="utf-8")
    table_file = file.with_suffix(".csv")
    table_file.write_text(csv(r), encoding="utf-8")
    return subprocess.run([pathlib.Path(__file__).resolve().with_name("plots.py"), table_file], check=False).returncode


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
