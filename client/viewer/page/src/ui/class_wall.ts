import {classWord} from "../model/class_words";
import {make, setOptions, setText} from "./elements";
import type {OperateOp} from "./console";

/// Somebody as the wall shows them.
export interface OnWall {
  readonly key: string; // a person's number, or a station's name
  readonly person: number; // 0: a station that is nobody's of the class
  readonly name: string;
  readonly scene: string;
  readonly station: string; // empty: none is there
  readonly doing: string;
  readonly tone: "away" | "idle" | "works" | "held" | "muted";
  readonly forceN: number | undefined;
  readonly limitN: number; // Infinity: none
  readonly goal: string;
}

export interface WallWishes {
  begin(scene: string): void;
  say(person: number, name: string, text: string): void;
  watch(scene: string, station: string): void;
  operate(op: OperateOp, station: string): void;
}

interface Card {
  readonly item: HTMLLIElement;
  readonly doing: HTMLElement;
  readonly seat: HTMLElement;
  readonly bar: HTMLElement;
  readonly limit: HTMLElement;
  readonly figure: HTMLElement;
  readonly goal: HTMLElement;
  readonly watch: HTMLButtonElement;
  readonly admit: HTMLButtonElement;
  readonly mute: HTMLButtonElement;
  readonly back: HTMLButtonElement;
  readonly sayTo: HTMLButtonElement;
  now: OnWall;
}

/// The bar is this long where there is no limit [N], and else so many limits: what is too much shows.
const kFullN = 1;
const kFullLimits = 1.5;

/// Who does what now, and what a teacher does about it.
export class ClassWall {
  readonly body = make("div", {className: "class-wall"});
  private readonly scene = make("select", {id: "class-scene"});
  private readonly begin = make("button", {
    ...{type: "button", className: "primary", textContent: classWord("begin")},
    title: classWord("beginTitle"),
  });
  private readonly end = make("button", {
    ...{type: "button", textContent: classWord("end"), title: classWord("endTitle")},
  });
  private readonly to = make("select", {id: "class-to"});
  private readonly line = make("input", {
    ...{type: "text", id: "class-line", maxLength: 120, placeholder: classWord("line")},
    ariaLabel: classWord("line"),
  });
  private readonly none = make("p", {className: "quiet", textContent: classWord("nobody")});
  private readonly list = make("ul", {className: "wall"});
  private readonly cards = new Map<string, Card>();

  constructor(private readonly wish: WallWishes) {
    this.begin.addEventListener("click", () => wish.begin(this.scene.value));
    this.end.addEventListener("click", () => wish.begin(""));
    const say = make(
      "form",
      {
        className: "say",
        onsubmit: (event) => {
          event.preventDefault();
          const text = this.line.value.trim();
          if (text === "") return this.line.focus();
          wish.say(Number(this.to.value), this.to.selectedOptions[0]?.text ?? "", text);
          this.line.value = "";
        },
      },
      make("label", {htmlFor: this.to.id}, `${classWord("to")} `, this.to),
      this.line,
      make("button", {type: "submit", textContent: classWord("say")}),
    );
    const start = make(
      "div",
      {className: "start"},
      make("label", {htmlFor: this.scene.id}, `${classWord("scene")} `, this.scene),
      this.begin,
      this.end,
    );
    this.body.append(make("div", {className: "class-bar"}, start, say), this.none, this.list);
  }

  /// @param scenes  that have seats
  /// @param begun  the one whose seats are given; empty: none
  show(all: readonly OnWall[], scenes: readonly string[], begun: string): void {
    const chosen = scenes.includes(this.scene.value) ? this.scene.value : (scenes[0] ?? "");
    const option = (name: string) => ({value: name, text: name});
    setOptions(this.scene, scenes.map(option), chosen, classWord("noSeats"));
    this.begin.disabled = scenes.length === 0;
    this.end.hidden = begun === "";
    const people = all.filter(({person}) => person > 0);
    const reach = people.map(({person, name}) => ({value: String(person), text: name}));
    const wanted = reach.some(({value}) => value === this.to.value) ? this.to.value : "0";
    setOptions(this.to, [{value: "0", text: classWord("all")}, ...reach], wanted, "");
    this.none.hidden = all.length > 0;
    const keys = new Set(all.map(({key}) => key));
    for (const [key, {item}] of this.cards) {
      if (keys.has(key)) continue;
      item.remove();
      this.cards.delete(key);
    }
    all.forEach((one, place) => {
      const card = this.cards.get(one.key) ?? this.addCard(one);
      this.showCard(card, one);
      if (this.list.children[place] !== card.item)
        this.list.insertBefore(card.item, this.list.children[place] ?? null);
    });
  }

  private showCard(card: Card, now: OnWall): void {
    card.now = now;
    const {forceN, limitN, tone, station} = now;
    card.item.className = tone;
    const isOver = forceN !== undefined && forceN > limitN;
    card.item.classList.toggle("over", isOver);
    setText(card.item.querySelector("b")!, now.name);
    setText(card.seat, now.scene);
    setText(card.doing, now.doing);
    const fullN = Number.isFinite(limitN) ? kFullLimits * limitN : kFullN;
    card.bar.style.width = `${100 * Math.min(1, (forceN ?? 0) / fullN)}%`;
    card.limit.hidden = !Number.isFinite(limitN);
    card.limit.style.left = `${100 / kFullLimits}%`;
    const force = (forceN ?? 0).toFixed(2);
    const figure = Number.isFinite(limitN)
      ? classWord("ofLimit", {force, limit: limitN})
      : classWord("newtons", {force});
    setText(
      card.figure,
      forceN === undefined ? "–" : isOver ? `${figure}: ${classWord("tooMuch")}` : figure,
    );
    setText(card.goal, now.goal);
    card.goal.hidden = now.goal === "";
    card.watch.disabled = now.scene === "";
    card.admit.hidden = tone !== "held";
    card.mute.hidden = tone === "held";
    setText(card.mute, classWord(tone === "muted" ? "unmute" : "mute"));
    card.mute.disabled = card.back.disabled = station === "";
    card.sayTo.hidden = now.person === 0;
  }

  private addCard(now: OnWall): Card {
    const button = (text: string, title: string, onclick: () => void): HTMLButtonElement =>
      make("button", {type: "button", textContent: text, title, onclick});
    const operate = (op: OperateOp): void => this.wish.operate(op, card.now.station);
    const {name} = now;
    const [bar, limit] = [
      make("span", {className: "fill"}),
      make("span", {className: "limit", hidden: true}),
    ];
    const card: Card = {
      item: make("li"),
      doing: make("span", {className: "doing"}),
      seat: make("span", {className: "seat"}),
      figure: make("output", {className: "figure", ariaLabel: classWord("force")}),
      goal: make("p", {className: "goal-words"}),
      ...{bar, limit, now},
      watch: button(classWord("watch"), classWord("watchTitle", {name}), () =>
        this.wish.watch(card.now.scene, card.now.station),
      ),
      admit: button(classWord("admit"), classWord("admit"), () => operate("admit")),
      mute: button(classWord("mute"), classWord("mute"), () =>
        operate(card.now.tone === "muted" ? "unmute" : "mute"),
      ),
      back: button(classWord("takeBack"), classWord("takeBack"), () => operate("take_back")),
      sayTo: button(classWord("sayTo"), classWord("sayToTitle", {name}), () => {
        this.to.value = String(card.now.person);
        this.line.focus();
      }),
    };
    card.figure.ariaLive = "off";
    card.admit.className = "primary";
    card.item.append(
      make("p", {className: "top"}, make("b"), card.seat),
      make("p", {}, card.doing),
      make("div", {className: "force-bar", ariaHidden: "true"}, bar, limit),
      card.figure,
      card.goal,
      make(
        "span",
        {className: "choices", role: "group"},
        ...[card.watch, card.admit, card.mute, card.back, card.sayTo],
      ),
    );
    this.cards.set(now.key, card);
    return card;
  }
}
