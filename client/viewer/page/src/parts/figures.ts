import type {SceneModel} from "../model/bundle";
import type {LinkReport} from "../model/link_report";
import {norm} from "../model/pose";
import type {Station} from "../model/world";
import type {SceneGoal} from "../protocol/messages";
import {rememberInAddress} from "../ui/address";
import {Announcer} from "../ui/announcer";
import {Console} from "../ui/console";
import {element, setText} from "../ui/elements";
import {Lesson} from "../ui/lesson";
import {Plots, type PlotTime} from "../ui/plots";
import {Readout} from "../ui/readout";
import {Tables} from "../ui/tables";

/// Figures, plots and words on stations, and what a teacher does about them.
export class Figures {
  private readonly readout = new Readout();
  private readonly plots = new Plots(element("plots", HTMLDivElement));
  private readonly tables = new Tables();
  private readonly announcer: Announcer;
  private readonly console: Console;
  private readonly lesson: Lesson;
  private staleWho = true;

  /// @param operate  sends what a teacher decides
  constructor(operate: (message: object) => boolean) {
    const spoken = element("spoken", HTMLParagraphElement);
    this.announcer = new Announcer((sentence) => setText(spoken, sentence));
    this.console = new Console((op, station) => operate({op, station}));
    this.lesson = new Lesson(
      this.readout.box,
      rememberInAddress,
      (student) => this.plots.showFor(student),
      (goal) => operate({op: "goal", ...goal}),
    );
  }

  /// Keys, for listenForKeys.
  readonly keys: Readonly<Record<string, () => void>> = {v: () => this.lesson.switchAudience()};

  /// Whether this page may decide about stations and goals.
  allowDeciding(may: boolean): void {
    this.console.setVisible(may);
    this.lesson.allow(may);
  }

  showGoal(scene: string, goal: SceneGoal | undefined): void {
    this.lesson.showGoal(scene, goal);
  }

  /// In other colours.
  repaint(): void {
    this.plots.build();
  }

  /// Who drives what has changed.
  sessionsChanged(): void {
    this.staleWho = true;
  }

  /// @param station  whose figures are shown
  /// @param own      the station that this page's mouse is; empty: none
  /// @param model    of the scene that is shown
  showStation(
    station: Station | undefined,
    own: string,
    model: SceneModel | undefined,
    time: PlotTime,
    report: LinkReport,
    nowS: number,
  ): void {
    const state = station?.isMoving(nowS) ? station.track.latest : undefined;
    const sentence = this.readout.show(station, own, model, nowS);
    this.lesson.show(state ? norm(state.forceN) : 0);
    this.announcer.offer(report.tone === "alarm" ? report.text : sentence, 1000 * nowS);
    this.plots.update(station, time);
    this.tables.updateLoop(station);
    this.tables.updateArm(station, nowS);
  }

  /// @param mouse  the station that this page's mouse is, or was last
  showStations(listed: readonly Station[], mouse: string, nowS: number): void {
    this.console.update(listed, 1000 * nowS);
    if (!this.staleWho) return;
    this.staleWho = false;
    this.tables.updateWho(listed, mouse);
  }
}
