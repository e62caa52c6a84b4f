import type {DoneTrial, LocalText} from "./exercise_messages";

/// Answers of `GET /history/…`, with the fields written by client/course/history.cpp.
export interface TermGrade {
  readonly of: number; // number of trials; 0: there is no grade
  readonly mean: number | null;
  readonly error: number | null;
  readonly low: number | null; // 95 % interval, from three trials on
  readonly high: number | null;
}
export interface TrialSpread {
  readonly n: number;
  readonly people: number;
  readonly low: number; // quartiles
  readonly median: number;
  readonly high: number;
}
export interface CriterionLoss {
  readonly criterion: string;
  readonly points: number; // of 100
  readonly of: number; // number of trials or of people
}
export interface HistoryExercise {
  readonly name: string;
  readonly title: LocalText; // empty: the exercise no longer exists
  /// Names of the criteria by that under which marks are stored.
  readonly criteria?: Readonly<Record<string, LocalText>>;
  readonly trials: number; // how many make a grade
  readonly pass: number | null;
  readonly spread: readonly TrialSpread[];
  readonly lost: readonly CriterionLoss[];
}
export interface DoneSeries {
  readonly exercise: string;
  readonly done: number;
  readonly points: readonly (readonly [n: number, points: number])[];
  readonly grade: TermGrade;
  readonly lost: readonly CriterionLoss[]; // the first one only
}
export interface HistoryPerson {
  readonly person: number;
  readonly name: string;
  readonly role: string;
  readonly here: boolean; // not withdrawn
  readonly did: readonly DoneSeries[];
}
export interface ClassHistory {
  readonly exercises: readonly HistoryExercise[];
  readonly people: readonly HistoryPerson[];
}
export interface HistoryTrial extends DoneTrial {
  readonly begun_s: number;
  readonly marks: readonly {readonly criterion: string; readonly points: number}[];
}
export interface OwnExercise extends HistoryExercise {
  readonly done: readonly HistoryTrial[];
  readonly grade: TermGrade;
}
export interface PersonHistory {
  readonly person: number;
  readonly name: string;
  readonly here: boolean;
  readonly exercises: readonly OwnExercise[];
}

/// Fetches a file of the history; undefined if it is not available.  A plain link could send no token.
async function fetched(
  file: string,
  headers: Record<string, string>,
): Promise<Response | undefined> {
  try {
    const response = await fetch(`history/${file}`, {cache: "no-store", headers});
    return response.ok ? response : undefined;
  } catch {
    return undefined;
  }
}

/// @param of "class" or a person's number
export const fetchHistory = async <T>(
  of: string,
  headers: Record<string, string>,
): Promise<T | undefined> =>
  (await (await fetched(`${of}.json`, headers))?.json().catch(() => undefined)) as T | undefined;

/// Saves it; returns false if it is not available.
export async function saveHistory(
  file: string,
  as: string,
  headers: Record<string, string>,
): Promise<boolean> {
  const blob = await (await fetched(file, headers))?.blob().catch(() => undefined);
  if (!blob) return false;
  const href = URL.createObjectURL(blob);
  Object.assign(document.createElement("a"), {href, download: as}).click();
  setTimeout(() => URL.revokeObjectURL(href), 60_000);
  return true;
}
