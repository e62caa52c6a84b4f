import type {Exercise, LocalText} from "./exercise_messages";

export interface ExamTrial {
  readonly task: number; // from 0
  readonly counts: boolean; // false: it is to be repeated
  readonly running: boolean;
  readonly cut: string; // reason, if it ended neither by its person nor by a time limit
  readonly sealed: boolean;
  readonly scored: boolean; // after the exam is closed
  readonly points: number | null; // null if nothing was touched
}
/// Whether a candidate works, waits for a seat of the task's scene, or may begin.
export interface ExamTurn {
  readonly phase: "ready" | "waits" | "called" | "works" | "done";
  readonly scene: string;
  readonly seat: string; // where they work, or which is kept for them
  readonly ahead: number; // how many wait before them
  readonly left_s: number; // for how long the seat is kept
  readonly waits_s: number; // since when they wait
  readonly waited_s: number; // in all, with that; their exam ends as much later
  readonly works?: readonly string[]; // for a candidate: who works in that scene
}
export interface ExamPerson {
  readonly person: number;
  readonly name: string;
  readonly task: number;
  readonly title: LocalText; // of the task's exercise
  readonly turn: ExamTurn;
  readonly trials: readonly ExamTrial[];
}
export interface OpenExam {
  readonly name: string;
  readonly title: LocalText;
  readonly closed: boolean;
  readonly left_s: number;
  readonly tasks: number;
  // For a candidate:
  readonly task?: number; // in the candidate's own order; the number of tasks: all are done
  readonly trial?: number;
  readonly trials?: number;
  readonly time_s?: number;
  readonly exercise?: Exercise;
  readonly cut?: string; // why the last trial was cut short; empty: it was not
  readonly turn?: ExamTurn;
  // For a teacher:
  readonly down_s?: number; // time without a gateway
  readonly set_by_s?: number; // by how much the computer's clock was set; nobody's time changed
  readonly people?: readonly ExamPerson[];
}
export interface ExamFile {
  readonly name: string;
  readonly title: LocalText;
  readonly tasks: number;
  readonly time_s: number;
  readonly wrong: string;
}
export interface ExamState {
  readonly open: OpenExam | null; // or the last one, for a teacher
  readonly exams?: readonly ExamFile[];
  readonly trouble?: string;
}
export interface ExamAnswer {
  readonly refusal: string;
}
