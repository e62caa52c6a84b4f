import {say} from "./messages/say";
import {Choice} from "./parts/choice";
import {ClassRoom} from "./parts/class_room";
import {Exam} from "./parts/exam";
import {Exercises} from "./parts/exercises";
import {Figures} from "./parts/figures";
import {GatewayLink} from "./parts/gateway_link";
import {HistoryRoom} from "./parts/history";
import {nowS} from "./parts/now";
import {Picture} from "./parts/picture";
import {type Probe, probeStations} from "./parts/probe";
import {ReplayMode} from "./parts/replay_mode";
import {SceneStore} from "./parts/scene_store";
import {ToolHold} from "./parts/tool_hold";
import {ViewControls} from "./parts/view_controls";
import {WholeButton} from "./parts/whole_button";
import {norm} from "./base/pose";
import type {SceneModel} from "./model/bundle";
import {usualGuards} from "./model/guarded";
import type {LinkReport} from "./model/link_report";
import type {Station} from "./model/station";
import {type Change, World} from "./model/world";
import type {Exercise, ExerciseList, Guard, TrialState} from "./protocol/exercise_messages";
import {toMouseState, toReplayAnswer} from "./protocol/messages";
import {BurSound} from "./ui/bur_sound";
import {element} from "./ui/elements";
import {listenForKeys} from "./ui/keys";
import {Notice} from "./ui/notice";
import {listenToPanel} from "./ui/panel";
import {listenToSetting} from "./ui/settings";
import {followLanguage} from "./ui/spoken";
import {ThemeSwitch} from "./ui/theme";
import {TissueList} from "./ui/tissue_list";
import {readPalette} from "./view/palette";

const kTickMs = 100; // plots and figures
const kOldNewsS = 1; // messages this soon after the link opened are not news

/// The page: connects its parts (parts/) to each other.
export class App {
  // First, since the picture and the plots read its colours.
  private readonly theme = new ThemeSwitch(() => this.repaint());
  private readonly world = new World((change, scene) => this.worldChanged(change, scene));
  private readonly notice = new Notice();
  private readonly picture = new Picture({
    mover: (tool) => this.world.lastMoverOf(this.choice.scene, tool),
    station: () => this.station(nowS()),
    ownTool: () => this.hold.tool,
    lead: (now) => this.exercises.lead(now, this.station(now)?.shown(now)?.haptic.p),
  });
  private readonly viewControls = new ViewControls(this.picture);
  private readonly tissues = new TissueList();
  private readonly burSound = new BurSound();
  private readonly figures = new Figures((message) => this.link.publish("operate", message));
  private readonly link: GatewayLink = new GatewayLink(this.world, {
    link: (state) => {
      if (state === "open") {
        this.loadAgain();
        this.exam.linkOpened();
        this.exercises.linkOpened();
      } else this.hold.mouse.linkLost();
      this.showLink();
    },
    wants: (topic) => topic in this.receivers || this.world.wants(topic),
    message: (topic, value, stampS) => {
      const receive = this.receivers[topic];
      if (receive) receive(value);
      else this.world.receive(topic, value, stampS, nowS());
    },
    rights: () => this.showRights(),
    refused: (reason) => this.whole.refused(reason),
  });
  private readonly choice: Choice = new Choice(this.world, (scene) => {
    if (this.hold.mouse.scene !== scene) this.hold.mouse.release();
    this.showScene();
    void this.scenes.load(scene);
  });
  private readonly loading = element("loading", HTMLParagraphElement);
  private readonly scenes = new SceneStore({
    headers: () => this.link.token.headers,
    isWanted: (scene) => scene === this.choice.scene,
    loading: (is) => void (this.loading.hidden = !is || !this.picture.view.isEmpty),
    loaded: (anew) => (anew ? this.showScene() : this.hold.show()),
    failed: (reason, whileSo) => this.notice.say(reason, {alarm: true, whileSo}),
  });
  private readonly hold: ToolHold = new ToolHold(
    this.world,
    this.choice,
    this.scenes,
    this.link,
    this.picture,
    this.notice,
    () => this.mayTake,
    () => this.exam.askToHandIn(this.notice),
    () => this.exercises.runs,
  );
  private readonly whole = new WholeButton(this.notice, (op) =>
    this.link.publish("mouse", {op, scene: this.choice.scene}),
  );
  private readonly replay: ReplayMode = new ReplayMode(
    this.world.replay,
    this.link,
    this.notice,
    () => {
      if (this.replay.isOn) this.hold.mouse.release();
      this.showRights();
      this.showTitle();
    },
  );
  private readonly classRoom = new ClassRoom(this.world, {
    publish: (topic, message) => this.link.publish(topic, message),
    show: (scene, station) => this.choice.show(scene, station),
    student: () => this.figures.lesson.greetStudent(),
  });
  private readonly trials = {
    seat: () => this.classRoom.seat,
    served: (exercise: Exercise) => {
      const {seat} = this.classRoom;
      const scene = seat.startsWith(`${exercise.scene}-`) ? seat : exercise.scene;
      return this.scenes.model(scene) || this.world.scenes.has(scene) ? scene : "";
    },
  };
  private readonly exercises: Exercises = new Exercises({
    publish: (message) => this.link.publish("trial", message),
    begin: (scene, tool, ask) => {
      this.choice.show(scene, "");
      this.choice.stay();
      this.hold.mouse.take(scene, tool, ask);
    },
    students: () => this.classRoom.students,
    ...this.trials,
  });
  private readonly exam: Exam = new Exam({
    publish: (topic, message) => this.link.publish(topic, message),
    begin: (ask) => this.hold.mouse.expect(ask),
    changed: () => this.showRights(),
    ...this.trials,
  });
  private readonly history = new HistoryRoom({
    headers: () => this.link.token.headers,
    me: () => this.classRoom.person,
    remove: (person, done) => this.classRoom.remove(person, done),
  });

  constructor() {
    listenForKeys({
      ...this.viewControls.keys,
      ...this.hold.keys,
      ...this.replay.keys,
      ...listenToPanel(),
      v: () => this.figures.lesson.switchAudience(),
      w: () => this.whole.press(),
      t: () => this.theme.toggle(),
    });
    listenToSetting("left-handed");
    listenToSetting("projector", () => this.repaint());
    listenToSetting("bur-mute", (on) => (this.burSound.mute = on));
    listenToSetting("force-sound", (on) => this.figures.sound.want(on));
    followLanguage(() => this.showTitle());
    this.hold.show();
    this.link.start();
    window.setInterval(() => this.tick(), kTickMs);
  }

  get probe(): Probe {
    return {
      ...this.picture.probe,
      link: this.link.state,
      links: this.link.opened,
      scene: this.choice.scene,
      stations: probeStations(this.world.stations),
      hold: this.hold.mouse.hold,
    };
  }

  // --- incoming messages ---

  /// By topic; the world takes all others.
  private readonly receivers: Readonly<Record<string, (value: unknown) => void>> = {
    ...this.classRoom.receivers,
    ...this.exam.receivers,
    exercises: (value) => this.exercises.receiveList(value as ExerciseList),
    trial_state: (value) => {
      this.exam.receiveTrial(value as TrialState);
      this.exercises.receiveTrial(value as TrialState);
    },
    replay_answer: (value) => this.replay.answered(toReplayAnswer(value)),
    mouse_state: (value) => {
      const {mouse, isBusy} = this.hold;
      mouse.receive(toMouseState(value));
      if (isBusy || mouse.hold === "none") return;
      // It had the tool before this page came, or the gateway chose where.
      this.choice.show(mouse.scene, "");
      this.choice.stay();
    },
  };

  private worldChanged(change: Change, scene: string): void {
    const isShown = scene === this.choice.scene;
    switch (change) {
      case "replay":
        this.replay.told();
        break;
      case "tool":
        if (isShown) this.picture.wake();
        break;
      case "goal":
        if (isShown) this.figures.lesson.showGoal(scene, this.world.goals.get(scene));
        break;
      case "scenes":
        this.choice.chooseScene();
        break;
      case "remains":
      case "whole":
        if (!isShown) break;
        this.picture.view.updateRemains();
        this.showWhole();
        if (change === "whole") this.wholeAnswered(scene);
        break;
      case "serverRun":
        // The server may have other scenes, or a changed one under the same name.
        void this.link.askHealth();
        this.loadAgain();
        break;
    }
  }

  private loadAgain(): void {
    if (this.choice.scene !== "") void this.scenes.load(this.choice.scene);
  }

  /// During a replay the event is old and has a mark; a page that has just connected need
  /// not be told.
  private wholeAnswered(scene: string): void {
    const whole = this.world.wholes.get(scene);
    if (!whole || this.replay.isOn) return;
    this.whole.answered(whole, nowS() - this.link.openedS > kOldNewsS);
  }

  // --- what is shown ---

  private get model(): SceneModel | undefined {
    return this.scenes.model(this.choice.scene);
  }
  private station(now: number): Station | undefined {
    const {hold, station} = this.hold.mouse;
    return this.choice.station(hold === "holding" ? station : "", now);
  }
  /// A tool of a replay cannot be taken.
  private get mayTake(): boolean {
    return this.link.may.take && !this.replay.isOn;
  }

  private showLink(): LinkReport {
    return this.link.show({
      mayTake: this.mayTake,
      takes: this.hold.isBusy,
      draws: this.picture.view.draws,
      replay: this.replay.phase,
    });
  }

  private showScene(): void {
    const {world} = this;
    const {scene} = this.choice;
    this.picture.setScene(
      this.model,
      world.remainsOf(scene),
      (tool) => world.lastMoverOf(scene, tool)?.track.latest?.graphic,
    );
    this.viewControls.showScene();
    this.figures.lesson.showGoal(scene, world.goals.get(scene));
    this.hold.showTools(this.model?.tools ?? []);
    this.showWhole();
    this.showTitle();
  }

  private repaint(): void {
    this.picture.view.paint(readPalette());
    this.figures.plots.build();
  }

  private get guards(): readonly Guard[] {
    const asked = this.exercises.guardsIn(this.choice.scene);
    return asked.length > 0 || !this.model ? asked : usualGuards(this.model);
  }

  private showTitle(): void {
    const parts = [this.replay.isOn ? say("replay.word") : "", this.choice.scene, "Palpate"];
    document.title = parts.filter((part) => part !== "").join(" · ");
  }

  private showRights(): void {
    this.hold.offer(this.mayTake);
    // In a replay there is nothing to decide.
    this.figures.allowDeciding(this.link.may.operate && !this.replay.isOn);
    this.classRoom.allow(this.link.may.teach && !this.replay.isOn);
    this.history.allow(this.link.may.try && !this.exam.isOn, this.link.may.teach);
    this.exam.allow(this.link.may.teach && !this.replay.isOn);
    this.exercises.allow(this.link.may.try && !this.replay.isOn && !this.exam.isOn);
    this.showWhole();
  }

  private showWhole(): void {
    const {scene} = this.choice;
    this.whole.show(
      this.mayTake && (this.model?.isCut ?? false),
      this.world.remainsOf(scene).isWhole,
      this.world.wholes.get(scene)?.hasBookmark ?? false,
    );
  }

  private tick(): void {
    const now = nowS();
    if (!this.hold.isBusy) this.choice.goWhereSomethingMoves(now);
    this.link.pulse.beat(now, !document.hidden);
    this.picture.wake(); // if no message arrives any more, nothing else triggers a picture
    const report = this.showLink();
    // Hints on using a tool are pointless while no data of it arrives.
    this.notice.update(report.tone !== "alarm");
    this.replay.show(now);
    const station = this.station(now);
    const time = this.replay.plotTime(station, now);
    const taskN = this.exam.limitN ?? this.exercises.limitN;
    const task = {limitN: taskN, guards: this.exam.isOn ? [] : this.guards};
    this.figures.showStation(station, this.hold.station, task, this.model, time, report, now);
    const forceN = norm(this.hold.ownState?.forceN ?? [0, 0, 0]);
    this.burSound.update(this.hold.burTurns ? forceN : undefined);
    this.figures.showStations(this.world.listed(now), this.hold.mouse.station, now);
    this.tissues.update(this.model, this.world.remainsOf(this.choice.scene));
    this.choice.showLists(station, now);
    this.classRoom.tick(now);
    this.exercises.tick(now);
    this.history.tick(now);
    this.exam.tick(now);
  }
}
