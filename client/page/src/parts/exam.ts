import {say, sayList} from "../messages/say";
import {ownText} from "../model/local_text";
import {sayReason} from "../model/reasons";
import {clock} from "../model/words";
import type {ExamAnswer, ExamState, ExamTurn, OpenExam} from "../protocol/exam_messages";
import type {Exercise, TrialPhase, TrialState} from "../protocol/exercise_messages";
import {element, make, press, setText} from "../ui/elements";
import {ExamDesk} from "../ui/exam_desk";
import type {Notice} from "../ui/notice";
import {followLanguage, setWords} from "../ui/spoken";

export interface ExamEvents {
  publish(topic: string, message: object): boolean;
  /// The scene in which an exercise can be done; empty: it is not served.
  served(exercise: Exercise): string;
  /// Takes the tool that the gateway gives for a task.
  begin(ask: () => boolean): void;
  /// Called when it changes whether the page is restricted to an exam.
  changed(): void;
}

const kBusy: ReadonlySet<TrialPhase> = new Set(["preparing", "running", "ending", "unentered"]);

/// An exam: the next task for a candidate, and the examiner's desk.
export class Exam {
  private readonly bar = make("section", {id: "exam-bar", hidden: true});
  private readonly title = make("h2");
  private readonly where = make("span");
  private readonly clock = make("span.clock", {role: "timer"});
  private readonly trialClock = make("span.clock", {role: "timer"});
  private readonly goal = make("p.goal");
  private readonly task = make("div.task");
  private readonly word = make("p.word", {role: "status"});
  private readonly begin = press("exam.begin", () => this.beginTask(), {className: "primary"});
  private readonly handIn = press("exam.hand_in", () => this.handInTrial());
  private readonly desk = new ExamDesk((wish) => this.ask(wish));
  private state: ExamState = {open: null};
  private trial: TrialState | undefined;
  private endsS: number | undefined; // end of the exam, page's clock
  private calledS: number | undefined; // until when a seat is kept
  private trialEndsS: number | undefined;
  private teaches = false;
  private tag = 0;

  constructor(private readonly events: ExamEvents) {
    setWords(this.bar, "ariaLabel", () => say("exam.title"));
    const times = make("p.times", this.where, this.clock, this.trialClock);
    const choices = make("p.choices", this.begin, this.handIn);
    this.bar.append(this.title, times, this.goal, this.task, this.word, choices);
    element("above", HTMLDivElement).append(this.bar);
    followLanguage(() => this.show());
  }

  /// @param teaches  this page may hold an exam
  allow(teaches: boolean): void {
    this.teaches = teaches;
    this.desk.allow(teaches);
  }

  /// Whether this page's person sits an exam, so that nothing else may be done.
  get isOn(): boolean {
    return this.state.open !== null && !this.teaches && !this.state.open.closed;
  }

  /// Force limit of the present task; undefined: there is no task, or no limit.
  get limitN(): number | undefined {
    const most_N = this.isOn ? (this.state.open?.exercise?.most_N ?? 0) : 0;
    return this.trial?.phase === "running" && most_N > 0 ? most_N : undefined;
  }

  /// A trial that ran ended with the last link, at the latest; what runs now the gateway tells.
  linkOpened(): void {
    if (!this.isBusy) return;
    this.trial = this.trialEndsS = undefined;
    setText(this.trialClock, "");
    this.show();
  }

  /// By topic.
  readonly receivers = {
    exam_answer: (value: unknown): void => this.desk.tell((value as ExamAnswer).refusal),
    exam_state: (value: unknown): void => this.receiveState(value as ExamState),
  };
  receiveTrial(trial: TrialState): void {
    this.trial = trial;
    this.trialEndsS = undefined;
    this.show();
  }

  /// Asks whether to hand in the trial: a key pressed by reflex must not end it.  Returns false if
  /// there is no exam.
  askToHandIn(notice: Notice): boolean {
    if (!this.isOn) return false;
    const whileSo = (): boolean => this.isOn && this.isBusy;
    const text = (): string => say("exam.sure", {what: say("exam.hand_in")});
    notice.say(() => say("exam.once"), {whileSo, action: {text, run: () => this.handInTrial()}});
    return true;
  }

  tick(nowS: number): void {
    const {open} = this.state;
    if (!open) return;
    const {turn} = open;
    const stands = !this.teaches && turn?.phase === "waits";
    if (stands || this.endsS === undefined) this.endsS = nowS + open.left_s;
    const left = clock(Math.ceil(this.endsS - nowS));
    if (this.teaches) return this.desk.tick(left, nowS);
    this.calledS ??= nowS + (turn?.left_s ?? 0);
    if (turn?.phase === "called" && !this.isBusy) {
      const time = clock(Math.max(0, Math.ceil(this.calledS - nowS)));
      setText(this.word, say("exam.called", {seat: turn.seat, time}));
    }
    setText(this.clock, say("exam.left", {time: left}));
    const runs = this.trial?.phase === "running";
    if (runs) this.trialEndsS ??= nowS + (this.trial?.left_s ?? 0);
    const ownLeft = runs ? clock(Math.ceil((this.trialEndsS ?? nowS) - nowS)) : "";
    setText(this.trialClock, runs ? say("exam.trial_left", {time: ownLeft}) : "");
    this.begin.hidden = !this.mayBegin(open) || this.endsS <= nowS;
  }

  private receiveState(state: ExamState): void {
    const was = this.isOn;
    this.state = state;
    this.endsS = this.calledS = undefined;
    this.desk.show(state);
    this.show();
    document.body.classList.toggle("in-exam", this.isOn);
    if (was !== this.isOn) this.events.changed();
  }

  private get isBusy(): boolean {
    const phase = this.trial?.phase;
    return phase !== undefined && kBusy.has(phase);
  }

  private show(): void {
    const {open} = this.state;
    this.bar.hidden = !this.isOn;
    if (!open || !this.isOn) return;
    const {exercise} = open;
    setText(this.title, ownText(open.title));
    setText(this.where, whereIn(open));
    const shown = exercise ?? undefined;
    setText(this.goal, shown ? `${ownText(shown.title)}: ${ownText(shown.goal)}` : "");
    this.bar.classList.toggle("works", this.isBusy);
    this.handIn.hidden = this.trial?.phase !== "running";
    this.begin.hidden = !this.mayBegin(open);
    this.task.replaceChildren(...(shown && !this.isBusy ? aboutOf(shown, open) : []));
    setText(this.word, this.wordOf(open));
  }

  private mayBegin({exercise, turn}: OpenExam): boolean {
    return !this.isBusy && exercise !== undefined && turn?.phase !== "waits";
  }

  private wordOf(open: OpenExam): string {
    const {turn} = open;
    const phase = this.trial?.phase;
    if (phase && kBusy.has(phase))
      return say(`exercises.${phase}`, {reason: sayReason(this.trial!.reason)});
    if (turn?.phase === "waits") return waitingWords(turn);
    if (open.cut) return say("exam.cut", {reason: sayReason(open.cut)});
    if (!open.exercise) return say("exam.done");
    if (this.events.served(open.exercise) === "") return say("exercises.not_served");
    return phase === "kept" ? say("exercises.kept") : "";
  }

  private beginTask(): void {
    const exercise = this.state.open?.exercise;
    if (!exercise || this.events.served(exercise) === "") return this.show();
    this.events.begin(() => this.events.publish("trial", {op: "begin", exercise: exercise.name}));
  }

  private handInTrial(): void {
    this.events.publish("trial", {op: "stop"});
  }

  private ask(wish: object): void {
    this.events.publish("exam", {tag: (this.tag += 1), ...wish});
  }
}

function waitingWords({scene, ahead, works = []}: ExamTurn): string {
  const waits = say("exam.waits", {scene, ahead});
  const names = sayList("list.separator", works);
  const who = say("exam.who_works", {names});
  const first = names === "" ? waits : say("list.sentences", {first: waits, second: who});
  return say("list.sentences", {first, second: say("exam.clock_stands")});
}

function whereIn({tasks, task = 0, trial = 1, trials = 1}: OpenExam): string {
  if (task >= tasks) return "";
  const at = say("exam.task_of", {task: task + 1, tasks});
  return trials > 1 ? `${at}, ${say("exam.trial_of", {trial, trials})}` : at;
}

function aboutOf(exercise: Exercise, {time_s = 0}: OpenExam): HTMLElement[] {
  const {most_N: force} = exercise;
  const limits = {force, time: time_s};
  return [
    make("p", ownText(exercise.instruction)),
    ...exercise.pictures.map(({path, text}) => make("img", {src: path, alt: ownText(text)})),
    make("p", say(force > 0 ? "exercises.limits" : "exercises.limit_time", limits)),
    make("p.quiet", say("exam.once")),
  ];
}
