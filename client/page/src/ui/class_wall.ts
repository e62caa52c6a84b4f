import {say, sayNumber} from "../messages/say";
import {make, press, setOptions, setText} from "./elements";
import type {OperateOp} from "./console";

/// A person or station as the wall shows it.
export interface OnWall {
  readonly key: string; // person's number or station's name
  readonly person: number; // 0: a station of nobody in the class
  readonly name: string;
  readonly scene: string;
  readonly station: string; // empty: none
  readonly doing: string;
  readonly tone: "away" | "idle" | "works" | "held" | "muted";
  readonly forceN: number | undefined;
  readonly limitN: number; // Infinity: no limit
  readonly goal: string;
  readonly trial: string; // the person's newest; empty: none
  readonly trialFails: boolean;
}

export interface WallWishes {
  begin(scene: string, goal: {text: string; limitN: number}): void;
  end(): void;
  say(person: number, name: string, text: string): void;
  watch(scene: string, station: string): void;
  operate(op: OperateOp, station: string): void;
}

interface Card {
  readonly item: HTMLLIElement;
  readonly doing: HTMLElement;
  readonly seat: HTMLElement;
  readonly force: HTMLElement; // bar and figure
  readonly bar: HTMLElement;
  readonly limit: HTMLElement;
  readonly figure: HTMLElement;
  readonly goal: HTMLElement;
  readonly trial: HTMLElement;
  readonly watch: HTMLButtonElement;
  readonly admit: HTMLButtonElement;
  readonly mute: HTMLButtonElement;
  readonly back: HTMLButtonElement;
  readonly sayTo: HTMLButtonElement;
  now: OnWall;
}

/// Force at the full length of a bar without a limit [N], or else the multiple of the limit: an
/// excess is visible.
const kFullN = 1;
const kFullLimits = 1.5;

/// The wall: what everybody does now, and a teacher's commands.
export class ClassWall {
  readonly body = make("div.class-wall");
  private readonly scene = make("select", {id: "class-scene"});
  private readonly begin = make("button", {
    ...{type: "submit", className: "primary", say: "class.begin"},
    sayTitle: "class.begin_title",
  });
  private readonly end = make("button", {
    ...{type: "button", say: "class.end", sayTitle: "class.end_title"},
  });
  private readonly goal = make("input", {
    ...{type: "text", id: "class-goal", maxLength: 120, sayPlaceholder: "class.goal_hint"},
  });
  private readonly limit = make("input", {
    ...{type: "number", id: "class-limit", min: "0", step: "0.05", placeholder: "–"},
  });
  private readonly to = make("select", {id: "class-to"});
  private readonly line = make("input", {
    ...{type: "text", id: "class-line", maxLength: 120, sayPlaceholder: "class.line"},
    sayLabel: "class.line",
  });
  private readonly none = make("p.quiet", {say: "class.nobody"});
  private readonly list = make("ul.wall");
  private readonly cards = new Map<string, Card>();

  constructor(private readonly wish: WallWishes) {
    this.end.addEventListener("click", () => wish.end());
    const lineForm = make(
      "form.say",
      {
        onsubmit: (event) => {
          event.preventDefault();
          const text = this.line.value.trim();
          if (text === "") return this.line.focus();
          wish.say(Number(this.to.value), this.to.selectedOptions[0]?.text ?? "", text);
          this.line.value = "";
        },
      },
      make("label", {htmlFor: this.to.id}, () => `${say("class.to")} `, this.to),
      this.line,
      make("button", {type: "submit", say: "class.say"}),
    );
    const start = make(
      "form.start",
      {
        onsubmit: (event) => {
          event.preventDefault();
          const limitN = Math.max(0, Number.parseFloat(this.limit.value) || 0);
          wish.begin(this.scene.value, {text: this.goal.value.trim(), limitN});
        },
      },
      make("label", {htmlFor: this.scene.id}, () => `${say("class.scene")} `, this.scene),
      make("label.goal", () => say("class.goal"), this.goal),
      make(
        "label",
        () => `${say("class.at_most")} `,
        this.limit,
        () => ` ${say("class.newton")}`,
      ),
      this.begin,
      this.end,
    );
    this.body.append(make("div.class-bar", start, lineForm), this.none, this.list);
  }

  /// @param scenes  those with seats
  /// @param begun  the scene whose seats are assigned; empty: none
  show(all: readonly OnWall[], scenes: readonly string[], begun: string): void {
    const chosen = scenes.includes(this.scene.value) ? this.scene.value : (scenes[0] ?? "");
    const option = (name: string) => ({value: name, text: name});
    setOptions(this.scene, scenes.map(option), chosen, say("class.no_seats"));
    this.begin.disabled = scenes.length === 0;
    this.end.hidden = begun === "";
    const people = all.filter(({person}) => person > 0);
    const reach = people.map(({person, name}) => ({value: String(person), text: name}));
    const wanted = reach.some(({value}) => value === this.to.value) ? this.to.value : "0";
    setOptions(this.to, [{value: "0", text: say("class.all")}, ...reach], wanted, "");
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
    const force = sayNumber(forceN ?? 0, 2);
    const figure = Number.isFinite(limitN)
      ? say("class.of_limit", {force, limit: limitN})
      : say("class.newtons", {force});
    setText(
      card.figure,
      forceN === undefined ? "–" : isOver ? `${figure}: ${say("class.too_much")}` : figure,
    );
    setText(card.goal, now.goal);
    card.goal.hidden = now.goal === "" || tone === "away";
    setText(card.trial, now.trial);
    card.trial.hidden = now.trial === "";
    card.trial.classList.toggle("alarm", now.trialFails);
    card.watch.disabled = now.scene === "";
    card.admit.hidden = tone !== "held";
    card.mute.hidden = tone === "held" || station === "";
    card.back.hidden = card.force.hidden = station === "";
    setText(card.mute, say(tone === "muted" ? "class.unmute" : "class.mute"));
    card.sayTo.hidden = now.person === 0 || tone === "away";
  }

  private addCard(now: OnWall): Card {
    const operate = (op: OperateOp): void => this.wish.operate(op, card.now.station);
    const {name} = now;
    const [bar, limit] = [make("span.fill"), make("span.limit", {hidden: true})];
    const card: Card = {
      item: make("li"),
      force: make("div"),
      doing: make("span.doing"),
      seat: make("span.seat"),
      figure: make("output.figure", {ariaLive: "off", sayLabel: "class.force"}),
      goal: make("p.goal-words"),
      trial: make("p.trial"),
      ...{bar, limit, now},
      watch: press("class.watch", () => this.wish.watch(card.now.scene, card.now.station), {
        title: () => say("class.watch_title", {name}),
      }),
      admit: press("class.admit", () => operate("admit"), {className: "primary"}),
      mute: press("class.mute", () => operate(card.now.tone === "muted" ? "unmute" : "mute")),
      back: press("class.take_back", () => operate("take_back")),
      sayTo: press(
        "class.say_to",
        () => {
          this.to.value = String(card.now.person);
          this.line.focus();
        },
        {title: () => say("class.say_to_title", {name})},
      ),
    };
    card.force.append(make("div.wall-force", {ariaHidden: "true"}, bar, limit), card.figure);
    card.item.append(
      make("p.top", make("b"), card.seat),
      make("p", card.doing),
      card.force,
      card.trial,
      card.goal,
      make(
        "span.choices",
        {role: "group"},
        ...[card.watch, card.admit, card.mute, card.back, card.sayTo],
      ),
    );
    this.cards.set(now.key, card);
    return card;
  }
}
