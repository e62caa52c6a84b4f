// A class of three in two exercises, as palpate-viewer tells of it.
import type {ClassHistory, OwnExercise, PersonHistory} from "@page/protocol/history_messages";

const kMargin = {en: "Walking along the margin", de: "Am Zahnfleischrand entlang"};
const grade = (of: number, mean: number | null, half?: number) => ({
  ...{of, mean, error: half === undefined ? null : half / 2.5},
  low: half === undefined || mean === null ? null : mean - half,
  high: half === undefined || mean === null ? null : Math.min(100, mean + half),
});
const floor = {criterion: "Floor felt all along", points: 12.4, of: 3};
const force = {criterion: "No more than 25 g", points: 6.1, of: 3};
const spread = [1, 2, 3].map((n) => ({n, people: 3, low: 40 + n, median: 50 + n, high: 70 + n}));
const margin = {name: "margin-walking", title: kMargin, trials: 3, pass: 70, spread};
const gone = {name: "old-one", title: {}, trials: 5, pass: null, spread: [], lost: []};
const did = (points: [number, number][], of: ReturnType<typeof grade>, lost = [floor]) => [
  {exercise: "margin-walking", done: points.length, points, grade: of, lost},
];
const person = (id: number, name: string, done: ClassHistory["people"][number]["did"]) => ({
  ...{person: id, name, role: "drive", here: true, did: done},
});

export const kClassHistory: ClassHistory = {
  exercises: [{...margin, lost: [floor, force]}, {...gone, name: "two", title: kMargin}, gone],
  people: [
    person(2, "Ben", did([[1, 60], [2, 75], [3, 91]], grade(3, 75.3, 38.5))), // prettier-ignore
    person(3, "Zoe", did([[1, 30], [3, 50]], grade(2, 40), [force])), // prettier-ignore
    {...person(4, "Cleo", []), here: false},
  ],
};

const done = (n: number, points: number | null, more: object = {}) => ({
  ...{n, begun_s: 1_795_000_000 + n, points, passed: (points ?? 0) >= 70, whole: true},
  ...{submitted: n === 3, reason: "stopped", page: `key${n}`},
  marks: points === null ? [] : [{criterion: floor.criterion, points}],
  ...more,
});
const exercise: OwnExercise = {
  ...{...margin, lost: [floor, force], grade: grade(3, 75.3, 38.5)},
  done: [
    done(1, 60),
    done(2, 75),
    done(3, 91),
    done(4, null, {whole: false, page: "", reason: "its scoring hung"}),
  ],
};
export const kPersonHistory: PersonHistory = {
  ...{person: 2, name: "Ben", here: true},
  exercises: [exercise, {...gone, lost: [], grade: grade(0, null), done: [done(1, null)]}],
};
