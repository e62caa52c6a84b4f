import type {LocalText, TrialState} from "./exercise_messages";

export type Role = "watch" | "drive" | "operate";

export interface Person {
  readonly person: number;
  readonly name: string;
  readonly role: Role;
  readonly station: string;
  readonly here: number; // number of open pages
  readonly seat: string; // a scene; empty: none
  readonly trial?: NewestTrial | null; // of this run of the gateway
}
export interface NewestTrial
  extends Pick<TrialState, "exercise" | "n" | "phase" | "reason" | "points"> {
  readonly title?: LocalText; // missing: the exercise is gone
  readonly ahead: number;
}
/// All people, for operators.
export interface People {
  readonly scene: string; // whose seats are assigned; empty: none are
  readonly people: readonly Person[];
}
/// What a person's page is told about that person.
export interface Me {
  readonly person: number;
  readonly name: string;
  readonly role: Role;
  readonly seat: string;
  readonly line: string;
  readonly lines: number;
  readonly names?: Readonly<Record<string, string>>; // of those who hold tools, by station
}
export interface MadePerson {
  readonly person: number;
  readonly name: string;
  readonly token: string;
}
export interface ClassAnswer {
  readonly tag: number;
  readonly refusal: string;
  readonly note: string;
  readonly people: readonly MadePerson[];
}
