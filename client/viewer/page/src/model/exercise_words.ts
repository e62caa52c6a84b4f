/// What the exercises say.  `{name}` stands for a value.
export const kExerciseWords = {
  open: "Exercises",
  openTitle: "What there is to do, and how you did",
  title: "Exercises",
  close: "Close",
  begin: "Begin",
  beginTitle: "Take the tool: all that you do with it is recorded until you stop",
  stop: "Stop",
  stopTitle: "End this trial, and see how it went",
  submit: "Submit",
  submitTitle: "Hand this trial in",
  submitted: "handed in",
  next: "Next exercise",
  again: "Once more",
  score: "How it went",
  limits: "No more than {force} N, within {time} s",
  limitTime: "Within {time} s",
  trialsOf: "{done} of {all} trials",
  trial: "Trial {n}",
  points: "{points} of 100",
  passed: "passed",
  notYet: "not yet",
  noPoints: "no points",
  notWhole: "not whole",
  notServed: "No server has its scene now.",
  left: "{time} s",
  preparing: "One moment: the recording begins…",
  running: "Go.",
  ending: "The trial ends…",
  scoring: "It is being scored…",
  scored: "{points} of 100: {verdict}",
  unscored: "There is no score: {reason}",
  one: "One trial predicts nothing: what counts is the average.",
} as const;

export function exerciseWord(
  word: keyof typeof kExerciseWords,
  values: Readonly<Record<string, string | number>> = {},
): string {
  return kExerciseWords[word].replace(/\{(\w+)\}/g, (_, name: string) =>
    String(values[name] ?? ""),
  );
}

/// In the reader's language, else in English, else in whatever there is.
export function localText(text: Readonly<Record<string, string>>, language: string): string {
  const [short = ""] = language.split("-");
  return text[language] ?? text[short] ?? text["en"] ?? Object.values(text)[0] ?? "";
}
