import {say} from "../messages/say";
import type {SceneModel} from "../model/bundle";
import {burOf} from "../model/drilled";
import {guardedM} from "../model/guarded";
import {figure, partWords} from "../model/words";
import type {Guard} from "../protocol/exercise_messages";
import type {ToolState} from "../protocol/messages";
import {element, setText} from "./elements";

/// The figure is shown from this distance on.
const kMostM = 2e-3;

/// How far a bur is from the nearest tissue that is to be spared, and a frame round the picture
/// where it comes too near.
export class GuardSign {
  private readonly box = element("guard-box", HTMLDivElement);
  private readonly name = element("guard-name", HTMLElement);
  private readonly distance = element("guard", HTMLOutputElement);

  /// @return a warning for a screen reader; empty: none
  show(
    state: ToolState | undefined,
    model: SceneModel | undefined,
    guards: readonly Guard[],
  ): string {
    const bur = burOf(model, state?.tool ?? model?.tools[0]?.name ?? "");
    const {box} = this;
    box.hidden = !bur || guards.length === 0;
    let nearest = {tissue: guards[0]?.tissue ?? "", awayM: Infinity, isNear: false};
    if (bur && model && state) {
      for (const {tissue, within_mm} of guards) {
        const awayM = guardedM(model, bur, state.graphic, tissue, kMostM);
        if (awayM < nearest.awayM) nearest = {tissue, awayM, isNear: 1000 * awayM < within_mm};
      }
    }
    const {tissue, awayM, isNear} = nearest;
    const distance = figure(1000 * awayM, 1);
    box.classList.toggle("over", isNear);
    document.body.classList.toggle("near-guarded", isNear);
    setText(this.name, () => say("figure.guard", {tissue: partWords(tissue)}));
    setText(this.distance, awayM < Infinity ? distance : say("figure.guard_far"));
    if (!isNear) return "";
    return awayM > 0
      ? say("guard.near", {tissue: partWords(tissue), distance})
      : say("guard.opened", {tissue: partWords(tissue)});
  }
}
