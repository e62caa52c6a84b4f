import {say} from "../messages/say";
import {Guide} from "../model/guide";
import {ownText, scoreLink} from "../model/local_text";
import {sayReason} from "../model/reasons";
import {partWords} from "../model/words";
import type {Pose, Vec3} from "../base/pose";
import type {
  DoneTrial,
  Exercise,
  ExerciseList,
  Graded,
  Guard,
  TrialState,
} from "../protocol/exercise_messages";
import {element, make, press, setOptions, setText} from "../ui/elements";
import {Room} from "../ui/room";
import {followLanguage, setWords} from "../ui/spoken";

export interface ExerciseEvents {
  publish(message: object): boolean;
  /// The scene in which an exercise can be done; empty: it is not served.
  served(exercise: Exercise): string;
  /// The person's seat; empty: none.
  seat(): string;
  /// The number of people who are to have seats.
  students(): number;
  begin(scene: string, tool: string, ask: () => boolean): void;
}

function verdictOf(trial: DoneTrial): string {
  const passed = trial.passed ? "exercises.passed" : "exercises.not_yet";
  return (
    say(trial.points === null ? "exercises.no_points" : passed) +
    (trial.whole ? "" : `, ${say("exercises.not_whole")}`)
  );
}

function gradedWords({name, points, gates, harms}: Graded): string {
  const key = gates ? "exercises.task" : harms ? "exercises.harm" : "exercises.care";
  return say(key, {name: ownText(name), points: Math.round(points)});
}

/// The exercises, the running trial, and its result.
export class Exercises {
  private readonly room = new Room(
    "exercises",
    {open: "exercises.open", openTitle: "exercises.open_title", title: "exercises.title"},
    () => this.open(),
  );
  private readonly list = make("ul.list");
  private readonly about = make("div.about");
  private readonly server = make("div.server");
  private readonly bar = make("section", {id: "trial-bar", hidden: true});
  private readonly what = make("b");
  private readonly word = make("span", {role: "status"});
  private readonly clock = make("span.clock");
  private readonly stop = press("exercises.stop", () => void this.events.publish({op: "stop"}));
  private readonly submit = press("exercises.submit", () => this.handIn(this.trial));
  private readonly guided = press("exercises.guide", () => this.showGuide(!this.wantsGuide));
  private readonly score = make("a", {target: "_blank", say: "exercises.score"});
  private readonly tool = make("select");
  private readonly toolPick = make("label", () => `${say("exercises.with")} `, this.tool);
  private readonly again = press("exercises.again", () => this.beginShownText());
  private readonly next = press("exercises.next", () => this.showNext());
  private exercises: readonly Exercise[] = [];
  private shown = "";
  private trial: TrialState | undefined;
  private endsS: number | undefined; // end of the trial, page's clock
  private wantsGuide = false;
  private guide: Guide | undefined; // of the running trial

  constructor(private readonly events: ExerciseEvents) {
    this.room.fill({}, this.server, make("div.columns", this.list, this.about));
    setWords(this.bar, "ariaLabel", () => say("exercises.title"));
    const {what, word, clock, guided, stop, submit, score, again, next} = this;
    setWords(guided, "title", () => say("exercises.guide_title"));
    this.bar.append(what, word, clock, guided, stop, submit, score, again, next);
    element("above", HTMLDivElement).append(this.bar);
    followLanguage(() => this.showAll());
  }

  /// @param may  this page may do exercises
  allow(may: boolean): void {
    this.room.allow(may);
  }

  /// A trial that ran ended with the last link, at the latest; what runs now the gateway tells.
  linkOpened(): void {
    if (this.isBusy) this.receiveTrial(undefined);
  }

  receiveList({exercises}: ExerciseList): void {
    this.exercises = exercises;
    this.showAll();
  }
  receiveTrial(trial: TrialState | undefined): void {
    this.trial = trial;
    this.endsS = undefined;
    this.showAll();
  }
  private showAll(): void {
    this.showBar();
    if (this.room.isOpen) this.show();
  }

  tick(nowS: number): void {
    const {trial} = this;
    if (trial?.phase !== "running") return setText(this.clock, "");
    this.endsS ??= nowS + trial.left_s;
    const time = Math.max(0, Math.ceil(this.endsS - nowS));
    setText(this.clock, say("exercises.left", {time}));
  }

  get runs(): boolean {
    return this.trial?.phase === "running";
  }

  /// Force limit of the running trial; undefined: none runs, or it has no limit.
  get limitN(): number | undefined {
    if (!this.runs) return undefined;
    const most_N = this.exercises.find(({name}) => name === this.trial?.exercise)?.most_N ?? 0;
    return most_N > 0 ? most_N : undefined;
  }

  /// What is to be spared in a scene, or a seat of it: by the running trial's exercise, or by all
  /// that are done there.
  guardsIn(scene: string): readonly Guard[] {
    const own = this.exercises.find(({name}) => this.runs && name === this.trial?.exercise);
    const of = scene.replace(/-\d+$/, "");
    const here = this.exercises.filter((one) => one.scene === scene || one.scene === of);
    const guards = (own ? [own] : here).flatMap(({guards = []}) => guards);
    return guards.filter(({tissue}, i) => guards.findIndex((one) => one.tissue === tissue) === i);
  }

  /// Returns the expert's tool for a hand that follows it; undefined: it is not shown.
  lead(nowS: number, hand: Vec3 | undefined): Pose | undefined {
    const {guide} = this;
    return this.wantsGuide && guide && !guide.isOver ? guide.lead(nowS, hand) : undefined;
  }

  private showGuide(wants: boolean): void {
    this.wantsGuide = wants;
    this.showBar();
  }

  private open(): void {
    if (this.shown === "") {
      const served = this.exercises.find((exercise) => this.events.served(exercise) !== "");
      this.shown = (served ?? this.exercises[0])?.name ?? "";
    }
    this.show();
    this.room.open();
  }

  private show(): void {
    const items = this.exercises.map((exercise) => {
      const done = exercise.done.filter(({points}) => points !== null).length;
      const pick = make(
        "button",
        {type: "button", onclick: () => this.choose(exercise.name)},
        make("b", ownText(exercise.title)),
        make("span.quiet", say("exercises.trials_of", {done, all: exercise.trials})),
        make("span.quiet", this.placeOf(exercise)),
      );
      pick.setAttribute("aria-pressed", String(exercise.name === this.shown));
      pick.classList.toggle("absent", this.events.served(exercise) === "");
      return make("li", pick);
    });
    this.list.replaceChildren(...items);
    this.server.replaceChildren(...this.aboutServer());
    const exercise = this.exercises.find(({name}) => name === this.shown);
    if (exercise) this.about.replaceChildren(...this.aboutOf(exercise));
  }

  private choose(name: string): void {
    this.shown = name;
    this.show();
  }

  private aboutOf(exercise: Exercise): HTMLElement[] {
    const [force, time] = [exercise.most_N, exercise.most_s];
    const begin = press("exercises.begin", () => this.beginShownText());
    begin.title = say("exercises.begin_title");
    begin.className = "begin";
    const [scene, seat] = [this.events.served(exercise), this.events.seat()];
    begin.disabled = scene === "" || (seat !== "" && scene !== seat) || this.isBusy;
    const {tools = []} = exercise;
    const option = (tool: string) => ({value: tool, text: partWords(tool)});
    setOptions(this.tool, tools.map(option), this.toolFor(exercise), "");
    const pictures = exercise.pictures.map(({path, text}) =>
      make(
        "figure",
        make("img", {src: path, alt: ownText(text)}),
        make("figcaption", ownText(text)),
      ),
    );
    const limits = say(force > 0 ? "exercises.limits" : "exercises.limit_time", {force, time});
    return [
      make("h3", ownText(exercise.title)),
      make("p", ownText(exercise.instruction)),
      ...pictures,
      make("p.goal", ownText(exercise.goal)),
      make("p.quiet", limits),
      ...(tools.length > 1 ? [this.toolPick] : []),
      begin,
      make("p.quiet", this.placeOf(exercise)),
      make("h4", say("exercises.graded", {pass: exercise.pass})),
      make("ul.graded", ...exercise.graded.map((one) => make("li", gradedWords(one)))),
      make("ol.done", ...exercise.done.map((trial) => this.rowOf(exercise, trial))),
      make("p.quiet", say("exercises.one")),
    ];
  }

  /// The scene or seat in which it is done, and with what; or why it cannot be.
  private placeOf(exercise: Exercise): string {
    const {tool} = exercise;
    const scene = this.events.served(exercise);
    const seat = this.events.seat();
    if (scene === "") return say("exercises.needs", {scene: exercise.scene, tool});
    if (seat === "") return say("exercises.at", {scene, tool});
    return scene === seat
      ? say("exercises.at_seat", {seat, tool})
      : say("exercises.other_seat", {seat});
  }

  /// How many exercises can be done now; to a teacher, also what serves them all.
  private aboutServer(): HTMLElement[] {
    const {exercises} = this;
    const served = exercises.filter((exercise) => this.events.served(exercise) !== "").length;
    const count = make("p.quiet", say("exercises.served", {served, all: exercises.length}));
    const scenes = new Set(exercises.flatMap(({serve}) => serve ?? []));
    if (served === exercises.length || scenes.size === 0) return [count];
    const seats = Math.max(1, this.events.students());
    const command = `palpate-server ${[...scenes].join(" ")} --seats ${seats}`;
    return [count, make("p", say("exercises.serve")), make("pre", command)];
  }

  private rowOf(exercise: Exercise, trial: DoneTrial): HTMLLIElement {
    const {n, points} = trial;
    const row = make("li", make("span", say("exercises.trial", {n})));
    const said = points === null ? "" : say("exercises.points", {points: Math.round(points)});
    row.append(make("b", said), make("span", verdictOf(trial)));
    if (trial.page !== "") row.append(this.linkTo(trial.page));
    // Not only where a pointer rests: a phone has none.
    if (points === null) row.append(make("span.quiet", sayReason(trial.reason)));
    if (trial.submitted) row.append(make("span", say("exercises.submitted")));
    else row.append(press("exercises.submit", () => this.handIn({exercise: exercise.name, n})));
    return row;
  }

  private linkTo(page: string): HTMLAnchorElement {
    return make("a", {
      ...{href: scoreLink(page), target: "_blank", textContent: say("exercises.score")},
    });
  }

  private get isBusy(): boolean {
    const phase = this.trial?.phase;
    return phase !== undefined && !["scored", "unscored", "kept"].includes(phase);
  }

  private beginShownText(): void {
    const exercise = this.exercises.find(({name}) => name === this.shown);
    const scene = exercise ? this.events.served(exercise) : "";
    if (!exercise || scene === "") return;
    this.room.close();
    const tool = this.toolFor(exercise);
    const other = tool === exercise.tool ? {} : {tool};
    this.events.begin(scene, tool, () =>
      this.events.publish({op: "begin", exercise: exercise.name, ...other}),
    );
  }

  /// The one that is chosen, also for the next trial.
  private toolFor({tool, tools = []}: Exercise): string {
    return tools.includes(this.tool.value) ? this.tool.value : tool;
  }

  private handIn(trial: {readonly exercise: string; readonly n: number} | undefined): void {
    if (trial) this.events.publish({op: "submit", exercise: trial.exercise, n: trial.n});
  }

  private showNext(): void {
    const at = this.exercises.findIndex(({name}) => name === this.shown);
    this.shown = this.exercises[(at + 1) % this.exercises.length]?.name ?? "";
    this.open();
  }

  private showBar(): void {
    const {trial} = this;
    const exercise = this.exercises.find(({name}) => name === trial?.exercise);
    this.bar.hidden = !trial || !exercise;
    if (!trial || !exercise) return;
    this.shown = exercise.name;
    const done = exercise.done.find(({n}) => n === trial.n);
    const over = !this.isBusy;
    setText(this.what, `${ownText(exercise.title)}: ${ownText(exercise.goal)}`);
    const points = Math.round(trial.points ?? 0);
    const {ahead = 0} = trial;
    const reason = sayReason(trial.reason);
    const verdict = verdictOf(trial);
    setText(this.word, say(`exercises.${trial.phase}`, {points, verdict, reason, ahead}));
    this.bar.dataset["verdict"] = trial.phase !== "scored" ? "" : trial.passed ? "good" : "poor";
    const submitted = trial.submitted || done?.submitted === true;
    const {runs} = this;
    if (!runs) this.guide = undefined;
    else if (exercise.guide.length > 0) this.guide ??= new Guide(exercise.guide);
    this.guided.hidden = !this.guide;
    this.guided.setAttribute("aria-pressed", String(this.wantsGuide));
    this.stop.hidden = !runs;
    this.submit.hidden = submitted || !(over || trial.phase === "running");
    this.score.hidden = trial.page === "";
    this.score.href = scoreLink(trial.page);
    this.again.hidden = this.next.hidden = !over;
  }
}
