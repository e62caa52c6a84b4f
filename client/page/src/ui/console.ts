import {nameOf} from "../model/names";
import {say, sayList} from "../messages/say";
import type {Station} from "../model/station";
import {consoleWords, faultWords} from "../model/words";
import type {SessionState} from "../protocol/messages";
import {element, make, press, setText, type Told} from "./elements";
import {setWords} from "./spoken";

export type OperateOp = "admit" | "take_back" | "mute" | "unmute";

/// Time limit for the station's state to change after a request [ms].
const kAnswerWithinMs = 4000;

interface Row {
  readonly item: HTMLLIElement;
  readonly name: HTMLElement;
  readonly words: HTMLElement;
  readonly faults: HTMLElement;
  readonly admit: HTMLButtonElement;
  readonly mute: HTMLButtonElement;
  readonly back: HTMLButtonElement;
  session: SessionState | undefined; // last received from the server
  asked: {readonly of: SessionState | undefined; readonly untilMs: number} | undefined;
}

const answers = (before: SessionState | undefined, now: SessionState): boolean =>
  before?.phase !== now.phase || before.muted !== now.muted;

/// A teacher's console: every station with its tool and state, and the teacher's decisions.  It
/// shows what the server reports; a request greys its row until then.
export class Console {
  private readonly section = element("console-section", HTMLElement);
  private readonly list = element("console", HTMLUListElement);
  private readonly none = element("console-none", HTMLParagraphElement);
  private readonly rows = new Map<string, Row>();

  constructor(private readonly wish: (op: OperateOp, station: string) => boolean) {}

  setVisible(visible: boolean): void {
    this.section.hidden = !visible;
    document.body.classList.toggle("operates", visible);
  }

  /// @param stations  sorted by importance
  update(stations: readonly Station[], nowMs: number): void {
    if (this.section.hidden) return;
    // Nothing is to be decided about stations that have left.
    const here = stations.filter(
      ({session}) =>
        session !== undefined && session.phase !== "ended" && session.phase !== "refused",
    );
    this.none.hidden = here.length > 0;
    const ids = new Set(here.map(({id}) => id));
    for (const [id, {item}] of this.rows) {
      if (ids.has(id)) continue;
      item.remove();
      this.rows.delete(id);
    }
    // Stations that wait to be admitted come first.
    const waits = ({session}: Station): number => (session!.phase === "held" ? 0 : 1);
    [...here]
      .sort((a, b) => waits(a) - waits(b) || a.id.localeCompare(b.id))
      .forEach((station, place) => {
        const row = this.rows.get(station.id) ?? this.addRow(station.id);
        this.show(row, station, nowMs);
        if (this.list.children[place] !== row.item)
          this.list.insertBefore(row.item, this.list.children[place] ?? null);
      });
  }

  private show(row: Row, station: Station, nowMs: number): void {
    const session = station.session!;
    const {muted} = session;
    const isHeld = session.phase === "held";
    row.session = session;
    const {asked} = row;
    if (asked && (answers(asked.of, session) || nowMs > asked.untilMs)) row.asked = undefined;
    setText(row.name, nameOf(station.id));
    setText(row.words, consoleWords(session));
    const faults = station.isMoving(nowMs / 1000) ? (station.statistics?.faults ?? 0) : 0;
    const told = sayList("list.clauses", faultWords(faults));
    setText(row.faults, told);
    row.faults.hidden = told === "";
    row.item.classList.toggle("held", isHeld);
    row.name.dataset.muted = muted ? say("console.muted") : "";
    row.admit.hidden = !isHeld;
    row.mute.hidden = isHeld;
    setText(row.mute, say(muted ? "console.unmute" : "console.mute"));
    row.mute.title = say(muted ? "console.unmute_title" : "console.mute_title");
    setText(row.back, say(isHeld ? "console.refuse" : "console.take_back"));
    row.back.title = say(isHeld ? "console.refuse_title" : "console.take_back_title");
    for (const button of [row.admit, row.mute, row.back]) button.disabled = row.asked !== undefined;
    row.item.setAttribute("aria-busy", String(row.asked !== undefined));
  }

  private addRow(id: string): Row {
    const words = make("span.words");
    const faults = make("span.faults");
    const button = (text: Told, op: () => OperateOp): HTMLButtonElement =>
      press(text, () => this.ask(id, op()));
    const admit = button("console.admit", () => "admit");
    const mute = button("console.mute", () => (row.session?.muted ? "unmute" : "mute"));
    const back = button("console.take_back", () => "take_back");
    admit.className = "primary";
    setWords(admit, "title", () => say("console.admit_title"));
    const choices = make("span.choices", {role: "group"}, admit, mute, back);
    setWords(choices, "ariaLabel", () => say("console.decide", {station: nameOf(id)}));
    const name = make("b");
    const who = make("p", name, " ", words);
    const item = make("li", who, faults, choices);
    const row: Row = {
      ...{item, name, words, faults, admit, mute, back},
      session: undefined,
      asked: undefined,
    };
    this.rows.set(id, row);
    this.list.append(item);
    return row;
  }

  private ask(id: string, op: OperateOp): void {
    const row = this.rows.get(id);
    if (!row || row.asked || !this.wish(op, id)) return;
    row.asked = {of: row.session, untilMs: performance.now() + kAnswerWithinMs};
    for (const button of [row.admit, row.mute, row.back]) button.disabled = true;
  }
}
