#!/usr/bin/python3
"""usage: tests/benchmarks/plots.py FILE...

Draws the pictures of the reports: for each FILE.csv or FILE.json a FILE.svg
beside it, for light and dark pages, in the colours of the web page.  The contents
of the file determine the picture:

  pareto.csv        from palpate-bench pareto: errors and penetration against the
                    time of a step
  peers.csv         from palpate-bench peers: the same, for other libraries only
  accuracy.csv      from tests/benchmarks/publish, or palpate-bench accuracy --json
  closed-loop.json  from palpate-bench closed-loop --out DIR --json: stiffness,
                    energy and limit cycle by delay

Needs matplotlib, which deploy/setup --for tests installs for Debian's python3.
"""
import csv
import itertools
import json
import pathlib
import re
import sys

try:
    import matplotlib
except ImportError:
    sys.exit("plots.py needs matplotlib; install it: sudo apt-get install python3-matplotlib")
matplotlib.use("svg")
import matplotlib.pyplot as plt

# ---- appearance: the page's style sheet, which is installed beside this script

HERE = pathlib.Path(__file__).resolve().parent
STYLE = next(style for style in (HERE / "style.css", HERE / "../../client/page/src/style.css")
             if style.is_file()).read_text(encoding="utf-8")


def theme(selector):
    block = re.search(re.escape("\n" + selector + " {") + "([^}]*)}", STYLE)[1]
    return dict(re.findall(r"--([-\w]+): ([^;]+);", block))


LIGHT = theme(":root")
DARK = LIGHT | theme(':root[data-theme="dark"]')
SERIES = [re.fullmatch(r"var\(--(.+)\)", LIGHT[f"series-{i}"])[1] for i in range(1, 9)]
MARKS = "os^DvPX*"  # so that series differ by more than their colour

plt.rcParams |= {
    "svg.fonttype": "none", "svg.hashsalt": "palpate", "font.size": 10,
    "figure.facecolor": LIGHT["paper"], "axes.facecolor": LIGHT["paper"], "text.color": LIGHT["ink"],
    "axes.labelcolor": LIGHT["ink"], "axes.edgecolor": LIGHT["quiet"], "xtick.color": LIGHT["quiet"],
    "ytick.color": LIGHT["quiet"], "axes.grid": True, "grid.color": LIGHT["line"], "axes.axisbelow": True,
    "lines.linewidth": 1.3, "lines.markersize": 6, "legend.frameon": False, "axes.titleweight": "semibold",
    "axes.titlelocation": "left", "axes.titlesize": 12}


def save(figure, file):
    figure.savefig(file, metadata={"Date": None})
    plt.close(figure)
    # Matplotlib writes each colour where it is used.
    dark = "".join(f'[style*="{what}: {LIGHT[name]}"]{{{what}:{DARK[name]} !important}}'
                   for name in ("paper", "ink", "quiet", "line", *SERIES) for what in ("fill", "stroke"))
    look = f"text{{font-family:{LIGHT['font']} !important}}@media (prefers-color-scheme: dark){{{dark}}}"
    text = file.read_text(encoding="utf-8")
    text = text.replace("<defs>", f"<style>{look}</style><defs>", 1)
    file.write_text(re.sub(r"\s*\n\s*", " ", text).replace('<g id="axes_', '\n<g id="axes_') + "\n", encoding="utf-8")


# ---- parts of pictures

class Picture:
    """Plots one below the other, each with a legend between its title and its frame."""

    def __init__(self, count, height=2.9):
        self.figure, axes = plt.subplots(count, 1, figsize=(10, (height + 0.9) * count), squeeze=False,
                                         layout="constrained")
        self.figure.set_constrained_layout_pads(w_pad=0.15, h_pad=0.12)
        self.axes = iter(axes[:, 0])

    def plot(self, title, x, y, log="", bottom=None):
        axis = next(self.axes)
        axis.set(title=title, xlabel=x, ylabel=y)
        for name, scale in (("x", axis.set_xscale), ("y", axis.set_yscale)):
            if name in log:
                scale("log")
                ticks = getattr(axis, f"{name}axis")
                ticks.set_major_formatter(lambda value, _: f"{value:,.5f}".rstrip("0").rstrip("."))
                ticks.set_minor_locator(matplotlib.ticker.NullLocator())
        return Plot(axis, bottom)


class Plot:
    def __init__(self, axis, bottom):
        self.axis, self.bottom, self.looks, self.labels = axis, bottom, zip(SERIES, MARKS), []

    def series(self, name, points, style="-"):
        """points: (x, y) or (x, y, label); a y below the lower edge lies on it."""
        if not points:
            return
        colour, marker = next(self.looks)
        x, y = ([point[i] for point in points] for i in (0, 1))
        if self.bottom is not None:
            y = [max(value, self.bottom) for value in y]
        self.axis.plot(x, y, linestyle=style, marker=marker, color=LIGHT[colour], label=name,
                       markeredgecolor=LIGHT["paper"], markeredgewidth=0.5, clip_on=False, zorder=3)
        self.labels += [(x[i], y[i], point[2]) for i, point in enumerate(points) if len(point) > 2]

    def noticed(self):
        self.axis.axhspan(0.06, 0.08, color=LIGHT["line"], label="people begin to notice: 6 to 8 %")

    def line(self, name, style, **at):
        value, = at.values()
        draw = self.axis.axhline if "y" in at else self.axis.axvline
        draw(value, color=LIGHT["quiet"], linestyle=style, linewidth=1.1, label=name)

    def done(self):
        if self.bottom is not None:
            self.axis.set_ylim(bottom=self.bottom)
        for ticks, (low, high) in ((self.axis.xaxis, self.axis.get_xlim()), (self.axis.yaxis, self.axis.get_ylim())):
            if ticks.get_scale() == "log" and high < 3000 * low:
                ticks.set_major_locator(matplotlib.ticker.LogLocator(subs=(1, 2, 5)))
        names = self.axis.get_legend_handles_labels()[1]
        columns = 3 if max(map(len, names)) < 40 else 2
        self.axis.legend(loc="lower left", bbox_to_anchor=(-0.01, 1.0), ncols=columns, borderaxespad=0.2,
                         columnspacing=1.5).set_in_layout(False)
        self.axis.set_title(self.axis.get_title("left"), pad=10 + 15.5 * -(-len(names) // columns))
        return self

    def write_labels(self):
        """Beside each point where there is room: not on another label, mark or line, else nowhere."""
        figure = self.axis.figure
        figure.canvas.draw()
        frame = self.axis.get_window_extent()
        marks = [self.axis.transData.transform(label[:2]) for label in self.labels]
        taken = [matplotlib.transforms.Bbox.from_bounds(x - 4, y - 4, 8, 8) for x, y in marks]
        for line in self.axis.lines:
            if line.get_linestyle() == "-" and line.get_marker() != "None":
                path = line.get_transform().transform_path(line.get_path()).interpolated(40)
                taken += [matplotlib.transforms.Bbox.from_bounds(x, y, 1, 1) for x, y in path.vertices]
        for x, y, text in self.labels:
            for dx, dy in itertools.product((1, -1, 0), (0, 1, -1)):
                label = self.axis.annotate(
                    text, (x, y), xytext=(7 * dx if dy == 0 else 5 * dx, 7 * dy if dx == 0 else 6 * dy),
                    textcoords="offset points", fontsize=8.5, va=("center", "bottom", "top")[dy],
                    ha=("center", "left", "right")[dx])
                box = label.get_window_extent().padded(1)
                inside = frame.x0 < box.x0 and box.x1 < frame.x1 and frame.y0 < box.y0 and box.y1 < frame.y1
                if (dx or dy) and inside and not any(box.overlaps(other) for other in taken):
                    taken.append(box)
                    break
                label.remove()


def contact(name):
    return {"spheres": "sphere contact"}.get(name, f"{name} contact")


def thousands(number):
    return f"{int(number):,}"


# ---- pictures

def pareto(rows):
    slides, scenes = ([row for row in rows if row["part"] == part] for part in ("slide", "scene"))
    by_time = "Step, best p99.9 [µs]"
    picture = Picture(3, 3.4)
    plots = []
    for which, name, chapter, bound in (("mean", "mean", "chapter: cube, 4,096 spheres", 0.05),
                                        ("max", "greatest", "chapter: ellipsoid, 512 spheres", 0.05)):
        plot = picture.plot(f"Force error, {name}: a ball of 5 mm slides with 1 N; labels are spheres", by_time,
                            "Error [of 1 N]", "xy", 1e-5)

        def points(chosen, label, which=which):
            return [(row["best_p999_us"], row[f"error_{which}"], label(row)) for row in chosen]

        own = [row for row in slides if row["triangles"] not in (5120, 81920)]
        for thing, kind in itertools.product(("cube", "ellipsoid"), ("spheres", "surface")):
            plot.series(f"{thing}, {contact(kind)}",
                        points([row for row in own if row["name"] == thing and row["contact"] == kind],
                               lambda row: thousands(row["spheres"])))
        plot.series("the same, 512 spheres, other mesh", points(
            [row for row in slides if row not in own], lambda row: thousands(row["triangles"]) + " triangles"), "none")
        plot.series("peers, cube", points(
            [row for row in rows if row["part"] == "peer slide" and not row["name"].startswith("Palpate")],
            lambda row: row["name"]), "none")
        plot.noticed()
        plot.line(chapter, "--", y=bound)
        plots.append(plot.done())
    plot = picture.plot("Penetration of the meshes, friction off", by_time, "p99 of the steps [µm]", "xy", 1e-3)
    for kind in ("spheres", "surface"):
        plot.series(contact(kind), [(row["best_p999_us"], row["penetration_p99_um"], row["name"]) for row in scenes
                                    if row["contact"] == kind and row["friction"] == "off"],
                    "none")
    plot.series("peers, bunny-bunny", [
        (row["best_p999_us"], row["penetration_p99_um"], row["name"]) for row in rows
        if row["part"] == "peer path" and not row["name"].startswith("Palpate") and row["penetration_p99_um"] != ""],
        "none")
    plot.line("1 ms", "-", x=1000)
    plot.line("chapter: bunnies, 1.5 ms", ":", x=1500)
    plot.line("goal: 10 µm", "--", y=10)
    plots.append(plot.done())
    for plot in plots:
        plot.write_labels()
    return picture


def peers(rows):
    picture = Picture(2, 3.4)
    plots = []
    for title, y, key, parts in (
            ("Penetration of the meshes on the path of two bunnies, greatest", "µm", "penetration_max_um",
             {"peer path": ""}),
            ("Force error, mean: a ball slides with 1 N over a cube and an ellipsoid", "Error [of 1 N]", "error_mean",
             {"peer slide": "cube", "peer slide on ellipsoid": "ellipsoid"})):
        plot = picture.plot(title, "Step, best p99.9 [µs]", y, "xy", 1e-3 if len(parts) == 1 else 1e-5)
        shown = [row for row in rows if row["part"] in parts and row[key] != ""]
        for name, run in itertools.groupby(sorted(shown, key=lambda row: row["name"]), lambda row: row["name"]):
            plot.series(name, [(row["best_p999_us"], row[key], parts[row["part"]]) for row in run], "none")
        if len(parts) == 2:
            plot.noticed()
        plots.append(plot.done())
    for plot in plots:
        plot.write_labels()
    return picture


def accuracy(rows):
    picture = Picture(2)
    for which, name in (("mean", "mean"), ("max", "greatest")):
        plot = picture.plot(f"Force error, {name}: a ball of 5 mm slides with 1 N over a cube and an ellipsoid",
                            "Spheres of the object's tree", "|δF| of eq. 2.36 [of 1 N]", "xy", 1e-4)
        for (thing, kind), run in itertools.groupby(rows, lambda row: (row["object"], row["contact"])):
            plot.series(f"{thing}, {contact(kind)}", [(row["spheres"], row[f"error_{which}"]) for row in run])
        plot.noticed()
        plot.done()
    return picture


def closed_loop(run):
    picture = Picture(4, 2.4)
    at = f" at {run['stiffness_N_per_m']:g} N/m"
    for title, y, key, log in (
            ("Stiffest stable coupling", "Stiffness [N/m]", "max_stable_stiffness_N_per_m", "y"),
            ("The most that the hand is held by", "Stiffness [N/m]", "felt_stiffness_N_per_m", "y"),
            ("Energy that the hand was given" + at, "Energy [J]", "energy_J", ""),
            ("Limit cycle" + at, "Peak to peak [mm]", "limit_cycle_mm", "")):
        plot = picture.plot(f"{title}: {run['scene']}, hand {run['hand']}, jitter {run['jitter_ms']:g} ms, "
                            f"loss {run['loss']:g}", "Delay, there and back [ms]", y, log)
        for curve in run["z_width"]:
            on = {True: "on", False: "off"}
            plot.series(f"local model {on[curve['local_model']]}, passivity controller {on[curve['passivity']]}",
                        list(zip(curve["delay_ms"], curve[key])))
        plot.done()
    return picture


# ---- files

def number(cell):
    try:
        return float(cell)
    except ValueError:
        return cell


def picture_of(file):
    if file.suffix == ".csv":
        with file.open(encoding="utf-8") as lines:
            rows = [{key: number(cell) for key, cell in row.items()} for row in csv.DictReader(lines)]
        for column, draw in (("part", pareto), ("object", accuracy)):
            if rows and column in rows[0]:
                alone = column == "part" and all(str(row["part"]).startswith("peer") for row in rows)
                return peers(rows) if alone else draw(rows)
    elif file.suffix == ".json":
        run = json.loads(file.read_text(encoding="utf-8"))
        if "z_width" in run:
            return closed_loop(run)
        if "object" in run:
            return accuracy([{"object": run["object"], "contact": run["contact"], "spheres": row["spheres"],
                              "error_mean": row["force_error"]["magnitude"]["mean"],
                              "error_max": row["force_error"]["magnitude"]["max"]}
                             for row in run.get("results", [run])])
    sys.exit(f"{file}: is nothing that plots.py draws; see --help")


def main(arguments):
    if not arguments or arguments[0] in ("-h", "--help"):
        print(__doc__.strip())
        return 0 if arguments else 2
    for name in arguments:
        file = pathlib.Path(name)
        if not file.is_file():
            sys.exit(f"{file}: cannot be opened; name a CSV or JSON of palpate-bench")
        save(picture_of(file).figure, file.with_suffix(".svg"))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
