import {nameOf} from "../model/names";
import {say, sayList} from "../messages/say";
import type {Station} from "../model/station";
import {consoleWords, faultWords} from "../model/words";
import type {SessionState} from "../protocol/messages";
import {element, make, press, refill} from "./elements";

export type OperateOp = "admit" | "take_back" | "mute" | "unmute";

/// Time limit for the station's state to change after a request [ms].
const kAnswerWithinMs = 4000;

/// A teacher's console: every station with its tool and state, and the teacher's decisions.  It
/// shows what the server reports; a request greys its row until then.
export class Console {
  private readonly section = element("console-section", HTMLElement);
  private readonly list = element("console", HTMLUListElement);
  private readonly none = element("console-none", HTMLParagraphElement);
  private readonly asked = new Map<string, {of: SessionState; untilMs: number}>(); // by station

  constructor(private readonly wish: (op: OperateOp, station: string) => boolean) {}

  setVisible(visible: boolean): void {
    this.section.hidden = !visible;
    document.body.classList.toggle("operates", visible);
  }

  update(stations: readonly Station[], nowMs: number): void {
    if (this.section.hidden) return;
    // Nothing is to be decided about stations that have left.
    const here = stations.filter(({isHere}) => isHere);
    this.none.hidden = here.length > 0;
    // Stations that wait to be admitted come first.
    const waits = ({session}: Station): number => (session!.phase === "held" ? 0 : 1);
    here.sort((a, b) => waits(a) - waits(b) || a.id.localeCompare(b.id));
    refill(this.list, ...here.map((station) => this.row(station, nowMs)));
  }

  private row(station: Station, nowMs: number): HTMLLIElement {
    const {id, statistics} = station;
    const session = station.session!;
    const {muted, phase} = session;
    const isHeld = phase === "held";
    const asked = this.asked.get(id);
    const isAnswered = asked?.of.phase !== phase || asked.of.muted !== muted;
    if (isAnswered || nowMs > asked.untilMs) this.asked.delete(id);
    const disabled = this.asked.has(id);
    const button = (
      text: "admit" | "refuse" | "mute" | "unmute" | "take_back",
      op: OperateOp,
      more: {className?: string; hidden?: boolean} = {},
    ): HTMLButtonElement =>
      press(`console.${text}`, () => this.ask(station, session, op), {
        ...{disabled, sayTitle: `console.${text}_title`, ...more},
      });
    const faults = station.isMoving(nowMs / 1000) ? faultWords(statistics?.faults ?? 0) : [];
    const name = make("b", nameOf(id));
    name.dataset.muted = muted ? say("console.muted") : "";
    const item = make(
      "li",
      {className: isHeld ? "held" : "", ariaBusy: String(disabled)},
      make("p", name, " ", make("span.words", consoleWords(session))),
      make("span.faults", {hidden: faults.length === 0}, sayList("list.clauses", faults)),
      make(
        "span.choices",
        {role: "group", ariaLabel: say("console.decide", {station: nameOf(id)})},
        button("admit", "admit", {className: "primary", hidden: !isHeld}),
        muted
          ? button("unmute", "unmute", {hidden: isHeld})
          : button("mute", "mute", {hidden: isHeld}),
        isHeld ? button("refuse", "take_back") : button("take_back", "take_back"),
      ),
    );
    item.dataset.key = id;
    return item;
  }

  private ask(station: Station, of: SessionState, op: OperateOp): void {
    const nowMs = performance.now();
    if (this.asked.has(station.id) || !this.wish(op, station.id)) return;
    this.asked.set(station.id, {of, untilMs: nowMs + kAnswerWithinMs});
    const had = [...this.list.children].find(
      (one) => (one as HTMLElement).dataset.key === station.id,
    );
    if (had) refill(had, ...this.row(station, nowMs).childNodes);
  }
}
