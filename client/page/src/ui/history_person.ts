import {scoreLink} from "../model/local_text";
import {type Key, say, sayNumber} from "../messages/say";
import {sayReason} from "../model/reasons";
import {whenWords} from "../model/words";
import type {HistoryTrial, OwnExercise, PersonHistory} from "../protocol/history_messages";
import {Curve, legend, type Line, lossBars} from "./curve";
import {make, table} from "./elements";
import {criterionName, namedLosses, gradeFigure, gradeWords, titlesOf} from "./history_words";

/// Most suggestions of what to practise next.
const kMostNext = 3;
/// A smaller loss is within the variation between two trials.
const kLeastLoss = 2;

/// A person's history: what to practise next, and for each exercise curve, grade and trials.
export function personHistory(history: PersonHistory, isOwn: boolean): HTMLElement[] {
  const {exercises} = history;
  const titles = titlesOf(exercises);
  if (exercises.length === 0) return [make("p.quiet", say("history.none"))];
  return [
    nextOf(exercises, titles),
    ...exercises.map((exercise) => articleOf(exercise, titles.get(exercise.name)!, isOwn)),
  ];
}

function nextOf(
  exercises: readonly OwnExercise[],
  titles: ReadonlyMap<string, string>,
): HTMLElement {
  const next = exercises
    .flatMap((exercise) =>
      namedLosses(exercise).map((loss) => ({...loss, title: titles.get(exercise.name)!})),
    )
    .filter(({points}) => points >= kLeastLoss)
    .sort((a, b) => b.points - a.points)
    .slice(0, kMostNext)
    .map(({criterion, points, title}) =>
      make(
        "li",
        make("b.cost", say("history.lost", {points: Math.round(points)})),
        make("span.criterion", criterion),
        make("span.quiet", title),
      ),
    );
  return make(
    "section.next",
    make("h3", say("history.next")),
    next.length > 0 ? make("ol", ...next) : make("p.quiet", say("history.no_loss")),
    make("p.quiet", say("history.next_why")),
  );
}

function articleOf(exercise: OwnExercise, title: string, isOwn: boolean): HTMLElement {
  const {grade, pass, trials, spread, done} = exercise;
  const counted = done.filter(({whole, points}) => whole && points !== null);
  const last = counted.slice(-Math.max(1, grade.of));
  const curve = new Curve();
  const words = gradeWords(grade, trials);
  curve.show({
    label: say("history.curve", {title, words}),
    ...{spread, pass},
    own: counted.map(({n, points}) => [n, points!]),
    ...(grade.mean === null
      ? {}
      : {
          grade: {
            ...{from: last[0]!.n, to: last.at(-1)!.n, mean: grade.mean},
            ...{low: grade.low, high: grade.high},
          },
        }),
  });
  const isPassed = pass !== null && grade.mean !== null && grade.mean >= pass;
  const verdict = isPassed ? "exercises.passed" : "exercises.not_yet";
  const keys: [Line, string][] = [
    ["own", say(isOwn ? "history.you" : "history.them")],
    ["interval", say("history.mean")],
  ];
  if (spread.length > 0)
    keys.push(["band", say("history.half")], ["median", say("history.median")]);
  if (pass !== null) keys.push(["pass", say("history.pass")]);
  return make(
    "article",
    make("h3", title),
    make(
      "div.side-by-side",
      make("div", make("h4", say("history.points_over_trials")), curve.body, legend(...keys)),
      make(
        "div",
        make(
          "p.figure",
          make("b", gradeFigure(grade)),
          make(
            "span",
            {className: isPassed ? "verdict good" : "verdict"},
            pass === null || grade.of === 0 ? "" : say(verdict),
          ),
        ),
        make("p.quiet", words),
        ...(grade.of === 0
          ? []
          : [
              make("h4", say("history.loses")),
              lossBars(namedLosses(exercise), say("history.loses")),
            ]),
      ),
    ),
    make(
      "details",
      make("summary", say("history.all_trials", {count: done.length})),
      tableOf(exercise),
    ),
  );
}

function tableOf(exercise: OwnExercise): HTMLElement {
  const {done} = exercise;
  const criteria = [...new Set(done.flatMap(({marks}) => marks.map(({criterion}) => criterion)))];
  const figure = (points: number | null | undefined): HTMLElement =>
    make("td.number", points == null ? "–" : sayNumber(points, 0));
  const rows = [...done].reverse().map((trial) => {
    const how = make("td");
    how.textContent = [
      trial.whole ? "" : say("exercises.not_whole"),
      trial.submitted ? say("exercises.submitted") : "",
      trial.points === null ? sayReason(trial.reason) : "",
    ]
      .filter((word) => word !== "")
      .join(", ");
    const page = make("td");
    if (trial.page !== "")
      page.append(
        make("a", {
          ...{href: scoreLink(trial.page), target: "_blank", textContent: say("exercises.score")},
          ariaLabel: say("history.score_of", {n: trial.n}),
        }),
      );
    return make(
      "tr",
      make("th", {scope: "row"}, String(trial.n)),
      make("td.number", whenWords(trial.begun_s)),
      figure(trial.points),
      page,
      how,
      ...criteria.map((name) =>
        figure(trial.marks.find((mark) => mark.criterion === name)?.points),
      ),
    );
  });
  const heads = [
    "history.trial",
    "history.when",
    "history.points",
    "history.page",
    "history.state",
  ];
  const all = [
    ...heads.map((key) => say(key as Key)),
    ...criteria.map((name) => criterionName(exercise, name)),
  ];
  const region = make("div.table", {tabIndex: 0, role: "region"}, table(all, rows));
  region.ariaLabel = say("history.trials");
  return region;
}
