import {locale, say, sayNumber} from "../messages/say";
import {ownText} from "../model/local_text";
import type {HistoryExercise, TermGrade} from "../protocol/history_messages";

/// By name; one that is gone has no title, and of two with one title each has its name as well.
export function titlesOf(
  exercises: readonly Pick<HistoryExercise, "name" | "title">[],
): ReadonlyMap<string, string> {
  const titles = exercises.map(({name, title}) => ownText(title) || name);
  return new Map(
    exercises.map(({name}, i) => {
      const title = titles[i]!;
      const isOne = titles.filter((other) => other === title).length === 1;
      return [name, isOne ? title : `${title} (${name})`];
    }),
  );
}

/// "78 ± 6": half of the interval where it is of enough trials.
export function gradeFigure({mean, low, high, error, of}: TermGrade): string {
  if (mean === null) return "–";
  if (low === null || high === null || error === null) return sayNumber(mean, 0);
  // The interval ends at 0 and 100; its longer half is the one that is whole.
  const half = Math.max(mean - low, high - mean);
  return of > 0
    ? say("history.plus_minus", {mean: sayNumber(mean, 0), half: sayNumber(half, 0)})
    : "";
}

/// What the figure is, in words.
export function gradeWords({of, low, high}: TermGrade, trials: number): string {
  if (of === 0) return say("history.no_grade");
  const what =
    of < trials ? say("history.mean_of_only", {of, trials}) : say("history.mean_of", {of});
  const sure =
    low === null || high === null
      ? say("history.too_few")
      : say("history.interval", {low: sayNumber(low, 0), high: sayNumber(high, 0)});
  return say("list.sentences", {first: what, second: sure});
}

export const whenWords = (timeS: number): string =>
  new Date(1000 * timeS).toLocaleString(locale(), {dateStyle: "medium", timeStyle: "short"});
