import {say} from "../messages/say";
import {element, onPress, setTextOf} from "../ui/elements";
import {followLanguage} from "../ui/spoken";
import type {Picture} from "./picture";

const kTurn = 0.12; // per key press [rad]

/// Buttons and keys that change the view of the scene.
export class ViewControls {
  private readonly followButton = onPress("follow", () => this.follow());
  private readonly spheres = onPress("spheres", () => this.switchSpheres());
  private readonly level = element("level", HTMLInputElement);
  private readonly numbers = onPress("numbers", () => this.switchNumbers());

  constructor(private readonly picture: Picture) {
    this.level.addEventListener("input", () => this.showLevel());
    followLanguage(() => this.showLevel());
    onPress("reset", () => picture.lookAtAll());
  }

  /// Keys, for listenForKeys.
  readonly keys: Readonly<Record<string, () => void>> = {
    f: () => this.follow(),
    r: () => this.picture.lookAtAll(),
    s: () => this.switchSpheres(),
    n: () => this.switchNumbers(),
    "[": () => this.stepLevel(-1),
    "]": () => this.stepLevel(1),
    ArrowLeft: () => this.nudge(-kTurn, 0, 1),
    ArrowRight: () => this.nudge(kTurn, 0, 1),
    ArrowUp: () => this.nudge(0, -kTurn, 1),
    ArrowDown: () => this.nudge(0, kTurn, 1),
    "+": () => this.nudge(0, 0, 0.9),
    "-": () => this.nudge(0, 0, 1 / 0.9),
  };

  /// Another scene is shown.
  showScene(): void {
    const {view} = this.picture;
    this.numbers.hidden = !view.labels.any;
    const atFinest = this.level.value === this.level.max;
    this.level.max = String(Math.max(0, view.sphereLevels - 1));
    if (atFinest) this.level.value = this.level.max;
    this.showLevel();
  }

  private follow(): void {
    this.followButton.setAttribute("aria-pressed", String(this.picture.followOrNot()));
  }

  private switchSpheres(): void {
    this.spheres.setAttribute("aria-pressed", String(!this.showsSpheres));
    element("level-pick", HTMLLabelElement).hidden = !this.showsSpheres;
    this.showLevel();
  }
  private get showsSpheres(): boolean {
    return this.spheres.getAttribute("aria-pressed") === "true";
  }

  private switchNumbers(): void {
    if (this.numbers.hidden) return;
    const {labels} = this.picture.view;
    labels.shown = !labels.shown;
    this.numbers.setAttribute("aria-pressed", String(labels.shown));
    this.picture.askFrame();
  }

  private stepLevel(by: number): void {
    this.level.value = String(Number(this.level.value) + by);
    this.showLevel();
  }

  private showLevel(): void {
    const level = Number(this.level.value);
    this.picture.view.setSphereLevel(this.showsSpheres ? level : undefined);
    const isLeaves = this.level.value === this.level.max;
    const text = isLeaves
      ? say("tools.leaves")
      : say("tools.level_of", {level: level + 1, levels: Number(this.level.max) + 1});
    setTextOf("level-text", text);
    this.level.setAttribute("aria-valuetext", text);
  }

  private nudge(azimuth: number, polar: number, zoom: number): void {
    this.picture.view.camera.nudge(azimuth, polar, zoom);
    this.picture.askFrame();
  }
}
