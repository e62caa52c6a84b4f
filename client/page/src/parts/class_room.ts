import {say, type Words} from "../messages/say";
import {norm} from "../base/pose";
import {ownText} from "../model/local_text";
import {reasonWords, sayReason} from "../model/reasons";
import {nameOf, tellNames} from "../model/names";
import type {Station} from "../model/station";
import type {World} from "../model/world";
import type {ClassAnswer, MadePerson, Me, People, Person, Role} from "../protocol/class_messages";
import {ClassPeople} from "../ui/class_people";
import {ClassWall, type OnWall} from "../ui/class_wall";
import type {OperateOp} from "../ui/console";
import {element, make, press, setText} from "../ui/elements";
import {Room} from "../ui/room";
import {nowS} from "./now";

export interface ClassEvents {
  publish(topic: string, message: object): boolean;
  show(scene: string, station: string): void;
  /// This page is a student's.
  student(): void;
}

const kAnswerWithinMs = 4000;
const kMostNames = 200; // of a wish (ClassCommand)
const kSeat = /^(.+)-\d+$/;

/// A course on the page: for a teacher the wall and the people, for a person the assigned seat.
export class ClassRoom {
  private readonly room = new Room(
    "class",
    {open: "class.open", openTitle: "class.open_title", title: "class.title"},
    () => this.open(),
  );
  private readonly count = make("span.quiet.count");
  private readonly said = make("p.said", {role: "status", hidden: true});
  private readonly saidText = make("span");
  private readonly tabs: Readonly<Record<"wall" | "people", HTMLButtonElement>>;
  private readonly wall: ClassWall;
  private readonly roster: ClassPeople;
  private class: People = {scene: "", people: []};
  private me: Me | undefined;
  private tag = 0;
  private readonly waiting = new Map<number, (answer: ClassAnswer) => void>();

  constructor(
    private readonly world: World,
    private readonly events: ClassEvents,
  ) {
    this.wall = new ClassWall({
      begin: (scene, goal) => this.begin(scene, goal),
      end: () => this.ask({op: "begin", scene: ""}),
      say: (person, name, text) =>
        this.ask({op: "say", person, text}, () => this.room.tell(() => say("class.said", {name}))),
      watch: (scene, station) => {
        this.room.close();
        events.show(scene, station);
      },
      operate: (op, station) => this.operate(op, station),
    });
    this.roster = new ClassPeople({
      make: (names, role) => this.makePeople(names, role),
      rename: (person, name) => this.ask({op: "person_rename", person, name}),
      renew: (person) => this.askForLinks({op: "person_link", person}),
      withdraw: (person) => this.ask({op: "person_withdraw", person}),
    });
    this.tabs = {
      wall: press("class.wall", () => this.turn("wall")),
      people: press("class.people", () => this.turn("people")),
    };
    const tabs = make("span.group", {role: "group"}, this.tabs.wall, this.tabs.people);
    this.room.fill({after: [tabs, this.count]}, this.wall.body, this.roster.body);
    this.room.dialog.addEventListener("close", () => this.roster.forget());
    const hide = press("class.hide", () => void (this.said.hidden = true));
    this.said.append(make("b", {say: "class.from"}), this.saidText, hide);
    element("above", HTMLDivElement).append(this.said);
    this.turn("wall");
  }

  /// The person's own scene; empty: none.
  get seat(): string {
    return this.me?.seat ?? "";
  }

  /// Number of this page's person; 0: none.
  get person(): number {
    return this.me?.person ?? 0;
  }

  /// The number of people who are to have seats, as far as this page knows them.
  get students(): number {
    return this.class.people.filter(({role}) => role === "drive").length;
  }

  /// Deletes a person with all of their data.  @param done  is given the refusal, or ""
  remove(person: number, done: (refusal: Words) => void): void {
    this.ask({op: "person_delete", person}, () => done(""), done);
  }

  /// @param may  this page may decide about people
  allow(may: boolean): void {
    this.room.allow(may);
  }

  /// By topic.
  readonly receivers = {
    people: (value: unknown): void => this.receivePeople(value as People),
    me: (value: unknown): void => this.receiveMe(value as Me),
    class_answer: (value: unknown): void => this.receiveAnswer(value as ClassAnswer),
  };

  tick(nowS: number): void {
    if (!this.room.isOpen) return;
    const {people, scene} = this.class;
    const here = people.filter(({here}) => here > 0).length;
    setText(this.count, say("class.here", {here, all: people.length}));
    this.roster.show(people);
    const scenes = [...this.world.scenes];
    const seated = scenes.filter((name) => scenes.includes(`${name}-1`)).sort();
    this.wall.show(this.onWall(nowS), seated, scene);
  }

  /// People who need a teacher come first, then those who work, then the rest, by name.
  private onWall(nowS: number): OnWall[] {
    const stations = new Map([...this.world.stations].filter(([, {isHere}]) => isHere));
    const all = this.class.people.map((person) => {
      const station = stations.get(person.station);
      stations.delete(person.station);
      return this.personOnWall(person, station, nowS);
    });
    const nobody = {person: 0, role: "drive", here: 1, seat: ""} as const;
    for (const [id, station] of stations) {
      const person = {...nobody, name: nameOf(id), station: id};
      all.push(this.personOnWall(person, station, nowS));
    }
    const rank = {held: 0, works: 1, muted: 1, idle: 2, away: 3};
    return all.sort(
      (a, b) => rank[a.tone] - rank[b.tone] || a.person.name.localeCompare(b.person.name),
    );
  }

  private personOnWall(person: Person, station: Station | undefined, nowS: number): OnWall {
    const scene = station?.session?.scene ?? person.seat;
    const goal = this.world.goals.get(scene);
    const state = station?.isMoving(nowS) ? station.track.latest : undefined;
    const forceN = state && norm(state.forceN);
    const trial = trialOf(person);
    return {person, station, scene, goal, forceN, trial, ...doingOf(person, station)};
  }

  private open(): void {
    this.room.tell("");
    this.turn(this.class.people.length > 1 ? "wall" : "people");
    this.room.open();
    this.tick(nowS());
  }

  private turn(to: "wall" | "people"): void {
    this.wall.body.hidden = to !== "wall";
    this.roster.body.hidden = to !== "people";
    for (const of of ["wall", "people"] as const)
      this.tabs[of].setAttribute("aria-pressed", String(of === to));
  }

  private operate(op: OperateOp, station: string): void {
    this.events.publish("operate", {op, station});
  }

  private begin(scene: string, goal: {text: string; limitN: number}): void {
    this.events.publish("operate", {
      ...{op: "goal", scene, text: goal.text, limit_N: goal.limitN},
    });
    this.ask({op: "begin", scene}, ({note}) => {
      this.room.tell(note !== "" ? reasonWords(note) : () => say("class.begun"));
      for (const [id, {session}] of this.world.stations)
        if (session?.phase === "held") this.operate("admit", id);
    });
  }

  /// As many at once as the gateway takes; who is left stays in the field until they are made too.
  private makePeople(
    names: readonly string[],
    role: Role,
    before: readonly MadePerson[] = [],
  ): void {
    const wish = {op: "person_make", names: names.slice(0, kMostNames), role};
    this.ask(wish, ({people}) => {
      const made = [...before, ...people];
      const left = names.slice(kMostNames);
      this.roster.handOut(made, left);
      if (left.length > 0) this.makePeople(left, role, made);
    });
  }

  private askForLinks(wish: object): void {
    this.ask(wish, ({people}: {people: readonly MadePerson[]}) => this.roster.handOut(people));
  }

  private ask(
    wish: object,
    done: (answer: ClassAnswer) => void = () => {},
    refused: (why: Words) => void = (why) => this.room.tell(why, true),
  ): void {
    const tag = (this.tag += 1);
    this.room.tell("");
    this.waiting.set(tag, (answer) => {
      if (answer.refusal !== "") refused(reasonWords(answer.refusal));
      else done(answer);
    });
    setTimeout(() => {
      if (this.waiting.delete(tag)) refused(() => say("class.no_answer"));
    }, kAnswerWithinMs);
    this.events.publish("class", {tag, ...wish});
  }

  private receiveAnswer(answer: ClassAnswer): void {
    const done = this.waiting.get(answer.tag);
    if (done && this.waiting.delete(answer.tag)) done(answer);
  }

  private receivePeople(people: People): void {
    this.class = people;
    tellNames(people.people.map(({station, name}) => [station, name]));
  }

  private receiveMe(me: Me): void {
    const before = this.me;
    this.me = me;
    tellNames(Object.entries(me.names ?? {}));
    if (me.role === "drive") this.events.student();
    if (me.seat && me.seat !== before?.seat) this.events.show(me.seat, "");
    if (!me.line || me.lines === before?.lines) return;
    setText(this.saidText, me.line);
    this.said.hidden = false;
  }
}

/// What has become of the person's newest trial.
function trialOf({trial}: Person): string {
  if (!trial) return "";
  const {n, phase, ahead, reason} = trial;
  const exercise = ownText(trial.title ?? {}) || trial.exercise;
  const points = Math.round(trial.points ?? 0);
  const key = phase !== "scored" ? phase : trial.points === null ? "no_points" : "points";
  const state = say(`exercises.${key}`, {ahead, reason: sayReason(reason), points});
  return say("class.trial", {exercise, n, state});
}

function doingOf(person: Person, station: Station | undefined): Pick<OnWall, "tone" | "doing"> {
  const session = station?.session;
  if (session?.phase === "held") return {tone: "held", doing: say("class.waits")};
  if (session?.muted) return {tone: "muted", doing: say("class.muted")};
  if (session?.phase === "acquiring") return {tone: "works", doing: say("class.acquiring")};
  if (session) return {tone: "works", doing: say("class.works", {tool: session.tool})};
  if (person.here > 1) return {tone: "idle", doing: say("class.pages", {count: person.here})};
  if (person.here === 0) return {tone: "away", doing: say("class.away")};
  return {tone: "idle", doing: say(person.role === "operate" ? "class.teaches" : "class.looks_on")};
}
