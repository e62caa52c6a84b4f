import {say} from "../messages/say";
import type {SceneModel} from "../model/bundle";
import {removedByTissue, type Remains} from "../model/remains";
import {figure, partWords} from "../model/words";
import {element, make, setText} from "./elements";

/// The colours of what burs cut, as the scene names it, and how much of each burs have removed.
export class TissueList {
  private readonly list = element("tissues", HTMLUListElement);
  private readonly removed = new Map<string, HTMLElement>(); // by tissue
  private readonly head = make("li", {say: "tissues.removed"});

  show(model: SceneModel | undefined): void {
    const named = new Map(
      model?.objects.flatMap(({tissues, cutColours}) =>
        tissues.map((name, i) => [name, cutColours[i]!] as const),
      ),
    );
    this.removed.clear();
    const items = [...named].map(([name, colour]) => {
      const swatch = make("i.swatch");
      swatch.style.setProperty("--of", `#${colour.toString(16).padStart(6, "0")}`);
      const removed = make("output");
      removed.ariaLive = "off";
      this.removed.set(name, removed);
      return make(
        "li",
        swatch,
        make("span", () => partWords(name)),
        " ",
        removed,
      );
    });
    this.list.replaceChildren(this.head, ...items);
    this.list.hidden = items.length < 2;
  }

  update(model: SceneModel | undefined, remains: Remains): void {
    const removed = model ? removedByTissue(model, remains) : new Map<string, number>();
    const isAny = [...removed.values()].some((volume) => volume > 0);
    this.head.hidden = !isAny;
    for (const [name, output] of this.removed) {
      const volume = figure(removed.get(name) ?? 0);
      setText(output, isAny ? say("tissues.volume", {volume}) : "");
    }
  }
}
