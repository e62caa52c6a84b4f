import type {Exercise, LocalText} from "./exercise_messages";

export interface ExamTrial {
  readonly task: number; // from 0
  readonly counts: boolean; // false: it is to be done again
  readonly running: boolean;
  readonly cut: string; // why, where neither its person nor a time ended it
  readonly sealed: boolean;
  readonly scored: boolean; // once the exam is closed
  readonly points: number | null; // null where nothing was touched
}
export interface ExamPerson {
  readonly person: number;
  readonly name: string;
  readonly task: number;
  readonly trials: readonly ExamTrial[];
}
export interface OpenExam {
  readonly name: string;
  readonly title: LocalText;
  readonly closed: boolean;
  readonly left_s: number;
  readonly tasks: number;
  // Of who sits it:
  readonly task?: number; // as many as there are tasks: all is done
  readonly trial?: number;
  readonly trials?: number;
  readonly time_s?: number;
  readonly exercise?: Exercise;
  readonly cut?: string; // why the last trial was cut short; empty: it was not
  // Of who teaches:
  readonly down_s?: number; // for which there was no gateway
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
  readonly open: OpenExam | null; // or the last one, for who teaches
  readonly exams?: readonly ExamFile[];
  readonly trouble?: string;
}
export interface ExamAnswer {
  readonly refusal: string;
}
