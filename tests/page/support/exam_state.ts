import {kTestScene} from "./scene_bytes";

const kTitle = {en: "Midterm", de: "Zwischenprüfung"};
export const kExercise = {
  ...{name: "light-force", title: {en: "Light force"}, scene: kTestScene.name, tool: "ball"},
  ...{instruction: {en: "Rest on the floor."}, goal: {en: "Ten seconds"}, pictures: []},
  ...{most_N: 0.245, most_s: 90, trials: 5, pass: 70, guide: [], sources: [], done: [], graded: []},
};

const turn = (phase: string, more: object = {}): object => ({
  ...{phase, scene: kTestScene.name, seat: "", ahead: 0, left_s: 0, waits_s: 0, waited_s: 0},
  ...more,
});
/// Whether a candidate waits for a seat, as their own page receives it.
export const ownTurn = (phase: string, more: object = {}): object => ({
  turn: {...turn(phase, more), works: ["Ben", "Cleo"]},
});

/// The state of an exam as a candidate's page receives it.
export const ownExam = (more: object = {}): object => ({
  open: {
    ...{name: "midterm", title: kTitle, closed: false, left_s: 600, tasks: 3},
    ...{task: 0, trial: 1, trials: 2, time_s: 90, exercise: kExercise, cut: ""},
    ...ownTurn("ready"),
    ...more,
  },
});

export const trialState = (phase: string, more: object = {}): object => ({
  ...{exercise: "light-force", n: 1, phase, reason: "", whole: true, points: null},
  ...{passed: false, submitted: true, page: "", left_s: 90},
  ...more,
});

/// And as the examiner's page does.
export const heldExam = (more: object = {}): object => {
  const trial = {
    task: 0,
    counts: true,
    running: false,
    cut: "",
    sealed: true,
    scored: false,
    points: null,
  };
  const cut = {...trial, task: 1, cut: "the gateway was killed", sealed: false};
  return {
    open: {
      ...{
        name: "midterm",
        title: kTitle,
        closed: false,
        left_s: 600,
        tasks: 2,
        down_s: 41,
        set_by_s: -3600,
      },
      people: [
        {
          ...{
            person: 2,
            name: "Anna",
            task: 2,
            title: {},
            turn: turn("done"),
            trials: [trial, cut],
          },
        },
        {
          ...{person: 3, name: "Ben", task: 1, title: {en: "Caries"}, trials: []},
          turn: turn("waits", {ahead: 2, waits_s: 30, waited_s: 90}),
        },
      ],
      ...more,
    },
    exams: [
      {name: "midterm", title: kTitle, tasks: 2, time_s: 600, wrong: ""},
      {name: "bad.exam.json", title: {}, tasks: 0, time_s: 0, wrong: "bad.exam.json:1: no"},
    ],
    trouble: "",
  };
};
