import {say, sayNumber} from "../messages/say";
import {ownText} from "../model/local_text";
import type {CriterionLoss, HistoryExercise, TermGrade} from "../protocol/history_messages";

/// Returns titles by exercise name.  A missing exercise has its name; equal titles get
/// the name added.
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

/// Returns a criterion's name; an exercise that is gone has none in other languages.
export const criterionName = (
  exercise: Pick<HistoryExercise, "criteria"> | undefined,
  criterion: string,
): string => ownText(exercise?.criteria?.[criterion] ?? {}) || criterion;

export const namedLosses = (exercise: HistoryExercise): CriterionLoss[] =>
  exercise.lost.map((loss) => ({...loss, criterion: criterionName(exercise, loss.criterion)}));

/// Returns "78 ± 6", with half of the interval if there are enough trials.
export function gradeFigure({mean, low, high, error, of}: TermGrade): string {
  if (mean === null) return "–";
  if (low === null || high === null || error === null) return sayNumber(mean, 0);
  // The interval is clamped to 0 and 100; its longer half is complete.
  const half = Math.max(mean - low, high - mean);
  return of > 0
    ? say("history.plus_minus", {mean: sayNumber(mean, 0), half: sayNumber(half, 0)})
    : "";
}

/// Explains the figure in words.
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
