import {say} from "../messages/say";
import type {SceneModel} from "../model/bundle";
import type {LinkReport} from "../model/link_report";
import {norm} from "../base/pose";
import {burOf, drilledM} from "../model/drilled";
import {isProbe, kProbeLimitN, probingDepthM, tellsProbingDepth} from "../model/probing";
import {touchedObjects} from "../model/touched";
import {
  deviceLines,
  figure,
  handPastM,
  type Line,
  sessionWords,
  stationNote,
  statisticsLines,
  statusSentence,
  touchedWords,
} from "../model/words";
import type {Station} from "../model/station";
import type {Guard} from "../protocol/exercise_messages";
import type {ToolState} from "../protocol/messages";
import {Announcer} from "../ui/announcer";
import {Console} from "../ui/console";
import {element, make, refill, setTextOf} from "../ui/elements";
import {ForceBar} from "../ui/force_bar";
import {GuardSign} from "../ui/guard_sign";
import {Lesson} from "../ui/lesson";
import {OverSound} from "../ui/over_sound";
import {Plots, type PlotTime} from "../ui/plots";
import {followLanguage} from "../ui/spoken";

/// What the person's task asks for.
export interface Task {
  readonly limitN: number | undefined; // force limit; undefined: the goal's applies
  readonly guards: readonly Guard[];
}

/// Figures, plots and texts about stations, and a teacher's decisions about them.
export class Figures {
  readonly lesson: Lesson;
  readonly plots = new Plots(element("plots", HTMLDivElement));
  readonly sound = new OverSound();
  private readonly bar = new ForceBar();
  private readonly guard = new GuardSign();
  private readonly box = element("readout", HTMLDivElement);
  private readonly announcer: Announcer;
  private readonly console: Console;

  /// @param operate  sends a teacher's decision
  constructor(operate: (message: object) => boolean) {
    this.announcer = new Announcer((sentence) => setTextOf("spoken", sentence));
    this.console = new Console((op, station) => operate({op, station}));
    this.lesson = new Lesson(
      (student) => this.plots.showFor(student),
      (goal) => operate({op: "goal", ...goal}),
    );
    followLanguage(() => this.plots.build());
  }

  /// Sets whether this page may decide about stations and goals.
  allowDeciding(may: boolean): void {
    this.console.setVisible(may);
    this.lesson.allow(may);
  }

  /// @param station  whose figures are shown
  /// @param own      station of this page's mouse; empty: none
  /// @param model    of the shown scene
  showStation(
    station: Station | undefined,
    own: string,
    task: Task,
    model: SceneModel | undefined,
    time: PlotTime,
    report: LinkReport,
    nowS: number,
  ): void {
    const state = station?.isMoving(nowS) ? station.track.latest : undefined;
    const depthM = this.showState(state, model);
    const note = stationNote(station?.session, station !== undefined && station.id === own);
    setTextOf("station-note", note);
    element("station-note", HTMLElement).hidden = note === "";
    const status = statusSentence(state, depthM);
    const tooMuch = this.showLimit(state, model, task.limitN);
    const tooNear = this.guard.show(state, model, task.guards);
    const sentence = [tooNear, tooMuch, status, note]
      .filter((one) => one !== "")
      .reduce((first, second) => say("list.sentences", {first, second}));
    this.announcer.offer(report.tone === "alarm" ? report.text : sentence, 1000 * nowS);
    this.plots.update(station, time);
    const {statistics} = station ?? {};
    showLines("loop", statistics ? statisticsLines(statistics) : []);
    const device = station?.deviceNow(nowS);
    showLines("arm", device ? deviceLines(device) : []);
    if (device) setTextOf("arm-none", () => say("panel.no_figures_now"));
  }

  /// @param mouse  present or last station of this page's mouse
  showStations(listed: readonly Station[], mouse: string, nowS: number): void {
    this.console.update(listed, 1000 * nowS);
    const rows = listed.flatMap(({id, session, holdsTool}) => {
      if (!session) return [];
      const name = make("b", id);
      if (id === mouse) name.dataset.you = say("panel.you");
      const item = make("li", name, ` ${sessionWords(session)}`);
      item.classList.toggle("gone", !holdsTool);
      return [item];
    });
    element("who-none", HTMLElement).hidden = rows.length > 0;
    refill(element("who", HTMLElement), ...rows);
  }

  /// Shows whether the force is too high: by the task, the goal or, for a probe, the force
  /// of periodontal probing.
  /// @return a message about it
  private showLimit(
    state: ToolState | undefined,
    model: SceneModel | undefined,
    taskN: number | undefined,
  ): string {
    const tool = state?.tool ?? model?.tools[0]?.name ?? "";
    const forProbe = model && isProbe(model, tool) ? kProbeLimitN : undefined;
    const limitN = taskN ?? this.lesson.limitN ?? forProbe;
    const words = this.bar.show(state && norm(state.forceN), limitN);
    this.box.classList.toggle("over", words !== "");
    this.sound.update(words !== "");
    return words;
  }

  /// Shows the figures above the picture.   @return the probing depth, if there is one
  private showState(
    state: ToolState | undefined,
    model: SceneModel | undefined,
  ): number | undefined {
    this.box.classList.toggle("idle", state === undefined);
    setTextOf("force", state ? figure(norm(state.forceN)) : "–");
    setTextOf("torque", state ? figure(1000 * norm(state.torqueNm), 1) : "–");
    setTextOf("past", state ? figure(1000 * handPastM(state)) : "–");
    setTextOf("contacts", state ? String(state.contacts) : "–");
    const touches = state && model ? touchedObjects(model, state) : [];
    setTextOf("touched", state ? touchedWords(touches) : "–");
    const name = state?.tool ?? model?.tools[0]?.name ?? "";
    const tells = model !== undefined && tellsProbingDepth(model, name);
    element("probing-box", HTMLElement).hidden = !tells;
    const depthM = tells && state ? probingDepthM(model, state.graphic) : undefined;
    setTextOf("probing", depthM === undefined ? "–" : figure(1000 * depthM, 1));
    const drills = model?.isCut === true && burOf(model, name) !== undefined;
    element("drilled-box", HTMLElement).hidden = !drills;
    setTextOf("drilled", drills && state ? figure(1000 * drilledM(model, state.graphic)) : "–");
    setTextOf("sentence", statusSentence(state)); // the figure beside it shows the depth
    return depthM;
  }
}

function showLines(id: "loop" | "arm", lines: readonly Line[]): void {
  element(`${id}-none`, HTMLElement).hidden = lines.length > 0;
  const rows = lines.map(({label, value, remark, tone}) =>
    make(
      "tr",
      {className: tone},
      make("th", {scope: "row"}, label),
      ...[make("td.value", value), make("td.remark", remark)],
    ),
  );
  refill(element(id, HTMLTableElement).tBodies[0]!, ...rows);
}
