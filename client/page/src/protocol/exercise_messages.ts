// Messages as the gateway writes them.  They are not validated, since only the gateway sends them.

export type LocalText = Readonly<Record<string, string>>;

export interface DoneTrial {
  readonly n: number;
  readonly points: number | null;
  readonly passed: boolean;
  readonly whole: boolean;
  readonly submitted: boolean;
  readonly reason: string;
  readonly page: string; // key of the score page, below /score/; empty: there is none
}
export interface Graded {
  readonly name: LocalText;
  readonly points: number; // of 100, at most
  readonly gates: boolean; // the task: the others count only as far as it is done
  readonly harms: boolean; // the others count only as far as this harm is not done
}
/// A tissue to be spared, and how near to it a bur is warned.
export interface Guard {
  readonly tissue: string;
  readonly within_mm: number;
}
export interface Exercise {
  readonly name: string;
  readonly title: LocalText;
  readonly scene: string;
  readonly tool: string;
  readonly tools?: readonly string[]; // to choose from: it, and other burs of the scene
  readonly serve?: string; // to a teacher: the scene that palpate-server is to be told
  readonly instruction: LocalText;
  readonly pictures: readonly {readonly path: string; readonly text: LocalText}[];
  readonly goal: LocalText;
  readonly most_N: number;
  readonly most_s: number;
  readonly trials: number;
  readonly pass: number;
  readonly graded: readonly Graded[];
  readonly guide: readonly (readonly number[])[]; // keys of the expert's motion; empty: not shown
  readonly guards?: readonly Guard[]; // not in an exam, which gives no hints
  readonly done: readonly DoneTrial[];
}
export interface ExerciseList {
  readonly exercises: readonly Exercise[];
}
export type TrialPhase =
  | "preparing"
  | "running"
  | "ending"
  | "unentered" // its recording is kept, but its end cannot be stored yet
  | "waiting" // for its turn to be scored
  | "scoring"
  | "scored"
  | "unscored"
  | "kept"; // in an exam: stored, and not scored yet
export interface TrialState extends DoneTrial {
  readonly exercise: string;
  readonly phase: TrialPhase;
  readonly left_s: number;
  readonly ahead?: number; // while it waits: the number of trials that are scored before it
}
