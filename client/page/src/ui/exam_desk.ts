import {type Key, say} from "../messages/say";
import {ownText} from "../model/local_text";
import {reasonWords, sayReason} from "../model/reasons";
import {clock} from "../model/words";
import type {
  ExamFile,
  ExamPerson,
  ExamState,
  ExamTrial,
  ExamTurn,
  OpenExam,
} from "../protocol/exam_messages";
import {make, press, setText, sure, table} from "./elements";
import {Room} from "./room";
import {followLanguage} from "./spoken";

const kMoreS = 300;

/// The desk where a teacher opens an exam, follows everybody's progress, and closes it.
export class ExamDesk {
  private readonly room = new Room(
    "exam",
    {open: "exam.title", openTitle: "exam.desk_title", title: "exam.title"},
    () => this.open(),
  );
  private readonly clock = make("span.clock", {role: "timer"});
  private readonly running = make("section");
  private readonly files = make("ul.exam-files");
  private readonly waits: {words: HTMLElement; turn: ExamTurn}[] = []; // who has waited
  private drawnS: number | undefined; // page's clock
  private shown = "";
  private drawn = (): void => {}; // draws the same again

  constructor(private readonly wish: (wish: object) => void) {
    this.room.fill({}, this.running, this.files);
    followLanguage(() => this.drawn());
  }

  private open(): void {
    this.wish({op: "look"});
    this.room.open();
  }

  allow(may: boolean): void {
    this.room.allow(may);
  }

  tell(refusal: string): void {
    this.room.tell(reasonWords(refusal), true);
  }

  tick(left: string, nowS: number): void {
    setText(this.clock, say("exam.left", {time: left}));
    this.drawnS ??= nowS;
    for (const {words, turn} of this.waits) {
      const goes = turn.phase === "waits" ? nowS - this.drawnS : 0;
      setText(words, say("exam.waited", {time: clock(Math.floor(turn.waited_s + goes))}));
    }
  }

  show({open, exams = [], trouble = ""}: ExamState): void {
    // Without the changing time, so that the focused element stays.
    const now = JSON.stringify([{...open, left_s: 0}, exams, trouble]);
    if (now === this.shown) return;
    this.shown = now;
    this.tell(trouble);
    this.draw(open, exams);
  }

  private draw(open: ExamState["open"], exams: readonly ExamFile[]): void {
    this.drawn = () => this.draw(open, exams);
    this.waits.length = 0;
    this.drawnS = undefined;
    this.running.replaceChildren(...(open?.people ? this.aboutOf(open, open.people) : []));
    const isOpen = open !== null && !open.closed;
    const rows = exams.map((exam) => this.rowOf(exam, isOpen));
    if (rows.length === 0) rows.push(make("li.quiet", say("exam.none")));
    this.files.replaceChildren(...rows);
  }

  private rowOf({name, title, tasks, time_s, wrong}: ExamFile, isOpen: boolean): HTMLLIElement {
    if (wrong !== "") return make("li.alarm", `${name}: ${sayReason(wrong)}`);
    const about = say("exam.file", {tasks, minutes: Math.round(time_s / 60)});
    const open = ask("exam.open", () => this.wish({op: "open", exam: name}));
    open.disabled = isOpen;
    const text = make("span", make("b", ownText(title)), ` ${name}, ${about}`);
    return make("li", text, open);
  }

  private aboutOf(open: OpenExam, people: readonly ExamPerson[]): HTMLElement[] {
    const {down_s = 0, set_by_s = 0, closed, name} = open;
    const title = make("h3", ownText(open.title));
    const head = ["exam.person", "exam.at", "exam.trials", "exam.do"] as const;
    const rows = people.map((person) => this.personRow(person, open));
    const list = table(
      head.map((key) => say(key)),
      rows,
    );
    if (closed) {
      const verify = `palpate-replay verify-exam COURSE --exam ${name} --key COURSE/exam-key.pub.pem --out certificate`;
      const words = make("p", say("exam.closed"));
      return [title, words, make("pre", verify), list];
    }
    const more = press(
      () => say("exam.more", {minutes: kMoreS / 60}),
      () => this.wish({op: "more", s: kMoreS}),
    );
    const close = ask("exam.close", () => this.wish({op: "close"}));
    const bar = make("p.choices", this.clock, more, close);
    const told: HTMLElement[] = [title];
    if (set_by_s !== 0) told.push(make("p.word", say("exam.clock_set", {seconds: set_by_s})));
    if (down_s === 0) return [...told, bar, list];
    const back = press(
      () => say("exam.give_back", {seconds: down_s}),
      () => this.wish({op: "give_back"}),
    );
    const down = make("p.word", say("exam.down", {seconds: down_s}), " ", back);
    return [...told, down, bar, list];
  }

  private personRow(whose: ExamPerson, open: OpenExam): HTMLElement {
    const {person, name, trials} = whose;
    const {closed} = open;
    const list = make("ul", ...trials.map((trial) => make("li", wordsOf(trial))));
    const choice = make("td");
    if (!closed && trials.some(({counts, running}) => counts && !running))
      choice.append(
        ask("exam.again", () => this.wish({op: "again", person}), {sayTitle: "exam.again_title"}),
      );
    const cells = [this.standing(whose, open), make("td", list), choice];
    const who = make("th", {scope: "row"}, name);
    return make("tr", who, ...cells);
  }

  /// At which task a person is, and whether they work or wait.
  private standing({task, title, turn}: ExamPerson, {closed}: OpenExam): HTMLElement {
    if (turn.phase === "done") return make("td", say("exam.all_done"));
    const at = make("span", `${say("exam.task", {task: task + 1})}: ${ownText(title)}`);
    if (closed) return make("td", at);
    const {scene, seat, ahead} = turn;
    const phase = make("span.turn", say(`exam.turn_${turn.phase}`, {scene, seat, ahead}));
    phase.classList.add(turn.phase);
    const lines = [at, phase];
    if (turn.waited_s > 0 || turn.phase === "waits") {
      const words = make("span.quiet");
      this.waits.push({words, turn});
      lines.push(words);
    }
    return make("td", ...lines);
  }
}

function wordsOf({task, counts, running, cut, sealed, scored, points}: ExamTrial): string {
  const words = [say("exam.task", {task: task + 1})];
  if (running) words.push(say("exam.runs"));
  if (cut !== "") words.push(say("exam.cut", {reason: sayReason(cut)}));
  if (!counts) words.push(say("exam.void"));
  if (sealed) words.push(say("exam.sealed"));
  if (points !== null) words.push(say("exercises.points", {points: Math.round(points)}));
  else if (scored) words.push(say("exercises.no_points"));
  return words.join(", ");
}

const ask = (
  key: "exam.open" | "exam.close" | "exam.again",
  wish: () => void,
  more: {sayTitle?: Key} = {},
): HTMLButtonElement => sure(key, () => say("exam.sure", {what: say(key)}), wish, more);
