import {type Key, say, sayNumber} from "../messages/say";
import type {Station} from "../model/station";
import type {Person} from "../protocol/class_messages";
import type {SceneGoal} from "../protocol/messages";
import {make, press, refill, setOptions} from "./elements";
import type {OperateOp} from "./console";

/// A person or station as the wall shows it.
export interface OnWall {
  readonly person: Person; // 0: a station of nobody in the class
  readonly station: Station | undefined;
  readonly scene: string;
  readonly goal: SceneGoal | undefined;
  readonly doing: string;
  readonly tone: "away" | "idle" | "works" | "held" | "muted";
  readonly trial: string; // the person's newest; empty: none
  readonly forceN: number | undefined;
}

export interface WallWishes {
  begin(scene: string, goal: {text: string; limitN: number}): void;
  end(): void;
  say(person: number, name: string, text: string): void;
  watch(scene: string, station: string): void;
  operate(op: OperateOp, station: string): void;
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
    const people = all.map(({person}) => person).filter(({person}) => person > 0);
    const reach = people.map(({person, name}) => ({value: String(person), text: name}));
    const wanted = reach.some(({value}) => value === this.to.value) ? this.to.value : "0";
    setOptions(this.to, [{value: "0", text: say("class.all")}, ...reach], wanted, "");
    this.none.hidden = all.length > 0;
    refill(this.list, ...all.map((one) => this.card(one)));
  }

  private card(one: OnWall): HTMLLIElement {
    const {scene, tone, forceN, goal, trial, person: of} = one;
    const {name, person} = of;
    const station = one.station?.id ?? "";
    const limitN = goal && goal.limitN > 0 ? goal.limitN : Infinity;
    const isOver = forceN !== undefined && forceN > limitN;
    const hasLimit = Number.isFinite(limitN);
    const [bar, limit] = [make("span.fill"), make("span.limit", {hidden: !hasLimit})];
    bar.style.width = `${100 * Math.min(1, (forceN ?? 0) / (hasLimit ? kFullLimits * limitN : kFullN))}%`;
    limit.style.left = `${100 / kFullLimits}%`;
    const force = sayNumber(forceN ?? 0, 2);
    const figure = hasLimit
      ? say("class.of_limit", {force, limit: limitN})
      : say("class.newtons", {force});
    const words = isOver ? `${figure}: ${say("class.too_much")}` : figure;
    const operate = (text: Key, op: OperateOp, more: object): HTMLButtonElement =>
      press(text, () => this.wish.operate(op, station), more);
    const sayTo = (): void => {
      this.to.value = String(person);
      this.line.focus();
    };
    const isOut = {hidden: station === ""};
    const mute = {hidden: isOut.hidden || tone === "held"};
    const item = make(
      "li",
      {className: isOver ? `${tone} over` : tone},
      make("p.top", make("b", name), make("span.seat", scene)),
      make("p", make("span.doing", one.doing)),
      make(
        "div",
        isOut,
        make("div.wall-force", {ariaHidden: "true"}, bar, limit),
        make(
          "output.figure",
          {ariaLive: "off", ariaLabel: say("class.force")},
          forceN === undefined ? "–" : words,
        ),
      ),
      make("p.trial", {hidden: trial === ""}, trial),
      make("p.goal-words", {hidden: !goal?.text || tone === "away"}, goal?.text ?? ""),
      make(
        "span.choices",
        {role: "group"},
        press("class.watch", () => this.wish.watch(scene, station), {
          ...{disabled: scene === "", title: say("class.watch_title", {name})},
        }),
        operate("class.admit", "admit", {className: "primary", hidden: tone !== "held"}),
        tone === "muted"
          ? operate("class.unmute", "unmute", mute)
          : operate("class.mute", "mute", mute),
        operate("class.take_back", "take_back", isOut),
        press("class.say_to", sayTo, {
          ...{hidden: person === 0 || tone === "away", title: say("class.say_to_title", {name})},
        }),
      ),
    );
    item.dataset.key = person === 0 ? station : String(person);
    const isLost = of.trial?.phase === "unscored" || of.trial?.phase === "unentered";
    item.querySelector(".trial")!.classList.toggle("alarm", isLost);
    return item;
  }
}
