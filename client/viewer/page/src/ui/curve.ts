import {say} from "../messages/say";
import type {TrialSpread} from "../protocol/history_messages";
import {make, makeSvg} from "./elements";

export type CurvePoint = readonly [n: number, points: number];

/// Points over trials.
export interface CurveData {
  readonly label: string; // for who does not see it
  readonly spread: readonly TrialSpread[]; // of the class
  readonly pass: number | null;
  readonly own: readonly CurvePoint[];
  /// The mean of the last trials and its interval, over those trials.
  readonly grade?: {
    from: number;
    to: number;
    mean: number;
    low: number | null;
    high: number | null;
  };
  readonly others?: readonly {readonly key: number; readonly points: readonly CurvePoint[]}[];
}

const kHeight = 220; // CSS pixels
const kMargin = {left: 34, right: 12, top: 12, bottom: 26};
/// More lines than these are a carpet.
const kMostOthers = 60;

const path = (points: readonly CurvePoint[]): string =>
  points.map(([x, y], i) => `${i === 0 ? "M" : "L"}${x.toFixed(1)} ${y.toFixed(1)}`).join("");

/// A curve in the width that it has.
export class Curve {
  readonly body = make("div", {className: "curve"});
  private data: CurveData | undefined;

  constructor() {
    new ResizeObserver(() => this.draw()).observe(this.body);
  }

  show(data: CurveData): void {
    this.data = data;
    this.draw();
  }

  /// One of the others stands out.
  light(key: number | undefined): void {
    for (const line of this.body.querySelectorAll<SVGElement>(".other"))
      line.classList.toggle("lit", line.dataset["key"] === String(key));
  }

  private draw(): void {
    const {data} = this;
    const width = this.body.clientWidth;
    if (!data || width === 0) return;
    const svg = makeSvg("svg", {
      ...{role: "img", "aria-label": data.label},
      ...{width: String(width), height: String(kHeight), viewBox: `0 0 ${width} ${kHeight}`},
    });
    const all = [
      ...data.own.map(([n]) => n),
      ...data.spread.map(({n}) => n),
      ...(data.others ?? []).flatMap(({points}) => points.map(([n]) => n)),
    ];
    const last = all.reduce((most, n) => Math.max(most, n), 1);
    const inner = width - kMargin.left - kMargin.right;
    // A single trial stands in the middle.
    const x = (n: number): number =>
      kMargin.left + (last === 1 ? inner / 2 : (inner * (n - 1)) / (last - 1));
    const y = (points: number): number =>
      kMargin.top + (kHeight - kMargin.top - kMargin.bottom) * (1 - points / 100);
    const at = ([n, points]: CurvePoint): CurvePoint => [x(n), y(points)];
    const add = (
      tag: "path" | "line" | "circle" | "rect",
      of: Record<string, string>,
    ): SVGElement => svg.appendChild(makeSvg(tag, of));
    this.addAxes(svg, width, last, x, y);
    const {spread, pass, own, grade} = data;
    if (spread.length > 0) {
      const band = [
        ...spread.map(({n, high}) => at([n, high])),
        ...[...spread].reverse().map(({n, low}) => at([n, low])),
      ];
      add("path", {class: "band", d: `${path(band)}Z`});
    }
    const others = (data.others ?? []).slice(0, kMostOthers);
    for (const {key, points} of others)
      add("path", {class: "other", d: path(points.map(at))}).dataset["key"] = String(key);
    if (spread.length > 0)
      add("path", {class: "median", d: path(spread.map(({n, median}) => at([n, median])))});
    if (pass !== null) {
      const level = String(y(pass));
      add("line", {
        ...{class: "pass", x1: String(kMargin.left), x2: String(width - kMargin.right)},
        ...{y1: level, y2: level},
      });
    }
    if (grade) {
      const [x1, x2] = [x(grade.from) - 5, x(grade.to) + 5];
      if (grade.low !== null && grade.high !== null)
        add("rect", {
          ...{class: "interval", x: String(x1), y: String(y(grade.high)), rx: "3"},
          ...{width: String(x2 - x1), height: String(y(grade.low) - y(grade.high))},
        });
      const level = String(y(grade.mean));
      add("line", {class: "mean", x1: String(x1), x2: String(x2), y1: level, y2: level});
    }
    add("path", {class: "own", d: path(own.map(at))});
    for (const point of own) {
      const [cx, cy] = at(point);
      add("circle", {class: "dot", cx: cx.toFixed(1), cy: cy.toFixed(1), r: "4"});
    }
    this.body.replaceChildren(svg);
  }

  private addAxes(
    svg: SVGSVGElement,
    width: number,
    last: number,
    x: (n: number) => number,
    y: (points: number) => number,
  ): void {
    const word = (text: string, of: Record<string, string>): void => {
      svg.appendChild(makeSvg("text", of)).textContent = text;
    };
    for (const points of [0, 25, 50, 75, 100]) {
      const level = String(y(points));
      svg.append(
        makeSvg("line", {
          ...{class: "grid", x1: String(kMargin.left), x2: String(width - kMargin.right)},
          ...{y1: level, y2: level},
        }),
      );
      word(String(points), {
        ...{x: String(kMargin.left - 8), y: String(y(points) + 4), "text-anchor": "end"},
      });
    }
    const room = (width - kMargin.left - kMargin.right) / Math.max(1, last - 1);
    const step = Math.max(1, Math.ceil(26 / room));
    for (let n = 1; n <= last; n += step)
      word(String(n), {x: String(x(n)), y: String(kHeight - 6), "text-anchor": "middle"});
  }
}

/// What the curve's lines are, each by how it is drawn.
export function legend(...of: readonly (readonly [line: string, words: string])[]): HTMLElement {
  return make(
    "ul",
    {className: "legend"},
    ...of.map(([line, words]) =>
      make("li", {}, make("span", {className: `key ${line}`}), make("span", {textContent: words})),
    ),
  );
}

/// Criteria by what they cost, as bars.
export function lossBars(
  lost: readonly {readonly criterion: string; readonly points: number}[],
  of = "",
): HTMLElement {
  const worth = lost.filter(({points}) => points >= 0.5).slice(0, 5);
  const most = Math.max(...worth.map(({points}) => points), 1);
  const bars = worth.map(({criterion, points}) => {
    const bar = make("span", {className: "bar-of"}, make("span", {className: "fill"}));
    bar.firstElementChild!.setAttribute("style", `width: ${(100 * points) / most}%`);
    const figure = say("history.lost", {points: Math.round(points)});
    return make(
      "li",
      {},
      make("span", {className: "criterion", textContent: criterion}),
      make("span", {className: "cost", textContent: figure}),
      bar,
    );
  });
  if (bars.length === 0)
    return make("p", {className: "quiet", textContent: say("history.no_loss")});
  return make("ol", {className: "losses", ariaLabel: of}, ...bars);
}
