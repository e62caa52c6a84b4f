import {say} from "../messages/say";
import {kHereS} from "../model/replay";
import {clock, markWords} from "../model/words";
import type {ReplayMark} from "../protocol/messages";
import {element, make, setText} from "./elements";

/// More contacts than these are shown on the bar only: nobody reads them all.
const kMostContacts = 100;

/// A replay's marks, sorted by time: to jump to, and bookmarks to remove.
export class MarkList {
  private readonly section = element("marks-section", HTMLElement);
  private readonly list = element("marks", HTMLOListElement);
  private readonly none = element("marks-none", HTMLParagraphElement);
  private rows: {atS: number; item: HTMLLIElement}[] = [];
  private current: HTMLLIElement | undefined;

  constructor(
    private readonly chosen: (mark: ReplayMark) => void,
    private readonly dropped: (mark: ReplayMark) => void,
  ) {}

  setVisible(visible: boolean): void {
    this.section.hidden = !visible;
  }

  setMarks(marks: readonly ReplayMark[]): void {
    const contacts = marks.filter(({kind}) => kind === "contact").length;
    const tooMany = contacts > kMostContacts;
    const listed = tooMany ? marks.filter(({kind}) => kind !== "contact") : marks;
    this.rows = listed.map((mark) => ({atS: mark.atS, item: this.row(mark)}));
    this.current = undefined;
    this.list.replaceChildren(...this.rows.map(({item}) => item));
    this.none.hidden = listed.length > 0 && !tooMany;
    setText(this.none, tooMany ? say("mark.on_bar_alone", {count: contacts}) : say("mark.none"));
  }

  /// Highlights the mark passed last.
  show(atS: number): void {
    const current = this.rows.filter((row) => row.atS <= atS + kHereS).at(-1)?.item;
    if (current === this.current) return;
    this.current?.removeAttribute("aria-current");
    current?.setAttribute("aria-current", "true");
    this.current = current;
    if (!current) return;
    // Scrolls only within the list, not the page.
    const {list} = this;
    const top = current.offsetTop - list.offsetTop;
    const isAbove = top < list.scrollTop;
    const isBelow = top + current.offsetHeight > list.scrollTop + list.clientHeight;
    if (isAbove || isBelow) list.scrollTop = top - list.clientHeight / 2;
  }

  private row(mark: ReplayMark): HTMLLIElement {
    const said = markWords(mark);
    const time = make("span.time", clock(mark.atS));
    const words = make("span.words", {title: said}, said);
    const go = make("button.go", {type: "button"}, make("i"), time, " ", words);
    go.addEventListener("click", () => this.chosen(mark));
    const item = make("li", {className: mark.kind}, go);
    if (mark.kind === "bookmark") {
      const drop = make("button.drop", {type: "button"}, "×");
      drop.title = say("mark.drop_title");
      drop.ariaLabel = say("mark.drop", {name: said});
      drop.addEventListener("click", () => this.dropped(mark));
      item.append(drop);
    }
    return item;
  }
}
