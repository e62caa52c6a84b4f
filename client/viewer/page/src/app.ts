import {norm} from "./model/pose";
import type {Pose, Vec3} from "./model/pose";
import {type LinkFacts, type LinkReport, linkReport, Pulse} from "./model/link_report";
import {looksTheSame} from "./model/pose_track";
import {type Drawn, PictureQuality, qualityOf} from "./model/quality";
import type {ReplayPhase} from "./model/replay";
import {pictureWords} from "./model/words";
import {type Change, kOwnTopics, kTopics, Station, World} from "./model/world";
import {MouseDevice} from "./mouse/mouse_device";
import {Connection, type LinkState} from "./protocol/connection";
import {toMouseState, toReplayAnswer, type ToolState} from "./protocol/messages";
import {type FetchedScene, fetchHealth, fetchScene} from "./protocol/scene_fetch";
import {AccessToken} from "./protocol/token";
import {rememberInAddress} from "./ui/address";
import {Announcer} from "./ui/announcer";
import {Console} from "./ui/console";
import {element, setOptions, setText} from "./ui/elements";
import {listenForKeys} from "./ui/keys";
import {Lesson} from "./ui/lesson";
import {Notice} from "./ui/notice";
import {Plots, type PlotTime} from "./ui/plots";
import {QualityPick} from "./ui/quality_pick";
import {Readout} from "./ui/readout";
import {listenToPointer} from "./ui/pointer";
import {ReplayControls} from "./ui/replay_controls";
import {Tables} from "./ui/tables";
import {ThemeSwitch} from "./ui/theme";
import {browserTokenHost} from "./ui/token_host";
import {readPalette} from "./view/palette";
import {drawsBySoftware} from "./view/renderer";
import {type Cost, SceneView} from "./view/scene_view";
import {ToolPointer} from "./view/tool_pointer";

const kTickMs = 100; // plots and figures
const kRetrySceneMs = 1000;
const kWarmUp = 3;
const kOldNewsS = 1; // what comes so soon after the link was opened was said before
/// The gateway is asked how it is this often; that also tells a link that only looks open.
const kAskHealthMs = 4000;
const kAnswerWithinMs = 3000;
/// A link on which nothing comes is given up once the gateway has been silent so many times.
const kMostSilences = 2;

const nowS = (): number => performance.now() / 1000;

/// What tests and curious people can read: `palpate` in the browser's console.
export interface Probe {
  link: LinkState;
  links: number; // times that the link was opened
  scene: string;
  firstPictureMs: number | undefined; // since the page was asked for
  pictures: number;
  scriptMs: {last: number; mean: number; max: number}; // of a picture, without the card's time
  triangles: number;
  costs: {still: Cost; moving: Cost}; // of what stands still, when it was drawn last, and of the rest
  drawnAnew: number; // times that what stands still was drawn
  quality: {rest: string; motion: string};
  stations: Record<
    string,
    {poseSequence: number; haptic: Pose; graphic: Pose; forceN: Vec3; frames: number}
  >;
  hold: string;
}

export class App {
  private readonly canvas = element("view", HTMLCanvasElement);
  private readonly banner = element("banner", HTMLParagraphElement);
  private readonly loading = element("loading", HTMLParagraphElement);
  private readonly scenePick = element("scene", HTMLSelectElement);
  private readonly stationPick = element("station", HTMLSelectElement);
  private readonly toolPick = element("tool", HTMLSelectElement);
  private readonly takeButton = element("take", HTMLButtonElement);
  private readonly level = element("level", HTMLInputElement);
  private readonly numbers = element("numbers", HTMLButtonElement);
  private readonly wholeButton = element("whole", HTMLButtonElement);

  private readonly world = new World((change, scene) => this.worldChanged(change, scene));
  private readonly connection: Connection;
  private readonly view: SceneView;
  private readonly quality: PictureQuality;
  private readonly qualityPick: QualityPick;
  private readonly mouse: MouseDevice;
  private readonly replayControls: ReplayControls;
  private readonly plots: Plots;
  private readonly tables = new Tables();
  private readonly console: Console;
  private readonly notice = new Notice();
  private readonly readout = new Readout();
  private readonly toolPointer: ToolPointer;
  private readonly token = new AccessToken(browserTokenHost);
  private readonly lesson: Lesson;
  private readonly announcer: Announcer;

  private link: LinkState = "connecting";
  private links = 0;
  private openedS = -Infinity;
  private losses = 0; // since the link was last open: the loss itself, and tries that failed
  private lostS = -Infinity; // the first of them
  private gateway = {saidS: -Infinity, full: false, wantsToken: false, silences: 0};
  private mayPublish = false;
  private maySteer = false; // a replay
  private mayOperate = false; // decide about stations
  private allowsMice = true; // until the gateway says otherwise
  private isReplay = false;
  private wholeAsked = false;
  private moving = ""; // the stations that move
  private scene = "";
  private chosenScene = new URLSearchParams(location.search).get("scene") ?? "";
  private chosenStation = new URLSearchParams(location.search).get("station") ?? "";
  private readonly fetched = new Map<string, FetchedScene>();
  private loadingScene = "";
  private loadAgain = false;
  private drawn: ToolState[] = [];
  private frameAsked = false;
  private readonly pulse = new Pulse();
  private dirty = true;
  private staleWho = true;
  private firstPictureMs: number | undefined;
  private pictures = 0;
  private drawnAnew = 0;
  private before: {drawn: Drawn; atMs: number} | undefined; // in the frame before
  private settling: number | undefined; // timer
  private scriptMs = {last: 0, total: 0, max: 0};

  constructor() {
    const bySoftware = drawsBySoftware();
    const fixed = qualityOf(new URLSearchParams(location.search).get("quality") ?? "");
    this.quality = new PictureQuality(bySoftware, fixed);
    const calm = matchMedia("(prefers-reduced-motion: reduce)").matches;
    const theme = new ThemeSwitch(element("theme", HTMLButtonElement), () => {
      this.view.paint(readPalette());
      this.plots.build();
    });
    const below = element("below", HTMLDivElement);
    this.toolPointer = new ToolPointer(element("tool-pointer", HTMLButtonElement), below, () =>
      this.lookAtAll(),
    );
    this.view = new SceneView(
      this.canvas,
      element("labels", HTMLDivElement),
      below,
      readPalette(),
      this.quality,
      !bySoftware || fixed === "full", // smoothed edges take a third of a processor's time
      calm,
      () => this.askFrame(),
    );
    this.qualityPick = new QualityPick(this.quality, rememberInAddress, () => this.view.resize());
    this.plots = new Plots(element("plots", HTMLDivElement));
    this.lesson = new Lesson(
      this.readout.box,
      rememberInAddress,
      (student) => this.plots.showFor(student),
      (goal) => this.connection.publish(kTopics.operate, {op: "goal", ...goal}),
    );
    const spoken = element("spoken", HTMLParagraphElement);
    this.announcer = new Announcer((sentence) => setText(spoken, sentence));

    const url = new URL(".", location.href);
    url.protocol = url.protocol === "https:" ? "wss:" : "ws:";
    this.connection = new Connection(
      url.href,
      new Set(Object.values(kTopics).filter((topic) => !kOwnTopics.has(topic))),
      {
        link: (state) => this.linkChanged(state),
        message: (topic, value, stampS) => this.received(topic, value, stampS),
        status: (level, message) => {
          if (level > 0) console.warn(`gateway: ${message}`);
        },
        mayPublish: (may, role) => {
          this.mayPublish = may;
          this.mayOperate = may && role === "operate";
        },
        offers: (topics) => {
          this.allowsMice = this.mayPublish && topics.has(kTopics.mouseState);
          this.maySteer = this.mayPublish && topics.has(kTopics.replayAnswer);
          this.showRights();
        },
      },
      {
        openSocket: (address, protocols) => new WebSocket(address, this.token.protocols(protocols)),
        setTimer: (callback, milliseconds) => window.setTimeout(callback, milliseconds),
        clearTimer: (timer) => window.clearTimeout(timer),
      },
    );
    this.mouse = new MouseDevice({
      publish: (message) => this.connection.publish(kTopics.mouse, message),
      changed: () => this.showHold(),
      viewFrame: (at) => this.view.camera.viewFrame(at),
      tool: (scene, tool) => this.toolNow(scene, tool),
    });

    this.replayControls = new ReplayControls(this.world.replay, {
      publish: (message) => this.connection.publish(kTopics.replay, message),
      say: (text, alarm) => this.notice.say(text, {alarm}),
    });

    this.console = new Console((op, station) =>
      this.connection.publish(kTopics.operate, {op, station}),
    );

    this.listen(theme);
    this.showHold();
    this.connection.start();
    // Beside the socket's handshake: the first picture need not wait for it.
    void this.askHealth();
    window.setInterval(() => this.tick(), kTickMs);
    window.setInterval(() => void this.watchGateway(), kAskHealthMs);
  }

  get probe(): Probe {
    const stations: Probe["stations"] = {};
    for (const [id, {track, frames}] of this.world.stations) {
      const latest = track.latest;
      if (!latest) continue;
      const {poseSequence, haptic, graphic, forceN} = latest;
      stations[id] = {poseSequence, haptic, graphic, forceN, frames};
    }
    const {last, total, max} = this.scriptMs;
    return {
      link: this.link,
      links: this.links,
      scene: this.scene,
      firstPictureMs: this.firstPictureMs,
      pictures: this.pictures,
      scriptMs: {last, mean: total / Math.max(1, this.pictures - kWarmUp), max},
      triangles: this.view.costs.still.triangles + this.view.costs.moving.triangles,
      costs: this.view.costs,
      drawnAnew: this.drawnAnew,
      quality: this.quality.names,
      stations,
      hold: this.mouse.hold,
    };
  }

  // --- what comes in ---

  private linkChanged(state: LinkState): void {
    this.link = state;
    if (state === "open") {
      this.links += 1;
      this.losses = 0;
      this.openedS = nowS();
      this.world.startLink();
      if (this.scene !== "") void this.loadScene(this.scene);
      void this.askHealth();
    } else {
      if (state === "lost" && (this.losses += 1) === 1) this.lostS = nowS();
      this.mouse.linkLost();
    }
    this.showLink();
  }

  private received(topic: string, value: unknown, stampS: number): void {
    if (topic === kTopics.mouseState) {
      this.mouse.receive(toMouseState(value));
    } else if (topic === kTopics.replayAnswer) {
      this.replayControls.answered(toReplayAnswer(value));
    } else {
      this.world.receive(topic, value, stampS, nowS());
    }
  }

  private worldChanged(change: Change, scene: string): void {
    switch (change) {
      case "replay": {
        const {state} = this.world.replay;
        if (state) this.replayControls.told(state);
        this.showReplay(nowS());
        break;
      }
      case "tool":
        if (scene === this.scene) this.wake();
        break;
      case "sessions":
        this.staleWho = true;
        break;
      case "goal":
        if (scene === this.scene) this.showGoal();
        break;
      case "scenes":
        this.chooseScene();
        break;
      case "remains":
        if (scene === this.scene) this.view.updateRemains();
        if (scene === this.scene) this.showWhole();
        break;
      case "whole":
        if (scene === this.scene) this.view.updateRemains();
        this.wholeAnswered(scene);
        break;
      case "serverRun":
        // It may serve other scenes, or another one under the same name.
        void this.askHealth();
        if (this.scene !== "") void this.loadScene(this.scene);
        break;
      case "statistics":
        break;
    }
  }

  // --- scenes and stations ---

  /// The reader's choice where there is it, else the first scene, until a tool moves in another.
  private chooseScene(): void {
    const known = this.world.scenes;
    const wanted = [this.chosenScene, this.scene, ...known].find((name) => known.has(name));
    if (wanted !== undefined && wanted !== this.scene) this.enterScene(wanted);
  }

  private goWhereSomethingMoves(): void {
    if (this.world.scenes.has(this.chosenScene) || this.mouse.hold !== "none") return;
    if (this.listedHere().length > 0) return;
    const now = nowS();
    const mover = this.world.listed(now).find((station) => station.isMoving(now));
    if (mover && this.world.scenes.has(mover.scene)) this.enterScene(mover.scene);
  }

  private enterScene(name: string): void {
    this.scene = name;
    if (this.mouse.hold !== "none") this.mouse.release();
    this.showScene();
    void this.loadScene(name);
  }

  private async loadScene(name: string): Promise<void> {
    if (this.loadingScene === name) {
      this.loadAgain = true; // it may have changed since it was asked for
      return;
    }
    this.loadingScene = name;
    this.loadAgain = false;
    this.loading.hidden = !this.view.isEmpty;
    try {
      const have = this.fetched.get(name);
      const scene = await fetchScene(name, this.token.headers, have);
      this.fetched.set(name, scene);
      if (name !== this.scene) return;
      if (scene !== have) this.showScene();
      this.showHold();
    } catch (error) {
      if (name !== this.scene) return;
      const whileSo = (): boolean => name === this.scene && !this.fetched.has(name);
      this.notice.say(error instanceof Error ? error.message : String(error), {
        alarm: true,
        whileSo,
      });
      window.setTimeout(() => {
        if (name === this.scene && !this.fetched.has(name)) void this.loadScene(name);
      }, kRetrySceneMs);
    } finally {
      // Another scene may have been entered meanwhile: then the rest is its load's.
      if (this.loadingScene === name) {
        this.loadingScene = "";
        this.loading.hidden = true;
        if (this.loadAgain) void this.loadScene(name);
      }
    }
  }

  private showScene(): void {
    const model = this.fetched.get(this.scene)?.model;
    this.quality.restart();
    this.view.setScene(
      model,
      this.world.remainsOf(this.scene),
      (tool) => this.world.lastMoverOf(this.scene, tool)?.track.latest?.graphic,
    );
    this.view.resize();
    this.showGoal();
    this.numbers.hidden = this.view.teeth === 0;
    this.showWhole();
    this.drawn = [];
    this.showTitle();
    this.canvas.setAttribute(
      "aria-label",
      model ? pictureWords(model) : "The scene in three dimensions",
    );
    const tools = model?.tools.map(({name}) => ({value: name, text: name})) ?? [];
    setOptions(this.toolPick, tools, this.toolPick.value || (tools[0]?.value ?? ""), "no tool");
    if (tools[0] && this.toolPick.selectedIndex < 0) this.toolPick.selectedIndex = 0;
    element("tool-pick", HTMLLabelElement).hidden = tools.length < 2;
    const finest = Math.max(0, this.view.sphereLevels - 1);
    const atFinest = this.level.value === this.level.max;
    this.level.max = String(finest);
    if (atFinest) this.level.value = this.level.max;
    this.showHold();
    this.showLevel();
  }

  private showGoal(): void {
    this.lesson.showGoal(this.scene, this.world.goalOf(this.scene));
  }

  private showTitle(): void {
    const parts = [this.isReplay ? "Replay" : "", this.scene, "Palpate"];
    document.title = parts.filter((part) => part !== "").join(" · ");
  }

  /// The station whose figures are shown: the reader's choice, else the page's own, else the one
  /// that moves.
  private get station(): Station | undefined {
    const here = this.listedHere();
    const own = this.mouse.hold === "holding" ? this.mouse.station : "";
    return (
      here.find(({id}) => id === this.chosenStation) ?? here.find(({id}) => id === own) ?? here[0]
    );
  }
  private listedHere(): Station[] {
    const now = nowS();
    return this.world
      .listed(now)
      .filter(
        (station) => station.scene === this.scene && (station.holdsTool || station.isMoving(now)),
      );
  }

  private toolNow(scene: string, tool: string): ReturnType<ToolNow> {
    const body = this.fetched.get(scene)?.model.tools.find(({name}) => name === tool);
    const centroid = body?.geometry.centroid ?? [0, 0, 0];
    const state = this.world.lastMoverOf(scene, tool)?.track.latest;
    const start = body?.pose ?? {p: [0, 0, 0], q: [1, 0, 0, 0]};
    if (!state) return {pose: start, graphic: start, touches: false, centroid};
    return {
      // Where the tool is, not where the last hand had it: that may be deep inside.
      pose: state.graphic,
      graphic: state.graphic,
      touches: state.contacts > 0,
      centroid,
    };
  }

  // --- the picture ---

  /// Something has changed that a picture shows.
  private askFrame(): void {
    this.dirty = true;
    this.wake();
  }

  /// Something may have changed: the frame finds out, and draws only then.
  private wake(): void {
    if (this.frameAsked) return;
    this.frameAsked = true;
    requestAnimationFrame((atMs) => this.frame(atMs));
  }

  private frame(atMs: number): void {
    const startMs = performance.now();
    this.frameAsked = false;
    this.judge(atMs);
    const now = startMs / 1000;
    let catchingUp = false;
    const tools = this.fetched.get(this.scene)?.model.tools ?? [];
    tools.forEach((tool, i) => {
      const mover = this.world.lastMoverOf(this.scene, tool.name);
      const state = mover?.shown(now);
      if (!mover || !state) return;
      catchingUp = mover.isCatchingUp(now) || catchingUp;
      if (looksTheSame(state, this.drawn[i])) return;
      this.view.setTool(tool.name, state);
      if (mover === this.station) this.view.camera.toolAt(state.graphic.p);
      this.drawn[i] = state;
      this.dirty = true;
    });
    this.dirty = this.view.camera.controls.update() || this.dirty;
    if (this.dirty) {
      this.dirty = false;
      const drawn = this.view.render(startMs);
      this.pointToTool();
      this.before = {drawn, atMs};
      if (this.view.draws && !this.view.isEmpty) this.countPicture(drawn, startMs);
      this.settleLater(startMs);
      this.wake(); // it tells by when the browser was ready for another one
    }
    if (catchingUp) this.wake();
  }

  /// To the one that this page may take, or has.
  private pointToTool(): void {
    const tools = this.fetched.get(this.scene)?.model.tools ?? [];
    const index = Math.max(
      0,
      tools.findIndex(({name}) => name === this.toolPick.value),
    );
    const end = this.view.draws ? this.view.endOf(index) : undefined;
    this.toolPointer.update(this.view.camera.eye, end, tools[index]?.name ?? "tool");
  }

  private lookAtAll(): void {
    this.view.lookAtAll();
    this.askFrame();
  }

  private countPicture(drawn: Drawn, startMs: number): void {
    const tookMs = performance.now() - startMs;
    this.pictures += 1;
    this.drawnAnew += drawn === "tools" ? 0 : 1;
    this.scriptMs.last = tookMs;
    // The first pictures upload meshes and compile shaders: once, and not what a picture costs.
    if (this.pictures > kWarmUp) {
      this.scriptMs.total += tookMs;
      this.scriptMs.max = Math.max(this.scriptMs.max, tookMs);
    }
    if (this.firstPictureMs === undefined) {
      this.firstPictureMs = performance.now();
      performance.mark("palpate-first-picture");
    }
  }

  /// Where the frame before drew, how long it took tells how well pictures can be drawn.
  private judge(atMs: number): void {
    const {before} = this;
    this.before = undefined;
    if (!before || !this.quality.took(before.drawn, atMs - before.atMs)) return;
    this.view.resize();
    this.qualityPick.show();
  }

  /// What was drawn in haste, while the eye moved, is drawn well once it rests.
  private settleLater(nowMs: number): void {
    window.clearTimeout(this.settling);
    const inMs = this.view.settlesInMs(nowMs);
    if (inMs !== undefined) this.settling = window.setTimeout(() => this.askFrame(), inMs);
  }

  // --- figures and words ---

  private tick(): void {
    this.goWhereSomethingMoves();
    const now = nowS();
    this.pulse.beat(now, !document.hidden);
    this.wakeWhereSomethingStops(now);
    const station = this.station;
    const state = station?.isMoving(now) ? station.track.latest : undefined;
    const own = this.mouse.hold === "none" ? "" : this.mouse.station;
    const sentence = this.readout.show(station, own, this.fetched.get(this.scene)?.model, now);
    this.lesson.show(state ? norm(state.forceN) : 0);
    const report = this.showLink();
    // What one can do with a tool is nothing where none of it arrives.
    this.notice.update(report.tone !== "alarm");
    this.announcer.offer(report.tone === "alarm" ? report.text : sentence, performance.now());
    this.showReplay(now);
    this.plots.update(station, this.plotTime(station, now));
    this.tables.updateLoop(station);
    this.tables.updateArm(station, now);
    this.console.update(this.world.listed(now), performance.now());
    if (this.staleWho) {
      this.staleWho = false;
      this.tables.updateWho(this.world.listed(now), this.mouse.station);
    }
    this.showLists(station);
  }

  private showReplay(now: number): void {
    const phase = this.replayPhase;
    if ((phase !== "none") !== this.isReplay) {
      this.isReplay = phase !== "none";
      if (this.isReplay && this.mouse.hold !== "none") this.mouse.release();
      this.showRights();
      this.showTitle();
    }
    this.replayControls.show(phase, this.maySteer, now);
  }

  /// Figures of a replay stand at the recording's time, with what it lacks of their station.
  private plotTime(station: Station | undefined, nowS: number): PlotTime {
    const {replay} = this.world;
    if (!this.isReplay) return {nowS, isRecorded: false, gaps: []};
    const gaps = replay.contents?.gaps.filter((gap) => gap.station === station?.id) ?? [];
    return {nowS: replay.atS(nowS), isRecorded: true, gaps};
  }

  /// Where nothing comes any more, nothing else would draw that.
  private wakeWhereSomethingStops(now: number): void {
    const moving = [...this.world.stations.values()]
      .filter((station) => station.isMoving(now))
      .map(({id}) => id)
      .join();
    if (moving !== this.moving) this.wake();
    this.moving = moving;
  }

  private showLists(station: Station | undefined): void {
    const scenes = [...this.world.scenes].sort();
    setOptions(
      this.scenePick,
      scenes.map((name) => ({value: name, text: name})),
      this.scene,
      "none yet",
    );
    setOptions(
      this.stationPick,
      this.listedHere().map(({id}) => ({value: id, text: id})),
      station?.id ?? "",
      "nobody",
    );
  }

  private showLink(): LinkReport {
    let sessions = 0;
    for (const station of this.world.stations.values()) sessions += station.holdsTool ? 1 : 0;
    const report = linkReport({
      link: this.link,
      wasOpen: this.links > 0,
      nowS: nowS(),
      openedS: this.openedS,
      lastStateS: this.world.lastStateS,
      sessions,
      scenes: this.world.scenes.size,
      refusal: this.refusal,
      serverLives: this.world.serverLives,
      compiling: this.world.compiling,
      mayTake: this.mayTake,
      takes: this.mouse.hold !== "none",
      draws: this.view.draws,
      replay: this.replayPhase,
      recording: this.world.replay.name,
      replaySilenceS: this.world.replay.silenceS(nowS(), this.heardSinceS),
      busyS: this.pulse.busyS,
    });
    this.banner.hidden = report.tone === "none";
    this.banner.classList.toggle("alarm", report.tone === "alarm");
    setText(this.banner, report.text);
    return report;
  }

  /// Since when this page hears what is said: the link is open, and the page runs.
  private get heardSinceS(): number {
    return Math.max(this.openedS, this.pulse.busyS);
  }
  private get replayPhase(): ReplayPhase {
    return this.world.replay.phase(nowS(), this.heardSinceS);
  }

  /// What keeps the link from opening, where it is not the way to the gateway.
  private get refusal(): LinkFacts["refusal"] {
    if (this.gateway.wantsToken) return "token";
    if (this.losses < 2 || this.gateway.saidS < this.lostS) return "none";
    return this.gateway.full ? "full" : "this page";
  }

  /// A socket can look open long after the way to its other end is gone: where nothing comes and
  /// the gateway does not answer either, the link is made anew.
  private async watchGateway(): Promise<void> {
    const askedS = nowS();
    await this.askHealth();
    const isSilent = this.world.lastStateS < askedS && this.openedS < askedS;
    if (this.link !== "open" || !isSilent || this.gateway.silences < kMostSilences) return;
    this.gateway.silences = 0;
    this.connection.restart();
  }

  private async askHealth(): Promise<void> {
    const health = await fetchHealth(kAnswerWithinMs, this.token.headers);
    if (!health) {
      this.gateway.silences += 1;
      return;
    }
    const wantsToken = health === "token";
    const full = !wantsToken && health.full;
    this.gateway = {saidS: nowS(), full, wantsToken, silences: 0};
    if (wantsToken) return;
    this.world.receiveHealth(health, nowS());
  }

  // --- the mouse ---

  /// A tool of a replay is in no one's reach.
  private get mayTake(): boolean {
    return this.allowsMice && !this.isReplay;
  }

  private showRights(): void {
    for (const part of document.querySelectorAll<HTMLElement>(".of-mouse")) {
      part.hidden = !this.mayTake;
    }
    // Of a replay nothing is to be decided: it has been.
    this.console.setVisible(this.mayOperate && !this.isReplay);
    this.lesson.allow(this.mayOperate && !this.isReplay);
    this.showWhole();
  }

  private showWhole(): void {
    const wears = this.fetched.get(this.scene)?.model.wears ?? false;
    this.wholeButton.hidden = !this.mayTake || !wears;
    this.wholeButton.disabled = this.world.remainsOf(this.scene).isWhole;
  }

  private makeWhole(): void {
    if (this.wholeButton.hidden || this.wholeButton.disabled) return;
    this.wholeAsked = true;
    this.notice.say("Asking the server to make it whole…");
    this.connection.publish(kTopics.mouse, {op: "whole", scene: this.scene});
  }

  /// Who looks on should know why the objects have changed; who comes later need not.
  private wholeAnswered(scene: string): void {
    this.showWhole();
    const whole = this.world.wholeOf(scene);
    // In a replay it is of then, and a mark.
    const isNews = !this.isReplay && (nowS() - this.openedS > kOldNewsS || this.wholeAsked);
    if (scene !== this.scene || whole === undefined || !isNews) return;
    this.wholeAsked = false;
    const text =
      whole.refusal === ""
        ? `The ${scene} is whole again (${whole.by}).`
        : `It is not made whole: ${whole.refusal}.`;
    this.notice.say(text, {alarm: whole.refusal !== ""});
  }

  private showHold(): void {
    const {hold} = this.mouse;
    const message = this.mouse.takeMessage();
    const holding = hold === "holding";
    this.canvas.classList.toggle("holding", holding);
    this.takeButton.classList.toggle("holding", holding);
    this.takeButton.disabled = hold === "none" && !this.fetched.has(this.scene);
    setText(
      this.takeButton,
      holding ? "Give it back" : hold === "asking" ? "Cancel" : "Take the tool",
    );
    this.view.camera.controls.enableZoom = !holding;
    const help = matchMedia("(pointer: coarse)").matches
      ? "Drag to move, two fingers to push, pull and turn."
      : "Drag to move, wheel to push and pull, Shift-drag to turn, Esc to give it back.";
    if (hold === "none" && message !== "") {
      const {scene} = this;
      const whileSo = (): boolean => this.mouse.hold === "none" && this.scene === scene;
      this.notice.say(message, {alarm: true, whileSo});
    }
    this.notice.rest(hold === "none" ? "" : message || (holding ? help : "Asking…"));
    this.notice.update(true);
    this.staleWho = true;
    if (holding) this.canvas.focus({preventScroll: true});
  }

  private takeOrRelease(): void {
    if (!this.mayTake) return;
    if (!this.fetched.has(this.scene)) {
      const whileSo = (): boolean => !this.fetched.has(this.scene);
      this.notice.say("There is no tool yet: no server has told of its scene.", {whileSo});
      return;
    }
    if (this.mouse.hold !== "none") {
      this.mouse.release();
      return;
    }
    const tool = this.toolPick.value;
    const holder = this.world.holderOf(this.scene, tool);
    // What does not move may be gone, or this page's own a moment ago: the server decides.
    if (holder?.isMoving(nowS()) && holder.id !== this.mouse.station) {
      this.sayWhoHolds(holder, tool);
      return;
    }
    this.chosenScene = this.scene; // and stays there when the tool is given back
    this.chosenStation = "";
    this.mouse.take(this.scene, tool);
  }

  private sayWhoHolds(holder: Station, tool: string): void {
    const {scene} = this;
    const whileSo = (): boolean =>
      this.scene === scene &&
      holder.isMoving(nowS()) &&
      this.world.holderOf(scene, tool) === holder;
    const who = `'${holder.id}' holds the ${tool}.`;
    if (!this.mayOperate) {
      this.notice.say(`${who} It is free once that station ends.`, {alarm: true, whileSo});
      return;
    }
    const run = (): void => {
      this.connection.publish(kTopics.operate, {op: "take_back", station: holder.id});
      this.notice.say("Asking the server to take it back…");
    };
    this.notice.say(who, {alarm: true, whileSo, action: {text: "Take it back", run}});
  }

  // --- controls ---

  private listen(theme: ThemeSwitch): void {
    const follow = element("follow", HTMLButtonElement);
    const spheres = element("spheres", HTMLButtonElement);
    const help = element("help-dialog", HTMLDialogElement);
    const panel = element("panel", HTMLElement);
    const panelToggle = element("panel-toggle", HTMLButtonElement);

    const actions = {
      follow: () => {
        const on = !this.view.camera.following;
        this.view.camera.follow(on);
        follow.setAttribute("aria-pressed", String(on));
        const state = this.station?.shown(nowS());
        if (on && state) this.view.camera.toolAt(state.graphic.p);
        this.askFrame();
      },
      reset: () => this.lookAtAll(),
      spheres: () => {
        const on = spheres.getAttribute("aria-pressed") !== "true";
        spheres.setAttribute("aria-pressed", String(on));
        element("level-pick", HTMLLabelElement).hidden = !on;
        this.showLevel();
      },
      numbers: () => {
        if (this.numbers.hidden) return;
        this.view.showsNumbers = !this.view.showsNumbers;
        this.numbers.setAttribute("aria-pressed", String(this.view.showsNumbers));
      },
      level: (by: number) => {
        this.level.value = String(Number(this.level.value) + by);
        this.showLevel();
      },
      panel: () => {
        panel.hidden = !panel.hidden;
        panelToggle.setAttribute("aria-expanded", String(!panel.hidden));
      },
      help: () => help.showModal(),
    };
    follow.addEventListener("click", actions.follow);
    spheres.addEventListener("click", actions.spheres);
    this.numbers.addEventListener("click", actions.numbers);
    this.wholeButton.addEventListener("click", () => this.makeWhole());
    element("reset", HTMLButtonElement).addEventListener("click", actions.reset);
    element("help", HTMLButtonElement).addEventListener("click", actions.help);
    panelToggle.addEventListener("click", actions.panel);
    this.takeButton.addEventListener("click", () => this.takeOrRelease());
    this.level.addEventListener("input", () => this.showLevel());
    this.scenePick.addEventListener("change", () => {
      this.chosenScene = this.scenePick.value;
      this.chosenStation = "";
      this.chooseScene();
      rememberInAddress("scene", this.chosenScene);
    });
    this.stationPick.addEventListener("change", () => {
      this.chosenStation = this.stationPick.value;
      rememberInAddress("station", this.chosenStation);
    });

    listenToPointer(this.canvas, this.mouse, this.view.camera.controls);
    // The tool's keys come first: while it is held, arrows move it and not the eye.
    this.canvas.addEventListener("keydown", (event) => {
      if (this.mouse.key(event)) event.preventDefault();
    });
    const turn = 0.12;
    const nudge = (azimuth: number, polar: number, zoom: number) => () => {
      this.view.camera.nudge(azimuth, polar, zoom);
      this.askFrame();
    };
    listenForKeys({
      f: actions.follow,
      r: actions.reset,
      s: actions.spheres,
      n: actions.numbers,
      w: () => this.makeWhole(),
      v: () => this.lesson.switchAudience(),
      "[": () => actions.level(-1),
      "]": () => actions.level(1),
      p: actions.panel,
      t: () => theme.toggle(),
      m: () => this.takeOrRelease(),
      "?": actions.help,
      Escape: () => this.mouse.release(),
      ArrowLeft: nudge(-turn, 0, 1),
      ArrowRight: nudge(turn, 0, 1),
      ArrowUp: nudge(0, -turn, 1),
      ArrowDown: nudge(0, turn, 1),
      "+": nudge(0, 0, 0.9),
      "-": nudge(0, 0, 1 / 0.9),
      ...this.replayControls.keys,
    });
    new ResizeObserver(() => this.view.resize()).observe(this.canvas);
    // A link with another token, followed in this tab, changes the address and loads nothing.
    addEventListener("hashchange", () => {
      if (!this.token.takeFromAddress()) return;
      this.connection.restart();
      void this.askHealth();
    });
    // A tool in the hand of a page that is gone would stay taken.
    addEventListener("pagehide", () => this.mouse.release());
  }

  private showLevel(): void {
    const on = element("spheres", HTMLButtonElement).getAttribute("aria-pressed") === "true";
    const level = Number(this.level.value);
    this.view.setSphereLevel(on ? level : undefined);
    const isLeaves = this.level.value === this.level.max;
    const text = isLeaves ? "leaves" : `level ${level + 1} of ${Number(this.level.max) + 1}`;
    setText(element("level-text", HTMLOutputElement), text);
    this.level.setAttribute("aria-valuetext", text);
  }
}

type ToolNow = (
  scene: string,
  tool: string,
) => {pose: Pose; graphic: Pose; touches: boolean; centroid: Vec3};
