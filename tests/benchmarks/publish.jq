# The reports of tests/benchmarks/publish, as Markdown and CSV, from what palpate-bench has written as JSON.
# Called with all files slurped; $report says which file, $head what was done and where.  Each
# sentence about figures is computed from them.

# ---- numbers as people read them: three digits

def num:
  if type != "number" then "–"
  elif . == 0 then "0"
  else (fabs | log10 | floor) as $e
    | if $e < -4 or $e > 5 then
        (. / pow(10; $e) * 100 | round / 100 | tostring) + "e" + ($e | tostring)
      elif $e >= 2 then round | tostring
      else pow(10; 2 - $e) as $scale | . * $scale | round / $scale | tostring
      end
  end;
def percent: (100 * . | num) + " %";
def cell: tostring | gsub("\\|"; "\\|") | gsub("\n"; " ");
def row: "| " + (map(cell) | join(" | ")) + " |";

# table("lr"; ["a", "b"]): of an array of rows.
def table($align; $head):
  [$head | row]
  + ["|" + ($align / "" | map(if . == "r" then "---:" else "---" end) | join("|")) + "|"]
  + map(row) | join("\n");
# csv(["a", "b"]): of an array of rows, figures with as many digits as people read.
def csv($head): ([$head] + .)[] | map(if type == "number" and . != floor then num | tonumber else . end) | @csv;
def contact: (if . == "spheres" then "sphere" else . end) + " contact";
def unit: sub("^um$"; "µm");
def plural($one): "\(.) \($one)" + (if . == 1 then "" else "s" end);

# ---- what every report begins with

def head($title; $machine):
  $head.load[0] as $load
  | "# \($title)\n\n```sh\n\($head.publish)\n```\n\nwhich runs\n\n```sh\n"
  + ($head.commands | join("\n")) + "\n```\n\n"
  + ([["processor", $machine.cpu], ["cores", $machine.cores], ["SIMD", $machine.simd],
      ["compiler", $machine.compiler], ["build", $head.build], ["begun", $head.begun],
      ["load averages before", ($head.load | map(tostring) | join(" "))]] | table("ll"; ["", ""]))
  + (if $head.smoke then
      "\n\n**A smoke run:** tiny, to try the script. These are no figures to quote." else "" end)
  + (if $load > 0.25 * $machine.cores then
      "\n\n**The machine was not at rest:** a load average of \($load) on "
      + "\($machine.cores | plural("core")) before the first measurement. Times are as long or "
      + "longer than on a quiet machine, p99.9 and raw times most of all: a process may lose its core. Errors do "
      + "not depend on it." else "" end);

# ---- accuracy

def accuracy_rows: [.[] | {object, contact} as $run | (.results // [.])[] | $run + .];
def accuracy_contact($name):
  map(select(.contact == $name)) as $rows
  | if $rows == [] then empty else
      ($rows | max_by(.force_error.strength.max)) as $worst
      | ($rows | map(select(.force_error.strength.max <= 0.06)) | length) as $fine
      | "With \($name | contact) the force's strength is at most "
        + "\($worst.force_error.strength.max | percent) off (\($worst.object), \($worst.spheres) "
        + "spheres) and its direction \($rows | map(.direction_deg.max) | max | num)°; in \($fine) of "
        + "\($rows | length) rows the strength stays within the 6 % that people begin to notice, at "
        + "every sample."
    end;
def accuracy_short:
  map(select(.force_error.strength.max > 0.06)
      | "\(.object), \(.spheres) spheres, \(.contact | contact) (\(.force_error.strength.max | percent))")
  | if length == 0 then "No row passes 6 %."
    else "Short of it: " + join("; ") + "." end;
def accuracy_meshes:
  [.[] | select(.mesh) | .mesh] | unique_by(.triangles)
  | map("The \(.triangles) flat triangles of the ellipsoid's mesh, felt exactly, would be "
        + "\(.force_error.magnitude.max | percent) off at most: an object that is not declared curved "
        + "is felt so.") | join(" ");
def accuracy_csv:
  accuracy_rows
  | map([.object, .contact, .spheres, .felt_triangles]
        + (.force_error | [.magnitude.mean, .magnitude.max, .strength.mean, .strength.max])
        + [.direction_deg.mean, .direction_deg.max, .best_step_us.p50, .best_step_us.p999])
  | csv(["object", "contact", "spheres", "triangles_felt", "error_mean", "error_max", "strength_mean",
         "strength_max", "direction_mean_deg", "direction_max_deg", "best_p50_us", "best_p999_us"]);
def accuracy:
  accuracy_rows as $rows
  | head("Force against the analytic truth"; .[0].machine) + "\n\n"
  + "A ball of 5 mm radius, commanded 1 mm deep at 1 N/mm, slides along a cube of 50 mm side and an "
  + "ellipsoid of semi-axes 40, 25 and 30 mm (the chapter's 2.5.1); \(.[0].steps) samples. The error is "
  + "δF of eq. 2.36, of the true 1 N; *strength* is the part of it that changes how strong the force "
  + "is.\n\n"
  + ([$rows | accuracy_contact("surface", "spheres")] | join(" ")) + " " + ($rows | accuracy_short)
  + "\n\n" + accuracy_meshes + "\n\n"
  + "![Force error against the count of spheres, mean and greatest](accuracy.svg)\n\n"
  + ($rows | map([.object, .contact, .spheres, .felt_triangles,
                  (.force_error.magnitude | .mean, .max | num),
                  (.force_error.strength | .mean, .max | num),
                  (.direction_deg | .mean, .max | num),
                  (.best_step_us | .p50, .p999 | num)])
     | table("llrrrrrrrrrr"; ["object", "contact", "spheres", "triangles felt", "error, mean", "max",
                              "of the strength, mean", "max", "direction, mean [°]", "max",
                              "step, best p50 [µs]", "best p99.9"]));

# ---- stability

def models: "\(.contact | contact), friction \(.friction)";
# A case is held by more than its figure: what it broke is named.
def broken:
  [(if .figure > .bound then
      "\(.figure | num) \(.unit | unit) where \(.bound | num) \(.unit | unit) is the bound" | gsub("  +"; " ")
    else empty end),
   (if .tunnelled > 0 then (.tunnelled | plural("step")) + " tunnelled" else empty end),
   (if .nonfinite > 0 then (.nonfinite | plural("step")) + " not finite" else empty end),
   (if .penetration_um > 10 then "overlap of \(.penetration_um | num) µm" else empty end)]
  | join(", ");
def not_held:
  [.[] | models as $with | .cases[] | select(.held | not) | "`\(.name)` (\($with)): \(broken)"];
def stability_csv:
  [.[] | {contact, friction} as $with | .cases[]
   | [.name, $with.contact, $with.friction, .what, .steps, .figure, .bound, .unit, .penetration_um,
      .tunnelled, .nonfinite, .held]]
  | csv(["case", "contact", "friction", "figure_of", "steps", "figure", "bound", "unit", "overlap_um",
         "tunnelled", "not_finite", "held"]);
# A row for each case, with the figure of each choice of models that has it.
def stability_row($runs):
  . as $case
  | ["`\(.name)`", .what, ("\(.bound | num) \(.unit | unit)" | sub(" $"; ""))]
    + ($runs | map(.cases | map(select(.name == $case.name)) | first
                   | if . == null then "–" elif .held then .figure | num
                     else "**\(.figure | num)**" end));
def stability:
  . as $runs
  | head("Hard cases against their bounds"; .[0].machine) + "\n\n"
  + "Each case holds where its figure keeps its bound, nothing tunnels, every number is finite, and no "
  + "overlap passes 10 µm where a pose without any exists. `palpate-bench stability --list` gives the "
  + "reason of each bound.\n\n"
  + "\(map(.held) | add) of \(map(.total) | add | plural("case")) held over \(map(.steps) | add) steps, "
  + "every choice of models counted: \(map(.tunnelled) | add) steps tunnelled, \(map(.nonfinite) | add) "
  + "were not finite, and the deepest overlap was \(map(.penetration_um) | max | num) µm. "
  + (not_held | if length == 0 then "None fell short."
                else "Short: " + join("; ") + "." end) + "\n\n"
  + "These cases are made to be hard and are all of the project's own; they do not prove that no other "
  + "case fails.\n\n"
  + "**Bold** did not hold; – is not asked of these models. `stability.csv` has the steps, overlap, "
  + "tunnelled and not finite steps of each.\n\n"
  + (reduce $runs[].cases[] as $case ([]; if any(.name == $case.name) then . else . + [$case] end)
     | map(stability_row($runs))
     | table("lll" + ($runs | map("r") | join("")); ["case", "figure of", "bound"] + ($runs | map(
         "\(models): \(.held) of \(.total) held, \(.steps) steps"))));

# ---- qp

def qp:
  (max_by(.best_us.p999)) as $slow
  | (map(select(.best_warm_us.p50 >= .best_us.p50) | .source)) as $no_gain
  | head("The solver alone"; .[0].machine) + "\n\n"
  + "The quadratic problem of each step of a scene's path with sphere contact, solved cold and from the "
  + "rows that the step before had active (*warm*). The residual is the worst violation of the "
  + "optimality conditions, computed anew from the problem, in its own units.\n\n"
  + "The slowest scene is `\($slow.source)`: \($slow.best_us.p999 | num) µs at p99.9 from cold, "
  + "\($slow.best_us.max | num) at most. "
  + (if $no_gain == [] then "A warm start is faster at the median in every scene. "
     else "A warm start is no faster at the median in " + ($no_gain | map("`\(.)`") | join(", ")) + ". "
     end)
  + "Of \(map(.problems) | add) problems \(map(.unsolved) | add) were not solved and "
  + "\(map(.relaxed) | add) contradict themselves and were relaxed; the greatest residual is "
  + "\(map(.kkt_residual_max) | max | num). Only these scenes' problems are measured: other hands give "
  + "others, and contact between meshes is not among them.\n\n"
  + (map(["`\(.source)`", .problems, (.rows | .p50, .max | num), (.best_us | .p50, .p99, .p999, .max | num),
          (.best_warm_us | .p50, .p999, .max | num), (.raw_us.p999 | num), (.kkt_residual_max | num),
          .unsolved, .relaxed])
     | table("lrrrrrrrrrrrrrr"; ["scene", "problems", "rows, p50", "max", "cold, best p50 [µs]", "p99",
                                 "p99.9", "max", "warm, best p50 [µs]", "p99.9", "max",
                                 "cold, raw p99.9 [µs]", "residual, max", "unsolved", "relaxed"]));

# ---- pareto: what stands before the report that palpate-bench has written

# Beside the peers: by speed at p99.9, and by how deep the meshes are in each other.
def peers:
  .peers as $peers
  | [$peers.path[] | select(.available)]
  | (.[] | select(.id == "palpate" and (.name | test("surface")))) as $own
  | map(select(.id != "palpate")) as $others
  | if $others == [] then empty else
      ($others | map(select(.best_step_us.p999 < $own.best_step_us.p999))) as $faster
      | ($others | map(select(.penetration_um.max > $own.penetration_um.max))) as $deeper
      | "On the path of `\($peers.scene)`, \($own.name) takes \($own.best_step_us.p999 | num) µs at p99.9 and "
      + "is \($own.penetration_um.max | num) µm deep at most. "
      + (if $faster == [] then "No peer is faster there" else "Faster there: "
         + ($faster | map("\(.name) (\(.best_step_us.p999 | num) µs, \(.penetration_um.max | num) µm, "
                          + "\(.free_force_N | num) N where the hand is free)") | join(", ")) end)
      + (if $deeper == [] then "; none is deeper. " else "; deeper: " + ($deeper | map(.name) | join(", ")) + ". " end)
    end;

# Where a peer does better than Palpate's surface contact, one row for each figure of a path or slide.
def better($runs; $where; $figure; $unit; $what):
  ($runs[] | select(.id == "palpate" and (.name | test("surface")))) as $own
  | [$runs[] | select(.id != "palpate" and getpath($figure) < ($own | getpath($figure)))] as $others
  | if $others == [] then empty else
      "\($where), \($what): " + ($others | map("\(.name) \(getpath($figure) | num)") | join(", "))
      + " where Palpate has \($own | getpath($figure) | num)\($unit)" end;
def peers_better:
  [.peers.path[] | select(.available)] as $path
  | [.peers.slide[] | select(.available)] as $slide
  | [better($path; "Two bunnies"; ["best_step_us", "p999"]; " µs"; "a step's best p99.9"),
     better($path; "Two bunnies"; ["jump", "force_N_max"]; " N"; "greatest jump of the force"),
     ($slide | map(.object) | unique[] | . as $object | [$slide[] | select(.object == $object)] as $over
      | better($over; "Slide, \($object)"; ["best_step_us", "p999"]; " µs"; "a step's best p99.9"),
        better($over; "Slide, \($object)"; ["force_error", "mean"]; ""; "mean error of the force"),
        better($over; "Slide, \($object)"; ["force_error", "rms"]; ""; "its root mean square"))]
  | if . == [] then "" else "Peers do better than surface contact here:\n\n" + (map("- \(.)\n") | join("")) end;

def peers_page:
  .[0] as $r
  | head("Beside the peers"; $r.machine) + "\n\n"
  + "The same meshes and the same hand through Palpate and through the libraries that researchers step rigid "
  + "bodies with: who enters how far, what a step costs, and what force comes out. " + ([$r | peers] | join(""))
  + "\n\n" + ($r | peers_better);

def pareto:
  .[0] as $r
  | [$r.scenes[] | .scene as $s | .runs[] | select(.available) | {scene: $s} + .] as $runs
  | [$r.goals[] | select(has("figure"))] as $known
  | ($r.goals | map(select(has("figure") | not))) as $unknown
  | ($runs | map(select(.best_step_us.p999 > 1000))) as $slow
  | head("Speed against error"; $r.machine) + "\n\n"
  + (if $runs == [] then "" else
      ($runs | max_by(.best_step_us.p999)) as $slowest
      | "\($runs | length) runs (scene, contact and friction model): a step's best p99.9 is "
      + "\($slowest.best_step_us.p999 | num) µs or less (`\($slowest.scene)`, \($slowest | models)). "
      + (if $slow == [] then "So in each all but one in a thousand steps fit into the millisecond, by their best time; raw "
              + "times, which hold what else the machine did, are not counted here. "
         else "Over a millisecond: "
              + ($slow | map("`\(.scene)`, \(models)") | join("; ")) + ". " end) end)
  + "\($known | map(select(.held)) | length) of \($known | length) figures to reach are held, "
  + "\($unknown | length) not measured (the last table). "
  + ([$r | peers] | join(""))
  + ($r.scenes | map(select(.not_available) | "`\(.scene)`")
     | if length == 0 then "" else "Scenes that were not there: " + join(", ") + "." end);

if $report == "accuracy.md" then accuracy
elif $report == "accuracy.csv" then accuracy_csv
elif $report == "stability.md" then stability
elif $report == "stability.csv" then stability_csv
elif $report == "qp.md" then qp
elif $report == "pareto.md" then pareto
elif $report == "peers.md" then peers_page
else error("no report '\($report)'")
end
