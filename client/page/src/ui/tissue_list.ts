import {say} from "../messages/say";
import type {SceneModel} from "../model/bundle";
import {removedByTissue, type Remains} from "../model/remains";
import {figure, partWords} from "../model/words";
import {element, make, refill} from "./elements";

/// The colours of what burs cut, as the scene names it, and how much of each burs have removed.
export class TissueList {
  private readonly list = element("tissues", HTMLUListElement);

  update(model: SceneModel | undefined, remains: Remains): void {
    const removed = model ? removedByTissue(model, remains) : new Map<string, number>();
    const isAny = [...removed.values()].some((volume) => volume > 0);
    const named = new Map(
      model?.objects.flatMap(({tissues, cutColours}) =>
        tissues.map((name, i) => [name, cutColours[i]!] as const),
      ),
    );
    const items = [...named].map(([name, colour]) => {
      const swatch = make("i.swatch");
      swatch.style.setProperty("--of", `#${colour.toString(16).padStart(6, "0")}`);
      const volume = figure(removed.get(name) ?? 0);
      const words = isAny ? say("tissues.volume", {volume}) : "";
      const gone = make("output", {ariaLive: "off"}, words);
      return make("li", swatch, make("span", partWords(name)), " ", gone);
    });
    const head = make("li", {hidden: !isAny}, say("tissues.removed"));
    refill(this.list, head, ...items);
    this.list.hidden = items.length < 2;
  }
}
